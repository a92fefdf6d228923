#include "ema/ema_trend.h"

#include "ema_ahead.h"
#include "ema_copy.h"
#include "ema_math.h"
#include "ema_trend_kept.h"

/* Beyond it one kind of law has nothing left in float32. */
#define EMA_ODDS_MOST EMA_R(80.0)
/* Smaller sums are taken as this one. */
#define EMA_LEAST EMA_R(1.0e-35)

/* The instant by which `share` has reached the limit, straight between two; open where it does not. */
static ema_time_left_t ema_left_of(const ema_real reached[EMA_FORECAST_TIMES], ema_real share, ema_real age_days)
{
    uint32_t place = 0U;
    while ((place < EMA_FORECAST_TIMES) && (reached[place] < share)) {
        ++place;
    }
    ema_time_left_t left = {EMA_R(0.0), place == EMA_FORECAST_TIMES};
    if (left.open) {
        left.days = EMA_AHEAD_MOST * age_days;
        return left;
    }
    if (place > 0U) {
        const ema_real before = ema_ahead_time(place - 1U);
        const ema_real part = (share - reached[place - 1U]) / (reached[place] - reached[place - 1U]);
        left.days = (before + (part * (ema_ahead_time(place) - before))) * age_days;
    }
    return left;
}

static ema_real ema_odds_log(const ema_forecast_t* forecast)
{
    const ema_real odds = ema_log(ema_max(forecast->wears, EMA_LEAST)) - ema_log(ema_max(forecast->still, EMA_LEAST));
    return ema_clamp(odds, -EMA_ODDS_MOST, EMA_ODDS_MOST);
}

static void ema_outlook_values(const ema_forecast_t* forecast, ema_outlook_t* outlook)
{
    const ema_real limit = forecast->config.limit_percent;
    const ema_real size = ema_abs(limit);
    const ema_real sum = forecast->weight_sum;
    outlook->now_percent = limit * forecast->now;
    outlook->now_std_percent = size * ema_sqrt(forecast->now_square / sum);
    outlook->by_percent = limit * (forecast->by / sum);
    outlook->rate_percent_per_day = limit * (forecast->rate / forecast->age_days);
    outlook->rate_std_percent_per_day = size * (ema_sqrt(forecast->rate_square / sum) / forecast->age_days);
    outlook->odds_log = ema_odds_log(forecast);
    outlook->drifts = outlook->odds_log >= -ema_log(forecast->config.false_alarm_ratio);
    outlook->towards = outlook->drifts && (forecast->by > EMA_R(0.0));
}

ema_trend_status_t ema_forecast_result(const ema_forecast_t* forecast, ema_outlook_t* outlook)
{
    if ((forecast == NULL) || (outlook == NULL)) {
        return EMA_TREND_NULL;
    }
    if (forecast->mark != EMA_FORECAST_MARK) {
        return EMA_TREND_STALE;
    }
    if (!ema_forecast_done(forecast)) {
        return EMA_TREND_UNFINISHED;
    }
    ema_real reached[EMA_FORECAST_TIMES];
    ema_real most = EMA_R(0.0);
    const ema_real stalled_for = forecast->stalled_for / ema_max(forecast->stalled_sum, EMA_LEAST);
    for (uint32_t k = 0U; k < EMA_FORECAST_TIMES; ++k) {
        const ema_real share = ema_ahead_share(forecast->going, forecast->stalled, stalled_for, k);
        most = ema_max(most, share / forecast->weight_sum);
        reached[k] = ema_min(most, EMA_R(1.0));
    }
    ema_clear(outlook, sizeof *outlook);
    ema_outlook_values(forecast, outlook);
    outlook->low = ema_left_of(reached, EMA_R(0.05), forecast->age_days);
    outlook->median = ema_left_of(reached, EMA_R(0.5), forecast->age_days);
    outlook->high = ema_left_of(reached, EMA_R(0.95), forecast->age_days);
    outlook->reached_ratio = reached[EMA_FORECAST_TIMES - 1U];
    outlook->ahead_days = EMA_AHEAD_MOST * forecast->age_days;
    return EMA_TREND_OK;
}
