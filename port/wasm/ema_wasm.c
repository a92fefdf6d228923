/* What the compiler calls where it makes no instruction of a copy: there is no C library behind the module in a
 * browser. */
#include <string.h>

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
