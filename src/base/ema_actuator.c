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

/* Distances between the nodes of a learned table. */
#define EMA_TABLE_SPANS EMA_R(15.0)

/* The length of a periodic axis as a file may round it. */
#define EMA_PERIOD_ROUNDED EMA_R(1.00001)

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

/* The sites whose effects are learned tables: all other rows of the list expand to nothing. */
#define EMA_TABLES_PARAMETER(name)
#define EMA_TABLES_FRICTION(name)
#define EMA_TABLES_TORQUE(name)
#define EMA_TABLES_LOAD(name)
#define EMA_TABLES_VOLTAGE(name)
#define EMA_TABLES_MOTOR(name)
#define EMA_TABLES_PRESLIDING(name)
#define EMA_TABLES_TRANSMISSION(name)
#define EMA_TABLES_FRICTION_TABLE(name) EMA_TABLES(name)
#define EMA_TABLES_TORQUE_TABLE(name) EMA_TABLES(name)
#define EMA_TABLES_VOLTAGE_TABLE(name) EMA_TABLES(name)
#define EMA_TABLES_READING_TABLE(name) EMA_TABLES(name)
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) EMA_TABLES_##site(name)

/* Periods of the axes position in the lead and angle in the turn; zero for the others. */
static ema_real ema_axis_period(const ema_params_t* params, ema_real axis)
{
    const ema_real period_of_turn = (axis == EMA_R(3.0)) ? EMA_TURN_RAD : EMA_R(0.0);
    return (axis == EMA_R(2.0)) ? params->lead_mm : period_of_turn;
}

/* What ranges alone do not tell of a table that acts; `offender` is the place of the bad value in it. */
static ema_status_t ema_table_check(ema_real axis, ema_real first, ema_real last, ema_real period, size_t axis_id, size_t* offender)
{
    ema_status_t status = EMA_OK;
    /* a range so short that its inverse overflows is none */
    if (!(first < last) || !ema_is_finite(EMA_TABLE_SPANS / (last - first))) {
        status = EMA_ERR_BOUNDS;
        *offender = axis_id + 1U;
    } else if (axis != ema_floor(axis)) {
        status = EMA_ERR_RANGE;
        *offender = axis_id;
    } else if ((period > EMA_R(0.0)) && ((last - first) > (period * EMA_PERIOD_ROUNDED))) {
        status = EMA_ERR_RANGE;
        *offender = axis_id + 2U;
    } else {
        /* a table that can be read */
    }
    return status;
}

static ema_status_t ema_tables_check(const ema_actuator_t* actuator, size_t* offender)
{
    ema_status_t status = EMA_OK;
#define EMA_TABLES(name)                                                                                                                          \
    if ((status == EMA_OK) && (actuator->effects.name.gain != EMA_R(0.0))) {                                                                      \
        status = ema_table_check(actuator->effects.name.axis, actuator->effects.name.first, actuator->effects.name.last,                          \
                                 ema_axis_period(&actuator->params, actuator->effects.name.axis), (size_t)EMA_EFFECT_VALUE_ID(name, axis), offender); \
    }
#include "ema/ema_effects.def"
#undef EMA_TABLES
    return status;
}

bool ema_actuator_is_learned(ema_value_id_t id)
{
    bool learned = false;
#define EMA_TABLES(name) learned = learned || ((id >= EMA_EFFECT_VALUE_ID(name, gain)) && (id <= EMA_EFFECT_VALUE_ID(name, node_15)));
#include "ema/ema_effects.def"
#undef EMA_TABLES
#undef EMA_EFFECT
    return learned;
}

ema_status_t ema_actuator_check(const ema_actuator_t* actuator, size_t* offender)
{
    if (actuator == NULL) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = EMA_OK;
    size_t id = 0;
    while ((status == EMA_OK) && (id < EMA_RANGE_COUNT)) {
        ema_real value = EMA_R(0.0);
        if (id < EMA_VALUE_COUNT) {
            (void)ema_actuator_get(actuator, (ema_value_id_t)id, &value);
        } else {
            int32_t option;
            (void)memcpy(&option, (const unsigned char*)&actuator->options + ((id - EMA_VALUE_COUNT) * sizeof option), sizeof option);
            value = (ema_real)option;
        }
        if (!ema_is_finite(value)) {
            status = EMA_ERR_NOT_FINITE;
        } else if ((value < ema_ranges[id].lower) || (value > ema_ranges[id].upper)) {
            status = EMA_ERR_RANGE;
        } else {
            ++id;
        }
    }
    if (status == EMA_OK) {
        status = ema_tables_check(actuator, &id);
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
