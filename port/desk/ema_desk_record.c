#include "ema_desk_record.h"

#include <stdlib.h>

ema_sample_t ema_sample_from(const double* command_mm, const double* channels, int32_t row)
{
    ema_sample_t sample;
    sample.command_mm = (ema_real)command_mm[row];
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        sample.channel[channel] = (ema_real)channels[((size_t)row * EMA_CHANNEL_COUNT) + channel];
    }
    return sample;
}

ema_status_t ema_record_config_from(ema_record_config_t* config, const double* command_mm, const double* channels,
                                    const double* weight, const bool* keep, int32_t rows, int32_t int16_record)
{
    const ema_record_config_t fresh = {0};
    *config = fresh;
    size_t stride = 1U;
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config->keep[channel] = (channel == (uint32_t)EMA_CHANNEL_POSITION) || (weight[channel] > 0.0) || keep[channel];
        stride += config->keep[channel] ? 1U : 0U;
    }
    config->format = (int16_record != 0) ? EMA_RECORD_INT16 : EMA_RECORD_REAL;
    double largest[1U + EMA_CHANNEL_COUNT] = {1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9, 1.0e-9};
    for (int32_t row = 0; row < rows; ++row) {
        for (uint32_t k = 0; k <= EMA_CHANNEL_COUNT; ++k) {
            const double value = (k == 0U) ? command_mm[row] : channels[((size_t)row * EMA_CHANNEL_COUNT) + (k - 1U)];
            const double size = (value < 0.0) ? -value : value;
            largest[k] = (size > largest[k]) ? size : largest[k];
        }
    }
    /* a margin of one part in a thousand, so that rounding never leaves the scale */
    config->command_full_scale_mm = (ema_real)(largest[0] * 1.001);
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        config->full_scale[channel] = (ema_real)(largest[1U + channel] * 1.001);
    }
    config->buffer_bytes = (size_t)rows * stride * ((int16_record != 0) ? sizeof(int16_t) : sizeof(ema_real));
    config->buffer = malloc(config->buffer_bytes);
    return (config->buffer != NULL) ? EMA_OK : EMA_ERR_FULL;
}
