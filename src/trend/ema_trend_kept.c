#include "trend/ema_trend_kept.h"

#include "base/ema_math.h"

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
