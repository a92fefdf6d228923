#include "ema/detail/ema_random.h"

#define EMA_PCG_MULTIPLIER UINT64_C(6364136223846793005)

uint32_t ema_random_u32(ema_random_t* random)
{
    const uint64_t old = random->state;
    random->state = (old * EMA_PCG_MULTIPLIER) + random->increment;
    const uint32_t mixed = (uint32_t)(((old >> 18U) ^ old) >> 27U);
    const uint32_t turn = (uint32_t)(old >> 59U);
    return (mixed >> turn) | (mixed << ((32U - turn) & 31U));
}

void ema_random_init(ema_random_t* random, uint64_t seed, uint64_t stream)
{
    random->state = 0U;
    random->increment = (stream << 1U) | 1U;
    (void)ema_random_u32(random);
    random->state += seed;
    (void)ema_random_u32(random);
}

ema_real ema_random_uniform(ema_random_t* random)
{
    const uint32_t bits = ema_random_u32(random) >> 9U;
    return ((ema_real)bits + EMA_R(0.5)) * EMA_R(1.1920928955078125e-7);
}

ema_real ema_random_normal(ema_random_t* random)
{
    ema_real sum = EMA_R(-6.0);
    for (uint32_t k = 0; k < 12U; ++k) {
        sum += ema_random_uniform(random);
    }
    return sum;
}
