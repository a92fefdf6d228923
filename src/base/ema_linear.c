#include "ema_linear.h"

#include "ema_math.h"

bool ema_cholesky(ema_real* matrix, uint32_t size, uint32_t stride)
{
    for (uint32_t i = 0; i < size; ++i) {
        const ema_real diagonal = matrix[(i * stride) + i];
        for (uint32_t j = 0; j <= i; ++j) {
            ema_real sum = matrix[(i * stride) + j];
            for (uint32_t k = 0; k < j; ++k) {
                sum -= matrix[(i * stride) + k] * matrix[(j * stride) + k];
            }
            if (i == j) {
                if (!(sum > (EMA_PIVOT_SHARE * diagonal))) {
                    return false;
                }
                matrix[(i * stride) + i] = ema_sqrt(sum);
            } else {
                matrix[(i * stride) + j] = sum / matrix[(j * stride) + j];
            }
        }
    }
    return true;
}

void ema_solve_lower(const ema_real* factor, uint32_t size, uint32_t stride, ema_real* b)
{
    for (uint32_t i = 0; i < size; ++i) {
        for (uint32_t k = 0; k < i; ++k) {
            b[i] -= factor[(i * stride) + k] * b[k];
        }
        b[i] /= factor[(i * stride) + i];
    }
}

void ema_solve_upper(const ema_real* factor, uint32_t size, uint32_t stride, ema_real* b)
{
    for (uint32_t i = size; i > 0U; --i) {
        for (uint32_t k = i; k < size; ++k) {
            b[i - 1U] -= factor[(k * stride) + (i - 1U)] * b[k];
        }
        b[i - 1U] /= factor[((i - 1U) * stride) + (i - 1U)];
    }
}
