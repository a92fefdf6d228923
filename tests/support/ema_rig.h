/* What the tests of the model share: the nominal actuator, a prepared model, the chirp, a recorded run. */
#ifndef EMA_RIG_H
#define EMA_RIG_H

#include "ema/ema.h"
#include "ema_close.h"

/* A tolerance or a count that differs between the two builds. */
#if EMA_REAL64
#define EMA_BY_PRECISION(in_float32, in_float64) (in_float64)
#else
#define EMA_BY_PRECISION(in_float32, in_float64) (in_float32)
#endif

/* Resolution of the build's numbers, in double. */
#define EMA_EPS ((double)EMA_REAL_EPSILON)

/* Fails with the texts of both statuses. */
#define EMA_ASSERT_STATUS(expected, actual) ema_assert_status((expected), (actual), (unsigned)__LINE__)
void ema_assert_status(ema_status_t expected, ema_status_t actual, unsigned line);

/* The nominal actuator, without effects. */
ema_actuator_t ema_rig_actuator(void);

/* A model at rest at `start_mm`; fails the test when it cannot be made. */
ema_model_t ema_rig_model(const ema_actuator_t* actuator, ema_real start_mm);

/* One step that must succeed. */
ema_output_t ema_rig_step(ema_model_t* model, ema_real command_mm);

/* The same command for a number of steps; the row of the last. */
ema_output_t ema_rig_hold(ema_model_t* model, ema_real command_mm, uint32_t steps);

/* A chirp of 2 mm from 0.1 Hz: the reference chirp when it takes 10 s to 4 Hz. */
ema_command_t ema_rig_chirp(ema_real end_hz, ema_real duration_s, ema_real step_s);

/* Records `rows` rows of `actuator` under `command`, in `config`, from rest at zero. */
void ema_rig_record(ema_record_t* record, const ema_record_config_t* config, const ema_actuator_t* actuator,
                    const ema_command_t* command, uint32_t rows);

/* The result of a fed session that is run to its end in slices of `steps`. */
ema_result_t ema_rig_result(ema_session_t* session, uint32_t steps);

/* A record of reals with the command in it; `all` keeps every channel, else the rod position alone. */
ema_record_config_t ema_rig_real_record(void* buffer, size_t bytes, bool all);

/* Reads an actuator's value by its index; fails the test for a bad index. */
ema_real ema_rig_value(const ema_actuator_t* actuator, size_t id);

/* Number of the tests' own sweeps, uniform in [lower, upper). */
ema_real ema_rig_uniform(ema_real lower, ema_real upper);

/* Starts them again. */
void ema_rig_seed(uint64_t seed);

#endif
