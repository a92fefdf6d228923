/* An example ACE: a position loop at 1 kHz in the timer interrupt, the identification and the onboard diagnosis in the
 * background.
 *
 * The interrupt commands the chirp, closes the loop and feeds the guarded session a row; once the record is full, the
 * background gives it its slices while the loop goes on. The answer is CSJ and BLK, what the table of signatures found
 * missing from the model, and a verdict that knows both. How late a tick came and how long a slice took are measured
 * against what is allowed.
 */
#ifndef ACE_H
#define ACE_H

#include "ema/ema.h"

#define ACE_TICK_HZ 1000U
#define ACE_ROWS 10000U

typedef enum {
    ACE_OK = 0,
    ACE_LATE = 1,    /* a control tick came late: something held the interrupt up */
    ACE_OVERRUN = 2, /* a slice took longer than allowed: make it shorter */
    ACE_REFUSED = 3, /* the session refused a call */
    ACE_UNSOUND = 4, /* the module's self-test failed: nothing was recorded */
    ACE_UNKNOWN = 5  /* the image of the configuration was refused: nothing was recorded */
} ace_status_t;

/* What is allowed, in microseconds, and the length of a slice. */
typedef struct {
    uint32_t tick_late_us;
    uint32_t slice_us;
    uint32_t slice_steps;
} ace_limits_t;

typedef struct {
    ace_status_t status; /* unsound before unknown before refused before late before overrun */
    ema_selftest_outcome_t selftest;
    ema_image_status_t image; /* what was said of the configuration's image, where there is one */
    ema_status_t session;     /* what the session answered last */
    uint32_t ticks;           /* control ticks made */
    uint32_t ticks_searching; /* those while the search ran */
    uint32_t late_ticks;
    uint32_t latest_us; /* how late the latest tick began */
    uint32_t tick_us;   /* what the longest took */
    uint32_t slices;
    uint32_t overruns;
    uint32_t slice_us; /* what the longest took, interrupts not counted */
    uint32_t allowed_us;
    ema_result_t result;                  /* when status is less than ACE_REFUSED; its verdict is the guarded one */
    ema_real half_95[EMA_IDENTIFIED_MAX]; /* of the 95 % intervals about its estimates */
    ema_finding_t finding;                /* likewise: the effect that the model lacks, and its size */
    uint8_t packet[EMA_TELEMETRY_BYTES];  /* likewise: all of it, for a bus */
} ace_report_t;

/* The whole ground test: self-test, configuration, chirp, record, identification. */
void ace_run(const ace_limits_t* limits, ace_report_t* report);

#endif
