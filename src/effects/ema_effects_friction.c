/* Optional effects of dry friction (sites FRICTION and PRESLIDING). Equations and sources: ema/ema_effects.def;
 * signatures of the functions: ema_effect_sites.h. */
#include "base/ema_compiler.h"
#include "base/ema_math.h"
#include "effects/ema_effect_sites.h"
#include "effects/ema_table.h"

/* Where the exponential is below the resolution of the level. */
#if EMA_REAL64
#define EMA_FADED EMA_R(40.0)
#else
#define EMA_FADED EMA_R(18.0)
#endif

/* rise exp(-(abs(speed) / fallen)^shape): all of it at rest, 1/e of it at the speed `fallen_rad_s` > 0; zero where it
 * is below the resolution of the level. */
static EMA_NOINLINE ema_real ema_stribeck(ema_real rise_Nm, ema_real speed_rad_s, ema_real fallen_rad_s, ema_real shape)
{
    const ema_real ratio = ema_abs(speed_rad_s) / fallen_rad_s;
    ema_real power = EMA_R(0.0);
    /* ratio^shape; the two usual shapes need no logarithm */
    if (shape == EMA_R(1.0)) {
        power = ratio;
    } else if (shape == EMA_R(2.0)) {
        power = ratio * ratio;
    } else if (ratio > EMA_R(1.0e-30)) {
        power = ema_exp(shape * ema_log(ratio));
    } else {
        /* at rest the rise is whole */
    }
    return rise_Nm * ((power < EMA_FADED) ? ema_exp_inside(-power) : EMA_R(0.0));
}

/* Break-away friction above the sliding level that falls with speed. */
ema_real ema_effect_stribeck_friction(const ema_effect_stribeck_friction_t* effect, const ema_site_t* site,
                                      ema_real level_Nm)
{
    return ema_stribeck(level_Nm * effect->rise, site->speed_rad_s, effect->speed_rad_s, effect->shape);
}

/* Break-away friction that falls with speed, of another size in each direction. */
ema_real ema_effect_directional_stribeck(const ema_effect_directional_stribeck_t* effect, const ema_site_t* site,
                                         ema_real level_Nm)
{
    const ema_real rise = effect->rise * (EMA_R(1.0) + (effect->asymmetry * site->direction));
    return ema_stribeck(level_Nm * rise, site->speed_rad_s, effect->speed_rad_s, effect->shape);
}

/* Break-away friction that grows with the torque that is transmitted, and falls with speed. */
ema_real ema_effect_load_dependent_stribeck(const ema_effect_load_dependent_stribeck_t* effect, const ema_site_t* site,
                                            ema_real level_Nm)
{
    const ema_real torque_Nm = site->plant->motor.torque_constant_Nm_per_A * site->current_A;
    (void)level_Nm;
    return ema_stribeck(effect->ratio * ema_abs(torque_Nm), site->speed_rad_s, effect->speed_rad_s, effect->shape);
}

/* Dry friction that grows with the torque that is transmitted. */
ema_real ema_effect_load_dependent_friction(const ema_effect_load_dependent_friction_t* effect, const ema_site_t* site,
                                            ema_real level_Nm)
{
    (void)level_Nm;
    return effect->ratio * ema_abs(site->plant->motor.torque_constant_Nm_per_A * site->current_A);
}

/* Dry friction that varies once per lead of the screw. */
ema_real ema_effect_pitch_ripple(const ema_effect_pitch_ripple_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real lead_mm = site->plant->gearbox.lead_mm;
    return level_Nm * effect->ratio * ema_sin(((site->position_mm / lead_mm) * EMA_TURN_RAD) + effect->phase_rad);
}

/* A spot of the raceway with more dry friction, passed in both directions. */
ema_real ema_effect_jam_spot(const ema_effect_jam_spot_t* effect, const ema_site_t* site, ema_real level_Nm)
{
    const ema_real away = (site->position_mm - effect->place_mm) / effect->width_mm;
    (void)level_Nm;
    return effect->amplitude_Nm * ema_exp(-(away * away));
}

/* Dry friction that was learned against one axis. */
ema_real ema_effect_learned_friction(const ema_effect_learned_friction_t* effect, const ema_site_t* site,
                                     ema_real level_Nm)
{
    (void)level_Nm;
    return ema_table_value(EMA_TABLE_OF(effect), site);
}

/* Contact that stretches like a spring before it slides, Dahl's form, exact for a turn in one direction. */
ema_real ema_effect_presliding(const ema_effect_presliding_t* effect, ema_real turn_rad, ema_real stretch,
                               ema_real lead_mm_per_rad)
{
    (void)lead_mm_per_rad;
    const ema_real side = (turn_rad < EMA_R(0.0)) ? EMA_R(-1.0) : EMA_R(1.0);
    if (stretch == side) {
        /* slides already */
        return side;
    }
    return side + ((stretch - side) * ema_exp(-ema_abs(turn_rad) / effect->stretch_rad));
}

/* Dry friction behind a play with elastic ends, exact for a turn in one direction.
 *
 * The share of friction that is carried says where the shaft stands in the play, so that it is the whole memory: inside
 * the gap it runs over a part of the friction that nothing tells from none.
 */
#define EMA_IN_GAP EMA_R(1.0e-5)

ema_real ema_effect_elastic_backlash(const ema_effect_elastic_backlash_t* effect, ema_real turn_rad, ema_real stretch,
                                     ema_real lead_mm_per_rad)
{
    const ema_real half_mm = EMA_R(0.5) * effect->gap_mm;
    const ema_real share_per_mm = (EMA_R(1.0) - EMA_IN_GAP) / effect->contact_mm;
    const ema_real carried = ema_abs(stretch);
    const ema_real from_middle_mm = (ema_min(carried, EMA_IN_GAP) * (half_mm / EMA_IN_GAP))
                                    + (ema_max(carried - EMA_IN_GAP, EMA_R(0.0)) / share_per_mm);
    const ema_real place_mm =
        ((stretch < EMA_R(0.0)) ? -from_middle_mm : from_middle_mm) + (turn_rad * lead_mm_per_rad);
    const ema_real away_mm = ema_abs(place_mm);
    const ema_real share =
        (ema_min(away_mm, half_mm) * (EMA_IN_GAP / half_mm)) + (ema_max(away_mm - half_mm, EMA_R(0.0)) * share_per_mm);
    const ema_real within = ema_min(share, EMA_R(1.0));
    return (place_mm < EMA_R(0.0)) ? -within : within;
}
