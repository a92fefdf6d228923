/* The smallest firmware that identifies behind a table of signatures: what it links beyond ema_flash.c is the price of
 * the guard, table apart. */
#include "ema/ema.h"

extern const ema_actuator_t ema_flash_actuator;
extern const ema_sample_t ema_flash_sample;
extern const ema_signatures_t ema_flash_signatures;
ema_guarded_t ema_flash_guarded;
ema_session_config_t ema_flash_config;
ema_record_config_t ema_flash_record;
ema_result_t ema_flash_result;
ema_finding_t ema_flash_finding;

int ema_flash(void);

int ema_flash(void)
{
    ema_status_t status = ema_session_config_default(&ema_flash_config, &ema_flash_actuator, &ema_flash_record);
    if (status == EMA_OK) {
        status = ema_guarded_init(&ema_flash_guarded, &ema_flash_config, &ema_flash_signatures);
    }
    if (status == EMA_OK) {
        status = ema_guarded_feed(&ema_flash_guarded, &ema_flash_sample);
    }
    while ((status == EMA_OK) && (ema_guarded_phase(&ema_flash_guarded) != EMA_GUARDED_DONE)) {
        status = ema_guarded_run(&ema_flash_guarded, 200U);
    }
    if (status == EMA_OK) {
        status = ema_guarded_result(&ema_flash_guarded, &ema_flash_result, &ema_flash_finding);
    }
    return (int)status;
}
