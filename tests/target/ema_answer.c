/* Identifies one recorded case, or the worn unit by its own model, and prints the answer's bits: built for the host and
 * for the target, which must print the same.
 *
 * ema_answer a|b|c|u SEED SLICE real|int16 annealer|two_stages
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ema_recorded.h"

static ema_recorded_t recorded;

static void print_real(const char* name, ema_real value)
{
    uint32_t bits = 0U;
    (void)memcpy(&bits, &value, sizeof bits);
    (void)printf("%s %08" PRIx32 " %.9g\n", name, bits, (double)value);
}

static void print_result(const ema_session_config_t* config, const ema_result_t* result)
{
    for (uint32_t i = 0; i < result->identified_count; ++i) {
        print_real("estimate", result->identified[i].estimate);
        print_real("std", result->identified[i].std);
        ema_real half_95 = EMA_R(0.0);
        (void)ema_session_half_95(config, result, i, &half_95);
        print_real("half_95", half_95);
        print_real("shift_percent", result->identified[i].shift_percent);
    }
    print_real("objective_before", result->objective_before);
    print_real("objective_after", result->objective_after);
    print_real("residual_rms_mm", result->residual_rms_mm);
    print_real("residual_correlation", result->residual_correlation);
    (void)printf("evaluations %" PRIu32 "\nmodel_steps %llu\n", result->evaluations,
                 (unsigned long long)result->model_steps);
    (void)printf("random %016llx %016llx\n", (unsigned long long)result->random.state,
                 (unsigned long long)result->random.increment);
    (void)printf("stage %d\noutcome %d\nverdict %d\nadequate %d\nreasons %08" PRIx32 "\n", (int)result->stage,
                 (int)result->outcome, (int)result->verdict, (int)result->adequate, result->reasons);
}

int main(int argc, char* argv[])
{
    if (argc != 6) {
        (void)puts("usage: ema_answer a|b|c|u SEED SLICE real|int16 annealer|two_stages");
        return 2;
    }
    const uint32_t slice = (uint32_t)strtoul(argv[3], NULL, 10);
    const ema_record_format_t format = (strcmp(argv[4], "int16") == 0) ? EMA_RECORD_INT16 : EMA_RECORD_REAL;
    uint64_t slices = 0U;
    ema_result_t result;
    const ema_search_t search = (strcmp(argv[5], "annealer") == 0) ? EMA_SEARCH_ANNEALER : EMA_SEARCH_TWO_STAGES;
    ema_status_t status =
        ema_recorded_start(&recorded, argv[1][0], (uint32_t)strtoul(argv[2], NULL, 10), format, search);
    (void)printf("case %s\nseed %s\nformat %s\nrows %" PRIu32 "\n", argv[1], argv[2], argv[4],
                 recorded.session.record.count);
    while ((status == EMA_OK) && (ema_session_phase(&recorded.session) != EMA_PHASE_DONE)) {
        status = ema_session_run(&recorded.session, slice);
        ++slices;
    }
    if (status == EMA_OK) {
        status = ema_session_result(&recorded.session, &result);
    }
    if (status != EMA_OK) {
        (void)printf("status %s\n", ema_status_text(status));
        return 1;
    }
    print_result(&recorded.config, &result);
    (void)printf("slices %llu\n", (unsigned long long)slices);
    return 0;
}
