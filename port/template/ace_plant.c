#include "ace_plant.h"

#include <stdbool.h>

#define STEPS_PER_TICK 100
#define STEP_S 1.0e-5f

/* Its data sheet: the project's reference actuator. */
#define TORQUE_CONSTANT_NM_PER_A 0.0612f
#define BACK_EMF_V_S_PER_RAD 0.0612f
#define RESISTANCE_OHM 0.99f
#define INDUCTANCE_H 8.0e-4f
#define TORQUE_LIMIT_NM 1.48f
#define INERTIA_KGM2 6.0e-5f
#define VISCOUS_NM_S_PER_RAD 1.0e-4f
#define LEAD_MM_PER_RAD (5.0f / (6.2831853f * 4.0f))

/* Near zero current the dead time takes off less. */
#define DEAD_TIME_WIDTH_A 0.2f

typedef struct {
    float voltage_V;
    float current_A;
    float speed_rad_s;
    float angle_rad;
    float rod_mm;
    bool started;
} plant_t;

static plant_t plant;

static float clamp(float value, float lower, float upper)
{
    return (value < lower) ? lower : (value > upper) ? upper : value;
}

/* Speed after a step under `torque_Nm`. Dry friction stops the shaft and holds it, and never moves it. */
static float next_speed(float speed_rad_s, float torque_Nm)
{
    const float gain = STEP_S / INERTIA_KGM2;
    const float free_rad_s = speed_rad_s + (gain * torque_Nm);
    const float most_rad_s = gain * ACE_PLANT_CSJ_NM;
    return free_rad_s - clamp(free_rad_s, -most_rad_s, most_rad_s);
}

static void step(void)
{
    const float drop_V = ACE_PLANT_DEAD_TIME_V * clamp(plant.current_A / DEAD_TIME_WIDTH_A, -1.0f, 1.0f);
    const float change_V =
        plant.voltage_V - drop_V - (RESISTANCE_OHM * plant.current_A) - (BACK_EMF_V_S_PER_RAD * plant.speed_rad_s);
    const float before_A = plant.current_A;
    const float before_rad_s = plant.speed_rad_s;
    plant.current_A += (STEP_S / INDUCTANCE_H) * change_V;
    /* means over the step: an error of half a step in time would show in the play */
    const float mean_Nm = TORQUE_CONSTANT_NM_PER_A * 0.5f * (before_A + plant.current_A);
    const float motor_Nm = clamp(mean_Nm, -TORQUE_LIMIT_NM, TORQUE_LIMIT_NM);
    plant.speed_rad_s = next_speed(before_rad_s, motor_Nm - (VISCOUS_NM_S_PER_RAD * before_rad_s));
    plant.angle_rad += STEP_S * 0.5f * (before_rad_s + plant.speed_rad_s);
}

static float motor_mm(void)
{
    return plant.angle_rad * LEAD_MM_PER_RAD;
}

void ace_plant_reset(void)
{
    const plant_t rest = {0};
    plant = rest;
}

ace_sensors_t ace_plant_sensors(void)
{
    for (int k = 0; plant.started && (k < STEPS_PER_TICK); ++k) {
        step();
        const float half_mm = 0.5f * ACE_PLANT_BLK_MM;
        plant.rod_mm = clamp(plant.rod_mm, motor_mm() - half_mm, motor_mm() + half_mm);
    }
    plant.started = true;
    const ace_sensors_t sensors = {plant.rod_mm, motor_mm(), plant.current_A};
    return sensors;
}

void ace_plant_drive(float voltage_V)
{
    plant.voltage_V = voltage_V;
}
