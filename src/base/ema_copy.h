/* Copies what is large word by word: where nothing waits for it, the C library's fast copy costs more code than it
 * saves time. */
#ifndef EMA_COPY_H
#define EMA_COPY_H

#include <stddef.h>

/* `size` bytes, a multiple of four as every structure of reals has; the places may not overlap. */
void ema_copy(void* to, const void* from, size_t size);

#endif
