#include "ema_csv_text.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Bytes of a path that still leave room for the message. */
#define PATH_SHOWN 200U

ema_text_t ema_text_start(char* buffer, size_t size)
{
    if (size > 0U) {
        buffer[0] = '\0';
    }
    return (ema_text_t){.text = buffer, .size = size, .length = 0U};
}

static void ema_text_bytes(ema_text_t* line, const char* begin, size_t length)
{
    /* A character that does not fit whole ends the line for good. */
    if ((line->length + length) < line->size) {
        (void)memcpy(line->text + line->length, begin, length);
        line->length += length;
        line->text[line->length] = '\0';
    } else {
        line->size = (line->size > 0U) ? (line->length + 1U) : 0U;
    }
}

size_t ema_text_utf8(const char* begin, size_t length)
{
    const unsigned char first = (unsigned char)begin[0];
    size_t bytes = 0U;
    uint32_t smallest = 0U;
    uint32_t code = 0U;
    if (first < 0x80U) {
        return 1U;
    }
    if ((first & 0xE0U) == 0xC0U) {
        bytes = 2U;
        smallest = 0x80U;
        code = first & 0x1FU;
    } else if ((first & 0xF0U) == 0xE0U) {
        bytes = 3U;
        smallest = 0x800U;
        code = first & 0x0FU;
    } else if ((first & 0xF8U) == 0xF0U) {
        bytes = 4U;
        smallest = 0x10000U;
        code = first & 0x07U;
    } else {
        return 0U;
    }
    if (length < bytes) {
        return 0U;
    }
    for (size_t i = 1U; i < bytes; ++i) {
        const unsigned char next = (unsigned char)begin[i];
        if ((next & 0xC0U) != 0x80U) {
            return 0U;
        }
        code = (code << 6U) | (next & 0x3FU);
    }
    const int broken = (code < smallest) || (code > 0x10FFFFU) || ((code >= 0xD800U) && (code <= 0xDFFFU));
    return broken ? 0U : bytes;
}

void ema_text_add(ema_text_t* line, const char* text)
{
    ema_text_bytes(line, text, strlen(text));
}

void ema_text_add_foreign(ema_text_t* line, const char* begin, size_t length, size_t limit)
{
    size_t at = 0U;
    while (at < length) {
        size_t bytes = ema_text_utf8(begin + at, length - at);
        const unsigned char first = (unsigned char)begin[at];
        /* C1 controls are two bytes that start with C2. */
        const int control = (first < 0x20U) || (first == 0x7FU)
                            || ((bytes == 2U) && (first == 0xC2U) && ((unsigned char)begin[at + 1U] < 0xA0U));
        if ((at + ((bytes == 0U) ? 1U : bytes)) > limit) {
            ema_text_bytes(line, "...", 3U);
            return;
        }
        if ((bytes == 0U) || control) {
            ema_text_bytes(line, "?", 1U);
            bytes = (bytes == 0U) ? 1U : bytes;
        } else {
            ema_text_bytes(line, begin + at, bytes);
        }
        at += bytes;
    }
}

void ema_text_add_path(ema_text_t* line, const char* path)
{
    size_t length = strlen(path);
    if (length > PATH_SHOWN) {
        path += length - PATH_SHOWN;
        length = PATH_SHOWN;
        while ((length > 0U) && (((unsigned char)path[0] & 0xC0U) == 0x80U)) {
            ++path;
            --length;
        }
        ema_text_add(line, "...");
    }
    ema_text_add_foreign(line, path, length, length);
}

void ema_text_add_real(ema_text_t* line, double value, int significant)
{
    char digits[40];
    (void)snprintf(digits, sizeof digits, "%.*g", significant, value);
    size_t kept = 0U;
    for (size_t i = 0U; digits[i] != '\0'; ++i) {
        const char c = digits[i];
        const int plain = ((c >= '0') && (c <= '9')) || ((c >= 'a') && (c <= 'z')) || (c == '-') || (c == '+');
        if (plain) {
            digits[kept] = c;
            ++kept;
        } else if ((kept == 0U) || (digits[kept - 1U] != '.')) {
            digits[kept] = '.';
            ++kept;
        } else {
            continue;
        }
    }
    ema_text_bytes(line, digits, kept);
}

void ema_text_add_whole(ema_text_t* line, int64_t value)
{
    char digits[24];
    (void)snprintf(digits, sizeof digits, "%" PRId64, value);
    ema_text_add(line, digits);
}
