/* What an effect is given. */
#ifndef EMA_SITE_H
#define EMA_SITE_H

#include "ema/detail/ema_plant.h"

/* What an effect may look at, all at the same instant. */
typedef struct {
    const ema_plant_t* plant;
    ema_real speed_rad_s; /* motor shaft */
    ema_real angle_rad;
    ema_real position_mm; /* motor position expressed at the rod */
    ema_real current_A;
    ema_real voltage_V; /* applied by the drive; where it regulates the current, whose voltage nobody asks for, that */
    ema_real direction; /* of dry friction, -1 or 1, where its level is asked for */
    ema_real grease;    /* relative change of dry and viscous friction by temperature */
} ema_site_t;

/* One integration step of what lies behind the play. */
typedef struct {
    ema_real play_start_mm; /* output of the play at the start and at the end of the step */
    ema_real play_end_mm;
    ema_real step_s;
    ema_real lead_mm_per_rad;
} ema_transmission_t;

/* Growth of copper's resistance, per degC: IEC 60028. */
#define EMA_COPPER_PER_DEGC EMA_R(0.00393)

#endif
