/* PCG32, the annealer's own random numbers: 64-bit state, 32-bit output, same numbers on every machine.
 *
 * Source: M. E. O'Neill, PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number
 * Generation, HMC-CS-2014-0905 (2014), variant XSH-RR 64/32. Cost of a draw: one 64-bit multiplication. Memory: 16
 * bytes.
 */
#ifndef EMA_RANDOM_H
#define EMA_RANDOM_H

#include <stdint.h>

#include "ema/detail/ema_real.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint64_t state;
    uint64_t increment; /* odd */
} ema_random_t;

/* Starts the numbers of `seed` on `stream`; streams do not overlap. */
void ema_random_init(ema_random_t* random, uint64_t seed, uint64_t stream);

/* The next 32 random bits. */
uint32_t ema_random_u32(ema_random_t* random);

/* Uniform in the open interval (0, 1): never 0 and never 1, so that its logarithm is finite. 23 bits. */
ema_real ema_random_uniform(ema_random_t* random);

/* Standard normal by the sum of twelve uniforms minus six: mean 0, variance 1, |x| < 6, no transcendental. */
ema_real ema_random_normal(ema_random_t* random);

#ifdef __cplusplus
}
#endif

#endif
