/* The module's trend and time to a limit on the desk's readings. */
#include "ema_desk.h"

#include <stddef.h>

#include "ema/ema.h"

#define EMA_DESK_TREND_IDENTITY 1U

static double ema_left_to(const ema_time_left_t* left)
{
    return left->open ? -1.0 : (double)left->days;
}

static void ema_outlook_to(const ema_outlook_t* from, ema_desk_outlook_t* to)
{
    to->odds_log = (double)from->odds_log;
    to->now_percent = (double)from->now_percent;
    to->now_std_percent = (double)from->now_std_percent;
    to->by_percent = (double)from->by_percent;
    to->rate_percent_per_day = (double)from->rate_percent_per_day;
    to->rate_std_percent_per_day = (double)from->rate_std_percent_per_day;
    to->low_days = ema_left_to(&from->low);
    to->median_days = ema_left_to(&from->median);
    to->high_days = ema_left_to(&from->high);
    to->reached_ratio = (double)from->reached_ratio;
    to->ahead_days = (double)from->ahead_days;
    to->drifts = from->drifts ? 1 : 0;
    to->towards = from->towards ? 1 : 0;
}

static ema_trend_status_t ema_look(const ema_trend_t* trend, const ema_trend_config_t* config, int32_t slice_laws,
                                   ema_desk_outlook_t* outlook)
{
    ema_forecast_t forecast;
    ema_outlook_t found;
    ema_trend_status_t status = ema_forecast_start(&forecast, trend, config);
    while ((status == EMA_TREND_OK) && !ema_forecast_done(&forecast)) {
        status = ema_forecast_run(&forecast, (slice_laws > 0) ? (uint32_t)slice_laws : EMA_FORECAST_LAWS);
    }
    if (status == EMA_TREND_OK) {
        status = ema_forecast_result(&forecast, &found);
    }
    if (status == EMA_TREND_OK) {
        ema_outlook_to(&found, outlook);
    }
    return status;
}

static ema_trend_status_t ema_take(ema_trend_t* trend, const ema_reading_t* reading, int32_t saving)
{
    ema_trend_status_t status = ema_trend_update(trend, reading);
    if ((status == EMA_TREND_OK) && (saving != 0)) {
        uint8_t bytes[EMA_TREND_BYTES];
        status = ema_trend_save(trend, bytes);
        if (status == EMA_TREND_OK) {
            status = ema_trend_restore(trend, EMA_DESK_TREND_IDENTITY, bytes, sizeof bytes);
        }
    }
    return status;
}

int32_t ema_desk_trend(const double* time_days, const double* value_percent, const double* std_percent,
                       int32_t readings, double limit_percent, double false_alarm_ratio, const int32_t* look,
                       int32_t looks, int32_t slice_laws, int32_t saving, ema_desk_outlook_t* outlook,
                       int32_t* bad_reading)
{
    if ((time_days == NULL) || (value_percent == NULL) || (std_percent == NULL) || (look == NULL)
        || (outlook == NULL)) {
        return (int32_t)EMA_TREND_NULL;
    }
    const ema_trend_config_t config = {(ema_real)limit_percent, (ema_real)false_alarm_ratio};
    ema_trend_t trend;
    ema_trend_status_t status = ema_trend_init(&trend, EMA_DESK_TREND_IDENTITY);
    int32_t looked = 0;
    for (int32_t k = 0; (status == EMA_TREND_OK) && (k < readings); ++k) {
        const ema_reading_t reading = {(ema_real)time_days[k], (ema_real)value_percent[k], (ema_real)std_percent[k]};
        status = ema_take(&trend, &reading, saving);
        while ((status == EMA_TREND_OK) && (looked < looks) && (look[looked] == (k + 1))) {
            status = ema_look(&trend, &config, slice_laws, &outlook[looked]);
            ++looked;
        }
        if ((status != EMA_TREND_OK) && (bad_reading != NULL)) {
            *bad_reading = k;
        }
    }
    return (int32_t)status;
}

const char* ema_desk_trend_text(int32_t status)
{
    return ema_trend_text((ema_trend_status_t)status);
}
