/* A test source for test_runner.py: it runs no test. */
#include "unity.h"

void setUp(void)
{
}

void tearDown(void)
{
}

int main(void)
{
    UNITY_BEGIN();
    return UNITY_END();
}
