/* The columns of a recording, and what can be wrong with one. */
#ifndef EMA_CSV_COLUMNS_H
#define EMA_CSV_COLUMNS_H

#include <stdint.h>

typedef enum {
    EMA_COLUMN_TIME = 0,           /* s; required */
    EMA_COLUMN_COMMAND = 1,        /* mm; required */
    EMA_COLUMN_POSITION = 2,       /* rod, mm; required */
    EMA_COLUMN_MOTOR_POSITION = 3, /* motor encoder expressed at the rod, mm */
    EMA_COLUMN_CURRENT = 4,        /* A */
    EMA_COLUMN_VOLTAGE = 5,        /* V, applied over the interval that starts at the row */
    EMA_COLUMN_SPEED = 6           /* rod, mm/s */
} ema_column_t;

#define EMA_COLUMN_COUNT 7
#define EMA_COLUMNS_REQUIRED 3

/* Fewest rows of a recording. */
#define EMA_CSV_ROWS_MIN 100

/* Zero is success. */
typedef enum {
    EMA_CSV_OK = 0,
    EMA_CSV_END = 1,       /* no more rows, and nothing is wrong with the recording as such */
    EMA_CSV_OPEN = 2,      /* cannot be opened */
    EMA_CSV_READ = 3,      /* reading failed on the way */
    EMA_CSV_ENCODING = 4,  /* not UTF-8 text, or line ends that are neither LF nor CRLF */
    EMA_CSV_EMPTY = 5,     /* nothing in it, or no rows */
    EMA_CSV_HEADER = 6,    /* no header, another separator, a required column missing or a column twice */
    EMA_CSV_FIELDS = 7,    /* too few or too many fields in a row, or broken quotes */
    EMA_CSV_CUT = 8,       /* the file ends inside a row */
    EMA_CSV_NUMBER = 9,    /* a field is empty, no number, or not finite */
    EMA_CSV_TIME = 10,     /* time does not increase, or not at a constant rate */
    EMA_CSV_SHORT = 11,    /* too few rows */
    EMA_CSV_UNIT = 12,     /* a length that cannot be in millimetres, for this actuator */
    EMA_CSV_PERIOD = 13,   /* not the actuator's record period */
    EMA_CSV_CAPACITY = 14, /* more rows than the caller has room for */
    EMA_CSV_USAGE = 15     /* a null pointer or a size below zero */
} ema_csv_status_t;

/* Name of a column with its unit, as in the header row. */
const char* ema_column_name(ema_column_t column);

#endif
