/* Optional effects of the transmission behind the play (site TRANSMISSION). Equations and sources: ema/ema_effects.def;
 * signatures of the functions: ema_effect_sites.h. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"

/* Rod mass on a spring and damper behind the play.
 *
 * memory[0] is the stretch of the spring, play minus rod in mm, memory[1] the rod's speed in mm/s. With the play's
 * output moving evenly over the step the stretch d obeys d'' + 2 zeta W d' + W^2 d = 0, which is solved exactly.
 */
void ema_effect_transmission_compliance_adjust(const ema_effect_transmission_compliance_t* effect, ema_params_t* params)
{
    /* the total inertia already counts this mass as rigidly coupled */
    const ema_real lead_m_per_rad = (params->lead_mm * EMA_R(1.0e-3)) / (EMA_TURN_RAD * params->ratio);
    params->inertia_kgm2 -= effect->mass_kg * lead_m_per_rad * lead_m_per_rad;
}

ema_rod_t ema_effect_transmission_compliance(const ema_effect_transmission_compliance_t* effect,
                                             const ema_transmission_t* step, ema_real* memory)
{
    const ema_real natural_rad_s = EMA_TURN_RAD / effect->period_s;
    const ema_real decay_per_s = effect->damping_ratio * natural_rad_s;
    /* at critical damping the sine's factor 1/w has a limit that this floor keeps finite */
    const ema_real damped_rad_s =
        natural_rad_s * ema_sqrt(ema_max(EMA_R(1.0) - (effect->damping_ratio * effect->damping_ratio), EMA_R(1.0e-4)));
    const ema_real fade = ema_exp(-decay_per_s * step->step_s);
    const ema_real sine = ema_sin(damped_rad_s * step->step_s) / damped_rad_s;
    const ema_real cosine = ema_cos(damped_rad_s * step->step_s);

    const ema_real play_speed_mm_s = (step->play_end_mm - step->play_start_mm) / step->step_s;
    const ema_real stretch_mm = memory[0];
    const ema_real rate_mm_s = play_speed_mm_s - memory[1];
    const ema_real stretch_end_mm = fade * ((stretch_mm * (cosine + (decay_per_s * sine))) + (rate_mm_s * sine));
    const ema_real rate_end_mm_s =
        fade * ((rate_mm_s * (cosine - (decay_per_s * sine))) - (stretch_mm * natural_rad_s * natural_rad_s * sine));
    memory[0] = stretch_end_mm;
    memory[1] = play_speed_mm_s - rate_end_mm_s;

    const ema_real square_per_s2 = natural_rad_s * natural_rad_s;
    const ema_real torque_per_acceleration = effect->mass_kg * step->lead_mm_per_rad * EMA_R(1.0e-6);
    const ema_rod_t rod = {
        step->play_end_mm - stretch_end_mm,
        memory[1],
        -torque_per_acceleration * ((square_per_s2 * stretch_mm) + (EMA_R(2.0) * decay_per_s * rate_mm_s)),
        -torque_per_acceleration * ((square_per_s2 * stretch_end_mm) + (EMA_R(2.0) * decay_per_s * rate_end_mm_s)),
    };
    return rod;
}
