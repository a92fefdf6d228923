/* The host program's actuator file: any bytes give an actuator that passes its own check, or one printable line that
 * says why. */
#define _POSIX_C_SOURCE 200809L

#include "ema_config.h"
#include "ema_csv_text.h"
#include "ema_fuzz.h"

#define NAME "actuator.txt"
#define MESSAGE_BYTES 256U

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static char text[65536];
    if ((size == 0U) || (size > sizeof text)) {
        return 0;
    }
    (void)memcpy(text, data, size);
    FILE* const file = fmemopen(text, size, "rb");
    FUZZ_REQUIRE(file != NULL);
    char message[MESSAGE_BYTES] = "";
    ema_actuator_t actuator;
    const bool good = ema_config_take(&actuator, file, NAME, message, sizeof message);
    (void)fclose(file);
    if (good) {
        size_t offender = 0U;
        const ema_status_t status = ema_actuator_check(&actuator, &offender);
        /* what two values say together is for the model to refuse: tables' ends */
        FUZZ_REQUIRE((status == EMA_OK) || (offender < EMA_VALUE_COUNT));
        FUZZ_REQUIRE((status == EMA_OK) || (status == EMA_ERR_BOUNDS) || (status == EMA_ERR_RANGE));
        FUZZ_REQUIRE(message[0] == '\0');
    } else {
        const char* const end = memchr(message, '\0', sizeof message);
        FUZZ_REQUIRE(end != NULL);
        FUZZ_REQUIRE(strncmp(message, NAME ": ", sizeof NAME + 1U) == 0);
        for (const char* at = message; at < end; at += ema_text_utf8(at, (size_t)(end - at))) {
            FUZZ_REQUIRE((unsigned char)*at >= 0x20U);
            FUZZ_REQUIRE(ema_text_utf8(at, (size_t)(end - at)) > 0U);
        }
    }
    return 0;
}
