/* Copies what is large word by word: where nothing waits for it, the C library's fast copy costs more code than it
 * saves time. Clears in place. */
#ifndef EMA_COPY_H
#define EMA_COPY_H

#include <stddef.h>

/* `size` bytes, a multiple of four as every structure of reals has; the places may not overlap. */
void ema_copy(void* to, const void* from, size_t size);

/* All bits of `size` bytes to zero: what numbers, flags and absent pointers start as. A structure assigned from an
 * initialiser is a second one on the stack of a build without optimisation. */
void ema_clear(void* place, size_t size);

#endif
