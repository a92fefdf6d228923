/* The power series of a span, its values and its responses, for every plant that the check of the time constants lets through: finite.
 *
 * That check bounds products (rates times step), of which intervals of the factors know nothing; so the factors are gone through in boxes of one decade each, and in
 * each the others are bounded by what the check leaves them. The span may be any part of the integration step. */
#include "states.h"

#include "ema_series.h"

/* Rate times integration step, with what rounding may add. */
#define EMA_BOX_REACH 1.71f

static ema_plant_t plant;
static ema_circuit_t circuit;
static ema_series_t series;
static ema_real terms[EMA_SERIES_TERMS + 1U];

static ema_real ema_within(ema_real size)
{
    return Frama_C_float_interval(-size, size);
}

static ema_real ema_least(ema_real a, ema_real b)
{
    return (a < b) ? a : b;
}

/* One box: integration steps up to 4 `step_s`, torque constants and inverse inertias up to 10 times theirs. */
static void ema_one_box(ema_real step_s, ema_real torque_constant, ema_real inverse_inertia, bool algebraic)
{
    const ema_real reach_per_s = EMA_BOX_REACH / step_s;
    const ema_real product = algebraic ? reach_per_s : (reach_per_s * reach_per_s);
    const ema_real coupling = product / (torque_constant * inverse_inertia);
    plant.screw.inverse_inertia_per_kgm2 = Frama_C_float_interval(inverse_inertia, 10.0f * inverse_inertia);
    plant.screw.viscous_Nm_s_per_rad = Frama_C_float_interval(0.0f, ema_least(310.0f, reach_per_s / inverse_inertia));
    circuit.algebraic = algebraic;
    circuit.rate_current = algebraic ? 0.0f : Frama_C_float_interval(-reach_per_s, 0.0f);
    /* 100 V s/rad over 0.068 mOhm, over the time constant when there is one */
    circuit.rate_speed = Frama_C_float_interval(-ema_least(coupling, algebraic ? 1.5e6f : (1.5e6f * reach_per_s)), 0.0f);
    circuit.rate_voltage = Frama_C_float_interval(0.0f, algebraic ? 1.5e4f : (1.5e4f * reach_per_s));
    ema_span_t span;
    span.current_A = ema_within(1.0e6f);
    span.speed_rad_s = ema_within(1.0e6f);
    span.input = ema_within(1.0e5f);
    span.torque_Nm = ema_within(1.0e6f);
    span.input_rise = ema_within(2.0e5f);
    span.torque_rise_Nm = ema_within(2.0e6f);
    span.span_s = Frama_C_float_interval(0.0f, 4.0f * step_s);
    span.torque_gain_Nm_per_A = (Frama_C_interval(0, 1) != 0) ? 0.0f : Frama_C_float_interval(torque_constant, 10.0f * torque_constant);
    span.at_rest = Frama_C_interval(0, 1) != 0;
    span.current_held = Frama_C_interval(0, 1) != 0;
    ema_series_build(&series, &plant, &circuit, &span);
    ema_series_angle(&series, span.span_s, terms);
    const ema_real at = Frama_C_float_interval(0.0f, 1.0f);
    const ema_real current_A = ema_series_at(series.current_A, at);
    const ema_real speed_rad_s = ema_series_at(series.speed_rad_s, at);
    const ema_real turn_rad = ema_series_at(terms, at);
    //@ assert current: \is_finite(current_A);
    //@ assert speed: \is_finite(speed_rad_s);
    //@ assert turn: \is_finite(turn_rad);
}

void main(void)
{
    for (uint32_t s = 0; s < 10U; ++s) {
        static const ema_real steps[] = {1.5e-7f, 6.0e-7f, 2.4e-6f, 9.6e-6f, 3.84e-5f, 1.5e-4f, 6.0e-4f, 2.4e-3f, 5.0e-3f, 1.0e-2f};
        for (uint32_t k = 0; k < 9U; ++k) {
            static const ema_real constants[] = {4.0e-7f, 4.0e-6f, 4.0e-5f, 4.0e-4f, 4.0e-3f, 4.0e-2f, 0.4f, 4.0f, 40.0f};
            for (uint32_t j = 0; j < 12U; ++j) {
                static const ema_real inverse[] = {3.0e-2f, 0.3f, 3.0f, 30.0f, 300.0f, 3.0e3f, 3.0e4f, 3.0e5f, 3.0e6f, 3.0e7f, 3.0e8f, 3.0e9f};
                ema_one_box(steps[s], constants[k], inverse[j], false);
                ema_one_box(steps[s], constants[k], inverse[j], true);
            }
        }
    }
    Frama_C_show_each_end();
}
