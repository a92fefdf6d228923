#include "ema/detail/ema_objective.h"

#include "base/ema_math.h"
#include "ident/ema_cursor_step.h"
#include "plant/ema_run.h"

ema_status_t ema_objective_start(ema_objective_t* objective, const ema_actuator_t* actuator, const ema_record_t* record,
                                 const ema_real weight[EMA_CHANNEL_COUNT], ema_real start_mm, ema_real limit)
{
    if ((objective == NULL) || (actuator == NULL) || (record == NULL) || (weight == NULL)) {
        return EMA_ERR_NULL;
    }
    if (record->count < 1U) {
        return EMA_ERR_SHORT;
    }
    if (!ema_record_weights(record, weight)) {
        return EMA_ERR_RANGE;
    }
    const ema_status_t status = ema_model_init(&objective->model, actuator, start_mm);
    if (status == EMA_OK) {
        ema_cursor_start(&objective->cursor, record, actuator);
        objective->period_s = actuator->params.step_s * (ema_real)objective->cursor.every_steps;
        objective->channels = 0U;
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            if (weight[channel] > EMA_R(0.0)) {
                objective->weight[objective->channels] = weight[channel];
                objective->channel[objective->channels] = (uint8_t)channel;
                ++objective->channels;
            }
        }
        objective->limit = limit;
        objective->sum = EMA_R(0.0);
        objective->sum_low = EMA_R(0.0);
        objective->state = EMA_OBJECTIVE_RUNNING;
    }
    return status;
}

/* Squared error of one row, weighted over the channels. */
static inline ema_real ema_objective_row(const ema_objective_t* objective, const ema_output_t* simulated)
{
    const ema_record_t* const record = objective->cursor.record;
    ema_real sum = EMA_R(0.0);
    for (uint32_t k = 0; k < objective->channels; ++k) {
        const uint32_t channel = objective->channel[k];
        const ema_real error = ema_record_value(record, objective->cursor.row, (uint32_t)record->place[channel])
                               - ema_output_channel(simulated, channel);
        sum += objective->weight[k] * (error * error);
    }
    return sum;
}

ema_objective_state_t ema_objective_run(ema_objective_t* objective, uint32_t steps)
{
    objective->model.work.spent = 0U;
    while ((objective->state == EMA_OBJECTIVE_RUNNING) && (objective->model.work.spent < steps)) {
        ema_state_t* const state = &objective->model.state;
        const ema_real command_mm = ema_cursor_command(&objective->cursor, state->step);
        ema_output_t simulated;
        ema_tick(&objective->model.plant, state, &objective->model.work, command_mm, &simulated);
        if (ema_cursor_row_due(&objective->cursor)) {
            ema_add_compensated(&objective->sum, &objective->sum_low,
                                ema_objective_row(objective, &simulated) * objective->period_s);
            if (!(objective->sum <= objective->limit)) {
                const bool finite = ema_is_finite(objective->sum);
                objective->sum = finite ? objective->sum : EMA_COST_MAX;
                objective->state = finite ? EMA_OBJECTIVE_EXCEEDED : EMA_OBJECTIVE_DIVERGED;
            }
        }
        ema_cursor_pass(&objective->cursor);
        if (ema_cursor_ended(&objective->cursor) && (objective->state == EMA_OBJECTIVE_RUNNING)) {
            objective->state = EMA_OBJECTIVE_DONE;
        }
    }
    return objective->state;
}

ema_real ema_objective_value(const ema_objective_t* objective)
{
    return objective->sum;
}
