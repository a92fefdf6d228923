#include "ema_desk_actuator.h"

#include <stddef.h>

void ema_actuator_from(const double* values, const int32_t* options, ema_actuator_t* actuator)
{
    int32_t* const fields = (int32_t*)(void*)&actuator->options;
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        (void)ema_actuator_set(actuator, (ema_value_id_t)id, (ema_real)values[id]);
    }
    for (size_t index = 0; index < EMA_OPTION_COUNT; ++index) {
        fields[index] = options[index];
    }
}
