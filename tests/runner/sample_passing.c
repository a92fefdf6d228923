/* A test source for test_runner.py: one test that passes, and setUp and tearDown of its own. */
#include "unity.h"

static int prepared;

void setUp(void)
{
    prepared = 1;
}

void tearDown(void)
{
    prepared = 0;
}

static void test_its_own_set_up_came_first(void)
{
    TEST_ASSERT_EQUAL_INT(1, prepared);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_its_own_set_up_came_first);
    return UNITY_END();
}
