/* Numbers as bytes, the least first: the same on every processor. A real is a float32. */
#ifndef EMA_BYTES_H
#define EMA_BYTES_H

#include <stdint.h>
#include <string.h>

#include "ema/detail/ema_real.h"
#include <stddef.h>

static inline uint32_t ema_get_u16(const uint8_t* from)
{
    return (uint32_t)from[0] | ((uint32_t)from[1] << 8);
}

static inline uint32_t ema_get_u32(const uint8_t* from)
{
    return ema_get_u16(from) | (ema_get_u16(&from[2]) << 16);
}

static inline uint64_t ema_get_u64(const uint8_t* from)
{
    return (uint64_t)ema_get_u32(from) | ((uint64_t)ema_get_u32(&from[4]) << 32);
}

static inline ema_real ema_get_real(const uint8_t* from)
{
    const uint32_t word = ema_get_u32(from);
    float value = 0.0f;
    (void)memcpy(&value, &word, sizeof value); /* EMA-D3 */
    return (ema_real)value;
}

static inline void ema_put_u16(uint8_t* to, uint32_t value)
{
    to[0] = (uint8_t)(value & 0xFFU);
    to[1] = (uint8_t)((value >> 8) & 0xFFU);
}

static inline void ema_put_u32(uint8_t* to, uint32_t value)
{
    ema_put_u16(to, value);
    ema_put_u16(&to[2], value >> 16);
}

static inline void ema_put_u64(uint8_t* to, uint64_t value)
{
    ema_put_u32(to, (uint32_t)(value & 0xFFFFFFFFU));
    ema_put_u32(&to[4], (uint32_t)(value >> 32));
}

static inline void ema_put_real(uint8_t* to, ema_real value)
{
    const float single = (float)value;
    uint32_t word = 0U;
    (void)memcpy(&word, &single, sizeof word); /* EMA-D3 */
    ema_put_u32(to, word);
}

/* Of `length` bytes behind those whose checksum `crc` is; 0 before the first. Cost: some ten instructions a byte. */
uint32_t ema_crc32(uint32_t crc, const uint8_t* bytes, size_t length);

#endif
