/* A small table of signatures, made here from the model's own runs in double: CSJ, BLK and two effects in the rod
 * position and the current under a chirp of two seconds. */
#ifndef EMA_SIGNATURE_RIG_H
#define EMA_SIGNATURE_RIG_H

#include "ema/ema.h"
#include "ema_rig.h"

#define EMA_TABLE_RECORD_ROWS 2000U
#define EMA_TABLE_BIN_ROWS 40U
#define EMA_TABLE_BINS 50U
#define EMA_TABLE_ROWS 6U /* BLK and CSJ as nuisances, two effects, CSJ, BLK */
#define EMA_TABLE_CHANNELS 2U
#define EMA_TABLE_VECTOR (EMA_TABLE_BINS * EMA_TABLE_CHANNELS)

/* Noise of a row of the records that go with it. */
#define EMA_TABLE_NOISE_MM 0.002
#define EMA_TABLE_NOISE_A 0.03

typedef struct {
    ema_signatures_t table;
    ema_pattern_t pattern[2]; /* inertia_change, then spring_load */
    ema_real unit[EMA_TABLE_ROWS];
    int16_t value[EMA_TABLE_BINS * (1U + (EMA_TABLE_CHANNELS * (1U + EMA_TABLE_ROWS)))];
    double row[EMA_TABLE_ROWS][EMA_TABLE_VECTOR]; /* the same before it was rounded */
} ema_signature_rig_t;

/* Makes the table of `actuator`. */
void ema_signature_rig(ema_signature_rig_t* rig, const ema_actuator_t* actuator);

/* The chirp that it belongs to. */
ema_command_t ema_signature_command(const ema_actuator_t* actuator);

/* A sample of row `row` of a noisy run of `model`, which makes a step. */
ema_sample_t ema_signature_sample(ema_model_t* model, const ema_command_t* command, uint32_t row, ema_random_t* noise);

/* Means of the bins of a run's difference from another, weighted: [bin][channel]. */
void ema_signature_vector(const ema_actuator_t* moved, const ema_actuator_t* still, double* vector);

#endif
