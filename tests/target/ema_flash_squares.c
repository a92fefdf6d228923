/* The smallest firmware that also searches several values by least squares, on the session's record: what it links
 * beyond ema_flash.c is the price of it. */
#include "ema/ema.h"

extern const ema_actuator_t ema_flash_actuator;
extern const ema_sample_t ema_flash_sample;
ema_session_t ema_flash_session;
ema_session_config_t ema_flash_config;
ema_record_config_t ema_flash_record;
ema_result_t ema_flash_result;
ema_least_squares_t ema_flash_squares;
ema_least_squares_config_t ema_flash_searched;
ema_least_squares_result_t ema_flash_found;

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
    if (status == EMA_OK) {
        status = ema_least_squares_init(&ema_flash_squares, &ema_flash_searched, &ema_flash_session.record);
    }
    while ((status == EMA_OK) && !ema_least_squares_done(&ema_flash_squares)) {
        status = ema_least_squares_run(&ema_flash_squares, 200U);
    }
    if (status == EMA_OK) {
        status = ema_least_squares_result(&ema_flash_squares, &ema_flash_found);
    }
    return (int)status;
}
