/* What the module asks of <string.h>; the compiler makes one instruction of each, or a call of ema_wasm.c. */
#ifndef EMA_WASM_STRING_H
#define EMA_WASM_STRING_H

#include <stddef.h>

void* memcpy(void* to, const void* from, size_t bytes);
void* memset(void* to, int value, size_t bytes);

#endif
