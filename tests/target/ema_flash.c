/* The smallest firmware that identifies: what it links beyond this file is the module's share of flash. */
#include "ema/ema.h"

extern const ema_actuator_t ema_flash_actuator;
extern const ema_sample_t ema_flash_sample;
ema_session_t ema_flash_session;
ema_session_config_t ema_flash_config;
ema_record_config_t ema_flash_record;
ema_result_t ema_flash_result;

int ema_flash(void);

int ema_flash(void)
{
    ema_status_t status = ema_session_config_default(&ema_flash_config, &ema_flash_actuator, &ema_flash_record);
    if (status == EMA_OK) {
        status = ema_session_init(&ema_flash_session, &ema_flash_config);
    }
    if (status == EMA_OK) {
        status = ema_session_feed(&ema_flash_session, &ema_flash_sample);
    }
    while ((status == EMA_OK) && (ema_session_phase(&ema_flash_session) != EMA_PHASE_DONE)) {
        status = ema_session_run(&ema_flash_session, 200U);
    }
    if (status == EMA_OK) {
        status = ema_session_result(&ema_flash_session, &ema_flash_result);
    }
    return (int)status;
}
