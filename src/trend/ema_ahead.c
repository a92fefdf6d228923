#include "trend/ema_ahead.h"

#include "base/ema_math.h"

/* First instant behind zero; logarithm of the ratio of each to the one before, from there to EMA_FORECAST_HORIZON. */
#define EMA_FIRST EMA_R(0.002)
#define EMA_RATIO_LOG (EMA_R(9.210340371976184) / EMA_R(78.0))
_Static_assert(EMA_FORECAST_TIMES == 80U, "so many ratios are between them");

/* The exponential times of a change by the middles of five parts that are as likely, an odd number, so that no
 * median falls between two: -log(1 - (k + 1/2) / 5) */
#define EMA_CHANGES 5U
static const ema_real ema_changes[EMA_CHANGES] = {EMA_R(0.10536051565782628), EMA_R(0.35667494393873245),
                                                  EMA_R(0.6931471805599453), EMA_R(1.203972804325936),
                                                  EMA_R(2.302585092994046)};

/* The time until a stall ends, over that since it began, by the same middles: (1 - (k + 1/2) / 5)^(-1/2) - 1. One that
 * is to come lasts as if it had gone on for EMA_TO_COME. */
static const ema_real ema_ends[EMA_CHANGES] = {EMA_R(0.05409255338945984), EMA_R(0.19522860933439357),
                                               EMA_R(0.4142135623730949), EMA_R(0.8257418583505536),
                                               EMA_R(2.16227766016838)};
#define EMA_TO_COME EMA_R(0.3)

/* The normal logarithm of a pace by Gauss and Hermite's three points: e^(-0.75 sqrt 3), 1, e^(0.75 sqrt 3). */
#define EMA_PACES 3U
static const ema_real ema_paces[EMA_PACES] = {EMA_R(0.2727940659378488), EMA_R(1.0), EMA_R(3.6657688889311544)};
static const ema_real ema_pace_shares[EMA_PACES] = {EMA_R(0.125), EMA_R(0.5), EMA_R(0.125)};
#define EMA_STALL_SHARE EMA_R(0.25)

ema_real ema_forecast_time(uint32_t place)
{
    const ema_real count = (ema_real)place;
    return (place == 0U) ? EMA_R(0.0) : (EMA_FIRST * ema_exp(EMA_RATIO_LOG * (count - EMA_R(1.0))));
}

/* Straight between instants, held behind the last. */
static ema_real ema_share_at(const ema_real share[EMA_FORECAST_TIMES], ema_real at)
{
    if (at < EMA_FIRST) {
        return share[0] + ((share[1] - share[0]) * (at / EMA_FIRST));
    }
    const ema_real beyond = ema_log(at / EMA_FIRST) / EMA_RATIO_LOG;
    if (beyond >= EMA_R(78.0)) {
        return share[EMA_FORECAST_TIMES - 1U];
    }
    const uint32_t place = 1U + (uint32_t)ema_max(beyond, EMA_R(0.0));
    const ema_real before = ema_forecast_time(place);
    const ema_real part = (at - before) / (ema_forecast_time(place + 1U) - before);
    return share[place] + ((share[place + 1U] - share[place]) * ema_clamp(part, EMA_R(0.0), EMA_R(1.0)));
}

ema_real ema_forecast_share(const ema_real going[EMA_FORECAST_TIMES], const ema_real stalled[EMA_FORECAST_TIMES],
                            ema_real stalled_for, uint32_t place)
{
    const ema_real at = ema_forecast_time(place);
    ema_real sum = EMA_R(0.0);
    for (uint32_t k = 0U; k < EMA_CHANGES; ++k) {
        const ema_real until = ema_min(at, ema_changes[k]);
        const ema_real since = at - until;
        for (uint32_t pace = 0U; pace < EMA_PACES; ++pace) {
            sum += ema_pace_shares[pace] * ema_share_at(going, until + (ema_paces[pace] * since));
        }
        for (uint32_t end = 0U; end < EMA_CHANGES; ++end) {
            const ema_real again = ema_max(since - (ema_ends[end] * EMA_TO_COME), EMA_R(0.0));
            sum += (EMA_STALL_SHARE / (ema_real)EMA_CHANGES) * ema_share_at(going, until + again);
        }
        sum += ema_share_at(stalled, ema_max(at - (ema_ends[k] * stalled_for), EMA_R(0.0)));
    }
    return sum / (ema_real)EMA_CHANGES;
}
