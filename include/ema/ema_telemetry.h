/* A result as a packet of fixed length, for a bus or a recorder: verdict, reasons, estimates with their intervals, what
 * the table of signatures found, and which configuration and which version of the module it is of.
 *
 *     ema_result_pack(&config, &result, &finding, packet);
 *
 * Numbers stand with the least byte first, reals as float32, and a checksum at the end. On the ground `ema telemetry
 * FILE` reads packets, one behind the other. Layout: docs/FIRMWARE.md, "Results as telemetry". Firmware that does not
 * call it links none of it.
 */
#ifndef EMA_TELEMETRY_H
#define EMA_TELEMETRY_H

#include "ema/detail/ema_version.h"
#include "ema/ema_image.h"
#include "ema/ema_session.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Version of the packet's layout, and its bytes. */
#define EMA_TELEMETRY_VERSION 1U
#define EMA_TELEMETRY_BYTES 240U

/* A packet that was read. */
typedef struct {
    uint32_t software; /* EMA_VERSION of the module that made it */
    uint32_t schema;   /* EMA_CONFIG_SCHEMA of it: another one numbers values and effects otherwise */
    uint32_t identity; /* ema_actuator_identity of the configuration */
    bool has_finding;
    ema_value_id_t id[EMA_IDENTIFIED_MAX]; /* what the estimates are of */
    ema_real half_95[EMA_IDENTIFIED_MAX];  /* of the 95 % intervals about them, as ema_session_half_95 */
    ema_result_t result;
    ema_finding_t finding; /* where there is one */
} ema_telemetry_t;

/* Packs a result of the session of `config`, and the finding of a guarded one (may be NULL). Errors, nothing changed:
 * EMA_ERR_NULL; EMA_ERR_RANGE when the result is of another number of values than `config`. Cost: that of
 * ema_actuator_identity, and a few thousand instructions. */
ema_status_t ema_result_pack(const ema_session_config_t* config, const ema_result_t* result,
                             const ema_finding_t* finding, uint8_t packet[EMA_TELEMETRY_BYTES]);

/* Reads a packet at the beginning of `length` bytes. Errors, nothing changed: EMA_IMAGE_NULL, EMA_IMAGE_SHORT,
 * EMA_IMAGE_MAGIC, EMA_IMAGE_UNKNOWN_VERSION, EMA_IMAGE_LENGTH, EMA_IMAGE_CHECKSUM; EMA_IMAGE_LAYOUT for a verdict, an
 * outcome, a kind of finding or a number of values that is none. */
ema_image_status_t ema_result_unpack(const uint8_t* packet, size_t length, ema_telemetry_t* telemetry);

#ifdef __cplusplus
}
#endif

#endif
