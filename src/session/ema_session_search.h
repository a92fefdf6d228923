/* The parts of a search, one after the other: a model is prepared, runs, and its end is decided on. The runs are those
 * of the least squares, of the annealer, and of the assessment at the best point. */
#ifndef EMA_SESSION_SEARCH_H
#define EMA_SESSION_SEARCH_H

#include "ema/ema_session.h"

/* Plain steps that preparing a model counts as, which is not divided. Measured on the target: docs/BUDGETS.md. */
#define EMA_MODEL_WORK 110U

/* Value of an identified parameter at the coordinate `x` of the unit box. */
ema_real ema_identified_at(const ema_identified_t* identified, ema_real x);

/* Whether an estimate at the coordinate `x` lies on a bound of its search. */
bool ema_at_bound(ema_real x);

/* Moves the session's actuator to a point of the unit box. */
void ema_session_search_move(ema_session_t* session, const ema_real* x);

/* Where the rod rests before the record: at the command when the first sample agrees with it within play and noise. */
ema_real ema_session_search_start_mm(const ema_session_t* session);

/* Opens the search at the end of feeding: its first model run is due. Errors: those of ema_sensitivity_begin. */
ema_status_t ema_session_search_open(ema_session_t* session);

/* Plain steps of work that the next part of the session counts as, where it is not divided: preparing a model, or what
 * follows from runs that have ended. 0 while a model runs. */
uint32_t ema_session_part_work(const ema_session_t* session);

/* Does this part. Errors: those of ema_model_init, of the first model alone. */
ema_status_t ema_session_part(ema_session_t* session);

#endif
