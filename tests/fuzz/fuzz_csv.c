/* Recordings as text: any bytes give rows of finite numbers, or a status with one printable line that says why, the
 * same however the bytes arrive. */
#include "ema_csv.h"
#include "ema_fuzz.h"

#include <math.h>

#define NAME "record.csv"
#define TRAVEL_MM 25.0
#define PERIOD_S 1.0e-3

typedef struct {
    const uint8_t* at;
    size_t left;
    size_t chunk;
} source_t;

/* What one reading of the text gives. */
typedef struct {
    ema_csv_status_t status;
    ema_csv_status_t fit;
    int64_t rows;
    uint64_t hash;
    char message[EMA_CSV_MESSAGE];
    char fit_message[EMA_CSV_MESSAGE];
} reading_t;

static int64_t give(void* context, char* buffer, size_t size)
{
    source_t* const source = context;
    const size_t most = (source->chunk < size) ? source->chunk : size;
    const size_t got = (most < source->left) ? most : source->left;
    (void)memcpy(buffer, source->at, got);
    source->at += got;
    source->left -= got;
    return (int64_t)got;
}

static void require_one_line(const char* message)
{
    const char* const end = memchr(message, '\0', EMA_CSV_MESSAGE);
    FUZZ_REQUIRE(end != NULL);
    FUZZ_REQUIRE(strncmp(message, NAME ": ", sizeof NAME + 1U) == 0);
    FUZZ_REQUIRE((end - message) > (ptrdiff_t)(sizeof NAME + 1U));
    for (const char* at = message; at < end;) {
        const size_t bytes = ema_text_utf8(at, (size_t)(end - at));
        FUZZ_REQUIRE(bytes > 0U);
        FUZZ_REQUIRE((unsigned char)*at >= 0x20U);
        at += bytes;
    }
}

static void read_all(ema_csv_t* csv, const uint8_t* text, size_t size, size_t chunk, reading_t* reading)
{
    source_t source = {text, size, chunk};
    double row[EMA_COLUMN_COUNT];
    double last_s = (double)-INFINITY;
    reading->rows = 0;
    reading->hash = 14695981039346656037ULL;
    reading->status = ema_csv_start(csv, NAME, give, &source);
    while (reading->status == EMA_CSV_OK) {
        reading->status = ema_csv_next(csv, row);
        if (reading->status == EMA_CSV_OK) {
            ++reading->rows;
            FUZZ_REQUIRE(row[EMA_COLUMN_TIME] > last_s);
            last_s = row[EMA_COLUMN_TIME];
            for (int i = 0; i < EMA_COLUMN_COUNT; ++i) {
                FUZZ_REQUIRE((((csv->mask >> i) & 1) != 0) ? isfinite(row[i]) : isnan(row[i]));
                uint64_t bits = 0U;
                (void)memcpy(&bits, &row[i], sizeof bits);
                reading->hash = (reading->hash ^ bits) * 1099511628211ULL;
            }
        }
    }
    FUZZ_REQUIRE((reading->status == EMA_CSV_END) == (csv->message[0] == '\0'));
    (void)memcpy(reading->message, csv->message, sizeof reading->message);
    FUZZ_REQUIRE(ema_csv_next(csv, row) == reading->status);
    reading->fit = ema_csv_fit(csv, TRAVEL_MM, PERIOD_S);
    (void)memcpy(reading->fit_message, csv->message, sizeof reading->fit_message);
    if (reading->status == EMA_CSV_END) {
        FUZZ_REQUIRE(reading->rows >= EMA_CSV_ROWS_MIN);
        FUZZ_REQUIRE((reading->fit == EMA_CSV_OK) || (reading->fit == EMA_CSV_UNIT)
                     || (reading->fit == EMA_CSV_PERIOD));
        FUZZ_REQUIRE((reading->fit == EMA_CSV_OK) == (reading->fit_message[0] == '\0'));
    } else {
        FUZZ_REQUIRE((reading->status > EMA_CSV_OPEN) && (reading->status < EMA_CSV_UNIT));
        FUZZ_REQUIRE(reading->fit == reading->status);
        require_one_line(reading->message);
    }
    if ((reading->status == EMA_CSV_END) && (reading->fit != EMA_CSV_OK)) {
        require_one_line(reading->fit_message);
    }
    ema_csv_close(csv);
}

static int64_t count_rows(ema_csv_t* csv, const uint8_t* text, size_t size)
{
    source_t source = {text, size, size + 1U};
    ema_csv_status_t status = ema_csv_start(csv, NAME, give, &source);
    while (status == EMA_CSV_OK) {
        status = ema_csv_skip(csv);
    }
    return csv->skipped;
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static ema_csv_t csv;
    static reading_t whole;
    static reading_t parts;
    /* the last byte says in which pieces the text arrives the second time */
    const size_t chunk = (size > 0U) ? (1U + (size_t)(data[size - 1U] % 61U)) : 1U;
    read_all(&csv, data, size, size + 1U, &whole);
    read_all(&csv, data, size, chunk, &parts);
    FUZZ_REQUIRE((whole.status == parts.status) && (whole.fit == parts.fit) && (whole.rows == parts.rows)
                 && (whole.hash == parts.hash));
    FUZZ_REQUIRE(strcmp(whole.message, parts.message) == 0);
    FUZZ_REQUIRE(strcmp(whole.fit_message, parts.fit_message) == 0);
    if (whole.status == EMA_CSV_END) {
        FUZZ_REQUIRE(count_rows(&csv, data, size) == whole.rows);
    }
    return 0;
}
