#include "ema/ema_command.h"

#include <stddef.h>

#include "base/ema_copy.h"
#include "base/ema_math.h"

#define EMA_MULTISINE_LINES_MAX 32U
#define EMA_STEPS_MAX EMA_R(2147483000.0)

/* Phase of line m at the start, -pi m (m - 1) / count, as a fraction of 2^64 turns. */
static uint64_t ema_schroeder_phase(uint32_t line, uint32_t count)
{
    const uint32_t twice = 2U * count;
    const uint32_t folded = (line * (line - 1U)) % twice;
    return UINT64_C(0) - ema_turn64((ema_real)folded / (ema_real)twice);
}

static ema_real ema_multisine_sum(const ema_command_t* command, uint64_t phase)
{
    ema_real sum = EMA_R(0.0);
    for (uint32_t line = 1; line <= command->config.count; ++line) {
        sum += ema_sin_turn64((phase * line) + ema_schroeder_phase(line, command->config.count));
    }
    return sum * command->scale_mm;
}

/* Triangle of peak 1 with zero at phase 0, from a phase in fractions of 2^64; `steep` > 1 clips it to a trapezoid. */
static ema_real ema_ramp_wave(uint64_t phase, ema_real steep)
{
    const ema_real turn = (ema_real)(uint32_t)(phase >> 32U) / EMA_R(4294967296.0);
    ema_real value = EMA_R(4.0) * turn;
    if (turn > EMA_R(0.75)) {
        value = (EMA_R(4.0) * turn) - EMA_R(4.0);
    } else if (turn > EMA_R(0.25)) {
        value = EMA_R(2.0) - (EMA_R(4.0) * turn);
    } else {
        /* first quarter rises */
    }
    return ema_clamp(value * steep, EMA_R(-1.0), EMA_R(1.0));
}

/* A rate below half a turn as a fraction of 2^64. It is mostly tiny: scaling by 2^20 before the conversion keeps its
 * bits. */
static uint64_t ema_rate64(ema_real rate)
{
    const ema_real scaled = rate * EMA_R(1048576.0);
    return ((uint64_t)(uint32_t)ema_floor(scaled) << 44U) | (ema_turn64(scaled) >> 20U);
}

static bool ema_in_range(ema_real value, ema_real lower, ema_real upper)
{
    return (value >= lower) && (value <= upper);
}

ema_status_t ema_command_init(ema_command_t* command, const ema_command_config_t* config, ema_real step_s)
{
    if ((command == NULL) || (config == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_is_finite(step_s) || !(step_s > EMA_R(0.0))) {
        return EMA_ERR_RANGE;
    }
    const bool recorded = config->kind == EMA_COMMAND_RECORD;
    const bool stepped = config->kind == EMA_COMMAND_STEP;
    if (!recorded && !ema_is_finite(config->amplitude_mm)) {
        return EMA_ERR_NOT_FINITE;
    }
    const ema_real half_rate_hz = EMA_R(0.5) / step_s;
    if (!recorded && !stepped && !ema_in_range(config->start_hz, EMA_R(0.0), half_rate_hz)) {
        return EMA_ERR_RANGE;
    }
    ema_command_t made;
    ema_clear(&made, sizeof made);
    made.config = *config;
    made.turns = (recorded || stepped) ? 0U : ema_turn64(config->start_hz * step_s);

    ema_status_t status = EMA_OK;
    switch (config->kind) {
    case EMA_COMMAND_CHIRP: {
        const ema_real steps = config->duration_s / step_s;
        if (!ema_in_range(steps, EMA_R(1.0), EMA_STEPS_MAX)
            || !ema_in_range(config->end_hz, EMA_R(0.0), half_rate_hz)) {
            status = EMA_ERR_RANGE;
        } else {
            const ema_real rate = ((config->end_hz - config->start_hz) * step_s) / (EMA_R(2.0) * steps);
            made.turns_rate = (rate < EMA_R(0.0)) ? (UINT64_C(0) - ema_rate64(-rate)) : ema_rate64(rate);
            made.last_step = (uint32_t)(steps + EMA_R(0.5));
        }
        break;
    }
    case EMA_COMMAND_MULTISINE:
        if ((config->count < 1U) || (config->count > EMA_MULTISINE_LINES_MAX)
            || (((ema_real)config->count * config->start_hz) > half_rate_hz)) {
            status = EMA_ERR_RANGE;
        } else {
            made.scale_mm = config->amplitude_mm / ema_sqrt((ema_real)config->count);
            made.shift_mm = ema_multisine_sum(&made, 0U);
        }
        break;
    case EMA_COMMAND_TRIANGLE:
        break;
    case EMA_COMMAND_TRAPEZOID:
        if (!(config->share > EMA_R(0.0)) || !(config->share <= EMA_R(1.0))) {
            status = EMA_ERR_RANGE;
        }
        break;
    case EMA_COMMAND_STEP: {
        const ema_real steps = config->time_s / step_s;
        if (!ema_in_range(steps, EMA_R(0.0), EMA_STEPS_MAX)) {
            status = EMA_ERR_RANGE;
        } else {
            made.last_step = (uint32_t)(steps + EMA_R(0.5));
        }
        break;
    }
    case EMA_COMMAND_RECORD:
        if (config->samples_mm == NULL) {
            status = EMA_ERR_NULL;
        } else if (config->count < 1U) {
            status = EMA_ERR_RANGE;
        } else {
            /* the samples are read as they are */
        }
        break;
    default:
        status = EMA_ERR_RANGE;
        break;
    }
    if (status == EMA_OK) {
        ema_copy(command, &made, sizeof made);
    }
    return status;
}

ema_real ema_command_at(const ema_command_t* command, uint32_t step)
{
    ema_real value = EMA_R(0.0);
    const uint64_t index = step;
    switch (command->config.kind) {
    case EMA_COMMAND_CHIRP: {
        const uint64_t held = (step < command->last_step) ? index : (uint64_t)command->last_step;
        value = command->config.amplitude_mm * ema_sin_turn64((command->turns + (command->turns_rate * held)) * held);
        break;
    }
    case EMA_COMMAND_MULTISINE:
        value = ema_multisine_sum(command, command->turns * index) - command->shift_mm;
        break;
    case EMA_COMMAND_TRIANGLE:
        value = command->config.amplitude_mm * ema_ramp_wave(command->turns * index, EMA_R(1.0));
        break;
    case EMA_COMMAND_TRAPEZOID:
        value =
            command->config.amplitude_mm * ema_ramp_wave(command->turns * index, EMA_R(1.0) / command->config.share);
        break;
    case EMA_COMMAND_STEP:
        value = (step < command->last_step) ? EMA_R(0.0) : command->config.amplitude_mm;
        break;
    case EMA_COMMAND_RECORD:
        value = command->config.samples_mm[(step < command->config.count) ? step : (command->config.count - 1U)];
        break;
    default:
        break;
    }
    return value;
}
