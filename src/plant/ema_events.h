/* What happens in a span of the motion, and when: reversal, break-away, end of travel, saturation. The span is a power series, so an event is a root of it.
 *
 * Nothing here moves the state or asks effects, so that a series lives on the stack only while it is searched.
 */
#ifndef EMA_EVENTS_H
#define EMA_EVENTS_H

#include "ema_forces.h"

typedef enum {
    EMA_EVENT_NONE,
    EMA_EVENT_REST,     /* the speed reaches zero */
    EMA_EVENT_STOP,     /* an end of travel */
    EMA_EVENT_CURRENT,  /* the current reaches a limit of drive or torque */
    EMA_EVENT_RELEASE,  /* the drive need not hold the current any longer */
    EMA_EVENT_FORWARD,  /* the torque leaves what dry friction holds */
    EMA_EVENT_BACKWARD
} ema_event_kind_t;

typedef struct {
    ema_event_kind_t kind;
    ema_real at;           /* fraction of the span */
    ema_real value;        /* of the quantity that reached its bound */
    ema_real current_A;    /* at this instant, on the way that was assumed */
    ema_real speed_rad_s;
    ema_real turn_rad;     /* from the start of the span */
} ema_event_t;

/* What the current does over a segment that is located. */
typedef struct {
    bool held;                 /* the drive holds it at its limit */
    ema_real saturated_Nm;     /* motor torque while it is saturated, else zero */
} ema_regime_t;

/* What holds from now on. `last` is what happened just before, `regime` what held until then: on a bound itself they decide, for rounding puts the current on either side. */
void ema_regime_update(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, ema_real input, const ema_event_t* last, ema_regime_t* regime);

/* Where the segment would end if nothing happened in it. */
void ema_segment_end(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, const ema_regime_t* regime, ema_real span_s, ema_segment_t* segment);

/* The first event in the segment, or its end: EMA_EVENT_NONE at 1. Sets the segment's end. */
void ema_event_find(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state, const ema_regime_t* regime, ema_real span_s, ema_segment_t* segment,
                    ema_event_t* event);

#endif
