/* The parts of a forecast: the bank of laws, the filter of one, first passage, and what comes of a pace that changes.
 */
#include "ema/ema.h"

#include <math.h>

#include "ema_close.h"
#include "trend/ema_first_passage.h"
#include "trend/ema_forecast.h"
#include "trend/ema_law.h"
#include "trend/ema_wear_filter.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_laws_are_all_others_and_share_what_there_is(void)
{
    static ema_law_t laws[EMA_FORECAST_LAWS];
    double still = 0.0;
    double wears = 0.0;
    for (uint32_t k = 0; k < EMA_FORECAST_LAWS; ++k) {
        laws[k] = ema_law_of(k);
        const double share = exp((double)laws[k].share_log);
        still += (k < EMA_LAWS_STILL) ? share : 0.0;
        wears += (k < EMA_LAWS_STILL) ? 0.0 : share;
        const ema_real edges[] = {laws[k].onset,    laws[k].stall[0], laws[k].again[0],
                                  laws[k].stall[1], laws[k].again[1], EMA_R(1.0)};
        for (uint32_t edge = 1; edge < 6U; ++edge) {
            TEST_ASSERT_TRUE((edges[edge - 1U] < edges[edge]) || (edges[edge - 1U] >= EMA_R(1.0)));
        }
        for (uint32_t before = 0; before < k; ++before) {
            TEST_ASSERT_NOT_EQUAL(0, memcmp(&laws[k], &laws[before], sizeof laws[k]));
        }
    }
    TEST_ASSERT_TRUE((fabs(still - 1.0) < 1e-5) && (fabs(wears - 1.0) < 1e-5));
}

/* Even wear from a quarter of the age on, with these two stalls. */
static ema_law_t stalling(ema_real stall, ema_real again, ema_real second, ema_real again_second)
{
    const ema_law_t law = {EMA_R(12.0), EMA_R(0.25), {stall, second}, {again, again_second},
                           EMA_R(1.0),  EMA_R(0.0),  EMA_R(0.0),      EMA_R(0.0),
                           EMA_R(0.0),  EMA_R(0.0),  EMA_R(0.0)};
    return law;
}

static void test_wear_stalls_and_goes_on(void)
{
    const ema_law_t law = stalling(EMA_R(0.5), EMA_R(0.75), EMA_R(1.0), EMA_R(1.0));
    const ema_law_t twice = stalling(EMA_R(0.375), EMA_R(0.5), EMA_R(0.625), EMA_R(0.75));
    const ema_real times[] = {EMA_R(0.0), EMA_R(0.25), EMA_R(0.375), EMA_R(0.5), EMA_R(0.75), EMA_R(1.0), EMA_R(2.0)};
    const ema_real own[] = {EMA_R(0.0), EMA_R(0.0), EMA_R(0.125), EMA_R(0.25), EMA_R(0.25), EMA_R(0.5), EMA_R(1.5)};
    const ema_real own_twice[] = {EMA_R(0.0),  EMA_R(0.0), EMA_R(0.125), EMA_R(0.125),
                                  EMA_R(0.25), EMA_R(0.5), EMA_R(1.5)};
    for (uint32_t k = 0; k < 7U; ++k) {
        EMA_ASSERT_CLOSE(own[k], ema_law_own_time(&law, times[k]), 0.0, 0.0);
        EMA_ASSERT_CLOSE(own_twice[k], ema_law_own_time(&twice, times[k]), 0.0, 0.0);
    }
    EMA_ASSERT_CLOSE(EMA_R(0.0), ema_law_stalled_for(&law), 0.0, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(0.0), ema_law_stalled_for(&twice), 0.0, 0.0);
}

/* A stall lasts that has no end within the age, the first or the second. */
static void test_a_stall_that_lasts_has_been_since_it_began(void)
{
    const ema_law_t once = stalling(EMA_R(0.75), EMA_R(1.0), EMA_R(1.0), EMA_R(1.0));
    const ema_law_t twice = stalling(EMA_R(0.375), EMA_R(0.5), EMA_R(0.625), EMA_R(1.0));
    EMA_ASSERT_CLOSE(EMA_R(0.25), ema_law_stalled_for(&once), 0.0, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(0.375), ema_law_stalled_for(&twice), 0.0, 0.0);
}

/* An edge goes by within the part about it, and one at the ends of the age is none. */
static void test_edges_go_by(void)
{
    const ema_law_t law = stalling(EMA_R(0.5), EMA_R(0.75), EMA_R(1.0), EMA_R(1.0));
    const ema_law_t twice = stalling(EMA_R(0.5), EMA_R(0.625), EMA_R(0.75), EMA_R(0.875));
    ema_law_t none = stalling(EMA_R(1.0), EMA_R(1.0), EMA_R(1.0), EMA_R(1.0));
    none.onset = EMA_R(0.0);
    const ema_real times[] = {EMA_R(0.0), EMA_R(0.2), EMA_R(0.25), EMA_R(0.3), EMA_R(0.5), EMA_R(1.0)};
    const ema_real passed[] = {EMA_R(0.0), EMA_R(0.0), EMA_R(0.5), EMA_R(1.0), EMA_R(1.5), EMA_R(3.0)};
    for (uint32_t k = 0; k < 6U; ++k) {
        EMA_ASSERT_CLOSE(passed[k], ema_law_passed(&law, times[k]), 0.0, 0.0);
        EMA_ASSERT_CLOSE(EMA_R(0.0), ema_law_passed(&none, times[k]), 0.0, 0.0);
    }
    EMA_ASSERT_CLOSE(EMA_R(5.0), ema_law_passed(&twice, EMA_R(1.0)), 0.0, 0.0);
}

/* By the difference of what has risen. */
static void test_rates_are_those_of_what_rises(void)
{
    for (uint32_t k = 0; k < EMA_FORECAST_LAWS; ++k) {
        const ema_law_t law = ema_law_of(k);
        const ema_real step = EMA_R(0.01);
        const ema_real by =
            (ema_law_risen(&law, EMA_R(0.7) + step) - ema_law_risen(&law, EMA_R(0.7) - step)) / (EMA_R(2.0) * step);
        EMA_ASSERT_CLOSE(by, ema_law_rises(&law, EMA_R(0.7)), 1e-4, 2e-3);
        EMA_ASSERT_CLOSE((k < EMA_LAWS_STILL) ? EMA_R(0.0) : EMA_R(1.0), ema_law_risen(&law, EMA_R(1.0)), 1e-6, 0.0);
        EMA_ASSERT_CLOSE(EMA_R(0.0), ema_law_faded(&law, EMA_R(0.0)), 0.0, 0.0);
        TEST_ASSERT_TRUE(isfinite(ema_law_risen(&law, EMA_R(21.0))));
    }
}

/* The filter against the formulas of one straight line by least squares with a prior. */
static void test_one_law_is_least_squares_with_a_prior(void)
{
    ema_wear_t wear;
    ema_wear_begin(&wear);
    double normal[2][2] = {{1.0 / 0.04, 0.0}, {0.0, 1.0 / 0.16}};
    double right[2] = {0.0, 0.0};
    for (uint32_t k = 0; k < 20U; ++k) {
        const ema_real time = (ema_real)k / EMA_R(19.0);
        const ema_real row[EMA_WEAR_STATES] = {EMA_R(1.0), time, EMA_R(0.0)};
        const double x[2] = {1.0, (double)time};
        const ema_real value = EMA_R(0.1) + (EMA_R(0.3) * time) + (EMA_R(0.01) * (ema_real)(int32_t)(k % 3U));
        ema_wear_take(&wear, row, value, EMA_R(0.0004));
        for (uint32_t i = 0; i < 2U; ++i) {
            right[i] += x[i] * (double)value / 0.0004;
            normal[i][0] += x[i] * x[0] / 0.0004;
            normal[i][1] += x[i] * x[1] / 0.0004;
        }
    }
    const double det = (normal[0][0] * normal[1][1]) - (normal[0][1] * normal[1][0]);
    const ema_real rate[EMA_WEAR_STATES] = {EMA_R(0.0), EMA_R(1.0), EMA_R(0.0)};
    EMA_ASSERT_CLOSE((ema_real)(((normal[0][0] * right[1]) - (normal[1][0] * right[0])) / det),
                     ema_wear_mean(&wear, rate), 2e-5, 0.0);
    EMA_ASSERT_CLOSE((ema_real)(normal[0][0] / det), ema_wear_variance(&wear, rate), 0.0, 1e-3);
    ema_wear_walk(&wear, EMA_R(0.5));
    EMA_ASSERT_CLOSE((ema_real)(normal[0][0] / det), ema_wear_variance(&wear, rate), 0.0, 1e-3);
}

static void test_normal_tails(void)
{
    for (int32_t k = -90; k <= 90; ++k) {
        const double z = 0.1 * (double)k;
        EMA_ASSERT_CLOSE((ema_real)(0.5 * erfc(z / sqrt(2.0))), ema_normal_above((ema_real)z), EMA_REAL64 ? 1e-7 : 1e-6,
                         0.0);
    }
}

/* Known closed forms: no walk, a walk alone (twice the tail), a walk with a known drift (inverse Gaussian). */
static void test_first_passage(void)
{
    EMA_ASSERT_CLOSE(EMA_R(0.5), ema_reached(EMA_R(0.4), EMA_R(0.4), EMA_R(0.01), EMA_R(0.0)), 1e-6, 0.0);
    EMA_ASSERT_CLOSE((ema_real)erfc(1.0 / sqrt(2.0)), ema_reached(EMA_R(0.2), EMA_R(0.0), EMA_R(0.0), EMA_R(0.04)),
                     1e-6, 0.0);
    for (int32_t k = -5; k <= 5; ++k) {
        const double drift = 0.1 * (double)k;
        const double above = 0.5 * erfc((0.3 - drift) / 0.2 / sqrt(2.0));
        const double back = exp(2.0 * drift * 0.3 / 0.04) * 0.5 * erfc((0.3 + drift) / 0.2 / sqrt(2.0));
        EMA_ASSERT_CLOSE((ema_real)(above + back), ema_reached(EMA_R(0.3), (ema_real)drift, EMA_R(0.0), EMA_R(0.04)),
                         3e-6, 1e-5);
    }
    EMA_ASSERT_CLOSE(EMA_R(1.0), ema_reached(EMA_R(-0.5), EMA_R(0.0), EMA_R(0.001), EMA_R(0.01)), 1e-6, 0.0);
}

static void test_a_pace_that_changes(void)
{
    ema_real going[EMA_FORECAST_TIMES];
    ema_real none[EMA_FORECAST_TIMES];
    const ema_real since = EMA_R(0.4);
    for (uint32_t k = 0; k < EMA_FORECAST_TIMES; ++k) {
        going[k] = (ema_forecast_time(k) >= EMA_R(0.06)) ? EMA_R(1.0) : EMA_R(0.0);
        none[k] = EMA_R(0.0);
    }
    EMA_ASSERT_CLOSE(EMA_FORECAST_HORIZON, ema_forecast_time(EMA_FORECAST_TIMES - 1U), 0.0, 1e-5);
    /* before any change, the first of which comes after 0.105, it is as it was */
    const uint32_t place = 32U;
    TEST_ASSERT_TRUE((ema_forecast_time(place - 1U) > EMA_R(0.06)) && (ema_forecast_time(place) < EMA_R(0.105)));
    EMA_ASSERT_CLOSE(EMA_R(1.0), ema_forecast_share(going, none, since, place), 1e-6, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(0.0), ema_forecast_share(going, going, since, 0U), 0.0, 0.0);
    /* what is stalled goes on later, one fifth at a time, the sooner the shorter it has been, and in the end all is
     * there */
    EMA_ASSERT_CLOSE(EMA_R(0.0), ema_forecast_share(none, going, EMA_R(0.8), place), 1e-6, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(0.2), ema_forecast_share(none, going, EMA_R(0.2), place), 1e-6, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(0.4), ema_forecast_share(none, going, EMA_R(0.06), place), 1e-6, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(1.0), ema_forecast_share(none, going, EMA_R(0.0), place), 1e-6, 0.0);
    EMA_ASSERT_CLOSE(EMA_R(1.0), ema_forecast_share(none, going, since, EMA_FORECAST_TIMES - 1U), 1e-6, 0.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_laws_are_all_others_and_share_what_there_is);
    RUN_TEST(test_wear_stalls_and_goes_on);
    RUN_TEST(test_a_stall_that_lasts_has_been_since_it_began);
    RUN_TEST(test_edges_go_by);
    RUN_TEST(test_rates_are_those_of_what_rises);
    RUN_TEST(test_one_law_is_least_squares_with_a_prior);
    RUN_TEST(test_normal_tails);
    RUN_TEST(test_first_passage);
    RUN_TEST(test_a_pace_that_changes);
    return UNITY_END();
}
