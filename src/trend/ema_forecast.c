#include "trend/ema_forecast.h"

#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ema/ema_trend.h"
#include "trend/ema_first_passage.h"
#include "trend/ema_law.h"
#include "trend/ema_trend_kept.h"
#include "trend/ema_wear_filter.h"

/* Share of the evidence's logarithm that weighs the laws against each other: none is the machine's own, and readings
 * beside each other repeat what it lacks. */
#define EMA_TEMPER EMA_R(0.7)
/* Standard deviation of the level over an edge of a law, times the parts at whose ends it stands: what wears until one
 * is there is a step; the limit being 1. */
#define EMA_EDGE EMA_R(0.24)
/* Below any evidence that there can be. */
#define EMA_NO_LOG EMA_R(-1.0e30)
/* Least doubt about a value, squared, so that a quotient by it is finite. */
#define EMA_DOUBT_LEAST EMA_R(1.0e-12)

ema_trend_status_t ema_forecast_start(ema_forecast_t* forecast, const ema_trend_t* trend,
                                      const ema_trend_config_t* config)
{
    if ((forecast == NULL) || (trend == NULL) || (config == NULL)) {
        return EMA_TREND_NULL;
    }
    if (!ema_trend_started(trend)) {
        return EMA_TREND_STALE;
    }
    const ema_real size = ema_abs(config->limit_percent);
    if (!((size >= EMA_TREND_LIMIT_MIN_PERCENT) && (size <= EMA_TREND_PERCENT_MAX))) {
        return EMA_TREND_LIMIT;
    }
    if (!((config->false_alarm_ratio >= EMA_R(1.0e-6)) && (config->false_alarm_ratio <= EMA_R(0.5)))) {
        return EMA_TREND_FALSE_ALARM;
    }
    const ema_real age = trend->last_days - trend->first_days;
    if ((trend->readings < EMA_TREND_READINGS_MIN) || !(age > EMA_R(0.0))) {
        return EMA_TREND_FEW;
    }
    ema_clear(forecast, sizeof *forecast);
    forecast->mark = EMA_FORECAST_MARK;
    forecast->trend = trend;
    forecast->readings = trend->readings;
    forecast->config = *config;
    forecast->age_days = age;
    forecast->newest_std_percent[0] = ema_trend_robust_std(trend, trend->count - 2U);
    forecast->newest_std_percent[1] = ema_trend_robust_std(trend, trend->count - 1U);
    forecast->top_log = EMA_NO_LOG;
    forecast->best_log = EMA_NO_LOG;
    return EMA_TREND_OK;
}

/* The law through all knots; its own time at the last reading. */
static ema_real ema_followed(const ema_forecast_t* forecast, const ema_law_t* law, ema_wear_t* wear)
{
    const ema_trend_t* const trend = forecast->trend;
    const ema_real scatter = ema_trend_scatter(trend) / ema_abs(forecast->config.limit_percent);
    const ema_real edge = EMA_EDGE / law->parts;
    ema_wear_begin(wear);
    ema_real before = EMA_R(0.0);
    ema_real passed_before = EMA_R(0.0);
    for (uint32_t k = 0U; k < trend->count; ++k) {
        const ema_reading_t* const knot = &trend->knot[k];
        const ema_real at = knot->time_days / forecast->age_days;
        const ema_real now = ema_law_own_time(law, at);
        const ema_real risen = ema_law_risen(law, now);
        const ema_real faded = ema_law_faded(law, at);
        const ema_real row[] = {EMA_R(1.0), risen, faded};
        const uint32_t behind = trend->count - 1U - k;
        const ema_real std = scatter * ((behind < 2U) ? forecast->newest_std_percent[1U - behind] : knot->std_percent);
        const ema_real passed = ema_law_passed(law, at);
        ema_wear_walk(wear, (law->walk * law->walk * (now - before)) + (edge * edge * (passed - passed_before)));
        ema_wear_take(wear, row, knot->value_percent / forecast->config.limit_percent, std * std);
        before = now;
        passed_before = passed;
    }
    return before;
}

/* Evidence of wear and of none, over the best so far. */
static void ema_witness(ema_forecast_t* forecast, bool still, ema_real evidence_log)
{
    if (evidence_log > forecast->top_log) {
        const ema_real less = ema_exp(forecast->top_log - evidence_log);
        forecast->still *= less;
        forecast->wears *= less;
        forecast->top_log = evidence_log;
    }
    const ema_real share = ema_exp(evidence_log - forecast->top_log);
    if (still) {
        forecast->still += share;
    } else {
        forecast->wears += share;
    }
}

/* What a law has in the mixture; all others have less by as much as the best has become better. */
static ema_real ema_weight(ema_forecast_t* forecast, const ema_law_t* law, ema_real evidence_log)
{
    if (evidence_log > forecast->best_log) {
        const ema_real less = ema_exp(EMA_TEMPER * (forecast->best_log - evidence_log));
        forecast->weight_sum *= less;
        forecast->now_square *= less;
        forecast->rate_square *= less;
        forecast->by *= less;
        forecast->stalled_sum *= less;
        forecast->stalled_for *= less;
        for (uint32_t k = 0U; k < EMA_FORECAST_TIMES; ++k) {
            forecast->going[k] *= less;
            forecast->stalled[k] *= less;
        }
        forecast->best_log = evidence_log;
    }
    return ema_exp((EMA_TEMPER * (evidence_log - forecast->best_log)) + law->share_log);
}

/* Mean and sum of squares with one more law: about the mean, since about zero float32 has nothing left of them. */
static void ema_mean_with(ema_real* mean, ema_real* square, ema_real value, ema_real variance, ema_real weight,
                          ema_real weight_sum)
{
    const ema_real off = value - *mean;
    *mean += off * (weight / weight_sum);
    *square += weight * (variance + (off * (value - *mean)));
}

static void ema_mix(ema_forecast_t* forecast, const ema_law_t* law, const ema_wear_t* wear, ema_real own,
                    ema_real weight)
{
    const ema_real stalled_for = ema_law_stalled_for(law);
    const bool stalls = stalled_for > EMA_R(0.0);
    const ema_real risen = ema_law_risen(law, own);
    const ema_real faded = ema_law_faded(law, EMA_R(1.0));
    const ema_real rises = stalls ? EMA_R(0.0) : ema_law_rises(law, own);
    ema_real row[] = {EMA_R(1.0), risen, faded};
    const ema_real slope[] = {EMA_R(0.0), rises, EMA_R(0.0)};
    const ema_real now = ema_wear_mean(wear, row);
    forecast->weight_sum += weight;
    forecast->by += weight * row[1] * wear->mean[1];
    ema_mean_with(&forecast->now, &forecast->now_square, now, ema_wear_variance(wear, row), weight,
                  forecast->weight_sum);
    ema_mean_with(&forecast->rate, &forecast->rate_square, ema_wear_mean(wear, slope), ema_wear_variance(wear, slope),
                  weight, forecast->weight_sum);
    if (stalls) {
        forecast->stalled_sum += weight;
        forecast->stalled_for += weight * stalled_for;
    }
    ema_real* const share = stalls ? forecast->stalled : forecast->going;
    ema_real reached = EMA_R(0.0);
    for (uint32_t k = 0U; k < EMA_FORECAST_TIMES; ++k) {
        const ema_real ahead = ema_forecast_time(k);
        row[1] = ema_law_risen(law, own + ahead);
        const ema_real doubt = ema_max(ema_wear_variance(wear, row), EMA_DOUBT_LEAST);
        const ema_real walked = law->walk * law->walk * ahead;
        /* once there it is there */
        reached = ema_max(reached, ema_reached(EMA_R(1.0) - now, ema_wear_mean(wear, row) - now, doubt, walked));
        share[k] += weight * reached;
    }
}

ema_trend_status_t ema_forecast_run(ema_forecast_t* forecast, uint32_t laws)
{
    if (forecast == NULL) {
        return EMA_TREND_NULL;
    }
    if ((forecast->mark != EMA_FORECAST_MARK) || !ema_trend_started(forecast->trend)) {
        return EMA_TREND_STALE;
    }
    if (forecast->readings != forecast->trend->readings) {
        return EMA_TREND_CHANGED;
    }
    for (uint32_t k = 0U; (k < laws) && (forecast->law < EMA_FORECAST_LAWS); ++k) {
        const ema_law_t law = ema_law_of(forecast->law);
        const bool still = forecast->law < EMA_LAWS_STILL;
        ema_wear_t wear;
        const ema_real own = ema_followed(forecast, &law, &wear);
        ema_witness(forecast, still, wear.evidence_log + law.share_log);
        if (!still) {
            ema_mix(forecast, &law, &wear, own, ema_weight(forecast, &law, wear.evidence_log));
        }
        forecast->law += 1U;
    }
    return EMA_TREND_OK;
}

bool ema_forecast_done(const ema_forecast_t* forecast)
{
    return (forecast == NULL) || (forecast->mark != EMA_FORECAST_MARK) || (forecast->law >= EMA_FORECAST_LAWS);
}

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

EMA_NOINLINE ema_real ema_forecast_time(uint32_t place)
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

EMA_NOINLINE ema_real ema_forecast_share(const ema_real going[EMA_FORECAST_TIMES],
                                         const ema_real stalled[EMA_FORECAST_TIMES], ema_real stalled_for,
                                         uint32_t place)
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
