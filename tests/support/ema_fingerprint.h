/* Fingerprints of bits that every build must have, and of an identification: what the tests of compilers and of choices
 * share. */
#ifndef EMA_FINGERPRINT_H
#define EMA_FINGERPRINT_H

#include "ema/ema.h"
#include "unity.h"

#define FINGERPRINT_ROWS 4000U
#define FINGERPRINT_START UINT64_C(14695981039346656037)

/* FNV-1a over bytes. */
static inline uint64_t fingerprint(uint64_t hash, const void* bytes, size_t count)
{
    const unsigned char* const data = bytes;
    for (size_t k = 0; k < count; ++k) {
        hash = (hash ^ data[k]) * UINT64_C(1099511628211);
    }
    return hash;
}

static inline uint64_t fingerprint_of(uint64_t hash, ema_real value)
{
    return fingerprint(hash, &value, sizeof value);
}

static inline ema_command_t fingerprint_chirp(void)
{
    ema_command_t command;
    const ema_command_config_t config = {.kind = EMA_COMMAND_CHIRP,
                                         .amplitude_mm = EMA_R(2.0),
                                         .start_hz = EMA_R(0.1),
                                         .end_hz = EMA_R(4.0),
                                         .duration_s = EMA_R(4.0)};
    TEST_ASSERT_EQUAL(EMA_OK, ema_command_init(&command, &config, EMA_R(0.001)));
    return command;
}

/* Of an identification of a worn actuator, whose `record` has room for FINGERPRINT_ROWS: the way of the search,
 * estimates, their errors. */
static inline uint64_t fingerprint_of_answer(const ema_actuator_t* healthy, const ema_record_config_t* record,
                                             ema_search_t search)
{
    static ema_model_t model;
    static ema_session_t session;
    static ema_session_config_t config;
    ema_actuator_t worn = *healthy;
    worn.params.csj_Nm = EMA_R(0.3);
    worn.params.blk_mm = EMA_R(0.04125);
    const ema_command_t command = fingerprint_chirp();
    ema_result_t result;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_config_default(&config, healthy, record));
    config.search = search;
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_init(&session, &config));
    TEST_ASSERT_EQUAL(EMA_OK, ema_model_init(&model, &worn, EMA_R(0.0)));
    for (uint32_t row = 0; row < FINGERPRINT_ROWS; ++row) {
        ema_output_t output;
        ema_sample_t sample = {.command_mm = ema_command_at(&command, row)};
        TEST_ASSERT_EQUAL(EMA_OK, ema_model_step(&model, sample.command_mm, &output));
        sample.channel[EMA_CHANNEL_POSITION] = output.position_mm;
        TEST_ASSERT_EQUAL(EMA_OK, ema_session_feed(&session, &sample));
    }
    while (ema_session_phase(&session) != EMA_PHASE_DONE) {
        TEST_ASSERT_EQUAL(EMA_OK, ema_session_run(&session, 5000U));
    }
    TEST_ASSERT_EQUAL(EMA_OK, ema_session_result(&session, &result));
    TEST_ASSERT_EQUAL(EMA_VERDICT_FAULT, result.verdict);
    uint64_t hash = fingerprint(FINGERPRINT_START, &result.random.state, sizeof result.random.state);
    hash = fingerprint(hash, &result.evaluations, sizeof result.evaluations);
    for (uint32_t i = 0; i < result.identified_count; ++i) {
        hash = fingerprint_of(hash, result.identified[i].estimate);
        hash = fingerprint_of(hash, result.identified[i].std);
    }
    return fingerprint_of(hash, result.objective_after);
}

#endif
