/* What the fuzz targets share: reading choices from the input's bytes, and properties that end the run when they do not
 * hold. */
#ifndef EMA_FUZZ_H
#define EMA_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ema/ema.h"

/* libFuzzer calls this with every input; it answers 0. */
int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

#define FUZZ_REQUIRE(condition)                                                                                        \
    do {                                                                                                               \
        if (!(condition)) {                                                                                            \
            (void)fprintf(stderr, "%s:%d: property does not hold: %s\n", __FILE__, __LINE__, #condition);              \
            abort();                                                                                                   \
        }                                                                                                              \
    } while (0)

/* The bytes not yet used; behind their end everything reads zero. */
typedef struct {
    const uint8_t* at;
    size_t left;
} fuzz_bytes_t;

uint8_t fuzz_u8(fuzz_bytes_t* bytes);
uint16_t fuzz_u16(fuzz_bytes_t* bytes);
uint32_t fuzz_u32(fuzz_bytes_t* bytes);

/* A number from 0 to 1. */
ema_real fuzz_share(fuzz_bytes_t* bytes);

/* Any number at all: NaN, infinities, zeros, the smallest and the largest, or any bits. */
ema_real fuzz_any(fuzz_bytes_t* bytes);

/* A number inside the range, its ends and the nominal value included. */
ema_real fuzz_within(fuzz_bytes_t* bytes, const ema_range_t* range);

/* One value or option of the actuator becomes another: inside its range, or, where `wild`, any number at all. */
void fuzz_change(fuzz_bytes_t* bytes, ema_actuator_t* actuator, bool wild);

bool fuzz_finite(ema_real value);

#endif
