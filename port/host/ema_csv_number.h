/* Decimal text to the nearest double, whatever the locale: short numbers by one exact operation, the C library for the
 * rest. */
#ifndef EMA_CSV_NUMBER_H
#define EMA_CSV_NUMBER_H

typedef enum {
    EMA_NUMBER_OK = 0,
    EMA_NUMBER_EMPTY = 1,
    EMA_NUMBER_TEXT = 2,       /* not a decimal number */
    EMA_NUMBER_NOT_FINITE = 3, /* NaN or infinity in words */
    EMA_NUMBER_HUGE = 4        /* beyond the largest double */
} ema_number_t;

/* Reads all of [begin, end), blanks around the number allowed; `value` is set on EMA_NUMBER_OK alone. The result is
 * correctly rounded. */
ema_number_t ema_csv_number(const char* begin, const char* end, double* value);

#endif
