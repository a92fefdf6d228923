/* What Eva takes of the elementary functions instead of looking into them, in ACSL. Each line is shown by
 * tests/proof/every_float.c, which calls the function with every float32 there is. Included before every source of the
 * module, in the analysis alone.
 *
 * Eva 25 does not take NaN out of a value that an ordered comparison has let through; the two selections say for it
 * what they do with NaN.
 */
#ifndef EMA_PROOF_CONTRACTS_H
#define EMA_PROOF_CONTRACTS_H

#include <stdbool.h>

#include "ema/ema.h"

/*@ assigns \result \from a, b;
  @ behavior known: assumes !\is_NaN(b); ensures !\is_NaN(\result);
  @*/
static inline ema_real ema_min(ema_real a, ema_real b);

/*@ assigns \result \from a, b;
  @ behavior known: assumes !\is_NaN(b); ensures !\is_NaN(\result);
  @*/
static inline ema_real ema_max(ema_real a, ema_real b);

/*@ assigns \result \from x;
  @ behavior number: assumes !\is_NaN(x); ensures !\is_NaN(\result);
  @ behavior finite: assumes \is_finite(x); ensures \is_finite(\result);
  @ behavior large: assumes -1.0e35 <= x <= 1.0e35; ensures -1.0e35 <= \result <= 1.0e35;
  @ behavior small: assumes -65536.0 <= x <= 65536.0; ensures \is_finite(\result); ensures -65536.0 <= \result <=
  65536.0;
  @ behavior middle: assumes -2147483000.0 <= x <= 2147483000.0; ensures \is_finite(\result); ensures -2147483648.0 <=
  \result <= 2147483648.0;
  @*/
ema_real ema_floor(ema_real x);

/*@ assigns \result \from x;
  @ ensures number: \is_finite(\result);
  @ ensures range: 0.0 <= \result;
  @ behavior falls: assumes x <= 0.0; ensures \result <= 1.0;
  @*/
ema_real ema_exp(ema_real x);

/*@ assigns \result \from x;
  @ ensures number: \is_finite(\result);
  @ ensures range: -89.0 <= \result <= 89.5;
  @ behavior below: assumes 0.0 < x <= 1.0; ensures \result <= 0.0;
  @*/
ema_real ema_log(ema_real x);

/*@ assigns \result \from x;
  @ behavior finite: assumes \is_finite(x); ensures \is_finite(\result); ensures -1.000001 <= \result <= 1.000001;
  @*/
ema_real ema_sin(ema_real x);

/*@ assigns \result \from x;
  @ behavior finite: assumes \is_finite(x); ensures \is_finite(\result); ensures -1.000001 <= \result <= 1.000001;
  @*/
ema_real ema_cos(ema_real x);

#endif
