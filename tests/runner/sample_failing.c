/* A test source for test_runner.py: one test that fails. */
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void test_that_fails(void)
{
    TEST_FAIL_MESSAGE("failed as intended");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_that_fails);
    return UNITY_END();
}
