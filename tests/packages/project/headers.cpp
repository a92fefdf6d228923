// The module from C++11.
#include "ema/ema.h"

int main()
{
    static ema_actuator_t actuator;
    return (ema_actuator_defaults(&actuator) == EMA_OK) ? 0 : 1;
}
