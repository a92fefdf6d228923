/* A model of any actuator that passes its check, and one step from any state: any bits in every number, NaN and
 * infinities too. Shown: no index, pointer, shift, division of whole numbers or conversion goes wrong. */
#include "states.h"

static ema_actuator_t actuator;
static ema_model_t model;
static ema_output_t output;

void main(void)
{
    ema_real start_mm;
    ema_real command_mm;
    ema_any_actuator(&actuator);
    //@ slevel merge;
    EMA_ANY(start_mm);
    EMA_ANY(command_mm);
    if (ema_model_init(&model, &actuator, start_mm) == EMA_OK) {
        //@ slevel merge;
        EMA_ANY(model.state);
        model.state.motion = Frama_C_interval(EMA_MOTION_BACKWARD, EMA_MOTION_ELASTIC);
        model.state.play_side = Frama_C_interval(-1, 1);
        (void)ema_model_step(&model, command_mm, &output);
    }
    Frama_C_show_each_end();
}
