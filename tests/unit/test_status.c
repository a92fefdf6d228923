/* Every status has its number and a text of its own. */
#include "ema_rig.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static const ema_status_t statuses[] = {
#define EMA_STATUS_NAME(name, value, text) name,
    EMA_STATUS_LIST(EMA_STATUS_NAME)
#undef EMA_STATUS_NAME
};

#define STATUS_COUNT (sizeof(statuses) / sizeof(statuses[0]))

static void test_success_is_zero_and_numbers_have_no_gaps(void)
{
    TEST_ASSERT_EQUAL_INT(0, (int)EMA_OK);
    for (size_t k = 0; k < STATUS_COUNT; ++k) {
        TEST_ASSERT_EQUAL_INT((int)k, (int)statuses[k]);
    }
}

static void test_every_status_has_the_text_of_the_list(void)
{
#define EMA_STATUS_TEXT(name, value, text) TEST_ASSERT_EQUAL_STRING(text, ema_status_text(name));
    EMA_STATUS_LIST(EMA_STATUS_TEXT)
#undef EMA_STATUS_TEXT
}

static void test_texts_differ(void)
{
    for (size_t i = 0; i < STATUS_COUNT; ++i) {
        for (size_t j = 0; j < i; ++j) {
            TEST_ASSERT_TRUE(strcmp(ema_status_text(statuses[i]), ema_status_text(statuses[j])) != 0);
        }
    }
}

static void test_value_outside_the_list_is_unknown(void)
{
    TEST_ASSERT_EQUAL_STRING("unknown status", ema_status_text((ema_status_t)STATUS_COUNT));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_success_is_zero_and_numbers_have_no_gaps);
    RUN_TEST(test_every_status_has_the_text_of_the_list);
    RUN_TEST(test_texts_differ);
    RUN_TEST(test_value_outside_the_list_is_unknown);
    return UNITY_END();
}
