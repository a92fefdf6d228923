/* The self-test passes on a sound machine, whatever was in its memory, and says what is wrong with an unsound one. What
 * only another build or a damaged image shows is tried on the target: tests/target/selftest.py. */
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "session/ema_selftest_known.h"
#include "unity.h"

/* The bits of the processor's own word for its arithmetic; on others the tests have no mode to try. */
#if defined(__SSE__)
#include <xmmintrin.h>
#define MODES_ARE_KNOWN true
#define FLUSHES 0x8000U
#define ROUNDS_DOWN 0x2000U
#define ROUNDS_UP 0x4000U
static unsigned processor_mode(void)
{
    return _mm_getcsr();
}
static void processor_set_mode(unsigned mode)
{
    _mm_setcsr(mode);
}
#elif defined(__ARM_FP) && defined(__arm__)
#define MODES_ARE_KNOWN true
#define FLUSHES 0x01000000U
#define ROUNDS_UP 0x00400000U
#define ROUNDS_DOWN 0x00800000U
static unsigned processor_mode(void)
{
    unsigned mode;
    __asm__ volatile("vmrs %0, fpscr" : "=r"(mode));
    return mode;
}
static void processor_set_mode(unsigned mode)
{
    __asm__ volatile("vmsr fpscr, %0" : : "r"(mode) : "memory");
}
#else
#define MODES_ARE_KNOWN false
#define FLUSHES 0U
#define ROUNDS_UP 0U
#define ROUNDS_DOWN 0U
static unsigned processor_mode(void)
{
    return 0U;
}
static void processor_set_mode(unsigned mode)
{
    (void)mode;
}
#endif

static ema_selftest_t memory;

void setUp(void)
{
    (void)memset(&memory, 0x5A, sizeof memory);
}

void tearDown(void)
{
}

static void test_passes_in_any_memory_and_again(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_PASSED, ema_selftest(&memory, EMA_SELFTEST_BUILD));
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_PASSED, ema_selftest(&memory, EMA_SELFTEST_BUILD));
}

static void test_zero_is_success(void)
{
    TEST_ASSERT_EQUAL_INT(0, (int)EMA_SELFTEST_PASSED);
}

static void test_expected_values_are_those_of_today(void)
{
    char message[80];
    const uint32_t constants = ema_selftest_constants(&memory.actuator);
    (void)snprintf(message, sizeof message, "EMA_CONSTANTS_KNOWN is now 0x%08lXU", (unsigned long)constants);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(EMA_CONSTANTS_KNOWN, constants, message);
    const uint32_t model = ema_selftest_model(&memory);
    (void)snprintf(message, sizeof message, "EMA_MODEL_KNOWN is now 0x%08lXU", (unsigned long)model);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(EMA_MODEL_KNOWN, model, message);
    const uint32_t search = ema_selftest_search(&memory);
    (void)snprintf(message, sizeof message, "EMA_SEARCH_KNOWN is now 0x%08lXU", (unsigned long)search);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(EMA_SEARCH_KNOWN, search, message);
    TEST_ASSERT_EQUAL_HEX32(search, ema_selftest_search(&memory));
}

static void test_another_actuator_gives_another_model(void)
{
    (void)ema_selftest_constants(&memory.actuator);
    memory.actuator.params.csj_Nm += memory.actuator.params.csj_Nm * EMA_REAL_EPSILON;
    TEST_ASSERT_TRUE(ema_selftest_model(&memory) != EMA_MODEL_KNOWN);
}

static void test_other_values_than_the_expected_are_told(void)
{
    ema_selftest_known_t known = {EMA_CONSTANTS_KNOWN, EMA_MODEL_KNOWN, EMA_SEARCH_KNOWN ^ 1U};
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_SEARCH, ema_selftest_against(&memory, EMA_SELFTEST_BUILD, &known));
    known.model ^= 1U;
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_MODEL, ema_selftest_against(&memory, EMA_SELFTEST_BUILD, &known));
    known.constants ^= 1U;
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_CONSTANTS, ema_selftest_against(&memory, EMA_SELFTEST_BUILD, &known));
}

static void test_a_model_that_cannot_be_made_is_another(void)
{
    (void)ema_selftest_constants(&memory.actuator);
    memory.actuator.params.lead_mm = EMA_R(-1.0);
    TEST_ASSERT_TRUE(ema_selftest_model(&memory) != EMA_MODEL_KNOWN);
}

static void test_a_caller_of_another_build_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_LIBRARY, ema_selftest(&memory, EMA_SELFTEST_BUILD + 1U));
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_LIBRARY, ema_selftest(NULL, EMA_SELFTEST_BUILD + 1U));
}

static void test_no_memory_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(EMA_SELFTEST_NULL, ema_selftest(NULL, EMA_SELFTEST_BUILD));
}

/* The outcome on a processor in a mode, which is left afterwards. */
static ema_selftest_outcome_t outcome_in(unsigned mode)
{
    const unsigned before = processor_mode();
    processor_set_mode(before | mode);
    const ema_selftest_outcome_t found = ema_selftest(&memory, EMA_SELFTEST_BUILD);
    processor_set_mode(before);
    return found;
}

static void test_a_processor_that_rounds_another_way_is_told(void)
{
    static const unsigned ways[] = {ROUNDS_UP, ROUNDS_DOWN, ROUNDS_UP | ROUNDS_DOWN};
    for (size_t k = 0; k < (sizeof ways / sizeof ways[0]); ++k) {
        TEST_ASSERT_EQUAL_INT(MODES_ARE_KNOWN ? EMA_SELFTEST_ARITHMETIC : EMA_SELFTEST_PASSED, outcome_in(ways[k]));
    }
}

static void test_a_processor_that_flushes_small_numbers_is_told(void)
{
    TEST_ASSERT_EQUAL_INT(MODES_ARE_KNOWN ? EMA_SELFTEST_ARITHMETIC : EMA_SELFTEST_PASSED, outcome_in(FLUSHES));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_passes_in_any_memory_and_again);
    RUN_TEST(test_zero_is_success);
    RUN_TEST(test_expected_values_are_those_of_today);
    RUN_TEST(test_another_actuator_gives_another_model);
    RUN_TEST(test_other_values_than_the_expected_are_told);
    RUN_TEST(test_a_model_that_cannot_be_made_is_another);
    RUN_TEST(test_a_caller_of_another_build_is_told);
    RUN_TEST(test_no_memory_is_told);
    RUN_TEST(test_a_processor_that_rounds_another_way_is_told);
    RUN_TEST(test_a_processor_that_flushes_small_numbers_is_told);
    return UNITY_END();
}
