/* Ranges and access by index, read from the two lists. */
#include <stddef.h>

#include "base/ema_bounds.h"
#include "base/ema_bytes.h"
#include "base/ema_choice.h"
#include "base/ema_effect_rows.h"
#include "base/ema_math.h"
#include "ema/ema_actuator.h"

/* Rows of bounds that a learned table has: gain, axis, first, last, and one for its nodes, which are all alike. */
#define EMA_TABLE_BOUNDS 5U

/* Distances between the nodes of a learned table. */
#define EMA_TABLE_SPANS EMA_R(15.0)

/* The length of a periodic axis as a file may round it. */
#define EMA_PERIOD_ROUNDED EMA_R(1.00001)

/* Bounds of the parameters, of the effects that this build holds, and of the options. */
static const ema_bounds_t ema_bounds[] = {
#define EMA_PARAM(section, field, nominal, lower, upper, text) {EMA_R(lower), EMA_R(upper)},
#include "ema/ema_params.def"
#define EMA_TABLE_NODES(lower, upper, text) EMA_P(nodes, 0.0, lower, upper, text)
#define EMA_P(field, nominal, lower, upper, text) {EMA_R(lower), EMA_R(upper)},
#define EMA_BOUNDS_1(...) __VA_ARGS__
#define EMA_BOUNDS_0(...)
#define EMA_BOUNDS_JOIN(held) EMA_BOUNDS_##held
#define EMA_BOUNDS_OF(held) EMA_BOUNDS_JOIN(held)
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    EMA_BOUNDS_OF(EMA_HELD(name))(parameters)
#include "ema/ema_effects.def"
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) {(ema_real)(lower), (ema_real)(upper)},
#include "ema/ema_params.def"
};

/* How many of them an effect has. */
#define EMA_BOUNDS_COUNT(held, site, values)                                                                           \
    ((held) ? ((((uint32_t)(site) & (uint32_t)EMA_SITE_IS_TABLE) != 0U) ? EMA_TABLE_BOUNDS : (uint32_t)(values)) : 0U)

#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    +EMA_BOUNDS_COUNT(EMA_HAS_##name != 0, EMA_SITE_##site, sizeof(ema_effect_##name##_t) / sizeof(ema_real))
_Static_assert((sizeof(ema_bounds) / sizeof(ema_bounds[0]))
                   == (EMA_PARAM_COUNT + EMA_OPTION_COUNT
#include "ema/ema_effects.def"
                       ),
               "the nodes of a table share one row of bounds");

static bool ema_row_is_table(const ema_effect_row_t* row)
{
    return (row->site & (uint8_t)EMA_SITE_IS_TABLE) != 0U;
}

static uint32_t ema_row_bounds(const ema_effect_row_t* row)
{
    return EMA_BOUNDS_COUNT(row->held, row->site, row->values);
}

/* The effect of value `id`, NULL where it is a parameter or none; the place of its first row of bounds, and the value's
 * place in it. */
static const ema_effect_row_t* ema_row_of(size_t id, size_t* first, size_t* place)
{
    const ema_effect_row_t* row = NULL;
    *first = EMA_PARAM_COUNT;
    *place = id - EMA_PARAM_COUNT;
    for (uint32_t k = 0; (row == NULL) && (id >= EMA_PARAM_COUNT) && EMA_ROW_HELD(k); ++k) {
        if (*place < (size_t)ema_effect_rows[k].values) {
            row = &ema_effect_rows[k];
        } else {
            *place -= ema_effect_rows[k].values;
            *first += ema_row_bounds(&ema_effect_rows[k]);
        }
    }
    return row;
}

bool ema_bounds_of(size_t id, ema_bounds_t* bounds)
{
    size_t first;
    size_t place;
    const ema_effect_row_t* const row = ema_row_of(id, &first, &place);
    const size_t count = (row != NULL) ? ema_row_bounds(row) : 0U;
    const bool found = (id < EMA_PARAM_COUNT) || (count > 0U);
    if (found) {
        *bounds = ema_bounds[(id < EMA_PARAM_COUNT) ? id : (first + ((place < count) ? place : (count - 1U)))];
    }
    return found;
}

_Static_assert((size_t)offsetof(ema_actuator_t, params) == 0U, "the parameters are what an actuator begins with");

/* The structures are flat vectors of one type, so an index is an offset, in bytes from the actuator's beginning: the
 * options stand between. One that is none is the first value's. */
static size_t ema_value_offset(size_t id)
{
    const size_t inside = (id < EMA_VALUE_COUNT) ? (id * sizeof(ema_real)) : 0U;
    const size_t between = (size_t)offsetof(ema_actuator_t, effects) - (EMA_PARAM_COUNT * sizeof(ema_real));
    return (inside < (EMA_PARAM_COUNT * sizeof(ema_real))) ? inside : (inside + between);
}

#if !EMA_ONLY_CHECKED
/* How many of `count` values, from the first on, lie within their bounds; the last row of bounds holds for the rest.
 * Says why it stopped. */
static size_t ema_values_within(const ema_real* value, size_t count, const ema_bounds_t* bounds, size_t rows,
                                ema_status_t* status)
{
    size_t good = 0U;
    while ((*status == EMA_OK) && (good < count)) {
        const ema_bounds_t* const range = &bounds[(good < rows) ? good : (rows - 1U)];
        if ((value[good] >= range->lower) && (value[good] <= range->upper)) {
            ++good;
        } else {
            *status = ema_is_finite(value[good]) ? EMA_ERR_RANGE : EMA_ERR_NOT_FINITE;
        }
    }
    return good;
}
#endif

/* The values and options, one after the other; `id` is the first bad one's. Where they were checked at the desk, only
 * whether an effect acts that this build leaves out; `id` is its size's. */
static ema_status_t ema_ranges_check(const ema_actuator_t* actuator, size_t* id)
{
    ema_status_t status = EMA_OK;
#if EMA_ONLY_CHECKED
    const ema_real* value = (const ema_real*)(const void*)&actuator->effects; /* EMA-D4 */
    *id = EMA_PARAM_COUNT;
    for (uint32_t k = 0; (status == EMA_OK) && (k < (uint32_t)EMA_EFFECT_COUNT); ++k) {
        if (!ema_effect_rows[k].held && (*value != EMA_R(0.0))) {
            status = EMA_ERR_ABSENT;
        } else {
            *id += ema_effect_rows[k].values;
        }
        value = &value[ema_effect_rows[k].values];
    }
#else
    const ema_real* value = (const ema_real*)(const void*)&actuator->params; /* EMA-D4 */
    const ema_bounds_t* bounds = ema_bounds;
    *id = ema_values_within(value, EMA_PARAM_COUNT, bounds, EMA_PARAM_COUNT, &status);
    bounds = &bounds[EMA_PARAM_COUNT];
    value = (const ema_real*)(const void*)&actuator->effects; /* EMA-D4 */
    for (uint32_t k = 0; (status == EMA_OK) && (k < (uint32_t)EMA_EFFECT_COUNT); ++k) {
        const ema_effect_row_t* const row = &ema_effect_rows[k];
        const uint32_t count = ema_row_bounds(row);
        if (count > 0U) {
            *id += ema_values_within(value, row->values, bounds, count, &status);
        } else if (*value != EMA_R(0.0)) {
            status = EMA_ERR_ABSENT;
        } else {
            *id += row->values;
        }
        value = &value[row->values];
        bounds = &bounds[count];
    }
    const int32_t* const option = (const int32_t*)(const void*)&actuator->options; /* EMA-D4 */
    for (uint32_t k = 0; (status == EMA_OK) && (k < EMA_OPTION_COUNT); ++k) {
        const ema_real number = (ema_real)option[k];
        *id += ema_values_within(&number, 1U, &bounds[k], 1U, &status);
    }
#endif
    return status;
}

/* Periods of the axes position in the lead and angle in the turn; zero for the others. */
static ema_real ema_axis_period(const ema_params_t* params, ema_real axis)
{
    const ema_axis_t kind = (ema_axis_t)(int32_t)axis;
    const ema_real period_of_turn = (kind == EMA_AXIS_TURN) ? EMA_TURN_RAD : EMA_R(0.0);
    return (kind == EMA_AXIS_LEAD) ? params->lead_mm : period_of_turn;
}

/* What ranges alone do not tell of a table that acts; `offender` is the place of the bad value in it. */
static ema_status_t ema_table_check(const ema_real* table, const ema_params_t* params, size_t* offender)
{
    const ema_real axis = table[EMA_TABLE_AXIS];
    const ema_real first = table[EMA_TABLE_FIRST];
    const ema_real last = table[EMA_TABLE_LAST];
    const ema_real period = ema_axis_period(params, axis); /* of no matter where the axis is none */
    ema_status_t status = EMA_OK;
    /* a range so short that its inverse overflows is none */
    if (!(first < last) || !ema_is_finite(EMA_TABLE_SPANS / (last - first))) {
        status = EMA_ERR_BOUNDS;
        *offender = (size_t)EMA_TABLE_FIRST;
    } else if (axis != ema_floor(axis)) {
        status = EMA_ERR_RANGE;
        *offender = (size_t)EMA_TABLE_AXIS;
    } else if ((period > EMA_R(0.0)) && ((last - first) > (period * EMA_PERIOD_ROUNDED))) {
        status = EMA_ERR_RANGE;
        *offender = (size_t)EMA_TABLE_LAST;
    } else {
        /* a table that can be read */
    }
    return status;
}

/* Tables that act; `id` is the first bad value's. */
static ema_status_t ema_tables_check(const ema_actuator_t* actuator, size_t* id)
{
    ema_status_t status = EMA_OK;
    const ema_real* value = (const ema_real*)(const void*)&actuator->effects; /* EMA-D4 */
    size_t first = EMA_PARAM_COUNT;
    for (uint32_t k = 0; (status == EMA_OK) && EMA_ROW_TABLE(k); ++k) {
        if (ema_row_is_table(&ema_effect_rows[k]) && (*value != EMA_R(0.0))) {
            size_t place = 0U;
            status = ema_table_check(value, &actuator->params, &place);
            *id = first + place;
        }
        value = &value[ema_effect_rows[k].values];
        first += ema_effect_rows[k].values;
    }
    return status;
}

bool ema_actuator_is_learned(ema_value_id_t id)
{
    size_t first;
    size_t place;
    const ema_effect_row_t* const row = ema_row_of(id, &first, &place);
    return (row != NULL) && ema_row_is_table(row);
}

ema_status_t ema_actuator_check(const ema_actuator_t* actuator, size_t* offender)
{
    if (actuator == NULL) {
        return EMA_ERR_NULL;
    }
    size_t id = 0U;
    ema_status_t status = ema_ranges_check(actuator, &id);
    if ((status == EMA_OK) && !ema_choice_fits(&actuator->params, &actuator->options)) {
        status = EMA_ERR_ABSENT;
        id = EMA_VALUE_COUNT;
    }
    if ((status == EMA_OK) && (EMA_TABLES_HELD != 0)) {
        status = ema_tables_check(actuator, &id);
    }
    if ((status != EMA_OK) && (offender != NULL)) {
        *offender = id;
    }
    return status;
}

ema_real ema_value_of(const ema_actuator_t* actuator, ema_value_id_t id)
{
    const unsigned char* const first = (const unsigned char*)actuator;
    return *(const ema_real*)(const void*)&first[ema_value_offset(id)]; /* EMA-D4 */
}

ema_status_t ema_actuator_get(const ema_actuator_t* actuator, ema_value_id_t id, ema_real* value)
{
    if ((actuator == NULL) || (value == NULL)) {
        return EMA_ERR_NULL;
    }
    if (id >= EMA_VALUE_COUNT) {
        return EMA_ERR_RANGE;
    }
    *value = ema_value_of(actuator, id);
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
    unsigned char* const first = (unsigned char*)actuator;
    *(ema_real*)(void*)&first[ema_value_offset(id)] = value; /* EMA-D4 */
    return EMA_OK;
}

const ema_effect_row_t ema_effect_rows[EMA_EFFECT_COUNT] = {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    {(uint8_t)(sizeof(ema_effect_##name##_t) / sizeof(ema_real)), (uint8_t)EMA_SITE_##site, (substeps##U),             \
     (EMA_HAS_##name != 0)},
#include "ema/ema_effects.def"
};

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

static uint32_t ema_identity_reals(uint32_t crc, const ema_real* value, size_t count)
{
    uint32_t found = crc;
    for (size_t k = 0; k < count; ++k) {
        uint8_t bytes[4];
        ema_put_real(bytes, value[k]);
        found = ema_crc32(found, bytes, sizeof bytes);
    }
    return found;
}

uint32_t ema_actuator_identity(const ema_actuator_t* actuator)
{
    if (actuator == NULL) {
        return 0U;
    }
    const int32_t* const option = (const int32_t*)(const void*)&actuator->options; /* EMA-D4 */
    uint32_t crc =
        ema_identity_reals(0U, (const ema_real*)(const void*)&actuator->params, EMA_PARAM_COUNT); /* EMA-D4 */
    for (size_t k = 0; k < EMA_OPTION_COUNT; ++k) {
        uint8_t bytes[4];
        ema_put_u32(bytes, (uint32_t)option[k]);
        crc = ema_crc32(crc, bytes, sizeof bytes);
    }
    return ema_identity_reals(crc, (const ema_real*)(const void*)&actuator->effects,
                              EMA_EFFECT_VALUE_COUNT); /* EMA-D4 */
}
