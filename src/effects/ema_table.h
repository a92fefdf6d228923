/* Learned tables: what is unknown but repeats against one axis, as nodes an equal distance apart. Equations:
 * docs/DESIGN.md, "Learned tables". */
#ifndef EMA_TABLE_H
#define EMA_TABLE_H

#include "effects/ema_site.h"

/* All tables have the same values in the same places, which the list EMA_TABLE gives them: gain, axis, first, last,
 * nodes. */
#define EMA_TABLE_OF(effect) ((const ema_real*)(const void*)(effect)) /* EMA-D4 */

/* gain * value at the site: straight lines between the nodes, the edge value held outside. On a periodic axis a
 * straight line leads from the last node round to the first. Cost: about 20 operations. */
ema_real ema_table_value(const ema_real* table, const ema_site_t* site);

/* How far the site is outside the range of the nodes, over that range, zero inside; or `least` where that is larger. */
ema_real ema_table_outside(const ema_real* table, const ema_site_t* site, ema_real least);

#endif
