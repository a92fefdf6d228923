/* What the self-test finds on every sound machine. After a change of a parameter, its nominal value or its range, or of
 * the arithmetic of model, search or chirp, tests/unit/test_selftest.c says the new values: take them when the change
 * was meant. */
#ifndef EMA_SELFTEST_KNOWN_H
#define EMA_SELFTEST_KNOWN_H

#include "ema/ema_selftest.h"

#if EMA_REAL64
#define EMA_CONSTANTS_KNOWN 0x20DFE542U
#define EMA_MODEL_KNOWN 0x5135207DU
#define EMA_SEARCH_KNOWN 0xCB3F2EE9U
#else
#define EMA_CONSTANTS_KNOWN 0xA6C70032U
#define EMA_MODEL_KNOWN 0x43AA122BU
#define EMA_SEARCH_KNOWN 0x37BCB835U
#endif

/* What there is to compare with them. */
uint32_t ema_selftest_constants(ema_actuator_t* actuator);
/* The memory's actuator is the one that the constants were read from. */
uint32_t ema_selftest_model(ema_selftest_t* memory);
uint32_t ema_selftest_search(ema_selftest_t* memory);

typedef struct {
    uint32_t constants;
    uint32_t model;
    uint32_t search;
} ema_selftest_known_t;

/* ema_selftest with other expected values. */
ema_selftest_outcome_t ema_selftest_against(ema_selftest_t* memory, uint32_t build, const ema_selftest_known_t* known);

#endif
