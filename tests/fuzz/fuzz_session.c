/* Samples, call order and slices of the session: whatever is asked of it in between, and however often it is copied,
 * put back or begun anew, the answer is the bits that one straight run gives; a call out of place answers its status
 * and changes nothing. */
#include "ema/ema.h"
#include "ema_fuzz.h"

#define ROWS_MAX 112U
#define CALLS_MAX 64U
#define SUBSTEPS_MAX 4U
#define STRAIGHT 1000000U

typedef struct {
    ema_session_config_t config;
    ema_actuator_t actuator;
    ema_real buffer[ROWS_MAX * 2U];
} rig_t;

static ema_sample_t samples[ROWS_MAX];
static uint32_t sample_count;

/* The actuator, record format and search that the head of the input asks for; both rigs are alike but for their
 * buffers. */
static bool make_rig(rig_t* rig, fuzz_bytes_t bytes)
{
    (void)memset(rig, 0, sizeof *rig);
    FUZZ_REQUIRE(ema_actuator_defaults(&rig->actuator) == EMA_OK);
    const uint8_t head = fuzz_u8(&bytes);
    ema_record_config_t record = {
        .buffer = rig->buffer, .buffer_bytes = sizeof rig->buffer, .command_full_scale_mm = EMA_R(26.0)};
    record.full_scale[EMA_CHANNEL_POSITION] = EMA_R(26.0);
    record.format = ((head & 1U) != 0U) ? EMA_RECORD_INT16 : EMA_RECORD_REAL;
    rig->actuator.options.side = (head >> 1) & 1;
    rig->actuator.options.record_every_steps = ((head & 0x9CU) == 0x9CU) ? 2 : 1;
    rig->actuator.options.evaluation_budget = ((head & 0x18U) == 0x18U) ? 4 : 1;
    rig->actuator.options.seed = fuzz_u8(&bytes);
    const uint32_t changes = (head >> 5) & 3U;
    for (uint32_t k = 0; k < changes; ++k) {
        ema_actuator_t changed = rig->actuator;
        fuzz_change(&bytes, &changed, false);
        /* a budget or a rate that makes one input last for minutes says nothing more */
        changed.options.evaluation_budget = rig->actuator.options.evaluation_budget;
        changed.options.record_every_steps = rig->actuator.options.record_every_steps;
        if (ema_actuator_check(&changed, NULL) == EMA_OK) {
            rig->actuator = changed;
        }
    }
    FUZZ_REQUIRE(ema_session_config_default(&rig->config, &rig->actuator, &record) == EMA_OK);
    rig->config.abandon = (head & 64U) == 0U;
    ema_session_t trial;
    ema_model_t model;
    /* a model of many integration steps only makes inputs long */
    return (ema_model_init(&model, &rig->actuator, EMA_R(0.0)) == EMA_OK) && (model.plant.substeps <= SUBSTEPS_MAX)
           && (ema_session_init(&trial, &rig->config) == EMA_OK);
}

/* A rod that follows its command late, with what the input puts on top. */
static void make_samples(fuzz_bytes_t* bytes)
{
    ema_real command_mm = EMA_R(0.0);
    ema_real position_mm = EMA_R(0.0);
    ema_real rate_mm = EMA_R(0.0);
    const ema_real follows = fuzz_share(bytes);
    const uint8_t noise = fuzz_u8(bytes);
    sample_count = 96U + (fuzz_u8(bytes) % 16U);
    for (uint32_t k = 0; k < sample_count; ++k) {
        if ((k % 16U) == 0U) {
            rate_mm = ((ema_real)fuzz_u8(bytes) - EMA_R(128.0)) * EMA_R(1.0e-3);
        }
        command_mm += rate_mm;
        position_mm += follows * (command_mm - position_mm);
        samples[k].command_mm = command_mm;
        samples[k].channel[EMA_CHANNEL_POSITION] =
            position_mm + ((ema_real)((k * 37U) % 17U) * (ema_real)noise * EMA_R(1.0e-5));
    }
    const uint32_t broken = fuzz_u8(bytes) % 8U;
    for (uint32_t k = 0; k < broken; ++k) {
        ema_sample_t* const sample = &samples[fuzz_u8(bytes) % sample_count];
        sample->channel[EMA_CHANNEL_POSITION] = fuzz_any(bytes);
        if ((fuzz_u8(bytes) % 8U) == 0U) {
            sample->command_mm = fuzz_any(bytes);
        }
    }
}

/* Feeds the samples from `*fed` on; those that are refused are left out, as firmware does. */
static void feed(ema_session_t* session, uint32_t* fed, uint32_t count)
{
    for (uint32_t k = 0; (k < count) && (*fed < sample_count); ++k) {
        const uint32_t before = session->record.count;
        const ema_sample_t* const sample = &samples[*fed];
        const ema_status_t status = ema_session_feed(session, sample);
        const bool finite = fuzz_finite(sample->command_mm) && fuzz_finite(sample->channel[EMA_CHANNEL_POSITION]);
        FUZZ_REQUIRE((status == EMA_OK) || (status == EMA_ERR_NOT_FINITE) || (status == EMA_ERR_SCALE)
                     || (status == EMA_ERR_FULL));
        FUZZ_REQUIRE(finite || (status != EMA_OK));
        FUZZ_REQUIRE(session->record.count == (before + ((status == EMA_OK) ? 1U : 0U)));
        ++*fed;
    }
}

static bool same_real(ema_real a, ema_real b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static void require_same(const ema_result_t* a, const ema_result_t* b)
{
    FUZZ_REQUIRE(a->identified_count == b->identified_count);
    for (uint32_t i = 0; i < a->identified_count; ++i) {
        FUZZ_REQUIRE(same_real(a->identified[i].estimate, b->identified[i].estimate)
                     && same_real(a->identified[i].std, b->identified[i].std));
        FUZZ_REQUIRE(same_real(a->identified[i].shift_percent, b->identified[i].shift_percent)
                     && (a->identified[i].at_bound == b->identified[i].at_bound));
    }
    FUZZ_REQUIRE(same_real(a->objective_before, b->objective_before)
                 && same_real(a->objective_after, b->objective_after));
    FUZZ_REQUIRE(same_real(a->residual_rms_mm, b->residual_rms_mm)
                 && same_real(a->residual_correlation, b->residual_correlation));
    FUZZ_REQUIRE((a->evaluations == b->evaluations) && (a->model_steps == b->model_steps)
                 && (a->outcome == b->outcome));
    FUZZ_REQUIRE(memcmp(&a->random, &b->random, sizeof a->random) == 0);
    FUZZ_REQUIRE((a->verdict == b->verdict) && (a->reasons == b->reasons) && (a->adequate == b->adequate));
}

/* What every finished result keeps. */
static void require_sound(const ema_session_config_t* config, const ema_result_t* result)
{
    FUZZ_REQUIRE((result->verdict == EMA_VERDICT_UNDECIDED) == (result->reasons != 0U));
    FUZZ_REQUIRE((result->reasons & (uint32_t)EMA_REASON_NOT_FINISHED) == 0U);
    for (uint32_t i = 0; i < result->identified_count; ++i) {
        const ema_estimate_t* const estimate = &result->identified[i];
        FUZZ_REQUIRE((estimate->estimate >= config->identified[i].lower)
                     && (estimate->estimate <= (config->identified[i].upper * EMA_R(1.000001))));
        FUZZ_REQUIRE((result->verdict == EMA_VERDICT_UNDECIDED) || fuzz_finite(estimate->std));
        ema_real half_95 = EMA_R(-1.0);
        FUZZ_REQUIRE(ema_session_half_95(config, result, i, &half_95) == EMA_OK);
        FUZZ_REQUIRE((result->verdict == EMA_VERDICT_UNDECIDED) || (half_95 >= estimate->std));
    }
    FUZZ_REQUIRE(fuzz_finite(result->objective_before) && fuzz_finite(result->objective_after));
    FUZZ_REQUIRE((result->verdict == EMA_VERDICT_UNDECIDED) || fuzz_finite(result->residual_rms_mm));
}

static void finish(ema_session_t* session, uint32_t steps)
{
    while (ema_session_phase(session) != EMA_PHASE_DONE) {
        FUZZ_REQUIRE(ema_session_run(session, steps) == EMA_OK);
    }
}

/* A question that the phase allows or not; never a change. */
static void ask(ema_session_t* session, uint8_t kind)
{
    const ema_phase_t phase = ema_session_phase(session);
    ema_sample_t sample = {.command_mm = EMA_R(0.0)};
    sample.channel[EMA_CHANNEL_POSITION] = EMA_R(0.0);
    ema_result_t result;
    switch (kind % 4U) {
    case 0U:
        FUZZ_REQUIRE(ema_session_result(session, &result) == ((phase == EMA_PHASE_FEEDING) ? EMA_ERR_ORDER : EMA_OK));
        FUZZ_REQUIRE(
            (phase == EMA_PHASE_FEEDING) || (phase == EMA_PHASE_DONE)
            || ((result.verdict == EMA_VERDICT_UNDECIDED) && (result.reasons == (uint32_t)EMA_REASON_NOT_FINISHED)));
        break;
    case 1U:
        FUZZ_REQUIRE((phase == EMA_PHASE_FEEDING) || (ema_session_feed(session, &sample) == EMA_ERR_ORDER));
        break;
    case 2U:
        FUZZ_REQUIRE((ema_session_feed(session, NULL) == EMA_ERR_NULL) && (ema_session_run(NULL, 1U) == EMA_ERR_NULL));
        FUZZ_REQUIRE(ema_session_result(session, NULL) == EMA_ERR_NULL);
        break;
    default:
        FUZZ_REQUIRE((phase != EMA_PHASE_FEEDING) || (session->record.count >= EMA_ROWS_MIN)
                     || (ema_session_run(session, 5U) == EMA_ERR_SHORT));
        break;
    }
}

/* The same work as told by the input: in slices, by copies, with restarts. */
static bool wander(const rig_t* rig, fuzz_bytes_t* bytes, ema_result_t* result)
{
    static ema_session_t slots[2];
    static ema_session_t kept;
    uint32_t kept_fed = 0U;
    uint32_t fed = 0U;
    uint32_t place = 0U;
    bool have_kept = false;
    ema_session_t* session = &slots[place];
    FUZZ_REQUIRE(ema_session_init(session, &rig->config) == EMA_OK);
    for (uint32_t call = 0; (call < CALLS_MAX) && (bytes->left > 0U); ++call) {
        const uint8_t what = fuzz_u8(bytes);
        const uint8_t much = fuzz_u8(bytes);
        const bool ready = (fed == sample_count) && (session->record.count >= EMA_ROWS_MIN);
        switch (what % 8U) {
        case 0U:
        case 1U:
            if (ema_session_phase(session) == EMA_PHASE_FEEDING) {
                feed(session, &fed, much);
            }
            break;
        case 2U:
        case 3U:
            if (ready) {
                const uint32_t steps = (uint32_t)much * (uint32_t)(1U + (what >> 4));
                const ema_status_t status = ema_session_run(session, steps);
                FUZZ_REQUIRE((steps > 0U) ? (status == EMA_OK) || (ema_session_phase(session) == EMA_PHASE_FEEDING)
                                          : status == EMA_ERR_RANGE);
            }
            break;
        case 4U: {
            /* goes on elsewhere; what is left behind is destroyed */
            ema_session_t* const next = &slots[1U - place];
            (void)memcpy(next, session, sizeof *next);
            (void)memset(session, 0xA5, sizeof *session);
            place = 1U - place;
            session = next;
            break;
        }
        case 5U:
            if (much < 64U) {
                FUZZ_REQUIRE(ema_session_init(session, &rig->config) == EMA_OK);
                fed = 0U;
            } else if ((much < 128U) || !have_kept) {
                (void)memcpy(&kept, session, sizeof kept);
                kept_fed = fed;
                have_kept = true;
            } else {
                (void)memcpy(session, &kept, sizeof *session);
                fed = kept_fed;
            }
            break;
        default:
            ask(session, much);
            break;
        }
    }
    feed(session, &fed, sample_count);
    if ((session->record.count < EMA_ROWS_MIN) || (ema_session_run(session, 1U) != EMA_OK)) {
        return false;
    }
    finish(session, 1U + fuzz_u16(bytes) % 1000U);
    FUZZ_REQUIRE(ema_session_result(session, result) == EMA_OK);
    return true;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static rig_t straight;
    static rig_t wandering;
    static ema_session_t session;
    if (size < 16U) {
        return 0;
    }
    /* the head of the input makes the rig, then come the samples, then the calls */
    const fuzz_bytes_t head = {data, 16U};
    fuzz_bytes_t bytes = {data + 16, size - 16U};
    if (!make_rig(&straight, head)) {
        return 0;
    }
    FUZZ_REQUIRE(make_rig(&wandering, head));
    make_samples(&bytes);

    ema_result_t expected;
    ema_result_t found;
    uint32_t fed = 0U;
    FUZZ_REQUIRE(ema_session_init(&session, &straight.config) == EMA_OK);
    feed(&session, &fed, sample_count);
    const bool runs = (session.record.count >= EMA_ROWS_MIN) && (ema_session_run(&session, 1U) == EMA_OK);
    if (runs) {
        finish(&session, STRAIGHT);
        FUZZ_REQUIRE(ema_session_result(&session, &expected) == EMA_OK);
        require_sound(&straight.config, &expected);
    }
    FUZZ_REQUIRE(wander(&wandering, &bytes, &found) == runs);
    if (runs) {
        require_same(&expected, &found);
    }
    return 0;
}
