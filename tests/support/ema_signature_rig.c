#include "ema_signature_rig.h"

#include <math.h>

#define CSJ_STEP EMA_R(0.005)
#define BLK_STEP EMA_R(0.008)
#define INERTIA_STEP EMA_R(0.1)
#define SPRING_STEP EMA_R(0.01)

static const double weight[EMA_TABLE_CHANNELS] = {1.0 / (EMA_TABLE_NOISE_MM * 0.16), 1.0 / (EMA_TABLE_NOISE_A * 0.16)};

ema_command_t ema_signature_command(const ema_actuator_t* actuator)
{
    return ema_rig_chirp(EMA_R(4.0), EMA_R(2.0), actuator->params.step_s);
}

ema_sample_t ema_signature_sample(ema_model_t* model, const ema_command_t* command, uint32_t row, ema_random_t* noise)
{
    const ema_real command_mm = ema_command_at(command, row);
    const ema_output_t output = ema_rig_step(model, command_mm);
    const ema_real position_mm = output.position_mm + ((ema_real)EMA_TABLE_NOISE_MM * ema_random_normal(noise));
    const ema_real current_A = output.current_A + ((ema_real)EMA_TABLE_NOISE_A * ema_random_normal(noise));
    const ema_sample_t sample = {command_mm, {position_mm, output.motor_position_mm, current_A, output.voltage_V}};
    return sample;
}

void ema_signature_vector(const ema_actuator_t* moved, const ema_actuator_t* still, double* vector)
{
    const ema_command_t command = ema_signature_command(still);
    ema_model_t one = ema_rig_model(moved, EMA_R(0.0));
    ema_model_t other = ema_rig_model(still, EMA_R(0.0));
    for (uint32_t bin = 0; bin < EMA_TABLE_BINS; ++bin) {
        double sum[EMA_TABLE_CHANNELS] = {0.0};
        for (uint32_t k = 0; k < EMA_TABLE_BIN_ROWS; ++k) {
            const ema_real command_mm = ema_command_at(&command, (bin * EMA_TABLE_BIN_ROWS) + k);
            const ema_output_t first = ema_rig_step(&one, command_mm);
            const ema_output_t second = ema_rig_step(&other, command_mm);
            sum[0] += (double)first.position_mm - (double)second.position_mm;
            sum[1] += (double)first.current_A - (double)second.current_A;
        }
        for (uint32_t k = 0; k < EMA_TABLE_CHANNELS; ++k) {
            vector[(bin * EMA_TABLE_CHANNELS) + k] = (sum[k] / (double)EMA_TABLE_BIN_ROWS) * weight[k];
        }
    }
}

static double product(const double* a, const double* b)
{
    double sum = 0.0;
    for (uint32_t k = 0; k < EMA_TABLE_VECTOR; ++k) {
        sum += a[k] * b[k];
    }
    return sum;
}

/* Takes `other`, of length one, off. */
static void take_off(double* vector, const double* other)
{
    const double share = product(vector, other);
    for (uint32_t k = 0; k < EMA_TABLE_VECTOR; ++k) {
        vector[k] -= share * other[k];
    }
}

/* Makes the length one; what it was. */
static double normalise(double* vector)
{
    const double length = sqrt(product(vector, vector));
    for (uint32_t k = 0; k < EMA_TABLE_VECTOR; ++k) {
        vector[k] /= length;
    }
    return length;
}

static int16_t counts(double value, double unit)
{
    return (int16_t)floor((value / unit) + 0.5);
}

static void write_values(ema_signature_rig_t* rig, const ema_actuator_t* actuator)
{
    const ema_command_t command = ema_signature_command(actuator);
    const size_t stride = 1U + (EMA_TABLE_CHANNELS * (1U + EMA_TABLE_ROWS));
    for (uint32_t row = 0; row < EMA_TABLE_ROWS; ++row) {
        double largest = 0.0;
        for (uint32_t k = 0; k < EMA_TABLE_VECTOR; ++k) {
            largest = fmax(largest, fabs(rig->row[row][k]));
        }
        rig->unit[row] = (ema_real)(largest / 32767.0);
    }
    for (uint32_t bin = 0; bin < EMA_TABLE_BINS; ++bin) {
        int16_t* const value = &rig->value[stride * bin];
        double mean_mm = 0.0;
        for (uint32_t k = 0; k < EMA_TABLE_BIN_ROWS; ++k) {
            mean_mm += (double)ema_command_at(&command, (bin * EMA_TABLE_BIN_ROWS) + k) / (double)EMA_TABLE_BIN_ROWS;
        }
        value[0] = counts(mean_mm, (double)rig->table.command_unit_mm);
        for (uint32_t k = 0; k < EMA_TABLE_CHANNELS; ++k) {
            value[1U + k] = 0;
            for (uint32_t row = 0; row < EMA_TABLE_ROWS; ++row) {
                value[1U + EMA_TABLE_CHANNELS + (row * EMA_TABLE_CHANNELS) + k] =
                    counts(rig->row[row][(bin * EMA_TABLE_CHANNELS) + k], (double)rig->unit[row]);
            }
        }
    }
}

void ema_signature_rig(ema_signature_rig_t* rig, const ema_actuator_t* actuator)
{
    (void)memset(rig, 0, sizeof *rig);
    double csj[EMA_TABLE_VECTOR];
    double blk[EMA_TABLE_VECTOR];
    ema_actuator_t moved = *actuator;
    moved.params.csj_Nm += CSJ_STEP;
    ema_signature_vector(&moved, actuator, csj);
    moved = *actuator;
    moved.params.blk_mm += BLK_STEP;
    ema_signature_vector(&moved, actuator, blk);
    moved = *actuator;
    moved.effects.inertia_change.change = INERTIA_STEP;
    ema_signature_vector(&moved, actuator, rig->row[2]);
    moved = *actuator;
    moved.effects.spring_load.stiffness_Nm_per_mm = SPRING_STEP;
    ema_signature_vector(&moved, actuator, rig->row[3]);

    (void)memcpy(rig->row[0], blk, sizeof blk);
    const double blk_length = normalise(rig->row[0]);
    (void)memcpy(rig->row[1], csj, sizeof csj);
    const double csj_whole = sqrt(product(csj, csj));
    take_off(rig->row[1], rig->row[0]);
    const double csj_length = normalise(rig->row[1]);
    double length[2];
    for (uint32_t k = 0; k < 2U; ++k) {
        take_off(rig->row[2U + k], rig->row[0]);
        take_off(rig->row[2U + k], rig->row[1]);
        length[k] = normalise(rig->row[2U + k]);
    }
    (void)memcpy(rig->row[4], rig->row[1], sizeof rig->row[4]);
    (void)memcpy(rig->row[5], blk, sizeof blk);
    (void)normalise(csj);
    take_off(rig->row[5], csj);
    const double blk_alone = normalise(rig->row[5]);

    const ema_pattern_t inertia = {(uint8_t)EMA_EFFECT_ID_inertia_change,
                                   2U,
                                   1U,
                                   false,
                                   {(ema_real)((double)INERTIA_STEP / length[0]), EMA_R(0.0), EMA_R(0.0)},
                                   EMA_R(0.0)};
    const ema_pattern_t spring = {(uint8_t)EMA_EFFECT_ID_spring_load,
                                  3U,
                                  1U,
                                  true,
                                  {(ema_real)((double)SPRING_STEP / length[1]), EMA_R(0.0), EMA_R(0.0)},
                                  EMA_R(0.0)};
    rig->pattern[0] = inertia;
    rig->pattern[1] = spring;
    ema_signatures_t* const table = &rig->table;
    table->version = EMA_SIGNATURES_VERSION;
    table->fingerprint = ema_onboard_fingerprint(actuator);
    table->record_rows = EMA_TABLE_RECORD_ROWS;
    table->bin_rows = EMA_TABLE_BIN_ROWS;
    table->bins = EMA_TABLE_BINS;
    table->channels = EMA_TABLE_CHANNELS;
    table->channel[0] = (uint8_t)EMA_CHANNEL_POSITION;
    table->channel[1] = (uint8_t)EMA_CHANNEL_CURRENT;
    table->patterns = 2U;
    table->faults = 2U;
    table->nuisances = 2U;
    table->rows = EMA_TABLE_ROWS;
    table->command_unit_mm = EMA_R(2.0) / EMA_R(32767.0);
    table->command_apart_mm = EMA_R(0.01);
    table->reference[0] = EMA_R(1.0e-6);
    table->reference[1] = EMA_R(1.0e-6);
    table->weight[0] = (ema_real)weight[0];
    table->weight[1] = (ema_real)weight[1];
    table->limit = EMA_R(30.0);
    table->energy = EMA_R(160.0);
    const ema_signature_fault_t fault_csj = {EMA_VALUE_ID(csj_Nm), 4U, actuator->params.csj_Nm,
                                             (ema_real)((double)CSJ_STEP / csj_length),
                                             (ema_real)(csj_whole / (double)CSJ_STEP)};
    const ema_signature_fault_t fault_blk = {EMA_VALUE_ID(blk_mm), 5U, actuator->params.blk_mm,
                                             (ema_real)((double)BLK_STEP / blk_alone),
                                             (ema_real)(blk_length / (double)BLK_STEP)};
    table->fault[0] = fault_csj;
    table->fault[1] = fault_blk;
    table->pattern = rig->pattern;
    table->unit = rig->unit;
    table->value = rig->value;
    write_values(rig, actuator);
}
