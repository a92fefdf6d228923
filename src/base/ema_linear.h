/* Small symmetric positive systems. Matrices are held row by row; only the lower triangle is read and written. */
#ifndef EMA_LINEAR_H
#define EMA_LINEAR_H

#include <stdbool.h>
#include <stdint.h>

#include "ema/ema_real.h"

/* A pivot below this share of its diagonal means that the matrix is singular for our purpose. */
#define EMA_PIVOT_SHARE EMA_R(1.0e-5)

/* Cholesky factor in place; false, with the matrix spoilt, when it is not positive definite. Cost: size^3 / 6. */
bool ema_cholesky(ema_real* matrix, uint32_t size, uint32_t stride);

/* Solves L y = b and L' x = b in place. Cost: size^2 / 2. */
void ema_solve_lower(const ema_real* factor, uint32_t size, uint32_t stride, ema_real* b);
void ema_solve_upper(const ema_real* factor, uint32_t size, uint32_t stride, ema_real* b);

#endif
