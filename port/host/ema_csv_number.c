/* newlocale and uselocale are POSIX. */
#define _POSIX_C_SOURCE 200809L

#include "ema_csv_number.h"

#include <locale.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Powers of ten that a double holds exactly. */
#define EXACT_POWERS 22
static const double ema_power_of_ten[EXACT_POWERS + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                          1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                          1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/* Integers up to here are exact doubles. */
#define EXACT_INTEGER (UINT64_C(1) << 53)

/* Digits that always fit 64 bits. */
#define DIGITS_MAX 19

/* An exponent beyond every double, reached without overflow of the counter. */
#define EXPONENT_MAX 100000

/* More characters than the longest decimal expansion that decides a rounding. */
#define TEXT_MAX 1200

/* What the text says: (-1)^negative * mantissa * 10^exponent, unless digits were left out. */
typedef struct {
    uint64_t mantissa;
    int32_t exponent;
    bool negative;
    bool complete;
} ema_decimal_t;

static bool ema_is_digit(char c)
{
    return (c >= '0') && (c <= '9');
}

static bool ema_is_blank(char c)
{
    return (c == ' ') || (c == '\t');
}

/* True when [begin, end) is `word`, in either case. */
static bool ema_is_word(const char* begin, const char* end, const char* word)
{
    const char* at = begin;
    while ((at < end) && (*word != '\0')) {
        const char lower = ((*at >= 'A') && (*at <= 'Z')) ? (char)(*at - 'A' + 'a') : *at;
        if (lower != *word) {
            return false;
        }
        ++at;
        ++word;
    }
    return (at == end) && (*word == '\0');
}

static bool ema_names_no_number(const char* begin, const char* end)
{
    const char* const start = ((begin < end) && ((*begin == '+') || (*begin == '-'))) ? (begin + 1) : begin;
    return ema_is_word(start, end, "nan") || ema_is_word(start, end, "inf") || ema_is_word(start, end, "infinity");
}

static void ema_decimal_digit(ema_decimal_t* decimal, int32_t* digits, char digit, bool fraction)
{
    if (*digits < DIGITS_MAX) {
        decimal->mantissa = (decimal->mantissa * 10U) + (uint64_t)(digit - '0');
        *digits += (decimal->mantissa != 0U) ? 1 : 0;
        decimal->exponent -= (fraction && (decimal->exponent > -EXPONENT_MAX)) ? 1 : 0;
    } else {
        decimal->complete = false;
        decimal->exponent += (!fraction && (decimal->exponent < EXPONENT_MAX)) ? 1 : 0;
    }
}

/* The exponent behind the `e`; false when there is no number. */
static bool ema_decimal_exponent(ema_decimal_t* decimal, const char** at, const char* end)
{
    const char* p = *at;
    bool negative = false;
    if ((p < end) && ((*p == '+') || (*p == '-'))) {
        negative = *p == '-';
        ++p;
    }
    if ((p == end) || !ema_is_digit(*p)) {
        return false;
    }
    int32_t exponent = 0;
    while ((p < end) && ema_is_digit(*p)) {
        exponent = (exponent < EXPONENT_MAX) ? ((exponent * 10) + (int32_t)(*p - '0')) : exponent;
        ++p;
    }
    decimal->exponent += negative ? -exponent : exponent;
    *at = p;
    return true;
}

/* Splits [begin, end); false when it is not a decimal number. */
static bool ema_decimal_read(ema_decimal_t* decimal, const char* begin, const char* end)
{
    const char* p = begin;
    int32_t digits = 0;
    bool any = false;
    *decimal = (ema_decimal_t){.complete = true};
    if ((p < end) && ((*p == '+') || (*p == '-'))) {
        decimal->negative = *p == '-';
        ++p;
    }
    for (; (p < end) && ema_is_digit(*p); ++p) {
        ema_decimal_digit(decimal, &digits, *p, false);
        any = true;
    }
    if ((p < end) && (*p == '.')) {
        for (++p; (p < end) && ema_is_digit(*p); ++p) {
            ema_decimal_digit(decimal, &digits, *p, true);
            any = true;
        }
    }
    if (any && (p < end) && ((*p == 'e') || (*p == 'E'))) {
        ++p;
        any = ema_decimal_exponent(decimal, &p, end);
    }
    return any && (p == end);
}

/* A short decimal, whose digits and power of ten are exact doubles: one operation, rounded once. False for others. */
static bool ema_decimal_short(const ema_decimal_t* decimal, double* value)
{
    const int32_t exponent = decimal->exponent;
    const bool exact = decimal->complete && (exponent >= -EXACT_POWERS) && (exponent <= EXACT_POWERS)
                       && (decimal->mantissa <= EXACT_INTEGER);
    if (exact) {
        const double mantissa = (double)decimal->mantissa;
        *value = (exponent < 0) ? (mantissa / ema_power_of_ten[-exponent]) : (mantissa * ema_power_of_ten[exponent]);
        *value = decimal->negative ? -*value : *value;
    }
    return exact;
}

/* The C library's conversion with a decimal point, whatever locale the program has set: another one is changed for this
 * thread while it reads. False when it did not read all of the text. */
static bool ema_decimal_library(const char* begin, const char* end, double* value)
{
    char text[TEXT_MAX + 1];
    const size_t length = (size_t)(end - begin);
    if (length > TEXT_MAX) {
        return false;
    }
    (void)memcpy(text, begin, length);
    text[length] = '\0';
    char* stop = text;
    const bool reads_points = strtod("0.5", NULL) == 0.5;
    const locale_t plain = reads_points ? (locale_t)0 : newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0) {
        *value = strtod(text, &stop);
    } else {
        const locale_t before = uselocale(plain);
        *value = strtod(text, &stop);
        (void)uselocale(before);
        freelocale(plain);
    }
    return stop == (text + length);
}

ema_number_t ema_csv_number(const char* begin, const char* end, double* value)
{
    while ((begin < end) && ema_is_blank(*begin)) {
        ++begin;
    }
    while ((begin < end) && ema_is_blank(end[-1])) {
        --end;
    }
    if (begin == end) {
        return EMA_NUMBER_EMPTY;
    }
    ema_decimal_t decimal;
    double number = 0.0;
    if (!ema_decimal_read(&decimal, begin, end)) {
        return ema_names_no_number(begin, end) ? EMA_NUMBER_NOT_FINITE : EMA_NUMBER_TEXT;
    }
    if (!ema_decimal_short(&decimal, &number)) {
        if (!ema_decimal_library(begin, end, &number)) {
            return EMA_NUMBER_TEXT;
        }
        if (!isfinite(number)) {
            return EMA_NUMBER_HUGE;
        }
    }
    *value = number;
    return EMA_NUMBER_OK;
}
