#include "ema_fuzz.h"

#include <float.h>
#include <math.h>

uint8_t fuzz_u8(fuzz_bytes_t* bytes)
{
    if (bytes->left == 0U) {
        return 0U;
    }
    const uint8_t value = *bytes->at;
    ++bytes->at;
    --bytes->left;
    return value;
}

uint16_t fuzz_u16(fuzz_bytes_t* bytes)
{
    const uint32_t low = fuzz_u8(bytes);
    return (uint16_t)(low | ((uint32_t)fuzz_u8(bytes) << 8U));
}

uint32_t fuzz_u32(fuzz_bytes_t* bytes)
{
    const uint32_t low = fuzz_u16(bytes);
    return low | ((uint32_t)fuzz_u16(bytes) << 16U);
}

ema_real fuzz_share(fuzz_bytes_t* bytes)
{
    return (ema_real)fuzz_u16(bytes) / EMA_R(65535.0);
}

ema_real fuzz_any(fuzz_bytes_t* bytes)
{
    static const float special[] = {NAN,     -NAN,     INFINITY,       -INFINITY, 0.0F,     -0.0F,
                                    FLT_MIN, -FLT_MIN, FLT_MIN / 8.0F, FLT_MAX,   -FLT_MAX, FLT_EPSILON,
                                    1.0F,    -1.0F,    1.0e30F,        -1.0e30F};
    const uint8_t kind = fuzz_u8(bytes);
    float value = special[kind % 16U];
    if (kind >= 64U) {
        const uint32_t bits = fuzz_u32(bytes);
        (void)memcpy(&value, &bits, sizeof value);
    }
    return (ema_real)value;
}

ema_real fuzz_within(fuzz_bytes_t* bytes, const ema_range_t* range)
{
    const uint8_t kind = fuzz_u8(bytes);
    ema_real value = range->nominal;
    switch (kind % 8U) {
    case 0U:
        value = range->lower;
        break;
    case 1U:
        value = range->upper;
        break;
    case 2U:
    case 3U:
        value = range->lower + (fuzz_share(bytes) * (range->upper - range->lower));
        break;
    case 4U:
    case 5U:
        value = range->nominal * EMA_R(4.0) * fuzz_share(bytes);
        break;
    case 6U:
        /* small against the range: most ranges are wide */
        value = range->lower + ldexpf((float)(range->upper - range->lower), -(int)(fuzz_u8(bytes) % 40U));
        break;
    default:
        break;
    }
    return (value < range->lower) ? range->lower : ((value > range->upper) ? range->upper : value);
}

void fuzz_change(fuzz_bytes_t* bytes, ema_actuator_t* actuator, bool wild)
{
    const size_t count = EMA_VALUE_COUNT + EMA_OPTION_COUNT;
    const size_t id = (size_t)fuzz_u16(bytes) % count;
    const ema_range_t* const range = ema_actuator_range(id);
    FUZZ_REQUIRE(range != NULL);
    if (id < EMA_VALUE_COUNT) {
        FUZZ_REQUIRE(ema_actuator_set(actuator, (ema_value_id_t)id, wild ? fuzz_any(bytes) : fuzz_within(bytes, range))
                     == EMA_OK);
    } else {
        /* the largest seed is no float: the next one beyond it is asked for as the smallest number there is */
        const int32_t option = wild ? (int32_t)fuzz_u32(bytes) : (int32_t)(uint32_t)(int64_t)fuzz_within(bytes, range);
        (void)memcpy((char*)&actuator->options + ((id - EMA_VALUE_COUNT) * sizeof option), &option, sizeof option);
    }
}

bool fuzz_finite(ema_real value)
{
    return isfinite(value) != 0;
}
