/* Many actuators under one command: as many side by side as have the same shape. */
#include "ema_desk.h"
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
    double* out;
    int32_t* unlocated_event_steps;
    int32_t* status;
} ema_desk_batch_t;

/* Lanes that run together, and which of the batch they are. */
typedef struct {
    ema_lanes_t lanes;
    ema_actuator_t actuator[EMA_LANES];
    size_t run[EMA_LANES];
    uint32_t count;
} ema_desk_group_t;

#define EMA_WAITS INT32_MIN

/* Takes run `run` into the next lane; false where it does not fit beside those that are there. */
static bool ema_group_take(ema_desk_group_t* group, const ema_desk_batch_t* batch, size_t run)
{
    const uint32_t lane = group->count;
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
        ++group->count;
    } else {
        taken = false;
    }
    return taken;
}
