/* The model runs behind standard errors and verdict, at the best point of the search. */
#ifndef EMA_ASSESS_H
#define EMA_ASSESS_H

#include "ema/ema_session.h"

/* The search has ended: these runs are next. An estimate beside which no model can be made is left without them, and the
 * session is done: its result says that the record does not determine the parameters. */
void ema_assess_start(ema_session_t* session);

/* Makes the next of their models: each takes as long as a slice may. */
void ema_assess_model(ema_session_t* session);

#endif
