/* Apart from ema_least_squares.c so that what is asked once takes no stack from the runs. */
#include <stddef.h>

#include "base/ema_copy.h"
#include "base/ema_linear.h"
#include "base/ema_math.h"
#include "ident/ema_least_squares_check.h"
#include "ident/ema_residual.h"

/* An estimate this close to a bound, as a share of the bounds, lies on it. */
#define EMA_AT_BOUND_SHARE EMA_R(5.0e-4)

/* Standard errors that a value may have, as a share of its bounds, so that its 95 % interval is shorter than half of
 * them. */
#define EMA_DETERMINED_SHARE EMA_R(0.1275)

/* Squared rounding of a sensitivity, over that of a signal, at the most: two runs are rounded, each by about half a
 * unit in the last place of what it shows and of what it adds up. Measured, of values that do the same in exact
 * numbers. */
#define EMA_SLOPE_ROUNDED EMA_R(64.0)

/* Share of value `k`'s sensitivities that may be rounding. */
static ema_real ema_collinearity_rounded(const ema_squares_point_t* point, uint32_t k, ema_real length)
{
    const ema_real moved = point->reach[k] * length;
    const ema_real rounded = (EMA_SLOPE_ROUNDED * EMA_REAL_EPSILON * EMA_REAL_EPSILON) * point->size_square;
    return (moved > EMA_R(0.0)) ? (rounded / (moved * moved)) : EMA_R(1.0);
}

/* Standard error for a variance of one, as a share of the bounds. */
static ema_real ema_collinearity_error(const ema_collinearity_t* apart, ema_real rounded)
{
    const bool told = (apart->length > EMA_R(0.0)) && (apart->share > ema_max(rounded, EMA_PIVOT_SHARE));
    return told ? (EMA_R(1.0) / (apart->length * ema_sqrt(apart->share))) : EMA_COST_MAX;
}

static ema_determined_t ema_collinearity_determined(const ema_collinearity_t* apart, ema_real error)
{
    ema_determined_t determined = EMA_DETERMINED;
    if (!((apart->length * EMA_DETERMINED_SHARE) >= EMA_R(1.0))) {
        determined = EMA_DETERMINED_NOT;
    } else if (!(error <= EMA_DETERMINED_SHARE)) {
        determined = EMA_DETERMINED_TOGETHER;
    } else {
        /* by itself */
    }
    return determined;
}

ema_status_t ema_least_squares_result(const ema_least_squares_t* self, ema_least_squares_result_t* result)
{
    if ((self == NULL) || (result == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!self->known) {
        return (self->phase == EMA_SQUARES_DONE) ? EMA_ERR_DIVERGED : EMA_ERR_ORDER;
    }
    const ema_squares_point_t* const best = &self->best;
    const uint32_t rows = self->cursor.rows;
    const ema_real freedom = ema_squares_freedom(self);
    ema_clear(result, sizeof *result);
    result->count = self->config->count;
    result->misfit_before = ema_sqrt(self->first_square / freedom);
    result->misfit_after = ema_sqrt(best->square / freedom);
    result->residual_rms_mm = ema_sqrt(best->residual.position_square / (ema_real)rows);
    result->residual_correlation = ema_residual_correlation(&best->residual);
    result->outside_ratio = best->outside_ratio;
    result->crossed = best->pushed[0] && best->pushed[1];
    result->adequate = ema_squares_adequate(self);
    result->runs = self->runs;
    result->starts = self->starts;
    result->model_steps = self->model_steps;
    result->outcome = self->outcome;
    const ema_real variance =
        ema_residual_variance(&best->residual, freedom, ema_residual_widening(result->residual_correlation));
    const ema_real shared =
        ema_residual_shared(&best->residual, rows, result->residual_correlation, EMA_R(0.0)) * best->square;
    for (uint32_t k = 0; k < result->count; ++k) {
        const ema_searched_t* const searched = &self->config->searched[k];
        const ema_collinearity_t apart = ema_levmar_collinearity(best->normal, result->count, k);
        const ema_real range = searched->upper - searched->lower;
        const ema_real error = ema_collinearity_error(&apart, ema_collinearity_rounded(best, k, apart.length));
        ema_found_t* const found = &result->value[k];
        found->estimate = ema_searched_at(searched, best->x[k]);
        found->determined = ema_collinearity_determined(&apart, error);
        found->partner = apart.partner;
        found->at_bound = (best->x[k] < EMA_AT_BOUND_SHARE) || (best->x[k] > (EMA_R(1.0) - EMA_AT_BOUND_SHARE));
        found->noise_std = (error < EMA_COST_MAX) ? (error * range) : EMA_COST_MAX;
        found->std = (error < EMA_COST_MAX) ? (error * ema_sqrt(variance) * range) : EMA_COST_MAX;
        found->bias = (error < EMA_COST_MAX) ? (EMA_BIAS_SHARE * error * ema_sqrt(shared) * range) : EMA_COST_MAX;
    }
    return EMA_OK;
}
