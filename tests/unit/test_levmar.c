/* The damped step against a solution worked out here in double, its conditions at the bounds, and what the sums tell
 * apart. */
#include "ema/ema.h"

#include <math.h>

#include "ema_rig.h"

#define SIZE EMA_LEVMAR_MAX
#define ROWS 40U

static ema_levmar_t memory;
static ema_real normal[EMA_LEVMAR_TRIANGLE(SIZE)];
static ema_real gradient[SIZE];
static ema_real step[SIZE];
static const ema_real middle[SIZE] = {EMA_R(0.5), EMA_R(0.5), EMA_R(0.5), EMA_R(0.5),
                                      EMA_R(0.5), EMA_R(0.5), EMA_R(0.5), EMA_R(0.5)};

void setUp(void)
{
    ema_rig_seed(5U);
    (void)memset(&memory, 0xA5, sizeof memory);
    (void)memset(step, 0xA5, sizeof step);
}

void tearDown(void)
{
}

static double element(uint32_t i, uint32_t j)
{
    return (double)((i >= j) ? normal[EMA_LEVMAR_TRIANGLE(i) + j] : normal[EMA_LEVMAR_TRIANGLE(j) + i]);
}

/* Sums of random sensitivities of very different sizes, and of a random residual times `size`. */
static void make_sums(uint32_t count, ema_real size)
{
    for (uint32_t k = 0; k < EMA_LEVMAR_TRIANGLE(SIZE); ++k) {
        normal[k] = EMA_R(0.0);
    }
    for (uint32_t i = 0; i < count; ++i) {
        gradient[i] = EMA_R(0.0);
    }
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_real slope[SIZE];
        ema_real scale = EMA_R(0.1);
        const ema_real residual = ema_rig_uniform(-size, size);
        for (uint32_t i = 0; i < count; ++i) {
            slope[i] = scale * ema_rig_uniform(EMA_R(-1.0), EMA_R(1.0));
            scale *= EMA_R(3.0);
            gradient[i] += slope[i] * residual;
            for (uint32_t j = 0; j <= i; ++j) {
                normal[EMA_LEVMAR_TRIANGLE(i) + j] += slope[i] * slope[j];
            }
        }
    }
}

/* What is left of the damped equation of coordinate `i`, over the size of its own terms. */
static double left_of(uint32_t i, uint32_t count, double damping)
{
    double left = (double)gradient[i] - (damping * element(i, i) * (double)step[i]);
    double size = fabs((double)gradient[i]);
    for (uint32_t j = 0; j < count; ++j) {
        left -= element(i, j) * (double)step[j];
        size += fabs(element(i, j) * (double)step[j]);
    }
    return left / size;
}

static void test_step_solves_the_damped_equations(void)
{
    for (uint32_t count = 1U; count <= SIZE; ++count) {
        for (uint32_t trial = 0; trial < 20U; ++trial) {
            const ema_real damping = (trial < 10U) ? EMA_DAMPING_MIN : EMA_R(0.5);
            make_sums(count, EMA_R(1.0e-3));
            const ema_real promised = ema_levmar_step(normal, gradient, middle, count, damping, &memory, step);
            double fall = 0.0;
            for (uint32_t i = 0; i < count; ++i) {
                TEST_ASSERT_TRUE(fabs(left_of(i, count, (double)damping)) < EMA_BY_PRECISION(1.0e-4, 1.0e-12));
                double made = 0.0;
                for (uint32_t j = 0; j < count; ++j) {
                    made += element(i, j) * (double)step[j];
                }
                fall += (double)step[i] * ((2.0 * (double)gradient[i]) - made);
            }
            TEST_ASSERT_TRUE(fall > 0.0);
            EMA_ASSERT_CLOSE(fall, promised, 0.0, EMA_BY_PRECISION(1.0e-4, 1.0e-12));
        }
    }
}

/* Steps as long as the box and longer: the end is inside, coordinates that moved freely fulfil their equations, and one
 * that did not lies on a bound. */
static void test_step_stays_in_the_box_and_is_solved_for_the_others(void)
{
    uint32_t stopped = 0U;
    uint32_t moved = 0U;
    for (uint32_t trial = 0; trial < 300U; ++trial) {
        ema_real x[SIZE];
        make_sums(SIZE, EMA_R(3.0));
        for (uint32_t i = 0; i < SIZE; ++i) {
            x[i] = ema_rig_uniform(EMA_R(0.0), EMA_R(1.0));
        }
        (void)ema_levmar_step(normal, gradient, x, SIZE, EMA_R(0.01), &memory, step);
        for (uint32_t i = 0; i < SIZE; ++i) {
            const double to = (double)x[i] + (double)step[i];
            TEST_ASSERT_TRUE((to >= -EMA_EPS) && (to <= (1.0 + EMA_EPS)));
            if (fmin(fabs(to), fabs(1.0 - to)) <= EMA_EPS) {
                ++stopped;
            } else {
                ++moved;
                TEST_ASSERT_TRUE(fabs(left_of(i, SIZE, 0.01)) < EMA_BY_PRECISION(1.0e-3, 1.0e-11));
            }
        }
    }
    TEST_ASSERT_TRUE((stopped > 100U) && (moved > 100U));
}

static void test_coordinate_at_a_bound_stays_when_it_wants_out_and_leaves_when_it_wants_in(void)
{
    const ema_real x[2] = {EMA_R(0.0), EMA_R(1.0)};
    normal[0] = EMA_R(4.0);
    normal[1] = EMA_R(1.0);
    normal[2] = EMA_R(4.0);
    gradient[0] = EMA_R(-0.4);
    gradient[1] = EMA_R(0.4);
    const ema_real held = ema_levmar_step(normal, gradient, x, 2U, EMA_DAMPING_MIN, &memory, step);
    TEST_ASSERT_TRUE((step[0] == EMA_R(0.0)) && (step[1] == EMA_R(0.0)));
    TEST_ASSERT_TRUE(held == EMA_R(0.0));
    gradient[0] = EMA_R(0.4);
    const ema_real one = ema_levmar_step(normal, gradient, x, 2U, EMA_DAMPING_MIN, &memory, step);
    EMA_ASSERT_CLOSE(0.1, step[0], 2.0e-5, 0.0);
    TEST_ASSERT_TRUE(step[1] == EMA_R(0.0));
    EMA_ASSERT_CLOSE(0.04, one, 1.0e-5, 0.0);
}

static void test_coordinate_without_sensitivities_is_left_and_does_not_disturb(void)
{
    const ema_real useless[4] = {EMA_R(0.0), (ema_real)NAN, (ema_real)INFINITY, EMA_R(-1.0)};
    for (uint32_t k = 0; k < 4U; ++k) {
        normal[0] = EMA_R(4.0);
        normal[1] = useless[k];
        normal[2] = useless[k];
        gradient[0] = EMA_R(0.4);
        gradient[1] = useless[k];
        (void)ema_levmar_step(normal, gradient, middle, 2U, EMA_DAMPING_MIN, &memory, step);
        EMA_ASSERT_CLOSE(0.1, step[0], 2.0e-5, 0.0);
        TEST_ASSERT_TRUE(step[1] == EMA_R(0.0));
        const ema_collinearity_t apart = ema_levmar_collinearity(normal, 2U, 1U);
        TEST_ASSERT_TRUE(apart.length == EMA_R(0.0));
        TEST_ASSERT_EQUAL_UINT32(1U, apart.partner);
        const ema_collinearity_t other = ema_levmar_collinearity(normal, 2U, 0U);
        TEST_ASSERT_TRUE((other.share == EMA_R(1.0)) && (other.length == EMA_R(2.0)));
    }
}

static void test_alike_coordinates_still_have_a_step(void)
{
    for (uint32_t k = 0; k < 3U; ++k) {
        normal[k] = EMA_R(4.0);
    }
    gradient[0] = EMA_R(0.4);
    gradient[1] = EMA_R(0.4);
    (void)ema_levmar_step(normal, gradient, middle, 2U, EMA_DAMPING_MIN, &memory, step);
    EMA_ASSERT_CLOSE(0.05, step[0], 1.0e-4, 0.0);
    EMA_ASSERT_CLOSE(0.05, step[1], 1.0e-4, 0.0);
}

/* Below the least damping they have none, which is no step, not a wild one. */
static void test_alike_coordinates_without_damping_stay(void)
{
    for (uint32_t k = 0; k < 3U; ++k) {
        normal[k] = EMA_R(4.0);
    }
    gradient[0] = EMA_R(0.4);
    gradient[1] = EMA_R(0.4);
    TEST_ASSERT_TRUE(ema_levmar_step(normal, gradient, middle, 2U, EMA_R(0.0), &memory, step) == EMA_R(0.0));
    TEST_ASSERT_TRUE((step[0] == EMA_R(0.0)) && (step[1] == EMA_R(0.0)));
}

static void test_gradient_that_is_no_number_moves_nothing(void)
{
    normal[0] = EMA_R(4.0);
    normal[1] = EMA_R(0.0);
    normal[2] = EMA_R(4.0);
    gradient[0] = (ema_real)NAN;
    gradient[1] = EMA_R(0.4);
    (void)ema_levmar_step(normal, gradient, middle, 2U, EMA_DAMPING_MIN, &memory, step);
    TEST_ASSERT_TRUE(step[0] == EMA_R(0.0));
    EMA_ASSERT_CLOSE(0.1, step[1], 2.0e-5, 0.0);
}

static void test_share_is_that_of_the_inverse(void)
{
    make_sums(3U, EMA_R(1.0));
    const double a = element(0U, 0U);
    const double b = element(1U, 0U);
    const double c = element(1U, 1U);
    const double d = element(2U, 0U);
    const double e = element(2U, 1U);
    const double f = element(2U, 2U);
    const double determinant = (a * ((c * f) - (e * e))) - (b * ((b * f) - (e * d))) + (d * ((b * e) - (c * d)));
    const double inverse[3] = {((c * f) - (e * e)) / determinant, ((a * f) - (d * d)) / determinant,
                               ((a * c) - (b * b)) / determinant};
    for (uint32_t k = 0; k < 3U; ++k) {
        const ema_collinearity_t apart = ema_levmar_collinearity(normal, 3U, k);
        EMA_ASSERT_CLOSE(sqrt(element(k, k)), apart.length, 0.0, EMA_BY_PRECISION(1.0e-6, 1.0e-14));
        EMA_ASSERT_CLOSE(1.0 / (inverse[k] * element(k, k)), apart.share, EMA_BY_PRECISION(1.0e-5, 1.0e-13), 0.0);
    }
}

/* The second does what the first does twice over; the third something else, and a little of it. */
static void test_partner_does_the_same(void)
{
    const ema_real sums[6] = {EMA_R(1.0), EMA_R(2.0), EMA_R(4.0), EMA_R(0.1), EMA_R(0.2), EMA_R(9.0)};
    const ema_collinearity_t first = ema_levmar_collinearity(sums, 3U, 0U);
    const ema_collinearity_t second = ema_levmar_collinearity(sums, 3U, 1U);
    const ema_collinearity_t third = ema_levmar_collinearity(sums, 3U, 2U);
    EMA_ASSERT_CLOSE(0.0, first.share, EMA_BY_PRECISION(1.0e-6, 1.0e-14), 0.0);
    EMA_ASSERT_CLOSE(0.0, second.share, EMA_BY_PRECISION(1.0e-6, 1.0e-14), 0.0);
    TEST_ASSERT_EQUAL_UINT32(1U, first.partner);
    TEST_ASSERT_EQUAL_UINT32(0U, second.partner);
    EMA_ASSERT_CLOSE(1.0 - (0.01 / 9.0), third.share, EMA_BY_PRECISION(1.0e-6, 1.0e-14), 0.0);
    TEST_ASSERT_TRUE(third.partner < 2U);
    TEST_ASSERT_EQUAL_UINT32(0U, ema_levmar_collinearity(sums, 1U, 0U).partner);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_step_solves_the_damped_equations);
    RUN_TEST(test_step_stays_in_the_box_and_is_solved_for_the_others);
    RUN_TEST(test_coordinate_at_a_bound_stays_when_it_wants_out_and_leaves_when_it_wants_in);
    RUN_TEST(test_coordinate_without_sensitivities_is_left_and_does_not_disturb);
    RUN_TEST(test_alike_coordinates_still_have_a_step);
    RUN_TEST(test_alike_coordinates_without_damping_stay);
    RUN_TEST(test_gradient_that_is_no_number_moves_nothing);
    RUN_TEST(test_share_is_that_of_the_inverse);
    RUN_TEST(test_partner_does_the_same);
    return UNITY_END();
}
