/* A known answer, to be asked for at power-up before a session is trusted: does this library, on this processor as it
 * is set now, work out the very bits that every other one does?
 *
 *     static ema_selftest_t memory; (may lie where a session will lie afterwards)
 *     if (ema_selftest(&memory, EMA_SELFTEST_BUILD) != EMA_SELFTEST_PASSED) { no verdict }
 *
 * It does not replace a test of RAM, flash or the processor's own. It sees what a whole build or the processor's
 * settings change, and damage to the constants of model, search, its fit and the chirp. Not looked at: effects, which
 * differ between builds, and modes that the reference actuator does not have; the assessment after the search; single
 * files of those that were compiled otherwise than the rest (of what is run it sees them); the order of values in a
 * list whose length is the same; the configuration that is exported, which ema_actuator_check looks at.
 */
#ifndef EMA_SELFTEST_H
#define EMA_SELFTEST_H

#include "ema/ema_command.h"
#include "ema/ema_session.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum {
    EMA_SELFTEST_PASSED = 0,
    EMA_SELFTEST_NULL = 1,    /* no memory was given */
    EMA_SELFTEST_LIBRARY = 2, /* the caller was compiled with other headers, another EMA_REAL64, or other widths of
                               * enums and structures than the library: build both by the same flags */
    EMA_SELFTEST_ARITHMETIC =
        3,                      /* small numbers are flushed to zero, results are not rounded to nearest, or a product
                                 * and a sum are contracted: -ffp-contract=off, no part of -ffast-math, FPSCR or MXCSR at reset */
    EMA_SELFTEST_CONSTANTS = 4, /* nominal values, ranges, random numbers or elementary functions are not as built:
                                 * flash it again; after a change of the list see ema_selftest_known.h */
    EMA_SELFTEST_MODEL =
        5, /* a model run gives other bits than on any sound machine: likewise, and look at the flags */
    EMA_SELFTEST_SEARCH = 6 /* a search, its fit or a chirp does: likewise */
} ema_selftest_outcome_t;

/* What is run, one after the other. Means nothing before and after. */
typedef struct {
    ema_actuator_t actuator;
    union {
        ema_model_t model;
        ema_annealer_t annealer;
        ema_command_t command;
    };
} ema_selftest_t;

/* What the caller's headers say of the library: widths of the structures and how many values there are. */
#define EMA_SELFTEST_BUILD                                                                                             \
    ((((uint32_t)sizeof(ema_session_t) * 31U) + (uint32_t)sizeof(ema_session_config_t)) * 31U                          \
     + ((uint32_t)sizeof(ema_selftest_t) * 31U) + (uint32_t)EMA_VALUE_COUNT + ((uint32_t)EMA_REAL64 << 31U))

/* Runs the test; `build` is EMA_SELFTEST_BUILD. What is found first is told. Cost: 700 model steps, some of them with
 * reversals and both ends of the play; the drive stays within its limits; and 60 decisions of a search of three values:
 * docs/BUDGETS.md. */
ema_selftest_outcome_t ema_selftest(ema_selftest_t* memory, uint32_t build);

#ifdef __cplusplus
}
#endif

#endif
