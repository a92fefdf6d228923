/* A search of any configuration that ema_annealer_init accepts, and one cost told to it in any state: any bits in
 * costs, temperatures, steps and in the fit's memory, NaN too. Assumed of the state: the number of points kept is one
 * that is kept, the walk's coordinate is one of the search's, and the points lie in the box; that they still do
 * afterwards is asserted, so both hold for a whole search. */
#include "search/ema_quadratic.h"
#include "states.h"

static ema_annealer_t annealer;
static ema_annealer_config_t config;

static void ema_any_point(ema_annealer_point_t* point)
{
    EMA_ANY(*point);
    for (uint32_t i = 0; i < EMA_ANNEALER_DIMENSION_MAX; ++i) {
        point->x[i] = Frama_C_float_interval(0.0f, 1.0f);
    }
}

static void ema_one_dimension(uint32_t dimension)
{
    EMA_ANY(config);
    config.dimension = dimension;
    if (ema_annealer_init(&annealer, &config) != EMA_OK) {
        ema_leave();
    }
    const uint32_t wanted = (2U * ema_quadratic_unknowns(dimension)) + 2U;
    ema_real cost;
    //@ slevel merge;
    EMA_ANY(annealer);
    annealer.config = config;
    annealer.outcome = (ema_outcome_t)Frama_C_interval(EMA_OUTCOME_TOLERANCE, EMA_OUTCOME_COUNT);
    annealer.walked = Frama_C_interval(0, 1) != 0;
    annealer.coordinate = Frama_C_interval(0, (int)dimension - 1);
    ema_any_point(&annealer.current);
    ema_any_point(&annealer.best);
    ema_any_point(&annealer.candidate);
    for (uint32_t p = 0; p < EMA_ANNEALER_POINTS_MAX; ++p) {
        ema_any_point(&annealer.points[p]);
    }
    EMA_ANY(cost);
    /* still filling, or full: apart, since the place of the next point is a copy of the number */
    const uint32_t most = (wanted < EMA_ANNEALER_POINTS_MAX) ? wanted : EMA_ANNEALER_POINTS_MAX;
    annealer.point_count = (Frama_C_interval(0, 1) != 0) ? most : (uint32_t)Frama_C_interval(0, (int)most - 1);
    ema_annealer_tell(&annealer, cost);
    //@ slevel merge;
    for (uint32_t i = 0; i < EMA_ANNEALER_DIMENSION_MAX; ++i) {
        //@ assert in_the_box: \is_finite(annealer.candidate.x[i]) && 0.0 <= annealer.candidate.x[i] <= 1.0;
        //@ assert in_the_box: \is_finite(annealer.current.x[i]) && 0.0 <= annealer.current.x[i] <= 1.0;
        //@ assert in_the_box: \is_finite(annealer.best.x[i]) && 0.0 <= annealer.best.x[i] <= 1.0;
    }
    for (uint32_t p = 0; p < EMA_ANNEALER_POINTS_MAX; ++p) {
        for (uint32_t i = 0; i < EMA_ANNEALER_DIMENSION_MAX; ++i) {
            //@ assert in_the_box: \is_finite(annealer.points[p].x[i]) && 0.0 <= annealer.points[p].x[i] <= 1.0;
        }
    }
    //@ assert a_coordinate: annealer.coordinate < dimension;
    //@ assert kept: annealer.point_count <= EMA_ANNEALER_POINTS_MAX;
}

void main(void)
{
    const uint32_t dimension = (uint32_t)EMA_PROOF_DIMENSION;
    ema_one_dimension(dimension);
    Frama_C_show_each_end();
}
