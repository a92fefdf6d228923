#include "ema_config.h"

#include <string.h>

#include "ema_csv_number.h"
#include "ema_csv_text.h"

#define LINE_MAX_BYTES 1024
#define NAME_MAX_BYTES 128
#define FIELD_SHOWN 48U
#define RANGE_DIGITS 6

#define ROW_COUNT (EMA_VALUE_COUNT + EMA_OPTION_COUNT)

/* A row of the lists; ids count as in ema_actuator_range. */
typedef struct {
    const char* section; /* NULL: an effect's value */
    const char* field;
    const char* choices; /* "a|b", or empty */
} ema_config_row_t;

static const ema_config_row_t ema_rows[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {#section, #field, ""},
#include "ema/ema_params.def"
#define EMA_P(field, nominal, lower, upper, text) {NULL, #field, ""},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
#include "ema/ema_effects.def"
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) {#section, #field, choices},
#include "ema/ema_params.def"
};

_Static_assert((sizeof ema_rows / sizeof ema_rows[0]) == ROW_COUNT, "one name per value and option");

typedef struct {
    const char* name;
    size_t end; /* id behind its last value */
} ema_config_effect_t;

static const ema_config_effect_t ema_effect_ends[] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {#name, EMA_PARAM_COUNT + ((offsetof(ema_effects_t, name) + sizeof(ema_effect_##name##_t)) / sizeof(ema_real))},
#include "ema/ema_effects.def"
};

/* Where a message points. */
typedef struct {
    const char* path;
    int64_t row;
    char* message;
    size_t message_size;
} ema_place_t;

static ema_text_t ema_place_text(const ema_place_t* place)
{
    ema_text_t why = ema_text_start(place->message, place->message_size);
    ema_text_add_path(&why, place->path);
    ema_text_add(&why, ": ");
    if (place->row > 0) {
        ema_text_add(&why, "row ");
        ema_text_add_whole(&why, place->row);
        ema_text_add(&why, ", ");
    }
    return why;
}

/* "field: text" behind the place. */
static bool ema_fail(const ema_place_t* place, const char* field, const char* text)
{
    ema_text_t why = ema_place_text(place);
    ema_text_add_foreign(&why, field, strlen(field), FIELD_SHOWN);
    ema_text_add(&why, ": ");
    ema_text_add(&why, text);
    return false;
}

/* Name of row `id` as the file writes it. */
static void ema_config_name(size_t id, char* name, size_t size)
{
    ema_text_t text = ema_text_start(name, size);
    if (ema_rows[id].section == NULL) {
        size_t effect = 0U;
        while (id >= ema_effect_ends[effect].end) {
            ++effect;
        }
        ema_text_add(&text, "effects.");
        ema_text_add(&text, ema_effect_ends[effect].name);
    } else {
        ema_text_add(&text, ema_rows[id].section);
    }
    ema_text_add(&text, ".");
    ema_text_add(&text, ema_rows[id].field);
}

static size_t ema_config_find(const char* wanted)
{
    size_t id = 0U;
    bool found = false;
    while (!found && (id < ROW_COUNT)) {
        char name[NAME_MAX_BYTES];
        ema_config_name(id, name, sizeof name);
        found = strcmp(name, wanted) == 0;
        id += found ? 0U : 1U;
    }
    return id;
}

/* Place of `word` among "a|b", or -1. */
static int32_t ema_choice(const char* choices, const char* word)
{
    const size_t length = strlen(word);
    int32_t index = 0;
    while (*choices != '\0') {
        const char* const bar = strchr(choices, '|');
        const size_t here = (bar != NULL) ? (size_t)(bar - choices) : strlen(choices);
        if ((here == length) && (memcmp(choices, word, here) == 0)) {
            return index;
        }
        choices += here + ((bar != NULL) ? 1U : 0U);
        ++index;
    }
    return -1;
}

static bool ema_fail_range(const ema_place_t* place, const char* name, size_t id, const char* value)
{
    const ema_range_t* const range = ema_actuator_range(id);
    ema_text_t why = ema_place_text(place);
    ema_text_add(&why, name);
    ema_text_add(&why, ": \"");
    ema_text_add_foreign(&why, value, strlen(value), FIELD_SHOWN);
    if (ema_rows[id].choices[0] != '\0') {
        ema_text_add(&why, "\" is none of ");
        ema_text_add(&why, ema_rows[id].choices);
        ema_text_add(&why, "; write one of these words");
    } else {
        ema_text_add(&why, (id < EMA_VALUE_COUNT) ? "\" is no number from " : "\" is no whole number from ");
        ema_text_add_real(&why, (double)range->lower, RANGE_DIGITS);
        ema_text_add(&why, " to ");
        ema_text_add_real(&why, (double)range->upper, RANGE_DIGITS);
        ema_text_add(&why, "; correct it");
    }
    return false;
}

static bool ema_config_set(ema_actuator_t* actuator, const ema_place_t* place, size_t id, const char* value)
{
    const ema_range_t* const range = ema_actuator_range(id);
    char name[NAME_MAX_BYTES];
    double number = 0.0;
    ema_config_name(id, name, sizeof name);
    if (ema_rows[id].choices[0] != '\0') {
        number = (double)ema_choice(ema_rows[id].choices, value);
    } else if (ema_csv_number(value, value + strlen(value), &number) != EMA_NUMBER_OK) {
        return ema_fail_range(place, name, id, value);
    } else {
        /* the text is a number */
    }
    /* Compared as the module stores it, so that a bound written out is inside. */
    const bool inside = (number >= -1.0e30) && (number <= 1.0e30) && ((ema_real)number >= range->lower)
                        && ((ema_real)number <= range->upper);
    if (!inside || ((id >= EMA_VALUE_COUNT) && ((double)(int32_t)number != number))) {
        return ema_fail_range(place, name, id, value);
    }
    if (id < EMA_VALUE_COUNT) {
        (void)ema_actuator_set(actuator, (ema_value_id_t)id, (ema_real)number);
    } else {
        const int32_t option = (int32_t)number;
        (void)memcpy((char*)&actuator->options + ((id - EMA_VALUE_COUNT) * sizeof option), &option, sizeof option);
    }
    return true;
}

/* Takes blanks and a comment off a line, in place. */
static char* ema_config_trim(char* text)
{
    text[strcspn(text, "#")] = '\0';
    text += strspn(text, " \t\r\n");
    size_t length = strlen(text);
    while ((length > 0U) && (strchr(" \t\r\n", text[length - 1U]) != NULL)) {
        --length;
    }
    text[length] = '\0';
    return text;
}

static bool ema_config_line(ema_actuator_t* actuator, const ema_place_t* place, char* line, bool seen[ROW_COUNT])
{
    char* const text = ema_config_trim(line);
    if (*text == '\0') {
        return true;
    }
    char* const equals = strchr(text, '=');
    if (equals == NULL) {
        return ema_fail(place, text, "no `=` in the line; write `section.field = value`");
    }
    *equals = '\0';
    const char* const name = ema_config_trim(text);
    const char* const value = ema_config_trim(equals + 1);
    const size_t id = ema_config_find(name);
    if (id == ROW_COUNT) {
        return ema_fail(place, name,
                        "an actuator has no such value; take the names from a file that `ema export --flat` wrote");
    }
    if (seen[id]) {
        return ema_fail(place, name, "the value stands there twice; remove one of the lines");
    }
    seen[id] = true;
    return ema_config_set(actuator, place, id, value);
}

static bool ema_config_lines(ema_actuator_t* actuator, ema_place_t* place, FILE* file)
{
    static const char bom[] = "\xEF\xBB\xBF";
    bool seen[ROW_COUNT] = {false};
    char line[LINE_MAX_BYTES];
    bool good = true;
    while (good && (fgets(line, (int)sizeof line, file) != NULL)) {
        ++place->row;
        char* const start = ((place->row == 1) && (strncmp(line, bom, 3U) == 0)) ? (line + 3) : line;
        if ((strchr(line, '\n') == NULL) && (feof(file) == 0)) {
            return ema_fail(place, "line",
                            "longer than 1022 bytes, or not text; write one `section.field = value` per line");
        }
        good = ema_config_line(actuator, place, start, seen);
    }
    if (good && (ferror(file) != 0)) {
        place->row = 0;
        return ema_fail(place, "file", "cannot be read; name a text file, not a folder");
    }
    if (good && (place->row == 0)) {
        return ema_fail(place, "file", "empty; write it with `ema export --flat`");
    }
    return good;
}

bool ema_config_take(ema_actuator_t* actuator, FILE* file, const char* name, char* message, size_t message_size)
{
    ema_place_t place = {.path = name, .message = message, .message_size = message_size};
    (void)ema_actuator_defaults(actuator);
    return ema_config_lines(actuator, &place, file);
}

bool ema_config_read(ema_actuator_t* actuator, const char* path, char* message, size_t message_size)
{
    FILE* const file = fopen(path, "rb");
    if (file == NULL) {
        const ema_place_t place = {.path = path, .message = message, .message_size = message_size};
        return ema_fail(&place, "file", "cannot be opened; check the path");
    }
    const bool good = ema_config_take(actuator, file, path, message, message_size);
    (void)fclose(file);
    return good;
}
