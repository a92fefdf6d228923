#include "ema_series.h"

#include "ema_math.h"

/* Bracketing steps of the root search; Illinois' rule gains a digit or more in each. */
#define EMA_ROOT_STEPS 14U

static const ema_real ema_share[EMA_SERIES_TERMS] = {
    EMA_R(1.0), EMA_R(0.5), EMA_R(0.3333333333333333), EMA_R(0.25), EMA_R(0.2), EMA_R(0.16666666666666666), EMA_R(0.14285714285714285), EMA_R(0.125),
    EMA_R(0.1111111111111111), EMA_R(0.1), EMA_R(0.09090909090909091), EMA_R(0.08333333333333333), EMA_R(0.07692307692307693), EMA_R(0.07142857142857142),
#if EMA_REAL64
    EMA_R(0.06666666666666667), EMA_R(0.0625), EMA_R(0.058823529411764705), EMA_R(0.05555555555555555), EMA_R(0.05263157894736842), EMA_R(0.05),
    EMA_R(0.047619047619047616), EMA_R(0.045454545454545456), EMA_R(0.043478260869565216), EMA_R(0.041666666666666664),
#endif
};

void ema_series_build(ema_series_t* series, const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_span_t* span)
{
    const bool follows = circuit->algebraic && !span->current_held;
    series->speed_rad_s[0] = span->speed_rad_s;
    series->angle_rad[0] = EMA_R(0.0);
    series->current_A[0] = follows ? ((circuit->rate_speed * span->speed_rad_s) + (circuit->rate_voltage * span->input)) : span->current_A;
    ema_real input = span->input;
    ema_real torque_Nm = span->torque_Nm;
    ema_real input_next = span->input_rise;
    ema_real torque_next_Nm = span->torque_rise_Nm;
    for (uint32_t k = 0; k < EMA_SERIES_TERMS; ++k) {
        const ema_real share_s = span->span_s * ema_share[k];
        const ema_real current_A = series->current_A[k];
        const ema_real speed_rad_s = series->speed_rad_s[k];
        ema_real acceleration_rad_s2 = EMA_R(0.0);
        if (!span->at_rest) {
            acceleration_rad_s2 = ((span->torque_gain_Nm_per_A * current_A) - (plant->screw.viscous_Nm_s_per_rad * speed_rad_s) + torque_Nm)
                                  * plant->screw.inverse_inertia_per_kgm2;
        }
        series->angle_rad[k + 1U] = share_s * speed_rad_s;
        series->speed_rad_s[k + 1U] = share_s * acceleration_rad_s2;
        if (span->current_held) {
            series->current_A[k + 1U] = EMA_R(0.0);
        } else if (circuit->algebraic) {
            series->current_A[k + 1U] = (circuit->rate_speed * series->speed_rad_s[k + 1U]) + (circuit->rate_voltage * input_next);
        } else {
            series->current_A[k + 1U] = share_s * ((circuit->rate_current * current_A) + (circuit->rate_speed * speed_rad_s) + (circuit->rate_voltage * input));
        }
        input = input_next;
        torque_Nm = torque_next_Nm;
        input_next = EMA_R(0.0);
        torque_next_Nm = EMA_R(0.0);
    }
}

ema_real ema_series_at(const ema_real* terms, ema_real at)
{
    ema_real sum = terms[EMA_SERIES_TERMS];
    for (uint32_t k = EMA_SERIES_TERMS; k > 0U; --k) {
        sum = (sum * at) + terms[k - 1U];
    }
    return sum;
}

ema_real ema_series_root(const ema_real* terms, ema_real lower)
{
    ema_real left = lower;
    ema_real right = EMA_R(1.0);
    ema_real value_left = ema_series_at(terms, left);
    ema_real value_right = ema_series_at(terms, right);
    ema_real root = right;
    int32_t kept = 0;
    for (uint32_t k = 0; (k < EMA_ROOT_STEPS) && ((right - left) > EMA_REAL_EPSILON) && (value_right != EMA_R(0.0)); ++k) {
        root = right - ((value_right * (right - left)) / (value_right - value_left));
        /* rounding can push the secant's point out of the bracket; NaN fails both comparisons */
        if (!((root > left) && (root < right))) {
            root = EMA_R(0.5) * (left + right);
        }
        const ema_real value = ema_series_at(terms, root);
        if (value == EMA_R(0.0)) {
            break;
        }
        if ((value > EMA_R(0.0)) == (value_right > EMA_R(0.0))) {
            right = root;
            value_right = value;
            value_left = (kept > 0) ? (EMA_R(0.5) * value_left) : value_left;
            kept = 1;
        } else {
            left = root;
            value_left = value;
            value_right = (kept < 0) ? (EMA_R(0.5) * value_right) : value_right;
            kept = -1;
        }
    }
    return root;
}

/* Response to one unit input over one integration step. */
static void ema_circuit_column(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_span_t* span, ema_real* current, ema_real* speed, ema_real* angle)
{
    ema_series_t series;
    ema_series_build(&series, plant, circuit, span);
    *current = ema_series_at(series.current_A, EMA_R(1.0));
    *speed = ema_series_at(series.speed_rad_s, EMA_R(1.0));
    *angle = ema_series_at(series.angle_rad, EMA_R(1.0));
}

void ema_circuit_prepare(ema_circuit_t* circuit, const ema_plant_t* plant, ema_real span_s)
{
    const ema_span_t none = {EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), span_s, plant->motor.torque_constant_Nm_per_A, false, false};
    ema_response_t* const current = &circuit->current;
    ema_response_t* const speed = &circuit->speed;
    ema_response_t* const angle = &circuit->angle;
    ema_span_t span = none;
    span.current_A = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_current, &speed->from_current, &angle->from_current);
    span = none;
    span.speed_rad_s = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_speed, &speed->from_speed, &angle->from_speed);
    span = none;
    span.input = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_voltage, &speed->from_voltage, &angle->from_voltage);
    span = none;
    span.torque_Nm = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_torque, &speed->from_torque, &angle->from_torque);
    span = none;
    span.input_rise = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_voltage_rise, &speed->from_voltage_rise, &angle->from_voltage_rise);
    span = none;
    span.torque_rise_Nm = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &current->from_torque_rise, &speed->from_torque_rise, &angle->from_torque_rise);
    ema_real unused;
    span = none;
    span.at_rest = true;
    span.current_A = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &circuit->stuck_from_current, &unused, &unused);
    span.current_A = EMA_R(0.0);
    span.input = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &circuit->stuck_from_voltage, &unused, &unused);
    span.input = EMA_R(0.0);
    span.input_rise = EMA_R(1.0);
    ema_circuit_column(plant, circuit, &span, &circuit->stuck_from_voltage_rise, &unused, &unused);
}
