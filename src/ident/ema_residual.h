/* Sums over the residual at an estimate, and what they say: whether neighbouring rows are alike, and how far estimates
 * may be off for it. ema_sensitivity.h says what is made of them. */
#ifndef EMA_RESIDUAL_H
#define EMA_RESIDUAL_H

#include "base/ema_math.h"
#include "ema/detail/ema_sensitivity.h"

/* A residual that repeats itself entirely would make the standard errors infinite. */
#define EMA_CORRELATION_MAX EMA_R(0.999)

/* Rows over which what lasts is told from noise: noise sums up to little over so many, and every motion lasts longer.
 */
#define EMA_BLOCK_ROWS 16U

/* Scatter of a measured correlation that white noise may show, in standard errors. */
#define EMA_CORRELATION_DOUBT EMA_R(3.0)

/* Part of a shared residual that may have been taken for a parameter. */
#define EMA_BIAS_SHARE EMA_R(0.35)

/* Adds the rod position's residual of row `row`. */
static inline void ema_residual_row(ema_residual_t* residual, ema_real residual_mm, uint32_t row)
{
    residual->position_square += residual_mm * residual_mm;
    residual->position_neighbours += residual_mm * residual->position_last_mm;
    residual->position_last_mm = residual_mm;
    residual->block_mm += residual_mm;
    if ((row % EMA_BLOCK_ROWS) == (EMA_BLOCK_ROWS - 1U)) {
        residual->block_square += residual->block_mm * residual->block_mm;
        residual->block_mm = EMA_R(0.0);
    }
}

/* Of neighbouring rows: 0 is white. */
static inline ema_real ema_residual_correlation(const ema_residual_t* residual)
{
    return (residual->position_square > EMA_R(0.0)) ? (residual->position_neighbours / residual->position_square)
                                                    : EMA_R(0.0);
}

/* Share of the residual's mean square that neighbouring rows have in common, above what white noise may show: by pairs,
 * or by blocks where it lasts. What the sensor's noise is known to share, `noise_mm` rms, is taken off. */
static inline ema_real ema_residual_shared(const ema_residual_t* residual, uint32_t row, ema_real correlation,
                                           ema_real noise_mm)
{
    const ema_real width = (ema_real)EMA_BLOCK_ROWS;
    const uint32_t whole_blocks = row / EMA_BLOCK_ROWS;
    const ema_real blocks = (ema_real)whole_blocks;
    const ema_real rows = (ema_real)row;
    ema_real shared = correlation - (EMA_CORRELATION_DOUBT / ema_sqrt(rows));
    if ((residual->position_square > EMA_R(0.0)) && (blocks > EMA_R(0.0))) {
        const ema_real white = (residual->position_square / rows) * (blocks * width);
        const ema_real doubt = EMA_CORRELATION_DOUBT * ema_sqrt(EMA_R(2.0) / blocks);
        shared = ema_max(shared, ((residual->block_square / white) - EMA_R(1.0) - doubt) / (width - EMA_R(1.0)));
    }
    if (noise_mm > EMA_R(0.0)) {
        shared -= (noise_mm * noise_mm) * (rows / residual->position_square);
    }
    return ema_clamp(shared, EMA_R(0.0), EMA_R(1.0));
}

/* Correlation by which the errors are widened. */
static inline ema_real ema_residual_widening(ema_real correlation)
{
    return ema_clamp(correlation, EMA_R(0.0), EMA_CORRELATION_MAX);
}

/* Mean square of the weighted residual over `freedom`, widened for what neighbours share. */
static inline ema_real ema_residual_variance(const ema_residual_t* residual, ema_real freedom, ema_real widen)
{
    return (residual->weighted_square / freedom) * ((EMA_R(1.0) + widen) / (EMA_R(1.0) - widen));
}

#endif
