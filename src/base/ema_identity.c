/* Apart from ema_actuator.c so that firmware which does without it links none of it. */
#include <stddef.h>

#include "base/ema_bytes.h"
#include "base/ema_crc.h"
#include "ema/ema_actuator.h"

static uint32_t ema_identity_reals(uint32_t crc, const ema_real* value, size_t count)
{
    uint32_t found = crc;
    for (size_t k = 0; k < count; ++k) {
        uint8_t bytes[4];
        ema_put_real(bytes, value[k]);
        found = ema_crc32(found, bytes, sizeof bytes);
    }
    return found;
}

uint32_t ema_actuator_identity(const ema_actuator_t* actuator)
{
    if (actuator == NULL) {
        return 0U;
    }
    const int32_t* const option = (const int32_t*)(const void*)&actuator->options; /* EMA-D4 */
    uint32_t crc =
        ema_identity_reals(0U, (const ema_real*)(const void*)&actuator->params, EMA_PARAM_COUNT); /* EMA-D4 */
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        uint8_t bytes[4];
        ema_put_u32(bytes, (uint32_t)option[k]);
        crc = ema_crc32(crc, bytes, sizeof bytes);
    }
    return ema_identity_reals(crc, (const ema_real*)(const void*)&actuator->effects,
                              EMA_EFFECT_VALUE_COUNT); /* EMA-D4 */
}
