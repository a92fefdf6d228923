#include "ema/detail/ema_sensitivity.h"

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_linear.h"
#include "base/ema_math.h"
#include "ema/detail/ema_objective.h"
#include "ident/ema_cursor_step.h"
#include "ident/ema_residual.h"
#include "ident/ema_run_begin.h"
#include "plant/ema_run.h"

ema_status_t ema_sensitivity_begin(ema_sensitivity_t* self, const ema_actuator_t* actuator, const ema_record_t* record,
                                   const ema_real weight[EMA_CHANNEL_COUNT], uint32_t count)
{
    if (record->count < 1U) {
        return EMA_ERR_SHORT;
    }
    if ((count > EMA_IDENTIFIED_MAX) || !ema_record_weights(record, weight)) {
        return EMA_ERR_RANGE;
    }
    ema_clear(self, sizeof *self);
    ema_cursor_start(&self->cursor, record, actuator);
    self->period_s = actuator->params.step_s * (ema_real)self->cursor.every_steps;
    self->limit = EMA_COST_MAX;
    self->shared_noise_mm = actuator->params.shared_noise_mm;
    self->parameters = count;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        self->weight[channel] = weight[channel];
        self->channels += (weight[channel] > EMA_R(0.0)) ? 1U : 0U;
    }
    return EMA_OK;
}

ema_status_t ema_sensitivity_model(ema_sensitivity_t* self, const ema_actuator_t* actuator, ema_real start_mm)
{
    const uint32_t run = self->prepared;
    ++self->prepared;
    return ema_run_prepare(&self->plant[run], &self->state[run], &self->work, actuator, start_mm);
}

ema_status_t ema_sensitivity_moved(ema_sensitivity_t* self, ema_actuator_t* actuator, ema_value_id_t id, ema_real delta,
                                   ema_real start_mm)
{
    const ema_real value = ema_value_of(actuator, id);
    (void)ema_actuator_set(actuator, id, value + delta);
    self->delta[self->prepared - 1U] = delta;
    const ema_status_t status = ema_sensitivity_model(self, actuator, start_mm);
    (void)ema_actuator_set(actuator, id, value);
    return status;
}

ema_status_t ema_sensitivity_start(ema_sensitivity_t* self, ema_actuator_t* actuator, const ema_record_t* record,
                                   const ema_real weight[EMA_CHANNEL_COUNT], const ema_value_id_t* ids,
                                   const ema_real* delta, uint32_t count, ema_real start_mm)
{
    if ((self == NULL) || (actuator == NULL) || (record == NULL) || (weight == NULL) || (ids == NULL)
        || (delta == NULL)) {
        return EMA_ERR_NULL;
    }
    bool valid = true;
    for (uint32_t k = 0; valid && (k < count) && (k < EMA_IDENTIFIED_MAX); ++k) {
        valid = ((size_t)ids[k] < EMA_VALUE_COUNT) && !ema_actuator_is_learned(ids[k]);
    }
    ema_status_t status = valid ? ema_sensitivity_begin(self, actuator, record, weight, count) : EMA_ERR_RANGE;
    if (status == EMA_OK) {
        status = ema_sensitivity_model(self, actuator, start_mm);
    }
    for (uint32_t k = 0; (status == EMA_OK) && (k < count); ++k) {
        status = ema_sensitivity_moved(self, actuator, ids[k], delta[k], start_mm);
    }
    return status;
}

void ema_sensitivity_learned(ema_sensitivity_t* self, const ema_actuator_t* actuator)
{
    for (uint32_t k = 0; k <= self->parameters; ++k) {
        ema_plant_learned(&self->plant[k], actuator);
    }
}

/* Plain steps that the sums of a row count as, for each weighted channel. */
#define EMA_WORK_ROW 1U

/* Adds one row to the sums once every run has passed it. */
static void ema_sensitivity_row(ema_sensitivity_t* self)
{
    const ema_cursor_t* const cursor = &self->cursor;
    if (self->parameters > 0U) {
        self->work.spent += self->channels * EMA_WORK_ROW;
        const ema_real residual_mm =
            ema_record_at(cursor->record, cursor->row, (uint32_t)cursor->record->place[EMA_CHANNEL_POSITION])
            - self->row_output[0].position_mm;
        ema_residual_row(&self->residual, residual_mm, cursor->row);
        self->pushed[0] = self->pushed[0] || (self->state[0].play_side < 0);
        self->pushed[1] = self->pushed[1] || (self->state[0].play_side > 0);
    }
    ema_real cost = EMA_R(0.0);
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        if (self->weight[channel] > EMA_R(0.0)) {
            const ema_real base = ema_output_channel(&self->row_output[0], channel);
            const ema_real residual =
                ema_record_at(cursor->record, cursor->row, (uint32_t)cursor->record->place[channel]) - base;
            ema_real slope[EMA_IDENTIFIED_MAX];
            uint32_t at = 0U;
            self->residual.weighted_square += self->weight[channel] * residual * residual;
            cost += self->weight[channel] * (residual * residual);
            for (uint32_t i = 0; i < self->parameters; ++i) {
                slope[i] = (ema_output_channel(&self->row_output[1U + i], channel) - base) / self->delta[i];
                self->gradient[i] += self->weight[channel] * slope[i] * residual;
                for (uint32_t j = 0; j <= i; ++j) {
                    self->normal[at] += self->weight[channel] * slope[i] * slope[j];
                    ++at;
                }
            }
        }
    }
    ema_add_compensated(&self->cost, &self->cost_low, cost * self->period_s);
}

bool ema_sensitivity_done(const ema_sensitivity_t* self)
{
    /* written so that NaN is above the limit */
    return ema_cursor_ended(&self->cursor) || !(self->cost <= self->limit);
}

uint32_t ema_sensitivity_run(ema_sensitivity_t* self, uint32_t steps)
{
    uint32_t made = 0U;
    self->work.spent = 0U;
    while ((self->work.spent < steps) && !ema_sensitivity_done(self)) {
        ema_state_t* const state = &self->state[self->next_run];
        if (self->next_run == 0U) {
            self->command_mm = ema_record_asked(self->cursor.record, self->cursor.row, state->step);
        }
        /* between rows nothing reads them */
        ema_tick(&self->plant[self->next_run], state, &self->work, self->command_mm, &self->row_output[self->next_run]);
        ++made;
        ++self->next_run;
        if (self->next_run > self->parameters) {
            self->next_run = 0U;
            if (ema_cursor_row_due(&self->cursor)) {
                ema_sensitivity_row(self);
            }
            ema_cursor_pass(&self->cursor);
        }
    }
    return made;
}

/* So much more damping lets a parameter not move. */
#define EMA_DAMPING_HELD EMA_R(1.0e12)

/* Cholesky factor of J'J at unit diagonal, the parameters having different units, damped; false where the record does
 * not tell them apart. Those of `held`, a set of bits, do not move. */
static EMA_NOINLINE bool ema_sensitivity_factor(const ema_sensitivity_t* self, ema_real damping, uint32_t held,
                                                ema_real* factor, ema_real* length)
{
    const ema_real* normal = self->normal;
    ema_real* row = factor;
    bool determined = true;
    for (uint32_t i = 0; determined && (i < self->parameters); ++i) {
        length[i] = ema_sqrt(normal[i]);
        determined = (length[i] > EMA_R(0.0)) && ema_is_finite(length[i]);
        for (uint32_t j = 0; determined && (j <= i); ++j) {
            row[j] = normal[j] / (length[i] * length[j]);
        }
        if (determined) {
            row[i] += (((held >> i) & 1U) != 0U) ? EMA_DAMPING_HELD : damping;
        }
        normal = &normal[i + 1U];
        row = &row[i + 1U];
    }
    return determined && ema_cholesky(factor, self->parameters);
}

ema_real ema_sensitivity_step(const ema_sensitivity_t* self, ema_real damping, uint32_t held, ema_real* step)
{
    ema_real factor[EMA_TRIANGLE(EMA_IDENTIFIED_MAX)];
    ema_real length[EMA_IDENTIFIED_MAX];
    ema_real fall = EMA_R(-1.0);
    if (ema_sensitivity_factor(self, damping, held, factor, length)) {
        fall = EMA_R(0.0);
        for (uint32_t i = 0; i < self->parameters; ++i) {
            step[i] = self->gradient[i] / length[i];
        }
        ema_solve(factor, self->parameters, step);
        for (uint32_t i = 0; i < self->parameters; ++i) {
            step[i] /= length[i];
            fall += step[i] * (self->gradient[i] + (damping * step[i] * self->normal[EMA_TRIANGLE(i) + i]));
        }
    }
    return fall;
}

void ema_sensitivity_result(const ema_sensitivity_t* self, ema_sensitivity_result_t* result)
{
    const uint32_t count = self->parameters;
    const ema_real rows = (ema_real)self->cursor.row;
    result->residual_rms_mm = ema_sqrt(self->residual.position_square / rows);
    result->residual_correlation = ema_residual_correlation(&self->residual);

    result->outside_ratio = self->state[0].outside_ratio;
    result->crossed = self->pushed[0] && self->pushed[1];

    ema_real factor[EMA_TRIANGLE(EMA_IDENTIFIED_MAX)];
    ema_real length[EMA_IDENTIFIED_MAX];
    result->determined = ema_sensitivity_factor(self, EMA_R(0.0), 0U, factor, length);

    const ema_real widen = ema_residual_widening(result->residual_correlation);
    const ema_real freedom = ema_max((rows * (ema_real)self->channels) - (ema_real)count, EMA_R(1.0));
    const ema_real shared_square =
        ema_residual_shared(&self->residual, self->cursor.row, result->residual_correlation, self->shared_noise_mm)
        * self->residual.weighted_square;
    const ema_real variance = ema_residual_variance(&self->residual, freedom, widen);
    for (uint32_t i = 0; i < count; ++i) {
        ema_real column[EMA_IDENTIFIED_MAX];
        ema_clear(column, sizeof column);
        result->std[i] = EMA_R(0.0);
        result->bias[i] = EMA_R(0.0);
        if (result->determined) {
            column[i] = EMA_R(1.0);
            ema_solve(factor, count, column);
            result->std[i] = ema_sqrt(column[i] * variance) / length[i];
            result->bias[i] = (EMA_BIAS_SHARE * ema_sqrt(column[i] * shared_square)) / length[i];
        }
    }
}
