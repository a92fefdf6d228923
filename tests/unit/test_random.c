/* The generator against its published numbers, and the distributions against their moments. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define DRAWS 200000U

void setUp(void)
{
}

void tearDown(void)
{
}

/* First numbers of pcg32-demo, seed 42, stream 54: https://www.pcg-random.org */
static const uint32_t published[6] = {0xa15c02b7U, 0x7b47f409U, 0xba1d3330U, 0x83d2f293U, 0xbfa4784bU, 0xcbed606eU};

static void test_published_numbers(void)
{
    ema_random_t random;
    ema_random_init(&random, 42U, 54U);
    for (uint32_t k = 0; k < 6U; ++k) {
        TEST_ASSERT_EQUAL_HEX32(published[k], ema_random_u32(&random));
    }
}

static void test_a_copy_continues_with_the_same_numbers(void)
{
    ema_random_t random;
    ema_random_init(&random, 7U, 1U);
    (void)ema_random_u32(&random);
    ema_random_t copy = random;
    for (uint32_t k = 0; k < 100U; ++k) {
        TEST_ASSERT_EQUAL_HEX32(ema_random_u32(&random), ema_random_u32(&copy));
    }
}

static uint32_t equal_draws(uint64_t seed_a, uint64_t stream_a, uint64_t seed_b, uint64_t stream_b)
{
    ema_random_t a;
    ema_random_t b;
    uint32_t equal = 0U;
    ema_random_init(&a, seed_a, stream_a);
    ema_random_init(&b, seed_b, stream_b);
    for (uint32_t k = 0; k < 1000U; ++k) {
        equal += (ema_random_u32(&a) == ema_random_u32(&b)) ? 1U : 0U;
    }
    return equal;
}

static void test_seeds_and_streams_differ(void)
{
    TEST_ASSERT_EQUAL_UINT32(1000U, equal_draws(1U, 54U, 1U, 54U));
    TEST_ASSERT_EQUAL_UINT32(0U, equal_draws(1U, 54U, 2U, 54U));
    TEST_ASSERT_EQUAL_UINT32(0U, equal_draws(1U, 54U, 1U, 55U));
    /* the seed counts in all of its 64 bits */
    TEST_ASSERT_EQUAL_UINT32(0U, equal_draws(1U, 54U, UINT64_C(0x100000001), 54U));
}

static void test_uniform_is_open_at_both_ends(void)
{
    /* states whose next 32 bits are all zero and all one */
    ema_random_t least = {UINT64_C(0), UINT64_C(1)};
    ema_random_t most = {((UINT64_C(1) << 59U) - 1U) & ~((UINT64_C(1) << 41U) - 1U), UINT64_C(1)};
    ema_random_t probe = most;
    TEST_ASSERT_EQUAL_HEX32(0xffffffffU, ema_random_u32(&probe));
    probe = least;
    TEST_ASSERT_EQUAL_HEX32(0U, ema_random_u32(&probe));
    const ema_real low = ema_random_uniform(&least);
    const ema_real high = ema_random_uniform(&most);
    TEST_ASSERT_TRUE((double)low == 0x1p-24);
    TEST_ASSERT_TRUE((double)high == (1.0 - 0x1p-24));
}

static void test_both_builds_draw_the_same_uniforms(void)
{
    ema_random_t random;
    ema_random_t bits;
    ema_random_init(&random, 42U, 54U);
    ema_random_init(&bits, 42U, 54U);
    for (uint32_t k = 0; k < 1000U; ++k) {
        const double exact = ((double)(ema_random_u32(&bits) >> 9U) + 0.5) * 0x1p-23;
        TEST_ASSERT_TRUE((double)ema_random_uniform(&random) == exact);
    }
}

static void test_uniform_has_the_moments_of_a_uniform(void)
{
    ema_random_t random;
    double sum = 0.0;
    double square = 0.0;
    ema_random_init(&random, 5U, 54U);
    for (uint32_t k = 0; k < DRAWS; ++k) {
        const double x = (double)ema_random_uniform(&random);
        TEST_ASSERT_TRUE((x > 0.0) && (x < 1.0));
        sum += x;
        square += (x - 0.5) * (x - 0.5);
    }
    /* four standard errors: sigma / sqrt(n), and sigma^2 sqrt(0.8 / n) for a uniform */
    EMA_ASSERT_CLOSE(0.5, sum / DRAWS, 4.0 * sqrt(1.0 / (12.0 * DRAWS)), 0.0);
    EMA_ASSERT_CLOSE(1.0 / 12.0, square / DRAWS, 4.0 * sqrt(0.8 / DRAWS) / 12.0, 0.0);
}

static void test_uniform_fills_its_bins_evenly(void)
{
    enum { BINS = 100 };
    uint32_t count[BINS] = {0};
    ema_random_t random;
    ema_random_init(&random, 6U, 54U);
    for (uint32_t k = 0; k < DRAWS; ++k) {
        ++count[(uint32_t)(ema_random_uniform(&random) * (ema_real)BINS)];
    }
    double chi_square = 0.0;
    const double expected = (double)DRAWS / (double)BINS;
    for (uint32_t k = 0; k < BINS; ++k) {
        chi_square += ((count[k] - expected) * (count[k] - expected)) / expected;
    }
    /* 99 degrees of freedom: 1e-4 quantiles on both sides, for too even is not random either */
    TEST_ASSERT_TRUE(chi_square < 160.1);
    TEST_ASSERT_TRUE(chi_square > 54.0);
}

static void test_normal_has_mean_0_variance_1_and_no_skew(void)
{
    ema_random_t random;
    double moment[5] = {0.0};
    ema_random_init(&random, 8U, 54U);
    for (uint32_t k = 0; k < DRAWS; ++k) {
        const double x = (double)ema_random_normal(&random);
        TEST_ASSERT_TRUE(fabs(x) < 6.0);
        moment[1] += x / DRAWS;
        moment[2] += (x * x) / DRAWS;
        moment[3] += (x * x * x) / DRAWS;
        moment[4] += (x * x * x * x) / DRAWS;
    }
    EMA_ASSERT_CLOSE(0.0, moment[1], 4.0 / sqrt(DRAWS), 0.0);
    EMA_ASSERT_CLOSE(1.0, moment[2], 4.0 * sqrt(2.0 / DRAWS), 0.0);
    EMA_ASSERT_CLOSE(0.0, moment[3], 4.0 * sqrt(15.0 / DRAWS), 0.0);
    /* twelve uniforms: kurtosis 3 - 1.2 / 12 */
    EMA_ASSERT_CLOSE(2.9, moment[4], 4.0 * sqrt(96.0 / DRAWS), 0.0);
}

static void test_normal_is_the_sum_of_twelve_uniforms_minus_six(void)
{
    ema_random_t random;
    ema_random_t uniform;
    ema_random_init(&random, 9U, 54U);
    ema_random_init(&uniform, 9U, 54U);
    double sum = -6.0;
    for (uint32_t k = 0; k < 12U; ++k) {
        sum += (double)ema_random_uniform(&uniform);
    }
    EMA_ASSERT_CLOSE(sum, ema_random_normal(&random), 40.0 * EMA_EPS, 0.0);
    EMA_ASSERT_SAME_BITS(&uniform, &random, sizeof random);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_published_numbers);
    RUN_TEST(test_a_copy_continues_with_the_same_numbers);
    RUN_TEST(test_seeds_and_streams_differ);
    RUN_TEST(test_uniform_is_open_at_both_ends);
    RUN_TEST(test_both_builds_draw_the_same_uniforms);
    RUN_TEST(test_uniform_has_the_moments_of_a_uniform);
    RUN_TEST(test_uniform_fills_its_bins_evenly);
    RUN_TEST(test_normal_has_mean_0_variance_1_and_no_skew);
    RUN_TEST(test_normal_is_the_sum_of_twelve_uniforms_minus_six);
    return UNITY_END();
}
