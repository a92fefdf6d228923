/* One of each fault that the proofs look for, so that it is seen that they would find it. */
#include "states.h"

static ema_real values[4];

void main(void)
{
    const int32_t whole = Frama_C_interval(-1, 2147483647);
    const ema_real number = Frama_C_float_interval(-1.0e30f, 1.0e30f);
    switch (Frama_C_interval(0, 5)) {
    case 0:
        values[0] = values[(uint32_t)whole % 5U];
        break;
    case 1:
        values[0] = (ema_real)(7 / whole);
        break;
    case 2:
        values[0] = (ema_real)(whole + 1);
        break;
    case 3:
        values[0] = (ema_real)(int32_t)number;
        break;
    case 4:
        values[0] = (ema_real)(1 << whole);
        break;
    default:
        values[0] = number * number;
        break;
    }
    Frama_C_show_each_end();
}
