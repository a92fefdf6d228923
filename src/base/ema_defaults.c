/* The reference actuator and the ranges as tools show them. Firmware brings its own numbers and links none of this. */
#include "ema/ema_actuator.h"

static const ema_range_t ema_ranges[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {EMA_R(nominal), EMA_R(lower), EMA_R(upper)},
#include "ema/ema_params.def"
#define EMA_P(field, nominal, lower, upper, text) {EMA_R(nominal), EMA_R(lower), EMA_R(upper)},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
#include "ema/ema_effects.def"
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)                                               \
    {(ema_real)(nominal), (ema_real)(lower), (ema_real)(upper)},
#include "ema/ema_params.def"
};

#define EMA_RANGE_COUNT (sizeof(ema_ranges) / sizeof(ema_ranges[0]))

_Static_assert(EMA_RANGE_COUNT == (EMA_VALUE_COUNT + EMA_OPTION_COUNT), "one range per value and option");

const ema_range_t* ema_actuator_range(size_t id)
{
    return (id < EMA_RANGE_COUNT) ? &ema_ranges[id] : NULL;
}

ema_status_t ema_actuator_defaults(ema_actuator_t* actuator)
{
    if (actuator == NULL) {
        return EMA_ERR_NULL;
    }
    for (size_t id = 0; id < EMA_VALUE_COUNT; ++id) {
        (void)ema_actuator_set(actuator, (ema_value_id_t)id, ema_ranges[id].nominal);
    }
    int32_t* const option = (int32_t*)(void*)&actuator->options; /* EMA-D4 */
    for (size_t index = 0; index < EMA_OPTION_COUNT; ++index) {
        option[index] = (int32_t)ema_ranges[EMA_VALUE_COUNT + index].nominal;
    }
    return EMA_OK;
}
