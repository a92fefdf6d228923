/* What the module asks of a compiler beyond C11. This header alone may use extensions. */
#ifndef EMA_COMPILER_H
#define EMA_COMPILER_H

/* Keeps a function out of its callers: its frame takes stack only while it runs. Empty where a compiler has no word for
 * it, which changes stack and code size and no result. */
#if defined(__GNUC__)
#define EMA_NOINLINE __attribute__((noinline))
#else
#define EMA_NOINLINE
#endif

#endif
