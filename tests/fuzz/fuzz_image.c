/* Images of configurations and packed results with any bytes: a reason, or units whose parts lie inside the image and
 * whose values are in range. */
#include "ema/ema.h"
#include "ema_fuzz.h"
#include "ema_image_rig.h"

#define IMAGE_BYTES 4096U
#define UNITS_MAX 3U
#define CHANGES_MAX 8U

/* A table of no meaning whose numbers hang together. */
static void make_table(fuzz_bytes_t* bytes, ema_signatures_t* table)
{
    static ema_pattern_t patterns[4];
    static ema_real units[4];
    static int16_t values[8U * 9U];
    (void)memset(table, 0, sizeof *table);
    table->version = EMA_SIGNATURES_VERSION;
    table->channels = 1U;
    table->patterns = 1U + (fuzz_u8(bytes) % 4U);
    table->rows = fuzz_u8(bytes) % 5U;
    table->bins = fuzz_u8(bytes) % 8U;
    table->pattern = patterns;
    table->unit = units;
    table->value = values;
}

static void require_inside(const void* part, size_t size, const uint8_t* image, size_t length)
{
    const uint8_t* const first = (const uint8_t*)part;
    FUZZ_REQUIRE((first >= image) && (size <= length) && ((size_t)(first - image) <= (length - size)));
}

static void require_unit(const ema_unit_t* unit)
{
    FUZZ_REQUIRE(memchr(unit->name, 0, sizeof unit->name) != NULL);
    FUZZ_REQUIRE(ema_actuator_check(unit->actuator, NULL) == EMA_OK);
}

/* Reads every unit there may be, in place and as a copy: both must say the same, and be inside. */
static void read_all(const uint8_t* image, size_t length)
{
    static ema_real table[4096];
    static ema_actuator_t actuator;
    const ema_unit_memory_t memory = {&actuator, table, sizeof table};
    const ema_image_status_t checked = ema_image_check(image, length);
    const uint32_t count = ema_image_count(image, length);
    FUZZ_REQUIRE((checked != EMA_IMAGE_OK) || (count > 0U));
    for (uint32_t place = 0; place <= count; ++place) {
        ema_unit_t unit;
        ema_unit_t copy;
        const ema_image_status_t opened = ema_image_open(image, length, place, &unit);
        const ema_image_status_t copied = ema_image_copy(image, length, place, &memory, &copy);
        FUZZ_REQUIRE((place < count) || ((opened != EMA_IMAGE_OK) && (copied != EMA_IMAGE_OK)));
        FUZZ_REQUIRE((opened == copied) || (opened == EMA_IMAGE_PLACE) || (copied == EMA_IMAGE_ROOM));
        if (opened == EMA_IMAGE_OK) {
            uint32_t found = UINT32_MAX;
            require_unit(&unit);
            require_inside(unit.actuator, sizeof *unit.actuator, image, length);
            FUZZ_REQUIRE((checked != EMA_IMAGE_OK)
                         || (ema_image_find(image, length, unit.name, &found) == EMA_IMAGE_OK));
            FUZZ_REQUIRE((checked != EMA_IMAGE_OK) || (found <= place));
            if (unit.has_signatures) {
                const ema_signatures_t* const own = &unit.signatures;
                const size_t counts = (size_t)own->bins * (1U + ((size_t)own->channels * (1U + own->rows)));
                require_inside(own->pattern, own->patterns * sizeof *own->pattern, image, length);
                require_inside(own->unit, own->rows * sizeof *own->unit, image, length);
                require_inside(own->value, counts * sizeof *own->value, image, length);
            }
        }
        if (copied == EMA_IMAGE_OK) {
            require_unit(&copy);
            FUZZ_REQUIRE((opened != EMA_IMAGE_OK) || (copy.identity == unit.identity));
            FUZZ_REQUIRE((opened != EMA_IMAGE_OK) || (memcmp(&actuator, unit.actuator, sizeof actuator) == 0));
        }
    }
}

static void try_made(fuzz_bytes_t* bytes)
{
    static union {
        uint32_t word;
        uint8_t bytes[IMAGE_BYTES];
    } image;
    static ema_actuator_t actuators[UNITS_MAX];
    static ema_signatures_t tables[UNITS_MAX];
    static const char* const names[UNITS_MAX] = {"first", "second", "a third one with 31 bytes of it"};
    ema_image_rig_unit_t units[UNITS_MAX];
    const uint32_t count = 1U + (fuzz_u8(bytes) % UNITS_MAX);
    for (uint32_t k = 0; k < count; ++k) {
        FUZZ_REQUIRE(ema_actuator_defaults(&actuators[k]) == EMA_OK);
        fuzz_change(bytes, &actuators[k], (fuzz_u8(bytes) % 8U) == 0U);
        make_table(bytes, &tables[k]);
        units[k] = (ema_image_rig_unit_t){names[k], &actuators[k], ((fuzz_u8(bytes) % 2U) == 0U) ? &tables[k] : NULL};
    }
    const uint32_t length = ema_image_rig(image.bytes, units, count);
    FUZZ_REQUIRE(ema_image_check(image.bytes, length) == EMA_IMAGE_OK);
    const uint32_t changes = fuzz_u8(bytes) % CHANGES_MAX;
    for (uint32_t k = 0; k < changes; ++k) {
        const uint32_t place = fuzz_u16(bytes) % (length / 4U);
        /* also numbers near those that are there */
        const uint32_t value = fuzz_u32(bytes);
        const uint32_t old = ema_image_rig_get(image.bytes, 4U * place);
        ema_image_rig_put(image.bytes, 4U * place, ((value % 2U) == 0U) ? value : (old + (value % 16U) - 8U));
    }
    const uint32_t stated = ema_image_rig_get(image.bytes, EMA_RIG_LENGTH);
    if ((stated >= 4U) && (stated <= IMAGE_BYTES)) {
        ema_image_rig_seal(image.bytes);
    }
    read_all(image.bytes, length);
    const size_t part = fuzz_u16(bytes) % (length + 1U);
    read_all(image.bytes, part);
}

static void try_packet(fuzz_bytes_t* bytes)
{
    uint8_t packet[EMA_TELEMETRY_BYTES];
    ema_telemetry_t read;
    for (uint32_t k = 0; k < EMA_TELEMETRY_BYTES; ++k) {
        packet[k] = fuzz_u8(bytes);
    }
    (void)memcpy(packet, "EMAT\x01\x00\xF0\x00", 8U);
    FUZZ_REQUIRE(ema_result_unpack(packet, sizeof packet, &read) != EMA_IMAGE_SHORT);
    ema_image_rig_put(packet, sizeof packet - 4U, ema_image_rig_crc(packet, sizeof packet - 4U));
    if (ema_result_unpack(packet, sizeof packet, &read) == EMA_IMAGE_OK) {
        FUZZ_REQUIRE(read.result.identified_count <= EMA_IDENTIFIED_MAX);
        FUZZ_REQUIRE((uint32_t)read.finding.effect <= (uint32_t)EMA_EFFECT_COUNT);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    fuzz_bytes_t bytes = {data, size};
    const uint8_t what = fuzz_u8(&bytes);
    if ((what % 4U) == 0U) {
        /* the bytes as they are: libFuzzer's memory begins where it likes */
        read_all(data, size);
    } else if ((what % 4U) == 1U) {
        try_packet(&bytes);
    } else {
        try_made(&bytes);
    }
    return 0;
}
