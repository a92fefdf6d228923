/* What the desk asks of <stdlib.h>; what calls it is not in ema.wasm. */
#ifndef EMA_WASM_STDLIB_H
#define EMA_WASM_STDLIB_H

#include <stddef.h>

void* malloc(size_t bytes);
void free(void* block);

#endif
