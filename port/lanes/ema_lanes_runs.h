/* Many actuators under one command as flat arrays, for tools at a desk: what ema_desk_simulate is for one. */
#ifndef EMA_LANES_RUNS_H
#define EMA_LANES_RUNS_H

#include <stdint.h>

#include "ema/ema_real.h"

/* Lanes that run side by side, and the bits of a real number: 32 or 64. */
int32_t ema_lanes_count(void);
int32_t ema_lanes_bits(void);
int32_t ema_lanes_value_count(void);

/* 1 where the processor has AVX2, so that the libraries that are built for it can be loaded. */
int32_t ema_lanes_avx2(void);

/* Simulates `rows` recorded rows for each of `runs` actuators, all with the same options, command and start. `values`
 * are the actuators one after the other, `out` their results one after the other, each as ema_desk_simulate writes it
 * but in the library's own precision, since double would write twice as much that says the same: the very bits of one
 * run after the other. What is cheaper together runs together: actuators in which the same effects act and the same
 * blocks have the same form; they may stand in any order. `status` is an ema_status_t for each; where it is not EMA_OK
 * what `out` holds of the run means nothing. `unlocated_event_steps` counts steps with more events than are located.
 * `left` counts, over all runs together, [0] the spans of the motion of all lanes and [1] those of them that went
 * through the model's own functions. Memory: about 200 kB of stack. EMA_ERR_NULL, or EMA_OK. */
int32_t ema_lanes_simulate(const double* values, const int32_t* options, int32_t runs, const double* command_mm,
                           int32_t rows, double start_mm, ema_real* out, int32_t* unlocated_event_steps,
                           int32_t* status, int64_t* left);

#endif
