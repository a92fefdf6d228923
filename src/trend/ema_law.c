#include "trend/ema_law.h"

#include "base/ema_math.h"
#include "ema/ema_trend.h"

#define EMA_POWERS 2U
#define EMA_GROWTHS 7U
#define EMA_POLES 18U
#define EMA_POLES_FIRST 8U
#define EMA_SHAPES (EMA_POWERS + EMA_GROWTHS + EMA_POLES)
#define EMA_FADES 2U
#define EMA_WALKS 3U
/* Parts of the age at whose ends edges stand, and so many ways there are of three or five of them in order. */
#define EMA_PARTS_STEADY 8U
#define EMA_PARTS_ONCE 16U
#define EMA_PARTS_TWICE 8U
#define EMA_LAWS_STEADY (EMA_PARTS_STEADY * EMA_SHAPES * EMA_FADES * EMA_WALKS)
#define EMA_LAWS_ONCE 680U
#define EMA_LAWS_TWICE 126U
_Static_assert((EMA_LAWS_STILL + EMA_LAWS_STEADY + EMA_LAWS_ONCE + EMA_LAWS_TWICE) == EMA_FORECAST_LAWS,
               "every law has a number");

/* E-foldings behind which it does not matter any more how far beyond the limit. */
#define EMA_FAR EMA_R(20.0)
/* Wear that slows down begins infinitely fast: its rate is told from here on. */
#define EMA_BEGUN EMA_R(0.001)
/* Nearer to a pole it does not matter any more, either. */
#define EMA_POLE_LEAST EMA_R(0.001)

/* How wear rises: by powers, by e-foldings, towards poles, the first of them of order 1; how fast grease runs in; how
 * wide the walk is. */
static const ema_real ema_powers[EMA_POWERS] = {EMA_R(0.7), EMA_R(1.0)};
static const ema_real ema_growths[EMA_GROWTHS] = {EMA_R(0.7), EMA_R(1.1), EMA_R(1.5), EMA_R(2.0),
                                                  EMA_R(2.5), EMA_R(3.2), EMA_R(4.5)};
static const ema_real ema_poles[EMA_POLES] = {
    EMA_R(3.0), EMA_R(2.2), EMA_R(1.8), EMA_R(1.6), EMA_R(1.4), EMA_R(1.25), EMA_R(1.15), EMA_R(1.07), EMA_R(6.0),
    EMA_R(4.0), EMA_R(3.0), EMA_R(2.5), EMA_R(2.1), EMA_R(1.8), EMA_R(1.6),  EMA_R(1.4),  EMA_R(1.25), EMA_R(1.15)};
static const ema_real ema_fades[EMA_FADES] = {EMA_R(0.0), EMA_R(0.1)};
static const ema_real ema_walks[EMA_WALKS] = {EMA_R(0.0), EMA_R(0.04), EMA_R(0.2)};

/* Logarithms of 1 / 2, (3 / 4) / 1296, (1 / 8) / 680 and (1 / 8) / 126: of those that wear a quarter stalls. */
#define EMA_STILL_LOG EMA_R(-0.6931471805599453)
#define EMA_STEADY_LOG EMA_R(-7.454719949364001)
#define EMA_ONCE_LOG EMA_R(-8.601534339849989)
#define EMA_TWICE_LOG EMA_R(-6.915723448631314)

/* One that does not wear, and does not stall. */
static ema_law_t ema_plain(uint32_t parts, ema_real share_log)
{
    const ema_law_t law = {(ema_real)parts,
                           EMA_R(0.0),
                           {EMA_R(1.0), EMA_R(1.0)},
                           {EMA_R(1.0), EMA_R(1.0)},
                           EMA_R(0.0),
                           EMA_R(0.0),
                           EMA_R(0.0),
                           EMA_R(0.0),
                           EMA_R(0.0),
                           EMA_R(0.0),
                           share_log};
    return law;
}

static ema_law_t ema_steady(uint32_t number)
{
    const uint32_t shape = (number / (EMA_WALKS * EMA_FADES)) % EMA_SHAPES;
    ema_law_t law = ema_plain(EMA_PARTS_STEADY, EMA_STEADY_LOG);
    const uint32_t onset = number / (EMA_WALKS * EMA_FADES * EMA_SHAPES);
    law.onset = (ema_real)onset / law.parts;
    law.fade = ema_fades[(number / EMA_WALKS) % EMA_FADES];
    law.walk = ema_walks[number % EMA_WALKS];
    if (shape < EMA_POWERS) {
        law.power = ema_powers[shape];
    } else if (shape < (EMA_POWERS + EMA_GROWTHS)) {
        law.growth = ema_growths[shape - EMA_POWERS];
    } else {
        const uint32_t pole = shape - (EMA_POWERS + EMA_GROWTHS);
        law.pole = ema_poles[pole];
        law.order = (pole < EMA_POLES_FIRST) ? EMA_R(1.0) : EMA_R(2.0);
    }
    return law;
}

/* So many ways there are of `count` among `of`, which are at least as many. */
static uint32_t ema_ways(uint32_t of, uint32_t count)
{
    uint32_t ways = 1U;
    for (uint32_t k = 0U; k < count; ++k) {
        ways = (ways * (of - k)) / (k + 1U);
    }
    return ways;
}

/* Even wear with an onset and `stalls` stalls: that way, by its number, of as many edges in order among parts + 1. */
static ema_law_t ema_stalling(uint32_t number, uint32_t parts, uint32_t stalls, ema_real share_log)
{
    ema_law_t law = ema_plain(parts, share_log);
    law.power = EMA_R(1.0);
    uint32_t left = number;
    uint32_t place = 0U;
    const uint32_t edges = (2U * stalls) + 1U;
    for (uint32_t k = 0U; k < edges; ++k) {
        uint32_t ways = ema_ways(parts - place, edges - 1U - k);
        while (left >= ways) {
            left -= ways;
            ++place;
            ways = ema_ways(parts - place, edges - 1U - k);
        }
        const ema_real edge = (ema_real)place / law.parts;
        if (k == 0U) {
            law.onset = edge;
        } else if ((k % 2U) == 1U) {
            law.stall[k / 2U] = edge;
        } else {
            law.again[(k / 2U) - 1U] = edge;
        }
        ++place;
    }
    return law;
}

ema_law_t ema_law_of(uint32_t number)
{
    if (number < EMA_LAWS_STILL) {
        ema_law_t law = ema_plain(EMA_PARTS_STEADY, EMA_STILL_LOG);
        law.fade = ema_fades[number];
        return law;
    }
    const uint32_t wearing = number - EMA_LAWS_STILL;
    if (wearing < EMA_LAWS_STEADY) {
        return ema_steady(wearing);
    }
    const uint32_t stalling = wearing - EMA_LAWS_STEADY;
    return (stalling < EMA_LAWS_ONCE)
               ? ema_stalling(stalling, EMA_PARTS_ONCE, 1U, EMA_ONCE_LOG)
               : ema_stalling(stalling - EMA_LAWS_ONCE, EMA_PARTS_TWICE, EMA_LAW_STALLS, EMA_TWICE_LOG);
}

ema_real ema_law_own_time(const ema_law_t* law, ema_real at)
{
    ema_real gone = ema_max(at - law->onset, EMA_R(0.0));
    for (uint32_t k = 0U; k < EMA_LAW_STALLS; ++k) {
        gone -= ema_clamp(at - law->stall[k], EMA_R(0.0), law->again[k] - law->stall[k]);
    }
    return gone;
}

/* From half a part before the edge to half a one behind it; one at the ends of the age is none. */
static ema_real ema_edge_passed(const ema_law_t* law, ema_real edge, ema_real at)
{
    if (!(edge > EMA_R(0.0)) || !(edge < EMA_R(1.0))) {
        return EMA_R(0.0);
    }
    return ema_clamp(((at - edge) * law->parts) + EMA_R(0.5), EMA_R(0.0), EMA_R(1.0));
}

ema_real ema_law_passed(const ema_law_t* law, ema_real at)
{
    ema_real passed = ema_edge_passed(law, law->onset, at);
    for (uint32_t k = 0U; k < EMA_LAW_STALLS; ++k) {
        passed += ema_edge_passed(law, law->stall[k], at) + ema_edge_passed(law, law->again[k], at);
    }
    return passed;
}

/* (b / (b - u))^order - 1 by u / (b - u), so that nothing cancels. */
static ema_real ema_towards_pole(ema_real order, ema_real over)
{
    return (order > EMA_R(1.0)) ? (over * (over + EMA_R(2.0))) : over;
}

ema_real ema_law_risen(const ema_law_t* law, ema_real own_time)
{
    if (!(own_time > EMA_R(0.0))) {
        return EMA_R(0.0);
    }
    if (law->growth > EMA_R(0.0)) {
        return (ema_exp(ema_min(law->growth * own_time, EMA_FAR)) - EMA_R(1.0)) / (ema_exp(law->growth) - EMA_R(1.0));
    }
    if (law->pole > EMA_R(0.0)) {
        const ema_real over = own_time / ema_max(law->pole - own_time, EMA_POLE_LEAST);
        return ema_towards_pole(law->order, over) / ema_towards_pole(law->order, EMA_R(1.0) / (law->pole - EMA_R(1.0)));
    }
    return (law->power > EMA_R(0.0)) ? ema_exp(law->power * ema_log(own_time)) : EMA_R(0.0);
}

ema_real ema_law_rises(const ema_law_t* law, ema_real own_time)
{
    const ema_real begun = ema_max(own_time, EMA_BEGUN);
    if (law->growth > EMA_R(0.0)) {
        return law->growth * ema_exp(law->growth * begun) / (ema_exp(law->growth) - EMA_R(1.0));
    }
    if (law->pole > EMA_R(0.0)) {
        const ema_real left = law->pole - begun;
        const ema_real steep = (law->order > EMA_R(1.0)) ? (EMA_R(2.0) * (law->pole / left)) : EMA_R(1.0);
        return (steep * (law->pole / (left * left)))
               / ema_towards_pole(law->order, EMA_R(1.0) / (law->pole - EMA_R(1.0)));
    }
    return law->power * ema_law_risen(law, begun) / begun;
}

ema_real ema_law_faded(const ema_law_t* law, ema_real at)
{
    return (law->fade > EMA_R(0.0)) ? (ema_exp(-at / law->fade) - EMA_R(1.0)) : EMA_R(0.0);
}

ema_real ema_law_stalled_for(const ema_law_t* law)
{
    ema_real since = EMA_R(0.0);
    for (uint32_t k = 0U; k < EMA_LAW_STALLS; ++k) {
        if (law->again[k] >= EMA_R(1.0)) {
            since = ema_max(since, EMA_R(1.0) - law->stall[k]);
        }
    }
    return since;
}
