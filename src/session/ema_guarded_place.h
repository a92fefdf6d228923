/* The start that a table of signatures gives the search. */
#ifndef EMA_GUARDED_PLACE_H
#define EMA_GUARDED_PLACE_H

#include "ema/ema_guarded.h"

/* The shifts that the first run asks for become the start of the search. */
void ema_guarded_place(ema_guarded_t* guarded);

#endif
