/* The desk in a browser: what JavaScript needs beside the functions of ema_desk.h, which it calls as Python does.
 *
 * JavaScript owns the memory behind `__heap_base`: it puts arrays and structures there and gives their addresses. One
 * block of it is lent to the desk for its record; there is no other heap.
 */
#ifndef EMA_WASM_H
#define EMA_WASM_H

#include "ema_desk.h"

/* Structures whose size JavaScript compares with its own idea of them. */
typedef enum { EMA_WASM_SEARCH = 0, EMA_WASM_RESULT = 1 } ema_wasm_structure_t;

/* Size in bytes, 0 for anything that is none. */
int32_t ema_wasm_size(int32_t structure);

/* Lends `bytes` bytes at `block`, aligned to 8, until the next call: enough for 20 bytes a row. */
void ema_wasm_lend(void* block, uint32_t bytes);

/* The one function that JavaScript gives: told after each model run of a search with the runs so far, the cost, the
 * best cost and the values that were tried, or NULL; a return other than 0 stops the search. */
int32_t ema_wasm_progress(int32_t runs, double cost, double best, const double* values);

/* ema_desk_identify with that progress. */
int32_t ema_wasm_identify(const double* values, const int32_t* options, const double* command_mm,
                          const double* channels, int32_t rows, const ema_desk_search_t* search,
                          ema_desk_result_t* result, int32_t* bad_row);

#endif
