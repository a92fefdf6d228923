/* What a guarded session asks of the session it contains: runs beside a table of signatures in the memory of the
 * session's own runs, and a start for the search. A session that is not guarded links none of it. */
#ifndef EMA_SCORING_H
#define EMA_SCORING_H

#include "ema/ema_session.h"

/* Begins a run beside the table: of the healthy machine before the session has run, of its best point once it is done,
 * with all values that the session identifies. Errors: EMA_ERR_SHORT for fewer than EMA_ROWS_MIN rows (feeding may go
 * on); EMA_ERR_ORDER while the session runs; those of ema_onboard_start. */
ema_status_t ema_scoring_start(ema_session_t* session, const ema_signatures_t* table);

/* Makes at most `steps` model steps of it; returns how many. Cost: as ema_onboard_run. */
uint32_t ema_scoring_run(ema_session_t* session, uint32_t steps);

/* What the table says, once the run has ended; before, nothing is changed and the answer is false. */
bool ema_scoring_ended(const ema_session_t* session, ema_finding_t* finding);

/* The search starts at these values of what is identified, in their own units and in the configuration's order, instead
 * of where the configuration says; values outside the bounds at the bounds. The annealer then begins as cool as the
 * cost at the healthy values says. Between feeding and the session's first run. */
void ema_session_place_start(ema_session_t* session, const ema_real value[EMA_IDENTIFIED_MAX]);

/* Places it where the shifts of CSJ and BLK say that the run beside the table asked for. */
void ema_scoring_place(ema_session_t* session, const ema_finding_t* finding);

#endif
