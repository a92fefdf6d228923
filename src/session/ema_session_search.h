/* The model runs of a search, one after the other: at the healthy values and at the annealer's candidates. */
#ifndef EMA_SESSION_SEARCH_H
#define EMA_SESSION_SEARCH_H

#include "ema/ema_session.h"

/* Value of an identified parameter at the coordinate `x` of the unit box. */
ema_real ema_identified_at(const ema_identified_t* identified, ema_real x);

/* Moves the session's actuator to a point of the unit box. */
void ema_session_search_move(ema_session_t* session, const ema_real* x);

/* Where the rod rests before the record: at the command when the first sample agrees with it within play and noise. */
ema_real ema_session_search_start_mm(const ema_session_t* session);

/* Starts the run of today's candidate: first the healthy values, then the annealer's. Errors: those of
 * ema_objective_start. */
ema_status_t ema_session_search_begin(ema_session_t* session);

/* A model run has ended: its cost goes to the annealer, and the next run begins unless the search has ended. */
ema_status_t ema_session_search_next(ema_session_t* session);

/* The search has ended: these runs are next. An estimate beside which no model can be made is left without them, and
 * the session is done: its result says that the record does not determine the parameters. */
void ema_assess_start(ema_session_t* session);

/* Makes the next of their models: each takes as long as a slice may. */
void ema_assess_model(ema_session_t* session);

#endif
