/* Block 6: encoder network. Equations: docs/DESIGN.md, "Encoder network". */
#ifndef EMA_ENCODER_H
#define EMA_ENCODER_H

#include "base/ema_choice.h"
#include "base/ema_math.h"
#include "ema/detail/ema_plant.h"

void ema_encoder_prepare(ema_encoder_t* encoder, const ema_params_t* params, const ema_options_t* options);

/* Delay and resolution on top of the sample `position_mm` of this step. */
ema_real ema_encoder_general(const ema_encoder_t* encoder, ema_state_t* state, ema_real position_mm);

/* What the rod sensor reads. */
static inline ema_real ema_encoder_rod(const ema_encoder_t* encoder, ema_real rod_mm)
{
    return (rod_mm * encoder->rod_gain) + encoder->rod_offset_mm;
}

/* What the position loop sees, from the motor position and the rod sensor's reading. */
static inline ema_real ema_encoder_step(const ema_encoder_t* encoder, ema_state_t* state, ema_real motor_mm,
                                        ema_real rod_reading_mm)
{
    const ema_real position_mm = encoder->at_rod ? rod_reading_mm : motor_mm;
    return ((EMA_ONLY_EXACT != 0) || encoder->plain) ? position_mm : ema_encoder_general(encoder, state, position_mm);
}

#endif
