#include "ema_wasm.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static void* ema_lent;
static size_t ema_lent_bytes;
static bool ema_lent_taken;

int32_t ema_wasm_size(int32_t structure)
{
    size_t bytes = 0U;
    switch (structure) {
    case EMA_WASM_SEARCH:
        bytes = sizeof(ema_desk_search_t);
        break;
    case EMA_WASM_RESULT:
        bytes = sizeof(ema_desk_result_t);
        break;
    default:
        break;
    }
    return (int32_t)bytes;
}

void ema_wasm_lend(void* block, uint32_t bytes)
{
    ema_lent = block;
    ema_lent_bytes = bytes;
    ema_lent_taken = false;
}

/* The desk holds one block at a time. */
void* malloc(size_t bytes)
{
    if (ema_lent_taken || (bytes > ema_lent_bytes)) {
        return NULL;
    }
    ema_lent_taken = true;
    return ema_lent;
}

void free(void* block)
{
    if (block == ema_lent) {
        ema_lent_taken = false;
    }
}

/* Where the compiler makes no instruction of a copy. */
void* memcpy(void* to, const void* from, size_t bytes)
{
    unsigned char* const into = to;
    const unsigned char* const out_of = from;
    for (size_t k = 0; k < bytes; ++k) {
        into[k] = out_of[k];
    }
    return to;
}

void* memset(void* to, int value, size_t bytes)
{
    unsigned char* const into = to;
    for (size_t k = 0; k < bytes; ++k) {
        into[k] = (unsigned char)value;
    }
    return to;
}

static int32_t ema_told(int32_t evaluation, double cost, double best, const double* tried, void* context)
{
    (void)context;
    return ema_wasm_progress(evaluation, cost, best, tried);
}

int32_t ema_wasm_identify(const double* values, const int32_t* options, const double* command_mm,
                          const double* channels, int32_t rows, const ema_desk_search_t* search,
                          ema_desk_result_t* result, int32_t* bad_row)
{
    return ema_desk_identify(values, options, command_mm, channels, rows, search, ema_told, NULL, result, bad_row);
}
