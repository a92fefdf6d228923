/* The example firmware: one ground test, then its report on the console.
 *
 * ace [SLICE_STEPS [SLICE_US [TICK_LATE_US]]]: what is allowed, so that a test can ask for too little. The exit code is
 * the status.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ace.h"

static void print_real(const char* name, ema_real value)
{
    uint32_t bits = 0U;
    (void)memcpy(&bits, &value, sizeof bits);
    (void)printf("%s %08" PRIx32 " %.9g\n", name, bits, (double)value);
}

static void print_result(const ema_result_t* result, const ema_real* half_95)
{
    for (uint32_t i = 0; i < result->identified_count; ++i) {
        print_real("estimate", result->identified[i].estimate);
        print_real("std", result->identified[i].std);
        print_real("half_95", half_95[i]);
        print_real("shift_percent", result->identified[i].shift_percent);
    }
    print_real("objective_after", result->objective_after);
    (void)printf("evaluations %" PRIu32 "\nrandom %016llx\n", result->evaluations,
                 (unsigned long long)result->random.state);
    (void)printf("verdict %d\nadequate %d\nreasons %08" PRIx32 "\n", (int)result->verdict, (int)result->adequate,
                 result->reasons);
}

/* What the model lacks, beside what was estimated with it. */
static void print_finding(const ema_finding_t* finding)
{
    static const char* const kinds[] = {"adequate", "missing", "unknown", "none"};
    const bool named = finding->kind == EMA_FINDING_MISSING;
    (void)printf("finding %s\neffect %s\n", kinds[finding->kind], named ? ema_effect_name(finding->effect) : "none");
    print_real("size", named ? finding->size : EMA_R(0.0));
    print_real("score", finding->score);
    print_real("limit", finding->limit);
    print_real("energy", finding->energy);
}

/* The packet as it goes to the bus, in hexadecimal. */
static void print_packet(const uint8_t* packet)
{
    (void)printf("packet ");
    for (uint32_t k = 0; k < EMA_TELEMETRY_BYTES; ++k) {
        (void)printf("%02x", (unsigned)packet[k]);
    }
    (void)printf("\n");
}

static uint32_t number(int argc, char* argv[], int place, uint32_t otherwise)
{
    return (argc > place) ? (uint32_t)strtoul(argv[place], NULL, 10) : otherwise;
}

int main(int argc, char* argv[])
{
    static const char* const names[] = {"ok", "late", "overrun", "refused", "unsound", "unknown"};
    static ace_report_t report;
    const ace_limits_t limits = {.slice_steps = number(argc, argv, 1, 200U),
                                 .slice_us = number(argc, argv, 2, 2000U),
                                 .tick_late_us = number(argc, argv, 3, 20U)};
    ace_run(&limits, &report);
    (void)printf("status %s\nselftest %d\nimage %d %s\nsession %s\n", names[report.status], (int)report.selftest,
                 (int)report.image, ema_image_text(report.image), ema_status_text(report.session));
    (void)printf("ticks %" PRIu32 "\nticks_searching %" PRIu32 "\nlate_ticks %" PRIu32 "\nlatest_us %" PRIu32
                 "\ntick_us %" PRIu32 "\n",
                 report.ticks, report.ticks_searching, report.late_ticks, report.latest_us, report.tick_us);
    (void)printf("slices %" PRIu32 "\noverruns %" PRIu32 "\nslice_us %" PRIu32 "\nallowed_us %" PRIu32 "\n",
                 report.slices, report.overruns, report.slice_us, report.allowed_us);
    if (report.status < ACE_REFUSED) {
        print_result(&report.result, report.half_95);
        print_finding(&report.finding);
        print_packet(report.packet);
    }
    return (int)report.status;
}
