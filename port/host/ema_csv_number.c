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

/* The double `steps` places above `x` > 0. */
static double ema_neighbour(double x, int64_t steps)
{
    int64_t bits = 0;
    (void)memcpy(&bits, &x, sizeof bits);
    bits += steps;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static bool ema_is_power_of_two(double x)
{
    int exponent = 0;
    return frexp(x, &exponent) == 0.5;
}

/* x y - xy, exactly (T. J. Dekker, Numer. Math. 18, 1971). */
static double ema_product_error(double x, double y, double xy)
{
    const double splitter = 134217729.0;
    const double x_high = (splitter * x) - ((splitter * x) - x);
    const double y_high = (splitter * y) - ((splitter * y) - y);
    const double x_low = x - x_high;
    const double y_low = y - y_high;
    return (((x_high * y_high) - xy) + (x_high * y_low) + (x_low * y_high)) + (x_low * y_low);
}

/* mantissa / power, correctly rounded: the exact remainder of a first quotient says which neighbour is nearest.
 * False when the quotient lies too near the middle of two doubles, or at a power of two where their distance changes.
 */
static bool ema_divide(uint64_t mantissa, double power, double* value)
{
    const double high = (double)mantissa;
    const uint64_t rounded = (uint64_t)high;
    const double low = (mantissa >= rounded) ? (double)(mantissa - rounded) : -(double)(rounded - mantissa);
    const double quotient = high / power;
    const double product = quotient * power;
    const double remainder = ((high - product) + low) - ema_product_error(quotient, power, product);
    const double half = 0.5 * (ema_neighbour(quotient, 1) - quotient) * power;
    const double margin = 1.0e-9 * half;
    int64_t steps = 0;
    if (fabs(remainder) > half) {
        steps = (remainder > 0.0) ? 1 : -1;
    }
    *value = ema_neighbour(quotient, steps);
    return (fabs(fabs(remainder) - half) > margin) && (fabs(remainder) < (2.5 * half)) && !ema_is_power_of_two(quotient)
           && !ema_is_power_of_two(*value);
}

/* The decimal without the C library; false when that is not certain to be correctly rounded. */
static bool ema_decimal_fast(const ema_decimal_t* decimal, double* value)
{
    const int32_t exponent = decimal->exponent;
    bool done = false;
    if (!decimal->complete || (exponent < -EXACT_POWERS) || (exponent > EXACT_POWERS)) {
        done = false;
    } else if (decimal->mantissa <= EXACT_INTEGER) {
        const double mantissa = (double)decimal->mantissa;
        *value = (exponent < 0) ? (mantissa / ema_power_of_ten[-exponent]) : (mantissa * ema_power_of_ten[exponent]);
        done = true;
    } else if (exponent < 0) {
        done = ema_divide(decimal->mantissa, ema_power_of_ten[-exponent], value);
    } else {
        done = false;
    }
    if (done && decimal->negative) {
        *value = -*value;
    }
    return done;
}

/* The C library's conversion with a decimal point, whatever locale the program has set; false when it did not read all
 * of the text. */
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
    const locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
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
    if (!ema_decimal_fast(&decimal, &number)) {
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
