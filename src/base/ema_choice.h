/* What the build of a firmware fixes, so that nothing of the rest is compiled: each of these is 1, or 0 where it is
 * left open.
 *
 * The structures are the same in every build, so a configuration fits all of them; one that asks for what is left out
 * is refused with EMA_ERR_ABSENT.
 */
#ifndef EMA_CHOICE_H
#define EMA_CHOICE_H

#include "ema/ema_actuator.h"

/* The control law is proportional and integral action on position. */
#ifndef EMA_ONLY_PI
#define EMA_ONLY_PI 0
#endif

/* The drive applies a share of the bus voltage, at once. */
#ifndef EMA_ONLY_VOLTAGE
#define EMA_ONLY_VOLTAGE 0
#endif

/* The feedback is neither late nor stepped. */
#ifndef EMA_ONLY_EXACT
#define EMA_ONLY_EXACT 0
#endif

/* Records hold int16. */
#ifndef EMA_ONLY_INT16
#define EMA_ONLY_INT16 0
#endif

/* The command is recorded with the samples. */
#ifndef EMA_ONLY_RECORDED
#define EMA_ONLY_RECORDED 0
#endif

/* Configurations are within their ranges: the desk has looked. */
#ifndef EMA_ONLY_CHECKED
#define EMA_ONLY_CHECKED 0
#endif

/* Whether this build has what an actuator asks for, its effects aside. */
static inline bool ema_choice_fits(const ema_params_t* params, const ema_options_t* options)
{
    bool fits = true;
#if EMA_ONLY_PI
    fits = (options->structure == 0) && !(params->kd_s_per_m > EMA_R(0.0));
#endif
#if EMA_ONLY_VOLTAGE
    fits = fits && (options->mode == 0) && !(params->output_delay_s > EMA_R(0.0));
#endif
#if EMA_ONLY_EXACT
    fits = fits && !(params->delay_s > EMA_R(0.0)) && !(params->resolution_mm > EMA_R(0.0));
#endif
    (void)params;
    (void)options;
    return fits;
}

#endif
