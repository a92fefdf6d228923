#include "ema/ema_trend.h"

#include "base/ema_bytes.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "trend/ema_trend_kept.h"

_Static_assert((EMA_REAL64 != 0) || (sizeof(ema_trend_t) <= 1024U), "a trend takes at most 1 KiB");

/* Newest readings that are never joined: their neighbours are still asked for. */
#define EMA_NEWEST 6U
/* The scatter: deviations beyond three of it count as three, which of a normal one leaves 0.9733 of the square; before
 * any reading it is 1, as if eight had said so, and at least a half. */
#define EMA_CLIP EMA_R(9.0)
#define EMA_CLIPPED EMA_R(0.9733)
#define EMA_BEFORE 8U
#define EMA_SCATTER_LEAST EMA_R(0.25)

const char* ema_trend_text(ema_trend_status_t status)
{
    const char* text;
    switch (status) {
#define EMA_TREND_CASE(name, value, message)                                                                           \
    case (name):                                                                                                       \
        text = (message);                                                                                              \
        break;
        EMA_TREND_STATUS_LIST(EMA_TREND_CASE)
#undef EMA_TREND_CASE
    default:
        text = "unknown status";
        break;
    }
    return text;
}

ema_trend_status_t ema_trend_init(ema_trend_t* trend, uint32_t identity)
{
    if (trend == NULL) {
        return EMA_TREND_NULL;
    }
    ema_clear(trend, sizeof *trend);
    trend->mark = EMA_TREND_MARK;
    trend->identity = identity;
    trend->scatter_ratio = EMA_R(1.0);
    return EMA_TREND_OK;
}

/* Comparisons that NaN fails. */
static ema_trend_status_t ema_reading_check(const ema_trend_t* trend, const ema_reading_t* reading)
{
    if (!(ema_abs(reading->time_days) <= EMA_TREND_DAYS_MAX)) {
        return EMA_TREND_TIME;
    }
    if (!(ema_abs(reading->value_percent) <= EMA_TREND_PERCENT_MAX)) {
        return EMA_TREND_VALUE;
    }
    if (!((reading->std_percent >= EMA_TREND_STD_MIN_PERCENT) && (reading->std_percent <= EMA_TREND_PERCENT_MAX))) {
        return EMA_TREND_STD;
    }
    if ((trend->readings > 0U) && (reading->time_days < trend->last_days)) {
        return EMA_TREND_TIME_BACK;
    }
    return EMA_TREND_OK;
}

/* Joins the two neighbours that are least apart, the newest left out. */
static void ema_join(ema_trend_t* trend)
{
    uint32_t least = 0U;
    for (uint32_t k = 1U; (k + EMA_NEWEST + 1U) < EMA_TREND_KNOTS; ++k) {
        const ema_real gap = trend->knot[k + 1U].time_days - trend->knot[k].time_days;
        if (gap < (trend->knot[least + 1U].time_days - trend->knot[least].time_days)) {
            least = k;
        }
    }
    ema_reading_t* const one = &trend->knot[least];
    const ema_reading_t* const other = &trend->knot[least + 1U];
    /* by the ratio of the weights: the square of a small standard error is none in float32 */
    const ema_real ratio = one->std_percent / other->std_percent;
    const ema_real share = (ratio * ratio) / (EMA_R(1.0) + (ratio * ratio));
    one->time_days += share * (other->time_days - one->time_days);
    one->value_percent += share * (other->value_percent - one->value_percent);
    one->std_percent /= ema_sqrt(EMA_R(1.0) + (ratio * ratio));
    for (uint32_t k = least + 1U; (k + 1U) < EMA_TREND_KNOTS; ++k) {
        trend->knot[k] = trend->knot[k + 1U];
    }
    trend->count = EMA_TREND_KNOTS - 1U;
}

/* How far the newest reading but one lies off the line between its neighbours, over what they state of it. */
static void ema_learn_scatter(ema_trend_t* trend)
{
    const ema_reading_t* const left = &trend->knot[trend->count - 3U];
    const ema_reading_t* const middle = &trend->knot[trend->count - 2U];
    const ema_reading_t* const right = &trend->knot[trend->count - 1U];
    const ema_real span = right->time_days - left->time_days;
    const ema_real part = (span > EMA_R(0.0)) ? ((middle->time_days - left->time_days) / span) : EMA_R(0.5);
    const ema_real off =
        middle->value_percent - ((EMA_R(1.0) - part) * left->value_percent) - (part * right->value_percent);
    /* over the middle's, so that nothing leaves the range of float32 */
    const ema_real from_left = (EMA_R(1.0) - part) * (left->std_percent / middle->std_percent);
    const ema_real from_right = part * (right->std_percent / middle->std_percent);
    const ema_real stated =
        middle->std_percent * ema_sqrt(EMA_R(1.0) + (from_left * from_left) + (from_right * from_right));
    const ema_real clip = ema_sqrt(EMA_CLIP * trend->scatter_ratio);
    const ema_real size = ema_min(ema_abs(off) / stated, clip);
    const ema_real seen = ((size * size) / EMA_CLIPPED) - trend->scatter_ratio;
    const uint32_t counted = (trend->readings - 2U) + EMA_BEFORE;
    trend->scatter_ratio = ema_max(trend->scatter_ratio + (seen / (ema_real)counted), EMA_SCATTER_LEAST);
}

ema_trend_status_t ema_trend_update(ema_trend_t* trend, const ema_reading_t* reading)
{
    if ((trend == NULL) || (reading == NULL)) {
        return EMA_TREND_NULL;
    }
    if (!ema_trend_started(trend)) {
        return EMA_TREND_STALE;
    }
    const ema_trend_status_t status = ema_reading_check(trend, reading);
    if (status != EMA_TREND_OK) {
        return status;
    }
    if (trend->count == EMA_TREND_KNOTS) {
        ema_join(trend);
    }
    if (trend->readings == 0U) {
        trend->first_days = reading->time_days;
    }
    trend->last_days = reading->time_days;
    trend->knot[trend->count] = *reading;
    trend->knot[trend->count].time_days = reading->time_days - trend->first_days;
    trend->count += 1U;
    trend->readings += (trend->readings < EMA_READINGS_MOST) ? 1U : 0U;
    if (trend->count > 2U) {
        ema_learn_scatter(trend);
    }
    if (trend->count > (2U * EMA_TREND_SIDE)) {
        const uint32_t settled = trend->count - 1U - EMA_TREND_SIDE;
        /* the first of all wait for the fifth */
        for (uint32_t k = (trend->readings == ((2U * EMA_TREND_SIDE) + 1U)) ? 0U : settled; k <= settled; ++k) {
            trend->knot[k].std_percent = ema_trend_robust_std(trend, k);
        }
    }
    return EMA_TREND_OK;
}

/* Standard deviations off its neighbours beyond which a reading counts less. */
#define EMA_OUTLIER EMA_R(2.5)

ema_real ema_trend_scatter(const ema_trend_t* trend)
{
    return ema_sqrt(ema_max(trend->scatter_ratio, EMA_R(1.0)));
}

/* Middle of the knots `first` to `last`, at most five, by putting each where it belongs. */
static ema_real ema_middle(const ema_trend_t* trend, uint32_t first, uint32_t last)
{
    ema_real sorted[(2U * EMA_TREND_SIDE) + 1U] = {EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_R(0.0)};
    uint32_t count = 0U;
    uint32_t k = first;
    do {
        const ema_real value = trend->knot[k].value_percent;
        uint32_t place = count;
        while ((place > 0U) && (sorted[place - 1U] > value)) {
            sorted[place] = sorted[place - 1U];
            --place;
        }
        sorted[place] = value;
        ++count;
        ++k;
    } while (k <= last);
    const ema_real upper = sorted[count / 2U];
    return ((count % 2U) == 1U) ? upper : (EMA_R(0.5) * (sorted[(count / 2U) - 1U] + upper));
}

ema_real ema_trend_robust_std(const ema_trend_t* trend, uint32_t place)
{
    const uint32_t first = (place > EMA_TREND_SIDE) ? (place - EMA_TREND_SIDE) : 0U;
    const uint32_t beyond = place + EMA_TREND_SIDE;
    const uint32_t last = (beyond < trend->count) ? beyond : (trend->count - 1U);
    const ema_real std = trend->knot[place].std_percent;
    const ema_real scatter = ema_trend_scatter(trend);
    const ema_real off = ema_abs(trend->knot[place].value_percent - ema_middle(trend, first, last)) / scatter;
    return (off > (EMA_OUTLIER * std)) ? off : std;
}

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
