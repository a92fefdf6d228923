#include "ema/detail/ema_levmar.h"

#include "base/ema_linear.h"
#include "base/ema_math.h"

/* Element (i, j) of a triangle. */
static ema_real ema_levmar_at(const ema_real* normal, uint32_t i, uint32_t j)
{
    return (i >= j) ? normal[EMA_TRIANGLE(i) + j] : normal[EMA_TRIANGLE(j) + i];
}

/* Length of a coordinate's sensitivities, zero where it is not of use. */
static ema_real ema_levmar_length(const ema_real* normal, uint32_t i)
{
    const ema_real square = normal[EMA_TRIANGLE(i) + i];
    return ((square > EMA_R(0.0)) && ema_is_finite(square)) ? ema_sqrt(square) : EMA_R(0.0);
}

/* The step of the coordinates that are open, the others where `step` has them. All in units of their lengths, which
 * are as different as the values' own. */
static void ema_levmar_solve(const ema_real* normal, const ema_real* gradient, uint32_t size, ema_real damping,
                             ema_levmar_t* memory, ema_real* step)
{
    uint32_t count = 0U;
    for (uint32_t i = 0; i < size; ++i) {
        if (memory->open[i]) {
            ema_real* const row = &memory->matrix[EMA_TRIANGLE(count)];
            ema_real sum = gradient[i];
            for (uint32_t j = 0; j < size; ++j) {
                /* a coordinate without sensitivities has no finite products either */
                if (!memory->open[j] && (step[j] != EMA_R(0.0))) {
                    sum -= ema_levmar_at(normal, i, j) * step[j];
                }
            }
            for (uint32_t k = 0; k < count; ++k) {
                const uint32_t j = memory->place[k];
                row[k] = ema_levmar_at(normal, i, j) / (memory->length[i] * memory->length[j]);
            }
            row[count] = EMA_R(1.0) + damping;
            memory->right[count] = sum / memory->length[i];
            memory->place[count] = i;
            ++count;
        }
    }
    const bool solved = ema_cholesky(memory->matrix, count);
    if (solved) {
        ema_solve(memory->matrix, count, memory->right);
    }
    for (uint32_t k = 0; k < count; ++k) {
        const uint32_t i = memory->place[k];
        step[i] = solved ? (memory->right[k] / memory->length[i]) : EMA_R(0.0);
    }
}

/* Puts coordinates that the step takes outside to their bounds; false when there were any. */
static bool ema_levmar_inside(const ema_real* x, uint32_t size, ema_levmar_t* memory, ema_real* step)
{
    bool inside = true;
    for (uint32_t i = 0; i < size; ++i) {
        const ema_real to = x[i] + step[i];
        if (memory->open[i] && ((to < EMA_R(0.0)) || (to > EMA_R(1.0)))) {
            step[i] = (to < EMA_R(0.0)) ? -x[i] : (EMA_R(1.0) - x[i]);
            memory->open[i] = false;
            inside = false;
        }
    }
    return inside;
}

ema_real ema_levmar_step(const ema_real* normal, const ema_real* gradient, const ema_real* x, uint32_t size,
                         ema_real damping, ema_levmar_t* memory, ema_real* step)
{
    ema_real fall = EMA_R(0.0);
    for (uint32_t i = 0; i < size; ++i) {
        const bool held = ((x[i] <= EMA_R(0.0)) && (gradient[i] < EMA_R(0.0)))
                          || ((x[i] >= EMA_R(1.0)) && (gradient[i] > EMA_R(0.0)));
        memory->length[i] = ema_levmar_length(normal, i);
        memory->open[i] = (memory->length[i] > EMA_R(0.0)) && ema_is_finite(gradient[i]) && !held;
        step[i] = EMA_R(0.0);
    }
    bool inside = false;
    /* every round but the last leaves fewer of them open */
    while (!inside) {
        ema_levmar_solve(normal, gradient, size, damping, memory, step);
        inside = ema_levmar_inside(x, size, memory, step);
    }
    for (uint32_t i = 0; i < size; ++i) {
        if (step[i] != EMA_R(0.0)) {
            ema_real made = EMA_R(0.0);
            for (uint32_t j = 0; j < size; ++j) {
                if (step[j] != EMA_R(0.0)) {
                    made += ema_levmar_at(normal, i, j) * step[j];
                }
            }
            fall += step[i] * ((EMA_R(2.0) * gradient[i]) - made);
        }
    }
    return fall;
}

/* The parts of a coordinate's sensitivities along those of `place`, whose Cholesky factor is given, in `along`; returns
 * the square of what is left of its unit length. */
static ema_real ema_levmar_rest(const ema_real* normal, const ema_real* factor, const uint32_t* place, uint32_t count,
                                uint32_t which, ema_real* along)
{
    const ema_real length = ema_levmar_length(normal, which);
    ema_real rest = EMA_R(1.0);
    for (uint32_t k = 0; k < count; ++k) {
        along[k] = ema_levmar_at(normal, which, place[k]) / (length * ema_levmar_length(normal, place[k]));
    }
    ema_solve_lower(factor, count, along);
    for (uint32_t k = 0; k < count; ++k) {
        rest -= along[k] * along[k];
    }
    return rest;
}

ema_collinearity_t ema_levmar_collinearity(const ema_real* normal, uint32_t size, uint32_t which)
{
    ema_collinearity_t apart = {ema_levmar_length(normal, which), EMA_R(1.0), which};
    ema_real factor[EMA_TRIANGLE(EMA_LEVMAR_MAX)];
    ema_real along[EMA_LEVMAR_MAX];
    uint32_t place[EMA_LEVMAR_MAX];
    uint32_t count = 0U;
    /* the others one after the other, those left out that the ones before them make already */
    for (uint32_t i = 0; i < size; ++i) {
        if ((i != which) && (ema_levmar_length(normal, i) > EMA_R(0.0))) {
            ema_real* const row = &factor[EMA_TRIANGLE(count)];
            const ema_real rest = ema_levmar_rest(normal, factor, place, count, i, row);
            if (rest > EMA_PIVOT_SHARE) {
                row[count] = ema_sqrt(rest);
                place[count] = i;
                ++count;
            }
        }
    }
    if (apart.length > EMA_R(0.0)) {
        apart.share = ema_max(ema_levmar_rest(normal, factor, place, count, which, along), EMA_R(0.0));
        ema_solve_upper(factor, count, along);
        ema_real largest = EMA_R(0.0);
        for (uint32_t k = 0; k < count; ++k) {
            if (ema_abs(along[k]) > largest) {
                largest = ema_abs(along[k]);
                apart.partner = place[k];
            }
        }
    }
    return apart;
}
