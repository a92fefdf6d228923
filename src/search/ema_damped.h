/* The step of a damped least-squares search inside the unit box, and which values the sums can tell apart.
 *
 * Step s from the point x: (N + lambda diag N) s = g with N = J'J and g = J'r, r measured minus simulated (Levenberg,
 * Quart. Appl. Math. 2, 1944; the damping by the diagonal is Marquardt's, J. SIAM 11, 1963). A coordinate at a bound
 * whose gradient points outside stays there; one that the step would take outside goes to its bound, and the others are
 * solved for again with it there (active set, at most one round for each coordinate).
 */
#ifndef EMA_DAMPED_H
#define EMA_DAMPED_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/ema_real.h"

/* Coordinates at the most. */
#define EMA_DAMPED_MAX 8U

/* Least damping: with it the system is never singular for the solver. */
#define EMA_DAMPING_MIN EMA_R(1.0e-4)

/* What a step promises. */
typedef struct {
    ema_real fall; /* of the sum of squares, by the linear model */
    ema_real open; /* sum of what each coordinate that may move would gain alone: zero at the lowest point */
} ema_promise_t;

/* How well one coordinate is told from the others. */
typedef struct {
    ema_real length;  /* of its own sensitivities; 0 where there are none, or they are no finite numbers */
    ema_real share;   /* squared, of them, that no other coordinate makes: 1 minus the coefficient of determination */
    uint32_t partner; /* the coordinate that makes the largest part of the rest; itself where there is none */
} ema_apart_t;

/* Writes the step from `x`, `size` coordinates in [0, 1]; x + step is in the box. `normal` is a triangle as in
 * ema_linear.h, `damping` at least EMA_DAMPING_MIN. Cost: at most 1 + size Cholesky solutions. */
ema_promise_t ema_damped_step(const ema_real* normal, const ema_real* gradient, const ema_real* x, uint32_t size,
                              ema_real damping, ema_real* step);

/* How well coordinate `which` is told from the others. Cost: one Cholesky factor. */
ema_apart_t ema_damped_apart(const ema_real* normal, uint32_t size, uint32_t which);

#endif
