/* Motion over a span as a power series in the fraction of the span: exact for a linear plant with inputs that are constant or rise
 * evenly. The same series gives the response of a whole step and the instant of an event inside it.
 */
#ifndef EMA_SERIES_H
#define EMA_SERIES_H

#include "ema/ema_model.h"

/* Rate of the fastest linear motion times the span that the series is built for, at most; the first term left out is then
 * below the number type's resolution. */
#define EMA_SERIES_REACH EMA_R(1.7)
#if EMA_REAL64
#define EMA_SERIES_TERMS 24U
#else
#define EMA_SERIES_TERMS 14U
#endif

typedef struct {
    ema_real current_A[EMA_SERIES_TERMS + 1U];
    ema_real speed_rad_s[EMA_SERIES_TERMS + 1U];
} ema_series_t;

/* What moves current and speed over a span; the first six in the order of ema_response_t. */
typedef struct {
    ema_real current_A;
    ema_real speed_rad_s;
    ema_real input;        /* of the circuit: V or A */
    ema_real torque_Nm;    /* on the shaft beside the motor's */
    ema_real input_rise;   /* over the span */
    ema_real torque_rise_Nm;
    ema_real span_s;
    ema_real torque_gain_Nm_per_A; /* of the current; zero while the motor's torque is saturated */
    bool at_rest;          /* the shaft does not move */
    bool current_held;     /* the drive holds the current */
} ema_span_t;

void ema_series_build(ema_series_t* series, const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_span_t* span);

/* Terms of the angle from the start of the span, into EMA_SERIES_TERMS + 1 places. */
void ema_series_angle(const ema_series_t* series, ema_real span_s, ema_real* terms);

/* Value at the fraction `at` of the span. */
ema_real ema_series_at(const ema_real* terms, ema_real at);

/* Where the series crosses zero between the fractions `lower` and 1, at which its signs differ. */
ema_real ema_series_root(const ema_real* terms, ema_real lower);

/* Prepares the exact responses of the circuit over `span_s`. */
void ema_circuit_prepare(ema_circuit_t* circuit, const ema_plant_t* plant, ema_real span_s);

#endif
