/* Whether a search can work with its settings, before it is begun: ema_annealer_init refuses what means nothing, this
 * says what means something and will not reach the lowest cost. A firmware that does not call it links none of it.
 *
 * The rules stand in docs/FIRMWARE.md; how often they are right is counted in docs/ROBUSTNESS.md.
 */
#ifndef EMA_ANNEALER_CHECK_H
#define EMA_ANNEALER_CHECK_H

#include "ema/detail/ema_annealer.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What is wrong and what to do; a set of bits. */
/* EMA-D1 */
#define EMA_ANNEALER_WARNING_LIST(X)                                                                                   \
    X(EMA_WARNING_START, 1, "the start of the search lies outside its bounds: widen them")                             \
    X(EMA_WARNING_FEW, 2, "evaluation_budget is too small to search so many values: allow 30 model runs for each")     \
    X(EMA_WARNING_HOT, 4,                                                                                              \
      "the evaluations are used up before the search is cold: raise evaluation_budget, or lower cooling or "           \
      "initial_temperature")                                                                                           \
    X(EMA_WARNING_COLD, 8,                                                                                             \
      "initial_temperature lies so far below function_tolerance that nothing is searched: raise the one or lower the " \
      "other")                                                                                                         \
    X(EMA_WARNING_TOLERANCE, 16,                                                                                       \
      "function_tolerance is larger than what the sensor resolves, so the search ends before its lowest cost: lower "  \
      "it")                                                                                                            \
    X(EMA_WARNING_REANNEALED, 32,                                                                                      \
      "reanneal_interval is so short that the search never cools: raise it to 10 or more, 60 say")

enum {
#define EMA_WARNING_ENUM(name, bit, text) name = (bit), /* EMA-D1 */
    EMA_ANNEALER_WARNING_LIST(EMA_WARNING_ENUM)
#undef EMA_WARNING_ENUM
};

/* The warnings for `config`. `resolution` is the difference of two costs that just matters, in their unit: by what one
 * standard error of a parameter raises the cost; for a position alone, squared sensor noise times the record's period
 * (mm^2 s). Zero, or anything that is no positive finite number, is unknown: the function tolerance takes its place,
 * and what needs more than that is not judged. Does not look for what ema_annealer_init refuses, the start aside; NULL
 * has no warnings. Cost: three logarithms. */
uint32_t ema_annealer_check(const ema_annealer_config_t* config, ema_real resolution);

/* The text of one warning, a constant string; "unknown warning" for anything but one bit of the list. Cost: a handful
 * of comparisons. */
const char* ema_annealer_warning_text(uint32_t warning);

#ifdef __cplusplus
}
#endif

#endif
