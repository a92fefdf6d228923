/* What the estimates mean for the actuator. */
#ifndef EMA_VERDICT_H
#define EMA_VERDICT_H

#include "ema/ema_session.h"

/* Whether sensor noise explains a residual of the rod position of this rms and correlation of neighbouring rows. */
bool ema_residual_adequate(const ema_params_t* params, ema_real rms_mm, ema_real correlation);

/* Fills verdict, adequacy and reasons of `result` from its estimates and residual. `determined` says whether the
 * standard errors exist. */
void ema_verdict_judge(const ema_session_config_t* config, bool determined, ema_result_t* result);

#endif
