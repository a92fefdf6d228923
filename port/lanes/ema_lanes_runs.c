/* Many actuators under one command: as many side by side as have the same shape. */
#include "ema_lanes_runs.h"

#include <stddef.h>

#include "ema/ema_model.h"
#include "ema_desk_actuator.h"
#include "ema_lanes.h"
#include "ema_math.h"
#include "ema_prepare.h"

/* What one call is given. */
typedef struct {
    const double* values;
    const int32_t* options;
    const double* command_mm;
    size_t rows;
    ema_real start_mm;
    ema_real* out;
    int32_t* unlocated_event_steps;
    int32_t* status;
    int64_t* left;
} ema_batch_t;

/* Lanes that run together, and which of the batch they are. */
typedef struct {
    ema_lanes_t lanes;
    ema_actuator_t actuator[EMA_LANES];
    size_t run[EMA_LANES];
    ema_model_t alone; /* of a run that finds no company */
} ema_group_t;

#define EMA_WAITS INT32_MIN

/* Takes run `run` into the next lane; false where it does not fit beside those that are there. */
static bool ema_group_take(ema_group_t* group, const ema_batch_t* batch, size_t run)
{
    const uint32_t lane = group->lanes.count;
    ema_lanes_t* const lanes = &group->lanes;
    ema_actuator_from(&batch->values[run * EMA_VALUE_COUNT], batch->options, &group->actuator[lane]);
    const ema_status_t status = ema_run_prepare(&lanes->plant[lane], &lanes->state[lane], &lanes->work,
                                                &group->actuator[lane], batch->start_mm);
    bool taken = status == EMA_OK;
    if (!taken) {
        batch->status[run] = (int32_t)status;
    } else if (ema_lanes_alike(&lanes->plant[0], &lanes->plant[lane])) {
        group->run[lane] = run;
        batch->status[run] = (int32_t)EMA_OK;
        ++group->lanes.count;
    } else {
        taken = false;
    }
    return taken;
}

/* Lanes that nobody asked for go with the first one. */
static void ema_group_fill(ema_group_t* group)
{
    for (uint32_t lane = group->lanes.count; lane < EMA_LANES; ++lane) {
        group->lanes.plant[lane] = group->lanes.plant[0];
        group->lanes.state[lane] = group->lanes.state[0];
    }
}

/* One signal from the rows that are kept, to each lane's place. */
static void ema_group_signal(const ema_group_t* group, const ema_batch_t* batch, const ema_lane_t* signal, size_t kept,
                             ema_real* out)
{
    const size_t stride = sizeof(ema_lanes_output_t) / sizeof(ema_lane_t);
    for (uint32_t lane = 0; lane < group->lanes.count; ++lane) {
        ema_real* const own = &out[group->run[lane] * 5U * batch->rows];
        for (size_t row = 0; row < kept; ++row) {
            own[row] = signal[row * stride][lane];
        }
    }
}

static void ema_group_show(const ema_group_t* group, const ema_batch_t* batch, size_t first, size_t kept)
{
    const ema_lanes_output_t* const shown = group->lanes.rows;
    ema_real* const out = &batch->out[first];
    ema_group_signal(group, batch, &shown->position_mm, kept, out);
    ema_group_signal(group, batch, &shown->motor_position_mm, kept, &out[batch->rows]);
    ema_group_signal(group, batch, &shown->current_A, kept, &out[2U * batch->rows]);
    ema_group_signal(group, batch, &shown->voltage_V, kept, &out[3U * batch->rows]);
    ema_group_signal(group, batch, &shown->speed_mm_s, kept, &out[4U * batch->rows]);
}

/* A lane that has left the finite numbers ends; what takes its place stays finite a while and is not looked at. */
static void ema_group_end(ema_group_t* group, const ema_batch_t* batch)
{
    for (uint32_t lane = 0; lane < EMA_LANES; ++lane) {
        if (!ema_lanes_finite(&group->lanes, lane)) {
            if (lane < group->lanes.count) {
                batch->status[group->run[lane]] = (int32_t)EMA_ERR_DIVERGED;
            }
            ema_state_rest(&group->lanes.state[lane], &group->lanes.plant[lane]);
            ema_lanes_return(&group->lanes, lane);
        }
    }
}

static void ema_group_run(ema_group_t* group, const ema_batch_t* batch)
{
    const int32_t every = group->actuator[0].options.record_every_steps;
    size_t kept = 0U;
    size_t row = 0U;
    bool known = true;
    ema_lanes_start(&group->lanes);
    while (known && (row < batch->rows)) {
        const ema_real command_mm = (ema_real)batch->command_mm[row];
        known = ema_is_finite(command_mm);
        for (int32_t k = 0; known && (k < every); ++k) {
            /* what is between the recorded rows goes behind the last of them, where nobody looks */
            group->lanes.row = &group->lanes.rows[(k == 0) ? kept : EMA_LANES_ROWS];
            const bool finite = ema_lanes_step(&group->lanes, command_mm);
            if (!finite) {
                ema_group_end(group, batch);
            }
        }
        ++row;
        ++kept;
        if ((kept == EMA_LANES_ROWS) || (row == batch->rows)) {
            ema_group_show(group, batch, row - kept, kept);
            kept = 0U;
        }
    }
    batch->left[0] += (int64_t)group->lanes.lane_spans;
    batch->left[1] += (int64_t)group->lanes.left_spans;
    for (uint32_t lane = 0; lane < group->lanes.count; ++lane) {
        const size_t run = group->run[lane];
        batch->unlocated_event_steps[run] = (int32_t)group->lanes.state[lane].unlocated_event_steps;
        if (!known && (batch->status[run] == (int32_t)EMA_OK)) {
            batch->status[run] = (int32_t)EMA_ERR_NOT_FINITE;
        }
    }
}

/* From how many runs on lanes cost no more than runs one after the other, those without a run among them. */
#define EMA_LANES_WORTH (2U + (EMA_LANES / 8U))

/* One run on its own. */
static void ema_run_alone(ema_group_t* group, const ema_batch_t* batch, uint32_t lane)
{
    const size_t run = group->run[lane];
    const int32_t every = group->actuator[lane].options.record_every_steps;
    ema_real* const out = &batch->out[run * 5U * batch->rows];
    ema_model_t* const model = &group->alone;
    ema_status_t status = ema_model_init(model, &group->actuator[lane], batch->start_mm);
    for (size_t row = 0; (status == EMA_OK) && (row < batch->rows); ++row) {
        for (int32_t k = 0; (status == EMA_OK) && (k < every); ++k) {
            ema_output_t output = {0};
            status = ema_model_step(model, (ema_real)batch->command_mm[row], &output);
            if (k == 0) {
                out[row] = output.position_mm;
                out[batch->rows + row] = output.motor_position_mm;
                out[(2U * batch->rows) + row] = output.current_A;
                out[(3U * batch->rows) + row] = output.voltage_V;
                out[(4U * batch->rows) + row] = output.speed_mm_s;
            }
        }
    }
    batch->status[run] = (int32_t)status;
    batch->unlocated_event_steps[run] = (int32_t)model->state.unlocated_event_steps;
}

static void ema_group_go(ema_group_t* group, const ema_batch_t* batch)
{
    if (group->lanes.count >= EMA_LANES_WORTH) {
        ema_group_fill(group);
        ema_group_run(group, batch);
    } else {
        for (uint32_t lane = 0; lane < group->lanes.count; ++lane) {
            ema_run_alone(group, batch, lane);
        }
    }
}

int32_t ema_lanes_count(void)
{
    return (int32_t)EMA_LANES;
}

int32_t ema_lanes_bits(void)
{
    return (int32_t)(8U * sizeof(ema_real));
}

int32_t ema_lanes_value_count(void)
{
    return (int32_t)EMA_VALUE_COUNT;
}

int32_t ema_lanes_avx2(void)
{
#if defined(__GNUC__) && defined(__x86_64__)
    return (__builtin_cpu_supports("avx2") != 0) ? 1 : 0;
#else
    return 0;
#endif
}

int32_t ema_lanes_simulate(const double* values, const int32_t* options, int32_t runs, const double* command_mm,
                           int32_t rows, double start_mm, ema_real* out, int32_t* unlocated_event_steps,
                           int32_t* status, int64_t* left)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (out == NULL)
        || (unlocated_event_steps == NULL) || (status == NULL) || (left == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    const size_t count = (runs > 0) ? (size_t)runs : 0U;
    const ema_batch_t batch = {.values = values,
                               .options = options,
                               .command_mm = command_mm,
                               .rows = (rows > 0) ? (size_t)rows : 0U,
                               .start_mm = (ema_real)start_mm,
                               .out = out,
                               .unlocated_event_steps = unlocated_event_steps,
                               .status = status,
                               .left = left};
    ema_group_t group = {0};
    left[0] = 0;
    left[1] = 0;
    for (size_t run = 0; run < count; ++run) {
        status[run] = EMA_WAITS;
        unlocated_event_steps[run] = 0;
    }
    for (size_t first = 0; first < count; ++first) {
        group.lanes.count = 0U;
        for (size_t run = first; (run < count) && (group.lanes.count < EMA_LANES); ++run) {
            if (status[run] == EMA_WAITS) {
                (void)ema_group_take(&group, &batch, run);
            }
        }
        ema_group_go(&group, &batch);
    }
    return (int32_t)EMA_OK;
}
