/* Where things stand in an image, and what of its head is looked at. */
#ifndef EMA_IMAGE_LAYOUT_H
#define EMA_IMAGE_LAYOUT_H

#include "ema/ema_image.h"

/* "EMAI", and a mark that reads otherwise in another order of bytes. */
#define EMA_IMAGE_MARK 0x49414D45U
#define EMA_IMAGE_ORDER_MARK 0x01020304U

/* The head: mark, order, version, length, schema, number of units; then an entry for each unit, and at the very end
 * the checksum of all before it. */
#define EMA_IMAGE_AT_ORDER 4U
#define EMA_IMAGE_AT_VERSION 8U
#define EMA_IMAGE_AT_LENGTH 12U
#define EMA_IMAGE_AT_SCHEMA 16U
#define EMA_IMAGE_AT_COUNT 20U
#define EMA_IMAGE_HEAD_BYTES 24U
#define EMA_IMAGE_CRC_BYTES 4U

/* An entry: name, identity, where the actuator begins, where the table begins (0 for none) and its bytes. */
#define EMA_ENTRY_AT_IDENTITY EMA_UNIT_NAME_BYTES
#define EMA_ENTRY_AT_ACTUATOR (EMA_UNIT_NAME_BYTES + 4U)
#define EMA_ENTRY_AT_TABLE (EMA_UNIT_NAME_BYTES + 8U)
#define EMA_ENTRY_AT_TABLE_BYTES (EMA_UNIT_NAME_BYTES + 12U)
#define EMA_ENTRY_BYTES (EMA_UNIT_NAME_BYTES + 16U)

/* An actuator: parameters, options, values of effects. */
#define EMA_ACTUATOR_BYTES ((uint32_t)(4U * (EMA_VALUE_COUNT + EMA_OPTION_COUNT)))

/* A table: the members of ema_signatures_t in their order, then patterns, units and counts. */
#define EMA_TABLE_AT_CHANNELS 20U
#define EMA_TABLE_AT_CHANNEL 24U
#define EMA_TABLE_AT_PATTERNS 28U
#define EMA_TABLE_AT_ROWS 40U
#define EMA_TABLE_AT_REFERENCE 52U
#define EMA_TABLE_AT_WEIGHT 68U
#define EMA_TABLE_AT_FAULT 92U
#define EMA_FAULT_BYTES 16U
#define EMA_TABLE_HEAD_BYTES 124U
#define EMA_PATTERN_BYTES 20U

/* Whether this processor reads a number of 32 bits at `mark` as the image means it. */
bool ema_image_native(const uint8_t* mark);

#endif
