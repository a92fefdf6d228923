/* Copies what is large byte by byte: where nothing waits for it, the C library's fast copy costs more code than time.
 */
#ifndef EMA_COPY_H
#define EMA_COPY_H

#include <stddef.h>

/* `size` bytes; the places may not overlap. */
void ema_copy(void* to, const void* from, size_t size);

#endif
