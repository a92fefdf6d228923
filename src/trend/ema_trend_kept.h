/* What is kept of a trend, as the files of this level share it. */
#ifndef EMA_TREND_KEPT_H
#define EMA_TREND_KEPT_H

#include "ema/ema_trend.h"

/* "EMAW", of a trend in memory and in bytes; and of a forecast. */
#define EMA_TREND_MARK 0x57414D45U
#define EMA_FORECAST_MARK 0x46414D45U

/* Readings on each side by which one is seen to lie far off. */
#define EMA_TREND_SIDE 2U

/* Readings that are counted; more count as so many, so that no sum of them turns over. */
#define EMA_READINGS_MOST 0x7FFFFFFFU

/* Whether it was started, and its numbers are those of a trend as far as memory is concerned. */
static inline bool ema_trend_started(const ema_trend_t* trend)
{
    return (trend->mark == EMA_TREND_MARK) && (trend->count <= EMA_TREND_KNOTS) && (trend->count <= trend->readings)
           && (trend->readings <= EMA_READINGS_MOST);
}

/* What readings scatter by over what they state, at least 1. */
ema_real ema_trend_scatter(const ema_trend_t* trend);

/* Standard error of the knot at `place`, before the scatter: larger where it lies far off those beside it. */
ema_real ema_trend_robust_std(const ema_trend_t* trend, uint32_t place);

#endif
