/* One model step of a run against a record, as a slice of a session makes it: any actuator that passes its check, any
 * state of the model, any numbers in the record. Assumed: the run stands on a row that the record has. */
#include "states.h"

#define EMA_PROOF_ROWS 100U

static ema_actuator_t actuator;
static ema_objective_t objective;
static ema_record_t record;
static ema_record_config_t config;
static ema_real buffer[(1U + EMA_CHANNEL_COUNT) * EMA_PROOF_ROWS];
static ema_real weight[EMA_CHANNEL_COUNT];

void main(void)
{
    ema_real start_mm;
    ema_any_actuator(&actuator);
    //@ slevel merge;
    EMA_ANY(start_mm);
    EMA_ANY(buffer);
    EMA_ANY(weight);
    config.buffer = buffer;
    config.buffer_bytes = sizeof buffer;
    config.format = EMA_RECORD_REAL;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config.keep[channel] = true;
    }
    (void)ema_record_init(&record, &config);
    record.count = EMA_PROOF_ROWS;
    if (ema_objective_start(&objective, &actuator, &record, weight, start_mm, EMA_COST_MAX) == EMA_OK) {
        //@ slevel merge;
        EMA_ANY(objective.model.state);
        EMA_ANY(objective.sum);
        EMA_ANY(objective.sum_low);
        EMA_ANY(objective.limit);
        objective.model.state.motion = Frama_C_interval(EMA_MOTION_BACKWARD, EMA_MOTION_ELASTIC);
        objective.model.state.play_side = Frama_C_interval(-1, 1);
        objective.cursor.every_steps = (uint32_t)Frama_C_interval(1, 1000);
        objective.cursor.step_in_row = (uint32_t)Frama_C_interval(0, 999);
        objective.cursor.row = (uint32_t)Frama_C_interval(0, EMA_PROOF_ROWS - 1U);
        (void)ema_objective_run(&objective, 1U);
    }
    Frama_C_show_each_end();
}
