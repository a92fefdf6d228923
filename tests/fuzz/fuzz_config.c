/* An actuator and a session configured with any numbers: a status, or a model whose every row is finite or says that it
 * diverged. */
#include "ema/ema.h"
#include "ema_fuzz.h"

#define STEPS 10U

/* Integration steps of one input: a stiff model makes fewer steps, so that inputs stay short. */
#define SUBSTEPS 40U
#define CHANGES_MAX 16U
#define ROWS 4U

static bool output_finite(const ema_output_t* output)
{
    return fuzz_finite(output->position_mm) && fuzz_finite(output->motor_position_mm) && fuzz_finite(output->current_A)
           && fuzz_finite(output->voltage_V) && fuzz_finite(output->speed_mm_s);
}

static void try_model(fuzz_bytes_t* bytes, const ema_actuator_t* actuator, ema_status_t checked)
{
    static ema_model_t model;
    static ema_model_t before;
    (void)memset(&before, 0x5A, sizeof before);
    (void)memcpy(&model, &before, sizeof model);
    const ema_real travel_mm = actuator->params.travel_mm;
    const ema_real start_mm =
        ((fuzz_u8(bytes) % 4U) == 0U) ? fuzz_any(bytes) : (travel_mm * (fuzz_share(bytes) - EMA_R(0.5)));
    ema_status_t status = ema_model_init(&model, actuator, start_mm);
    if (status != EMA_OK) {
        FUZZ_REQUIRE((memcmp(&model.plant, &before.plant, sizeof model.plant) == 0)
                     && (memcmp(&model.state, &before.state, sizeof model.state) == 0));
        return;
    }
    FUZZ_REQUIRE(checked == EMA_OK);
    for (uint32_t k = 0; (k < STEPS) && ((k * model.plant.substeps) <= SUBSTEPS) && (status != EMA_ERR_DIVERGED); ++k) {
        const uint8_t kind = fuzz_u8(bytes);
        const ema_real command_mm =
            (kind < 8U) ? fuzz_any(bytes) : (travel_mm * ((ema_real)kind - EMA_R(128.0)) / EMA_R(120.0));
        ema_output_t output = {0};
        status = ema_model_step(&model, command_mm, &output);
        if (status == EMA_ERR_NOT_FINITE) {
            FUZZ_REQUIRE(!fuzz_finite(command_mm));
        } else {
            FUZZ_REQUIRE((status == EMA_ERR_DIVERGED) || ((status == EMA_OK) && output_finite(&output)));
        }
    }
    ema_model_restart(&model);
    FUZZ_REQUIRE(fuzz_finite(model.state.rod_mm) && fuzz_finite(model.state.angle_rad));
}

static void change_session(fuzz_bytes_t* bytes, ema_session_config_t* config)
{
    const uint8_t place = fuzz_u8(bytes);
    ema_identified_t* const identified = &config->identified[place % EMA_IDENTIFIED_MAX];
    switch (fuzz_u8(bytes) % 16U) {
    case 0U:
        config->identified_count = fuzz_u8(bytes);
        break;
    case 1U:
        identified->id = fuzz_u16(bytes);
        break;
    case 2U:
        identified->lower = fuzz_any(bytes);
        break;
    case 3U:
        identified->upper = fuzz_any(bytes);
        break;
    case 4U:
        identified->min_shift_percent = fuzz_any(bytes);
        break;
    case 5U:
        config->annealer.first_step = fuzz_any(bytes);
        break;
    case 6U:
        config->annealer.initial_temperature = fuzz_any(bytes);
        break;
    case 7U:
        config->annealer.cooling = fuzz_any(bytes);
        break;
    case 8U:
        config->annealer.function_tolerance = fuzz_any(bytes);
        break;
    case 9U:
        config->annealer.stall_evaluations = fuzz_u32(bytes);
        break;
    case 10U:
        config->annealer.evaluation_budget = fuzz_u32(bytes);
        break;
    case 11U:
        config->annealer.start[place % EMA_ANNEALER_DIMENSION_MAX] = fuzz_any(bytes);
        config->start_at_healthy = false;
        break;
    case 12U:
        config->record.full_scale[place % EMA_CHANNEL_COUNT] = fuzz_any(bytes);
        break;
    case 13U:
        config->record.command_full_scale_mm = fuzz_any(bytes);
        break;
    case 14U:
        config->record.buffer_bytes = (config->record.buffer_bytes * (size_t)fuzz_u8(bytes)) / 256U;
        break;
    default:
        config->record.format = EMA_RECORD_INT16;
        config->record.keep[place % EMA_CHANNEL_COUNT] = true;
        break;
    }
}

static void try_session(fuzz_bytes_t* bytes, const ema_actuator_t* actuator, ema_status_t checked)
{
    static ema_real buffer[ROWS * (1U + EMA_CHANNEL_COUNT)];
    static ema_session_t session;
    ema_session_config_t config;
    ema_record_config_t record = {.buffer = buffer,
                                  .buffer_bytes = sizeof buffer,
                                  .format = EMA_RECORD_REAL,
                                  .command_full_scale_mm = EMA_R(30.0)};
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        record.full_scale[channel] = EMA_R(30.0);
    }
    FUZZ_REQUIRE(ema_session_config_default(&config, actuator, &record) == EMA_OK);
    const uint32_t changes = fuzz_u8(bytes) % 5U;
    for (uint32_t k = 0; k < changes; ++k) {
        change_session(bytes, &config);
    }
    if (ema_session_init(&session, &config) != EMA_OK) {
        return;
    }
    FUZZ_REQUIRE(checked == EMA_OK);
    FUZZ_REQUIRE(ema_session_phase(&session) == EMA_PHASE_FEEDING);
    const uint32_t rows = fuzz_u8(bytes) % 8U;
    for (uint32_t k = 0; k < rows; ++k) {
        ema_sample_t sample = {.command_mm = fuzz_any(bytes)};
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            sample.channel[channel] = (channel == 0U) ? fuzz_any(bytes) : EMA_R(1.0);
        }
        const uint32_t count = session.record.count;
        const ema_status_t status = ema_session_feed(&session, &sample);
        const bool finite = fuzz_finite(sample.command_mm) && fuzz_finite(sample.channel[0]);
        if (status == EMA_OK) {
            ema_sample_t kept;
            FUZZ_REQUIRE(finite);
            FUZZ_REQUIRE((session.record.count == (count + 1U)) && (session.record.count <= session.record.capacity));
            FUZZ_REQUIRE(ema_record_read(&session.record, count, 1U, &kept) == EMA_OK);
            FUZZ_REQUIRE(fuzz_finite(kept.command_mm) && fuzz_finite(kept.channel[0]));
        } else {
            FUZZ_REQUIRE((status == EMA_ERR_FULL) || (status == EMA_ERR_NOT_FINITE) || (status == EMA_ERR_SCALE));
            FUZZ_REQUIRE(session.record.count == count);
        }
    }
    FUZZ_REQUIRE(ema_session_run(&session, 1U + (uint32_t)fuzz_u16(bytes)) == EMA_ERR_SHORT);
    ema_result_t result;
    FUZZ_REQUIRE(ema_session_result(&session, &result) == EMA_ERR_ORDER);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_bytes_t bytes = {data, size};
    ema_actuator_t actuator;
    FUZZ_REQUIRE(ema_actuator_defaults(&actuator) == EMA_OK);
    const uint8_t head = fuzz_u8(&bytes);
    const uint32_t changes = head % CHANGES_MAX;
    const bool wild = head >= 192U;
    for (uint32_t k = 0; k < changes; ++k) {
        fuzz_change(&bytes, &actuator, wild);
    }
    size_t offender = EMA_VALUE_COUNT + EMA_OPTION_COUNT;
    const ema_status_t checked = ema_actuator_check(&actuator, &offender);
    FUZZ_REQUIRE((checked == EMA_OK) || (offender < (EMA_VALUE_COUNT + EMA_OPTION_COUNT)));
    if ((head & 16U) != 0U) {
        try_session(&bytes, &actuator, checked);
    } else {
        try_model(&bytes, &actuator, checked);
    }
    return 0;
}
