/* A session whose verdict is guarded by a table of signatures, and whose search starts where the table says.
 *
 * The same four calls as those of a session, with a run beside the table before the search and another one at its best
 * point:
 *
 *     ema_guarded_init(&guarded, &config, &EMA_SIGNATURES);
 *     ema_guarded_feed(&guarded, &sample);
 *     while (ema_guarded_run(&guarded, 200) == EMA_OK && ema_guarded_phase(&guarded) != EMA_GUARDED_DONE) { }
 *     ema_guarded_result(&guarded, &result, &finding);
 *
 * The first run's shifts of CSJ and BLK give the search its start, and the annealer a lower temperature, so that it
 * takes fewer model runs; its answer is the same. The last one tells what the best CSJ and BLK, with grease and winding
 * as they are today where these are searched too, leave unexplained: an effect that is missing from the model makes the
 * verdict undecided, whatever the estimates say. Without a table (NULL) every result is the session's, bit for bit. A
 * plain value like the session, which it contains: a copy is a checkpoint. Its runs take turns in the same memory.
 */
#ifndef EMA_GUARDED_H
#define EMA_GUARDED_H

#include "ema/detail/ema_onboard.h"
#include "ema/ema_session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    EMA_GUARDED_FEEDING = 0,
    EMA_GUARDED_STARTING = 1, /* the run that gives the search its start */
    EMA_GUARDED_SESSION = 2,  /* search and assessment */
    EMA_PHASE_SCREENING = 3,  /* the run at the best point */
    EMA_GUARDED_DONE = 4
} ema_guarded_phase_t;

typedef struct {
    ema_session_t session;
    const ema_signatures_t* signatures;
    ema_guarded_phase_t phase;
    ema_result_t result;   /* once the session has ended */
    ema_finding_t finding; /* of the run that ended last */
} ema_guarded_t;

/* Starts an empty session; `signatures` may be NULL. On an error nothing has changed. Errors: those of ema_session_init
 * and ema_onboard_check; EMA_ERR_RANGE when the session identifies other values than CSJ and BLK, and grease and
 * winding as ema_session_config_day adds them, beside a table. */
ema_status_t ema_guarded_init(ema_guarded_t* guarded, const ema_session_config_t* config,
                              const ema_signatures_t* signatures);

/* As ema_session_feed. */
ema_status_t ema_guarded_feed(ema_guarded_t* guarded, const ema_sample_t* sample);

/* As ema_session_adopt and ema_session_gap. */
ema_status_t ema_guarded_adopt(ema_guarded_t* guarded, uint32_t rows);
ema_status_t ema_guarded_gap(ema_guarded_t* guarded);

/* As ema_session_run, with the runs beside the table. Errors: those of ema_session_run and ema_model_init. */
ema_status_t ema_guarded_run(ema_guarded_t* guarded, uint32_t steps);

/* EMA_GUARDED_FEEDING of none. */
ema_guarded_phase_t ema_guarded_phase(const ema_guarded_t* guarded);

/* As ema_session_result, and `finding` (may be NULL): what the table says, EMA_FINDING_NONE until the end and without a
 * table. Errors: EMA_ERR_NULL; EMA_ERR_ORDER before the search. */
ema_status_t ema_guarded_result(const ema_guarded_t* guarded, ema_result_t* result, ema_finding_t* finding);

#ifdef __cplusplus
}
#endif

#endif
