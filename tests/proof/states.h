/* What the proofs share: anything at all in a structure, and an actuator that has passed its check. */
#ifndef EMA_PROOF_STATES_H
#define EMA_PROOF_STATES_H

#include "__fc_builtin.h"
#include "ema/ema.h"

/* The analysis has no body of its own for it. */
ema_real fabsf(ema_real x)
{
    return (x < 0.0f) ? -x : x;
}

#define EMA_ANY(what) Frama_C_make_unknown((char*)&(what), sizeof(what))

/* A path that the proof does not follow: the case that a condition in front of it excludes. */
static void ema_leave(void)
{
    for (;;) {
    }
}

/* Any bytes that ema_actuator_check lets through. Eva knows the ranges from the check itself; what it cannot take from
 * a comparison is said by assertions, which every_float.c shows (ema_is_finite is right for every float32) and, for
 * options, tests/unit/test_actuator.c (each is refused outside its range). */
static void ema_any_actuator(ema_actuator_t* actuator)
{
    EMA_ANY(*actuator);
    if (ema_actuator_check(actuator, NULL) != EMA_OK) {
        ema_leave();
    }
    //@ slevel merge;
    for (uint32_t k = 0; k < EMA_PARAM_COUNT; ++k) {
        //@ assert known_finite: \is_finite(((ema_real*)&actuator->params)[k]);
    }
    for (uint32_t k = 0; k < EMA_EFFECT_VALUE_COUNT; ++k) {
        //@ assert known_finite: \is_finite(((ema_real*)&actuator->effects)[k]);
    }
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)                                               \
    if ((actuator->options.field < (lower)) || (actuator->options.field > (upper))) {                                  \
        ema_leave();                                                                                                   \
    }
#include "ema/ema_params.def"
}

#endif
