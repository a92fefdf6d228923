#include "ema_options.h"

#include <string.h>

#include "ema_csv_number.h"
#include "ema_csv_text.h"

/* Model steps between two returns of the search, unless the user says otherwise. */
#define SLICE_STEPS 200U
#define SLICE_STEPS_MAX 1000000000U
#define FULL_SCALE_MAX_MM 100000.0
#define SEED_MAX 9007199254740991U /* every reader of JSON holds it exactly */

const char* const ema_usage_text =
    "usage: ema_identify [--reference | --config FILE] [--json FILE [--force]] [--slice N] [--seed N] [--int16 "
    "[--full-scale MM]] RECORD.csv\n"
    "\n"
    "Feeds a recording to the onboard module row by row and prints what the module finds: CSJ (dry friction) and BLK "
    "(backlash).\n"
    "\n"
    "  --reference    the healthy actuator is the reference actuator (the default)\n"
    "  --config FILE  the healthy actuator: lines `section.field = value`, as `ema export --flat` writes them\n"
    "  --json FILE    also write the result to FILE, which must not exist\n"
    "  --force        replace FILE when it exists\n"
    "  --slice N      plain steps of work per slice (200); changes no result\n"
    "  --seed N       seed of the search (the actuator's)\n"
    "  --int16        keep the record as scaled 16-bit integers, as a small target does\n"
    "  --full-scale MM  of those integers, for command and rod position, as the target's firmware states it; a\n"
    "                 twentieth beyond the actuator's travel when absent\n"
    "  --help         this text\n"
    "\n"
    "Exit code: 0 done, 1 bad input, 2 wrong usage.\n";

static bool ema_refuse(char* message, size_t size, const char* argument, const char* text)
{
    ema_text_t why = ema_text_start(message, size);
    ema_text_add(&why, "ema_identify: ");
    if (argument != NULL) {
        ema_text_add_path(&why, argument);
        ema_text_add(&why, ": ");
    }
    ema_text_add(&why, text);
    return false;
}

/* A whole number in decimal digits alone, at most `largest`. */
static bool ema_whole(const char* text, uint64_t largest, uint64_t* value)
{
    uint64_t number = 0U;
    if (*text == '\0') {
        return false;
    }
    for (; *text != '\0'; ++text) {
        if ((*text < '0') || (*text > '9')) {
            return false;
        }
        const uint64_t digit = (uint64_t)(*text - '0');
        if (number > ((largest - digit) / 10U)) {
            return false;
        }
        number = (number * 10U) + digit;
    }
    *value = number;
    return true;
}

/* An option that stands alone; false when `argument` is none. */
static bool ema_take_flag(ema_options_cli_t* options, const char* argument, bool* reference)
{
    bool known = true;
    if (strcmp(argument, "--int16") == 0) {
        options->int16 = true;
    } else if (strcmp(argument, "--force") == 0) {
        options->force = true;
    } else if (strcmp(argument, "--reference") == 0) {
        *reference = true;
    } else if ((strcmp(argument, "--help") == 0) || (strcmp(argument, "-h") == 0)) {
        options->help = true;
    } else {
        known = false;
    }
    return known;
}

static bool ema_takes_value(const char* argument)
{
    return (strcmp(argument, "--json") == 0) || (strcmp(argument, "--config") == 0)
           || (strcmp(argument, "--slice") == 0) || (strcmp(argument, "--seed") == 0)
           || (strcmp(argument, "--full-scale") == 0);
}

/* Stores the value of an option; NULL, or what the value should have been. */
static const char* ema_take_value(ema_options_cli_t* options, const char* argument, const char* value)
{
    uint64_t number = 0U;
    const char* wanted = NULL;
    if (strcmp(argument, "--json") == 0) {
        options->json = value;
    } else if (strcmp(argument, "--config") == 0) {
        options->config = value;
    } else if (strcmp(argument, "--slice") == 0) {
        if (ema_whole(value, SLICE_STEPS_MAX, &number) && (number > 0U)) {
            options->slice_steps = (uint32_t)number;
        } else {
            wanted = "--slice takes a whole number from 1 to 1000000000";
        }
    } else if (strcmp(argument, "--full-scale") == 0) {
        double full_scale_mm = 0.0;
        if ((ema_csv_number(value, value + strlen(value), &full_scale_mm) == EMA_NUMBER_OK) && (full_scale_mm > 0.0)
            && (full_scale_mm <= FULL_SCALE_MAX_MM)) {
            options->full_scale_mm = full_scale_mm;
        } else {
            wanted = "--full-scale takes a number of millimetres above 0, at most 100000";
        }
    } else if (ema_whole(value, SEED_MAX, &number)) {
        options->seed = number;
        options->seed_given = true;
    } else {
        wanted = "--seed takes a whole number from 0 to 9007199254740991";
    }
    return wanted;
}

bool ema_options_read(ema_options_cli_t* options, int argc, char* const argv[], char* message, size_t message_size)
{
    *options = (ema_options_cli_t){.slice_steps = SLICE_STEPS};
    bool reference = false;
    bool only_files = false;
    for (int i = 1; i < argc; ++i) {
        const char* const argument = argv[i];
        if (!only_files && (strcmp(argument, "--") == 0)) {
            only_files = true;
        } else if (!only_files && ema_takes_value(argument)) {
            ++i;
            if (i == argc) {
                return ema_refuse(message, message_size, argument,
                                  "a value is missing behind this option; see ema_identify --help");
            }
            const char* const wanted = ema_take_value(options, argument, argv[i]);
            if (wanted != NULL) {
                return ema_refuse(message, message_size, argv[i], wanted);
            }
        } else if (!only_files && ema_take_flag(options, argument, &reference)) {
            continue;
        } else if (!only_files && (argument[0] == '-') && (argument[1] != '\0')) {
            return ema_refuse(message, message_size, argument, "no such option; see ema_identify --help");
        } else if (options->record == NULL) {
            options->record = argument;
        } else {
            return ema_refuse(message, message_size, argument, "a second recording; give one at a time");
        }
    }
    if (options->help) {
        return true;
    }
    if (reference && (options->config != NULL)) {
        return ema_refuse(message, message_size, options->config,
                          "--config and --reference exclude each other; give one of them");
    }
    if ((options->full_scale_mm > 0.0) && !options->int16) {
        return ema_refuse(message, message_size, "--full-scale",
                          "the record is kept in 32-bit reals, which have no scale; give --int16 or leave it out");
    }
    if (options->force && (options->json == NULL)) {
        return ema_refuse(message, message_size, "--force",
                          "there is no --json FILE to replace; give one or leave --force out");
    }
    if (options->record == NULL) {
        return ema_refuse(message, message_size, NULL,
                          "no recording given; name a CSV file, or see ema_identify --help");
    }
    return true;
}
