#include "base/ema_linear.h"

#include "base/ema_math.h"

bool ema_cholesky(ema_real* matrix, uint32_t size)
{
    ema_real* row = matrix;
    for (uint32_t i = 0; i < size; ++i) {
        const ema_real diagonal = row[i];
        const ema_real* above = matrix;
        for (uint32_t j = 0; j <= i; ++j) {
            ema_real sum = row[j];
            for (uint32_t k = 0; k < j; ++k) {
                sum -= row[k] * above[k];
            }
            if (i == j) {
                if (!(sum > (EMA_PIVOT_SHARE * diagonal))) {
                    return false;
                }
                row[i] = ema_sqrt(sum);
            } else {
                row[j] = sum / above[j];
            }
            above = &above[j + 1U];
        }
        row = &row[i + 1U];
    }
    return true;
}

void ema_solve_lower(const ema_real* factor, uint32_t size, ema_real* b)
{
    const ema_real* row = factor;
    for (uint32_t i = 0; i < size; ++i) {
        for (uint32_t k = 0; k < i; ++k) {
            b[i] -= row[k] * b[k];
        }
        b[i] /= row[i];
        row = &row[i + 1U];
    }
}

void ema_solve_upper(const ema_real* factor, uint32_t size, ema_real* b)
{
    for (uint32_t i = size; i > 0U; --i) {
        for (uint32_t k = i; k < size; ++k) {
            b[i - 1U] -= factor[EMA_TRIANGLE(k) + (i - 1U)] * b[k];
        }
        b[i - 1U] /= factor[EMA_TRIANGLE(i - 1U) + (i - 1U)];
    }
}

void ema_solve(const ema_real* factor, uint32_t size, ema_real* b)
{
    ema_solve_lower(factor, size, b);
    ema_solve_upper(factor, size, b);
}
