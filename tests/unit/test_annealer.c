/* The annealer: the distribution of its decisions, its cooling and steps, why it ends, and that its path is a function
 * of configuration and costs alone.
 */
#include <math.h>

#include "base/ema_math.h"
#include "ema/ema.h"
#include "ema_rig.h"

#define FOREVER 1000000000U

static ema_annealer_config_t config;
static ema_annealer_t annealer;

void setUp(void)
{
    const ema_annealer_config_t plain = {.dimension = 2U,
                                         .start = {EMA_R(0.3), EMA_R(0.6)},
                                         .first_step = EMA_R(0.2),
                                         .initial_temperature = EMA_R(1.0),
                                         .cooling = EMA_R(0.9),
                                         .function_tolerance = EMA_R(0.0),
                                         .stall_evaluations = 40U,
                                         .reanneal_interval = 0U,
                                         .accept_limit = 0U,
                                         .evaluation_budget = FOREVER,
                                         .seed = 1U};
    config = plain;
    ema_rig_seed(11U);
}

void tearDown(void)
{
}

static void start(void)
{
    (void)memset(&annealer, 0, sizeof annealer);
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_init(&annealer, &config));
}

static bool active(void)
{
    return ema_annealer_outcome(&annealer) == EMA_OUTCOME_ACTIVE;
}

/* A bowl with its lowest point inside the box, the steeper the higher the coordinate. */
static ema_real bowl(const ema_real* x, uint32_t dimension)
{
    ema_real sum = EMA_R(0.0);
    for (uint32_t i = 0; i < dimension; ++i) {
        const ema_real away = x[i] - (EMA_R(0.2) + (EMA_R(0.08) * (ema_real)i));
        sum += (EMA_R(1.0) + (EMA_R(2.0) * (ema_real)i)) * away * away;
    }
    return sum;
}

/* Neither smooth nor with one minimum. */
static ema_real bumpy(const ema_real* x, uint32_t dimension)
{
    return bowl(x, dimension) + (EMA_R(0.05) * ema_sin(EMA_R(40.0) * x[0]))
           + ((x[0] > EMA_R(0.7)) ? EMA_R(0.3) : EMA_R(0.0));
}

static void test_first_candidate_is_the_start(void)
{
    start();
    EMA_ASSERT_SAME_BITS(config.start, ema_annealer_candidate(&annealer), 2U * sizeof(ema_real));
    TEST_ASSERT_TRUE(active());
    TEST_ASSERT_TRUE(ema_annealer_limit(&annealer) > EMA_R(1.0e38));
}

/* A search that is restarted before its first cost goes the way of one that began there. */
static void test_restart_is_another_beginning(void)
{
    const ema_real elsewhere[2] = {EMA_R(0.9), EMA_R(0.1)};
    static ema_annealer_t begun;
    start();
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_restart(&annealer, elsewhere, EMA_R(0.25)));
    config.start[0] = elsewhere[0];
    config.start[1] = elsewhere[1];
    config.initial_temperature = EMA_R(0.25);
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_init(&begun, &config));
    for (uint32_t k = 0; k < 100U; ++k) {
        EMA_ASSERT_SAME_BITS(ema_annealer_candidate(&begun), ema_annealer_candidate(&annealer), 2U * sizeof(ema_real));
        TEST_ASSERT_TRUE(ema_annealer_limit(&begun) == ema_annealer_limit(&annealer));
        const ema_real cost = bumpy(ema_annealer_candidate(&begun), 2U);
        ema_annealer_tell(&begun, cost);
        ema_annealer_tell(&annealer, cost);
    }
    EMA_ASSERT_SAME_BITS(&begun.random, &annealer.random, sizeof begun.random);
    /* as cold as can be: no step uphill */
    start();
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_restart(&annealer, annealer.config.start, EMA_R(0.0)));
    for (uint32_t k = 0; k < 100U; ++k) {
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, annealer.info.accepted_uphill);
}

static void test_restart_refuses_and_changes_nothing(void)
{
    const ema_real inside[2] = {EMA_R(0.0), EMA_R(1.0)};
    const ema_real outside[2] = {EMA_R(0.5), EMA_R(1.1)};
    static ema_annealer_t before;
    start();
    before = annealer;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_annealer_restart(NULL, inside, EMA_R(1.0)));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_annealer_restart(&annealer, NULL, EMA_R(1.0)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_annealer_restart(&annealer, outside, EMA_R(1.0)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_annealer_restart(&annealer, inside, -EMA_R(1.0)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_annealer_restart(&annealer, inside, EMA_R(2.0e30)));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_annealer_restart(&annealer, inside, (ema_real)NAN));
    EMA_ASSERT_SAME_BITS(&before, &annealer, sizeof before);
    ema_annealer_tell(&annealer, EMA_R(1.0));
    EMA_ASSERT_STATUS(EMA_ERR_ORDER, ema_annealer_restart(&annealer, inside, EMA_R(1.0)));
}

static void test_candidates_stay_in_the_box(void)
{
    for (uint32_t dimension = 1U; dimension <= EMA_ANNEALER_DIMENSION_MAX; ++dimension) {
        config.dimension = dimension;
        for (uint32_t i = 0; i < dimension; ++i) {
            config.start[i] = ((i % 2U) == 0U) ? EMA_R(0.0) : EMA_R(1.0);
        }
        config.cooling = EMA_R(0.995);
        config.first_step = EMA_R(1.0);
        start();
        for (uint32_t k = 0; k < 2000U; ++k) {
            const ema_real* const x = ema_annealer_candidate(&annealer);
            for (uint32_t i = 0; i < dimension; ++i) {
                TEST_ASSERT_TRUE((x[i] >= EMA_R(0.0)) && (x[i] <= EMA_R(1.0)));
            }
            /* lowest outside the box, so that the search presses against its walls */
            ema_annealer_tell(&annealer, (x[0] + EMA_R(1.0)) * (x[0] + EMA_R(1.0)) + bowl(x, dimension));
        }
    }
}

/* Share of uphill steps of `rise` that are accepted at a temperature that hardly falls. */
static double accepted_share(double rise, double temperature, uint32_t trials)
{
    config.initial_temperature = (ema_real)temperature;
    config.cooling = EMA_R(1.0) - (EMA_REAL_EPSILON / EMA_R(2.0));
    start();
    ema_annealer_tell(&annealer, EMA_R(0.0));
    uint32_t accepted = 0U;
    for (uint32_t k = 0; k < trials; ++k) {
        const uint32_t before = annealer.info.accepted;
        TEST_ASSERT_TRUE(annealer.current.cost == EMA_R(0.0));
        ema_annealer_tell(&annealer, (ema_real)rise);
        if (annealer.info.accepted > before) {
            ++accepted;
            /* back down: taken at once, whatever is drawn */
            ema_annealer_tell(&annealer, EMA_R(0.0));
            TEST_ASSERT_EQUAL_UINT32(before + 2U, annealer.info.accepted);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(accepted, annealer.info.accepted_uphill);
    return (double)accepted / trials;
}

static void test_uphill_steps_are_accepted_as_boltzmann_says(void)
{
    const double ratios[6] = {0.05, 0.3, 0.7, 1.0, 2.0, 4.0};
    const uint32_t trials = 20000U;
    for (uint32_t k = 0; k < 6U; ++k) {
        for (uint32_t seed = 1U; seed <= 2U; ++seed) {
            config.seed = seed;
            const double expected = exp(-ratios[k]);
            const double deviation = sqrt(expected * (1.0 - expected) / trials);
            EMA_ASSERT_CLOSE(expected, accepted_share(ratios[k] * 0.37, 0.37, trials), (4.0 * deviation) + 1.0e-3, 0.0);
        }
    }
}

static void test_level_and_downhill_steps_are_always_accepted(void)
{
    config.initial_temperature = EMA_R(1.0e-20);
    start();
    for (uint32_t k = 0; k < 500U; ++k) {
        ema_annealer_tell(&annealer, EMA_R(1.0) - (EMA_R(0.001) * (ema_real)(k / 2U)));
    }
    TEST_ASSERT_EQUAL_UINT32(500U, annealer.info.accepted);
    TEST_ASSERT_EQUAL_UINT32(0U, annealer.info.accepted_uphill);
}

static void test_frozen_search_goes_downhill_only(void)
{
    config.initial_temperature = EMA_R(1.0e-20);
    start();
    ema_annealer_tell(&annealer, EMA_R(1.0));
    for (uint32_t k = 0; k < 500U; ++k) {
        ema_annealer_tell(&annealer, EMA_R(1.001));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, annealer.info.accepted);
}

static void test_temperature_falls_by_its_factor(void)
{
    config.initial_temperature = EMA_R(3.0);
    config.cooling = EMA_R(0.93);
    start();
    for (uint32_t k = 0; k < 300U; ++k) {
        EMA_ASSERT_CLOSE(3.0 * pow(0.93, k), annealer.temperature, 0.0, (k + 1.0) * EMA_EPS);
        ema_annealer_tell(&annealer, bowl(ema_annealer_candidate(&annealer), 2U));
    }
}

static void test_reannealing_raises_the_temperature_to_the_spread_and_widens_the_steps(void)
{
    config.reanneal_interval = 25U;
    config.cooling = EMA_R(0.97);
    start();
    uint32_t seen = 0U;
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_annealer_t before = annealer;
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
        if (annealer.info.reannealed > before.info.reannealed) {
            ema_real spread = EMA_R(0.0);
            for (uint32_t p = 0; p < annealer.point_count; ++p) {
                spread = ema_max(spread, annealer.points[p].cost - annealer.best.cost);
            }
            TEST_ASSERT_TRUE(annealer.temperature == ema_max(before.temperature * config.cooling, spread));
            TEST_ASSERT_EQUAL_UINT32(0U, annealer.accepted_since);
            TEST_ASSERT_EQUAL_UINT32(25U, before.accepted_since + 1U);
            ++seen;
        } else {
            TEST_ASSERT_TRUE(annealer.temperature == (before.temperature * config.cooling));
        }
    }
    TEST_ASSERT_TRUE(seen > 3U);
    TEST_ASSERT_EQUAL_UINT32(seen, annealer.info.reannealed);
}

static void test_reannealing_never_narrows_a_step(void)
{
    config.reanneal_interval = 30U;
    config.first_step = EMA_R(0.05);
    config.cooling = EMA_R(0.97);
    config.initial_temperature = EMA_R(10.0);
    start();
    uint32_t widened = 0U;
    for (uint32_t k = 0; k < 3000U; ++k) {
        const ema_annealer_t before = annealer;
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
        if (annealer.info.reannealed > before.info.reannealed) {
            for (uint32_t i = 0; i < 2U; ++i) {
                /* the decision just before may have shrunk it once */
                TEST_ASSERT_TRUE(annealer.step[i] >= (EMA_R(0.64) * before.step[i]));
                widened += (annealer.step[i] > before.step[i]) ? 1U : 0U;
            }
        }
    }
    TEST_ASSERT_TRUE(widened > 5U);
}

static void test_interval_of_zero_never_reanneals(void)
{
    start();
    for (uint32_t k = 0; k < 1000U; ++k) {
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
    }
    TEST_ASSERT_EQUAL_UINT32(0U, annealer.info.reannealed);
    TEST_ASSERT_TRUE(annealer.info.accepted > 100U);
}

static void test_step_grows_when_accepted_and_shrinks_when_refused(void)
{
    config.cooling = EMA_R(0.999);
    start();
    uint32_t grown = 0U;
    uint32_t shrunk = 0U;
    for (uint32_t k = 0; k < 3000U; ++k) {
        const ema_annealer_t before = annealer;
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
        for (uint32_t i = 0; i < 2U; ++i) {
            const ema_real ratio = annealer.step[i] / before.step[i];
            if (!before.walked || (i != before.coordinate)) {
                TEST_ASSERT_TRUE(ratio == EMA_R(1.0));
            } else if (annealer.info.accepted > before.info.accepted) {
                TEST_ASSERT_TRUE((ratio > EMA_R(1.0)) || (annealer.step[i] == EMA_R(1.0)));
                ++grown;
            } else {
                TEST_ASSERT_TRUE((ratio < EMA_R(1.0)) || (annealer.step[i] < EMA_R(2.0e-6)));
                ++shrunk;
            }
        }
    }
    TEST_ASSERT_TRUE((grown > 20U) && (shrunk > 20U));
}

static void test_walk_moves_one_coordinate_at_a_time_in_turn(void)
{
    config.dimension = 3U;
    config.start[2] = EMA_R(0.5);
    start();
    uint32_t walks = 0U;
    uint32_t expected = 0U;
    for (uint32_t k = 0; k < 3000U; ++k) {
        if (annealer.walked) {
            TEST_ASSERT_EQUAL_UINT32(expected, annealer.coordinate);
            for (uint32_t i = 0; i < 3U; ++i) {
                TEST_ASSERT_TRUE((i == annealer.coordinate) || (annealer.candidate.x[i] == annealer.current.x[i]));
            }
            expected = (expected + 1U) % 3U;
            ++walks;
        }
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 3U));
    }
    TEST_ASSERT_TRUE(walks > 100U);
}

static void test_steps_of_the_walk_settle_at_an_acceptance_of_0_44(void)
{
    /* on a plane at a fixed temperature nothing but the step decides; a quadratic cannot be fitted to a plane */
    config.dimension = 1U;
    config.initial_temperature = EMA_R(0.01);
    config.cooling = EMA_R(1.0) - (EMA_REAL_EPSILON / EMA_R(2.0));
    start();
    uint32_t walks = 0U;
    uint32_t accepted = 0U;
    for (uint32_t k = 0; k < 40000U; ++k) {
        const ema_annealer_t before = annealer;
        ema_annealer_tell(&annealer, ema_abs(ema_annealer_candidate(&annealer)[0] - EMA_R(0.5)));
        if (before.walked && (k > 1000U)) {
            ++walks;
            accepted += annealer.info.accepted - before.info.accepted;
        }
    }
    TEST_ASSERT_TRUE(walks > 2000U);
    EMA_ASSERT_CLOSE(0.44, (double)accepted / walks, 0.05, 0.0);
}

static void test_best_is_the_least_cost_of_all_and_its_point(void)
{
    config.cooling = EMA_R(0.999);
    start();
    ema_real least = EMA_R(1.0e30);
    ema_real at[2] = {EMA_R(0.0), EMA_R(0.0)};
    for (uint32_t k = 0; k < 2000U; ++k) {
        const ema_real* const x = ema_annealer_candidate(&annealer);
        const ema_real cost = bumpy(x, 2U);
        if (cost < least) {
            least = cost;
            at[0] = x[0];
            at[1] = x[1];
        }
        ema_annealer_tell(&annealer, cost);
        TEST_ASSERT_TRUE(annealer.best.cost == least);
        EMA_ASSERT_SAME_BITS(at, annealer.best.x, sizeof at);
    }
    /* at this temperature the search wandered off its best point */
    TEST_ASSERT_TRUE(annealer.info.accepted_uphill > 100U);
}

static void test_ends_by_budget(void)
{
    config.evaluation_budget = 57U;
    start();
    while (active()) {
        TEST_ASSERT_TRUE(annealer.info.evaluations < 57U);
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
    }
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, ema_annealer_outcome(&annealer));
    TEST_ASSERT_EQUAL_UINT32(57U, annealer.info.evaluations);
}

static void test_ends_by_count_of_accepted(void)
{
    config.accept_limit = 31U;
    start();
    while (active()) {
        TEST_ASSERT_TRUE(annealer.info.accepted < 31U);
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
    }
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_COUNT, ema_annealer_outcome(&annealer));
    TEST_ASSERT_EQUAL_UINT32(31U, annealer.info.accepted);
}

static void test_ends_by_tolerance_after_its_stall_window(void)
{
    config.initial_temperature = EMA_R(1.0e-4);
    config.function_tolerance = EMA_R(1.0e-3);
    config.stall_evaluations = 23U;
    start();
    ema_annealer_tell(&annealer, EMA_R(2.0));
    uint32_t after = 0U;
    while (active()) {
        /* improves by less than the tolerance: no reason to go on */
        ema_annealer_tell(&annealer, EMA_R(2.0) - EMA_R(0.0009));
        ++after;
    }
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, ema_annealer_outcome(&annealer));
    TEST_ASSERT_EQUAL_UINT32(23U, after);
}

static void test_improvement_beyond_the_tolerance_opens_a_new_window(void)
{
    config.initial_temperature = EMA_R(1.0e-4);
    config.function_tolerance = EMA_R(1.0e-3);
    config.stall_evaluations = 23U;
    start();
    ema_annealer_tell(&annealer, EMA_R(2.0));
    for (uint32_t k = 0; k < 20U; ++k) {
        ema_annealer_tell(&annealer, EMA_R(2.0));
    }
    ema_annealer_tell(&annealer, EMA_R(1.9));
    uint32_t after = 0U;
    while (active()) {
        ema_annealer_tell(&annealer, EMA_R(1.95));
        ++after;
    }
    TEST_ASSERT_EQUAL_UINT32(23U, after);
}

static void test_hot_search_does_not_end_by_tolerance(void)
{
    config.function_tolerance = EMA_R(1.0e-3);
    config.initial_temperature = EMA_R(1.0);
    config.cooling = EMA_R(0.9);
    config.stall_evaluations = 5U;
    start();
    while (active()) {
        TEST_ASSERT_TRUE(annealer.temperature > EMA_R(1.0e-3));
        ema_annealer_tell(&annealer, EMA_R(2.0));
    }
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_TOLERANCE, ema_annealer_outcome(&annealer));
    TEST_ASSERT_TRUE(annealer.temperature <= EMA_R(1.0e-3));
}

static void test_nothing_happens_after_the_end(void)
{
    config.evaluation_budget = 10U;
    start();
    while (active()) {
        ema_annealer_tell(&annealer, bowl(ema_annealer_candidate(&annealer), 2U));
    }
    const ema_annealer_t before = annealer;
    ema_annealer_tell(&annealer, EMA_R(-5.0));
    EMA_ASSERT_SAME_BITS(&before, &annealer, sizeof before);
}

static void test_cost_above_the_limit_counts_the_same_however_large(void)
{
    const ema_real excess[3] = {EMA_R(0.0), EMA_R(3.0), EMA_R(1.0e20)};
    config.reanneal_interval = 20U;
    config.cooling = EMA_R(0.95);
    for (uint32_t dimension = 1U; dimension <= EMA_ANNEALER_DIMENSION_MAX; ++dimension) {
        config.dimension = dimension;
        for (uint32_t f = 0; f < 3U; ++f) {
            start();
            ema_annealer_t given_up = annealer;
            uint32_t above = 0U;
            for (uint32_t k = 0; k < 600U; ++k) {
                const ema_real limit = ema_annealer_limit(&annealer);
                const ema_real cost = bumpy(ema_annealer_candidate(&annealer), dimension);
                EMA_ASSERT_SAME_BITS(annealer.candidate.x, given_up.candidate.x, dimension * sizeof(ema_real));
                TEST_ASSERT_TRUE(limit == ema_annealer_limit(&given_up));
                const bool beyond = cost > limit;
                ema_annealer_tell(&annealer, cost);
                /* what is told for it: the next number above the limit, and far above */
                const ema_real next = limit + (EMA_R(2.0) * EMA_REAL_EPSILON * ema_abs(limit)) + EMA_R(1.0e-30);
                ema_annealer_tell(&given_up, beyond ? (next + excess[f]) : cost);
                above += beyond ? 1U : 0U;
            }
            given_up.last_cost = annealer.last_cost;
            EMA_ASSERT_SAME_BITS(&annealer, &given_up, sizeof annealer);
            TEST_ASSERT_TRUE(above > 50U);
        }
    }
}

static void test_limit_is_never_below_what_would_be_accepted(void)
{
    config.cooling = EMA_R(0.98);
    start();
    for (uint32_t k = 0; k < 1000U; ++k) {
        const uint32_t before = annealer.info.accepted;
        const ema_real limit = ema_annealer_limit(&annealer);
        const ema_real cost = bumpy(ema_annealer_candidate(&annealer), 2U);
        ema_annealer_tell(&annealer, cost);
        TEST_ASSERT_TRUE((annealer.info.accepted == before) || (cost <= limit));
    }
}

static void test_costs_that_are_no_numbers_are_counted_and_never_accepted(void)
{
    const ema_real bad[3] = {(ema_real)NAN, (ema_real)INFINITY, (ema_real)-INFINITY};
    config.cooling = EMA_R(0.97);
    start();
    uint32_t told = 0U;
    for (uint32_t k = 0; k < 600U; ++k) {
        const ema_annealer_t before = annealer;
        if ((k % 3U) == 0U) {
            ema_annealer_tell(&annealer, bad[(k / 3U) % 3U]);
            ++told;
            TEST_ASSERT_EQUAL_UINT32(before.info.accepted, annealer.info.accepted);
            TEST_ASSERT_TRUE(before.best.cost == annealer.best.cost);
            TEST_ASSERT_EQUAL_UINT32(before.point_count, annealer.point_count);
        } else {
            ema_annealer_tell(&annealer, bowl(ema_annealer_candidate(&annealer), 2U));
        }
        TEST_ASSERT_EQUAL_UINT32(told, annealer.info.not_finite);
        TEST_ASSERT_TRUE(isfinite((double)annealer.temperature));
    }
    TEST_ASSERT_TRUE(annealer.best.cost < EMA_R(0.01));
}

static void test_search_without_a_single_number_ends_by_budget(void)
{
    config.evaluation_budget = 200U;
    config.reanneal_interval = 10U;
    start();
    while (active()) {
        ema_annealer_tell(&annealer, (ema_real)NAN);
    }
    TEST_ASSERT_EQUAL_INT(EMA_OUTCOME_BUDGET, ema_annealer_outcome(&annealer));
    TEST_ASSERT_EQUAL_UINT32(0U, annealer.info.accepted);
    TEST_ASSERT_EQUAL_UINT32(200U, annealer.info.not_finite);
}

static void test_copy_is_a_checkpoint(void)
{
    config.reanneal_interval = 20U;
    start();
    for (uint32_t k = 0; k < 333U; ++k) {
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
    }
    ema_annealer_t copy = annealer;
    for (uint32_t k = 0; k < 333U; ++k) {
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
        ema_annealer_tell(&copy, bumpy(ema_annealer_candidate(&copy), 2U));
    }
    EMA_ASSERT_SAME_BITS(&annealer, &copy, sizeof copy);
}

static void test_same_seed_same_path_other_seed_other_path(void)
{
    start();
    ema_annealer_t same = annealer;
    ema_annealer_t other;
    (void)memset(&same, 0, sizeof same);
    (void)memset(&other, 0, sizeof other);
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_init(&same, &config));
    config.seed = 2U;
    EMA_ASSERT_STATUS(EMA_OK, ema_annealer_init(&other, &config));
    uint32_t differing = 0U;
    for (uint32_t k = 0; k < 200U; ++k) {
        EMA_ASSERT_SAME_BITS(annealer.candidate.x, same.candidate.x, 2U * sizeof(ema_real));
        differing += (annealer.candidate.x[0] != other.candidate.x[0]) ? 1U : 0U;
        ema_annealer_tell(&annealer, bumpy(ema_annealer_candidate(&annealer), 2U));
        ema_annealer_tell(&same, bumpy(ema_annealer_candidate(&same), 2U));
        ema_annealer_tell(&other, bumpy(ema_annealer_candidate(&other), 2U));
    }
    /* the start is the same, nothing after it */
    TEST_ASSERT_TRUE(differing >= 198U);
}

/* Runs of a search with many seeds: how many end within `tolerance` of the lowest cost in `budget` evaluations. */
static uint32_t successes(ema_real (*cost)(const ema_real*, uint32_t), double lowest, double tolerance, uint32_t budget,
                          uint32_t seeds)
{
    uint32_t found = 0U;
    config.evaluation_budget = budget;
    for (uint32_t seed = 1U; seed <= seeds; ++seed) {
        config.seed = seed;
        start();
        while (active()) {
            ema_annealer_tell(&annealer, cost(ema_annealer_candidate(&annealer), config.dimension));
        }
        found += (((double)annealer.best.cost - lowest) <= tolerance) ? 1U : 0U;
    }
    return found;
}

static void test_lowest_point_of_bowls_in_one_to_eight_dimensions(void)
{
    const uint32_t budget[EMA_ANNEALER_DIMENSION_MAX] = {40U, 75U, 125U, 175U, 200U, 250U, 350U, 450U};
    for (uint32_t dimension = 1U; dimension <= EMA_ANNEALER_DIMENSION_MAX; ++dimension) {
        config.dimension = dimension;
        for (uint32_t i = 0; i < dimension; ++i) {
            config.start[i] = EMA_R(0.9);
        }
        config.cooling = EMA_R(1.0) - (EMA_R(18.0) / (ema_real)budget[dimension - 1U]);
        TEST_ASSERT_EQUAL_UINT32(50U, successes(bowl, 0.0, 1.0e-6, budget[dimension - 1U], 50U));
    }
}

/* A bowl whose axes are not the coordinates'. */
static ema_real turned(const ema_real* x, uint32_t dimension)
{
    ema_real sum = bowl(x, dimension);
    for (uint32_t i = 1; i < dimension; ++i) {
        const ema_real a = x[i - 1U] - (EMA_R(0.2) + (EMA_R(0.08) * (ema_real)(i - 1U)));
        const ema_real b = x[i] - (EMA_R(0.2) + (EMA_R(0.08) * (ema_real)i));
        sum += EMA_R(4.0) * (a - b) * (a - b);
    }
    return sum;
}

static void test_lowest_point_of_turned_bowls(void)
{
    const uint32_t budget[EMA_ANNEALER_DIMENSION_MAX] = {40U, 75U, 125U, 175U, 600U, 800U, 1000U, 1200U};
    for (uint32_t dimension = 2U; dimension <= EMA_ANNEALER_DIMENSION_MAX; ++dimension) {
        config.dimension = dimension;
        for (uint32_t i = 0; i < dimension; ++i) {
            config.start[i] = EMA_R(0.9);
        }
        config.cooling = EMA_R(1.0) - (EMA_R(18.0) / (ema_real)budget[dimension - 1U]);
        /* above four dimensions the quadratic is separable, and these axes are learnt by walking */
        const double tolerance = (dimension <= 4U) ? 1.0e-6 : 1.0e-3;
        TEST_ASSERT_TRUE(successes(turned, 0.0, tolerance, budget[dimension - 1U], 50U) >= 49U);
    }
}

/* Rosenbrock's valley, scaled into the box: lowest at (0.75, 0.75), cost 0. */
static ema_real valley(const ema_real* x, uint32_t dimension)
{
    ema_real sum = EMA_R(0.0);
    for (uint32_t i = 1; i < dimension; ++i) {
        const ema_real a = (EMA_R(4.0) * x[i - 1U]) - EMA_R(2.0);
        const ema_real b = (EMA_R(4.0) * x[i]) - EMA_R(2.0);
        const ema_real off = b - (a * a);
        sum += (EMA_R(10.0) * off * off) + ((EMA_R(1.0) - a) * (EMA_R(1.0) - a));
    }
    return sum;
}

static void test_lowest_point_of_a_curved_valley(void)
{
    config.start[0] = EMA_R(0.1);
    config.start[1] = EMA_R(0.9);
    config.initial_temperature = EMA_R(10.0);
    config.cooling = EMA_R(0.96);
    config.reanneal_interval = 100U;
    const uint32_t found = successes(valley, 0.0, 1.0e-4, 700U, 50U);
    TEST_ASSERT_TRUE(found >= 45U);
    /* and it is no trivial task: a tenth of the budget does not do */
    TEST_ASSERT_TRUE(successes(valley, 0.0, 1.0e-4, 70U, 50U) < 25U);
}

/* A bowl with ridges: a search that only goes downhill from its start is caught far from the lowest point. */
static ema_real ridges(const ema_real* x, uint32_t dimension)
{
    ema_real sum = EMA_R(0.0);
    for (uint32_t i = 0; i < dimension; ++i) {
        const ema_real away = x[i] - EMA_R(0.3);
        sum += (EMA_R(4.0) * away * away) + (EMA_R(0.15) * (EMA_R(1.0) - ema_cos(EMA_R(31.41592654) * away)));
    }
    return sum;
}

static void test_heat_carries_over_ridges(void)
{
    config.start[0] = EMA_R(0.95);
    config.start[1] = EMA_R(0.95);
    config.first_step = EMA_R(0.1);
    config.initial_temperature = EMA_R(1.0);
    config.cooling = EMA_R(0.99);
    TEST_ASSERT_TRUE(successes(ridges, 0.0, 1.0e-2, 1000U, 50U) >= 45U);
}

/* A valley that leaves the box: its lowest point inside lies on a wall, and elsewhere along it than the valley's own.
 */
static ema_real leaving(const ema_real* x, uint32_t dimension)
{
    (void)dimension;
    const ema_real beyond = x[0] - EMA_R(1.2);
    const ema_real aside = (x[1] - EMA_R(0.5)) + (EMA_R(0.8) * beyond);
    return (EMA_R(100.0) * aside * aside) + (beyond * beyond);
}

static void test_lowest_point_on_a_wall(void)
{
    config.function_tolerance = EMA_R(1.0e-7);
    TEST_ASSERT_TRUE(successes(leaving, 0.04, 1.0e-5, 400U, 50U) >= 35U);
}

static void assert_refused(unsigned line)
{
    (void)memset(&annealer, 0x5A, sizeof annealer);
    const ema_annealer_t before = annealer;
    ema_assert_status(EMA_ERR_RANGE, ema_annealer_init(&annealer, &config), line);
    ema_assert_same_bits(&before, &annealer, sizeof before, line);
    setUp();
}

static void test_init_needs_its_pointers(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_annealer_init(NULL, &config));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_annealer_init(&annealer, NULL));
}

static void test_init_refuses_a_dimension_out_of_range(void)
{
    config.dimension = 0U;
    assert_refused(__LINE__);
    config.dimension = 9U;
    assert_refused(__LINE__);
}

static void test_init_refuses_a_start_outside_the_box(void)
{
    const ema_real bad[3] = {EMA_R(-0.001), EMA_R(1.001), (ema_real)NAN};
    for (uint32_t k = 0; k < 3U; ++k) {
        config.start[1] = bad[k];
        assert_refused(__LINE__);
    }
    /* coordinates beyond the dimension are not looked at */
    config.start[2] = (ema_real)NAN;
    start();
}

static void test_init_refuses_a_first_step_out_of_range(void)
{
    const ema_real bad[4] = {EMA_R(0.0), EMA_R(-0.1), EMA_R(1.001), (ema_real)NAN};
    for (uint32_t k = 0; k < 4U; ++k) {
        config.first_step = bad[k];
        assert_refused(__LINE__);
    }
}

static void test_init_refuses_a_temperature_out_of_range(void)
{
    const ema_real bad[4] = {EMA_R(0.0), EMA_R(-1.0), (ema_real)NAN, (ema_real)INFINITY};
    for (uint32_t k = 0; k < 4U; ++k) {
        config.initial_temperature = bad[k];
        assert_refused(__LINE__);
    }
}

static void test_init_refuses_a_cooling_out_of_range(void)
{
    const ema_real bad[4] = {EMA_R(0.0), EMA_R(1.0), EMA_R(-0.5), (ema_real)NAN};
    for (uint32_t k = 0; k < 4U; ++k) {
        config.cooling = bad[k];
        assert_refused(__LINE__);
    }
}

static void test_init_refuses_a_tolerance_out_of_range(void)
{
    const ema_real bad[3] = {EMA_R(-1.0e-9), (ema_real)NAN, (ema_real)INFINITY};
    for (uint32_t k = 0; k < 3U; ++k) {
        config.function_tolerance = bad[k];
        assert_refused(__LINE__);
    }
}

static void test_init_refuses_no_window_and_no_budget(void)
{
    config.stall_evaluations = 0U;
    assert_refused(__LINE__);
    config.evaluation_budget = 0U;
    assert_refused(__LINE__);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_first_candidate_is_the_start);
    RUN_TEST(test_restart_is_another_beginning);
    RUN_TEST(test_restart_refuses_and_changes_nothing);
    RUN_TEST(test_candidates_stay_in_the_box);
    RUN_TEST(test_uphill_steps_are_accepted_as_boltzmann_says);
    RUN_TEST(test_level_and_downhill_steps_are_always_accepted);
    RUN_TEST(test_frozen_search_goes_downhill_only);
    RUN_TEST(test_temperature_falls_by_its_factor);
    RUN_TEST(test_reannealing_raises_the_temperature_to_the_spread_and_widens_the_steps);
    RUN_TEST(test_reannealing_never_narrows_a_step);
    RUN_TEST(test_interval_of_zero_never_reanneals);
    RUN_TEST(test_step_grows_when_accepted_and_shrinks_when_refused);
    RUN_TEST(test_walk_moves_one_coordinate_at_a_time_in_turn);
    RUN_TEST(test_steps_of_the_walk_settle_at_an_acceptance_of_0_44);
    RUN_TEST(test_best_is_the_least_cost_of_all_and_its_point);
    RUN_TEST(test_ends_by_budget);
    RUN_TEST(test_ends_by_count_of_accepted);
    RUN_TEST(test_ends_by_tolerance_after_its_stall_window);
    RUN_TEST(test_improvement_beyond_the_tolerance_opens_a_new_window);
    RUN_TEST(test_hot_search_does_not_end_by_tolerance);
    RUN_TEST(test_nothing_happens_after_the_end);
    RUN_TEST(test_cost_above_the_limit_counts_the_same_however_large);
    RUN_TEST(test_limit_is_never_below_what_would_be_accepted);
    RUN_TEST(test_costs_that_are_no_numbers_are_counted_and_never_accepted);
    RUN_TEST(test_search_without_a_single_number_ends_by_budget);
    RUN_TEST(test_copy_is_a_checkpoint);
    RUN_TEST(test_same_seed_same_path_other_seed_other_path);
    RUN_TEST(test_lowest_point_of_bowls_in_one_to_eight_dimensions);
    RUN_TEST(test_lowest_point_of_turned_bowls);
    RUN_TEST(test_lowest_point_of_a_curved_valley);
    RUN_TEST(test_heat_carries_over_ridges);
    RUN_TEST(test_lowest_point_on_a_wall);
    RUN_TEST(test_init_needs_its_pointers);
    RUN_TEST(test_init_refuses_a_dimension_out_of_range);
    RUN_TEST(test_init_refuses_a_start_outside_the_box);
    RUN_TEST(test_init_refuses_a_first_step_out_of_range);
    RUN_TEST(test_init_refuses_a_temperature_out_of_range);
    RUN_TEST(test_init_refuses_a_cooling_out_of_range);
    RUN_TEST(test_init_refuses_a_tolerance_out_of_range);
    RUN_TEST(test_init_refuses_no_window_and_no_budget);
    return UNITY_END();
}
