/* What a call answers. Zero is success; every other value is an error and the call changed nothing unless it says so.
 *
 * Call status, run outcome (ema_outcome_t) and verdict (ema_verdict_t) are three types: was the call legal, why did the
 * search stop, what does it mean for the actuator.
 */
#ifndef EMA_STATUS_H
#define EMA_STATUS_H

#ifdef __cplusplus
extern "C" {
#endif

/* EMA-D1 */
#define EMA_STATUS_LIST(X)                                                                                             \
    X(EMA_OK, 0, "ok")                                                                                                 \
    X(EMA_ERR_NULL, 1, "a required pointer is null")                                                                   \
    X(EMA_ERR_RANGE, 2, "a value is outside its range")                                                                \
    X(EMA_ERR_NOT_FINITE, 3, "a value is NaN or infinite")                                                             \
    X(EMA_ERR_STIFF, 4,                                                                                                \
      "the step is too long for a time constant: shorten step_s, or set inductance_H or current_loop_s to 0")          \
    X(EMA_ERR_INERTIA, 5, "the mass on the spring is heavier than the total inertia allows")                           \
    X(EMA_ERR_FULL, 6, "the record buffer is full")                                                                    \
    X(EMA_ERR_SCALE, 7, "a sample is too large for the record's scale")                                                \
    X(EMA_ERR_ORDER, 8, "the call does not fit the session's phase")                                                   \
    X(EMA_ERR_SHORT, 9, "the record is too short to identify from")                                                    \
    X(EMA_ERR_BOUNDS, 10, "a lower bound is not below its upper bound")                                                \
    X(EMA_ERR_DIVERGED, 11, "the model's state left the finite numbers")                                               \
    X(EMA_ERR_ABSENT, 12, "the configuration asks for what this build leaves out")                                     \
    X(EMA_ERR_TABLE, 13, "the table of signatures belongs to another actuator or version: export it again")            \
    X(EMA_ERR_ALIGN, 14, "a buffer is not aligned for what it holds")

typedef enum {
#define EMA_STATUS_ENUM(name, value, text) name = (value), /* EMA-D1 */
    EMA_STATUS_LIST(EMA_STATUS_ENUM)
#undef EMA_STATUS_ENUM
} ema_status_t;

/* The text of a status, a constant string; "unknown status" for a value outside the list. Cost: a handful of
 * comparisons. */
const char* ema_status_text(ema_status_t status);

#ifdef __cplusplus
}
#endif

#endif
