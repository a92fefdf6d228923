/* Expected values are bits that every sound machine agrees on. They change with a parameter of the list, its nominal
 * value or range, and with the model's arithmetic: tests/unit/test_selftest.c then says the new ones. */
#include "ema/ema_selftest.h"

#include <float.h>
#include <stddef.h>
#include <string.h>

#include "ema/detail/ema_annealer.h"
#include "ema/detail/ema_random.h"

#include "base/ema_bounds.h"
#include "base/ema_math.h"
#include "session/ema_selftest_known.h"

#define EMA_SELFTEST_STEPS 700U
/* Steps from one end of the motion to the other, and how far apart they are. */
#define EMA_SELFTEST_TURN 150U
#define EMA_SELFTEST_STEP_MM EMA_R(0.03125)
#define EMA_SELFTEST_POINTS 16U
#define EMA_SEARCHED 3U
#define EMA_SEARCHED_BUDGET 60U
/* A thousandth of a second; from one row of the chirp that is asked for to the next. */
#define EMA_COMMANDED_STEP_S EMA_R(0.001)
#define EMA_COMMANDED_APART 131U

#if EMA_REAL64
#define EMA_LEAST_NORMAL DBL_MIN
#define EMA_NEAR_ONE EMA_R(7.4505805969238281e-9)
#else
#define EMA_LEAST_NORMAL FLT_MIN
#define EMA_NEAR_ONE EMA_R(2.44140625e-4)
#endif

/* Fowler, Noll and Vo's hash, variant 1a, by words of 32 bits. */
#define EMA_FOLD_START 2166136261U
#define EMA_FOLD_PRIME 16777619U

static uint32_t ema_fold(uint32_t hash, uint32_t word)
{
    return (hash ^ word) * EMA_FOLD_PRIME;
}

static uint32_t ema_fold_real(uint32_t hash, ema_real value)
{
#if EMA_REAL64
    uint64_t bits;
    (void)memcpy(&bits, &value, sizeof bits); /* EMA-D3 */
    return ema_fold(ema_fold(hash, (uint32_t)(bits & UINT32_MAX)), (uint32_t)(bits >> 32U));
#else
    uint32_t bits;
    (void)memcpy(&bits, &value, sizeof bits); /* EMA-D3 */
    return ema_fold(hash, bits);
#endif
}

/* Numbers are read at run time, or the compiler would work them out as it was built. */
static bool ema_arithmetic_holds(void)
{
    const volatile ema_real least = EMA_LEAST_NORMAL;
    const volatile ema_real half = EMA_R(0.5);
    const volatile ema_real one = EMA_R(1.0);
    const volatile ema_real half_step = EMA_REAL_EPSILON * EMA_R(0.5);
    const volatile ema_real near_one = one + EMA_NEAR_ONE;
    const volatile ema_real small = least * half;
    const volatile ema_real above = one + half_step;
    const volatile ema_real below = -one - half_step;
    const volatile ema_real next = (one + EMA_REAL_EPSILON) + half_step;
    const ema_real factor = near_one;
    const ema_real square = one + (EMA_R(2.0) * EMA_NEAR_ONE);
    /* what a contracted product keeps beyond its rounding */
    const volatile ema_real rest = (factor * factor) - square;
    const bool rounds =
        (small > EMA_R(0.0)) && (above == one) && (below == -one) && (next == (one + (EMA_R(2.0) * EMA_REAL_EPSILON)));
    return rounds && (rest == EMA_R(0.0));
}

uint32_t ema_selftest_constants(ema_actuator_t* actuator)
{
    uint32_t hash = EMA_FOLD_START;
    (void)ema_actuator_defaults(actuator);
    const ema_real* const value = (const ema_real*)(const void*)&actuator->params; /* EMA-D4 */
    for (uint32_t k = 0; k < (uint32_t)EMA_PARAM_COUNT; ++k) {
        ema_bounds_t bounds = {EMA_R(0.0), EMA_R(0.0)};
        (void)ema_bounds_of((ema_value_id_t)k, &bounds);
        hash = ema_fold_real(ema_fold_real(ema_fold_real(hash, value[k]), bounds.lower), bounds.upper);
    }
    for (uint32_t k = 0; k < EMA_INVERSE_COUNT; ++k) {
        hash = ema_fold_real(hash, ema_inverse[k]);
    }
    ema_random_t random;
    ema_random_init(&random, 1U, 1U);
    for (uint32_t k = 0; k < EMA_SELFTEST_POINTS; ++k) {
        const ema_real x = ema_random_normal(&random);
        hash = ema_fold_real(ema_fold_real(hash, ema_exp(x)), ema_log(ema_abs(x) + EMA_REAL_EPSILON));
        hash = ema_fold_real(ema_fold_real(hash, ema_sin(EMA_TURN_RAD * x)), ema_sin_turn64(ema_turn64(x)));
    }
    return hash;
}

uint32_t ema_selftest_model(ema_selftest_t* memory)
{
    uint32_t hash = EMA_FOLD_START;
    ema_status_t status = ema_model_init(&memory->model, &memory->actuator, EMA_R(0.0));
    ema_real command_mm = EMA_R(0.0);
    ema_real step_mm = EMA_SELFTEST_STEP_MM;
    for (uint32_t k = 0; (status == EMA_OK) && (k < EMA_SELFTEST_STEPS); ++k) {
        ema_output_t row;
        status = ema_model_step(&memory->model, command_mm, &row);
        hash = ema_fold_real(ema_fold_real(hash, row.position_mm), row.motor_position_mm);
        hash = ema_fold_real(ema_fold_real(hash, row.current_A), row.voltage_V);
        command_mm += step_mm;
        step_mm = ((k % EMA_SELFTEST_TURN) == (EMA_SELFTEST_TURN - 1U)) ? -step_mm : step_mm;
    }
    return ema_fold(hash, (uint32_t)status);
}

/* A search whose quadratic has all of its terms, and a chirp. */
static const ema_annealer_config_t ema_searched = {.dimension = EMA_SEARCHED,
                                                   .start = {[0] = EMA_R(0.2), [1] = EMA_R(0.4), [2] = EMA_R(0.9)},
                                                   .first_step = EMA_R(0.25),
                                                   .initial_temperature = EMA_R(0.1),
                                                   .cooling = EMA_R(0.95),
                                                   .function_tolerance = EMA_R(0.0),
                                                   .stall_evaluations = EMA_SEARCHED_BUDGET,
                                                   .reanneal_interval = 20U,
                                                   .evaluation_budget = EMA_SEARCHED_BUDGET,
                                                   .seed = 1U};
static const ema_command_config_t ema_commanded = {.kind = EMA_COMMAND_CHIRP,
                                                   .amplitude_mm = EMA_R(1.5),
                                                   .start_hz = EMA_R(0.3),
                                                   .end_hz = EMA_R(7.0),
                                                   .duration_s = EMA_R(2.0)};

/* Lowest inside the box, and skew, so that no term of the quadratic is idle. */
static ema_real ema_searched_cost(const ema_real* x)
{
    const ema_real first = x[0] - EMA_R(0.3);
    const ema_real second = x[1] - EMA_R(0.6);
    const ema_real third = x[2] - EMA_R(0.7);
    return (first * first) + (EMA_R(3.0) * second * second) + (EMA_R(0.5) * third * third)
           + (EMA_R(0.7) * first * second) - (EMA_R(0.3) * second * third);
}

uint32_t ema_selftest_search(ema_selftest_t* memory)
{
    uint32_t hash = EMA_FOLD_START;
    hash = ema_fold(hash, (uint32_t)ema_annealer_init(&memory->annealer, &ema_searched));
    while (ema_annealer_outcome(&memory->annealer) == EMA_OUTCOME_ACTIVE) {
        const ema_real* const x = ema_annealer_candidate(&memory->annealer);
        for (uint32_t k = 0; k < EMA_SEARCHED; ++k) {
            hash = ema_fold_real(hash, x[k]);
        }
        hash = ema_fold_real(hash, ema_annealer_limit(&memory->annealer));
        ema_annealer_tell(&memory->annealer, ema_searched_cost(x));
    }
    hash = ema_fold(hash, memory->annealer.info.from_quadratic);
    hash = ema_fold(hash, (uint32_t)ema_command_init(&memory->command, &ema_commanded, EMA_COMMANDED_STEP_S));
    for (uint32_t k = 0; k < EMA_SELFTEST_POINTS; ++k) {
        hash = ema_fold_real(hash, ema_command_at(&memory->command, k * EMA_COMMANDED_APART));
    }
    return hash;
}

ema_selftest_outcome_t ema_selftest_against(ema_selftest_t* memory, uint32_t build, const ema_selftest_known_t* known)
{
    ema_selftest_outcome_t found = EMA_SELFTEST_PASSED;
    if (build != EMA_SELFTEST_BUILD) {
        found = EMA_SELFTEST_LIBRARY;
    } else if (memory == NULL) {
        found = EMA_SELFTEST_NULL;
    } else if (!ema_arithmetic_holds()) {
        found = EMA_SELFTEST_ARITHMETIC;
    } else if (ema_selftest_constants(&memory->actuator) != known->constants) {
        found = EMA_SELFTEST_CONSTANTS;
    } else if (ema_selftest_model(memory) != known->model) {
        found = EMA_SELFTEST_MODEL;
    } else if (ema_selftest_search(memory) != known->search) {
        found = EMA_SELFTEST_SEARCH;
    } else {
        /* as on every other machine */
    }
    return found;
}

ema_selftest_outcome_t ema_selftest(ema_selftest_t* memory, uint32_t build)
{
    static const ema_selftest_known_t known = {EMA_CONSTANTS_KNOWN, EMA_MODEL_KNOWN, EMA_SEARCH_KNOWN};
    return ema_selftest_against(memory, build, &known);
}
