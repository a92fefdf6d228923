#include "ema/ema_trend.h"

#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "trend/ema_ahead.h"
#include "trend/ema_trend_kept.h"

/* Beyond it one kind of law has nothing left in float32. */
#define EMA_ODDS_MOST EMA_R(80.0)
/* Smaller sums are taken as this one. */
#define EMA_LEAST EMA_R(1.0e-35)

/* An instant, and the share that has reached the limit by then. */
typedef struct {
    ema_real at;
    ema_real reached;
} ema_instant_t;

/* The time by which `share` has reached the limit, straight between two instants, where it is between these. */
static void ema_left_between(ema_time_left_t* left, ema_real share, const ema_instant_t* before,
                             const ema_instant_t* now, ema_real age_days)
{
    if (left->open && (now->reached >= share)) {
        const ema_real part = (share - before->reached) / (now->reached - before->reached);
        left->days = (before->at + (part * (now->at - before->at))) * age_days;
        left->open = false;
    }
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
    ema_clear(outlook, sizeof *outlook);
    ema_outlook_values(forecast, outlook);
    outlook->ahead_days = EMA_FORECAST_HORIZON * forecast->age_days;
    const ema_time_left_t open = {outlook->ahead_days, true};
    outlook->low = open;
    outlook->median = open;
    outlook->high = open;
    ema_instant_t before = {EMA_R(0.0), EMA_R(0.0)};
    const ema_real stalled_for = forecast->stalled_for / ema_max(forecast->stalled_sum, EMA_LEAST);
    for (uint32_t k = 0U; k < EMA_FORECAST_TIMES; ++k) {
        const ema_real share = ema_forecast_share(forecast->going, forecast->stalled, stalled_for, k);
        ema_instant_t now = {ema_forecast_time(k), EMA_R(0.0)};
        now.reached = ema_max(before.reached, ema_min(share / forecast->weight_sum, EMA_R(1.0)));
        ema_left_between(&outlook->low, EMA_R(0.05), &before, &now, forecast->age_days);
        ema_left_between(&outlook->median, EMA_R(0.5), &before, &now, forecast->age_days);
        ema_left_between(&outlook->high, EMA_R(0.95), &before, &now, forecast->age_days);
        before = now;
    }
    outlook->reached_ratio = before.reached;
    return EMA_TREND_OK;
}
