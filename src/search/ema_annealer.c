#include "ema/detail/ema_annealer.h"

#include <stddef.h>

#include "base/ema_copy.h"
#include "base/ema_math.h"
#include "search/ema_quadratic.h"

/* Step adaptation: at an acceptance rate of 0.44 growth and shrinkage balance. */
#define EMA_STEP_GROW EMA_R(1.75)
#define EMA_STEP_SHRINK EMA_R(0.644)
#define EMA_STEP_MIN EMA_R(1.0e-6)

/* Share of candidates that the quadratic proposes once it exists. */
#define EMA_QUADRATIC_SHARE EMA_R(0.8)

/* Share of the walk's candidates that are drawn from the whole range of their coordinate: the way out of a plateau. */
#define EMA_JUMP_SHARE EMA_R(0.15)

/* Candidates per dimension that are drawn from the whole box before the walk begins: a start on a plateau does no harm.
 */
#define EMA_SCOUTS_PER_DIMENSION 4U

#define EMA_TEMPERATURE_MAX EMA_R(1.0e30)

/* Larger than any cost: no limit yet. */
#define EMA_NO_COST EMA_R(3.0e38)

static bool ema_inside(ema_real value, ema_real lower, ema_real upper)
{
    return (value >= lower) && (value <= upper);
}

static bool ema_start_valid(const ema_real* start, uint32_t dimension)
{
    bool valid = true;
    for (uint32_t i = 0; valid && (i < dimension); ++i) {
        valid = ema_inside(start[i], EMA_R(0.0), EMA_R(1.0));
    }
    return valid;
}

static bool ema_config_valid(const ema_annealer_config_t* config)
{
    return (config->dimension >= 1U) && (config->dimension <= EMA_ANNEALER_DIMENSION_MAX)
           && ema_inside(config->first_step, EMA_STEP_MIN, EMA_R(1.0))
           && ema_inside(config->initial_temperature, EMA_R(1.0e-30), EMA_TEMPERATURE_MAX)
           && (config->cooling > EMA_R(0.0)) && (config->cooling < EMA_R(1.0))
           && ema_inside(config->function_tolerance, EMA_R(0.0), EMA_R(1.0e30)) && (config->stall_evaluations >= 1U)
           && (config->evaluation_budget >= 1U) && ema_start_valid(config->start, config->dimension);
}

/* Points kept: enough to average over, few enough to stay near the best. */
static uint32_t ema_points_wanted(uint32_t dimension)
{
    const uint32_t unknowns = ema_quadratic_unknowns(dimension);
    const uint32_t wanted = (2U * unknowns) + 2U;
    return (wanted < EMA_ANNEALER_POINTS_MAX) ? wanted : EMA_ANNEALER_POINTS_MAX;
}

/* Folds a coordinate back into the box as a mirror would. */
static ema_real ema_reflect(ema_real x)
{
    ema_real folded = x - (EMA_R(2.0) * ema_floor(EMA_R(0.5) * x));
    if (folded > EMA_R(1.0)) {
        folded = EMA_R(2.0) - folded;
    }
    return ema_clamp(folded, EMA_R(0.0), EMA_R(1.0));
}

static uint32_t ema_worst_point(const ema_annealer_t* annealer)
{
    uint32_t worst = 0U;
    for (uint32_t p = 1; p < annealer->point_count; ++p) {
        if (annealer->points[p].cost > annealer->points[worst].cost) {
            worst = p;
        }
    }
    return worst;
}

static void ema_annealer_propose(ema_annealer_t* annealer)
{
    const uint32_t dimension = annealer->config.dimension;
    ema_random_t* const random = &annealer->random;
    const ema_real source = ema_random_uniform(random);
    const bool scouting = annealer->info.evaluations <= (EMA_SCOUTS_PER_DIMENSION * dimension);
    ema_quadratic_t* const quadratic = &annealer->quadratic;
    annealer->walked = false;
    bool proposed = scouting;
    for (uint32_t i = 0; scouting && (i < dimension); ++i) {
        annealer->candidate.x[i] = ema_random_uniform(random);
    }
    if (!scouting && (source < EMA_QUADRATIC_SHARE) && ema_quadratic_fit(quadratic, annealer)) {
        ema_quadratic_draw(quadratic, annealer, random, annealer->candidate.x);
        proposed = true;
        ++annealer->info.from_quadratic;
    }
    if (!proposed) {
        const uint32_t i = annealer->coordinate;
        const bool jump = ema_random_uniform(random) < EMA_JUMP_SHARE;
        const ema_real draw = jump ? ema_random_uniform(random)
                                   : (annealer->current.x[i] + (annealer->step[i] * ema_random_normal(random)));
        ema_copy(&annealer->candidate, &annealer->current, sizeof annealer->candidate);
        annealer->candidate.x[i] = ema_reflect(draw);
        annealer->walked = !jump;
    }
    /* -log(u) > 0: with u drawn now, what will be accepted is known before the evaluation */
    annealer->accept_limit = annealer->current.cost - (annealer->temperature * ema_log(ema_random_uniform(random)));
    const bool filling = annealer->point_count < ema_points_wanted(dimension);
    const ema_real wanted = filling ? EMA_NO_COST : annealer->points[ema_worst_point(annealer)].cost;
    annealer->limit = ema_max(annealer->accept_limit, wanted);
}

/* Keeps the point if it is among the best. */
static void ema_annealer_keep(ema_annealer_t* annealer)
{
    uint32_t place = annealer->point_count;
    if (annealer->point_count < ema_points_wanted(annealer->config.dimension)) {
        ++annealer->point_count;
    } else {
        place = ema_worst_point(annealer);
        if (!(annealer->candidate.cost < annealer->points[place].cost)) {
            return;
        }
    }
    ema_copy(&annealer->points[place], &annealer->candidate, sizeof annealer->points[place]);
}

static void ema_annealer_reanneal(ema_annealer_t* annealer)
{
    const ema_real spread = annealer->points[ema_worst_point(annealer)].cost - annealer->best.cost;
    annealer->temperature = ema_max(annealer->temperature, spread);
    for (uint32_t i = 0; i < annealer->config.dimension; ++i) {
        annealer->step[i] =
            ema_max(annealer->step[i], ema_min(annealer->step[i] * EMA_R(4.0), annealer->config.first_step));
    }
    annealer->accepted_since = 0U;
    ++annealer->info.reannealed;
}

static void ema_annealer_decide(ema_annealer_t* annealer)
{
    /* before the first cost there is no limit either, and no cost is still none */
    const bool accepted =
        (annealer->candidate.cost < EMA_NO_COST) && (annealer->candidate.cost <= annealer->accept_limit);
    if (annealer->walked) {
        ema_real* const step = &annealer->step[annealer->coordinate];
        *step = ema_clamp(*step * (accepted ? EMA_STEP_GROW : EMA_STEP_SHRINK), EMA_STEP_MIN, EMA_R(1.0));
        annealer->coordinate = (annealer->coordinate + 1U) % annealer->config.dimension;
    }
    if (accepted) {
        annealer->info.accepted_uphill += (annealer->candidate.cost > annealer->current.cost) ? 1U : 0U;
        ema_copy(&annealer->current, &annealer->candidate, sizeof annealer->current);
        ++annealer->info.accepted;
        ++annealer->accepted_since;
    }
    if (annealer->candidate.cost < annealer->best.cost) {
        ema_copy(&annealer->best, &annealer->candidate, sizeof annealer->best);
    }
}

static ema_outcome_t ema_annealer_judge(ema_annealer_t* annealer)
{
    const ema_annealer_config_t* const config = &annealer->config;
    ema_outcome_t outcome = EMA_OUTCOME_ACTIVE;
    const bool cold = annealer->temperature <= config->function_tolerance;
    if ((annealer->stall_cost - annealer->best.cost) > config->function_tolerance) {
        annealer->stall_cost = annealer->best.cost;
        annealer->stall_start = annealer->info.evaluations;
    } else if (cold && ((annealer->info.evaluations - annealer->stall_start) >= config->stall_evaluations)) {
        outcome = EMA_OUTCOME_TOLERANCE;
    } else {
        /* still inside the window */
    }
    if ((outcome == EMA_OUTCOME_ACTIVE) && (config->accept_limit > 0U)
        && (annealer->info.accepted >= config->accept_limit)) {
        outcome = EMA_OUTCOME_COUNT;
    }
    if ((outcome == EMA_OUTCOME_ACTIVE) && (annealer->info.evaluations >= config->evaluation_budget)) {
        outcome = EMA_OUTCOME_BUDGET;
    }
    return outcome;
}

/* Nothing is known of the first candidate. */
static void ema_annealer_begin(ema_annealer_t* annealer)
{
    ema_copy(&annealer->current, &annealer->candidate, sizeof annealer->current);
    annealer->current.cost = EMA_NO_COST;
    ema_copy(&annealer->best, &annealer->current, sizeof annealer->best);
}

ema_status_t ema_annealer_init(ema_annealer_t* annealer, const ema_annealer_config_t* config)
{
    if ((annealer == NULL) || (config == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!ema_config_valid(config)) {
        return EMA_ERR_RANGE;
    }
    ema_clear(annealer, sizeof *annealer);
    ema_copy(&annealer->config, config, sizeof *config);
    ema_random_init(&annealer->random, config->seed, UINT64_C(54));
    for (uint32_t i = 0; i < config->dimension; ++i) {
        annealer->candidate.x[i] = config->start[i];
        annealer->step[i] = config->first_step;
    }
    ema_annealer_begin(annealer);
    annealer->stall_cost = EMA_NO_COST;
    annealer->temperature = config->initial_temperature;
    annealer->limit = EMA_NO_COST;
    annealer->accept_limit = EMA_NO_COST;
    annealer->outcome = EMA_OUTCOME_ACTIVE;
    return EMA_OK;
}

ema_status_t ema_annealer_restart(ema_annealer_t* annealer, const ema_real* start, ema_real temperature)
{
    if ((annealer == NULL) || (start == NULL)) {
        return EMA_ERR_NULL;
    }
    if (annealer->info.evaluations > 0U) {
        return EMA_ERR_ORDER;
    }
    if (!ema_start_valid(start, annealer->config.dimension)
        || !ema_inside(temperature, EMA_R(0.0), EMA_TEMPERATURE_MAX)) {
        return EMA_ERR_RANGE;
    }
    for (uint32_t i = 0; i < annealer->config.dimension; ++i) {
        annealer->config.start[i] = start[i];
        annealer->candidate.x[i] = start[i];
    }
    annealer->temperature = temperature;
    ema_annealer_begin(annealer);
    return EMA_OK;
}

const ema_real* ema_annealer_candidate(const ema_annealer_t* annealer)
{
    return annealer->candidate.x;
}

ema_real ema_annealer_limit(const ema_annealer_t* annealer)
{
    return annealer->limit;
}

void ema_annealer_tell(ema_annealer_t* annealer, ema_real cost)
{
    if (annealer->outcome != EMA_OUTCOME_ACTIVE) {
        return;
    }
    ++annealer->info.evaluations;
    annealer->last_cost = cost;
    const bool finite = ema_is_finite(cost);
    annealer->info.not_finite += finite ? 0U : 1U;
    /* a cost above the limit counts the same however far above it is */
    annealer->candidate.cost = (finite && (cost <= annealer->limit)) ? cost : EMA_NO_COST;
    ema_annealer_decide(annealer);
    if (annealer->candidate.cost < EMA_NO_COST) {
        ema_annealer_keep(annealer);
    }
    annealer->temperature *= annealer->config.cooling;
    if ((annealer->config.reanneal_interval > 0U) && (annealer->accepted_since >= annealer->config.reanneal_interval)) {
        ema_annealer_reanneal(annealer);
    }
    annealer->outcome = ema_annealer_judge(annealer);
    if (annealer->outcome == EMA_OUTCOME_ACTIVE) {
        ema_annealer_propose(annealer);
    }
}

ema_outcome_t ema_annealer_outcome(const ema_annealer_t* annealer)
{
    return annealer->outcome;
}

/* The limits of the rules, chosen on a design of settings and counted on another: docs/ROBUSTNESS.md. */

/* Evaluations that one dimension needs. */
#define EMA_FEWEST_PER_DIMENSION 30U

/* Times the resolution, at the most: the last temperature, and the tolerance. */
#define EMA_LAST_OVER_RESOLUTION EMA_R(30.0)
#define EMA_TOLERANCE_OVER_RESOLUTION EMA_R(100.0)

/* Times the tolerance, at the least: the first temperature. */
#define EMA_FIRST_OVER_TOLERANCE EMA_R(1.0e-3)

/* Accepted candidates between two reannealings at the least. */
#define EMA_REANNEAL_LEAST 10U

static bool ema_start_outside(const ema_annealer_config_t* config)
{
    bool outside = false;
    for (uint32_t i = 0; (i < config->dimension) && (i < EMA_ANNEALER_DIMENSION_MAX); ++i) {
        outside = outside || !((config->start[i] >= EMA_R(0.0)) && (config->start[i] <= EMA_R(1.0)));
    }
    return outside;
}

static uint32_t ema_warning_if(bool holds, uint32_t warning)
{
    return holds ? warning : 0U;
}

uint32_t ema_annealer_check(const ema_annealer_config_t* config, ema_real resolution)
{
    if (config == NULL) {
        return 0U;
    }
    uint32_t warnings = ema_warning_if(ema_start_outside(config), (uint32_t)EMA_WARNING_START);
    warnings |= ema_warning_if(config->evaluation_budget < (EMA_FEWEST_PER_DIMENSION * config->dimension),
                               (uint32_t)EMA_WARNING_FEW);
    warnings |= ema_warning_if((config->reanneal_interval > 0U) && (config->reanneal_interval < EMA_REANNEAL_LEAST),
                               (uint32_t)EMA_WARNING_REANNEALED);
    const bool known = (resolution > EMA_R(0.0)) && ema_is_finite(resolution);
    const ema_real first = config->initial_temperature;
    const ema_real tolerance = config->function_tolerance;
    warnings |= ema_warning_if(known && (tolerance > (EMA_TOLERANCE_OVER_RESOLUTION * resolution)),
                               (uint32_t)EMA_WARNING_TOLERANCE);
    warnings |= ema_warning_if(first < (EMA_FIRST_OVER_TOLERANCE * tolerance), (uint32_t)EMA_WARNING_COLD);
    const ema_real cold = EMA_LAST_OVER_RESOLUTION * (known ? resolution : tolerance);
    const bool falls = (first > cold) && (cold > EMA_R(0.0)) && ema_is_finite(first) && (config->cooling > EMA_R(0.0))
                       && (config->cooling < EMA_R(1.0));
    if (falls) {
        /* evaluations until the temperature is down */
        const ema_real fall = (ema_log(first) - ema_log(cold)) / -ema_log(config->cooling);
        warnings |= ema_warning_if(fall > (ema_real)config->evaluation_budget, (uint32_t)EMA_WARNING_HOT);
    }
    return warnings;
}

const char* ema_annealer_warning_text(uint32_t warning)
{
    const char* text;
    switch (warning) {
#define EMA_WARNING_CASE(name, bit, message)                                                                           \
    case (uint32_t)(name):                                                                                             \
        text = (message);                                                                                              \
        break;
        EMA_ANNEALER_WARNING_LIST(EMA_WARNING_CASE)
#undef EMA_WARNING_CASE
    default:
        text = "unknown warning";
        break;
    }
    return text;
}
