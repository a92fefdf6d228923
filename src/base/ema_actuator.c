/* Defaults, ranges and access by index, all read from the two lists. */
#include "ema/ema_actuator.h"

#include <string.h>

#include "ema_math.h"

static const ema_range_t ema_ranges[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {EMA_R(nominal), EMA_R(lower), EMA_R(upper)},
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text)
#include "ema/ema_params.def"
#undef EMA_PARAM
#undef EMA_OPTION
#define EMA_P(field, nominal, lower, upper, text) {EMA_R(nominal), EMA_R(lower), EMA_R(upper)},
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) parameters
#include "ema/ema_effects.def"
#undef EMA_EFFECT
#undef EMA_P
#define EMA_PARAM(section, field, nominal, lower, upper, text)
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) {(ema_real)(nominal), (ema_real)(lower), (ema_real)(upper)},
#include "ema/ema_params.def"
#undef EMA_PARAM
#undef EMA_OPTION
};

#define EMA_RANGE_COUNT (sizeof(ema_ranges) / sizeof(ema_ranges[0]))

_Static_assert(EMA_RANGE_COUNT == (EMA_VALUE_COUNT + EMA_OPTION_COUNT), "one range per value and option");

/* The structures are flat vectors of one type, so an index is an offset. */
static ema_real* ema_value_at(ema_actuator_t* actuator, size_t id)
{
    unsigned char* base = (unsigned char*)&actuator->params;
    size_t place = id;
    if (id >= EMA_PARAM_COUNT) {
        base = (unsigned char*)&actuator->effects;
        place = id - EMA_PARAM_COUNT;
    }
    return (ema_real*)(void*)(base + (place * sizeof(ema_real)));
}

static int32_t* ema_option_at(ema_actuator_t* actuator, size_t index)
{
    return (int32_t*)(void*)((unsigned char*)&actuator->options + (index * sizeof(int32_t)));
}

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
        *ema_value_at(actuator, id) = ema_ranges[id].nominal;
    }
    for (size_t index = 0; index < EMA_OPTION_COUNT; ++index) {
        *ema_option_at(actuator, index) = (int32_t)ema_ranges[EMA_VALUE_COUNT + index].nominal;
    }
    return EMA_OK;
}

ema_status_t ema_actuator_check(const ema_actuator_t* actuator, size_t* offender)
{
    if (actuator == NULL) {
        return EMA_ERR_NULL;
    }
    ema_actuator_t copy = *actuator;
    ema_status_t status = EMA_OK;
    size_t id = 0;
    while ((status == EMA_OK) && (id < EMA_RANGE_COUNT)) {
        const ema_real value = (id < EMA_VALUE_COUNT) ? *ema_value_at(&copy, id)
                                                      : (ema_real)*ema_option_at(&copy, id - EMA_VALUE_COUNT);
        if (!ema_is_finite(value)) {
            status = EMA_ERR_NOT_FINITE;
        } else if ((value < ema_ranges[id].lower) || (value > ema_ranges[id].upper)) {
            status = EMA_ERR_RANGE;
        } else {
            ++id;
        }
    }
    if ((status != EMA_OK) && (offender != NULL)) {
        *offender = id;
    }
    return status;
}

ema_status_t ema_actuator_get(const ema_actuator_t* actuator, ema_value_id_t id, ema_real* value)
{
    if ((actuator == NULL) || (value == NULL)) {
        return EMA_ERR_NULL;
    }
    if (id >= EMA_VALUE_COUNT) {
        return EMA_ERR_RANGE;
    }
    const unsigned char* base = (const unsigned char*)&actuator->params;
    size_t place = id;
    if (id >= EMA_PARAM_COUNT) {
        base = (const unsigned char*)&actuator->effects;
        place = (size_t)id - EMA_PARAM_COUNT;
    }
    (void)memcpy(value, base + (place * sizeof(ema_real)), sizeof(ema_real));
    return EMA_OK;
}

ema_status_t ema_actuator_set(ema_actuator_t* actuator, ema_value_id_t id, ema_real value)
{
    if (actuator == NULL) {
        return EMA_ERR_NULL;
    }
    if (id >= EMA_VALUE_COUNT) {
        return EMA_ERR_RANGE;
    }
    *ema_value_at(actuator, id) = value;
    return EMA_OK;
}
