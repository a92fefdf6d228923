#include "trend/ema_wear_filter.h"

#include <stdint.h>

#include "base/ema_math.h"

/* Variances before any reading, the limit being 1: of the level 0.2, of the rate over the time since the first reading
 * 0.4, of the fading part 0.2, squared. */
static const ema_real ema_wear_before[EMA_WEAR_STATES] = {EMA_R(0.04), EMA_R(0.16), EMA_R(0.04)};

void ema_wear_begin(ema_wear_t* wear)
{
    for (uint32_t k = 0U; k < EMA_WEAR_STATES; ++k) {
        wear->mean[k] = EMA_R(0.0);
        wear->upper[k] = EMA_R(0.0);
        wear->diagonal[k] = ema_wear_before[k];
    }
    wear->evidence_log = EMA_R(0.0);
}

void ema_wear_walk(ema_wear_t* wear, ema_real variance)
{
    wear->diagonal[0] += variance;
}

/* U' times the row. */
static void ema_wear_turned(const ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES],
                            ema_real turned[EMA_WEAR_STATES])
{
    turned[0] = row[0];
    turned[1] = row[1] + (wear->upper[0] * row[0]);
    turned[2] = row[2] + (wear->upper[1] * row[0]) + (wear->upper[2] * row[1]);
}

ema_real ema_wear_mean(const ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES])
{
    return (row[0] * wear->mean[0]) + (row[1] * wear->mean[1]) + (row[2] * wear->mean[2]);
}

ema_real ema_wear_variance(const ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES])
{
    ema_real turned[EMA_WEAR_STATES];
    ema_wear_turned(wear, row, turned);
    return (wear->diagonal[0] * turned[0] * turned[0]) + (wear->diagonal[1] * turned[1] * turned[1])
           + (wear->diagonal[2] * turned[2] * turned[2]);
}

void ema_wear_take(ema_wear_t* wear, const ema_real row[EMA_WEAR_STATES], ema_real value, ema_real variance)
{
    ema_real turned[EMA_WEAR_STATES];
    ema_wear_turned(wear, row, turned);
    const ema_real off = value - ema_wear_mean(wear, row);
    const ema_real first = wear->diagonal[0] * turned[0];
    const ema_real second = wear->diagonal[1] * turned[1];
    const ema_real third = wear->diagonal[2] * turned[2];
    /* variance of what is foretold, one state after the other */
    const ema_real sum0 = variance + (turned[0] * first);
    const ema_real sum1 = sum0 + (turned[1] * second);
    const ema_real sum2 = sum1 + (turned[2] * third);
    const ema_real by1 = -turned[1] / sum0;
    const ema_real by2 = -turned[2] / sum1;
    const ema_real old01 = wear->upper[0];
    const ema_real old02 = wear->upper[1];
    const ema_real old12 = wear->upper[2];
    const ema_real gain0 = first + (second * old01);
    wear->upper[0] = old01 + (by1 * first);
    wear->upper[1] = old02 + (by2 * gain0);
    wear->upper[2] = old12 + (by2 * second);
    wear->diagonal[0] *= variance / sum0;
    wear->diagonal[1] *= sum0 / sum1;
    wear->diagonal[2] *= sum1 / sum2;
    const ema_real step = off / sum2;
    wear->mean[0] += (gain0 + (third * old02)) * step;
    wear->mean[1] += (second + (third * old12)) * step;
    wear->mean[2] += third * step;
    wear->evidence_log -= EMA_R(0.5) * ((off * step) + ema_log(sum2));
}
