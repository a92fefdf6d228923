/* The start of a run beside a table that has been checked, for a caller whose actuator is no longer the exported one.
 */
#ifndef EMA_ONBOARD_BEGIN_H
#define EMA_ONBOARD_BEGIN_H

#include "ema/detail/ema_onboard.h"

/* As ema_onboard_start, after ema_onboard_check of the exported actuator with this table and record; `actuator` may
 * differ from that in what differs from day to day, besides CSJ and BLK. Errors: those of ema_model_init. */
ema_status_t ema_onboard_begin(ema_onboard_t* self, const ema_signatures_t* table, const ema_actuator_t* actuator,
                               const ema_record_t* record, ema_real start_mm);

#endif
