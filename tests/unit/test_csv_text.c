/* Lines for messages are one printable line, whatever is put into them and however little room there is. */
#include <string.h>

#include "ema_close.h"
#include "ema_csv_text.h"

void setUp(void)
{
}

void tearDown(void)
{
}

static char buffer[200];

static const char* foreign(const char* text, size_t limit)
{
    ema_text_t line = ema_text_start(buffer, sizeof buffer);
    ema_text_add_foreign(&line, text, strlen(text), limit);
    return buffer;
}

static void test_good_utf8_passes(void)
{
    static const char* const good[] = {"plain ~",      "\xC3\xA9",         "\xC2\xA0",        "\xE2\x82\xAC",
                                       "\xEF\xBF\xBD", "\xF0\x9F\x98\x80", "\xF4\x8F\xBF\xBF"};
    for (size_t i = 0; i < (sizeof good / sizeof good[0]); ++i) {
        TEST_ASSERT_EQUAL_STRING(good[i], foreign(good[i], 50U));
    }
}

static void test_broken_utf8_and_controls_become_question_marks(void)
{
    TEST_ASSERT_EQUAL_STRING("a?b?c?", foreign("a\nb\x7F"
                                               "c\x1B",
                                               50U));
    TEST_ASSERT_EQUAL_STRING("?", foreign("\xC2\x85", 50U)); /* a control of two bytes */
    TEST_ASSERT_EQUAL_STRING("?x", foreign("\x80x", 50U));   /* a tail alone */
    TEST_ASSERT_EQUAL_STRING("?x", foreign("\xC3x", 50U));   /* a head alone */
    TEST_ASSERT_EQUAL_STRING("?", foreign("\xC3", 50U));
    TEST_ASSERT_EQUAL_STRING("??", foreign("\xC0\xAF", 50U)); /* longer than needed */
    TEST_ASSERT_EQUAL_STRING("???", foreign("\xE0\x80\x80", 50U));
    TEST_ASSERT_EQUAL_STRING("???", foreign("\xED\xA0\x80", 50U));      /* half of a pair */
    TEST_ASSERT_EQUAL_STRING("????", foreign("\xF4\x90\x80\x80", 50U)); /* beyond the last character */
    TEST_ASSERT_EQUAL_STRING("?", foreign("\xFF", 50U));
}

static void test_cuts_fall_between_characters(void)
{
    TEST_ASSERT_EQUAL_STRING("abcd", foreign("abcd", 4U));
    TEST_ASSERT_EQUAL_STRING("abc...", foreign("abcde", 3U));
    TEST_ASSERT_EQUAL_STRING("ab...", foreign("ab\xE2\x82\xAC"
                                              "cde",
                                              4U));
    for (size_t size = 0U; size < 9U; ++size) {
        (void)memset(buffer, '!', sizeof buffer);
        ema_text_t line = ema_text_start(buffer, size);
        ema_text_add_foreign(&line,
                             "a\xE2\x82\xAC"
                             "b\xC3\xA9",
                             7U, 50U);
        ema_text_add(&line, "");
        TEST_ASSERT_EQUAL_CHAR('!', buffer[size]);
        if (size > 0U) {
            static const char* const fits[] = {"",
                                               "",
                                               "a",
                                               "a",
                                               "a",
                                               "a\xE2\x82\xAC",
                                               "a\xE2\x82\xAC"
                                               "b",
                                               "a\xE2\x82\xAC"
                                               "b",
                                               "a\xE2\x82\xAC"
                                               "b\xC3\xA9"};
            TEST_ASSERT_EQUAL_STRING(fits[size], buffer);
        }
    }
}

/* Once something did not fit, nothing shorter is added behind the gap. */
static void test_nothing_follows_a_cut(void)
{
    char small[8];
    ema_text_t line = ema_text_start(small, sizeof small);
    ema_text_add(&line, "12345");
    ema_text_add(&line, "678");
    ema_text_add(&line, "9");
    TEST_ASSERT_EQUAL_STRING("12345", small);
}

static void test_numbers(void)
{
    ema_text_t line = ema_text_start(buffer, sizeof buffer);
    ema_text_add_real(&line, 0.001, 6);
    ema_text_add(&line, " ");
    ema_text_add_real(&line, -12345.678, 4);
    ema_text_add(&line, " ");
    ema_text_add_real(&line, 1.5e-300, 15);
    ema_text_add(&line, " ");
    ema_text_add_whole(&line, INT64_MIN);
    TEST_ASSERT_EQUAL_STRING("0.001 -1.235e+04 1.5e-300 -9223372036854775808", buffer);
}

static void test_the_end_of_a_long_path_is_shown(void)
{
    char path[400];
    char shown[400];
    (void)memset(path, 'd', sizeof path);
    (void)memcpy(path + sizeof path - 9U, "/rec.csv", 9U);
    /* the cut would fall inside this character */
    (void)memcpy(path + sizeof path - 202U, "\xE2\x82\xAC", 3U);
    ema_text_t line = ema_text_start(shown, sizeof shown);
    ema_text_add_path(&line, path);
    TEST_ASSERT_EQUAL_INT(0, strncmp(shown, "...ddd", 6U));
    TEST_ASSERT_EQUAL_STRING("d/rec.csv", shown + strlen(shown) - 9U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_good_utf8_passes);
    RUN_TEST(test_broken_utf8_and_controls_become_question_marks);
    RUN_TEST(test_cuts_fall_between_characters);
    RUN_TEST(test_nothing_follows_a_cut);
    RUN_TEST(test_numbers);
    RUN_TEST(test_the_end_of_a_long_path_is_shown);
    return UNITY_END();
}
