#include "ema/ema_telemetry.h"

#include "base/ema_bytes.h"
#include "base/ema_copy.h"

/* "EMAT". */
#define EMA_TELEMETRY_MARK 0x54414D45U

/* Where things stand: head, flags, what the search did, the residual, the finding, the values, the checksum. */
#define EMA_AT_VERSION 4U
#define EMA_AT_LENGTH 6U
#define EMA_AT_SOFTWARE 8U
#define EMA_AT_SCHEMA 12U
#define EMA_AT_IDENTITY 16U
#define EMA_AT_REASONS 20U
#define EMA_AT_VERDICT 24U
#define EMA_AT_OUTCOME 25U
#define EMA_AT_FLAGS 26U
#define EMA_AT_COUNT 27U
#define EMA_AT_EVALUATIONS 28U
#define EMA_AT_MODEL_STEPS 32U
#define EMA_AT_RANDOM 40U
#define EMA_AT_SEARCH 56U
#define EMA_AT_RESIDUAL 80U
#define EMA_AT_FINDING 100U
#define EMA_AT_ALIKE 104U
#define EMA_AT_SCORES 112U
#define EMA_AT_VALUES 140U
#define EMA_AT_CRC 236U

#define EMA_VALUE_BYTES 24U

/* Bits of the flags, and of a value's. */
#define EMA_FLAG_ADEQUATE 1U
#define EMA_FLAG_FINDING 2U
#define EMA_FLAG_LEAST_SQUARES 4U
#define EMA_FLAG_AT_BOUND 1U

/* No effect, in one byte. */
#define EMA_NO_EFFECT 255U
_Static_assert((uint32_t)EMA_EFFECT_COUNT < EMA_NO_EFFECT, "an effect is numbered by one byte");
_Static_assert((EMA_AT_VALUES + (EMA_IDENTIFIED_MAX * EMA_VALUE_BYTES)) == EMA_AT_CRC,
               "the checksum follows the values");
_Static_assert((EMA_AT_CRC + 4U) == EMA_TELEMETRY_BYTES, "the checksum is the end");

static void ema_put_reals(uint8_t* to, const ema_real* value, size_t count)
{
    for (size_t k = 0; k < count; ++k) {
        ema_put_real(&to[4U * k], value[k]);
    }
}

static void ema_put_head(const ema_session_config_t* config, const ema_result_t* result, bool found, uint8_t* to)
{
    ema_put_u32(to, EMA_TELEMETRY_MARK);
    ema_put_u16(&to[EMA_AT_VERSION], EMA_TELEMETRY_VERSION);
    ema_put_u16(&to[EMA_AT_LENGTH], EMA_TELEMETRY_BYTES);
    ema_put_u32(&to[EMA_AT_SOFTWARE], EMA_VERSION);
    ema_put_u32(&to[EMA_AT_SCHEMA], EMA_CONFIG_SCHEMA);
    ema_put_u32(&to[EMA_AT_IDENTITY], ema_actuator_identity(config->actuator));
    ema_put_u32(&to[EMA_AT_REASONS], result->reasons);
    to[EMA_AT_VERDICT] = (uint8_t)result->verdict;
    to[EMA_AT_OUTCOME] = (uint8_t)result->outcome;
    to[EMA_AT_FLAGS] = (uint8_t)((result->adequate ? EMA_FLAG_ADEQUATE : 0U) | (found ? EMA_FLAG_FINDING : 0U)
                                 | ((result->stage == EMA_STAGE_LEAST_SQUARES) ? EMA_FLAG_LEAST_SQUARES : 0U));
    to[EMA_AT_COUNT] = (uint8_t)result->identified_count;
}

static void ema_put_search(const ema_result_t* result, uint8_t* to)
{
    const ema_annealer_info_t* const search = &result->search;
    const uint32_t counts[] = {search->evaluations,    search->accepted,   search->accepted_uphill,
                               search->from_quadratic, search->reannealed, search->not_finite};
    const ema_real residual[] = {result->objective_before, result->objective_after, result->residual_rms_mm,
                                 result->residual_correlation, result->outside_ratio};
    ema_put_u32(&to[EMA_AT_EVALUATIONS], result->evaluations);
    ema_put_u64(&to[EMA_AT_MODEL_STEPS], result->model_steps);
    ema_put_u64(&to[EMA_AT_RANDOM], result->random.state);
    ema_put_u64(&to[EMA_AT_RANDOM + 8U], result->random.increment);
    for (size_t k = 0; k < (sizeof counts / sizeof counts[0]); ++k) {
        ema_put_u32(&to[EMA_AT_SEARCH + (4U * k)], counts[k]);
    }
    ema_put_reals(&to[EMA_AT_RESIDUAL], residual, sizeof residual / sizeof residual[0]);
}

static uint8_t ema_effect_byte(ema_effect_id_t effect)
{
    return ((uint32_t)effect < (uint32_t)EMA_EFFECT_COUNT) ? (uint8_t)effect : (uint8_t)EMA_NO_EFFECT;
}

static void ema_put_finding(const ema_finding_t* finding, uint8_t* to)
{
    const ema_real scores[] = {finding->score,  finding->runner_up_score, finding->limit,   finding->size,
                               finding->energy, finding->moved[0],        finding->moved[1]};
    to[EMA_AT_FINDING] = (uint8_t)finding->kind;
    to[EMA_AT_FINDING + 1U] = ema_effect_byte(finding->effect);
    to[EMA_AT_FINDING + 2U] = ema_effect_byte(finding->runner_up);
    ema_put_u64(&to[EMA_AT_ALIKE], finding->alike);
    ema_put_reals(&to[EMA_AT_SCORES], scores, sizeof scores / sizeof scores[0]);
}

static void ema_put_value(const ema_session_config_t* config, const ema_result_t* result, uint32_t place, uint8_t* to)
{
    const ema_estimate_t* const estimate = &result->identified[place];
    ema_real half_95 = EMA_R(0.0);
    (void)ema_session_half_95(config, result, place, &half_95);
    const ema_real values[] = {estimate->estimate, estimate->std, estimate->bias, estimate->shift_percent, half_95};
    ema_put_u16(to, config->identified[place].id);
    ema_put_u16(&to[2], estimate->at_bound ? EMA_FLAG_AT_BOUND : 0U);
    ema_put_reals(&to[4], values, sizeof values / sizeof values[0]);
}

ema_status_t ema_result_pack(const ema_session_config_t* config, const ema_result_t* result,
                             const ema_finding_t* finding, uint8_t packet[EMA_TELEMETRY_BYTES])
{
    if ((config == NULL) || (config->actuator == NULL) || (result == NULL) || (packet == NULL)) {
        return EMA_ERR_NULL;
    }
    if ((result->identified_count != config->identified_count) || (result->identified_count > EMA_IDENTIFIED_MAX)) {
        return EMA_ERR_RANGE;
    }
    ema_clear(packet, EMA_TELEMETRY_BYTES);
    ema_put_head(config, result, finding != NULL, packet);
    ema_put_search(result, packet);
    if (finding != NULL) {
        ema_put_finding(finding, packet);
    }
    for (uint32_t place = 0; place < result->identified_count; ++place) {
        ema_put_value(config, result, place, &packet[EMA_AT_VALUES + (place * EMA_VALUE_BYTES)]);
    }
    ema_put_u32(&packet[EMA_AT_CRC], ema_crc32(0U, packet, EMA_AT_CRC));
    return EMA_OK;
}

static ema_image_status_t ema_packet_check(const uint8_t* packet, size_t length)
{
    if (length < EMA_TELEMETRY_BYTES) {
        return EMA_IMAGE_SHORT;
    }
    if (ema_get_u32(packet) != EMA_TELEMETRY_MARK) {
        return EMA_IMAGE_MAGIC;
    }
    if (ema_get_u16(&packet[EMA_AT_VERSION]) != EMA_TELEMETRY_VERSION) {
        return EMA_IMAGE_UNKNOWN_VERSION;
    }
    if (ema_get_u16(&packet[EMA_AT_LENGTH]) != EMA_TELEMETRY_BYTES) {
        return EMA_IMAGE_LENGTH;
    }
    if (ema_crc32(0U, packet, EMA_AT_CRC) != ema_get_u32(&packet[EMA_AT_CRC])) {
        return EMA_IMAGE_CHECKSUM;
    }
    const bool known = (packet[EMA_AT_VERDICT] <= (uint8_t)EMA_VERDICT_UNDECIDED)
                       && (packet[EMA_AT_OUTCOME] <= (uint8_t)EMA_OUTCOME_COUNT)
                       && (packet[EMA_AT_COUNT] <= EMA_IDENTIFIED_MAX)
                       && (packet[EMA_AT_FINDING] <= (uint8_t)EMA_FINDING_NONE);
    return known ? EMA_IMAGE_OK : EMA_IMAGE_LAYOUT;
}

static void ema_get_search(const uint8_t* from, ema_result_t* result)
{
    ema_annealer_info_t* const search = &result->search;
    uint32_t* const counts[] = {&search->evaluations,    &search->accepted,   &search->accepted_uphill,
                                &search->from_quadratic, &search->reannealed, &search->not_finite};
    ema_real* const residual[] = {&result->objective_before, &result->objective_after, &result->residual_rms_mm,
                                  &result->residual_correlation, &result->outside_ratio};
    result->evaluations = ema_get_u32(&from[EMA_AT_EVALUATIONS]);
    result->model_steps = ema_get_u64(&from[EMA_AT_MODEL_STEPS]);
    result->random.state = ema_get_u64(&from[EMA_AT_RANDOM]);
    result->random.increment = ema_get_u64(&from[EMA_AT_RANDOM + 8U]);
    for (size_t k = 0; k < (sizeof counts / sizeof counts[0]); ++k) {
        *counts[k] = ema_get_u32(&from[EMA_AT_SEARCH + (4U * k)]);
    }
    for (size_t k = 0; k < (sizeof residual / sizeof residual[0]); ++k) {
        *residual[k] = ema_get_real(&from[EMA_AT_RESIDUAL + (4U * k)]);
    }
}

static ema_effect_id_t ema_effect_of(uint8_t byte)
{
    return (byte < (uint8_t)EMA_EFFECT_COUNT) ? (ema_effect_id_t)byte : EMA_EFFECT_COUNT;
}

static void ema_get_finding(const uint8_t* from, ema_finding_t* finding)
{
    ema_real* const scores[] = {&finding->score,  &finding->runner_up_score, &finding->limit,   &finding->size,
                                &finding->energy, &finding->moved[0],        &finding->moved[1]};
    finding->kind = (ema_finding_kind_t)from[EMA_AT_FINDING];
    finding->effect = ema_effect_of(from[EMA_AT_FINDING + 1U]);
    finding->runner_up = ema_effect_of(from[EMA_AT_FINDING + 2U]);
    finding->alike = ema_get_u64(&from[EMA_AT_ALIKE]);
    for (size_t k = 0; k < (sizeof scores / sizeof scores[0]); ++k) {
        *scores[k] = ema_get_real(&from[EMA_AT_SCORES + (4U * k)]);
    }
}

ema_image_status_t ema_result_unpack(const uint8_t* packet, size_t length, ema_telemetry_t* telemetry)
{
    if ((packet == NULL) || (telemetry == NULL)) {
        return EMA_IMAGE_NULL;
    }
    const ema_image_status_t status = ema_packet_check(packet, length);
    if (status != EMA_IMAGE_OK) {
        return status;
    }
    ema_result_t* const result = &telemetry->result;
    ema_clear(telemetry, sizeof *telemetry);
    telemetry->software = ema_get_u32(&packet[EMA_AT_SOFTWARE]);
    telemetry->schema = ema_get_u32(&packet[EMA_AT_SCHEMA]);
    telemetry->identity = ema_get_u32(&packet[EMA_AT_IDENTITY]);
    result->reasons = ema_get_u32(&packet[EMA_AT_REASONS]);
    result->verdict = (ema_verdict_t)packet[EMA_AT_VERDICT];
    result->outcome = (ema_outcome_t)packet[EMA_AT_OUTCOME];
    result->adequate = (packet[EMA_AT_FLAGS] & EMA_FLAG_ADEQUATE) != 0U;
    result->stage =
        ((packet[EMA_AT_FLAGS] & EMA_FLAG_LEAST_SQUARES) != 0U) ? EMA_STAGE_LEAST_SQUARES : EMA_STAGE_ANNEALER;
    result->identified_count = packet[EMA_AT_COUNT];
    ema_get_search(packet, result);
    telemetry->has_finding = (packet[EMA_AT_FLAGS] & EMA_FLAG_FINDING) != 0U;
    ema_get_finding(packet, &telemetry->finding);
    for (uint32_t place = 0; place < result->identified_count; ++place) {
        const uint8_t* const from = &packet[EMA_AT_VALUES + (place * EMA_VALUE_BYTES)];
        ema_estimate_t* const estimate = &result->identified[place];
        telemetry->id[place] = (ema_value_id_t)ema_get_u16(from);
        estimate->at_bound = (ema_get_u16(&from[2]) & EMA_FLAG_AT_BOUND) != 0U;
        estimate->estimate = ema_get_real(&from[4]);
        estimate->std = ema_get_real(&from[8]);
        estimate->bias = ema_get_real(&from[12]);
        estimate->shift_percent = ema_get_real(&from[16]);
        telemetry->half_95[place] = ema_get_real(&from[20]);
    }
    return EMA_IMAGE_OK;
}
