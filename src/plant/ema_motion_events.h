/* What happens in a span of the motion, and when: reversal, break-away, end of travel, saturation. The span is a power
 * series, so an event is a root of it.
 *
 * Nothing here moves the state or asks effects, so that no other frame lies under a search.
 */
#ifndef EMA_MOTION_EVENTS_H
#define EMA_MOTION_EVENTS_H

#include "plant/ema_motion.h"

/* What holds from now on. The work's event is what happened just before, its regime what held until then: on a bound
 * itself they decide, for rounding puts the current on either side. */
void ema_regime_update(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work);

/* Where the segment would end if nothing happened in it. */
void ema_segment_end(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work);

/* The first event in the segment, or its end: EMA_EVENT_NONE at 1. Sets the segment's end. */
void ema_event_find(const ema_plant_t* plant, const ema_state_t* state, ema_step_scratch_t* work);

#endif
