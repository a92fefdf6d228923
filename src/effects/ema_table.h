/* Learned tables: what is unknown but repeats against one axis, as nodes an equal distance apart. Equations:
 * docs/DESIGN.md, "Learned tables". */
#ifndef EMA_TABLE_H
#define EMA_TABLE_H

#include "ema_effect_sites.h"

/* The axes, as the value `axis` of a table counts them. */
typedef enum {
    EMA_AXIS_SPEED = 0,    /* of the motor shaft, rad/s */
    EMA_AXIS_POSITION = 1, /* motor position expressed at the rod, or the rod's where its sensor is meant, mm */
    EMA_AXIS_LEAD = 2,     /* the same within one lead of the screw, mm: periodic */
    EMA_AXIS_TURN = 3,     /* motor angle within one turn, rad: periodic */
    EMA_AXIS_CURRENT = 4   /* of the motor, A */
} ema_axis_t;

/* All tables have the same values in the same places, which the list EMA_TABLE gives them: gain, axis, first, last,
 * nodes. */
#define EMA_TABLE_OF(effect) ((const ema_real*)(const void*)(effect)) /* EMA-D4 */

/* gain * value at the site: straight lines between the nodes, the edge value held outside. On a periodic axis a
 * straight line leads from the last node round to the first. Cost: about 20 operations. */
ema_real ema_table_value(const ema_real* table, const ema_site_t* site);

/* How far the site is outside the range of the nodes, over that range; zero inside. */
ema_real ema_table_outside(const ema_real* table, const ema_site_t* site);

#endif
