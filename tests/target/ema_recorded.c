#include "ema_recorded.h"

#include <string.h>

#include "ace_unit_actuator.h"
#include "ema_recorded_tables.inc"

/* Full scale of the record over the actuator's travel, as the host program takes it. */
#define FULL_SCALE EMA_R(1.05)

_Static_assert(sizeof case_a / sizeof case_a[0] == EMA_RECORDED_ROWS, "a case fills the buffer");
_Static_assert(sizeof case_b / sizeof case_b[0] == EMA_RECORDED_ROWS, "a case fills the buffer");
_Static_assert(sizeof case_c / sizeof case_c[0] == EMA_RECORDED_ROWS, "a case fills the buffer");
_Static_assert(sizeof worn / sizeof worn[0] == EMA_RECORDED_ROWS, "the unit's record fills the buffer");

static ema_real number(uint32_t bits)
{
    ema_real value;
    (void)memcpy(&value, &bits, sizeof value);
    return value;
}

bool ema_recorded_row(char name, uint32_t row, ema_sample_t* sample)
{
    const uint32_t (*const table)[3] = (name == 'a')   ? case_a
                                       : (name == 'b') ? case_b
                                       : (name == 'c') ? case_c
                                       : (name == 'u') ? worn
                                                       : NULL;
    const bool there = (table != NULL) && (row < EMA_RECORDED_ROWS);
    if (there) {
        const ema_sample_t fresh = {0};
        *sample = fresh;
        sample->command_mm = number(table[row][0]);
        sample->channel[EMA_CHANNEL_POSITION] = number(table[row][1]);
        sample->channel[EMA_CHANNEL_CURRENT] = number(table[row][2]);
    }
    return there;
}

ema_status_t ema_recorded_start(ema_recorded_t* recorded, char name, uint32_t seed, ema_record_format_t format,
                                ema_search_t search)
{
    ema_sample_t sample;
    ema_status_t status = ema_actuator_defaults(&recorded->actuator);
    if (name == 'u') {
        recorded->actuator = EMA_ACTUATOR;
    }
    const ema_real full_scale_mm = FULL_SCALE * recorded->actuator.params.travel_mm;
    ema_record_config_t record = {
        .buffer = &recorded->buffer, .format = format, .command_full_scale_mm = full_scale_mm};
    record.full_scale[EMA_CHANNEL_POSITION] = full_scale_mm;
    record.buffer_bytes = (format == EMA_RECORD_INT16) ? sizeof recorded->buffer.int16 : sizeof recorded->buffer.real;
    if (status == EMA_OK) {
        status = ema_session_config_default(&recorded->config, &recorded->actuator, &record);
    }
    if (status == EMA_OK) {
        status = ema_session_config_day(&recorded->config);
    }
    if (status == EMA_OK) {
        recorded->config.annealer.seed = seed;
        recorded->config.search = search;
        status = ema_session_init(&recorded->session, &recorded->config);
    }
    if ((status == EMA_OK) && !ema_recorded_row(name, 0U, &sample)) {
        status = EMA_ERR_SHORT;
    }
    for (uint32_t row = 0; (status == EMA_OK) && ema_recorded_row(name, row, &sample); ++row) {
        status = ema_session_feed(&recorded->session, &sample);
    }
    return status;
}
