/* Which effects act in a run, asked by those who add up what they say. */
#ifndef EMA_EFFECT_RUNS_H
#define EMA_EFFECT_RUNS_H

#include "ema_effect_sites.h"

/* Whether an effect acts in this run; known beforehand of one that this build leaves out, so that nothing of it is
 * compiled. */
#define EMA_RUNS(words, name)                                                                                          \
    ((EMA_HAS_##name != 0)                                                                                             \
     && ((((words)[(uint32_t)EMA_EFFECT_ID_##name / 32U] >> ((uint32_t)EMA_EFFECT_ID_##name % 32U)) & 1U) != 0U))

/* A copy of these words, since each call would have them read again. */
#define EMA_PRESENT(plant) {(plant)->active.present[0], (plant)->active.present[EMA_EFFECT_WORDS - 1U]}
_Static_assert(EMA_EFFECT_WORDS <= 2U, "the copy has two words");

/* A learned table lies where the configuration does. */
#define EMA_LEARNED(plant, name) (&(plant)->learned->name)

/* Adds what an effect at a site makes of its values. */
#define EMA_ADD(sum, name, values)                                                                                     \
    if (EMA_RUNS(present, name)) {                                                                                     \
        (sum) += ema_effect_##name(values, site);                                                                      \
    }

#endif
