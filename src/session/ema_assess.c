/* Apart from ema_session_search.c so that the lists of values take no stack from the search. */
#include "session/ema_assess.h"

#include "base/ema_bounds.h"
#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "ident/ema_sensitivity_begin.h"
#include "session/ema_session_search.h"

/* Step of the sensitivities, as a share of the healthy value: large against rounding, small against the parameter. */
#define EMA_DELTA_SHARE EMA_R(0.01)

/* What has come of the part of the start so far: without a model beside the estimate the session ends. */
static void ema_assess_went(ema_session_t* session, ema_status_t status)
{
    session->assessed = status == EMA_OK;
    session->phase = session->assessed ? EMA_PHASE_ASSESSING : EMA_PHASE_DONE;
}

void ema_assess_start(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_session_search_move(session, session->annealer.best.x);
    ema_assess_went(session, ema_sensitivity_begin(&session->sensitivity, &session->actuator, &session->record,
                                                   config->weight, config->identified_count));
}

void ema_assess_model(ema_session_t* session)
{
    const ema_session_config_t* const config = session->config;
    ema_sensitivity_t* const sensitivity = &session->sensitivity;
    const uint32_t made = sensitivity->prepared;
    if (made == 0U) {
        ema_assess_went(session,
                        ema_sensitivity_model(sensitivity, &session->actuator, ema_session_search_start_mm(session)));
    } else {
        const ema_identified_t* const identified = &config->identified[made - 1U];
        const ema_real value = ema_value_of(&session->actuator, identified->id);
        ema_real delta = EMA_DELTA_SHARE * ema_abs(ema_value_of(config->actuator, identified->id));
        if ((value + delta) > identified->upper) {
            delta = -delta;
        }
        ema_assess_went(session, ema_sensitivity_moved(sensitivity, &session->actuator, identified->id, delta,
                                                       ema_session_search_start_mm(session)));
    }
    if (session->assessed && (sensitivity->prepared > sensitivity->parameters)) {
        ema_sensitivity_learned(sensitivity, config->actuator);
    }
}
