/* Small symmetric positive systems. Only the lower triangle is held, row after row: element (i, j), j <= i, stands at i
 * (i + 1) / 2 + j. */
#ifndef EMA_LINEAR_H
#define EMA_LINEAR_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"

/* A pivot below this share of its diagonal means that the matrix is singular for our purpose. */
#define EMA_PIVOT_SHARE EMA_R(1.0e-5)

/* Place of the first element of row i: also the number of elements of a triangle of that size. */
#define EMA_TRIANGLE(i) (((i) * ((i) + 1U)) / 2U)

/* Cholesky factor in place; false, with the matrix spoilt, when it is not positive definite. Cost: size^3 / 6. */
bool ema_cholesky(ema_real* matrix, uint32_t size);

/* Solves L y = b and L' x = b in place. Cost: size^2 / 2. */
void ema_solve_lower(const ema_real* factor, uint32_t size, ema_real* b);
void ema_solve_upper(const ema_real* factor, uint32_t size, ema_real* b);

/* Both, one after the other: solves A x = b by the factor of A. */
void ema_solve(const ema_real* factor, uint32_t size, ema_real* b);

#endif
