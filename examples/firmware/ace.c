#include "ace.h"

#include "ace_board.h"

/* What is known of the machine, as `ema export` writes it: the data sheet's model, or with ACE_UNIT that of one unit,
 * made from its healthy runs; with ACE_IMAGE that of the unit of this name in a binary image, as it lies in flash. */
#ifdef ACE_IMAGE
#include "ace_image.h"
#elif defined(ACE_UNIT)
#include "ace_unit_actuator.h"
#include "ace_unit_signatures.h"
#else
#include "ace_actuator.h"
#include "ace_signatures.h"
#endif

#define US_PER_S 1000000U
#define TICK_S (1.0f / (float)ACE_TICK_HZ)
#define MM_PER_M 1000.0f

/* Full scale of the record. The chirp and room for overshoot: a count of int16 is 0.12 um. More than the supply can
 * drive through the winding: 0.9 mA. */
#define FULL_SCALE_MM 4.0f
#define FULL_SCALE_A 30.0f

static const ema_command_config_t chirp_config = {
    .kind = EMA_COMMAND_CHIRP, .amplitude_mm = 2.0f, .start_hz = 0.1f, .end_hz = 4.0f, .duration_s = 10.0f};

/* Everything the firmware keeps. The interrupt writes the first part; the background reads it once `recorded` is set,
 * its counts at any time. */
static struct {
    ema_command_t chirp;
    uint32_t start;
    uint32_t period;
    uint32_t late_limit;
    float integral;
    volatile uint32_t ticks;
    volatile uint32_t late_ticks;
    volatile uint32_t latest;
    volatile uint32_t longest;
    volatile uint32_t spent; /* in interrupts, modulo 2^32 */
    volatile bool recorded;
    volatile ema_status_t fed;
    ema_unit_t unit; /* of an image */
    const ema_actuator_t* actuator;
    const ema_signatures_t* signatures;
    union { /* one after the other */
        ema_selftest_t selftest;
        ema_guarded_t guarded;
    };
    ema_session_config_t config;
    _Alignas(ema_real) int16_t record[2U * ACE_ROWS];
} ace;

/* Where the configuration is. */
static ema_image_status_t known(void)
{
#ifdef ACE_IMAGE
    uint32_t place = 0U;
    ema_image_status_t status = ema_image_find(ace_image, ace_image_bytes, ACE_IMAGE, &place);
    if (status == EMA_IMAGE_OK) {
        status = ema_image_open(ace_image, ace_image_bytes, place, &ace.unit);
    }
    ace.actuator = ace.unit.actuator;
    ace.signatures = ace.unit.has_signatures ? &ace.unit.signatures : NULL;
    return status;
#else
    ace.actuator = &EMA_ACTUATOR;
    ace.signatures = &EMA_SIGNATURES;
    return EMA_IMAGE_OK;
#endif
}

/* PI with back-calculation: the control law of the actuator's file. */
static float control(float command_mm, float motor_mm)
{
    const ema_params_t* const params = &ace.actuator->params;
    const float error_m = (command_mm - motor_mm) / MM_PER_M;
    const float raw = (params->kp_per_m * error_m) + ace.integral;
    const float limit = params->output_limit;
    const float output = (raw < -limit) ? -limit : (raw > limit) ? limit : raw;
    ace.integral += TICK_S * ((params->ki_per_m_s * error_m) + (params->anti_windup_per_s * (output - raw)));
    return output;
}

static void feed(float command_mm, const ace_sensors_t* seen)
{
    const ema_sample_t sample = {
        .command_mm = command_mm,
        .channel = {[EMA_CHANNEL_POSITION] = seen->rod_mm, [EMA_CHANNEL_CURRENT] = seen->current_A}};
    ace.fed = ema_guarded_feed(&ace.guarded, &sample);
    ace.recorded = (ace.fed != EMA_OK) || ((ace.ticks + 1U) == ACE_ROWS);
}

/* The timer interrupt. */
static void ace_tick(void)
{
    const uint32_t begin = ace_board_now();
    /* a lost tick makes all later ones late by a period */
    const uint32_t late = begin - (ace.start + ((ace.ticks + 1U) * ace.period));
    const ace_sensors_t seen = ace_board_sensors();
    const float command_mm = ema_command_at(&ace.chirp, ace.ticks);
    ace_board_drive(control(command_mm, seen.motor_mm) * ace.actuator->params.supply_V);
    if (!ace.recorded) {
        feed(command_mm, &seen);
    }
    ace.late_ticks += (late > ace.late_limit) ? 1U : 0U;
    ace.latest = (late > ace.latest) ? late : ace.latest;
    ++ace.ticks;
    const uint32_t took = ace_board_now() - begin;
    ace.longest = (took > ace.longest) ? took : ace.longest;
    ace.spent += took;
}

static ema_status_t prepare(const ace_limits_t* limits)
{
    /* the command is known at every tick, so its place in the record is free for the current, which the table asks for
     */
    ema_record_config_t record = {
        .buffer = ace.record, .buffer_bytes = sizeof ace.record, .format = EMA_RECORD_INT16, .command = &ace.chirp};
    record.full_scale[EMA_CHANNEL_POSITION] = FULL_SCALE_MM;
    record.keep[EMA_CHANNEL_CURRENT] = true;
    record.full_scale[EMA_CHANNEL_CURRENT] = FULL_SCALE_A;
    ema_status_t status = ema_command_init(&ace.chirp, &chirp_config, TICK_S);
    if (status == EMA_OK) {
        status = ema_session_config_default(&ace.config, ace.actuator, &record);
    }
    if (status == EMA_OK) {
        /* grease and winding too, where the machine's model says so */
        status = ema_session_config_day(&ace.config);
    }
    if (status == EMA_OK) {
        status = ema_guarded_init(&ace.guarded, &ace.config, ace.signatures);
    }
    ace.integral = 0.0f;
    ace.ticks = 0U;
    ace.late_ticks = 0U;
    ace.latest = 0U;
    ace.longest = 0U;
    ace.spent = 0U;
    ace.recorded = false;
    ace.fed = EMA_OK;
    ace.period = ace_board_hz() / ACE_TICK_HZ;
    ace.late_limit = limits->tick_late_us * (ace_board_hz() / US_PER_S);
    return status;
}

/* The counter without the time spent in interrupts. */
static uint32_t own_now(void)
{
    uint32_t spent = 0U;
    uint32_t now = 0U;
    do {
        spent = ace.spent;
        now = ace_board_now();
    } while (spent != ace.spent); /* an interrupt came between the two */
    return now - spent;
}

/* Gives search and diagnosis their slices until both are done; the time of interrupts in between is not the slice's. */
static ema_status_t search(const ace_limits_t* limits, ace_report_t* report)
{
    const uint32_t allowed = limits->slice_us * (ace_board_hz() / US_PER_S);
    uint32_t longest = 0U;
    ema_status_t status = ace.fed;
    while ((status == EMA_OK) && (ema_guarded_phase(&ace.guarded) != EMA_GUARDED_DONE)) {
        const uint32_t begin = own_now();
        status = ema_guarded_run(&ace.guarded, limits->slice_steps);
        const uint32_t took = own_now() - begin;
        ++report->slices;
        report->overruns += (took > allowed) ? 1U : 0U;
        longest = (took > longest) ? took : longest;
    }
    report->slice_us = longest / (ace_board_hz() / US_PER_S);
    report->allowed_us = limits->slice_us;
    if (status == EMA_OK) {
        status = ema_guarded_result(&ace.guarded, &report->result, &report->finding);
    }
    for (uint32_t i = 0; (status == EMA_OK) && (i < report->result.identified_count); ++i) {
        status = ema_session_half_95(&ace.config, &report->result, i, &report->half_95[i]);
    }
    if (status == EMA_OK) {
        status = ema_result_pack(&ace.config, &report->result, &report->finding, report->packet);
    }
    return status;
}

void ace_run(const ace_limits_t* limits, ace_report_t* report)
{
    const ace_report_t fresh = {0};
    *report = fresh;
    report->selftest = ema_selftest(&ace.selftest, EMA_SELFTEST_BUILD);
    if (report->selftest != EMA_SELFTEST_PASSED) {
        report->status = ACE_UNSOUND;
        return;
    }
    report->image = known();
    if (report->image != EMA_IMAGE_OK) {
        report->status = ACE_UNKNOWN;
        return;
    }
    report->session = prepare(limits);
    if (report->session == EMA_OK) {
        ace.start = ace_board_start(ace.period, ace_tick);
        while (!ace.recorded) {
            ace_board_wait();
        }
        const uint32_t recording = ace.ticks;
        report->session = search(limits, report);
        ace_board_stop();
        report->ticks = ace.ticks;
        report->ticks_searching = ace.ticks - recording;
        report->late_ticks = ace.late_ticks;
        report->latest_us = ace.latest / (ace_board_hz() / US_PER_S);
        report->tick_us = ace.longest / (ace_board_hz() / US_PER_S);
    }
    if (report->session != EMA_OK) {
        report->status = ACE_REFUSED;
    } else if (report->late_ticks > 0U) {
        report->status = ACE_LATE;
    } else {
        report->status = (report->overruns > 0U) ? ACE_OVERRUN : ACE_OK;
    }
}
