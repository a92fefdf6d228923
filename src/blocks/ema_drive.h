/* Block 2: controller and drive electronics. Equations: docs/DESIGN.md, "Controller and drive electronics". */
#ifndef EMA_DRIVE_H
#define EMA_DRIVE_H

#include "base/ema_choice.h"
#include "base/ema_math.h"
#include "ema/detail/ema_step_scratch.h"

void ema_drive_prepare(ema_drive_t* drive, const ema_params_t* params, const ema_options_t* options);

/* Current mode: the loop follows its reference while the bus voltage suffices, else the bus voltage is applied. */
void ema_drive_current_mode(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output, ema_real current_A,
                            ema_real speed_rad_s, ema_drive_output_t* applied);

/* The step below with what was asked `age` steps ago, as a function: it is not in the way of every model step. */
void ema_drive_late(const ema_plant_t* plant, const ema_state_t* state, uint32_t age, ema_drive_output_t* applied);

/* Whether it regulates the current, whether it does so over this step, and whether it is late. */
static inline bool ema_drive_regulates(const ema_drive_t* drive)
{
    return (EMA_ONLY_VOLTAGE == 0) && drive->current_mode;
}

static inline bool ema_drive_follows(const ema_drive_output_t* applied)
{
    return (EMA_ONLY_VOLTAGE == 0) && applied->current_loop;
}

static inline bool ema_drive_delays(const ema_drive_t* drive)
{
    return (EMA_ONLY_VOLTAGE == 0) && drive->delayed;
}

/* Whether it drives the circuit of its mode. */
static inline bool ema_drive_keeps(const ema_drive_t* drive, const ema_drive_output_t* applied)
{
    return (EMA_ONLY_VOLTAGE != 0) || (applied->current_loop == drive->current_mode);
}

/* The circuit that it drives. */
static inline const ema_circuit_t* ema_circuit_of(const ema_plant_t* plant, const ema_drive_output_t* applied)
{
    return ema_drive_follows(applied) ? &plant->current_loop : &plant->motor_circuit;
}

/* Current of a circuit without a time constant under `input`, inside the drive's limit. */
ema_real ema_circuit_follow(const ema_plant_t* plant, const ema_circuit_t* circuit, const ema_state_t* state,
                            ema_real input);

/* Current of a circuit without a time constant, from the instant on at which the drive applies its input. */
static inline void ema_drive_current(const ema_plant_t* plant, ema_state_t* state, const ema_drive_output_t* applied)
{
    const ema_circuit_t* const circuit = ema_circuit_of(plant, applied);
    if (circuit->algebraic) {
        state->current_A = ema_circuit_follow(plant, circuit, state, applied->input);
    }
}

static inline void ema_drive_step(const ema_drive_t* drive, const ema_motor_t* motor, ema_real output,
                                  ema_real current_A, ema_real speed_rad_s, ema_drive_output_t* applied)
{
    if (ema_drive_regulates(drive)) {
        ema_drive_current_mode(drive, motor, output, current_A, speed_rad_s, applied);
    } else {
        applied->input = output * drive->supply_V;
        applied->voltage_V = applied->input;
        applied->current_loop = false;
    }
}

#endif
