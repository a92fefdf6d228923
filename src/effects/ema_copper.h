/* What the effects of a warm winding have in common. */
#ifndef EMA_COPPER_H
#define EMA_COPPER_H

#include "ema/detail/ema_real.h"

/* Growth of copper's resistance, per degC: IEC 60028. */
#define EMA_COPPER_PER_DEGC EMA_R(0.00393)

#endif
