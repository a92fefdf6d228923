#include "plant/ema_series.h"

#include <stddef.h>

#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

_Static_assert((sizeof(ema_response_t) == (EMA_RESPONSES * sizeof(ema_real)))
                   && ((size_t)offsetof(ema_response_t, from_current) == (size_t)offsetof(ema_span_t, current_A))
                   && ((size_t)offsetof(ema_response_t, from_speed) == (size_t)offsetof(ema_span_t, speed_rad_s))
                   && ((size_t)offsetof(ema_response_t, from_voltage) == (size_t)offsetof(ema_span_t, input))
                   && ((size_t)offsetof(ema_response_t, from_torque) == (size_t)offsetof(ema_span_t, torque_Nm))
                   && ((size_t)offsetof(ema_response_t, from_voltage_rise) == (size_t)offsetof(ema_span_t, input_rise))
                   && ((size_t)offsetof(ema_response_t, from_torque_rise)
                       == (size_t)offsetof(ema_span_t, torque_rise_Nm)),
               "what moves a span stands in the order of the responses to it");

/* Bracketing steps of the root search; Illinois' rule gains a digit or more in each. */
#define EMA_ROOT_STEPS 14U

void ema_series_build(ema_series_t* series, const ema_plant_t* plant, const ema_circuit_t* circuit,
                      const ema_span_t* span)
{
    const bool follows = circuit->algebraic && !span->current_held;
    series->speed_rad_s[0] = span->speed_rad_s;
    series->current_A[0] =
        follows ? ((circuit->rate_speed * span->speed_rad_s) + (circuit->rate_voltage * span->input)) : span->current_A;
    ema_real input = span->input;
    ema_real torque_Nm = span->torque_Nm;
    ema_real input_next = span->input_rise + span->input_bend;
    ema_real input_last = -span->input_bend;
    ema_real torque_next_Nm = (span->torque_rise_Nm + span->torque_bend_Nm) - span->torque_twist_Nm;
    ema_real torque_third_Nm = (EMA_R(3.0) * span->torque_twist_Nm) - span->torque_bend_Nm;
    ema_real torque_last_Nm = EMA_R(-2.0) * span->torque_twist_Nm;
    for (uint32_t k = 0; k < EMA_SERIES_TERMS; ++k) {
        const ema_real share_s = span->span_s * ema_inverse[k + 1U];
        const ema_real current_A = series->current_A[k];
        const ema_real speed_rad_s = series->speed_rad_s[k];
        ema_real acceleration_rad_s2 = EMA_R(0.0);
        if (!span->at_rest) {
            acceleration_rad_s2 = ((span->torque_gain_Nm_per_A * current_A)
                                   - (plant->screw.viscous_Nm_s_per_rad * speed_rad_s) + torque_Nm)
                                  * plant->screw.inverse_inertia_per_kgm2;
        }
        series->speed_rad_s[k + 1U] = share_s * acceleration_rad_s2;
        if (span->current_held) {
            series->current_A[k + 1U] = EMA_R(0.0);
        } else if (circuit->algebraic) {
            series->current_A[k + 1U] =
                (circuit->rate_speed * series->speed_rad_s[k + 1U]) + (circuit->rate_voltage * input_next);
        } else {
            series->current_A[k + 1U] = share_s
                                        * ((circuit->rate_current * current_A) + (circuit->rate_speed * speed_rad_s)
                                           + (circuit->rate_voltage * input));
        }
        input = input_next;
        torque_Nm = torque_next_Nm;
        input_next = input_last;
        input_last = EMA_R(0.0);
        torque_next_Nm = torque_third_Nm;
        torque_third_Nm = torque_last_Nm;
        torque_last_Nm = EMA_R(0.0);
    }
}

void ema_series_angle(const ema_series_t* series, ema_real span_s, ema_real* terms)
{
    terms[0] = EMA_R(0.0);
    for (uint32_t k = 0; k < EMA_SERIES_TERMS; ++k) {
        terms[k + 1U] = (span_s * ema_inverse[k + 1U]) * series->speed_rad_s[k];
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
    for (uint32_t k = 0; k < EMA_ROOT_STEPS; ++k) {
        if (!((right - left) > EMA_REAL_EPSILON) || (value_right == EMA_R(0.0))) {
            break;
        }
        root = right - ((value_right * (right - left)) / (value_right - value_left));
        /* rounding can push the secant's point out of the bracket; NaN fails both comparisons */
        if (!((root > left) && (root < right))) {
            root = EMA_R(0.5) * (left + right);
        }
        const ema_real value = ema_series_at(terms, root);
        if ((value == EMA_R(0.0)) || ((value > EMA_R(0.0)) == (value_right > EMA_R(0.0)))) {
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

void ema_series_end(const ema_plant_t* plant, ema_step_scratch_t* work, ema_point_t* end)
{
    ema_series_t* const series = &work->series;
    work->spent += EMA_WORK_SERIES;
    ema_series_build(series, plant, work->circuit, &work->span);
    ema_series_angle(series, work->span.span_s, work->terms);
    end->current_A = ema_series_at(series->current_A, EMA_R(1.0));
    end->speed_rad_s = ema_series_at(series->speed_rad_s, EMA_R(1.0));
    end->angle_rad = ema_series_at(work->terms, EMA_R(1.0));
}

void ema_responses_prepare(ema_responses_t* responses, const ema_plant_t* plant, ema_step_scratch_t* work,
                           ema_real span_s)
{
    /* bend and twist are of use where a whole step is tried alone */
    const uint32_t columns = ema_tries_whole(plant) ? EMA_RESPONSES : EMA_RESPONSES_EVEN;
    ema_real* const driven = (ema_real*)(void*)&work->span;          /* EMA-D4 */
    ema_real* const current = (ema_real*)(void*)&responses->current; /* EMA-D4 */
    ema_real* const speed = (ema_real*)(void*)&responses->speed;     /* EMA-D4 */
    ema_real* const angle = (ema_real*)(void*)&responses->angle;     /* EMA-D4 */
    ema_real* const stuck = &responses->stuck_from_current;
    ema_point_t* const end = &work->segment.end;
    ema_clear(&work->span, sizeof work->span);
    work->span.span_s = span_s;
    work->span.torque_gain_Nm_per_A = plant->motor.torque_constant_Nm_per_A;
    for (uint32_t column = 0; column < columns; ++column) {
        driven[column] = EMA_R(1.0);
        /* at rest torques drive nothing */
        if (((column % 2U) == 0U) && (column < (EMA_RESPONSES - 1U))) {
            work->span.at_rest = true;
            ema_series_end(plant, work, end);
            stuck[column / 2U] = end->current_A;
            work->span.at_rest = false;
        }
        ema_series_end(plant, work, end);
        current[column] = end->current_A;
        speed[column] = end->speed_rad_s;
        angle[column] = end->angle_rad;
        driven[column] = EMA_R(0.0);
    }
}
