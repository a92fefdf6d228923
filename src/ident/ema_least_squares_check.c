/* Apart from ema_least_squares.c so that what is asked once takes no stack from the runs. */
#include "ident/ema_least_squares_check.h"

#include "base/ema_bounds.h"
#include "base/ema_math.h"
#include "ident/ema_record_row.h"

/* Smallest and largest noise that a signal may have. */
#define EMA_NOISE_MIN EMA_R(1.0e-9)
#define EMA_NOISE_MAX EMA_R(1.0e9)

ema_real ema_searched_with(const ema_searched_t* searched, const ema_actuator_t* actuator, ema_real value)
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

ema_status_t ema_least_squares_check(const ema_least_squares_config_t* config, const ema_record_t* record)
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

ema_real ema_squares_freedom(const ema_least_squares_t* self)
{
    return ((ema_real)self->cursor.record->count * (ema_real)self->channels) - (ema_real)self->config->count;
}

bool ema_squares_adequate(const ema_least_squares_t* self)
{
    const ema_real ratio = self->config->actuator->params.adequacy_ratio;
    return self->known && (self->best.square <= (ratio * ratio * ema_squares_freedom(self)));
}
