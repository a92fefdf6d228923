/* What the ground tests of a unit say together: whether a value drifts, how fast, and when it reaches its limit.
 *
 *     ema_trend_init(&trend, identity);                    once, or ema_trend_restore
 *     ema_trend_update(&trend, &reading);                  after every ground test
 *     ema_forecast_start(&forecast, &trend, &config);      whenever somebody asks
 *     while (!ema_forecast_done(&forecast)) { ema_forecast_run(&forecast, 10); }          in slices
 *     ema_forecast_result(&forecast, &outlook);
 *
 * One trend for each value that is watched, at most 1 KiB of the caller's, kept from test to test as plain bytes
 * (ema_trend_save). It holds the newest readings as they are and older ones joined with their neighbours, so that work
 * and memory do not grow with the unit's age. A forecast is a bank of EMA_FORECAST_LAWS named wear laws, each a Kalman
 * filter over what is kept, weighed by how well it foretold the readings; its memory is shared by all trends.
 * Equations: docs/DESIGN.md, "Trend and time to a limit". How often it is right: docs/REMAINING_LIFE.md.
 * The result depends on neither slices nor machine. Firmware that does not call it links none of it.
 */
#ifndef EMA_TREND_H
#define EMA_TREND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Readings that are kept, joined ones as one; fewest of a forecast; wear laws of it; instants that it looks at. */
#define EMA_TREND_KNOTS 48U
#define EMA_TREND_READINGS_MIN 6U
#define EMA_FORECAST_LAWS 2104U
#define EMA_FORECAST_TIMES 80U

/* Version of the saved bytes, and their number. */
#define EMA_TREND_VERSION 1U
#define EMA_TREND_BYTES 612U

/* Largest size of a time; of a shift, of its standard error and of a limit; least size of the last two. */
#define EMA_TREND_DAYS_MAX EMA_R(1.0e6)
#define EMA_TREND_PERCENT_MAX EMA_R(1.0e4)
#define EMA_TREND_STD_MIN_PERCENT EMA_R(1.0e-3)
#define EMA_TREND_LIMIT_MIN_PERCENT EMA_R(0.1)

/* Why a call is refused, and what is wrong; zero is success, and after any other nothing has changed. */
/* EMA-D1 */
#define EMA_TREND_STATUS_LIST(X)                                                                                       \
    X(EMA_TREND_OK, 0, "ok")                                                                                           \
    X(EMA_TREND_NULL, 1, "a required pointer is null")                                                                 \
    X(EMA_TREND_STALE, 2, "the structure was never started, or is damaged: start or restore it")                       \
    X(EMA_TREND_TIME, 3, "time_days is NaN, infinite or too large")                                                    \
    X(EMA_TREND_TIME_BACK, 4, "time_days lies before the last reading's")                                              \
    X(EMA_TREND_VALUE, 5, "value_percent is NaN, infinite or too large")                                               \
    X(EMA_TREND_STD, 6, "std_percent is below 0.001, NaN, infinite or too large")                                      \
    X(EMA_TREND_LIMIT, 7, "limit_percent is smaller than 0.1, NaN, infinite or too large")                             \
    X(EMA_TREND_FALSE_ALARM, 8, "false_alarm_ratio is not within 1e-6 .. 0.5")                                         \
    X(EMA_TREND_FEW, 9, "there are too few readings, or all are of one time")                                          \
    X(EMA_TREND_CHANGED, 10, "the trend took a reading since the forecast was started: start it anew")                 \
    X(EMA_TREND_UNFINISHED, 11, "the forecast has laws left: run it on")                                               \
    X(EMA_TREND_SHORT, 12, "too few bytes: nothing was saved there, or it is cut off")                                 \
    X(EMA_TREND_MAGIC, 13, "the bytes do not begin as a saved trend")                                                  \
    X(EMA_TREND_UNKNOWN_VERSION, 14, "the bytes are of another version than this module reads")                        \
    X(EMA_TREND_LENGTH, 15, "the bytes state another length than a saved trend has")                                   \
    X(EMA_TREND_CHECKSUM, 16, "the checksum of the bytes is another: they are damaged")                                \
    X(EMA_TREND_IDENTITY, 17, "the bytes are of another unit, configuration or value")                                 \
    X(EMA_TREND_LAYOUT, 18, "the bytes hold numbers that no trend has")

typedef enum {
#define EMA_TREND_ENUM(name, value, text) name = (value), /* EMA-D1 */
    EMA_TREND_STATUS_LIST(EMA_TREND_ENUM)
#undef EMA_TREND_ENUM
} ema_trend_status_t;

/* What one ground test says of one value. */
typedef struct {
    ema_real time_days;     /* of any beginning; or flight hours or cycles: then all of this header is in them */
    ema_real value_percent; /* shift of the value, of the healthy one */
    ema_real std_percent;   /* its standard error: half of its 95 % interval over 1.96 */
} ema_reading_t;

/* All that is kept of a value. A copy is a checkpoint. */
typedef struct {
    uint32_t mark;     /* of a started one */
    uint32_t identity; /* what it is of, as the caller says */
    uint32_t readings; /* taken so far */
    uint32_t count;    /* knots that hold them */
    ema_real first_days;
    ema_real last_days;
    ema_real scatter_ratio;              /* square of what readings scatter by, over what they state */
    ema_reading_t knot[EMA_TREND_KNOTS]; /* times after the first reading's */
} ema_trend_t;

typedef struct {
    ema_real limit_percent;     /* shift at which the unit is taken out of service; below zero for a value that falls */
    ema_real false_alarm_ratio; /* of units that do not wear, those that may be said to drift at one look */
} ema_trend_config_t;

/* A time until the limit is reached; an open one lies beyond `days`, and nothing is known of how far. */
typedef struct {
    ema_real days;
    bool open;
} ema_time_left_t;

typedef struct {
    bool drifts;                   /* at the stated false-alarm rate: what is below has no meaning without it */
    bool towards;                  /* and it is the limit that it drifts towards */
    ema_real odds_log;             /* logarithm of how much likelier the readings are with a drift; -80 .. 80 */
    ema_real now_percent;          /* shift at the last reading, by all of them, and its standard error */
    ema_real now_std_percent;      /* */
    ema_real by_percent;           /* how much of it wear has come to by its trend */
    ema_real rate_percent_per_day; /* trend at the last reading, and its standard error */
    ema_real rate_std_percent_per_day;
    ema_time_left_t low;    /* 5 % */
    ema_time_left_t median; /* 50 % */
    ema_time_left_t high;   /* 95 %: low .. high holds the time with 90 % */
    ema_real reached_ratio; /* probability that the limit is reached within what is looked ahead */
    ema_real ahead_days;    /* which is twenty times the time since the first reading */
} ema_outlook_t;

/* Memory of one forecast, under 1 KiB; one serves all trends, one after the other. */
typedef struct {
    const ema_trend_t* trend;
    uint32_t mark;
    uint32_t readings;
    uint32_t law; /* next one */
    ema_trend_config_t config;
    ema_real age_days;
    ema_real newest_std_percent[2]; /* of the readings that have too few behind them yet */
    ema_real top_log;               /* best evidence so far, of all laws and of those that wear */
    ema_real best_log;
    ema_real still; /* evidence of no wear, and of wear, over the best */
    ema_real wears;
    ema_real weight_sum;
    ema_real stalled_sum; /* of those that are stalled now, and of these times how long they have been */
    ema_real stalled_for;
    ema_real now; /* the limit being 1: mean of the value and sum of its squares about it, sum of wear, the rate's */
    ema_real now_square;
    ema_real by;
    ema_real rate;
    ema_real rate_square;
    ema_real going[EMA_FORECAST_TIMES];   /* share that has reached the limit, where wear goes on now */
    ema_real stalled[EMA_FORECAST_TIMES]; /* and where it is stalled */
} ema_forecast_t;

/* Starts an empty trend. `identity`: what it is of, which ema_trend_restore asks for: ema_actuator_identity of the
 * healthy configuration with the value's number, since shifts from another healthy value are no history of this one.
 * Errors: EMA_TREND_NULL. */
ema_trend_status_t ema_trend_init(ema_trend_t* trend, uint32_t identity);

/* Takes the reading of one ground test; the time may be the last one's. Readings of an undecided verdict whose residual
 * is not explained do not belong here. A reading far off its neighbours counts less, once two later ones say so.
 * Errors, in this order, nothing changed: EMA_TREND_NULL, EMA_TREND_STALE, EMA_TREND_TIME, EMA_TREND_VALUE,
 * EMA_TREND_STD, EMA_TREND_TIME_BACK. Cost: under two thousand instructions. */
ema_trend_status_t ema_trend_update(ema_trend_t* trend, const ema_reading_t* reading);

/* Begins a forecast from the last reading on. `trend` must outlive it; `config` is copied. Errors, nothing changed:
 * EMA_TREND_NULL, EMA_TREND_STALE, EMA_TREND_LIMIT, EMA_TREND_FALSE_ALARM, EMA_TREND_FEW. */
ema_trend_status_t ema_forecast_start(ema_forecast_t* forecast, const ema_trend_t* trend,
                                      const ema_trend_config_t* config);

/* Works through the next `laws` laws; once done, a call does nothing. Errors, nothing changed: EMA_TREND_NULL,
 * EMA_TREND_STALE, EMA_TREND_CHANGED. Cost: under fifty thousand instructions a law with all knots: docs/BUDGETS.md.
 */
ema_trend_status_t ema_forecast_run(ema_forecast_t* forecast, uint32_t laws);

/* Whether all laws are through; of none or of one that was not started, true. */
bool ema_forecast_done(const ema_forecast_t* forecast);

/* What it says. Errors, `outlook` unchanged: EMA_TREND_NULL, EMA_TREND_STALE, EMA_TREND_UNFINISHED. Cost: that of some
 * ten laws. */
ema_trend_status_t ema_forecast_result(const ema_forecast_t* forecast, ema_outlook_t* outlook);

/* Puts a trend into bytes: the least byte first, reals as float32, a version, a checksum. What is restored of a float32
 * build continues bit for bit. Layout: docs/FIRMWARE.md. Errors, nothing changed: EMA_TREND_NULL, EMA_TREND_STALE.
 * Cost: some ten instructions a byte. */
ema_trend_status_t ema_trend_save(const ema_trend_t* trend, uint8_t bytes[EMA_TREND_BYTES]);

/* Reads it back from the first of `length` bytes. Errors, nothing changed: EMA_TREND_NULL, and EMA_TREND_SHORT to
 * EMA_TREND_LAYOUT in the order of the list; with any of them the history is lost, and a new one begins with
 * ema_trend_init. */
ema_trend_status_t ema_trend_restore(ema_trend_t* trend, uint32_t identity, const uint8_t* bytes, size_t length);

/* The text of a status, a constant string; "unknown status" for a value outside the list. */
const char* ema_trend_text(ema_trend_status_t status);

#ifdef __cplusplus
}
#endif

#endif
