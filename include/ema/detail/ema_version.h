/* Version of the module, as results carry it: a number that grows. */
#ifndef EMA_VERSION_H
#define EMA_VERSION_H

#define EMA_VERSION_MAJOR 0U
#define EMA_VERSION_MINOR 1U
#define EMA_VERSION_PATCH 0U

#define EMA_VERSION ((EMA_VERSION_MAJOR * 65536U) + (EMA_VERSION_MINOR * 256U) + EMA_VERSION_PATCH)

#endif
