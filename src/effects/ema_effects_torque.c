/* Optional effects that act as a torque on the motor shaft (sites TORQUE and LOAD). Equations and sources:
 * ema/ema_effects.def; signatures of the functions: ema_effect_sites.h. */
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

/* Pull of the magnets towards the slots, periodic in the motor angle. */
ema_real ema_effect_cogging_torque(const ema_effect_cogging_torque_t* effect, const ema_site_t* site)
{
    const ema_real wave = ema_sin((effect->periods * site->angle_rad) + effect->phase_rad);
    return effect->amplitude_Nm * wave;
}

/* Viscous damping that differs between the directions. */
ema_real ema_effect_viscous_asymmetry(const ema_effect_viscous_asymmetry_t* effect, const ema_site_t* site)
{
    return -site->plant->screw.viscous_Nm_s_per_rad * effect->asymmetry * ema_abs(site->speed_rad_s);
}

/* Drag that grows with the square root of speed. */
ema_real ema_effect_concave_viscous(const ema_effect_concave_viscous_t* effect, const ema_site_t* site)
{
    const ema_real drag_Nm = effect->drag_Nm_per_sqrt_rad_s * ema_sqrt(ema_abs(site->speed_rad_s));
    return (site->speed_rad_s > EMA_R(0.0)) ? -drag_Nm : drag_Nm;
}

/* Turbulent drag on the rotor. */
ema_real ema_effect_quadratic_viscous(const ema_effect_quadratic_viscous_t* effect, const ema_site_t* site)
{
    return -effect->drag_Nm_s2_per_rad2 * site->speed_rad_s * ema_abs(site->speed_rad_s);
}

/* Torque on the shaft that was learned against one axis. */
ema_real ema_effect_learned_torque(const ema_effect_learned_torque_t* effect, const ema_site_t* site)
{
    return ema_table_value(EMA_TABLE_OF(effect), site);
}

/* Load that grows with the rod's displacement. */
ema_real ema_effect_spring_load(const ema_effect_spring_load_t* effect, const ema_site_t* site)
{
    return effect->stiffness_Nm_per_mm * site->position_mm;
}
