/* A program of another project: prints in hexadecimal what the reference actuator does in 2000 steps of 1 mm, so that
 * builds can be compared to the bit. */
#include <stdio.h>

#include "ema/ema.h"

int main(void)
{
    static ema_actuator_t actuator;
    static ema_model_t model;
    ema_output_t output = {0};
    double sum = 0.0;
    ema_status_t status = ema_actuator_defaults(&actuator);
#ifdef STRIBECK_RISE
    actuator.effects.stribeck_friction.rise = STRIBECK_RISE;
#endif
    if (status == EMA_OK) {
        status = ema_model_init(&model, &actuator, EMA_R(0.0));
    }
    for (int step = 0; (status == EMA_OK) && (step < 2000); step++) {
        status = ema_model_step(&model, ((step / 500) % 2) ? EMA_R(-1.0) : EMA_R(1.0), &output);
        sum += (double)output.position_mm + (double)output.current_A;
    }
    (void)printf("%d %s: %a %a\n", (int)status, ema_status_text(status), (double)output.position_mm, sum);
    return 0;
}
