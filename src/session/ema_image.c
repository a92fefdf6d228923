#include <string.h>

#include "base/ema_bytes.h"
#include "base/ema_copy.h"
#include "ema/ema_image.h"
#include "session/ema_image_layout.h"

/* What an image is read in place by: the structures of a build in float32 are the image's own. */
#if !EMA_REAL64
_Static_assert(sizeof(ema_actuator_t) == EMA_ACTUATOR_BYTES, "an actuator in an image is an ema_actuator_t");
_Static_assert(sizeof(ema_pattern_t) == EMA_PATTERN_BYTES, "a pattern in an image is an ema_pattern_t");
#endif

/* An image whose head, length, checksum and lists are right. */
typedef struct {
    const uint8_t* bytes;
    uint32_t end; /* of the parts, where the checksum stands */
    uint32_t count;
} ema_image_view_t;

/* A unit's parts, inside the image. */
typedef struct {
    const uint8_t* entry;
    const uint8_t* actuator;
    const uint8_t* table; /* NULL for none */
    uint32_t patterns;
    uint32_t rows;
    uint32_t counts; /* values of the table */
} ema_unit_view_t;

static ema_image_status_t ema_image_view(const uint8_t* bytes, size_t length, ema_image_view_t* view)
{
    if (bytes == NULL) {
        return EMA_IMAGE_NULL;
    }
    const uint32_t least = EMA_IMAGE_HEAD_BYTES + EMA_IMAGE_CRC_BYTES;
    if (length < least) {
        return EMA_IMAGE_SHORT;
    }
    if (ema_get_u32(bytes) != EMA_IMAGE_MARK) {
        return EMA_IMAGE_MAGIC;
    }
    if (ema_get_u32(&bytes[EMA_IMAGE_AT_ORDER]) != EMA_IMAGE_ORDER_MARK) {
        return EMA_IMAGE_ORDER;
    }
    if (ema_get_u32(&bytes[EMA_IMAGE_AT_VERSION]) != EMA_IMAGE_VERSION) {
        return EMA_IMAGE_UNKNOWN_VERSION;
    }
    const uint32_t total = ema_get_u32(&bytes[EMA_IMAGE_AT_LENGTH]);
    if ((total < least) || ((size_t)total > length)) {
        return EMA_IMAGE_LENGTH;
    }
    view->bytes = bytes;
    view->end = total - EMA_IMAGE_CRC_BYTES;
    view->count = ema_get_u32(&bytes[EMA_IMAGE_AT_COUNT]);
    if (ema_crc32(0U, bytes, view->end) != ema_get_u32(&bytes[view->end])) {
        return EMA_IMAGE_CHECKSUM;
    }
    if (ema_get_u32(&bytes[EMA_IMAGE_AT_SCHEMA]) != EMA_CONFIG_SCHEMA) {
        return EMA_IMAGE_SCHEMA;
    }
    const bool whole = (view->count >= 1U) && (view->count <= ((view->end - EMA_IMAGE_HEAD_BYTES) / EMA_ENTRY_BYTES));
    return whole ? EMA_IMAGE_OK : EMA_IMAGE_LAYOUT;
}

/* `size` bytes from `offset` on, where they lie behind the entries and before the checksum, on a boundary; NULL
 * otherwise. */
static const uint8_t* ema_image_part(const ema_image_view_t* view, uint32_t offset, uint32_t size)
{
    const uint32_t first = EMA_IMAGE_HEAD_BYTES + (view->count * EMA_ENTRY_BYTES);
    const bool inside = (offset >= first) && (size <= view->end) && (offset <= (view->end - size))
                        && ((offset % sizeof(uint32_t)) == 0U);
    return inside ? &view->bytes[offset] : NULL;
}

/* Whether the table of `size` bytes holds as many patterns, rows and values as it says. */
static bool ema_image_table(ema_unit_view_t* unit, uint32_t size)
{
    const uint8_t* const table = unit->table;
    const uint32_t channels = ema_get_u32(&table[EMA_TABLE_AT_CHANNELS]);
    const uint32_t bins = ema_get_u32(&table[EMA_TABLE_AT_CHANNELS - 4U]);
    unit->patterns = ema_get_u32(&table[EMA_TABLE_AT_PATTERNS]);
    unit->rows = ema_get_u32(&table[EMA_TABLE_AT_ROWS]);
    if ((channels > EMA_CHANNEL_COUNT) || (unit->patterns > EMA_SIGNATURE_ROWS_MAX)
        || (unit->rows > EMA_SIGNATURE_ROWS_MAX)) {
        return false;
    }
    const uint32_t bin = 1U + (channels * (1U + unit->rows));
    if (bins > (size / bin)) {
        return false;
    }
    unit->counts = bins * bin;
    const uint32_t before = EMA_TABLE_HEAD_BYTES + (unit->patterns * EMA_PATTERN_BYTES) + (unit->rows * 4U);
    bool sound = (before <= size) && ((2U * unit->counts) <= (size - before));
    for (uint32_t k = 0; sound && (k < unit->patterns); ++k) {
        /* read as a flag, where it lies */
        sound = table[EMA_TABLE_HEAD_BYTES + (k * EMA_PATTERN_BYTES) + 3U] <= 1U;
    }
    return sound;
}

static ema_image_status_t ema_image_unit(const ema_image_view_t* view, uint32_t place, ema_unit_view_t* unit)
{
    const uint8_t* const entry = &view->bytes[EMA_IMAGE_HEAD_BYTES + (place * EMA_ENTRY_BYTES)];
    const uint32_t offset = ema_get_u32(&entry[EMA_ENTRY_AT_TABLE]);
    const uint32_t size = ema_get_u32(&entry[EMA_ENTRY_AT_TABLE_BYTES]);
    ema_clear(unit, sizeof *unit);
    unit->entry = entry;
    unit->actuator = ema_image_part(view, ema_get_u32(&entry[EMA_ENTRY_AT_ACTUATOR]), EMA_ACTUATOR_BYTES);
    bool sound = (unit->actuator != NULL) && (entry[0] != 0U) && (entry[EMA_UNIT_NAME_BYTES - 1U] == 0U);
    if (sound && (offset != 0U)) {
        unit->table = (size >= EMA_TABLE_HEAD_BYTES) ? ema_image_part(view, offset, size) : NULL;
        sound = (unit->table != NULL) && ema_image_table(unit, size);
    }
    return sound ? EMA_IMAGE_OK : EMA_IMAGE_LAYOUT;
}

/* The image and one of its units. */
static ema_image_status_t ema_image_at(const uint8_t* bytes, size_t length, uint32_t place, ema_unit_view_t* unit)
{
    ema_image_view_t view;
    ema_image_status_t status = ema_image_view(bytes, length, &view);
    if ((status == EMA_IMAGE_OK) && (place >= view.count)) {
        status = EMA_IMAGE_NO_UNIT;
    }
    return (status == EMA_IMAGE_OK) ? ema_image_unit(&view, place, unit) : status;
}

ema_image_status_t ema_image_check(const uint8_t* bytes, size_t length)
{
    ema_image_view_t view;
    ema_unit_view_t unit;
    ema_image_status_t status = ema_image_view(bytes, length, &view);
    for (uint32_t place = 0; (status == EMA_IMAGE_OK) && (place < view.count); ++place) {
        status = ema_image_unit(&view, place, &unit);
    }
    return status;
}

uint32_t ema_image_count(const uint8_t* bytes, size_t length)
{
    ema_image_view_t view;
    return (ema_image_view(bytes, length, &view) == EMA_IMAGE_OK) ? view.count : 0U;
}

/* Whether an entry, whose last byte is zero, has this name. */
static bool ema_entry_is(const uint8_t* entry, const char* name)
{
    uint32_t k = 0U;
    while ((k < (EMA_UNIT_NAME_BYTES - 1U)) && (entry[k] != 0U) && (entry[k] == (uint8_t)name[k])) {
        ++k;
    }
    return entry[k] == (uint8_t)name[k];
}

ema_image_status_t ema_image_find(const uint8_t* bytes, size_t length, const char* name, uint32_t* place)
{
    if ((name == NULL) || (place == NULL)) {
        return EMA_IMAGE_NULL;
    }
    ema_image_view_t view;
    ema_unit_view_t unit;
    ema_image_status_t status = ema_image_view(bytes, length, &view);
    bool found = false;
    for (uint32_t k = 0; (status == EMA_IMAGE_OK) && !found && (k < view.count); ++k) {
        status = ema_image_unit(&view, k, &unit);
        found = (status == EMA_IMAGE_OK) && ema_entry_is(unit.entry, name);
        if (found) {
            *place = k;
        }
    }
    return ((status == EMA_IMAGE_OK) && !found) ? EMA_IMAGE_NO_UNIT : status;
}

bool ema_image_native(const uint8_t* mark)
{
    uint32_t word = 0U;
    (void)memcpy(&word, mark, sizeof word); /* EMA-D3 */
    return word == EMA_IMAGE_ORDER_MARK;
}

static bool ema_image_in_place(const uint8_t* bytes)
{
    const bool native = ema_image_native(&bytes[EMA_IMAGE_AT_ORDER]);
    return native && (((uintptr_t)bytes % sizeof(uint32_t)) == 0U) && (sizeof(ema_real) == sizeof(float));
}

static ema_image_status_t ema_image_values(const ema_actuator_t* actuator)
{
    const ema_status_t checked = ema_actuator_check(actuator, NULL);
    if (checked == EMA_ERR_ABSENT) {
        return EMA_IMAGE_ABSENT;
    }
    return (checked == EMA_OK) ? EMA_IMAGE_OK : EMA_IMAGE_RANGE;
}

/* The members of a table but its arrays. */
static void ema_image_numbers(const uint8_t* table, ema_signatures_t* to)
{
    uint32_t* const count[] = {&to->version,  &to->fingerprint, &to->record_rows,
                               &to->bin_rows, &to->bins,        &to->channels};
    for (size_t k = 0; k < (sizeof count / sizeof count[0]); ++k) {
        *count[k] = ema_get_u32(&table[4U * k]);
    }
    uint32_t* const more[] = {&to->patterns, &to->faults, &to->nuisances, &to->rows};
    for (size_t k = 0; k < (sizeof more / sizeof more[0]); ++k) {
        *more[k] = ema_get_u32(&table[EMA_TABLE_AT_PATTERNS + (4U * k)]);
    }
    to->command_unit_mm = ema_get_real(&table[EMA_TABLE_AT_ROWS + 4U]);
    to->command_apart_mm = ema_get_real(&table[EMA_TABLE_AT_ROWS + 8U]);
    for (uint32_t k = 0; k < EMA_CHANNEL_COUNT; ++k) {
        to->channel[k] = table[EMA_TABLE_AT_CHANNEL + k];
        to->reference[k] = ema_get_real(&table[EMA_TABLE_AT_REFERENCE + (4U * k)]);
        to->weight[k] = ema_get_real(&table[EMA_TABLE_AT_WEIGHT + (4U * k)]);
    }
    to->limit = ema_get_real(&table[EMA_TABLE_AT_FAULT - 8U]);
    to->energy = ema_get_real(&table[EMA_TABLE_AT_FAULT - 4U]);
    for (uint32_t k = 0; k < EMA_SIGNATURE_FAULTS_MAX; ++k) {
        const uint8_t* const from = &table[EMA_TABLE_AT_FAULT + (k * EMA_FAULT_BYTES)];
        ema_signature_fault_t* const fault = &to->fault[k];
        fault->id = (ema_value_id_t)ema_get_u16(from);
        fault->row = from[2];
        fault->healthy = ema_get_real(&from[4]);
        fault->turn = ema_get_real(&from[8]);
        fault->length = ema_get_real(&from[12]);
    }
}

/* Everything but the actuator and the table's arrays. */
static void ema_image_fill(const ema_unit_view_t* from, const ema_actuator_t* actuator, ema_unit_t* unit)
{
    ema_clear(unit, sizeof *unit);
    (void)memcpy(unit->name, from->entry, EMA_UNIT_NAME_BYTES);
    unit->identity = ema_get_u32(&from->entry[EMA_ENTRY_AT_IDENTITY]);
    unit->actuator = actuator;
    unit->has_signatures = from->table != NULL;
    if (unit->has_signatures) {
        ema_image_numbers(from->table, &unit->signatures);
    }
}

ema_image_status_t ema_image_open(const uint8_t* bytes, size_t length, uint32_t place, ema_unit_t* unit)
{
    if (unit == NULL) {
        return EMA_IMAGE_NULL;
    }
    ema_unit_view_t from;
    ema_image_status_t status = ema_image_at(bytes, length, place, &from);
    if (status != EMA_IMAGE_OK) {
        return status;
    }
    if (!ema_image_in_place(bytes)) {
        return EMA_IMAGE_PLACE;
    }
    const ema_actuator_t* const actuator = (const ema_actuator_t*)(const void*)from.actuator; /* EMA-D5 */
    status = ema_image_values(actuator);
    if (status == EMA_IMAGE_OK) {
        ema_image_fill(&from, actuator, unit);
    }
    if ((status == EMA_IMAGE_OK) && unit->has_signatures) {
        const uint8_t* const pattern = &from.table[EMA_TABLE_HEAD_BYTES];
        const uint8_t* const row = &pattern[(size_t)from.patterns * EMA_PATTERN_BYTES];
        unit->signatures.pattern = (const ema_pattern_t*)(const void*)pattern;                 /* EMA-D5 */
        unit->signatures.unit = (const ema_real*)(const void*)row;                             /* EMA-D5 */
        unit->signatures.value = (const int16_t*)(const void*)&row[from.rows * sizeof(float)]; /* EMA-D5 */
    }
    return status;
}

static size_t ema_table_bytes(const ema_unit_view_t* unit)
{
    return (unit->patterns * sizeof(ema_pattern_t)) + (unit->rows * sizeof(ema_real))
           + (unit->counts * sizeof(int16_t));
}

size_t ema_image_table_bytes(const uint8_t* bytes, size_t length, uint32_t place)
{
    ema_unit_view_t unit;
    return (ema_image_at(bytes, length, place, &unit) == EMA_IMAGE_OK) ? ema_table_bytes(&unit) : 0U;
}

static void ema_image_reals(const uint8_t* from, ema_real* to, size_t count)
{
    for (size_t k = 0; k < count; ++k) {
        to[k] = ema_get_real(&from[4U * k]);
    }
}

static void ema_image_actuator(const uint8_t* from, ema_actuator_t* to)
{
    const uint8_t* const option = &from[4U * EMA_PARAM_COUNT];
    ema_image_reals(from, (ema_real*)(void*)&to->params, EMA_PARAM_COUNT); /* EMA-D4 */
    int32_t* const number = (int32_t*)(void*)&to->options;                 /* EMA-D4 */
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        number[k] = (int32_t)ema_get_u32(&option[4U * k]);
    }
    ema_image_reals(&option[4U * EMA_OPTION_COUNT], (ema_real*)(void*)&to->effects,
                    EMA_EFFECT_VALUE_COUNT); /* EMA-D4 */
}

static void ema_image_arrays(const ema_unit_view_t* from, ema_real* memory, ema_signatures_t* to)
{
    ema_pattern_t* const pattern = (ema_pattern_t*)(void*)memory;      /* EMA-D5 */
    ema_real* const unit = (ema_real*)(void*)&pattern[from->patterns]; /* EMA-D5 */
    int16_t* const value = (int16_t*)(void*)&unit[from->rows];         /* EMA-D5 */
    const uint8_t* at = &from->table[EMA_TABLE_HEAD_BYTES];
    for (uint32_t k = 0; k < from->patterns; ++k) {
        pattern[k].effect = at[0];
        pattern[k].first = at[1];
        pattern[k].rows = at[2];
        pattern[k].one_sided = at[3] != 0U;
        ema_image_reals(&at[4], pattern[k].turn, sizeof pattern[k].turn / sizeof pattern[k].turn[0]);
        pattern[k].penalty = ema_get_real(&at[16]);
        at = &at[EMA_PATTERN_BYTES];
    }
    ema_image_reals(at, unit, from->rows);
    at = &at[from->rows * sizeof(uint32_t)];
    for (size_t k = 0; k < from->counts; ++k) {
        value[k] = (int16_t)ema_get_u16(&at[2U * k]);
    }
    to->pattern = pattern;
    to->unit = unit;
    to->value = value;
}

ema_image_status_t ema_image_copy(const uint8_t* bytes, size_t length, uint32_t place, const ema_unit_memory_t* memory,
                                  ema_unit_t* unit)
{
    if ((memory == NULL) || (memory->actuator == NULL) || (unit == NULL)) {
        return EMA_IMAGE_NULL;
    }
    ema_actuator_t* const actuator = memory->actuator;
    ema_real* const table = memory->table;
    ema_unit_view_t from;
    ema_image_status_t status = ema_image_at(bytes, length, place, &from);
    if ((status == EMA_IMAGE_OK) && (from.table != NULL)
        && ((table == NULL) || (memory->table_bytes < ema_table_bytes(&from)))) {
        status = EMA_IMAGE_ROOM;
    }
    if (status == EMA_IMAGE_OK) {
        ema_image_actuator(from.actuator, actuator);
        status = ema_image_values(actuator);
    }
    if (status == EMA_IMAGE_OK) {
        ema_image_fill(&from, actuator, unit);
    }
    if ((status == EMA_IMAGE_OK) && unit->has_signatures) {
        ema_image_arrays(&from, table, &unit->signatures);
    }
    return status;
}

const char* ema_image_text(ema_image_status_t status)
{
    const char* text;
    switch (status) {
#define EMA_IMAGE_CASE(name, value, message)                                                                           \
    case (name):                                                                                                       \
        text = (message);                                                                                              \
        break;
        EMA_IMAGE_STATUS_LIST(EMA_IMAGE_CASE)
#undef EMA_IMAGE_CASE
    default:
        text = "unknown status";
        break;
    }
    return text;
}
