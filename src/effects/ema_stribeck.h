/* What of a rise towards standstill is left at a speed. */
#ifndef EMA_STRIBECK_H
#define EMA_STRIBECK_H

#include "ema/detail/ema_real.h"

/* rise exp(-(abs(speed) / fallen)^shape): all of it at rest, 1/e of it at the speed `fallen_rad_s` > 0; zero where it
 * is below the resolution of the level. */
ema_real ema_stribeck(ema_real rise_Nm, ema_real speed_rad_s, ema_real fallen_rad_s, ema_real shape);

#endif
