/* A machine in open loop: the command alone sets the drive's output, so that steady states have closed forms. */
#ifndef EMA_OPEN_LOOP_H
#define EMA_OPEN_LOOP_H

#include "ema_rig.h"

/* Command in mm for an output of 1. */
#define EMA_FULL_OUTPUT_MM EMA_R(1.0e11)

/* The nominal actuator with a gain so small that its own motion is not seen, and with travel enough. */
ema_actuator_t ema_open_loop(void);

/* The same with a shaft that never breaks away. */
ema_actuator_t ema_open_loop_locked(void);

/* A model of it after half a second at the output `share`: its electrical and mechanical transients are over. */
ema_model_t ema_open_loop_steady(const ema_actuator_t* actuator, double share);

/* Steady speed of a machine whose torques are linear in speed. */
double ema_steady_speed_rad_s(double voltage_V, double torque_constant_Nm_per_A, double resistance_ohm,
                              double friction_Nm, double viscous_Nm_s_per_rad);

/* Motor torque in Nm at which a shaft at `start_mm` leaves its rest while the voltage rises slowly. */
double ema_open_loop_break_away_Nm(const ema_actuator_t* actuator, double start_mm);

/* Agreement of the two builds with a closed form, relative. */
#define EMA_CLOSED_FORM EMA_BY_PRECISION(3.0e-5, 1.0e-9)

#endif
