/* The step of a damped least-squares search inside the unit box, in up to 8 dimensions, and which coordinates the sums
 * tell apart. It knows sums of products, nothing of actuators.
 *
 * Step s from the point x: (N + lambda diag N) s = g with N = J'J and g = J'r, r measured minus simulated (Levenberg,
 * Quart. Appl. Math. 2, 1944; the damping by the diagonal is Marquardt's, J. SIAM 11, 1963). A coordinate at a bound
 * whose gradient points outside stays there; one that the step would take outside goes to its bound, and the others are
 * solved for again with it there (active set, at most one round for each coordinate).
 *
 * N is a lower triangle, row after row: element (i, j), j <= i, stands at i (i + 1) / 2 + j. A coordinate whose element
 * on the diagonal is not above zero, or no finite number, has no sensitivities: it is left where it is.
 */
#ifndef EMA_LEVMAR_H
#define EMA_LEVMAR_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EMA_LEVMAR_MAX 8U

/* Elements of a triangle of that many coordinates. */
#define EMA_LEVMAR_TRIANGLE(size) (((size) * ((size) + 1U)) / 2U)

/* Least damping: with it the system is never singular for the solver. */
#define EMA_DAMPING_MIN EMA_R(1.0e-4)

/* Memory of a solution: it means nothing between two calls. */
typedef struct {
    ema_real matrix[EMA_LEVMAR_TRIANGLE(EMA_LEVMAR_MAX)];
    ema_real right[EMA_LEVMAR_MAX];
    ema_real length[EMA_LEVMAR_MAX];
    uint32_t place[EMA_LEVMAR_MAX];
    bool open[EMA_LEVMAR_MAX]; /* may move */
} ema_levmar_t;

/* How well one coordinate is told from the others. */
typedef struct {
    ema_real length;  /* of its sensitivities; 0 where it has none */
    ema_real share;   /* squared, of them, that no other coordinate makes: 1 minus the coefficient of determination */
    uint32_t partner; /* the coordinate that makes the largest part of the rest; itself where there is none */
} ema_collinearity_t;

/* Writes the step from `x` and returns by how much the linear model lets the sum of squares fall. `x` is
 * `size` coordinates in [0, 1]; x + step is in the box but for rounding. `damping` is at
 * least EMA_DAMPING_MIN; with less the step may be none. No address may be NULL. Cost: at most 1 + size Cholesky
 * solutions. */
ema_real ema_levmar_step(const ema_real* normal, const ema_real* gradient, const ema_real* x, uint32_t size,
                         ema_real damping, ema_levmar_t* memory, ema_real* step);

/* How well coordinate `which` is told from the others. Cost: one Cholesky factor. */
ema_collinearity_t ema_levmar_collinearity(const ema_real* normal, uint32_t size, uint32_t which);

#ifdef __cplusplus
}
#endif

#endif
