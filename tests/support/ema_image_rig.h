/* Images of units written here, byte by byte and apart from the module, so that tests can spoil them anywhere. */
#ifndef EMA_IMAGE_RIG_H
#define EMA_IMAGE_RIG_H

#include "ema/ema.h"

/* A unit to write; `table` may be NULL. */
typedef struct {
    const char* name;
    const ema_actuator_t* actuator;
    const ema_signatures_t* table;
} ema_image_rig_unit_t;

/* Where parts of the image stand. */
#define EMA_RIG_VERSION 8U
#define EMA_RIG_LENGTH 12U
#define EMA_RIG_SCHEMA 16U
#define EMA_RIG_COUNT 20U
#define EMA_RIG_ENTRY(place) (24U + (48U * (place)))
#define EMA_RIG_ENTRY_ACTUATOR 36U
#define EMA_RIG_ENTRY_TABLE 40U
#define EMA_RIG_ENTRY_TABLE_BYTES 44U

/* Writes the image of `count` units; its length. */
uint32_t ema_image_rig(uint8_t* bytes, const ema_image_rig_unit_t* units, uint32_t count);

/* Number of 32 bits at a place. */
uint32_t ema_image_rig_get(const uint8_t* bytes, uint32_t place);
void ema_image_rig_put(uint8_t* bytes, uint32_t place, uint32_t value);

/* Makes the checksum right again. */
void ema_image_rig_seal(uint8_t* bytes);

/* CRC-32, one bit at a time. */
uint32_t ema_image_rig_crc(const uint8_t* bytes, uint32_t length);

#endif
