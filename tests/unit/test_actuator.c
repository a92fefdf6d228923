/* Defaults, ranges and access by index: each of them read from the two lists again, row by row. */
#include <math.h>

#include "base/ema_bounds.h"
#include "ema_rig.h"

void setUp(void)
{
}

void tearDown(void)
{
}

/* The rows of the lists as this test reads them: values first, options after them. */
typedef struct {
    double nominal;
    double lower;
    double upper;
} row_t;

static const row_t rows[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {(nominal), (lower), (upper)},
#include "ema/ema_params.def"
#define EMA_P(field, nominal, lower, upper, text) {(nominal), (lower), (upper)},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
#include "ema/ema_effects.def"
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) {(nominal), (lower), (upper)},
#include "ema/ema_params.def"
};

#define ROW_COUNT (sizeof(rows) / sizeof(rows[0]))

static int32_t* option_of(ema_actuator_t* actuator, size_t row)
{
    return &((int32_t*)(void*)&actuator->options)[row - EMA_VALUE_COUNT];
}

/* Sets any row; options take whole numbers. */
static void set_row(ema_actuator_t* actuator, size_t row, double value)
{
    if (row < EMA_VALUE_COUNT) {
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(actuator, (ema_value_id_t)row, (ema_real)value));
    } else {
        *option_of(actuator, row) = (int32_t)value;
    }
}

static void test_counts_agree(void)
{
    TEST_ASSERT_EQUAL_size_t(ROW_COUNT, EMA_VALUE_COUNT + EMA_OPTION_COUNT);
    TEST_ASSERT_EQUAL_size_t(EMA_VALUE_COUNT, EMA_PARAM_COUNT + EMA_EFFECT_VALUE_COUNT);
}

static void test_range_has_every_row_and_no_more(void)
{
    for (size_t row = 0; row < ROW_COUNT; ++row) {
        const ema_range_t* const range = ema_actuator_range(row);
        TEST_ASSERT_NOT_NULL(range);
        TEST_ASSERT_TRUE(range->nominal == (ema_real)rows[row].nominal);
        TEST_ASSERT_TRUE(range->lower == (ema_real)rows[row].lower);
        TEST_ASSERT_TRUE(range->upper == (ema_real)rows[row].upper);
        TEST_ASSERT_TRUE(range->lower < range->upper);
    }
    TEST_ASSERT_NULL(ema_actuator_range(ROW_COUNT));
    TEST_ASSERT_NULL(ema_actuator_range(SIZE_MAX));
}

/* The module's own bounds share one row for the nodes of a table; what they say is the list. */
static void test_bounds_are_those_of_the_ranges(void)
{
    ema_bounds_t bounds = {EMA_R(0.0), EMA_R(0.0)};
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        const ema_range_t* const range = ema_actuator_range(id);
        TEST_ASSERT_TRUE(ema_bounds_of(id, &bounds));
        TEST_ASSERT_TRUE(bounds.lower == range->lower);
        TEST_ASSERT_TRUE(bounds.upper == range->upper);
    }
    const ema_bounds_t last = bounds;
    TEST_ASSERT_FALSE(ema_bounds_of(EMA_VALUE_COUNT, &bounds));
    EMA_ASSERT_SAME_BITS(&last, &bounds, sizeof last);
}

static void test_defaults_are_the_nominal_column(void)
{
    EMA_GUARDED(ema_actuator_t) box;
    EMA_GUARD_SET(box);
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_defaults(&box.value));
    EMA_ASSERT_GUARDS(box);
#define EMA_PARAM(section, field, nominal, lower, upper, text)                                                         \
    TEST_ASSERT_TRUE(box.value.params.field == EMA_R(nominal));
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)                                               \
    TEST_ASSERT_EQUAL_INT32(nominal, box.value.options.field);
#include "ema/ema_params.def"
    for (size_t id = EMA_PARAM_COUNT; id < EMA_VALUE_COUNT; ++id) {
        TEST_ASSERT_TRUE(ema_rig_value(&box.value, id) == (ema_real)rows[id].nominal);
    }
}

static void test_every_effect_is_absent_by_default(void)
{
    const ema_actuator_t actuator = ema_rig_actuator();
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    TEST_ASSERT_TRUE(*(const ema_real*)(const void*)&actuator.effects.name == EMA_R(0.0));
#include "ema/ema_effects.def"
}

static void test_defaults_need_an_actuator(void)
{
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_actuator_defaults(NULL));
}

static void test_check_accepts_defaults_and_leaves_the_offender_alone(void)
{
    const ema_actuator_t actuator = ema_rig_actuator();
    size_t offender = 12345U;
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t(12345U, offender);
}

static void test_check_needs_an_actuator(void)
{
    size_t offender = 0U;
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_actuator_check(NULL, &offender));
}

static void test_check_accepts_every_row_at_its_bounds(void)
{
    for (size_t row = 0; row < ROW_COUNT; ++row) {
        ema_actuator_t actuator = ema_rig_actuator();
        set_row(&actuator, row, rows[row].lower);
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_check(&actuator, NULL));
        set_row(&actuator, row, rows[row].upper);
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_check(&actuator, NULL));
    }
}

static void test_check_names_every_row_outside_its_bounds(void)
{
    for (size_t row = 0; row < ROW_COUNT; ++row) {
        const bool option = row >= EMA_VALUE_COUNT;
        const double width = rows[row].upper - rows[row].lower;
        const double beyond = option ? 1.0 : (0.01 * width);
        ema_actuator_t actuator = ema_rig_actuator();
        size_t offender = SIZE_MAX;
        set_row(&actuator, row, rows[row].lower - beyond);
        EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_check(&actuator, &offender));
        TEST_ASSERT_EQUAL_size_t(row, offender);
        /* the largest whole number has none above it */
        if (rows[row].upper < 2147483647.0) {
            offender = SIZE_MAX;
            set_row(&actuator, row, rows[row].upper + beyond);
            EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_check(&actuator, &offender));
            TEST_ASSERT_EQUAL_size_t(row, offender);
        }
    }
}

static void test_check_does_not_need_an_offender(void)
{
    const ema_actuator_t empty = {0};
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_check(&empty, NULL));
}

static void test_check_names_every_value_that_is_not_finite(void)
{
    const double bad[3] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        for (size_t k = 0; k < 3U; ++k) {
            ema_actuator_t actuator = ema_rig_actuator();
            size_t offender = SIZE_MAX;
            set_row(&actuator, id, bad[k]);
            EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_actuator_check(&actuator, &offender));
            TEST_ASSERT_EQUAL_size_t(id, offender);
        }
    }
}

static void test_check_names_the_first_of_several(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    size_t offender = SIZE_MAX;
    actuator.params.csj_Nm = EMA_R(-1.0);
    actuator.params.lead_mm = (ema_real)NAN;
    actuator.options.seed = -1;
    EMA_ASSERT_STATUS(EMA_ERR_NOT_FINITE, ema_actuator_check(&actuator, &offender));
    TEST_ASSERT_EQUAL_size_t(EMA_VALUE_ID(lead_mm), offender);
}

static void test_ids_name_their_fields(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    ema_real mark = EMA_R(1.0);
#define EMA_PARAM(section, field, nominal, lower, upper, text)                                                         \
    mark += EMA_R(1.0);                                                                                                \
    EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&actuator, EMA_VALUE_ID(field), mark));                                 \
    TEST_ASSERT_TRUE(actuator.params.field == mark);                                                                   \
    TEST_ASSERT_TRUE(ema_rig_value(&actuator, EMA_VALUE_ID(field)) == mark);
#include "ema/ema_params.def"
    EMA_ASSERT_STATUS(EMA_OK,
                      ema_actuator_set(&actuator, EMA_EFFECT_VALUE_ID(stribeck_friction, speed_rad_s), EMA_R(3.0)));
    TEST_ASSERT_TRUE(actuator.effects.stribeck_friction.speed_rad_s == EMA_R(3.0));
    EMA_ASSERT_STATUS(EMA_OK,
                      ema_actuator_set(&actuator, EMA_EFFECT_VALUE_ID(spring_load, stiffness_Nm_per_mm), EMA_R(4.0)));
    TEST_ASSERT_TRUE(actuator.effects.spring_load.stiffness_Nm_per_mm == EMA_R(4.0));
}

static void test_set_changes_that_value_alone(void)
{
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        const ema_actuator_t before = ema_rig_actuator();
        ema_actuator_t after = before;
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&after, (ema_value_id_t)id, EMA_R(-77.0)));
        for (size_t other = 0; other < EMA_VALUE_COUNT; ++other) {
            const ema_real expected = (other == id) ? EMA_R(-77.0) : ema_rig_value(&before, other);
            TEST_ASSERT_TRUE(ema_rig_value(&after, other) == expected);
        }
        EMA_ASSERT_SAME_BITS(&before.options, &after.options, sizeof before.options);
    }
}

static void test_get_and_set_refuse_an_id_outside_the_list(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    const ema_actuator_t before = actuator;
    ema_real value = EMA_R(5.0);
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_get(&actuator, (ema_value_id_t)EMA_VALUE_COUNT, &value));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_set(&actuator, (ema_value_id_t)EMA_VALUE_COUNT, value));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_get(&actuator, UINT16_MAX, &value));
    EMA_ASSERT_STATUS(EMA_ERR_RANGE, ema_actuator_set(&actuator, UINT16_MAX, value));
    TEST_ASSERT_TRUE(value == EMA_R(5.0));
    EMA_ASSERT_SAME_BITS(&before, &actuator, sizeof before);
}

static void test_get_and_set_need_their_pointers(void)
{
    ema_actuator_t actuator = ema_rig_actuator();
    ema_real value = EMA_R(0.0);
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_actuator_get(NULL, 0U, &value));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_actuator_get(&actuator, 0U, NULL));
    EMA_ASSERT_STATUS(EMA_ERR_NULL, ema_actuator_set(NULL, 0U, value));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_counts_agree);
    RUN_TEST(test_range_has_every_row_and_no_more);
    RUN_TEST(test_bounds_are_those_of_the_ranges);
    RUN_TEST(test_defaults_are_the_nominal_column);
    RUN_TEST(test_every_effect_is_absent_by_default);
    RUN_TEST(test_defaults_need_an_actuator);
    RUN_TEST(test_check_accepts_defaults_and_leaves_the_offender_alone);
    RUN_TEST(test_check_needs_an_actuator);
    RUN_TEST(test_check_accepts_every_row_at_its_bounds);
    RUN_TEST(test_check_names_every_row_outside_its_bounds);
    RUN_TEST(test_check_does_not_need_an_offender);
    RUN_TEST(test_check_names_every_value_that_is_not_finite);
    RUN_TEST(test_check_names_the_first_of_several);
    RUN_TEST(test_ids_name_their_fields);
    RUN_TEST(test_set_changes_that_value_alone);
    RUN_TEST(test_get_and_set_refuse_an_id_outside_the_list);
    RUN_TEST(test_get_and_set_need_their_pointers);
    return UNITY_END();
}
