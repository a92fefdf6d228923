/* One line of text in a buffer of fixed size, for messages: always ended, always printable, cut between characters. */
#ifndef EMA_CSV_TEXT_H
#define EMA_CSV_TEXT_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    char* text;
    size_t size;
    size_t length;
} ema_text_t;

/* Starts an empty line in `buffer`. With size 0 nothing is ever written. */
ema_text_t ema_text_start(char* buffer, size_t size);

/* Adds text of the program. */
void ema_text_add(ema_text_t* line, const char* text);

/* Adds text from outside: control characters and broken UTF-8 become `?`. More than `limit` bytes are cut and end in
 * `...`. */
void ema_text_add_foreign(ema_text_t* line, const char* begin, size_t length, size_t limit);

/* Adds a path; of a long one the end. */
void ema_text_add_path(ema_text_t* line, const char* path);

/* Adds a number with at most `digits` digits, 1 to 17, with a decimal point in every locale. */
void ema_text_add_real(ema_text_t* line, double value, int digits);
void ema_text_add_whole(ema_text_t* line, int64_t value);

/* Bytes of the UTF-8 character at `begin`, 0 when it is broken. */
size_t ema_text_utf8(const char* begin, size_t length);

#endif
