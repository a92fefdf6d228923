/* The texts of the reasons: one for each bit of the list. */
#include "ema/ema.h"
#include "ema_rig.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static void every_reason_has_its_own_bit_and_text(void)
{
    static const struct {
        uint32_t bit;
        const char* text;
    } reasons[] = {
#define ROW(name, bit, text) {(uint32_t)(name), text},
        EMA_REASON_LIST(ROW)
#undef ROW
    };
    const size_t count = sizeof reasons / sizeof reasons[0];
    uint32_t seen = 0U;
    for (size_t k = 0; k < count; ++k) {
        TEST_ASSERT_EQUAL_HEX32((uint32_t)1U << k, reasons[k].bit);
        TEST_ASSERT_EQUAL_STRING(reasons[k].text, ema_reason_text(reasons[k].bit));
        seen |= reasons[k].bit;
    }
    TEST_ASSERT_EQUAL_STRING("unknown reason", ema_reason_text(0U));
    TEST_ASSERT_EQUAL_STRING("unknown reason", ema_reason_text(seen));
    TEST_ASSERT_EQUAL_STRING("unknown reason", ema_reason_text(seen + 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(every_reason_has_its_own_bit_and_text);
    return UNITY_END();
}
