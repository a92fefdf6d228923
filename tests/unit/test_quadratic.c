/* The quadratic through a search's best points: exact on quadratics, refused where none has a minimum, drawn from as
 * Boltzmann says. */
#include "base/ema_linear.h"
#include "search/ema_quadratic.h"

#include <math.h>

#include "ema_rig.h"

#define N_MAX EMA_ANNEALER_DIMENSION_MAX
#define REACH 3.0

static ema_annealer_t annealer;
static ema_quadratic_t quadratic;

void setUp(void)
{
    (void)memset(&annealer, 0, sizeof annealer);
    (void)memset(&quadratic, 0, sizeof quadratic);
    ema_rig_seed(UINT64_C(5));
}

void tearDown(void)
{
}

/* base + (x - lowest)' curvature (x - lowest) / 2 */
typedef struct {
    uint32_t dimension;
    double base;
    double lowest[N_MAX];
    double curvature[N_MAX][N_MAX];
} shape_t;

static double cost_of(const shape_t* shape, const ema_real* x)
{
    double sum = shape->base;
    for (uint32_t i = 0; i < shape->dimension; ++i) {
        for (uint32_t j = 0; j < shape->dimension; ++j) {
            sum += 0.5 * ((double)x[i] - shape->lowest[i]) * shape->curvature[i][j] * ((double)x[j] - shape->lowest[j]);
        }
    }
    return sum;
}

/* A bowl, leaning where the quadratic can lean. */
static shape_t bowl(uint32_t dimension)
{
    shape_t shape = {.dimension = dimension, .base = 0.25};
    for (uint32_t i = 0; i < dimension; ++i) {
        shape.lowest[i] = 0.4 + (0.03 * (double)i);
        shape.curvature[i][i] = 2.0 + (double)i;
        for (uint32_t j = 0; (dimension <= 4U) && (j < i); ++j) {
            shape.curvature[i][j] = 0.5 - (0.3 * (double)j);
            shape.curvature[j][i] = shape.curvature[i][j];
        }
    }
    return shape;
}

static void add_point(const ema_real* x, ema_real cost)
{
    ema_annealer_point_t* const point = &annealer.points[annealer.point_count];
    (void)memcpy(point->x, x, annealer.config.dimension * sizeof x[0]);
    point->cost = cost;
    if ((annealer.point_count == 0U) || (cost < annealer.best.cost)) {
        annealer.best = *point;
    }
    ++annealer.point_count;
}

/* `count` points of the shape, uniform in a box of half width `wide` around `centre`. */
static void scatter(const shape_t* shape, double centre, double wide, uint32_t count)
{
    annealer.config.dimension = shape->dimension;
    for (uint32_t p = 0; p < count; ++p) {
        ema_real x[N_MAX];
        for (uint32_t i = 0; i < shape->dimension; ++i) {
            x[i] = ema_rig_uniform((ema_real)(centre - wide), (ema_real)(centre + wide));
        }
        add_point(x, (ema_real)cost_of(shape, x));
    }
}

static double lowest_x(uint32_t i)
{
    return (double)annealer.best.x[i] + ((double)quadratic.scale[i] * (double)quadratic.lowest[i]);
}

static ema_real factor_at(uint32_t i, uint32_t j)
{
    return quadratic.factor[EMA_TRIANGLE(i) + j];
}

/* Curvature in x from the factor in z. */
static double curvature_x(uint32_t i, uint32_t j)
{
    double sum = 0.0;
    for (uint32_t k = 0; k <= ((i < j) ? i : j); ++k) {
        sum += (double)factor_at(i, k) * (double)factor_at(j, k);
    }
    return sum / ((double)quadratic.scale[i] * (double)quadratic.scale[j]);
}

static void test_unknowns_are_those_of_a_full_or_a_separable_quadratic(void)
{
    const uint32_t expected[9] = {1U, 3U, 6U, 10U, 15U, 11U, 13U, 15U, 17U};
    for (uint32_t dimension = 1; dimension <= 8U; ++dimension) {
        TEST_ASSERT_EQUAL_UINT32(expected[dimension], ema_quadratic_unknowns(dimension));
    }
}

static void test_fit_is_exact_on_bowls_in_one_to_eight_dimensions(void)
{
    for (uint32_t dimension = 1; dimension <= 8U; ++dimension) {
        setUp();
        const shape_t shape = bowl(dimension);
        scatter(&shape, 0.5, 0.2, 36U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
        for (uint32_t i = 0; i < dimension; ++i) {
            EMA_ASSERT_CLOSE(shape.lowest[i], lowest_x(i), EMA_BY_PRECISION(1.0e-3, 1.0e-12), 0.0);
            for (uint32_t j = 0; j <= i; ++j) {
                EMA_ASSERT_CLOSE(shape.curvature[i][j], curvature_x(i, j), EMA_BY_PRECISION(2.0e-2, 1.0e-11), 0.0);
            }
        }
    }
}

static void test_one_point_more_than_unknowns_is_enough_and_no_fewer(void)
{
    for (uint32_t dimension = 1; dimension <= 8U; ++dimension) {
        setUp();
        const shape_t shape = bowl(dimension);
        const uint32_t unknowns = ema_quadratic_unknowns(dimension);
        scatter(&shape, 0.5, 0.2, unknowns);
        TEST_ASSERT_FALSE(ema_quadratic_fit(&quadratic, &annealer));
    }
    for (uint32_t dimension = 1; dimension <= 2U; ++dimension) {
        setUp();
        const shape_t shape = bowl(dimension);
        scatter(&shape, 0.5, 0.2, ema_quadratic_unknowns(dimension) + 1U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    }
}

static void test_scale_of_the_cost_and_its_base_do_not_move_the_minimum(void)
{
    const double factors[3] = {1.0e-9, 1.0, 1.0e9};
    for (uint32_t k = 0; k < 3U; ++k) {
        setUp();
        shape_t shape = bowl(2U);
        shape.base = 0.0;
        for (uint32_t i = 0; i < 2U; ++i) {
            for (uint32_t j = 0; j < 2U; ++j) {
                shape.curvature[i][j] *= factors[k];
            }
        }
        scatter(&shape, 0.5, 0.2, 14U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
        for (uint32_t i = 0; i < 2U; ++i) {
            EMA_ASSERT_CLOSE(shape.lowest[i], lowest_x(i), EMA_BY_PRECISION(1.0e-3, 1.0e-12), 0.0);
            EMA_ASSERT_CLOSE(shape.curvature[i][i], curvature_x(i, i), 0.0, EMA_BY_PRECISION(1.0e-2, 1.0e-11));
        }
    }
}

/* A valley that is steeper on one side: the best points weigh most, so the minimum is found nearer than by plain least
 * squares. */
static void test_best_points_weigh_most(void)
{
    annealer.config.dimension = 1U;
    for (uint32_t p = 0; p < 20U; ++p) {
        const ema_real x = EMA_R(0.2) + (EMA_R(0.025) * (ema_real)p);
        const ema_real away = x - EMA_R(0.447);
        add_point(&x, (away * away) + (EMA_R(2.0) * away * away * away));
    }
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    const double weighted = fabs(lowest_x(0U) - 0.447);
    /* the same least squares without weights: three normal equations by Cramer's rule, centred at the best point */
    double s[5] = {0.0};
    double r[3] = {0.0};
    for (uint32_t p = 0; p < annealer.point_count; ++p) {
        const double z = (double)annealer.points[p].x[0] - (double)annealer.best.x[0];
        double power = 1.0;
        for (uint32_t k = 0; k < 5U; ++k) {
            s[k] += power;
            r[(k < 3U) ? k : 0U] += (k < 3U) ? (power * (double)annealer.points[p].cost) : 0.0;
            power *= z;
        }
    }
    const double slope = (s[0] * ((r[1] * s[4]) - (r[2] * s[3]))) - (r[0] * ((s[1] * s[4]) - (s[3] * s[2])))
                         + (s[2] * ((s[1] * r[2]) - (r[1] * s[2])));
    const double bend = (s[0] * ((s[2] * r[2]) - (s[3] * r[1]))) - (s[1] * ((s[1] * r[2]) - (r[1] * s[2])))
                        + (r[0] * ((s[1] * s[3]) - (s[2] * s[2])));
    const double plain = fabs(((double)annealer.best.x[0] - (0.5 * (slope / bend))) - 0.447);
    TEST_ASSERT_TRUE(weighted < (0.5 * plain));
}

static void test_points_at_one_cost_are_refused(void)
{
    shape_t flat = bowl(2U);
    (void)memset(flat.curvature, 0, sizeof flat.curvature);
    scatter(&flat, 0.5, 0.2, 14U);
    TEST_ASSERT_FALSE(ema_quadratic_fit(&quadratic, &annealer));
}

static void test_points_without_spread_in_a_coordinate_are_refused(void)
{
    const shape_t shape = bowl(2U);
    scatter(&shape, 0.5, 0.2, 14U);
    for (uint32_t p = 0; p < 14U; ++p) {
        annealer.points[p].x[1] = annealer.best.x[1];
    }
    TEST_ASSERT_FALSE(ema_quadratic_fit(&quadratic, &annealer));
}

static void test_points_on_a_line_are_refused(void)
{
    const shape_t shape = bowl(2U);
    scatter(&shape, 0.5, 0.2, 14U);
    for (uint32_t p = 0; p < 14U; ++p) {
        annealer.points[p].x[1] = annealer.points[p].x[0];
    }
    annealer.best.x[1] = annealer.best.x[0];
    TEST_ASSERT_FALSE(ema_quadratic_fit(&quadratic, &annealer));
}

/* Minimum beyond the points: as far as it is believed, along its direction. */
static void test_minimum_out_of_reach_is_approached_along_its_direction(void)
{
    shape_t shape = {.dimension = 2U, .lowest = {0.5, 0.5}};
    shape.curvature[0][0] = 2.0;
    shape.curvature[1][1] = 2.0;
    annealer.config.dimension = 2U;
    for (uint32_t p = 0; p < 14U; ++p) {
        const ema_real x[2] = {EMA_R(0.1) + ema_rig_uniform(EMA_R(-0.01), EMA_R(0.01)),
                               EMA_R(0.3) + ema_rig_uniform(EMA_R(-0.01), EMA_R(0.01))};
        add_point(x, (ema_real)cost_of(&shape, x));
    }
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    const double reached = fmax(fabs((double)quadratic.lowest[0]), fabs((double)quadratic.lowest[1]));
    EMA_ASSERT_CLOSE(REACH, reached, 1.0e-5, 0.0);
    const double slope = ((double)quadratic.lowest[1] * (double)quadratic.scale[1])
                         / ((double)quadratic.lowest[0] * (double)quadratic.scale[0]);
    const double wanted = (0.5 - (double)annealer.best.x[1]) / (0.5 - (double)annealer.best.x[0]);
    EMA_ASSERT_CLOSE(wanted, slope, 0.0, EMA_BY_PRECISION(0.05, 1.0e-8));
}

static void test_saddle_is_bent_into_a_bowl(void)
{
    shape_t saddle = {.dimension = 2U, .lowest = {0.5, 0.5}};
    saddle.curvature[0][0] = 4.0;
    saddle.curvature[1][1] = -0.05;
    scatter(&saddle, 0.5, 0.2, 14U);
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    for (uint32_t i = 0; i < 2U; ++i) {
        TEST_ASSERT_TRUE(factor_at(i, i) > EMA_R(0.0));
        TEST_ASSERT_TRUE(fabs((double)quadratic.lowest[i]) <= (REACH * (1.0 + (4.0 * EMA_EPS))));
    }
    /* bent up no more than it takes: the curvature that was there is at least kept, and less than doubled */
    TEST_ASSERT_TRUE(curvature_x(0U, 0U) > 3.9);
    TEST_ASSERT_TRUE(curvature_x(0U, 0U) < 8.0);
}

static void test_bowl_is_not_bent(void)
{
    shape_t narrow = {.dimension = 2U, .lowest = {0.5, 0.5}};
    narrow.curvature[0][0] = 400.0;
    narrow.curvature[1][1] = 1.0;
    scatter(&narrow, 0.5, 0.2, 14U);
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    EMA_ASSERT_CLOSE(1.0, curvature_x(1U, 1U), EMA_BY_PRECISION(0.1, 1.0e-9), 0.0);
}

static void test_leaning_dome_is_refused(void)
{
    shape_t dome = {.dimension = 2U, .lowest = {0.5, 0.5}};
    dome.curvature[0][0] = -1.0;
    dome.curvature[1][1] = -1.0;
    dome.curvature[0][1] = 0.9;
    dome.curvature[1][0] = 0.9;
    scatter(&dome, 0.5, 0.2, 14U);
    TEST_ASSERT_FALSE(ema_quadratic_fit(&quadratic, &annealer));
}

static void test_costs_as_large_as_a_diverged_run_do_no_harm(void)
{
    const shape_t shape = bowl(2U);
    scatter(&shape, 0.5, 0.2, 12U);
    const ema_real far_x[2] = {EMA_R(0.9), EMA_R(0.95)};
    add_point(far_x, EMA_R(1.0e30));
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    for (uint32_t i = 0; i < 2U; ++i) {
        TEST_ASSERT_TRUE(fabs((double)quadratic.lowest[i]) <= REACH);
        TEST_ASSERT_TRUE(factor_at(i, i) > EMA_R(0.0));
        TEST_ASSERT_TRUE(isfinite((double)factor_at(i, i)));
    }
}

/* Mean and covariance of many draws: lowest point, temperature times the inverse curvature. */
static void test_draws_are_boltzmanns(void)
{
    shape_t shape = {.dimension = 2U, .lowest = {0.45, 0.52}};
    shape.curvature[0][0] = 4.0;
    shape.curvature[1][1] = 3.0;
    shape.curvature[0][1] = 2.0;
    shape.curvature[1][0] = 2.0;
    const double determinant = (4.0 * 3.0) - (2.0 * 2.0);
    const double inverse[3] = {3.0 / determinant, 4.0 / determinant, -2.0 / determinant};
    const ema_real temperatures[2] = {EMA_R(1.0e-4), EMA_R(1.0e-2)};
    const uint32_t draws = 40000U;
    for (uint32_t k = 0; k < 2U; ++k) {
        setUp();
        scatter(&shape, 0.5, 0.4, 36U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
        annealer.temperature = temperatures[k];
        ema_random_t random;
        ema_random_init(&random, UINT64_C(9), UINT64_C(54));
        double sum[2] = {0.0};
        double square[3] = {0.0};
        for (uint32_t n = 0; n < draws; ++n) {
            ema_real x[N_MAX];
            ema_quadratic_draw(&quadratic, &annealer, &random, x);
            const double away[2] = {(double)x[0] - shape.lowest[0], (double)x[1] - shape.lowest[1]};
            sum[0] += away[0];
            sum[1] += away[1];
            square[0] += away[0] * away[0];
            square[1] += away[1] * away[1];
            square[2] += away[0] * away[1];
        }
        const double temperature = (double)temperatures[k];
        for (uint32_t i = 0; i < 2U; ++i) {
            const double wanted = temperature * inverse[i];
            /* five standard errors, and what the fit in float32 is off */
            EMA_ASSERT_CLOSE(0.0, sum[i] / draws, (5.0 * sqrt(wanted / draws)) + EMA_BY_PRECISION(5.0e-4, 0.0), 0.0);
            EMA_ASSERT_CLOSE(wanted, square[i] / draws, EMA_BY_PRECISION(3.0e-7, 0.0),
                             5.0 * sqrt(2.0 / draws) + EMA_BY_PRECISION(0.01, 0.0));
        }
        EMA_ASSERT_CLOSE(temperature * inverse[2], square[2] / draws, temperature * 0.015, 0.0);
    }
}

static void test_draws_stay_where_the_quadratic_holds(void)
{
    const shape_t shape = bowl(3U);
    scatter(&shape, 0.5, 0.1, 22U);
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    annealer.temperature = EMA_R(1.0e6);
    ema_random_t random;
    ema_random_init(&random, UINT64_C(9), UINT64_C(54));
    double widest = 0.0;
    for (uint32_t n = 0; n < 2000U; ++n) {
        ema_real x[N_MAX];
        ema_quadratic_draw(&quadratic, &annealer, &random, x);
        for (uint32_t i = 0; i < 3U; ++i) {
            widest = fmax(widest, fabs((double)x[i] - lowest_x(i)) / (double)quadratic.scale[i]);
        }
    }
    EMA_ASSERT_CLOSE(REACH, widest, 1.0e-4, 0.0);
}

static void test_cold_draw_is_the_minimum_itself(void)
{
    const shape_t shape = bowl(3U);
    scatter(&shape, 0.5, 0.2, 22U);
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    annealer.temperature = EMA_R(0.0);
    ema_random_t random;
    ema_random_init(&random, UINT64_C(9), UINT64_C(54));
    ema_real x[N_MAX];
    ema_quadratic_draw(&quadratic, &annealer, &random, x);
    for (uint32_t i = 0; i < 3U; ++i) {
        EMA_ASSERT_CLOSE(lowest_x(i), x[i], 4.0 * EMA_EPS, 0.0);
    }
}

/* A valley across the box whose lowest point lies outside: the draw is the lowest point of the box by an even grid,
 * with the other coordinates where the held one moves them. */
static void test_a_minimum_outside_is_sought_in_the_box(void)
{
    const double lowest[4][2] = {{-0.12, 0.35}, {1.08, 0.6}, {0.45, -0.1}, {1.05, 1.1}};
    for (uint32_t k = 0; k < 4U; ++k) {
        setUp();
        shape_t shape = {.dimension = 2U, .lowest = {lowest[k][0], lowest[k][1]}};
        shape.curvature[0][0] = 4.0;
        shape.curvature[1][1] = 3.0;
        shape.curvature[0][1] = 3.0;
        shape.curvature[1][0] = 3.0;
        scatter(&shape, 0.5, 0.45, 36U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
        annealer.temperature = EMA_R(0.0);
        ema_random_t random;
        ema_random_init(&random, UINT64_C(9), UINT64_C(54));
        ema_real x[N_MAX];
        ema_quadratic_draw(&quadratic, &annealer, &random, x);
        double least = (double)INFINITY;
        double there[2] = {0.0};
        for (uint32_t n = 0; n <= 400U; ++n) {
            for (uint32_t m = 0; m <= 400U; ++m) {
                const ema_real at[2] = {(ema_real)n / EMA_R(400.0), (ema_real)m / EMA_R(400.0)};
                const double cost = cost_of(&shape, at);
                if (cost < least) {
                    least = cost;
                    there[0] = (double)at[0];
                    there[1] = (double)at[1];
                }
            }
        }
        for (uint32_t i = 0; i < 2U; ++i) {
            TEST_ASSERT_TRUE((x[i] >= EMA_R(0.0)) && (x[i] <= EMA_R(1.0)));
            /* the grid is this wide, and the fit in float32 as far off as on bowls */
            EMA_ASSERT_CLOSE(there[i], x[i], 1.0 / 400.0 + 1.0e-3, 0.0);
        }
    }
}

static void test_draws_outside_come_into_the_box(void)
{
    for (uint32_t dimension = 1; dimension <= N_MAX; ++dimension) {
        setUp();
        shape_t shape = bowl(dimension);
        for (uint32_t i = 0; i < dimension; ++i) {
            shape.lowest[i] = ((i % 2U) == 0U) ? 0.02 : 0.97;
        }
        scatter(&shape, 0.5, 0.45, 36U);
        TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
        annealer.temperature = EMA_R(0.1);
        ema_random_t random;
        ema_random_init(&random, UINT64_C(9), UINT64_C(54));
        uint32_t held = 0U;
        for (uint32_t n = 0; n < 500U; ++n) {
            ema_real x[N_MAX];
            ema_quadratic_draw(&quadratic, &annealer, &random, x);
            for (uint32_t i = 0; i < dimension; ++i) {
                TEST_ASSERT_TRUE((x[i] >= EMA_R(0.0)) && (x[i] <= EMA_R(1.0)));
                held += ((x[i] < EMA_R(1.0e-6)) || (x[i] > EMA_R(0.999999))) ? 1U : 0U;
            }
        }
        TEST_ASSERT_TRUE(held > 50U);
    }
}

static void test_draw_takes_one_normal_per_dimension(void)
{
    const shape_t shape = bowl(4U);
    scatter(&shape, 0.5, 0.2, 32U);
    TEST_ASSERT_TRUE(ema_quadratic_fit(&quadratic, &annealer));
    annealer.temperature = EMA_R(1.0e-3);
    ema_random_t random;
    ema_random_init(&random, UINT64_C(9), UINT64_C(54));
    ema_random_t expected = random;
    ema_real x[N_MAX];
    ema_quadratic_draw(&quadratic, &annealer, &random, x);
    for (uint32_t i = 0; i < 4U; ++i) {
        (void)ema_random_normal(&expected);
    }
    EMA_ASSERT_SAME_BITS(&expected, &random, sizeof random);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_unknowns_are_those_of_a_full_or_a_separable_quadratic);
    RUN_TEST(test_fit_is_exact_on_bowls_in_one_to_eight_dimensions);
    RUN_TEST(test_one_point_more_than_unknowns_is_enough_and_no_fewer);
    RUN_TEST(test_scale_of_the_cost_and_its_base_do_not_move_the_minimum);
    RUN_TEST(test_best_points_weigh_most);
    RUN_TEST(test_points_at_one_cost_are_refused);
    RUN_TEST(test_points_without_spread_in_a_coordinate_are_refused);
    RUN_TEST(test_points_on_a_line_are_refused);
    RUN_TEST(test_minimum_out_of_reach_is_approached_along_its_direction);
    RUN_TEST(test_saddle_is_bent_into_a_bowl);
    RUN_TEST(test_bowl_is_not_bent);
    RUN_TEST(test_leaning_dome_is_refused);
    RUN_TEST(test_costs_as_large_as_a_diverged_run_do_no_harm);
    RUN_TEST(test_draws_are_boltzmanns);
    RUN_TEST(test_draws_stay_where_the_quadratic_holds);
    RUN_TEST(test_cold_draw_is_the_minimum_itself);
    RUN_TEST(test_a_minimum_outside_is_sought_in_the_box);
    RUN_TEST(test_draws_outside_come_into_the_box);
    RUN_TEST(test_draw_takes_one_normal_per_dimension);
    return UNITY_END();
}
