/* A build that leaves effects out: what it holds acts, the rest is refused by name, and the structures are those of
 * every build. */
#include <string.h>

#include "ema/ema.h"
#include "ema_image_rig.h"
#include "unity.h"

/* The effects that the build of this test holds, or none. */
static const char* const held[] = {
#if EMA_TEST_SOME
    "stribeck_friction", "cogging_torque", "inverter_dead_time", "transmission_compliance",
#endif
    ""};

typedef struct {
    const char* name;
    size_t id; /* of its size */
} row_t;

static const row_t rows[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name, EMA_PARAM_COUNT + (offsetof(ema_effects_t, name) / sizeof(ema_real))},
#include "ema/ema_effects.def"
};

#define ROW_COUNT (sizeof(rows) / sizeof(rows[0]))

static ema_actuator_t actuator;
static ema_model_t model;
static ema_session_t session;
static int16_t buffer[400];

void setUp(void)
{
    TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_defaults(&actuator));
}

void tearDown(void)
{
}

static bool is_held(const char* name)
{
    bool found = false;
    for (size_t k = 0; k < (sizeof(held) / sizeof(held[0])); ++k) {
        found = found || (strcmp(held[k], name) == 0);
    }
    return found;
}

static void test_an_effect_that_is_left_out_is_refused_and_named(void)
{
    for (size_t k = 0; k < ROW_COUNT; ++k) {
        const ema_status_t expected = is_held(rows[k].name) ? EMA_OK : EMA_ERR_ABSENT;
        size_t offender = 0U;
        setUp();
        TEST_ASSERT_EQUAL(EMA_OK, ema_actuator_set(&actuator, (ema_value_id_t)rows[k].id,
                                                   EMA_R(0.01) * ema_actuator_range(rows[k].id)->upper));
        TEST_ASSERT_EQUAL_MESSAGE(expected, ema_actuator_check(&actuator, &offender), rows[k].name);
        TEST_ASSERT_EQUAL_size_t((expected == EMA_OK) ? 0U : rows[k].id, offender);
        TEST_ASSERT_EQUAL_MESSAGE(expected, ema_model_init(&model, &actuator, EMA_R(0.0)), rows[k].name);
    }
    TEST_ASSERT_EQUAL_STRING("the configuration asks for what this build leaves out", ema_status_text(EMA_ERR_ABSENT));
}

static void test_a_session_refuses_it_too(void)
{
    const ema_record_config_t record = {.buffer = buffer,
                                        .buffer_bytes = sizeof buffer,
                                        .format = EMA_RECORD_INT16,
                                        .command_full_scale_mm = EMA_R(4.0),
                                        .full_scale = {EMA_R(4.0), EMA_R(4.0), EMA_R(40.0), EMA_R(40.0)}};
    ema_session_config_t config;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, &actuator, &record));
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_init(&session, &config));
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.1);
    TEST_ASSERT_EQUAL(EMA_ERR_ABSENT, ema_session_init(&session, &config));
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.0);
    config.identified[0].id = EMA_EFFECT_VALUE_ID(jam_spot, amplitude_Nm);
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_session_init(&session, &config));
    config.identified[0].id = EMA_EFFECT_VALUE_ID(learned_torque, gain);
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_session_init(&session, &config));
}

/* The bounds of a search lie where they lie in every build. */
static void test_a_search_of_an_effect_is_taken_if_the_build_holds_it(void)
{
    const ema_record_config_t record = {.buffer = buffer,
                                        .buffer_bytes = sizeof buffer,
                                        .format = EMA_RECORD_INT16,
                                        .command_full_scale_mm = EMA_R(4.0),
                                        .full_scale = {EMA_R(4.0), EMA_R(4.0), EMA_R(40.0), EMA_R(40.0)}};
    const ema_value_id_t speed = EMA_EFFECT_VALUE_ID(stribeck_friction, speed_rad_s);
    ema_session_config_t config;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, &actuator, &record));
    config.identified[0].id = speed;
    config.identified[0].lower = ema_actuator_range(speed)->lower;
    config.identified[0].upper = EMA_R(200.0);
    TEST_ASSERT_EQUAL(is_held("stribeck_friction") ? EMA_OK : EMA_ERR_RANGE, ema_session_init(&session, &config));
    config.identified[0].upper = EMA_R(201.0);
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_session_init(&session, &config));
}

static void test_options_and_parameters_are_checked_as_in_every_build(void)
{
    size_t offender = 0U;
    actuator.options.every_steps = 0;
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t(EMA_VALUE_COUNT + (offsetof(ema_options_t, every_steps) / sizeof(int32_t)), offender);
    setUp();
    actuator.params.travel_mm = EMA_R(-1.0);
    TEST_ASSERT_EQUAL(EMA_ERR_RANGE, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t(EMA_VALUE_ID(travel_mm), offender);
}

static void test_a_unit_of_an_image_refuses_it_too(void)
{
    static uint8_t image[2048];
    ema_actuator_t memory;
    ema_unit_t unit;
    const ema_unit_memory_t place = {&memory, NULL, 0U};
    actuator.effects.spring_load.stiffness_Nm_per_mm = EMA_R(0.1);
    const ema_image_rig_unit_t units[] = {{"unit", &actuator, NULL}};
    const uint32_t length = ema_image_rig(image, units, 1U);
    TEST_ASSERT_EQUAL(EMA_IMAGE_OK, ema_image_check(image, length));
    TEST_ASSERT_EQUAL(EMA_IMAGE_ABSENT, ema_image_copy(image, length, 0U, &place, &unit));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_an_effect_that_is_left_out_is_refused_and_named);
    RUN_TEST(test_a_session_refuses_it_too);
    RUN_TEST(test_a_search_of_an_effect_is_taken_if_the_build_holds_it);
    RUN_TEST(test_options_and_parameters_are_checked_as_in_every_build);
    RUN_TEST(test_a_unit_of_an_image_refuses_it_too);
    return UNITY_END();
}
