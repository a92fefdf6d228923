#include "search/ema_quadratic.h"

#include "base/ema_copy.h"
#include "base/ema_linear.h"
#include "base/ema_math.h"

#define EMA_FULL_DIMENSION_MAX 4U

/* Tries to bend a saddle into a bowl: none, then 1 % of the largest curvature times 5 each time. */
#define EMA_LIFTS 5U

/* Rounds over the coordinates in which a point outside the box finds its place in it: two coordinates need one. */
#define EMA_FOLDS 4U

/* How far from the best point, in spreads of the points, a minimum is believed. */
#define EMA_REACH EMA_R(3.0)

/* Share of the costs' spread that is added to every cost's distance from the best: keeps the weight of the best points
 * finite. */
#define EMA_WEIGHT_FLOOR EMA_R(0.02)

uint32_t ema_quadratic_unknowns(uint32_t dimension)
{
    return (dimension <= EMA_FULL_DIMENSION_MAX) ? (((dimension + 1U) * (dimension + 2U)) / 2U)
                                                 : ((2U * dimension) + 1U);
}

/* Terms of the quadratic at z: 1, z_i, then products; z stands in its places already. */
static void ema_quadratic_terms(uint32_t dimension, ema_real* terms)
{
    const ema_real* const z = &terms[1];
    uint32_t at = 1U + dimension;
    terms[0] = EMA_R(1.0);
    for (uint32_t i = 0; i < dimension; ++i) {
        const uint32_t last = (dimension <= EMA_FULL_DIMENSION_MAX) ? dimension : (i + 1U);
        for (uint32_t j = i; j < last; ++j) {
            terms[at] = z[i] * z[j];
            ++at;
        }
    }
}

/* Cholesky factor of the curvature, which is bent upwards as little as makes it a bowl. */
static bool ema_curvature_factor(ema_quadratic_t* quadratic, uint32_t dimension)
{
    ema_real most = EMA_R(0.0);
    for (uint32_t i = 0; i < EMA_TRIANGLE(dimension); ++i) {
        most = ema_max(most, ema_abs(quadratic->factor[i]));
    }
    ema_real lift = EMA_R(0.0);
    bool bowl = false;
    for (uint32_t k = 0; (k < EMA_LIFTS) && !bowl; ++k) {
        /* the equations are solved by now: their memory takes the trial */
        ema_real* const trial = quadratic->normal;
        for (uint32_t i = 0; i < EMA_TRIANGLE(dimension); ++i) {
            trial[i] = quadratic->factor[i];
        }
        for (uint32_t i = 0; i < dimension; ++i) {
            trial[EMA_TRIANGLE(i) + i] += lift;
        }
        bowl = ema_cholesky(trial, dimension);
        for (uint32_t i = 0; bowl && (i < EMA_TRIANGLE(dimension)); ++i) {
            quadratic->factor[i] = trial[i];
        }
        lift = (k == 0U) ? (EMA_R(0.01) * most) : (EMA_R(5.0) * lift);
    }
    return bowl;
}

bool ema_quadratic_fit(ema_quadratic_t* quadratic, const ema_annealer_t* annealer)
{
    const uint32_t dimension = annealer->config.dimension;
    const uint32_t unknowns = ema_quadratic_unknowns(dimension);
    if (annealer->point_count < (unknowns + 1U)) {
        return false;
    }
    const ema_annealer_point_t* const best = &annealer->best;
    ema_real spread = EMA_R(0.0);
    ema_clear(quadratic, sizeof *quadratic);
    for (uint32_t p = 0; p < annealer->point_count; ++p) {
        spread = ema_max(spread, annealer->points[p].cost - best->cost);
        for (uint32_t i = 0; i < dimension; ++i) {
            quadratic->scale[i] = ema_max(quadratic->scale[i], ema_abs(annealer->points[p].x[i] - best->x[i]));
        }
    }
    bool spans = spread > EMA_R(0.0);
    for (uint32_t i = 0; i < dimension; ++i) {
        spans = spans && (quadratic->scale[i] > EMA_R(0.0));
    }
    if (!spans) {
        return false;
    }

    ema_real* const normal = quadratic->normal;
    ema_real* const right = quadratic->right;
    for (uint32_t p = 0; p < annealer->point_count; ++p) {
        ema_real terms[EMA_ANNEALER_UNKNOWNS_MAX];
        for (uint32_t i = 0; i < dimension; ++i) {
            terms[1U + i] = (annealer->points[p].x[i] - best->x[i]) / quadratic->scale[i];
        }
        ema_quadratic_terms(dimension, terms);
        const ema_real above = (annealer->points[p].cost - best->cost) / spread;
        const ema_real weight = EMA_R(1.0) / (above + EMA_WEIGHT_FLOOR);
        const ema_real square = weight * weight;
        ema_real* element = normal;
        for (uint32_t a = 0; a < unknowns; ++a) {
            right[a] += square * terms[a] * above;
            for (uint32_t b = 0; b <= a; ++b) {
                *element += square * terms[a] * terms[b];
                ++element;
            }
        }
    }
    if (!ema_cholesky(normal, unknowns)) {
        return false;
    }
    ema_solve(normal, unknowns, right);

    /* curvature in units of the cost */
    uint32_t at = 1U + dimension;
    for (uint32_t i = 0; i < dimension; ++i) {
        const uint32_t last = (dimension <= EMA_FULL_DIMENSION_MAX) ? dimension : (i + 1U);
        for (uint32_t j = i; j < last; ++j) {
            quadratic->factor[EMA_TRIANGLE(j) + i] = right[at] * spread * ((i == j) ? EMA_R(2.0) : EMA_R(1.0));
            ++at;
        }
    }
    if (!ema_curvature_factor(quadratic, dimension)) {
        return false;
    }
    for (uint32_t i = 0; i < dimension; ++i) {
        quadratic->lowest[i] = -right[1U + i] * spread;
    }
    ema_solve(quadratic->factor, dimension, quadratic->lowest);
    /* a minimum beyond the reach is approached along its direction */
    ema_real far = EMA_REACH;
    for (uint32_t i = 0; i < dimension; ++i) {
        far = ema_max(far, ema_abs(quadratic->lowest[i]));
    }
    for (uint32_t i = 0; i < dimension; ++i) {
        quadratic->lowest[i] *= EMA_REACH / far;
    }
    return true;
}

/* Moves `z` into the box, within reach, to where the quadratic's curvature alone rises least: a coordinate that is held
 * at its bound moves the others along. One inside stays. */
static void ema_quadratic_fold(const ema_quadratic_t* quadratic, const ema_real* best, uint32_t dimension, ema_real* z)
{
    ema_real pull[EMA_ANNEALER_DIMENSION_MAX]; /* the factor's transpose times how far z was moved */
    ema_clear(pull, sizeof pull);
    for (uint32_t k = 0; k < EMA_FOLDS; ++k) {
        const ema_real* row = quadratic->factor;
        for (uint32_t i = 0; i < dimension; ++i) {
            ema_real slope = EMA_R(0.0);
            ema_real curvature = EMA_R(0.0);
            for (uint32_t j = 0; j <= i; ++j) {
                slope += row[j] * pull[j];
                curvature += row[j] * row[j];
            }
            /* the best point, at zero, is within reach and inside: what is cut to both in turn is in both */
            const ema_real lowest = quadratic->lowest[i];
            const ema_real near = ema_clamp(z[i] - (slope / curvature), lowest - EMA_REACH, lowest + EMA_REACH);
            const ema_real scale = quadratic->scale[i];
            const ema_real moved = ema_clamp(near, -best[i] / scale, (EMA_R(1.0) - best[i]) / scale) - z[i];
            z[i] += moved;
            for (uint32_t j = 0; j <= i; ++j) {
                pull[j] += row[j] * moved;
            }
            row = &row[i + 1U];
        }
    }
}

void ema_quadratic_draw(const ema_quadratic_t* quadratic, const ema_annealer_t* annealer, ema_random_t* random,
                        ema_real* x)
{
    const uint32_t dimension = annealer->config.dimension;
    const ema_real width = ema_sqrt(annealer->temperature);
    ema_real z[EMA_ANNEALER_DIMENSION_MAX];
    for (uint32_t i = 0; i < dimension; ++i) {
        z[i] = width * ema_random_normal(random);
    }
    ema_solve_upper(quadratic->factor, dimension, z);
    for (uint32_t i = 0; i < dimension; ++i) {
        /* a draw wider than the points themselves would leave the region where the quadratic holds */
        z[i] = quadratic->lowest[i] + ema_clamp(z[i], -EMA_REACH, EMA_REACH);
    }
    ema_quadratic_fold(quadratic, annealer->best.x, dimension, z);
    for (uint32_t i = 0; i < dimension; ++i) {
        x[i] = ema_clamp(annealer->best.x[i] + (quadratic->scale[i] * z[i]), EMA_R(0.0), EMA_R(1.0));
    }
}
