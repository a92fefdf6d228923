/* Small symmetric systems: known factors, random systems solved back, and what is refused. */
#include <math.h>

#include "base/ema_linear.h"
#include "base/ema_math.h"
#include "ema_rig.h"

#define SIZE_MAX_TRIED 17U

void setUp(void)
{
    ema_rig_seed(2U);
}

void tearDown(void)
{
}

static void test_factor_of_a_known_matrix(void)
{
    /* [4 2 0; 2 5 2; 0 2 10] = L L', L = [2; 1 2; 0 1 3] */
    ema_real matrix[7] = {EMA_R(4.0), EMA_R(2.0), EMA_R(5.0), EMA_R(0.0), EMA_R(2.0), EMA_R(10.0), EMA_R(-7.0)};
    TEST_ASSERT_TRUE(ema_cholesky(matrix, 3U));
    const ema_real factor[7] = {EMA_R(2.0), EMA_R(1.0), EMA_R(2.0), EMA_R(0.0), EMA_R(1.0), EMA_R(3.0), EMA_R(-7.0)};
    /* exact numbers, and nothing behind the triangle is written */
    EMA_ASSERT_SAME_BITS(factor, matrix, sizeof factor);
}

static void test_solves_lower_and_upper(void)
{
    const ema_real factor[3] = {EMA_R(2.0), EMA_R(1.0), EMA_R(4.0)};
    ema_real b[2] = {EMA_R(6.0), EMA_R(11.0)};
    ema_solve_lower(factor, 2U, b);
    TEST_ASSERT_TRUE((b[0] == EMA_R(3.0)) && (b[1] == EMA_R(2.0)));
    ema_solve_upper(factor, 2U, b);
    TEST_ASSERT_TRUE((b[0] == EMA_R(1.25)) && (b[1] == EMA_R(0.5)));
}

static void test_random_systems_solve_back(void)
{
    for (uint32_t size = 1U; size <= SIZE_MAX_TRIED; ++size) {
        for (uint32_t trial = 0; trial < 20U; ++trial) {
            ema_real matrix[EMA_TRIANGLE(SIZE_MAX_TRIED)];
            ema_real solution[SIZE_MAX_TRIED];
            ema_real b[SIZE_MAX_TRIED];
            for (uint32_t k = 0; k < EMA_TRIANGLE(SIZE_MAX_TRIED); ++k) {
                matrix[k] = (ema_real)NAN;
            }
            /* A' A + size I is positive definite and well conditioned */
            ema_real a[SIZE_MAX_TRIED][SIZE_MAX_TRIED];
            for (uint32_t i = 0; i < size; ++i) {
                solution[i] = ema_rig_uniform(EMA_R(-1.0), EMA_R(1.0));
                for (uint32_t j = 0; j < size; ++j) {
                    a[i][j] = ema_rig_uniform(EMA_R(-1.0), EMA_R(1.0));
                }
            }
            double full[SIZE_MAX_TRIED][SIZE_MAX_TRIED];
            for (uint32_t i = 0; i < size; ++i) {
                for (uint32_t j = 0; j < size; ++j) {
                    full[i][j] = (i == j) ? (double)size : 0.0;
                    for (uint32_t k = 0; k < size; ++k) {
                        full[i][j] += (double)a[k][i] * (double)a[k][j];
                    }
                }
            }
            for (uint32_t i = 0; i < size; ++i) {
                double sum = 0.0;
                for (uint32_t j = 0; j < size; ++j) {
                    sum += full[i][j] * (double)solution[j];
                    if (j <= i) {
                        matrix[EMA_TRIANGLE(i) + j] = (ema_real)full[i][j];
                    }
                }
                b[i] = (ema_real)sum;
            }
            TEST_ASSERT_TRUE(ema_cholesky(matrix, size));
            ema_solve_lower(matrix, size, b);
            ema_solve_upper(matrix, size, b);
            EMA_ASSERT_CLOSE_ARRAY(solution, b, size, 60.0 * EMA_EPS, 0.0);
        }
    }
}

static void test_singular_matrix_is_refused(void)
{
    ema_real twice[3] = {EMA_R(1.0), EMA_R(2.0), EMA_R(4.0)};
    TEST_ASSERT_FALSE(ema_cholesky(twice, 2U));
    ema_real zero[1] = {EMA_R(0.0)};
    TEST_ASSERT_FALSE(ema_cholesky(zero, 1U));
}

static void test_indefinite_matrix_is_refused(void)
{
    ema_real saddle[3] = {EMA_R(1.0), EMA_R(2.0), EMA_R(1.0)};
    TEST_ASSERT_FALSE(ema_cholesky(saddle, 2U));
    ema_real negative[1] = {EMA_R(-1.0)};
    TEST_ASSERT_FALSE(ema_cholesky(negative, 1U));
}

static void test_matrix_with_nan_is_refused(void)
{
    ema_real diagonal[1] = {(ema_real)NAN};
    TEST_ASSERT_FALSE(ema_cholesky(diagonal, 1U));
    ema_real beside[3] = {EMA_R(1.0), (ema_real)NAN, EMA_R(4.0)};
    TEST_ASSERT_FALSE(ema_cholesky(beside, 2U));
}

static void test_pivot_share_separates_singular_from_regular(void)
{
    /* [1 r; r 1] has the second pivot 1 - r^2 */
    const double share = (double)EMA_PIVOT_SHARE;
    const ema_real regular = (ema_real)sqrt(1.0 - (2.0 * share));
    const ema_real singular = (ema_real)sqrt(1.0 - (0.5 * share));
    ema_real well[3] = {EMA_R(1.0), regular, EMA_R(1.0)};
    ema_real ill[3] = {EMA_R(1.0), singular, EMA_R(1.0)};
    TEST_ASSERT_TRUE(ema_cholesky(well, 2U));
    TEST_ASSERT_FALSE(ema_cholesky(ill, 2U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_factor_of_a_known_matrix);
    RUN_TEST(test_solves_lower_and_upper);
    RUN_TEST(test_random_systems_solve_back);
    RUN_TEST(test_singular_matrix_is_refused);
    RUN_TEST(test_indefinite_matrix_is_refused);
    RUN_TEST(test_matrix_with_nan_is_refused);
    RUN_TEST(test_pivot_share_separates_singular_from_regular);
    return UNITY_END();
}
