/* A quadratic through the best points of a search: full up to 4 dimensions, separable above. */
#ifndef EMA_QUADRATIC_H
#define EMA_QUADRATIC_H

#include "ema/detail/ema_annealer.h"

/* Number of unknowns in `dimension` dimensions; a fit wants somewhat more points. */
uint32_t ema_quadratic_unknowns(uint32_t dimension);

/* Fits; `quadratic` may be the annealer's own. False when the points do not determine a quadratic with a minimum near
 * them. Cost: one Cholesky solution. */
bool ema_quadratic_fit(ema_quadratic_t* quadratic, const ema_annealer_t* annealer);

/* Draws from exp(-quadratic / temperature): normal around the minimum. A draw outside the box is moved into it, to
 * where the quadratic rises least above it. Writes `dimension` numbers in [0, 1]. Cost: dimension^2, four times that
 * outside. */
void ema_quadratic_draw(const ema_quadratic_t* quadratic, const ema_annealer_t* annealer, ema_random_t* random,
                        ema_real* x);

#endif
