/* The configuration as data: a binary image of one or more units, written by `ema export --image`, in flash beside the
 * program.
 *
 *     ema_image_find(image, sizeof image, "left aileron", &place);
 *     ema_image_open(image, sizeof image, place, &unit);
 *     ema_session_config_default(&config, unit.actuator, &record);
 *
 * Every number is of 32 bits (of 16 in a table of signatures), the least byte first and on a boundary of its size, so
 * that a processor which stores numbers that way reads the image where it lies; any other copies it. An image has a
 * version, its length, the number of the lists it was made for (ema_schema.h) and a checksum; one that is stale, cut
 * off or damaged is refused with its reason, and nothing of it is used. Reads inside `length` bytes only, whatever
 * they are. Layout: docs/FIRMWARE.md, "Configuration as data". Firmware that does not call it links none of it.
 */
#ifndef EMA_IMAGE_H
#define EMA_IMAGE_H

#include "ema/detail/ema_onboard.h"
#include "ema/detail/ema_schema.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the image's layout. */
#define EMA_IMAGE_VERSION 1U

/* Bytes of a unit's name, with the zero at its end. */
#define EMA_UNIT_NAME_BYTES 32U

/* Why an image, or a packed result (ema_telemetry.h), is refused; zero is success. */
/* EMA-D1 */
#define EMA_IMAGE_STATUS_LIST(X)                                                                                       \
    X(EMA_IMAGE_OK, 0, "ok")                                                                                           \
    X(EMA_IMAGE_NULL, 1, "a required pointer is null")                                                                 \
    X(EMA_IMAGE_SHORT, 2, "too few bytes for a head: nothing was written there, or it is cut off")                     \
    X(EMA_IMAGE_MAGIC, 3, "it does not begin as ema export writes it: name the right address, or write it again")      \
    X(EMA_IMAGE_ORDER, 4, "its bytes are in another order: write them as they stand in the file")                      \
    X(EMA_IMAGE_UNKNOWN_VERSION, 5, "it has another version than this module reads: export it again")                  \
    X(EMA_IMAGE_LENGTH, 6, "it is longer than the memory that was given, or no length of an image: write all of it")   \
    X(EMA_IMAGE_CHECKSUM, 7, "its checksum is another: it is damaged, write it again")                                 \
    X(EMA_IMAGE_SCHEMA, 8, "it was made for other lists of values than this module's: export it again")                \
    X(EMA_IMAGE_LAYOUT, 9, "a part of it is not as ema export writes it: export it again")                             \
    X(EMA_IMAGE_NO_UNIT, 10, "no unit of that name or place is in it: ask for one that is, or export it with it")      \
    X(EMA_IMAGE_PLACE, 11,                                                                                             \
      "it cannot be read where it lies, at an address that is no multiple of 4 or by this processor: copy it")         \
    X(EMA_IMAGE_ROOM, 12, "the memory for the copy of its table of signatures is too small")                           \
    X(EMA_IMAGE_RANGE, 13,                                                                                             \
      "a value of the unit is outside its range: correct the actuator's file and export it again")                     \
    X(EMA_IMAGE_ABSENT, 14, "the unit asks for what this build leaves out: build the module with it")

typedef enum {
#define EMA_IMAGE_ENUM(name, value, text) name = (value), /* EMA-D1 */
    EMA_IMAGE_STATUS_LIST(EMA_IMAGE_ENUM)
#undef EMA_IMAGE_ENUM
} ema_image_status_t;

/* A unit of an image. What it points to lies in the image, or in the memory of the copy, and must outlive the session;
 * so must `signatures`, which a guarded session points to. */
typedef struct {
    char name[EMA_UNIT_NAME_BYTES];
    uint32_t identity; /* ema_actuator_identity of its actuator */
    const ema_actuator_t* actuator;
    bool has_signatures;
    ema_signatures_t signatures; /* for ema_guarded_init, where there is one */
} ema_unit_t;

/* Memory of the caller for a copy. */
typedef struct {
    ema_actuator_t* actuator;
    ema_real* table; /* of ema_image_table_bytes; NULL where the unit has no table */
    size_t table_bytes;
} ema_unit_memory_t;

/* Whether all of it is sound but the values of the actuators, which are looked at when their unit is opened. `length`:
 * bytes that may be read; the image may be shorter. Errors: EMA_IMAGE_NULL to EMA_IMAGE_LAYOUT, in the order of the
 * list. Cost: some ten instructions a byte, as of every function here that reads an image. */
ema_image_status_t ema_image_check(const uint8_t* bytes, size_t length);

/* Number of its units; 0 of an image that is refused. */
uint32_t ema_image_count(const uint8_t* bytes, size_t length);

/* Place of the unit called `name`. Errors, nothing changed: those of ema_image_check; EMA_IMAGE_NO_UNIT. */
ema_image_status_t ema_image_find(const uint8_t* bytes, size_t length, const char* name, uint32_t* place);

/* The unit at `place`, 0 for the first, read where it lies. Errors, nothing changed: those of ema_image_check;
 * EMA_IMAGE_NO_UNIT; EMA_IMAGE_PLACE, also in float64; EMA_IMAGE_RANGE and EMA_IMAGE_ABSENT as ema_actuator_check
 * finds them. */
ema_image_status_t ema_image_open(const uint8_t* bytes, size_t length, uint32_t place, ema_unit_t* unit);

/* Bytes that the copy of a unit's table takes; 0 of a unit without one and of an image that is refused. */
size_t ema_image_table_bytes(const uint8_t* bytes, size_t length, uint32_t place);

/* The unit at `place`, copied to `memory`, on any processor and from any address; the image may go afterwards. Errors,
 * `unit` unchanged: those of ema_image_open but EMA_IMAGE_PLACE, and EMA_IMAGE_ROOM. */
ema_image_status_t ema_image_copy(const uint8_t* bytes, size_t length, uint32_t place, const ema_unit_memory_t* memory,
                                  ema_unit_t* unit);

/* The text of a status, a constant string; "unknown status" for a value outside the list. */
const char* ema_image_text(ema_image_status_t status);

#ifdef __cplusplus
}
#endif

#endif
