#include "trend/ema_trend_kept.h"

#include "base/ema_bytes.h"
#include "base/ema_copy.h"
#include "base/ema_crc.h"
#include "base/ema_math.h"

/* Where things stand. */
#define EMA_TREND_AT_VERSION 4U
#define EMA_TREND_AT_LENGTH 6U
#define EMA_TREND_AT_IDENTITY 8U
#define EMA_TREND_AT_READINGS 12U
#define EMA_TREND_AT_COUNT 16U
#define EMA_TREND_AT_FIRST 20U
#define EMA_TREND_AT_LAST 24U
#define EMA_TREND_AT_SCATTER 28U
#define EMA_TREND_AT_KNOTS 32U
#define EMA_TREND_KNOT_BYTES 12U
#define EMA_TREND_AT_CRC 608U
_Static_assert((EMA_TREND_AT_KNOTS + (EMA_TREND_KNOTS * EMA_TREND_KNOT_BYTES)) == EMA_TREND_AT_CRC,
               "the checksum follows the knots");
_Static_assert((EMA_TREND_AT_CRC + 4U) == EMA_TREND_BYTES, "the checksum is the end");

ema_trend_status_t ema_trend_save(const ema_trend_t* trend, uint8_t bytes[EMA_TREND_BYTES])
{
    if ((trend == NULL) || (bytes == NULL)) {
        return EMA_TREND_NULL;
    }
    if (!ema_trend_started(trend)) {
        return EMA_TREND_STALE;
    }
    ema_clear(bytes, EMA_TREND_BYTES);
    ema_put_u32(bytes, EMA_TREND_MARK);
    ema_put_u16(&bytes[EMA_TREND_AT_VERSION], EMA_TREND_VERSION);
    ema_put_u16(&bytes[EMA_TREND_AT_LENGTH], EMA_TREND_BYTES);
    ema_put_u32(&bytes[EMA_TREND_AT_IDENTITY], trend->identity);
    ema_put_u32(&bytes[EMA_TREND_AT_READINGS], trend->readings);
    ema_put_u32(&bytes[EMA_TREND_AT_COUNT], trend->count);
    ema_put_real(&bytes[EMA_TREND_AT_FIRST], trend->first_days);
    ema_put_real(&bytes[EMA_TREND_AT_LAST], trend->last_days);
    ema_put_real(&bytes[EMA_TREND_AT_SCATTER], trend->scatter_ratio);
    for (uint32_t k = 0U; k < trend->count; ++k) {
        uint8_t* const to = &bytes[EMA_TREND_AT_KNOTS + (k * EMA_TREND_KNOT_BYTES)];
        ema_put_real(to, trend->knot[k].time_days);
        ema_put_real(&to[4], trend->knot[k].value_percent);
        ema_put_real(&to[8], trend->knot[k].std_percent);
    }
    ema_put_u32(&bytes[EMA_TREND_AT_CRC], ema_crc32(0U, bytes, EMA_TREND_AT_CRC));
    return EMA_TREND_OK;
}

static ema_trend_status_t ema_saved_check(uint32_t identity, const uint8_t* bytes, size_t length)
{
    if (length < EMA_TREND_BYTES) {
        return EMA_TREND_SHORT;
    }
    if (ema_get_u32(bytes) != EMA_TREND_MARK) {
        return EMA_TREND_MAGIC;
    }
    if (ema_get_u16(&bytes[EMA_TREND_AT_VERSION]) != EMA_TREND_VERSION) {
        return EMA_TREND_UNKNOWN_VERSION;
    }
    if (ema_get_u16(&bytes[EMA_TREND_AT_LENGTH]) != EMA_TREND_BYTES) {
        return EMA_TREND_LENGTH;
    }
    if (ema_crc32(0U, bytes, EMA_TREND_AT_CRC) != ema_get_u32(&bytes[EMA_TREND_AT_CRC])) {
        return EMA_TREND_CHECKSUM;
    }
    return (ema_get_u32(&bytes[EMA_TREND_AT_IDENTITY]) == identity) ? EMA_TREND_OK : EMA_TREND_IDENTITY;
}

/* Whether knots and times are what updates leave; comparisons that NaN fails. */
static bool ema_kept_sound(const uint8_t* bytes)
{
    const uint32_t count = ema_get_u32(&bytes[EMA_TREND_AT_COUNT]);
    const uint32_t readings = ema_get_u32(&bytes[EMA_TREND_AT_READINGS]);
    const ema_real first = ema_get_real(&bytes[EMA_TREND_AT_FIRST]);
    const ema_real last = ema_get_real(&bytes[EMA_TREND_AT_LAST]);
    const ema_real scatter = ema_get_real(&bytes[EMA_TREND_AT_SCATTER]);
    bool sound = (first <= last) && (count <= EMA_TREND_KNOTS) && (count <= readings) && (readings <= EMA_READINGS_MOST)
                 && (ema_abs(first) <= EMA_TREND_DAYS_MAX) && (ema_abs(last) <= EMA_TREND_DAYS_MAX)
                 && (scatter > EMA_R(0.0)) && ema_is_finite(scatter);
    ema_real before = EMA_R(0.0);
    for (uint32_t k = 0U; sound && (k < count); ++k) {
        const uint8_t* const from = &bytes[EMA_TREND_AT_KNOTS + (k * EMA_TREND_KNOT_BYTES)];
        const ema_real at = ema_get_real(from);
        const ema_real std = ema_get_real(&from[8]);
        sound = (at >= before) && (at <= (EMA_R(2.0) * EMA_TREND_DAYS_MAX))
                && (ema_abs(ema_get_real(&from[4])) <= EMA_TREND_PERCENT_MAX) && (std > EMA_R(0.0))
                && (std <= (EMA_R(2.0) * EMA_TREND_PERCENT_MAX));
        before = at;
    }
    return sound;
}

ema_trend_status_t ema_trend_restore(ema_trend_t* trend, uint32_t identity, const uint8_t* bytes, size_t length)
{
    if ((trend == NULL) || (bytes == NULL)) {
        return EMA_TREND_NULL;
    }
    const ema_trend_status_t status = ema_saved_check(identity, bytes, length);
    if (status != EMA_TREND_OK) {
        return status;
    }
    if (!ema_kept_sound(bytes)) {
        return EMA_TREND_LAYOUT;
    }
    (void)ema_trend_init(trend, identity);
    trend->readings = ema_get_u32(&bytes[EMA_TREND_AT_READINGS]);
    trend->count = ema_get_u32(&bytes[EMA_TREND_AT_COUNT]);
    trend->first_days = ema_get_real(&bytes[EMA_TREND_AT_FIRST]);
    trend->last_days = ema_get_real(&bytes[EMA_TREND_AT_LAST]);
    trend->scatter_ratio = ema_get_real(&bytes[EMA_TREND_AT_SCATTER]);
    for (uint32_t k = 0U; k < trend->count; ++k) {
        const uint8_t* const from = &bytes[EMA_TREND_AT_KNOTS + (k * EMA_TREND_KNOT_BYTES)];
        trend->knot[k].time_days = ema_get_real(from);
        trend->knot[k].value_percent = ema_get_real(&from[4]);
        trend->knot[k].std_percent = ema_get_real(&from[8]);
    }
    return EMA_TREND_OK;
}
