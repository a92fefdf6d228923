/* A record of any configuration over a buffer, and one row of any numbers in any of its states, NaN and infinities too;
 * then the row is read. The sizes of the buffer are those in the list: nothing, less than a row, odd ones, whole rows.
 */
#include "states.h"

static ema_record_t record;
static ema_record_config_t config;
static ema_command_t command;
static unsigned char buffer[4100];

static void ema_one_size(size_t bytes, uint32_t kept, bool commanded, ema_record_format_t format)
{
    ema_sample_t sample;
    ema_sample_t back;
    EMA_ANY(config);
    EMA_ANY(sample);
    config.buffer = buffer;
    config.buffer_bytes = bytes;
    config.format = format;
    config.command = commanded ? &command : NULL;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config.keep[channel] = ((kept >> channel) & 1U) != 0U;
    }
    if (ema_record_init(&record, &config) == EMA_OK) {
        //@ assert a_row: record.capacity >= 1;
        record.count = (uint32_t)Frama_C_interval(0, (int)record.capacity);
        (void)ema_record_append(&record, &sample);
        //@ assert no_more_than_fit: record.count <= record.capacity;
        const uint32_t row = (uint32_t)Frama_C_interval(0, 0x7fffffff);
        (void)ema_record_read(&record, row, 1U, &back);
    }
}

void main(void)
{
    static const size_t sizes[] = {0U, 1U, 7U, 20U, 41U, sizeof buffer};
    EMA_ANY(buffer);
    command.config.kind = EMA_COMMAND_STEP;
    for (uint32_t s = 0; s < (sizeof sizes / sizeof sizes[0]); ++s) {
        for (uint32_t kept = 0; kept < 16U; ++kept) {
            ema_one_size(sizes[s], kept, false, EMA_RECORD_INT16);
            ema_one_size(sizes[s], kept, true, EMA_RECORD_INT16);
            ema_one_size(sizes[s], kept, false, EMA_RECORD_REAL);
            ema_one_size(sizes[s], kept, true, EMA_RECORD_REAL);
        }
    }
    Frama_C_show_each_end();
}
