#include "ema_rig.h"

#include <stdio.h>

#include "ema/ema.h"

static ema_random_t sweep;

void ema_assert_status(ema_status_t expected, ema_status_t actual, unsigned line)
{
    if (expected != actual) {
        char text[200];
        (void)snprintf(text, sizeof text, "expected status %d (%s), got %d (%s)", (int)expected,
                       ema_status_text(expected), (int)actual, ema_status_text(actual));
        UNITY_TEST_FAIL(line, text);
    }
}

ema_actuator_t ema_rig_actuator(void)
{
    ema_actuator_t actuator;
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_defaults(&actuator));
    return actuator;
}

ema_model_t ema_rig_model(const ema_actuator_t* actuator, ema_real start_mm)
{
    ema_model_t model;
    /* padding too, so that copies can be compared byte for byte */
    (void)memset(&model, 0, sizeof model);
    EMA_ASSERT_STATUS(EMA_OK, ema_model_init(&model, actuator, start_mm));
    return model;
}

ema_output_t ema_rig_step(ema_model_t* model, ema_real command_mm)
{
    ema_output_t output = {0};
    EMA_ASSERT_STATUS(EMA_OK, ema_model_step(model, command_mm, &output));
    return output;
}

ema_output_t ema_rig_hold(ema_model_t* model, ema_real command_mm, uint32_t steps)
{
    ema_output_t output = {0};
    for (uint32_t k = 0; k < steps; ++k) {
        output = ema_rig_step(model, command_mm);
    }
    return output;
}

ema_command_t ema_rig_chirp(ema_real end_hz, ema_real duration_s, ema_real step_s)
{
    const ema_command_config_t config = {.kind = EMA_COMMAND_CHIRP,
                                         .amplitude_mm = EMA_R(2.0),
                                         .start_hz = EMA_R(0.1),
                                         .end_hz = end_hz,
                                         .duration_s = duration_s};
    ema_command_t command;
    EMA_ASSERT_STATUS(EMA_OK, ema_command_init(&command, &config, step_s));
    return command;
}

void ema_rig_record(ema_record_t* record, const ema_record_config_t* config, const ema_actuator_t* actuator,
                    const ema_command_t* command, uint32_t rows)
{
    EMA_ASSERT_STATUS(EMA_OK, ema_record_init(record, config));
    ema_model_t model = ema_rig_model(actuator, EMA_R(0.0));
    const uint32_t every = (uint32_t)actuator->options.record_every_steps;
    for (uint32_t row = 0; row < rows; ++row) {
        const ema_real command_mm = ema_command_at(command, row * every);
        const ema_output_t first = ema_rig_step(&model, command_mm);
        const ema_sample_t sample = {command_mm,
                                     {first.position_mm, first.motor_position_mm, first.current_A, first.voltage_V}};
        EMA_ASSERT_STATUS(EMA_OK, ema_record_append(record, &sample));
        for (uint32_t k = 1; k < every; ++k) {
            (void)ema_rig_step(&model,
                               (config->command != NULL) ? ema_command_at(command, (row * every) + k) : command_mm);
        }
    }
}

ema_result_t ema_rig_result(ema_session_t* session, uint32_t steps)
{
    ema_result_t result;
    (void)memset(&result, 0, sizeof result);
    while (ema_session_phase(session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(session, steps));
    }
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(session, &result));
    return result;
}

ema_record_config_t ema_rig_real_record(void* buffer, size_t bytes, bool all)
{
    const ema_record_config_t config = {
        .buffer = buffer, .buffer_bytes = bytes, .format = EMA_RECORD_REAL, .keep = {true, all, all, all}};
    return config;
}

ema_real ema_rig_value(const ema_actuator_t* actuator, size_t id)
{
    ema_real value = EMA_R(0.0);
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_get(actuator, (ema_value_id_t)id, &value));
    return value;
}

ema_real ema_rig_uniform(ema_real lower, ema_real upper)
{
    return lower + ((upper - lower) * ema_random_uniform(&sweep));
}

void ema_rig_seed(uint64_t seed)
{
    ema_random_init(&sweep, seed, UINT64_C(7));
}
