/* Everything that makes a model of one actuator: plain numbers, no pointers.
 *
 * The fields are the rows of ema_params.def (nominal values, ranges, units and texts stand there) and of
 * ema_effects.def. A firmware build keeps the structure in flash: ema export writes it as a const initialiser.
 */
#ifndef EMA_ACTUATOR_H
#define EMA_ACTUATOR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ema/detail/ema_real.h"
#include "ema/detail/ema_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Real parameters, in the order of the list. */
typedef struct {
#define EMA_PARAM(section, field, nominal, lower, upper, text) ema_real field;
#include "ema/ema_params.def"
} ema_params_t;

/* Choices and whole numbers, in the order of the list. */
typedef struct {
#define EMA_OPTION(section, field, nominal, lower, upper, choices, text) int32_t field;
#include "ema/ema_params.def"
} ema_options_t;

/* One structure per effect, ema_effect_<name>_t, and all of them side by side. */
#define EMA_P(field, nominal, lower, upper, text) ema_real field; /* EMA-D1 */
/* EMA-D1 */
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    typedef struct {                                                                                                   \
        parameters                                                                                                     \
    } ema_effect_##name##_t;
#include "ema/ema_effects.def"

typedef struct {
/* EMA-D1 */
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) ema_effect_##name##_t name;
#include "ema/ema_effects.def"
} ema_effects_t;

/* Place of each effect in the list. */
typedef enum {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters) EMA_EFFECT_ID_##name,
#include "ema/ema_effects.def"
    EMA_EFFECT_COUNT /* also: no effect */
} ema_effect_id_t;

typedef struct {
    ema_params_t params;
    ema_options_t options;
    ema_effects_t effects;
} ema_actuator_t;

/* The axes of learned tables, as the value `axis` of a table counts them. */
typedef enum {
    EMA_AXIS_SPEED = 0,    /* of the motor shaft, rad/s */
    EMA_AXIS_POSITION = 1, /* motor position expressed at the rod, or the rod's where its sensor is meant, mm */
    EMA_AXIS_LEAD = 2,     /* the same within one lead of the screw, mm: periodic */
    EMA_AXIS_TURN = 3,     /* motor angle within one turn, rad: periodic */
    EMA_AXIS_CURRENT = 4   /* of the motor, A */
} ema_axis_t;

/* Number of real parameters, of options, of effects, and of reals in all effects together. */
#define EMA_PARAM_COUNT (sizeof(ema_params_t) / sizeof(ema_real))
#define EMA_OPTION_COUNT (sizeof(ema_options_t) / sizeof(int32_t))
#define EMA_EFFECT_VALUE_COUNT (sizeof(ema_effects_t) / sizeof(ema_real))
#define EMA_VALUE_COUNT (EMA_PARAM_COUNT + EMA_EFFECT_VALUE_COUNT)

/* The index by which a real value is named: parameters first, then the effects' values, in the order of the lists. */
typedef uint16_t ema_value_id_t;

#define EMA_VALUE_ID(field) ((ema_value_id_t)((size_t)offsetof(ema_params_t, field) / sizeof(ema_real)))
#define EMA_EFFECT_VALUE_ID(name, field)                                                                               \
    ((ema_value_id_t)(EMA_PARAM_COUNT                                                                                  \
                      + ((offsetof(ema_effects_t, name) + offsetof(ema_effect_##name##_t, field))                      \
                         / sizeof(ema_real))))

/* Whether the value belongs to a learned table. A model reads tables where they lie, so they are not identified while
 * it runs. Cost: a handful of comparisons. */
bool ema_actuator_is_learned(ema_value_id_t id);

/* Every real value, then every option, has one row: ids of options start at EMA_VALUE_COUNT. */
typedef struct {
    ema_real nominal;
    ema_real lower;
    ema_real upper;
} ema_range_t;

/* The nominal value and the range of value or option `id`; NULL when there is none. Cost: constant. */
const ema_range_t* ema_actuator_range(size_t id);

/* Sets the reference actuator without effects. Errors: EMA_ERR_NULL. Cost: one copy per value. */
ema_status_t ema_actuator_defaults(ema_actuator_t* actuator);

/* Checks every value and option against its range, every effect that is not zero for being in this build
 * (EMA_ERR_ABSENT), and every table that acts: EMA_ERR_RANGE for an axis that is none of the five or a range longer
 * than a periodic axis, EMA_ERR_BOUNDS when `first` is not below `last`. On these and on EMA_ERR_NOT_FINITE, `offender`
 * (may be NULL) is the id of the first bad value. EMA_ERR_ABSENT too, with EMA_VALUE_COUNT for `offender`, where
 * control law, drive or encoder are none that the build has fixed; a build that leaves ranges to the desk looks at what
 * is left out alone. EMA_ERR_NULL. Cost: two comparisons per value. */
ema_status_t ema_actuator_check(const ema_actuator_t* actuator, size_t* offender);

/* Reads and writes a real value by id. Errors: EMA_ERR_NULL; EMA_ERR_RANGE for an id outside the list. Cost: constant.
 */
ema_status_t ema_actuator_get(const ema_actuator_t* actuator, ema_value_id_t id, ema_real* value);
ema_status_t ema_actuator_set(ema_actuator_t* actuator, ema_value_id_t id, ema_real value);

/* What tells one configuration from another: CRC-32 of every value as float32 and of every option, in the order of the
 * structure, the least byte first. The image of a unit and every packed result carry it. 0 for none. Cost: some fifty
 * instructions per value. */
uint32_t ema_actuator_identity(const ema_actuator_t* actuator);

#ifdef __cplusplus
}
#endif

#endif
