#include "effects/ema_table.h"

#include <stddef.h>

#include "base/ema_effect_rows.h"
#include "base/ema_math.h"

#define EMA_TABLE_SPAN_COUNT ((uint32_t)(EMA_TABLE_VALUES - EMA_TABLE_NODES - 1))

#define EMA_ASSERT_TABLE(name)                                                                                         \
    _Static_assert(                                                                                                    \
        (sizeof(ema_effect_##name##_t) == ((size_t)EMA_TABLE_VALUES * sizeof(ema_real)))                               \
            && ((size_t)offsetof(ema_effect_##name##_t, gain) == ((size_t)EMA_TABLE_GAIN * sizeof(ema_real)))          \
            && ((size_t)offsetof(ema_effect_##name##_t, axis) == ((size_t)EMA_TABLE_AXIS * sizeof(ema_real)))          \
            && ((size_t)offsetof(ema_effect_##name##_t, first) == ((size_t)EMA_TABLE_FIRST * sizeof(ema_real)))        \
            && ((size_t)offsetof(ema_effect_##name##_t, last) == ((size_t)EMA_TABLE_LAST * sizeof(ema_real)))          \
            && ((size_t)offsetof(ema_effect_##name##_t, node_00) == ((size_t)EMA_TABLE_NODES * sizeof(ema_real))),     \
        "a table as EMA_TABLE makes it");
#define EMA_EFFECT_AT_FRICTION_TABLE(name) EMA_ASSERT_TABLE(name)
#define EMA_EFFECT_AT_TORQUE_TABLE(name) EMA_ASSERT_TABLE(name)
#define EMA_EFFECT_AT_VOLTAGE_TABLE(name) EMA_ASSERT_TABLE(name)
#define EMA_EFFECT_AT_READING_TABLE(name) EMA_ASSERT_TABLE(name)
#include "ema/ema_effects.def"

/* Where the site is on the axis, counted from the first node; the period is zero where the axis has none. */
typedef struct {
    ema_real from_first;
    ema_real period;
} ema_place_t;

static void ema_table_place(const ema_real* table, const ema_site_t* site, ema_place_t* place)
{
    ema_real at = EMA_R(0.0);
    place->period = EMA_R(0.0);
    switch ((int32_t)table[EMA_TABLE_AXIS]) {
    case (int32_t)EMA_AXIS_SPEED:
        at = site->speed_rad_s;
        break;
    case (int32_t)EMA_AXIS_LEAD:
        at = site->position_mm;
        place->period = site->plant->gearbox.lead_mm;
        break;
    case (int32_t)EMA_AXIS_TURN:
        at = site->angle_rad;
        place->period = EMA_TURN_RAD;
        break;
    case (int32_t)EMA_AXIS_CURRENT:
        at = site->current_A;
        break;
    case (int32_t)EMA_AXIS_POSITION:
    default:
        at = site->position_mm;
        break;
    }
    place->from_first = at - table[EMA_TABLE_FIRST];
}

/* Whole periods between the first node and the place; not a function, since nothing of the module lies deeper in the
 * stack. */
#define EMA_TABLE_ROUND(place) ((place).period * ema_floor((place).from_first / (place).period))

ema_real ema_table_value(const ema_real* table, const ema_site_t* site)
{
    const ema_real* const node = &table[EMA_TABLE_NODES];
    ema_place_t place;
    ema_table_place(table, site, &place);
    bool last = false;
    if (place.period > EMA_R(0.0)) {
        place.from_first -= EMA_TABLE_ROUND(place);
        last = place.from_first > (table[EMA_TABLE_LAST] - table[EMA_TABLE_FIRST]);
    }
    const ema_real range = table[EMA_TABLE_LAST] - table[EMA_TABLE_FIRST];
    ema_real value = node[EMA_TABLE_SPAN_COUNT];
    if (last) {
        /* round to the first node */
        const ema_real share = ema_clamp((place.from_first - range) / (place.period - range), EMA_R(0.0), EMA_R(1.0));
        value += share * (node[0] - node[EMA_TABLE_SPAN_COUNT]);
    } else {
        /* written so that NaN lands on the first node */
        const ema_real spans = ema_min(ema_max(place.from_first * ((ema_real)EMA_TABLE_SPAN_COUNT / range), EMA_R(0.0)),
                                       (ema_real)EMA_TABLE_SPAN_COUNT);
        const uint32_t span = (uint32_t)spans;
        if (span < EMA_TABLE_SPAN_COUNT) {
            value = node[span] + ((spans - (ema_real)span) * (node[span + 1U] - node[span]));
        }
    }
    return table[EMA_TABLE_GAIN] * value;
}

ema_real ema_table_outside(const ema_real* table, const ema_site_t* site, ema_real least)
{
    ema_place_t place;
    ema_table_place(table, site, &place);
    if (place.period > EMA_R(0.0)) {
        place.from_first -= EMA_TABLE_ROUND(place);
    }
    const ema_real range = table[EMA_TABLE_LAST] - table[EMA_TABLE_FIRST];
    ema_real beyond = ema_max(-place.from_first, place.from_first - range);
    if (!(beyond > EMA_R(0.0))) {
        return least;
    }
    if (place.period > EMA_R(0.0)) {
        /* the nearer edge */
        beyond = ema_min(beyond, place.period - place.from_first);
    }
    return ema_max(ema_max(beyond, EMA_R(0.0)) / range, least);
}
