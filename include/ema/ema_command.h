/* Position commands as pure functions of the step index: the same bits whenever and in whatever order they are asked.
 *
 * A chirp or multisine keeps its phase in fractions of 2^64 turns, so that it does not drift however long it runs.
 * Equations: docs/DESIGN.md, "Commands".
 */
#ifndef EMA_COMMAND_H
#define EMA_COMMAND_H

#include <stdint.h>

#include "ema/detail/ema_real.h"
#include "ema/detail/ema_status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    EMA_COMMAND_CHIRP = 0,     /* linear sine sweep */
    EMA_COMMAND_MULTISINE = 1, /* Schroeder phases */
    EMA_COMMAND_TRIANGLE = 2,
    EMA_COMMAND_TRAPEZOID = 3,
    EMA_COMMAND_STEP = 4,
    EMA_COMMAND_RECORD = 5 /* held samples of the caller */
} ema_command_kind_t;

/* What the user sets. Fields that a kind does not name are not read. */
typedef struct {
    ema_command_kind_t kind;
    ema_real amplitude_mm;      /* all but record */
    ema_real start_hz;          /* chirp: frequency at t = 0; multisine, triangle, trapezoid: base frequency */
    ema_real end_hz;            /* chirp: frequency at the end */
    ema_real duration_s;        /* chirp: length of the sweep, then the last value is held */
    ema_real share;             /* trapezoid: share of a quarter period that ramps, in (0, 1] */
    uint32_t count;             /* multisine: number of lines, 1 to 32; record: number of samples */
    ema_real time_s;            /* step: the instant */
    const ema_real* samples_mm; /* record: the samples, which must outlive the command */
} ema_command_config_t;

/* The prepared command: a plain value. */
typedef struct {
    ema_command_config_t config;
    uint64_t turns;      /* phase per step */
    uint64_t turns_rate; /* chirp: growth of the phase with the square of the step */
    uint32_t last_step;  /* chirp: the last step of the sweep; step: the first step at the new value */
    ema_real scale_mm;   /* multisine: amplitude of one line */
    ema_real shift_mm;   /* multisine: the value at t = 0 before it is taken off */
} ema_command_t;

/* Prepares a command for steps of `step_s`. Errors: EMA_ERR_NULL; EMA_ERR_NOT_FINITE for an amplitude that is no
 * number; EMA_ERR_RANGE for a frequency below 0 or above half the step rate, a duration or share or count outside its
 * range, one of these or a step that is no number, a step not above 0, or steps beyond 2^31. Samples are not looked at
 * here. Cost: at most 32 sines. */
ema_status_t ema_command_init(ema_command_t* command, const ema_command_config_t* config, ema_real step_s);

/* The command at step `step` in mm. Cost: one sine (multisine: `count`). */
ema_real ema_command_at(const ema_command_t* command, uint32_t step);

#ifdef __cplusplus
}
#endif

#endif
