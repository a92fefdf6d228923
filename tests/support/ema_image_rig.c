#include "ema_image_rig.h"

#include <string.h>

#define VERSION 1U
#define CRC_BYTES 4U

/* Where the next number goes. */
typedef struct {
    uint8_t* bytes;
    uint32_t at;
} pen_t;

uint32_t ema_image_rig_get(const uint8_t* bytes, uint32_t place)
{
    uint32_t value = 0U;
    for (uint32_t k = 4U; k > 0U; --k) {
        value = (value << 8) | bytes[place + k - 1U];
    }
    return value;
}

void ema_image_rig_put(uint8_t* bytes, uint32_t place, uint32_t value)
{
    for (uint32_t k = 0; k < 4U; ++k) {
        bytes[place + k] = (uint8_t)(value >> (8U * k));
    }
}

uint32_t ema_image_rig_crc(const uint8_t* bytes, uint32_t length)
{
    uint32_t crc = 0xFFFFFFFFU;
    for (uint32_t k = 0; k < length; ++k) {
        crc ^= bytes[k];
        for (uint32_t bit = 0; bit < 8U; ++bit) {
            crc = (crc >> 1) ^ (0xEDB88320U * (crc & 1U));
        }
    }
    return crc ^ 0xFFFFFFFFU;
}

static void put_byte(pen_t* pen, uint32_t value)
{
    pen->bytes[pen->at] = (uint8_t)value;
    ++pen->at;
}

static void put(pen_t* pen, uint32_t value)
{
    ema_image_rig_put(pen->bytes, pen->at, value);
    pen->at += 4U;
}

static void put_real(pen_t* pen, ema_real value)
{
    const float single = (float)value;
    uint32_t word;
    (void)memcpy(&word, &single, sizeof word);
    put(pen, word);
}

static void put_actuator(pen_t* pen, const ema_actuator_t* actuator)
{
    ema_real values[EMA_VALUE_COUNT];
    int32_t options[EMA_OPTION_COUNT];
    (void)memcpy(values, &actuator->params, sizeof actuator->params);
    (void)memcpy(&values[EMA_PARAM_COUNT], &actuator->effects, sizeof actuator->effects);
    (void)memcpy(options, &actuator->options, sizeof options);
    for (uint32_t k = 0; k < (uint32_t)EMA_PARAM_COUNT; ++k) {
        put_real(pen, values[k]);
    }
    for (uint32_t k = 0; k < (uint32_t)EMA_OPTION_COUNT; ++k) {
        put(pen, (uint32_t)options[k]);
    }
    for (uint32_t k = (uint32_t)EMA_PARAM_COUNT; k < (uint32_t)EMA_VALUE_COUNT; ++k) {
        put_real(pen, values[k]);
    }
}

static void put_table(pen_t* pen, const ema_signatures_t* table)
{
    put(pen, table->version);
    put(pen, table->fingerprint);
    put(pen, table->record_rows);
    put(pen, table->bin_rows);
    put(pen, table->bins);
    put(pen, table->channels);
    for (uint32_t k = 0; k < EMA_CHANNEL_COUNT; ++k) {
        put_byte(pen, table->channel[k]);
    }
    put(pen, table->patterns);
    put(pen, table->faults);
    put(pen, table->nuisances);
    put(pen, table->rows);
    put_real(pen, table->command_unit_mm);
    put_real(pen, table->command_apart_mm);
    for (uint32_t k = 0; k < EMA_CHANNEL_COUNT; ++k) {
        put_real(pen, table->reference[k]);
    }
    for (uint32_t k = 0; k < EMA_CHANNEL_COUNT; ++k) {
        put_real(pen, table->weight[k]);
    }
    put_real(pen, table->limit);
    put_real(pen, table->energy);
    for (uint32_t k = 0; k < EMA_SIGNATURE_FAULTS_MAX; ++k) {
        const ema_signature_fault_t* const fault = &table->fault[k];
        put(pen, (uint32_t)fault->id | ((uint32_t)fault->row << 16));
        put_real(pen, fault->healthy);
        put_real(pen, fault->turn);
        put_real(pen, fault->length);
    }
    for (uint32_t k = 0; k < table->patterns; ++k) {
        const ema_pattern_t* const pattern = &table->pattern[k];
        put_byte(pen, pattern->effect);
        put_byte(pen, pattern->first);
        put_byte(pen, pattern->rows);
        put_byte(pen, pattern->one_sided ? 1U : 0U);
        for (uint32_t turn = 0; turn < 3U; ++turn) {
            put_real(pen, pattern->turn[turn]);
        }
        put_real(pen, pattern->penalty);
    }
    for (uint32_t k = 0; k < table->rows; ++k) {
        put_real(pen, table->unit[k]);
    }
    const uint32_t counts = table->bins * (1U + (table->channels * (1U + table->rows)));
    for (uint32_t k = 0; k < counts; ++k) {
        const uint32_t word = (uint32_t)(int32_t)table->value[k];
        put_byte(pen, word & 255U);
        put_byte(pen, (word >> 8) & 255U);
    }
    while ((pen->at % 4U) != 0U) {
        put_byte(pen, 0U);
    }
}

void ema_image_rig_seal(uint8_t* bytes)
{
    const uint32_t end = ema_image_rig_get(bytes, EMA_RIG_LENGTH) - CRC_BYTES;
    ema_image_rig_put(bytes, end, ema_image_rig_crc(bytes, end));
}

uint32_t ema_image_rig(uint8_t* bytes, const ema_image_rig_unit_t* units, uint32_t count)
{
    (void)memset(bytes, 0, EMA_RIG_ENTRY(count));
    (void)memcpy(bytes, "EMAI", 4U);
    ema_image_rig_put(bytes, 4U, 0x01020304U);
    ema_image_rig_put(bytes, EMA_RIG_VERSION, VERSION);
    ema_image_rig_put(bytes, EMA_RIG_SCHEMA, EMA_CONFIG_SCHEMA);
    ema_image_rig_put(bytes, EMA_RIG_COUNT, count);
    pen_t pen = {bytes, EMA_RIG_ENTRY(count)};
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t entry = EMA_RIG_ENTRY(k);
        const uint32_t actuator = pen.at;
        (void)memcpy(&bytes[entry], units[k].name, strlen(units[k].name));
        put_actuator(&pen, units[k].actuator);
        ema_image_rig_put(bytes, entry + EMA_UNIT_NAME_BYTES, ema_image_rig_crc(&bytes[actuator], pen.at - actuator));
        ema_image_rig_put(bytes, entry + EMA_RIG_ENTRY_ACTUATOR, actuator);
        if (units[k].table != NULL) {
            const uint32_t table = pen.at;
            put_table(&pen, units[k].table);
            ema_image_rig_put(bytes, entry + EMA_RIG_ENTRY_TABLE, table);
            ema_image_rig_put(bytes, entry + EMA_RIG_ENTRY_TABLE_BYTES, pen.at - table);
        }
    }
    ema_image_rig_put(bytes, EMA_RIG_LENGTH, pen.at + CRC_BYTES);
    ema_image_rig_seal(bytes);
    return pen.at + CRC_BYTES;
}
