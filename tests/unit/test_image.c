/* Images of configurations: what is written is read, in place or copied; what is stale, cut off or damaged is refused
 * with its reason, and nothing of it is used. */
#include "ema/ema.h"

#include "base/ema_bytes.h"
#include "ema_image_rig.h"
#include "ema_signature_rig.h"
#include "session/ema_image_layout.h"

#define IMAGE_BYTES 8192U
#define PLAIN "left aileron"
#define GUARDED "a unit with a name of 31 bytes!"

/* Where the table of the second unit stands, and members of it. */
#define BINS 16U
#define CHANNELS 20U
#define PATTERNS 28U
#define ROWS 40U
#define FIRST_PATTERN 124U

static union {
    uint32_t word;
    uint8_t bytes[IMAGE_BYTES];
} image, spare;
static uint32_t length;
static ema_actuator_t plain;
static ema_actuator_t guarded;
static ema_signature_rig_t rig;
static ema_unit_t unit;
static ema_unit_t before;
static ema_actuator_t memory_actuator;
static ema_real memory_table[2048];

#define ASSERT_STATUS(expected, actual)                                                                                \
    do {                                                                                                               \
        const ema_image_status_t status_ = (actual);                                                                   \
        TEST_ASSERT_EQUAL_STRING(ema_image_text(expected), ema_image_text(status_));                                   \
        TEST_ASSERT_EQUAL_INT((expected), status_);                                                                    \
    } while (0)

static void write_image(void)
{
    const ema_image_rig_unit_t units[] = {{PLAIN, &plain, NULL}, {GUARDED, &guarded, &rig.table}};
    length = ema_image_rig(image.bytes, units, 2U);
    TEST_ASSERT_TRUE(length <= IMAGE_BYTES);
}

void setUp(void)
{
    plain = ema_rig_actuator();
    guarded = ema_rig_actuator();
    guarded.params.csj_Nm = EMA_R(0.25);
    guarded.options.seed = 7;
    guarded.effects.stribeck_friction.rise = EMA_R(0.125);
    guarded.effects.grease_warming.time_s = EMA_R(7.5);
    ema_signature_rig(&rig, &guarded);
    write_image();
    (void)memset(&unit, 0xA5, sizeof unit);
    (void)memcpy(&before, &unit, sizeof unit);
}

void tearDown(void)
{
}

static ema_unit_memory_t memory_of(void)
{
    const ema_unit_memory_t memory = {&memory_actuator, memory_table, sizeof memory_table};
    return memory;
}

/* The number as an image holds it. */
static double single(ema_real value)
{
    return (double)(float)value;
}

static void assert_actuator(const ema_actuator_t* expected, const ema_actuator_t* found)
{
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        TEST_ASSERT_TRUE(single(ema_rig_value(expected, id)) == (double)ema_rig_value(found, id));
    }
    TEST_ASSERT_EQUAL_MEMORY(&expected->options, &found->options, sizeof expected->options);
    TEST_ASSERT_EQUAL_HEX32(ema_actuator_identity(expected), ema_actuator_identity(found));
}

static void assert_reals(const ema_real* expected, const ema_real* found, uint32_t count)
{
    for (uint32_t k = 0; k < count; ++k) {
        TEST_ASSERT_TRUE(single(expected[k]) == (double)found[k]);
    }
}

static void assert_table(const ema_signatures_t* found)
{
    const ema_signatures_t* const table = &rig.table;
    TEST_ASSERT_EQUAL_UINT32(table->version, found->version);
    TEST_ASSERT_EQUAL_HEX32(table->fingerprint, found->fingerprint);
    TEST_ASSERT_EQUAL_UINT32(table->record_rows, found->record_rows);
    TEST_ASSERT_EQUAL_UINT32(table->bin_rows, found->bin_rows);
    TEST_ASSERT_EQUAL_UINT32(table->bins, found->bins);
    TEST_ASSERT_EQUAL_UINT32(table->channels, found->channels);
    TEST_ASSERT_EQUAL_MEMORY(table->channel, found->channel, sizeof table->channel);
    TEST_ASSERT_EQUAL_UINT32(table->patterns, found->patterns);
    TEST_ASSERT_EQUAL_UINT32(table->faults, found->faults);
    TEST_ASSERT_EQUAL_UINT32(table->nuisances, found->nuisances);
    TEST_ASSERT_EQUAL_UINT32(table->rows, found->rows);
    assert_reals(&table->command_unit_mm, &found->command_unit_mm, 1U);
    assert_reals(&table->command_apart_mm, &found->command_apart_mm, 1U);
    assert_reals(table->reference, found->reference, EMA_CHANNEL_COUNT);
    assert_reals(table->weight, found->weight, EMA_CHANNEL_COUNT);
    assert_reals(&table->limit, &found->limit, 1U);
    assert_reals(&table->energy, &found->energy, 1U);
    for (uint32_t k = 0; k < EMA_SIGNATURE_FAULTS_MAX; ++k) {
        TEST_ASSERT_EQUAL_UINT16(table->fault[k].id, found->fault[k].id);
        TEST_ASSERT_EQUAL_UINT8(table->fault[k].row, found->fault[k].row);
        assert_reals(&table->fault[k].healthy, &found->fault[k].healthy, 1U);
        assert_reals(&table->fault[k].turn, &found->fault[k].turn, 1U);
        assert_reals(&table->fault[k].length, &found->fault[k].length, 1U);
    }
    for (uint32_t k = 0; k < table->patterns; ++k) {
        TEST_ASSERT_EQUAL_UINT8(table->pattern[k].effect, found->pattern[k].effect);
        TEST_ASSERT_EQUAL_UINT8(table->pattern[k].first, found->pattern[k].first);
        TEST_ASSERT_EQUAL_UINT8(table->pattern[k].rows, found->pattern[k].rows);
        TEST_ASSERT_EQUAL_INT(table->pattern[k].one_sided, found->pattern[k].one_sided);
        assert_reals(table->pattern[k].turn, found->pattern[k].turn, 3U);
        assert_reals(&table->pattern[k].penalty, &found->pattern[k].penalty, 1U);
    }
    assert_reals(table->unit, found->unit, table->rows);
    TEST_ASSERT_EQUAL_INT16_ARRAY(rig.value, found->value, sizeof rig.value / sizeof rig.value[0]);
}

/* Refused by whoever reads it, with one reason, and nothing changed. */
static void assert_refused(ema_image_status_t expected, const uint8_t* bytes, size_t size)
{
    const ema_unit_memory_t memory = memory_of();
    uint32_t place = 77U;
    ASSERT_STATUS(expected, ema_image_check(bytes, size));
    ASSERT_STATUS(expected, ema_image_find(bytes, size, GUARDED, &place));
    TEST_ASSERT_EQUAL_UINT32(77U, place);
    ASSERT_STATUS(expected, ema_image_open(bytes, size, 1U, &unit));
    ASSERT_STATUS(expected, ema_image_copy(bytes, size, 1U, &memory, &unit));
    TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
    TEST_ASSERT_EQUAL_UINT(0U, ema_image_table_bytes(bytes, size, 1U));
}

static void test_units_are_found_by_name_and_place(void)
{
    uint32_t place = 77U;
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_check(image.bytes, length));
    TEST_ASSERT_EQUAL_UINT32(2U, ema_image_count(image.bytes, length));
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_find(image.bytes, length, PLAIN, &place));
    TEST_ASSERT_EQUAL_UINT32(0U, place);
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_find(image.bytes, length, GUARDED, &place));
    TEST_ASSERT_EQUAL_UINT32(1U, place);
    static const char* const strangers[] = {"",
                                            "left",
                                            "left aileron ",
                                            "LEFT AILERON",
                                            "a unit with a name of 31 bytes",
                                            GUARDED "!",
                                            GUARDED " and more"};
    for (size_t k = 0; k < (sizeof strangers / sizeof strangers[0]); ++k) {
        ASSERT_STATUS(EMA_IMAGE_NO_UNIT, ema_image_find(image.bytes, length, strangers[k], &place));
        TEST_ASSERT_EQUAL_UINT32(1U, place);
    }
    ASSERT_STATUS(EMA_IMAGE_NO_UNIT, ema_image_open(image.bytes, length, 2U, &unit));
    const ema_unit_memory_t memory = memory_of();
    ASSERT_STATUS(EMA_IMAGE_NO_UNIT, ema_image_copy(image.bytes, length, UINT32_MAX, &memory, &unit));
    TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
    TEST_ASSERT_EQUAL_UINT(0U, ema_image_table_bytes(image.bytes, length, 2U));
}

#if EMA_REAL64
static void test_float64_reads_nothing_in_place(void)
{
    ASSERT_STATUS(EMA_IMAGE_PLACE, ema_image_open(image.bytes, length, 0U, &unit));
    TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
}
#else
static void test_units_are_read_where_they_lie(void)
{
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_open(image.bytes, length, 0U, &unit));
    TEST_ASSERT_EQUAL_STRING(PLAIN, unit.name);
    TEST_ASSERT_EQUAL_HEX32(ema_actuator_identity(&plain), unit.identity);
    TEST_ASSERT_EQUAL_PTR(&image.bytes[ema_image_rig_get(image.bytes, EMA_RIG_ENTRY(0U) + EMA_RIG_ENTRY_ACTUATOR)],
                          unit.actuator);
    TEST_ASSERT_EQUAL_MEMORY(&plain, unit.actuator, sizeof plain);
    TEST_ASSERT_FALSE(unit.has_signatures);
    TEST_ASSERT_NULL(unit.signatures.value);
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_open(image.bytes, length, 1U, &unit));
    TEST_ASSERT_EQUAL_STRING(GUARDED, unit.name);
    TEST_ASSERT_EQUAL_MEMORY(&guarded, unit.actuator, sizeof guarded);
    TEST_ASSERT_TRUE(unit.has_signatures);
    assert_table(&unit.signatures);
    TEST_ASSERT_TRUE(((const uint8_t*)unit.signatures.value > image.bytes)
                     && ((const uint8_t*)unit.signatures.value < &image.bytes[length]));
}

static void test_a_guarded_session_starts_from_an_image(void)
{
    static ema_guarded_t session;
    static ema_session_config_t config;
    static ema_real buffer[5U * EMA_TABLE_RECORD_ROWS];
    const ema_record_config_t record = ema_rig_real_record(buffer, sizeof buffer, true);
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_open(image.bytes, length, 1U, &unit));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, unit.actuator, &record));
    EMA_ASSERT_STATUS(EMA_OK, ema_guarded_init(&session, &config, &unit.signatures));
    /* the table of one unit is refused beside another */
    ema_unit_t other;
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_open(image.bytes, length, 0U, &other));
    EMA_ASSERT_STATUS(EMA_OK, ema_session_config_default(&config, other.actuator, &record));
    EMA_ASSERT_STATUS(EMA_ERR_TABLE, ema_guarded_init(&session, &config, &unit.signatures));
}

static void test_an_odd_address_is_for_copies(void)
{
    for (uint32_t off = 1U; off < 4U; ++off) {
        (void)memcpy(&spare.bytes[off], image.bytes, length);
        ASSERT_STATUS(EMA_IMAGE_OK, ema_image_check(&spare.bytes[off], length));
        ASSERT_STATUS(EMA_IMAGE_PLACE, ema_image_open(&spare.bytes[off], length, 1U, &unit));
        TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
    }
}
#endif

static void test_copies_are_what_was_written(void)
{
    const ema_unit_memory_t memory = memory_of();
    for (uint32_t off = 0U; off < 4U; ++off) {
        (void)memset(memory_table, 0x5A, sizeof memory_table);
        (void)memcpy(&spare.bytes[off], image.bytes, length);
        ASSERT_STATUS(EMA_IMAGE_OK, ema_image_copy(&spare.bytes[off], length, 1U, &memory, &unit));
        (void)memset(spare.bytes, 0x5A, sizeof spare.bytes); /* the image may go */
        TEST_ASSERT_EQUAL_STRING(GUARDED, unit.name);
        TEST_ASSERT_EQUAL_HEX32(ema_actuator_identity(&guarded), unit.identity);
        TEST_ASSERT_EQUAL_PTR(&memory_actuator, unit.actuator);
        assert_actuator(&guarded, unit.actuator);
        TEST_ASSERT_TRUE(unit.has_signatures);
        assert_table(&unit.signatures);
    }
    const ema_unit_memory_t no_table = {&memory_actuator, NULL, 0U};
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_copy(image.bytes, length, 0U, &no_table, &unit));
    TEST_ASSERT_EQUAL_STRING(PLAIN, unit.name);
    TEST_ASSERT_FALSE(unit.has_signatures);
    assert_actuator(&plain, unit.actuator);
}

static void test_room_for_the_table_is_asked_for(void)
{
    const size_t needed = ema_image_table_bytes(image.bytes, length, 1U);
    TEST_ASSERT_EQUAL_UINT(sizeof rig.pattern + sizeof rig.unit + sizeof rig.value, needed);
    TEST_ASSERT_EQUAL_UINT(0U, ema_image_table_bytes(image.bytes, length, 0U));
    ema_unit_memory_t memory = memory_of();
    memory.table_bytes = needed;
    memory_table[(needed / sizeof memory_table[0]) + 1U] = EMA_R(-3.0);
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_copy(image.bytes, length, 1U, &memory, &unit));
    TEST_ASSERT_TRUE(memory_table[(needed / sizeof memory_table[0]) + 1U] == EMA_R(-3.0));
    (void)memcpy(&unit, &before, sizeof unit);
    memory.table_bytes = needed - 1U;
    ASSERT_STATUS(EMA_IMAGE_ROOM, ema_image_copy(image.bytes, length, 1U, &memory, &unit));
    memory.table_bytes = needed;
    memory.table = NULL;
    ASSERT_STATUS(EMA_IMAGE_ROOM, ema_image_copy(image.bytes, length, 1U, &memory, &unit));
    TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
}

static void test_nothing_is_no_image(void)
{
    ema_unit_memory_t memory = memory_of();
    uint32_t place = 0U;
    assert_refused(EMA_IMAGE_NULL, NULL, length);
    TEST_ASSERT_EQUAL_UINT32(0U, ema_image_count(NULL, length));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_find(image.bytes, length, NULL, &place));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_find(image.bytes, length, PLAIN, NULL));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_open(image.bytes, length, 0U, NULL));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_copy(image.bytes, length, 0U, NULL, &unit));
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_copy(image.bytes, length, 0U, &memory, NULL));
    memory.actuator = NULL;
    ASSERT_STATUS(EMA_IMAGE_NULL, ema_image_copy(image.bytes, length, 0U, &memory, &unit));
    TEST_ASSERT_EQUAL_HEX32(0U, ema_actuator_identity(NULL));
}

static void test_every_length_but_the_whole_is_refused(void)
{
    for (uint32_t size = 0; size < length; ++size) {
        assert_refused((size < 28U) ? EMA_IMAGE_SHORT : EMA_IMAGE_LENGTH, image.bytes, size);
    }
    /* a place in flash may be larger */
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_check(image.bytes, IMAGE_BYTES));
}

/* What the bit's place makes of it. */
static ema_image_status_t reason_of(uint32_t byte, ema_image_status_t found)
{
    static const ema_image_status_t head[] = {EMA_IMAGE_MAGIC, EMA_IMAGE_ORDER, EMA_IMAGE_UNKNOWN_VERSION};
    if (byte < EMA_RIG_LENGTH) {
        return head[byte / 4U];
    }
    /* shorter than it is, its checksum is elsewhere */
    return ((byte < EMA_RIG_SCHEMA) && (found == EMA_IMAGE_LENGTH)) ? EMA_IMAGE_LENGTH : EMA_IMAGE_CHECKSUM;
}

static void test_every_bit_that_is_another_is_refused(void)
{
    for (uint32_t bit = 0; bit < (8U * length); ++bit) {
        image.bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
        const ema_image_status_t found = ema_image_check(image.bytes, length);
        ASSERT_STATUS(reason_of(bit / 8U, found), found);
        image.bytes[bit / 8U] ^= (uint8_t)(1U << (bit % 8U));
    }
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_check(image.bytes, length));
}

static void test_flash_without_an_image_is_refused(void)
{
    for (uint32_t fill = 0; fill < 256U; fill += 85U) {
        (void)memset(image.bytes, (int)fill, sizeof image.bytes);
        assert_refused(EMA_IMAGE_MAGIC, image.bytes, sizeof image.bytes);
    }
}

/* A number of the head that is another, under a checksum that is right. */
static void put_sealed(uint32_t place, uint32_t value)
{
    write_image();
    ema_image_rig_put(image.bytes, place, value);
    ema_image_rig_seal(image.bytes);
}

static void test_stale_images_are_refused(void)
{
    put_sealed(EMA_RIG_VERSION, EMA_IMAGE_VERSION - 1U);
    assert_refused(EMA_IMAGE_UNKNOWN_VERSION, image.bytes, length);
    put_sealed(EMA_RIG_VERSION, EMA_IMAGE_VERSION + 1U);
    assert_refused(EMA_IMAGE_UNKNOWN_VERSION, image.bytes, length);
    put_sealed(EMA_RIG_SCHEMA, EMA_CONFIG_SCHEMA ^ 1U);
    assert_refused(EMA_IMAGE_SCHEMA, image.bytes, length);
    put_sealed(4U, 0x04030201U);
    assert_refused(EMA_IMAGE_ORDER, image.bytes, length);
    put_sealed(EMA_RIG_COUNT, 0U);
    ASSERT_STATUS(EMA_IMAGE_LAYOUT, ema_image_check(image.bytes, length));
    TEST_ASSERT_EQUAL_UINT32(0U, ema_image_count(image.bytes, length));
}

static void test_lengths_that_are_none_are_refused(void)
{
    static const uint32_t lengths[] = {0U, 1U, 27U, IMAGE_BYTES + 1U, UINT32_MAX};
    for (size_t k = 0; k < (sizeof lengths / sizeof lengths[0]); ++k) {
        write_image();
        ema_image_rig_put(image.bytes, EMA_RIG_LENGTH, lengths[k]);
        assert_refused(EMA_IMAGE_LENGTH, image.bytes, IMAGE_BYTES);
    }
    /* the least that has a head: no unit fits in it */
    write_image();
    ema_image_rig_put(image.bytes, EMA_RIG_LENGTH, 28U);
    ema_image_rig_seal(image.bytes);
    assert_refused(EMA_IMAGE_LAYOUT, image.bytes, IMAGE_BYTES);
}

static void test_parts_outside_the_image_are_refused(void)
{
    const uint32_t entry = EMA_RIG_ENTRY(1U);
    const uint32_t actuator = ema_image_rig_get(image.bytes, entry + EMA_RIG_ENTRY_ACTUATOR);
    const uint32_t table = ema_image_rig_get(image.bytes, entry + EMA_RIG_ENTRY_TABLE);
    const uint32_t size = ema_image_rig_get(image.bytes, entry + EMA_RIG_ENTRY_TABLE_BYTES);
    const struct {
        uint32_t place;
        uint32_t value;
    } wrong[] = {
        {EMA_RIG_COUNT, UINT32_MAX},
        {EMA_RIG_COUNT, 1U + ((length - 28U) / 48U)},
        {entry + EMA_RIG_ENTRY_ACTUATOR, 0U},
        {entry + EMA_RIG_ENTRY_ACTUATOR, EMA_RIG_ENTRY(2U) - 4U},
        {entry + EMA_RIG_ENTRY_ACTUATOR, actuator + 1U},
        {entry + EMA_RIG_ENTRY_ACTUATOR, actuator + 2U},
        {entry + EMA_RIG_ENTRY_ACTUATOR, length - 4U},
        {entry + EMA_RIG_ENTRY_ACTUATOR, UINT32_MAX - 3U},
        {entry + EMA_RIG_ENTRY_TABLE, table + 4U},
        {entry + EMA_RIG_ENTRY_TABLE, table + 2U},
        {entry + EMA_RIG_ENTRY_TABLE, 4U},
        {entry + EMA_RIG_ENTRY_TABLE, UINT32_MAX - 3U},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, 0U},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, FIRST_PATTERN - 4U},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, FIRST_PATTERN},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, size - 4U},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, size + 4U},
        {entry + EMA_RIG_ENTRY_TABLE_BYTES, UINT32_MAX},
        {table + BINS, rig.table.bins + 1U},
        {table + BINS, UINT32_MAX},
        {table + CHANNELS, EMA_CHANNEL_COUNT + 1U},
        {table + CHANNELS, UINT32_MAX},
        {table + PATTERNS, EMA_SIGNATURE_ROWS_MAX + 1U},
        {table + PATTERNS, EMA_SIGNATURE_ROWS_MAX},
        {table + PATTERNS, UINT32_MAX},
        {table + ROWS, EMA_SIGNATURE_ROWS_MAX + 1U},
        {table + ROWS, UINT32_MAX},
        {table + FIRST_PATTERN, 0x02010000U},
        {entry, 0U},
        {entry + EMA_UNIT_NAME_BYTES - 4U, 0x41414141U},
    };
    for (size_t k = 0; k < (sizeof wrong / sizeof wrong[0]); ++k) {
        put_sealed(wrong[k].place, wrong[k].value);
        assert_refused(EMA_IMAGE_LAYOUT, image.bytes, length);
    }
}

static void test_values_outside_their_range_are_refused(void)
{
    const ema_unit_memory_t memory = memory_of();
    guarded.params.resistance_ohm = EMA_R(-1.0);
    write_image();
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_check(image.bytes, length));
#if !EMA_REAL64
    ASSERT_STATUS(EMA_IMAGE_OK, ema_image_open(image.bytes, length, 0U, &unit));
    (void)memcpy(&unit, &before, sizeof unit);
    ASSERT_STATUS(EMA_IMAGE_RANGE, ema_image_open(image.bytes, length, 1U, &unit));
#endif
    ASSERT_STATUS(EMA_IMAGE_RANGE, ema_image_copy(image.bytes, length, 1U, &memory, &unit));
    guarded.params.resistance_ohm = EMA_R(1.0);
    guarded.options.seed = -1;
    write_image();
    ASSERT_STATUS(EMA_IMAGE_RANGE, ema_image_copy(image.bytes, length, 1U, &memory, &unit));
    TEST_ASSERT_EQUAL_MEMORY(&before, &unit, sizeof unit);
}

static void test_another_order_of_bytes_is_seen(void)
{
    static const union {
        uint32_t word;
        uint8_t bytes[4];
    } native = {0x01020304U}, other = {0x04030201U};
    TEST_ASSERT_TRUE(ema_image_native(native.bytes));
    TEST_ASSERT_FALSE(ema_image_native(other.bytes));
}

static void test_identity_tells_every_value(void)
{
    ema_actuator_t changed = plain;
    const uint32_t first = ema_actuator_identity(&plain);
    for (ema_value_id_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        const ema_real value = ema_rig_value(&plain, id);
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&changed, id, value + EMA_R(1.0)));
        TEST_ASSERT_NOT_EQUAL_HEX32(first, ema_actuator_identity(&changed));
        EMA_ASSERT_STATUS(EMA_OK, ema_actuator_set(&changed, id, value));
    }
    ++changed.options.seed;
    TEST_ASSERT_NOT_EQUAL_HEX32(first, ema_actuator_identity(&changed));
    --changed.options.seed;
    TEST_ASSERT_EQUAL_HEX32(first, ema_actuator_identity(&changed));
}

static void test_checksum_is_the_known_one(void)
{
    static const uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, ema_crc32(0U, digits, sizeof digits));
    TEST_ASSERT_EQUAL_HEX32(0xCBF43926U, ema_crc32(ema_crc32(0U, digits, 4U), &digits[4], sizeof digits - 4U));
    TEST_ASSERT_EQUAL_HEX32(ema_image_rig_crc(image.bytes, length), ema_crc32(0U, image.bytes, length));
    TEST_ASSERT_EQUAL_HEX32(0U, ema_crc32(0U, digits, 0U));
}

static void test_every_status_has_its_text(void)
{
    static const char* const texts[] = {
#define ROW(name, value, text) [value] = (text),
        EMA_IMAGE_STATUS_LIST(ROW)
#undef ROW
    };
    const int count = (int)(sizeof texts / sizeof texts[0]);
    for (int k = 0; k < count; ++k) {
        TEST_ASSERT_EQUAL_STRING(texts[k], ema_image_text((ema_image_status_t)k));
        TEST_ASSERT_TRUE(strlen(texts[k]) > 1U);
    }
    TEST_ASSERT_EQUAL_STRING("unknown status", ema_image_text((ema_image_status_t)count));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_units_are_found_by_name_and_place);
#if EMA_REAL64
    RUN_TEST(test_float64_reads_nothing_in_place);
#else
    RUN_TEST(test_units_are_read_where_they_lie);
    RUN_TEST(test_a_guarded_session_starts_from_an_image);
    RUN_TEST(test_an_odd_address_is_for_copies);
#endif
    RUN_TEST(test_copies_are_what_was_written);
    RUN_TEST(test_room_for_the_table_is_asked_for);
    RUN_TEST(test_nothing_is_no_image);
    RUN_TEST(test_every_length_but_the_whole_is_refused);
    RUN_TEST(test_every_bit_that_is_another_is_refused);
    RUN_TEST(test_flash_without_an_image_is_refused);
    RUN_TEST(test_stale_images_are_refused);
    RUN_TEST(test_lengths_that_are_none_are_refused);
    RUN_TEST(test_parts_outside_the_image_are_refused);
    RUN_TEST(test_values_outside_their_range_are_refused);
    RUN_TEST(test_another_order_of_bytes_is_seen);
    RUN_TEST(test_identity_tells_every_value);
    RUN_TEST(test_checksum_is_the_known_one);
    RUN_TEST(test_every_status_has_its_text);
    return UNITY_END();
}
