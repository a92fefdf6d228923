#include "ema/ema_least_squares.h"

#include <stddef.h>

#include "base/ema_bounds.h"
#include "base/ema_compiler.h"
#include "base/ema_copy.h"
#include "base/ema_linear.h"
#include "base/ema_math.h"
#include "ident/ema_cursor_step.h"
#include "ident/ema_record_row.h"
#include "ident/ema_residual.h"
#include "plant/ema_run.h"

/* Smallest and largest noise that a signal may have. */
#define EMA_NOISE_MIN EMA_R(1.0e-9)
#define EMA_NOISE_MAX EMA_R(1.0e9)

/* Value at the coordinate `x` of the unit box. */
static inline ema_real ema_searched_at(const ema_searched_t* searched, ema_real x)
{
    return searched->lower + (x * (searched->upper - searched->lower));
}

/* The companion's value where the searched value is `value`. */
static EMA_NOINLINE ema_real ema_searched_with(const ema_searched_t* searched, const ema_actuator_t* actuator,
                                               ema_real value)
{
    ema_real own = EMA_R(0.0);
    ema_real companion = EMA_R(0.0);
    (void)ema_actuator_get(actuator, searched->id, &own);
    (void)ema_actuator_get(actuator, searched->with, &companion);
    return (companion / own) * value;
}

/* Whether `lower` to `upper` lies inside the range of value `id`, which this build has. */
static bool ema_searched_within(ema_value_id_t id, ema_real lower, ema_real upper)
{
    ema_bounds_t bounds;
    return !ema_actuator_is_learned(id) && ema_bounds_of(id, &bounds) && (lower >= bounds.lower)
           && (upper <= bounds.upper);
}

static bool ema_searched_valid(const ema_searched_t* searched, const ema_actuator_t* actuator)
{
    ema_real own = EMA_R(0.0);
    bool valid = ema_searched_within(searched->id, searched->lower, searched->upper)
                 && (searched->start >= searched->lower) && (searched->start <= searched->upper);
    if (valid && (searched->with != searched->id)) {
        (void)ema_actuator_get(actuator, searched->id, &own);
        valid = (own != EMA_R(0.0)) && ((size_t)searched->with < EMA_VALUE_COUNT);
        if (valid) {
            const ema_real first = ema_searched_with(searched, actuator, searched->lower);
            const ema_real last = ema_searched_with(searched, actuator, searched->upper);
            valid = ema_searched_within(searched->with, ema_min(first, last), ema_max(first, last));
        }
    }
    return valid;
}

/* Errors: those of ema_least_squares_init except the model's. No address is NULL. */
static EMA_NOINLINE ema_status_t ema_least_squares_check(const ema_least_squares_config_t* config,
                                                         const ema_record_t* record)
{
    uint32_t channels = 0U;
    bool valid = (config->count >= 1U) && (config->count <= EMA_LEAST_SQUARES_MAX)
                 && (config->run_budget > config->count) && ema_record_weights(record, config->noise);
    for (uint32_t channel = 0; valid && (channel < EMA_CHANNEL_COUNT); ++channel) {
        if (config->noise[channel] > EMA_R(0.0)) {
            valid = (config->noise[channel] >= EMA_NOISE_MIN) && (config->noise[channel] <= EMA_NOISE_MAX);
            ++channels;
        }
    }
    for (uint32_t k = 0; valid && (k < config->count); ++k) {
        if (!(config->searched[k].lower < config->searched[k].upper)) {
            return EMA_ERR_BOUNDS;
        }
        valid = ema_searched_valid(&config->searched[k], config->actuator);
    }
    if (!valid) {
        return EMA_ERR_RANGE;
    }
    return ((record->count * channels) > config->count) ? EMA_OK : EMA_ERR_SHORT;
}

/* Number of compared values minus number of searched ones. */
static EMA_NOINLINE ema_real ema_squares_freedom(const ema_least_squares_t* self)
{
    return ((ema_real)self->cursor.record->count * (ema_real)self->channels) - (ema_real)self->config->count;
}

/* Whether the lowest point so far explains the record. */
static EMA_NOINLINE bool ema_squares_adequate(const ema_least_squares_t* self)
{
    const ema_real ratio = self->config->actuator->params.adequacy_ratio;
    return self->known && (self->best.square <= (ratio * ratio * ema_squares_freedom(self)));
}

/* Steps of the sensitivities, as shares of the bounds: the first; from then on so many standard errors of the value by
 * itself, large against rounding, small against what bends; and how small and large they may be. */
#define EMA_SQUARES_DELTA EMA_R(1.0e-3)
#define EMA_SQUARES_DELTA_ERRORS EMA_R(10.0)
#define EMA_SQUARES_DELTA_MIN EMA_R(1.0e-5)
#define EMA_SQUARES_DELTA_MAX EMA_R(2.0e-2)

/* Factor by which the first steps may be off before the first march is made anew. */
#define EMA_SQUARES_FAR_OFF EMA_R(2.0)

/* Damping of the first step, its factors after a step that kept its promise and after one that did not. */
#define EMA_DAMPING_FIRST EMA_R(1.0e-2)
#define EMA_DAMPING_FALL EMA_R(0.1)
#define EMA_DAMPING_RISE EMA_R(8.0)

/* Shares of the promise from which on a step kept it, and below which it did not. */
#define EMA_PROMISE_KEPT EMA_R(0.75)
#define EMA_PROMISE_BROKEN EMA_R(0.25)

/* Fall of the sum of squares that nothing is done for: of one standard error's, and of the sum itself, which is rounded
 * and whose runs are. */
#define EMA_FALL_LEAST EMA_R(1.0e-2)
#define EMA_FALL_ROUNDED EMA_REAL_EPSILON

/* Promise below which the sensitivities are taken to both sides: those to one side alone are off by what bends. */
#define EMA_FALL_FINE EMA_R(2.0)

/* Two descents end alike when their sums of squares differ by no more than this share; and so many that do are enough
 * where they explain the record, and where they do not. */
#define EMA_ALIKE_SQUARES EMA_R(1.0e-4)
#define EMA_ALIKE_ADEQUATE 2U
#define EMA_ALIKE_NOT 3U

/* What preparing a model or deciding on a step costs, in model steps without effects: a slice that has less left does
 * not begin it. */
#define EMA_SQUARES_STEPS 160U

/* Rows whose products are summed by themselves first. */
#define EMA_GATHERED_ROWS 64U

/* Further starts keep this share of the bounds off them, and what is nearer lies at the edge. */
#define EMA_START_MARGIN EMA_R(0.02)

/* Fractions of the square roots of the first primes. */
static const ema_real ema_start_turn[EMA_LEAST_SQUARES_MAX] = {EMA_R(0.41421356), EMA_R(0.73205081), EMA_R(0.23606798),
                                                               EMA_R(0.64575131), EMA_R(0.31662479), EMA_R(0.60555128),
                                                               EMA_R(0.12310563), EMA_R(0.35889894)};

_Static_assert(EMA_LEVMAR_MAX == EMA_LEAST_SQUARES_MAX, "a step moves all values");

/* The smallest fall of S that counts. */
static ema_real ema_squares_least(const ema_least_squares_t* self)
{
    return EMA_FALL_LEAST + (EMA_FALL_ROUNDED * self->present.square);
}

/* Puts value `k` of the actuator to the coordinate `x`, its companion with it. */
static void ema_squares_move(ema_least_squares_t* self, uint32_t k, ema_real x)
{
    const ema_searched_t* const searched = &self->config->searched[k];
    const ema_real value = ema_searched_at(searched, x);
    (void)ema_actuator_set(&self->actuator, searched->id, value);
    if (searched->with != searched->id) {
        (void)ema_actuator_set(&self->actuator, searched->with,
                               ema_searched_with(searched, self->config->actuator, value));
    }
}

/* A model of run `run` at the values that the actuator has. */
static bool ema_squares_model(ema_least_squares_t* self, uint32_t run)
{
    const bool made =
        ema_run_prepare(&self->plant[run], &self->state[run], &self->work, &self->actuator, self->start_mm) == EMA_OK;
    if (made) {
        /* tables are read where the configuration lies, so that a copy does not depend on its original */
        ema_plant_learned(&self->plant[run], self->config->actuator);
    }
    return made;
}

/* The model beside the present one that has value `k` moved: to the other side where the box or the model ends. Where
 * neither side has one it runs as the present one does, and shows no sensitivity. */
static void ema_squares_beside(ema_least_squares_t* self, uint32_t k)
{
    const ema_real x = self->present.x[k];
    ema_real delta = self->other_side ? -self->reach[k] : self->reach[k];
    bool made = false;
    for (uint32_t side = 0; !made && (side < 2U); ++side) {
        if (((x + delta) >= EMA_R(0.0)) && ((x + delta) <= EMA_R(1.0))) {
            ema_squares_move(self, k, x + delta);
            made = ema_squares_model(self, 1U + k);
        }
        self->delta[k] = made ? delta : EMA_R(0.0);
        delta = -delta;
    }
    ema_squares_move(self, k, x);
    if (!made) {
        ema_copy(&self->plant[1U + k], &self->plant[0], sizeof self->plant[0]);
        ema_copy(&self->state[1U + k], &self->state[0], sizeof self->state[0]);
    }
}

static void ema_squares_begin(ema_least_squares_t* self, ema_squares_phase_t phase)
{
    ema_cursor_start(&self->cursor, self->cursor.record, self->config->actuator);
    self->next_run = 0U;
    self->phase = phase;
}

/* Starts a march at `x`. */
static void ema_squares_go(ema_least_squares_t* self, const ema_real* x)
{
    ema_clear(&self->present, sizeof self->present);
    for (uint32_t k = 0; k < self->config->count; ++k) {
        self->present.x[k] = x[k];
    }
    self->failed = false;
    self->other_side = false;
    ema_squares_begin(self, EMA_SQUARES_PREPARING);
}

static void ema_squares_prepare(ema_least_squares_t* self)
{
    if (self->next_run == 0U) {
        for (uint32_t k = 0; k < self->config->count; ++k) {
            ema_squares_move(self, k, self->present.x[k]);
        }
        self->failed = !ema_squares_model(self, 0U);
    } else {
        ema_squares_beside(self, self->next_run - 1U);
    }
    ++self->next_run;
    if (self->failed) {
        self->phase = EMA_SQUARES_DECIDING;
    } else if (self->next_run > self->config->count) {
        ema_squares_begin(self, EMA_SQUARES_MARCHING);
    } else {
        /* the next one */
    }
}

/* Residual of a channel over its noise. */
static ema_real ema_squares_residual(const ema_least_squares_t* self, uint32_t channel, ema_real shown)
{
    const ema_record_t* const record = self->cursor.record;
    return (ema_record_at(record, self->cursor.row, (uint32_t)record->place[channel]) - shown)
           * self->inverse_noise[channel];
}

/* What came together over the last rows goes into the sum over all of them. */
static void ema_squares_gather(ema_squares_point_t* point)
{
    for (uint32_t k = 0; k < EMA_LEVMAR_TRIANGLE(EMA_LEAST_SQUARES_MAX); ++k) {
        point->normal[k] += point->part[k];
        point->part[k] = EMA_R(0.0);
    }
}

/* Adds one row to the sums once every run has passed it. */
static void ema_squares_row(ema_least_squares_t* self)
{
    const ema_record_t* const record = self->cursor.record;
    ema_squares_point_t* const point = &self->present;
    const ema_real residual_mm = ema_record_at(record, self->cursor.row, (uint32_t)record->place[EMA_CHANNEL_POSITION])
                                 - self->row_output[0].position_mm;
    if (!self->other_side) {
        ema_residual_row(&point->residual, residual_mm, self->cursor.row);
    }
    point->pushed[0] = point->pushed[0] || (self->state[0].play_side < 0);
    point->pushed[1] = point->pushed[1] || (self->state[0].play_side > 0);
    for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
        if (self->inverse_noise[channel] > EMA_R(0.0)) {
            const ema_real base = ema_output_channel(&self->row_output[0], channel);
            const ema_real residual = ema_squares_residual(self, channel, base);
            ema_real slope[EMA_LEAST_SQUARES_MAX];
            uint32_t at = 0U;
            if (!self->other_side) {
                const ema_real size = residual + (base * self->inverse_noise[channel]);
                point->size_square += size * size;
                ema_add_compensated(&point->square, &point->square_low, residual * residual);
            }
            for (uint32_t i = 0; i < self->config->count; ++i) {
                const ema_real moved = ema_output_channel(&self->row_output[1U + i], channel) - base;
                slope[i] = (self->delta[i] != EMA_R(0.0)) ? ((moved * self->inverse_noise[channel]) / self->delta[i])
                                                          : EMA_R(0.0);
                ema_add_compensated(&point->gradient[i], &point->gradient_low[i], slope[i] * residual);
                for (uint32_t j = 0; j <= i; ++j) {
                    point->part[at] += slope[i] * slope[j];
                    ++at;
                }
            }
        }
    }
    if ((self->cursor.row % EMA_GATHERED_ROWS) == (EMA_GATHERED_ROWS - 1U)) {
        ema_squares_gather(point);
    }
}

/* The mean of what was summed to both sides. */
static void ema_squares_mean(ema_squares_point_t* point)
{
    for (uint32_t k = 0; k < EMA_LEVMAR_TRIANGLE(EMA_LEAST_SQUARES_MAX); ++k) {
        point->normal[k] *= EMA_R(0.5);
    }
    for (uint32_t k = 0; k < EMA_LEAST_SQUARES_MAX; ++k) {
        point->gradient[k] *= EMA_R(0.5);
        point->gradient_low[k] *= EMA_R(0.5);
    }
}

/* At most `steps` model steps over all runs of the march; returns how many. */
static uint32_t ema_squares_march(ema_least_squares_t* self, uint32_t steps)
{
    uint32_t made = 0U;
    self->work.spent = 0U;
    while ((self->work.spent < steps) && !ema_cursor_ended(&self->cursor)) {
        ema_state_t* const state = &self->state[self->next_run];
        if (self->next_run == 0U) {
            self->command_mm = ema_record_asked(self->cursor.record, self->cursor.row, state->step);
        }
        /* between rows nothing reads them */
        ema_tick(&self->plant[self->next_run], state, &self->work, self->command_mm, &self->row_output[self->next_run]);
        ++made;
        ++self->next_run;
        if (self->next_run > self->config->count) {
            self->next_run = 0U;
            if (ema_cursor_row_due(&self->cursor)) {
                ema_squares_row(self);
            }
            ema_cursor_pass(&self->cursor);
        }
    }
    if (ema_cursor_ended(&self->cursor)) {
        ema_squares_point_t* const point = &self->present;
        ema_squares_gather(point);
        point->residual.weighted_square = point->square;
        for (uint32_t k = 0; k < self->config->count; ++k) {
            point->reach[k] = self->reach[k];
        }
        point->outside_ratio = self->state[0].outside_ratio;
        self->failed = !(point->square <= EMA_COST_MAX);
        if (self->other_side) {
            ema_squares_mean(point);
        }
        self->runs += 1U + self->config->count;
        self->tried = false;
        self->phase = EMA_SQUARES_DECIDING;
    }
    return made;
}

/* The same of the run that tries a step; it ends as soon as it is worse than the present point. */
static uint32_t ema_squares_try(ema_least_squares_t* self, uint32_t steps)
{
    uint32_t made = 0U;
    bool falls = true;
    self->work.spent = 0U;
    while (falls && (self->work.spent < steps) && !ema_cursor_ended(&self->cursor)) {
        ema_output_t* const output = &self->row_output[0];
        const ema_real command_mm = ema_record_asked(self->cursor.record, self->cursor.row, self->state[0].step);
        ema_tick(&self->plant[0], &self->state[0], &self->work, command_mm, output);
        ++made;
        if (ema_cursor_row_due(&self->cursor)) {
            for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
                if (self->inverse_noise[channel] > EMA_R(0.0)) {
                    const ema_real residual = ema_squares_residual(self, channel, ema_output_channel(output, channel));
                    ema_add_compensated(&self->trial_square, &self->trial_square_low, residual * residual);
                }
            }
            /* written so that NaN is worse */
            falls = self->trial_square < self->present.square;
        }
        ema_cursor_pass(&self->cursor);
    }
    if (!falls || ema_cursor_ended(&self->cursor)) {
        ++self->runs;
        self->tried = true;
        self->phase = EMA_SQUARES_DECIDING;
    }
    return made;
}

static void ema_squares_finish(ema_least_squares_t* self, ema_outcome_t outcome)
{
    self->outcome = outcome;
    self->phase = EMA_SQUARES_DONE;
}

/* Whether every value moved the signals at the present point: where none does, all descents end alike. */
static bool ema_squares_all_move(const ema_least_squares_t* self)
{
    bool all = !self->failed;
    for (uint32_t k = 0; k < self->config->count; ++k) {
        all = all && (self->present.normal[EMA_LEVMAR_TRIANGLE(k) + k] > EMA_R(0.0));
    }
    return all;
}

static bool ema_at_edge(ema_real x)
{
    return (x < EMA_START_MARGIN) || (x > (EMA_R(1.0) - EMA_START_MARGIN));
}

/* Whether a value lies at the edge of its bounds at the present point. */
static bool ema_squares_at_edge(const ema_least_squares_t* self)
{
    bool edge = false;
    for (uint32_t k = 0; k < self->config->count; ++k) {
        edge = edge || ema_at_edge(self->present.x[k]);
    }
    return edge;
}

/* Another descent: from the present point with the values at an edge put to the middle, or from the next of
 * the points that fill the box. */
static void ema_squares_again(ema_least_squares_t* self, bool from_edge)
{
    ema_real x[EMA_LEAST_SQUARES_MAX] = {0};
    for (uint32_t k = 0; k < self->config->count; ++k) {
        const ema_real turned = (ema_real)self->starts * ema_start_turn[k];
        const ema_real here = self->present.x[k];
        const bool kept = from_edge && !ema_at_edge(here);
        const ema_real part = from_edge ? EMA_R(0.5) : (turned - ema_floor(turned));
        x[k] = kept ? here : (EMA_START_MARGIN + ((EMA_R(1.0) - (EMA_R(2.0) * EMA_START_MARGIN)) * part));
        self->reach[k] = EMA_SQUARES_DELTA;
    }
    self->from_edge = from_edge;
    self->damping = EMA_DAMPING_FIRST;
    ++self->starts;
    ema_squares_go(self, x);
}

/* A descent has ended: that was it, or another one begins. */
static void ema_squares_descended(ema_least_squares_t* self)
{
    const ema_least_squares_config_t* const config = self->config;
    const bool edge = !self->failed && ema_squares_at_edge(self);
    const bool adequate = ema_squares_adequate(self);
    if (ema_squares_all_move(self) && !self->from_edge) {
        const ema_real apart = self->present.square - self->ended_square;
        const ema_real alike = EMA_ALIKE_SQUARES * self->ended_square;
        if (apart < -alike) {
            self->ended_alike = 1U;
        } else if (apart <= alike) {
            ++self->ended_alike;
        } else {
            /* a worse valley */
        }
        self->ended_square = ema_min(self->present.square, self->ended_square);
    }
    if ((adequate && !edge) || (self->ended_alike >= (adequate ? EMA_ALIKE_ADEQUATE : EMA_ALIKE_NOT))
        || (self->starts > config->restarts)) {
        ema_squares_finish(self, EMA_OUTCOME_TOLERANCE);
    } else if ((config->run_budget - self->runs) < (1U + config->count)) {
        ema_squares_finish(self, EMA_OUTCOME_BUDGET);
    } else {
        ema_squares_again(self, edge && !self->from_edge);
    }
}

/* The model of the step's end; false where there is none. */
static bool ema_squares_trial(ema_least_squares_t* self, const ema_real* step)
{
    for (uint32_t k = 0; k < self->config->count; ++k) {
        self->trial[k] = ema_clamp(self->present.x[k] + step[k], EMA_R(0.0), EMA_R(1.0));
        ema_squares_move(self, k, self->trial[k]);
    }
    self->trial_square = EMA_R(0.0);
    self->trial_square_low = EMA_R(0.0);
    return ema_squares_model(self, 0U);
}

/* The next step from the present point, by as much damping as it needs to promise something and to be a model; or the
 * end of the descent. */
static void ema_squares_propose(ema_least_squares_t* self)
{
    const uint32_t count = self->config->count;
    const ema_real least = ema_squares_least(self);
    const uint32_t left = self->config->run_budget - self->runs;
    if (left < (2U + count)) {
        ema_squares_finish(self, EMA_OUTCOME_BUDGET);
    } else {
        bool searching = true;
        while (searching) {
            ema_real step[EMA_LEAST_SQUARES_MAX] = {0};
            const ema_real promised = ema_levmar_step(self->present.normal, self->present.gradient, self->present.x,
                                                      count, self->damping, &self->solver, step);
            if (!self->other_side && (promised <= EMA_FALL_FINE) && (left > (2U * (2U + count)))) {
                searching = false;
                self->other_side = true;
                ema_squares_begin(self, EMA_SQUARES_PREPARING);
            } else if (promised <= least) {
                searching = false;
                ema_squares_descended(self);
            } else if (ema_squares_trial(self, step)) {
                searching = false;
                self->promised = promised;
                ema_squares_begin(self, EMA_SQUARES_TRYING);
            } else {
                self->damping *= EMA_DAMPING_RISE;
            }
        }
    }
}

/* Fits the steps of the sensitivities to what they are at the present point; whether one was far off. */
static bool ema_squares_reach(ema_least_squares_t* self)
{
    bool far_off = false;
    for (uint32_t k = 0; k < self->config->count; ++k) {
        const ema_real square = self->present.normal[EMA_LEVMAR_TRIANGLE(k) + k];
        if (square > EMA_R(0.0)) {
            const ema_real before = self->reach[k];
            self->reach[k] =
                ema_clamp(EMA_SQUARES_DELTA_ERRORS / ema_sqrt(square), EMA_SQUARES_DELTA_MIN, EMA_SQUARES_DELTA_MAX);
            far_off = far_off || (self->reach[k] > (EMA_SQUARES_FAR_OFF * before))
                      || (before > (EMA_SQUARES_FAR_OFF * self->reach[k]));
        }
    }
    return far_off;
}

/* What follows from a march or a trial. */
static void ema_squares_decide(ema_least_squares_t* self)
{
    if (self->failed) {
        ema_squares_descended(self);
    } else if (!self->tried) {
        self->first_square = self->known ? self->first_square : self->present.square;
        if (!self->known || (self->present.square <= self->best.square)) {
            self->best = self->present;
            self->known = true;
        }
        const bool first = self->runs == (1U + self->config->count);
        if (first && (self->config->run_budget >= (2U * self->runs)) && ema_squares_reach(self)) {
            ema_squares_go(self, self->best.x);
        } else {
            ema_squares_propose(self);
        }
    } else {
        const ema_real fall =
            (self->present.square - self->trial_square) + (self->present.square_low - self->trial_square_low);
        const ema_real kept = fall / self->promised;
        self->tried = false;
        if (!(fall > EMA_R(0.0))) {
            self->damping *= EMA_DAMPING_RISE;
            ema_squares_propose(self);
        } else if (fall <= ema_squares_least(self)) {
            ema_squares_descended(self);
        } else {
            if (kept >= EMA_PROMISE_KEPT) {
                self->damping = ema_max(self->damping * EMA_DAMPING_FALL, EMA_DAMPING_MIN);
            } else if (kept < EMA_PROMISE_BROKEN) {
                self->damping *= EMA_DAMPING_RISE;
            } else {
                /* as it is */
            }
            (void)ema_squares_reach(self);
            ema_squares_go(self, self->trial);
        }
    }
}

ema_status_t ema_least_squares_init(ema_least_squares_t* self, const ema_least_squares_config_t* config,
                                    const ema_record_t* record)
{
    if ((self == NULL) || (config == NULL) || (config->actuator == NULL) || (record == NULL)) {
        return EMA_ERR_NULL;
    }
    ema_status_t status = ema_least_squares_check(config, record);
    if (status == EMA_OK) {
        ema_real x[EMA_LEAST_SQUARES_MAX] = {0};
        ema_clear(self, sizeof *self);
        self->config = config;
        self->cursor.record = record;
        self->outcome = EMA_OUTCOME_ACTIVE;
        self->starts = 1U;
        self->damping = EMA_DAMPING_FIRST;
        self->ended_square = EMA_COST_MAX;
        self->start_mm = ema_start_mm(&config->actuator->params, record);
        ema_copy(&self->actuator, config->actuator, sizeof self->actuator);
        for (uint32_t channel = 0; channel < EMA_CHANNEL_COUNT; ++channel) {
            const bool compared = config->noise[channel] > EMA_R(0.0);
            self->inverse_noise[channel] = compared ? (EMA_R(1.0) / config->noise[channel]) : EMA_R(0.0);
            self->channels += compared ? 1U : 0U;
        }
        for (uint32_t k = 0; k < config->count; ++k) {
            const ema_searched_t* const searched = &config->searched[k];
            x[k] = ema_clamp((searched->start - searched->lower) / (searched->upper - searched->lower), EMA_R(0.0),
                             EMA_R(1.0));
            self->reach[k] = EMA_SQUARES_DELTA;
            ema_squares_move(self, k, x[k]);
        }
        status = ema_run_prepare(&self->plant[0], &self->state[0], &self->work, &self->actuator, self->start_mm);
        ema_squares_go(self, x);
    }
    return status;
}

ema_status_t ema_least_squares_run(ema_least_squares_t* self, uint32_t steps)
{
    if ((self == NULL) || (self->config == NULL)) {
        return EMA_ERR_NULL;
    }
    if (steps == 0U) {
        return EMA_ERR_RANGE;
    }
    uint32_t left = steps;
    while ((left > 0U) && (self->phase != EMA_SQUARES_DONE)) {
        uint32_t spent = EMA_SQUARES_STEPS;
        if (self->phase == EMA_SQUARES_MARCHING) {
            self->model_steps += ema_squares_march(self, left);
            spent = self->work.spent;
        } else if (self->phase == EMA_SQUARES_TRYING) {
            self->model_steps += ema_squares_try(self, left);
            spent = self->work.spent;
        } else if ((left < EMA_SQUARES_STEPS) && (left < steps)) {
            spent = left;
        } else if (self->phase == EMA_SQUARES_PREPARING) {
            ema_squares_prepare(self);
        } else {
            ema_squares_decide(self);
        }
        left = (left > spent) ? (left - spent) : 0U;
    }
    return EMA_OK;
}

bool ema_least_squares_done(const ema_least_squares_t* self)
{
    return (self != NULL) && (self->phase == EMA_SQUARES_DONE);
}

/* An estimate this close to a bound, as a share of the bounds, lies on it. */
#define EMA_AT_BOUND_SHARE EMA_R(5.0e-4)

/* Standard errors that a value may have, as a share of its bounds, so that its 95 % interval is shorter than half of
 * them. */
#define EMA_DETERMINED_SHARE EMA_R(0.1275)

/* Squared rounding of a sensitivity, over that of a signal, at the most: two runs are rounded, each by about half a
 * unit in the last place of what it shows and of what it adds up. Measured, of values that do the same in exact
 * numbers. */
#define EMA_SLOPE_ROUNDED EMA_R(64.0)

/* Share of value `k`'s sensitivities that may be rounding. */
static ema_real ema_collinearity_rounded(const ema_squares_point_t* point, uint32_t k, ema_real length)
{
    const ema_real moved = point->reach[k] * length;
    const ema_real rounded = (EMA_SLOPE_ROUNDED * EMA_REAL_EPSILON * EMA_REAL_EPSILON) * point->size_square;
    return (moved > EMA_R(0.0)) ? (rounded / (moved * moved)) : EMA_R(1.0);
}

/* Standard error for a variance of one, as a share of the bounds. */
static ema_real ema_collinearity_error(const ema_collinearity_t* apart, ema_real rounded)
{
    const bool told = (apart->length > EMA_R(0.0)) && (apart->share > ema_max(rounded, EMA_PIVOT_SHARE));
    return told ? (EMA_R(1.0) / (apart->length * ema_sqrt(apart->share))) : EMA_COST_MAX;
}

static ema_determined_t ema_collinearity_determined(const ema_collinearity_t* apart, ema_real error)
{
    ema_determined_t determined = EMA_DETERMINED;
    if (!((apart->length * EMA_DETERMINED_SHARE) >= EMA_R(1.0))) {
        determined = EMA_DETERMINED_NOT;
    } else if (!(error <= EMA_DETERMINED_SHARE)) {
        determined = EMA_DETERMINED_TOGETHER;
    } else {
        /* by itself */
    }
    return determined;
}

ema_status_t ema_least_squares_result(const ema_least_squares_t* self, ema_least_squares_result_t* result)
{
    if ((self == NULL) || (result == NULL)) {
        return EMA_ERR_NULL;
    }
    if (!self->known) {
        return (self->phase == EMA_SQUARES_DONE) ? EMA_ERR_DIVERGED : EMA_ERR_ORDER;
    }
    const ema_squares_point_t* const best = &self->best;
    const uint32_t rows = self->cursor.rows;
    const ema_real freedom = ema_squares_freedom(self);
    ema_clear(result, sizeof *result);
    result->count = self->config->count;
    result->misfit_before = ema_sqrt(self->first_square / freedom);
    result->misfit_after = ema_sqrt(best->square / freedom);
    result->residual_rms_mm = ema_sqrt(best->residual.position_square / (ema_real)rows);
    result->residual_correlation = ema_residual_correlation(&best->residual);
    result->outside_ratio = best->outside_ratio;
    result->crossed = best->pushed[0] && best->pushed[1];
    result->adequate = ema_squares_adequate(self);
    result->runs = self->runs;
    result->starts = self->starts;
    result->model_steps = self->model_steps;
    result->outcome = self->outcome;
    const ema_real variance =
        ema_residual_variance(&best->residual, freedom, ema_residual_widening(result->residual_correlation));
    const ema_real shared =
        ema_residual_shared(&best->residual, rows, result->residual_correlation, EMA_R(0.0)) * best->square;
    for (uint32_t k = 0; k < result->count; ++k) {
        const ema_searched_t* const searched = &self->config->searched[k];
        const ema_collinearity_t apart = ema_levmar_collinearity(best->normal, result->count, k);
        const ema_real range = searched->upper - searched->lower;
        const ema_real error = ema_collinearity_error(&apart, ema_collinearity_rounded(best, k, apart.length));
        ema_found_t* const found = &result->value[k];
        found->estimate = ema_searched_at(searched, best->x[k]);
        found->determined = ema_collinearity_determined(&apart, error);
        found->partner = apart.partner;
        found->at_bound = (best->x[k] < EMA_AT_BOUND_SHARE) || (best->x[k] > (EMA_R(1.0) - EMA_AT_BOUND_SHARE));
        found->noise_std = (error < EMA_COST_MAX) ? (error * range) : EMA_COST_MAX;
        found->std = (error < EMA_COST_MAX) ? (error * ema_sqrt(variance) * range) : EMA_COST_MAX;
        found->bias = (error < EMA_COST_MAX) ? (EMA_BIAS_SHARE * error * ema_sqrt(shared) * range) : EMA_COST_MAX;
    }
    return EMA_OK;
}
