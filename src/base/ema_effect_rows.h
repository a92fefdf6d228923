/* The rows of ema_effects.def as numbers, and which of them this build holds: all, or with EMA_EFFECTS_CHOSEN those
 * whose EMA_WITH_<name> is 1.
 *
 * The structures are the same in every build, so a configuration fits all of them; of an effect that is left out
 * neither code nor ranges remain, and one that is not zero is refused with EMA_ERR_ABSENT.
 */
#ifndef EMA_EFFECT_ROWS_H
#define EMA_EFFECT_ROWS_H

#include <stdint.h>

#include "ema/detail/ema_plant.h"

#ifndef EMA_EFFECTS_CHOSEN
#define EMA_EFFECTS_CHOSEN 0
#endif

/* 1 or 0, as a token. A name that is no macro is not 1: then the mark pastes to a word that stands for itself. */
#if EMA_EFFECTS_CHOSEN
#define EMA_HELD_MARK_1 0,
#define EMA_HELD_SECOND(first, second, ...) second
#define EMA_HELD_PICK(mark) EMA_HELD_SECOND(mark 1, 0, 0) /* EMA-D1 */
#define EMA_HELD_LOOK(word) EMA_HELD_PICK(EMA_HELD_MARK_##word)
#define EMA_HELD_EXPAND(word) EMA_HELD_LOOK(word)
#define EMA_HELD(name) EMA_HELD_EXPAND(EMA_WITH_##name)
#else
#define EMA_HELD(name) 1
#endif

/* Learned tables act at a site too; they are told apart by this. */
enum {
    EMA_SITE_IS_TABLE = 16,
    EMA_SITE_MASK = 15,
    EMA_SITE_FRICTION_TABLE = 17,
    EMA_SITE_TORQUE_TABLE = 18,
    EMA_SITE_VOLTAGE_TABLE = 20,
    EMA_SITE_READING_TABLE = 24
};

/* Which of them this build holds. */
enum {
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    EMA_HAS_##name = EMA_HELD(name),
#include "ema/ema_effects.def"
    EMA_HAS_NONE = 0
};

/* One bit per site at which an effect of this build acts, and whether one of them is a table. */
enum {
    EMA_SITES_HELD = 0U
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    | ((uint32_t)EMA_HAS_##name << ((uint32_t)EMA_SITE_##site & (uint32_t)EMA_SITE_MASK))
#include "ema/ema_effects.def"
    ,
    EMA_TABLES_HELD = 0U
#define EMA_EFFECT(name, site, memory, substeps, equation, source, look_alikes, parameters)                            \
    | ((uint32_t)EMA_HAS_##name * ((uint32_t)EMA_SITE_##site & (uint32_t)EMA_SITE_IS_TABLE))
#include "ema/ema_effects.def"
};

/* Whether row `k` is still one to look at: none is when the build holds no effect, or no table. */
#define EMA_ROW_HELD(k) ((EMA_SITES_HELD != 0) && ((k) < (uint32_t)EMA_EFFECT_COUNT))
#define EMA_ROW_TABLE(k) ((EMA_TABLES_HELD != 0) && ((k) < (uint32_t)EMA_EFFECT_COUNT))

/* Places of a learned table's values, as EMA_TABLE has them; ema_table.c holds them against it. */
enum {
    EMA_TABLE_GAIN = 0,
    EMA_TABLE_AXIS = 1,
    EMA_TABLE_FIRST = 2,
    EMA_TABLE_LAST = 3,
    EMA_TABLE_NODES = 4,
    EMA_TABLE_VALUES = 20
};

typedef struct {
    uint8_t values;   /* how many numbers it has; the first is its size */
    uint8_t site;     /* an ema_effect_site_t, with EMA_SITE_IS_TABLE for a learned table */
    uint8_t substeps; /* that it needs in a model step */
    bool held;        /* by this build */
} ema_effect_row_t;

extern const ema_effect_row_t ema_effect_rows[EMA_EFFECT_COUNT];

#endif
