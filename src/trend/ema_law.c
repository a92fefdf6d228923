#include "ema_law.h"

#include "ema/ema_trend.h"
#include "ema_math.h"

/* Places of onsets and stalls: twelfths. */
#define EMA_PARTS 12U
#define EMA_POWERS 3U
#define EMA_GROWTHS 2U
#define EMA_POLES 3U
#define EMA_SHAPES (EMA_POWERS + EMA_GROWTHS + EMA_POLES)
#define EMA_FADES 2U
#define EMA_WALKS 3U
#define EMA_LAWS_STEADY (EMA_PARTS * EMA_SHAPES * EMA_FADES * EMA_WALKS)
/* An onset, a stall and its end are three twelfths of 0 .. 12, in order. */
#define EMA_LAWS_STALLING 286U
_Static_assert((EMA_LAWS_STILL + EMA_LAWS_STEADY + EMA_LAWS_STALLING) == EMA_FORECAST_LAWS, "every law has a number");

/* E-foldings behind which it does not matter any more how far beyond the limit. */
#define EMA_FAR EMA_R(20.0)
/* Wear that slows down begins infinitely fast: its rate is told from here on. */
#define EMA_BEGUN EMA_R(0.001)
/* Nearer to a pole it does not matter any more, either. */
#define EMA_POLE_LEAST EMA_R(0.001)

/* How wear rises: by powers, by e-foldings, towards poles; how fast grease runs in; how wide the walk is, and that
 * beside a stall. */
static const ema_real ema_powers[EMA_POWERS] = {EMA_R(0.7), EMA_R(1.0), EMA_R(1.6)};
static const ema_real ema_growths[EMA_GROWTHS] = {EMA_R(2.0), EMA_R(5.0)};
static const ema_real ema_poles[EMA_POLES] = {EMA_R(2.4), EMA_R(1.5), EMA_R(1.25)};
static const ema_real ema_fades[EMA_FADES] = {EMA_R(0.0), EMA_R(0.1)};
static const ema_real ema_walks[EMA_WALKS] = {EMA_R(0.0), EMA_R(0.04), EMA_R(0.2)};
#define EMA_STALL_WALK EMA_R(0.04)

/* Logarithms of 1 / 2, (3 / 4) / 576 and (1 / 4) / 286: of those that wear a quarter stalls. */
#define EMA_STILL_LOG EMA_R(-0.6931471805599453)
#define EMA_STEADY_LOG EMA_R(-6.643789733147672)
#define EMA_STALLING_LOG EMA_R(-7.042286171939743)

static ema_real ema_part(uint32_t count)
{
    return (ema_real)count / (ema_real)EMA_PARTS;
}

static ema_law_t ema_steady(uint32_t number)
{
    const uint32_t shape = (number / (EMA_WALKS * EMA_FADES)) % EMA_SHAPES;
    ema_law_t law = {EMA_R(0.0), EMA_R(1.0), EMA_R(1.0), EMA_R(0.0),    EMA_R(0.0),
                     EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_STEADY_LOG};
    law.onset = ema_part(number / (EMA_WALKS * EMA_FADES * EMA_SHAPES));
    law.fade = ema_fades[(number / EMA_WALKS) % EMA_FADES];
    law.walk = ema_walks[number % EMA_WALKS];
    if (shape < EMA_POWERS) {
        law.power = ema_powers[shape];
    } else if (shape < (EMA_POWERS + EMA_GROWTHS)) {
        law.growth = ema_growths[shape - EMA_POWERS];
    } else {
        law.pole = ema_poles[shape - (EMA_POWERS + EMA_GROWTHS)];
    }
    return law;
}

static ema_law_t ema_stalling(uint32_t number)
{
    uint32_t left = number;
    uint32_t onset = 0U;
    uint32_t stall = 1U;
    /* so many ends has the stall that begins here */
    while (left >= (EMA_PARTS - stall)) {
        left -= EMA_PARTS - stall;
        ++stall;
        if (stall == EMA_PARTS) {
            ++onset;
            stall = onset + 1U;
        }
    }
    const ema_law_t law = {ema_part(onset), ema_part(stall), ema_part(stall + 1U + left),
                           EMA_R(1.0),      EMA_R(0.0),      EMA_R(0.0),
                           EMA_R(0.0),      EMA_STALL_WALK,  EMA_STALLING_LOG};
    return law;
}

ema_law_t ema_law_of(uint32_t number)
{
    if (number < EMA_LAWS_STILL) {
        ema_law_t law = {EMA_R(0.0), EMA_R(1.0), EMA_R(1.0), EMA_R(0.0),   EMA_R(0.0),
                         EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_STILL_LOG};
        law.fade = ema_fades[number];
        return law;
    }
    const uint32_t wearing = number - EMA_LAWS_STILL;
    return (wearing < EMA_LAWS_STEADY) ? ema_steady(wearing) : ema_stalling(wearing - EMA_LAWS_STEADY);
}

ema_real ema_law_own_time(const ema_law_t* law, ema_real at)
{
    const ema_real gone = ema_max(at - law->onset, EMA_R(0.0));
    return gone - ema_clamp(at - law->stall, EMA_R(0.0), law->again - law->stall);
}

/* From half a twelfth before the edge to half a one behind it; one at the ends of the age is none. */
static ema_real ema_edge_passed(ema_real edge, ema_real at)
{
    if (!(edge > EMA_R(0.0)) || !(edge < EMA_R(1.0))) {
        return EMA_R(0.0);
    }
    return ema_clamp(((at - edge) * (ema_real)EMA_PARTS) + EMA_R(0.5), EMA_R(0.0), EMA_R(1.0));
}

ema_real ema_law_passed(const ema_law_t* law, ema_real at)
{
    return ema_edge_passed(law->onset, at) + ema_edge_passed(law->stall, at) + ema_edge_passed(law->again, at);
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
        return own_time * ((law->pole - EMA_R(1.0)) / ema_max(law->pole - own_time, EMA_POLE_LEAST));
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
        return law->pole * (law->pole - EMA_R(1.0)) / (left * left);
    }
    return law->power * ema_law_risen(law, begun) / begun;
}

ema_real ema_law_faded(const ema_law_t* law, ema_real at)
{
    return (law->fade > EMA_R(0.0)) ? (ema_exp(-at / law->fade) - EMA_R(1.0)) : EMA_R(0.0);
}

bool ema_law_stalls(const ema_law_t* law)
{
    return (law->stall < EMA_R(1.0)) && (law->again >= EMA_R(1.0));
}
