#include "ema_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ema_csv_text.h"

/* The session identifies these two, in this order. */
#define FAULTS 2U
static const char* const ema_fault_name[FAULTS] = {"CSJ", "BLK"};
static const char* const ema_fault_unit[FAULTS] = {"Nm", "mm"};
static const char* const ema_fault_key[FAULTS] = {"csj_Nm", "blk_mm"};

static const char* ema_verdict_name(ema_verdict_t verdict)
{
    const char* name = "undecided";
    switch (verdict) {
    case EMA_VERDICT_HEALTHY:
        name = "healthy";
        break;
    case EMA_VERDICT_FAULT:
        name = "fault";
        break;
    case EMA_VERDICT_UNDECIDED:
    default:
        break;
    }
    return name;
}

static const char* ema_outcome_name(ema_outcome_t outcome)
{
    const char* name = "active";
    switch (outcome) {
    case EMA_OUTCOME_TOLERANCE:
        name = "tolerance";
        break;
    case EMA_OUTCOME_BUDGET:
        name = "budget";
        break;
    case EMA_OUTCOME_COUNT:
        name = "count";
        break;
    case EMA_OUTCOME_ACTIVE:
    default:
        break;
    }
    return name;
}

static double ema_healthy(const ema_report_t* report, uint32_t fault)
{
    ema_real value = EMA_R(0.0);
    (void)ema_actuator_get(report->config->actuator, report->config->identified[fault].id, &value);
    return (double)value;
}

/* Standard error; NaN where the module leaves zero because the record does not determine the parameters. */
static double ema_std(const ema_result_t* result, uint32_t fault)
{
    const double std = (double)result->identified[fault].std;
    const bool none = ((result->reasons & (uint32_t)EMA_REASON_NOT_SENSITIVE) != 0U) && !(std > 0.0);
    return none ? (double)NAN : std;
}

/* Half of the 95 % interval; NaN where the record does not determine it. */
static double ema_half_interval(const ema_report_t* report, uint32_t fault)
{
    ema_real half_95 = EMA_R(0.0);
    const ema_status_t status = ema_session_half_95(report->config, &report->result, fault, &half_95);
    const bool known = (status == EMA_OK) && isfinite(ema_std(&report->result, fault));
    return known ? (double)half_95 : (double)NAN;
}

/* "CSJ +117.4 %, BLK +25.0 %" */
static void ema_write_shifts(const ema_report_t* report, FILE* out)
{
    for (uint32_t i = 0; i < FAULTS; ++i) {
        (void)fprintf(out, "%s%s %+.1f %%", (i == 0U) ? "" : ", ", ema_fault_name[i],
                      (double)report->result.identified[i].shift_percent);
    }
}

/* Whether a shift is beyond its threshold, or `surely` so: by more than its doubt and what a sound machine scatters, as
 * the session itself decides. */
static bool ema_beyond(const ema_report_t* report, uint32_t fault, bool surely)
{
    const ema_estimate_t* const found = &report->result.identified[fault];
    const ema_params_t* const params = &report->config->actuator->params;
    const double sure = (double)params->confidence_std;
    double limit = (double)report->config->identified[fault].min_shift_percent;
    if (surely) {
        const double unseen = ((double)params->unseen_percent / 100.0) * limit;
        const double per_value_percent = 100.0 / fabs(ema_healthy(report, fault));
        limit = fmax(limit, sure * (double)found->scatter_percent) + unseen
                + (((sure * (double)found->std) + (double)found->bias) * per_value_percent);
    }
    return (double)found->shift_percent > limit;
}

/* "CSJ beyond its threshold of +5 %": of both where both surely are, or neither is by itself. */
static void ema_write_faults(const ema_report_t* report, FILE* out)
{
    bool any = false;
    for (uint32_t i = 0; i < FAULTS; ++i) {
        any = any || ema_beyond(report, i, true);
    }
    const char* joint = "";
    for (uint32_t i = 0; i < FAULTS; ++i) {
        if (ema_beyond(report, i, any)) {
            (void)fprintf(out, "%s%s beyond its threshold of %+.3g %%", joint, ema_fault_name[i],
                          (double)report->config->identified[i].min_shift_percent);
            joint = " and ";
        }
    }
    for (uint32_t i = 0; i < FAULTS; ++i) {
        if (any && ema_beyond(report, i, false) && !ema_beyond(report, i, true)) {
            (void)fprintf(out, "; whether %s is one too is not sure", ema_fault_name[i]);
        }
    }
}

/* The sentence that would be read out if only one were. */
static void ema_write_sentence(const ema_report_t* report, FILE* out)
{
    const ema_result_t* const result = &report->result;
    if (result->verdict == EMA_VERDICT_UNDECIDED) {
        (void)fputs("Undecided, no fault is reported: the best fit is ", out);
        ema_write_shifts(report, out);
        (void)fputs(", but it cannot be relied on for the reasons below.\n", out);
    } else if (result->verdict == EMA_VERDICT_FAULT) {
        ema_write_shifts(report, out);
        (void)fputs(": fault, ", out);
        ema_write_faults(report, out);
        (void)fputs(".\n", out);
    } else {
        ema_write_shifts(report, out);
        (void)fprintf(out, ": healthy, both within their thresholds of %.3g %% and %.3g %%.\n",
                      (double)report->config->identified[0].min_shift_percent,
                      (double)report->config->identified[1].min_shift_percent);
    }
}

void ema_report_text(const ema_report_t* report, FILE* out)
{
    const ema_result_t* const result = &report->result;
    char path[256];
    ema_text_t shown = ema_text_start(path, sizeof path);
    ema_text_add_path(&shown, report->record);
    ema_write_sentence(report, out);
    (void)fputs("\n          estimate        95 % interval     healthy      shift\n", out);
    for (uint32_t i = 0; i < FAULTS; ++i) {
        const ema_estimate_t* const found = &result->identified[i];
        const double estimate = (double)found->estimate;
        const double half = ema_half_interval(report, i);
        char interval[48] = "-";
        if (isfinite(half)) {
            (void)snprintf(interval, sizeof interval, "%.4g .. %.4g", estimate - half, estimate + half);
        }
        (void)fprintf(out, "%s  %s  %10.6f  %19s  %10.6g  %+8.2f %%\n", ema_fault_name[i], ema_fault_unit[i], estimate,
                      interval, ema_healthy(report, i), (double)found->shift_percent);
    }
    const double before = (double)result->objective_before;
    const double after = (double)result->objective_after;
    (void)fprintf(out, "\nerror       %.3g mm2 s before, %.3g mm2 s after", before, after);
    if (before > 0.0) {
        (void)fprintf(out, " (%+.3f %%)", 100.0 * (after - before) / before);
    }
    (void)fprintf(out, "; residual %.3g um rms\n", 1000.0 * (double)result->residual_rms_mm);
    (void)fprintf(out,
                  "search      %" PRIu32 " model runs, %.2f million model steps, %s, ended by %s, seed %" PRIu64 "\n",
                  result->evaluations, (double)result->model_steps / 1.0e6,
                  (result->stage == EMA_STAGE_LEAST_SQUARES) ? "least squares" : "annealer",
                  ema_outcome_name(result->outcome), report->config->annealer.seed);
    (void)fprintf(out, "time        %.3f s, %.3f s of them in the search (the paper: 40 to 75 s per case)\n",
                  report->wall_s, report->search_s);
    (void)fprintf(out, "recording   %s: %" PRId64 " rows, one every %.6g s, kept as %s\n", path, report->rows,
                  report->period_s, report->int16 ? "16-bit integers" : "32-bit reals");
    (void)fprintf(out, "verdict     %s; the model %s\n", ema_verdict_name(result->verdict),
                  result->adequate ? "explains the recording" : "does not explain the recording");
    for (uint32_t bit = 1U; bit != 0U; bit <<= 1U) {
        if ((result->reasons & bit) != 0U) {
            (void)fprintf(out, "  because   %s\n", ema_reason_text(bit));
        }
    }
}

/* Fewest and most digits that a 32-bit real needs to be read back exactly. */
#define DIGITS_MIN 6
#define DIGITS_MAX 9

/* A number that the module holds, in the fewest digits that give it back; JSON knows no NaN and no infinity. */
static void ema_json_real(FILE* out, const char* before, double value)
{
    char text[40] = "null";
    bool exact = !isfinite(value);
    for (int digits = DIGITS_MIN; !exact && (digits <= DIGITS_MAX); ++digits) {
        (void)snprintf(text, sizeof text, "%.*g", digits, value);
        exact = strtof(text, NULL) == (float)value;
    }
    (void)fputs(before, out);
    (void)fputs(text, out);
}

static void ema_json_text(FILE* out, const char* text)
{
    const size_t length = strlen(text);
    size_t at = 0U;
    (void)fputc('"', out);
    while (at < length) {
        const size_t bytes = ema_text_utf8(text + at, length - at);
        const unsigned char first = (unsigned char)text[at];
        if (bytes == 0U) {
            (void)fputs("\\ufffd", out);
        } else if ((first == (unsigned char)'"') || (first == (unsigned char)'\\')) {
            (void)fprintf(out, "\\%c", text[at]);
        } else if (first < 0x20U) {
            (void)fprintf(out, "\\u%04x", (unsigned)first);
        } else {
            (void)fwrite(text + at, 1U, bytes, out);
        }
        at += (bytes == 0U) ? 1U : bytes;
    }
    (void)fputc('"', out);
}

void ema_report_json(const ema_report_t* report, FILE* out)
{
    const ema_result_t* const result = &report->result;
    (void)fputs("{\n  \"record\": ", out);
    ema_json_text(out, report->record);
    (void)fprintf(out, ",\n  \"rows\": %" PRId64, report->rows);
    ema_json_real(out, ",\n  \"period_s\": ", report->period_s);
    (void)fprintf(out, ",\n  \"record_format\": \"%s\"", report->int16 ? "int16" : "float32");
    for (uint32_t i = 0; i < FAULTS; ++i) {
        const ema_estimate_t* const found = &result->identified[i];
        (void)fprintf(out, ",\n  \"%s\": {", ema_fault_key[i]);
        ema_json_real(out, "\"estimate\": ", (double)found->estimate);
        ema_json_real(out, ", \"std\": ", ema_std(result, i));
        ema_json_real(out, ", \"bias\": ", (double)found->bias);
        const double half = ema_half_interval(report, i);
        ema_json_real(out, ", \"interval95\": [", (double)found->estimate - half);
        ema_json_real(out, ", ", (double)found->estimate + half);
        (void)fputc(']', out);
        ema_json_real(out, ", \"shift_percent\": ", (double)found->shift_percent);
        ema_json_real(out, ", \"healthy\": ", ema_healthy(report, i));
        ema_json_real(out, ", \"threshold_percent\": ", (double)report->config->identified[i].min_shift_percent);
        (void)fprintf(out, ", \"at_bound\": %s}", found->at_bound ? "true" : "false");
    }
    ema_json_real(out, ",\n  \"objective_before_mm2s\": ", (double)result->objective_before);
    ema_json_real(out, ",\n  \"objective_after_mm2s\": ", (double)result->objective_after);
    ema_json_real(out, ",\n  \"residual_rms_mm\": ", (double)result->residual_rms_mm);
    ema_json_real(out, ",\n  \"residual_correlation\": ", (double)result->residual_correlation);
    (void)fprintf(out, ",\n  \"evaluations\": %" PRIu32 ",\n  \"model_steps\": %" PRIu64, result->evaluations,
                  result->model_steps);
    (void)fprintf(out, ",\n  \"stage\": \"%s\",\n  \"outcome\": \"%s\",\n  \"seed\": %" PRIu64,
                  (result->stage == EMA_STAGE_LEAST_SQUARES) ? "least_squares" : "annealer",
                  ema_outcome_name(result->outcome), report->config->annealer.seed);
    ema_json_real(out, ",\n  \"search_s\": ", report->search_s);
    ema_json_real(out, ",\n  \"wall_s\": ", report->wall_s);
    (void)fprintf(out, ",\n  \"verdict\": \"%s\",\n  \"adequate\": %s,\n  \"reasons\": [",
                  ema_verdict_name(result->verdict), result->adequate ? "true" : "false");
    const char* joint = "";
    for (uint32_t bit = 1U; bit != 0U; bit <<= 1U) {
        if ((result->reasons & bit) != 0U) {
            (void)fputs(joint, out);
            ema_json_text(out, ema_reason_text(bit));
            joint = ", ";
        }
    }
    (void)fputs("]\n}\n", out);
}
