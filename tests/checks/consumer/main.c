/* A program of another project: one step of the reference actuator towards 1 mm must move the motor forward. */
#include <stdio.h>

#include "ema/ema.h"

int main(void)
{
    static ema_actuator_t actuator;
    static ema_model_t model;
    ema_output_t output = {0};
    ema_status_t status = ema_actuator_defaults(&actuator);
    if (status == EMA_OK) {
        status = ema_model_init(&model, &actuator, 0);
    }
    for (int step = 0; (status == EMA_OK) && (step < 100); step++) {
        status = ema_model_step(&model, 1, &output);
    }
    (void)printf("%s, %.4f mm, %u bytes per number\n", ema_status_text(status), (double)output.motor_position_mm,
                 (unsigned)sizeof(ema_real));
    return ((status == EMA_OK) && (output.motor_position_mm > 0)) ? 0 : 1;
}
