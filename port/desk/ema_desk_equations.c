/* The module's equations at the points of a record, through the functions that the model itself calls. */
#include "blocks/ema_drive.h"
#include "blocks/ema_encoder.h"
#include "blocks/ema_limits.h"
#include "blocks/ema_mechanics.h"
#include "blocks/ema_pid.h"
#include "effects/ema_effect_sums.h"
#include "ema_desk.h"
#include "ema_desk_actuator.h"

/* The blocks of an actuator, without the circuits' responses: nothing here moves. The actuator gets its adjusted
 * parameters, and keeps the tables. */
static void ema_blocks_from(const double* values, const int32_t* options, ema_actuator_t* actuator, ema_plant_t* plant)
{
    const ema_plant_t none = {0};
    *plant = none;
    ema_actuator_from(values, options, actuator);
    const ema_params_t* const params = &actuator->params;
    const ema_options_t* const chosen = &actuator->options;
    ema_effects_adjust(&actuator->effects, &actuator->params);
    ema_effects_hold(plant, &actuator->effects);
    ema_pid_prepare(&plant->pid, params, chosen);
    ema_drive_prepare(&plant->drive, params, chosen);
    ema_motor_prepare(&plant->motor, params);
    ema_gearbox_prepare(&plant->gearbox, params);
    ema_screw_prepare(&plant->screw, &plant->gearbox, params);
    ema_encoder_prepare(&plant->encoder, params, chosen);
}

int32_t ema_desk_adjusted(const double* values, const int32_t* options, double* adjusted)
{
    if ((values == NULL) || (options == NULL) || (adjusted == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_actuator_from(values, options, &actuator);
    ema_effects_t effects = actuator.effects;
    ema_real* value = (ema_real*)(void*)&effects;
    for (size_t k = 0; k < (sizeof(ema_effect_rows) / sizeof(ema_effect_rows[0])); ++k) {
        if (ema_effect_rows[k].site == (uint8_t)EMA_SITE_TRANSMISSION) {
            *value = EMA_R(0.0);
        }
        value = &value[ema_effect_rows[k].values];
    }
    ema_effects_adjust(&effects, &actuator.params);
    ema_status_t status = EMA_OK;
    for (size_t id = 0; (status == EMA_OK) && (id < EMA_VALUE_COUNT); ++id) {
        ema_real number = EMA_R(0.0);
        status = ema_actuator_get(&actuator, (ema_value_id_t)id, &number);
        adjusted[id] = (double)number;
    }
    return (int32_t)status;
}

static ema_real ema_site_sum(const ema_plant_t* plant, ema_effect_site_t place, const ema_site_t* site,
                             ema_real level_Nm)
{
    ema_real sum = EMA_R(0.0);
    if (place == EMA_SITE_FRICTION) {
        sum = ema_site_friction(plant, site, level_Nm);
    } else if (place == EMA_SITE_TORQUE) {
        sum = ema_site_torque(plant, site);
    } else if (place == EMA_SITE_LOAD) {
        sum = ema_site_load(plant, site);
    } else if (place == EMA_SITE_VOLTAGE) {
        sum = ema_site_voltage(plant, site);
    } else if (place == EMA_SITE_MOTOR) {
        sum = ema_site_motor(plant, site);
    } else {
        sum = ema_site_reading(plant, site);
    }
    return sum;
}

int32_t ema_desk_site(const double* values, const int32_t* options, int32_t site, const double* points, int32_t rows,
                      double* sum)
{
    if ((values == NULL) || (options == NULL) || (points == NULL) || (sum == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((site <= (int32_t)EMA_SITE_PARAMETER) || (site >= (int32_t)EMA_SITE_COUNT)
        || (site == (int32_t)EMA_SITE_PRESLIDING) || (site == (int32_t)EMA_SITE_TRANSMISSION)
        || (site == (int32_t)EMA_SITE_WINDING) || (site == (int32_t)EMA_SITE_GREASE)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_blocks_from(values, options, &actuator, &plant);
    const size_t count = (rows > 0) ? (size_t)rows : 0U;
    for (size_t row = 0; row < count; ++row) {
        const ema_site_t here = {.plant = &plant,
                                 .current_A = (ema_real)points[row],
                                 .speed_rad_s = (ema_real)points[count + row],
                                 .angle_rad = (ema_real)points[(2U * count) + row],
                                 .position_mm = (ema_real)points[(3U * count) + row],
                                 .voltage_V = (ema_real)points[(4U * count) + row],
                                 .direction = (ema_real)points[(6U * count) + row]};
        const ema_real level_Nm = (ema_real)points[(5U * count) + row];
        sum[row] = (double)ema_site_sum(&plant, (ema_effect_site_t)site, &here, level_Nm);
    }
    return (int32_t)EMA_OK;
}

int32_t ema_desk_warmth(const double* values, const int32_t* options, int32_t site, const double* current_A,
                        int32_t rows, double period_s, double* change)
{
    if ((values == NULL) || (options == NULL) || (current_A == NULL) || (change == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    if ((site != (int32_t)EMA_SITE_WINDING) && (site != (int32_t)EMA_SITE_GREASE)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_state_t state = {0};
    ema_blocks_from(values, options, &actuator, &plant);
    for (int32_t row = 0; row < rows; ++row) {
        if (row > 0) {
            state.current_A = (ema_real)current_A[row];
            ema_site_warm(&plant, &state, (ema_real)current_A[row - 1], EMA_R(0.0), (ema_real)period_s);
        }
        change[row] = (double)((site == (int32_t)EMA_SITE_WINDING) ? ema_site_winding(&plant, state.effect_memory)
                                                                   : ema_site_grease(&plant, state.effect_memory));
    }
    return (int32_t)EMA_OK;
}

int32_t ema_desk_contact(const double* values, const int32_t* options, const double* angle_rad, int32_t rows,
                         double* share)
{
    if ((values == NULL) || (options == NULL) || (angle_rad == NULL) || (share == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_real memory[EMA_EFFECT_MEMORY_LENGTH] = {EMA_R(0.0)};
    ema_blocks_from(values, options, &actuator, &plant);
    for (int32_t row = 0; row < rows; ++row) {
        const double turn_rad = (row > 0) ? (angle_rad[row] - angle_rad[row - 1]) : 0.0;
        const ema_real carried = ema_site_presliding(&plant, memory, (ema_real)turn_rad);
        ema_site_presliding_keep(&plant, memory, carried);
        share[row] = (double)carried;
    }
    return (int32_t)EMA_OK;
}

int32_t ema_desk_contact_after(const double* values, const int32_t* options, const double* before,
                               const double* turn_rad, int32_t rows, double* share)
{
    if ((values == NULL) || (options == NULL) || (before == NULL) || (turn_rad == NULL) || (share == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_real memory[EMA_EFFECT_MEMORY_LENGTH] = {EMA_R(0.0)};
    ema_blocks_from(values, options, &actuator, &plant);
    for (int32_t row = 0; row < rows; ++row) {
        ema_site_presliding_keep(&plant, memory, (ema_real)before[row]);
        share[row] = (double)ema_site_presliding(&plant, memory, (ema_real)turn_rad[row]);
    }
    return (int32_t)EMA_OK;
}

int32_t ema_desk_play(const double* values, const int32_t* options, const double* motor_mm, int32_t rows,
                      double start_mm, double* play_mm)
{
    if ((values == NULL) || (options == NULL) || (motor_mm == NULL) || (play_mm == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_blocks_from(values, options, &actuator, &plant);
    ema_real output_mm = (ema_real)start_mm;
    for (int32_t row = 0; row < rows; ++row) {
        output_mm = ema_screw_play_at(&plant.screw, output_mm, (ema_real)motor_mm[row]);
        play_mm[row] = (double)output_mm;
    }
    return (int32_t)EMA_OK;
}

int32_t ema_desk_controller(const double* values, const int32_t* options, const double* command_mm,
                            const double* feedback_mm, int32_t rows, double* output)
{
    if ((values == NULL) || (options == NULL) || (command_mm == NULL) || (feedback_mm == NULL) || (output == NULL)) {
        return (int32_t)EMA_ERR_NULL;
    }
    ema_actuator_t actuator;
    ema_plant_t plant;
    ema_blocks_from(values, options, &actuator, &plant);
    if (!((actuator.params.delay_s / actuator.params.step_s) <= EMA_DELAY_STEPS_MAX)) {
        return (int32_t)EMA_ERR_RANGE;
    }
    ema_state_t state = {0};
    /* before the first row the sensor read what it reads there */
    for (uint32_t k = 0; (rows > 0) && (k < EMA_DELAY_SAMPLES); ++k) {
        state.delay_mm[k] = (ema_real)feedback_mm[0];
    }
    for (int32_t row = 0; row < rows; ++row) {
        /* both sides of the loop have the same recorded reading */
        const ema_real reading_mm = (ema_real)feedback_mm[row];
        const ema_real seen_mm = ema_encoder_step(&plant.encoder, &state, reading_mm, reading_mm);
        output[row] = (double)ema_pid_step(&plant.pid, &state, (ema_real)command_mm[row], seen_mm);
        state.step += (uint32_t)actuator.options.record_every_steps;
    }
    return (int32_t)EMA_OK;
}
