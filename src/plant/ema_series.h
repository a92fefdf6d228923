/* Motion over a span as a power series in the fraction of the span: exact for a linear plant with inputs that are
 * constant, or polynomials. The same series gives the response of a whole step and the instant of an event inside it.
 */
#ifndef EMA_SERIES_H
#define EMA_SERIES_H

#include "ema/detail/ema_step_scratch.h"

/* Rate of the fastest linear motion times the span that the series is built for, at most; the first term left out is
 * then below the number type's resolution. */
#define EMA_SERIES_REACH EMA_R(1.7)

void ema_series_build(ema_series_t* series, const ema_plant_t* plant, const ema_circuit_t* circuit,
                      const ema_span_t* span);

/* Terms of the angle from the start of the span, into EMA_SERIES_TERMS + 1 places. */
void ema_series_angle(const ema_series_t* series, ema_real span_s, ema_real* terms);

/* Value at the fraction `at` of the span. */
ema_real ema_series_at(const ema_real* terms, ema_real at);

/* Where the series crosses zero between the fractions `lower` and 1, at which its signs differ. */
ema_real ema_series_root(const ema_real* terms, ema_real lower);

/* The series of the work's circuit over its span, that of the angle in its `terms`; and where they end, the angle from
 * the start of the span. */
void ema_series_end(const ema_plant_t* plant, ema_step_scratch_t* work, ema_point_t* end);

/* Prepares the exact responses of the work's circuit over `span_s`. */
void ema_responses_prepare(ema_responses_t* responses, const ema_plant_t* plant, ema_step_scratch_t* work,
                           ema_real span_s);

#endif
