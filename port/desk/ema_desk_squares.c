/* The module's least squares on a record of the desk's. */
#include "ema_desk.h"

#include <stdlib.h>

#include "ema/ema.h"
#include "ema_desk_actuator.h"
#include "ema_desk_record.h"

_Static_assert(EMA_DESK_SEARCHED_MAX == EMA_LEAST_SQUARES_MAX, "the desk's arrays hold the search's");

static ema_status_t ema_squares_config_from(ema_least_squares_config_t* config, const ema_actuator_t* actuator,
                                            const ema_desk_squares_t* search)
{
    const ema_least_squares_config_t fresh = {0};
    *config = fresh;
    if ((search->count < 1) || (search->count > EMA_DESK_SEARCHED_MAX) || (search->run_budget < 1)
        || (search->restarts < 0) || (search->slice_steps < 1)) {
        return EMA_ERR_RANGE;
    }
    config->actuator = actuator;
    config->count = (uint32_t)search->count;
    config->run_budget = (uint32_t)search->run_budget;
    config->restarts = (uint32_t)search->restarts;
    for (uint32_t k = 0; k < config->count; ++k) {
        if ((search->id[k] < 0) || (search->id[k] >= (int32_t)EMA_VALUE_COUNT) || (search->with[k] < 0)
            || (search->with[k] >= (int32_t)EMA_VALUE_COUNT)) {
            return EMA_ERR_RANGE;
        }
        const ema_searched_t searched = {(ema_value_id_t)search->id[k], (ema_value_id_t)search->with[k],
                                         (ema_real)search->lower[k], (ema_real)search->upper[k],
                                         (ema_real)search->start[k]};
        config->searched[k] = searched;
    }
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config->noise[channel] = (ema_real)search->noise[channel];
    }
    return EMA_OK;
}

static double ema_error_to(ema_real error)
{
    return (error < EMA_COST_MAX) ? (double)error : -1.0;
}

static void ema_squares_result_to(const ema_least_squares_result_t* from, ema_desk_squares_result_t* to)
{
    const ema_desk_squares_result_t fresh = {.misfit_before = (double)from->misfit_before,
                                             .misfit_after = (double)from->misfit_after,
                                             .residual_rms_mm = (double)from->residual_rms_mm,
                                             .residual_correlation = (double)from->residual_correlation,
                                             .model_steps = (int64_t)from->model_steps,
                                             .runs = (int32_t)from->runs,
                                             .starts = (int32_t)from->starts,
                                             .outcome = (int32_t)from->outcome,
                                             .crossed = from->crossed ? 1 : 0,
                                             .adequate = from->adequate ? 1 : 0};
    *to = fresh;
    for (uint32_t k = 0; k < from->count; ++k) {
        to->estimate[k] = (double)from->value[k].estimate;
        to->std[k] = ema_error_to(from->value[k].std);
        to->bias[k] = ema_error_to(from->value[k].bias);
        to->noise_std[k] = ema_error_to(from->value[k].noise_std);
        to->determined[k] = (int32_t)from->value[k].determined;
        to->partner[k] = (int32_t)from->value[k].partner;
        to->at_bound[k] = from->value[k].at_bound ? 1 : 0;
    }
}

/* Runs the search to its end, unless the progress stops it. */
static ema_status_t ema_squares_to_end(ema_least_squares_t* search, int32_t slice_steps,
                                       ema_desk_squares_progress_t progress, void* context,
                                       ema_least_squares_result_t* result)
{
    ema_status_t status = EMA_OK;
    uint32_t told = 0U;
    bool stopped = false;
    while ((status == EMA_OK) && !stopped && !ema_least_squares_done(search)) {
        status = ema_least_squares_run(search, (uint32_t)slice_steps);
        /* a march that has just ended is not yet counted */
        if ((progress != NULL) && (search->runs > told) && (search->phase != EMA_SQUARES_DECIDING)
            && (ema_least_squares_result(search, result) == EMA_OK)) {
            double lowest[EMA_DESK_SEARCHED_MAX];
            for (uint32_t k = 0; k < result->count; ++k) {
                lowest[k] = (double)result->value[k].estimate;
            }
            told = search->runs;
            stopped = progress((int32_t)told, (double)result->misfit_after, lowest, context) != 0;
        }
    }
    return (status == EMA_OK) ? ema_least_squares_result(search, result) : status;
}

int32_t ema_desk_least_squares(const double* values, const int32_t* options, const double* command_mm,
                               const double* channels, int32_t rows, const ema_desk_squares_t* search,
                               ema_desk_squares_progress_t progress, void* context, ema_desk_squares_result_t* result,
                               int32_t* bad_row)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (channels == NULL) || (search == NULL)
        || (result == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if (rows < 1) {
        return (int32_t)EMA_ERR_SHORT;
    }
    ema_actuator_t actuator;
    ema_record_config_t kept;
    ema_record_t record;
    ema_least_squares_config_t config;
    ema_least_squares_t squares;
    const bool none[EMA_CHANNEL_COUNT] = {false};
    ema_actuator_from(values, options, &actuator);
    ema_status_t status =
        ema_record_config_from(&kept, command_mm, channels, search->noise, none, rows, search->int16_record);
    if (status == EMA_OK) {
        status = ema_record_init(&record, &kept);
    }
    for (int32_t row = 0; (status == EMA_OK) && (row < rows); ++row) {
        const ema_sample_t sample = ema_sample_from(command_mm, channels, row);
        status = ema_record_append(&record, &sample);
        if ((status != EMA_OK) && (bad_row != NULL)) {
            *bad_row = row;
        }
    }
    if (status == EMA_OK) {
        status = ema_squares_config_from(&config, &actuator, search);
    }
    if (status == EMA_OK) {
        status = ema_least_squares_init(&squares, &config, &record);
    }
    if (status == EMA_OK) {
        ema_least_squares_result_t found;
        status = ema_squares_to_end(&squares, search->slice_steps, progress, context, &found);
        if (status == EMA_OK) {
            ema_squares_result_to(&found, result);
        }
    }
    free(kept.buffer);
    return (int32_t)status;
}
