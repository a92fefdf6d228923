/* Bounds may hold values of which no model can be made; the search goes around them. */
#include <math.h>

#include "ema/ema.h"
#include "ema_rig.h"

#define ROWS 1500U

static ema_real memory[2U * ROWS];
static ema_actuator_t healthy;
static ema_session_config_t config;
static ema_session_t session;

void setUp(void)
{
}

void tearDown(void)
{
}

/* A session that looks for the viscous damping alone, up to 10 Nm s/rad: two thirds of it are too stiff for the step.
 */
static void start(void)
{
    ema_record_config_t record = ema_rig_real_record(memory, sizeof memory, false);
    const ema_command_t command = ema_rig_chirp(EMA_R(4.0), EMA_R(1.5), EMA_R(1.0e-3));
    ema_record_t made;
    healthy = ema_rig_actuator();
    ema_actuator_t worn = healthy;
    worn.params.viscous_Nm_s_per_rad = EMA_R(4.0e-4);
    ema_rig_record(&made, &record, &worn, &command, ROWS);
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, &healthy, &record));
    config.search = EMA_SEARCH_ANNEALER;
    const ema_identified_t viscous = {EMA_VALUE_ID(viscous_Nm_s_per_rad), EMA_R(1.0e-5), EMA_R(10.0), EMA_R(50.0)};
    config.identified[0] = viscous;
    config.identified_count = 1U;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_init(&session, &config));
    for (uint32_t row = 0; row < ROWS; ++row) {
        ema_sample_t sample;
        EMA_ASSERT_STATUS(EMA_OK, ema_record_read(&made, row, 1U, &sample));
        /* the session's record lies in the same buffer: row by row it is written over with itself */
        EMA_ASSERT_STATUS(EMA_OK, ema_session_feed(&session, &sample));
    }
}

static void test_part_of_the_bounds_makes_no_model(void)
{
    ema_model_t model;
    healthy = ema_rig_actuator();
    healthy.params.viscous_Nm_s_per_rad = EMA_R(10.0);
    EMA_ASSERT_STATUS(EMA_ERR_STIFF, ema_model_init(&model, &healthy, EMA_R(0.0)));
}

static void test_candidate_that_makes_no_model_costs_the_most(void)
{
    start();
    uint32_t refused = 0U;
    while (ema_session_phase(&session) < EMA_PHASE_ASSESSING) {
        const uint32_t before = session.evaluations;
        const double viscous = 1.0e-5 + ((double)ema_annealer_candidate(&session.annealer)[0] * (10.0 - 1.0e-5));
        /* so few steps that at most one run ends in a call */
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 1U));
        if ((session.evaluations > before) && (viscous > 7.0)) {
            TEST_ASSERT_TRUE(session.annealer.last_cost >= EMA_COST_MAX);
            ++refused;
        }
    }
    TEST_ASSERT_TRUE(refused > 0U);
}

static void test_search_ends_with_the_value_of_the_record(void)
{
    start();
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 500U));
    }
    ema_result_t result;
    EMA_ASSERT_STATUS(EMA_OK, ema_session_result(&session, &result));
    EMA_ASSERT_CLOSE(4.0e-4, result.identified[0].estimate, EMA_BY_PRECISION(4.0e-6, 1.0e-6), 0.0);
}

static void test_slices_change_no_bit_around_them(void)
{
    start();
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, UINT32_MAX));
    }
    const ema_random_t whole = session.annealer.random;
    start();
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        EMA_ASSERT_STATUS(EMA_OK, ema_session_run(&session, 7U));
    }
    EMA_ASSERT_SAME_BITS(&whole, &session.annealer.random, sizeof whole);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_part_of_the_bounds_makes_no_model);
    RUN_TEST(test_candidate_that_makes_no_model_costs_the_most);
    RUN_TEST(test_search_ends_with_the_value_of_the_record);
    RUN_TEST(test_slices_change_no_bit_around_them);
    return UNITY_END();
}
