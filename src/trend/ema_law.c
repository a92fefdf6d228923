#include "ema_law.h"

#include "ema/ema_trend.h"
#include "ema_math.h"

/* Places of onsets and stalls: twelfths. */
#define EMA_PARTS 12U
#define EMA_POWERS 4U
#define EMA_SHAPES 6U
#define EMA_FADES 2U
#define EMA_WALKS 4U
#define EMA_LAWS_STEADY (EMA_PARTS * EMA_SHAPES * EMA_FADES * EMA_WALKS)
/* A stall begins and ends at twelfths behind an onset at 0, 2/12, 4/12 or 6/12: 66, 45, 28 and 15 pairs. */
#define EMA_STALL_PAIRS 154U
#define EMA_STALL_WALKS 3U
#define EMA_LAWS_STALLING (EMA_STALL_PAIRS * EMA_STALL_WALKS)
_Static_assert((EMA_LAWS_STILL + EMA_LAWS_STEADY + EMA_LAWS_STALLING) == EMA_FORECAST_LAWS, "every law has a number");

/* E-foldings behind which it does not matter any more how far beyond the limit. */
#define EMA_FAR EMA_R(20.0)
/* Wear that slows down begins infinitely fast: its rate is told from here on. */
#define EMA_BEGUN EMA_R(0.001)

/* How wear rises, first powers, then e-foldings; how fast grease runs in; how wide the walk is. */
static const ema_real ema_shapes[EMA_SHAPES] = {EMA_R(0.5), EMA_R(1.0), EMA_R(1.6), EMA_R(2.5), EMA_R(2.0), EMA_R(5.0)};
static const ema_real ema_fades[EMA_FADES] = {EMA_R(0.0), EMA_R(0.1)};
static const ema_real ema_walks[EMA_WALKS] = {EMA_R(0.0), EMA_R(0.01), EMA_R(0.05), EMA_R(0.2)};

/* Logarithms of 1 / 2, 1 / (2 * 576) and 1 / (2 * 462): those that wear share one half each. */
#define EMA_STILL_LOG EMA_R(-0.6931471805599453)
#define EMA_STEADY_LOG EMA_R(-7.049254841255837)
#define EMA_STALLING_LOG EMA_R(-6.828712071641684)

static ema_real ema_part(uint32_t count)
{
    return (ema_real)count / (ema_real)EMA_PARTS;
}

static ema_law_t ema_steady(uint32_t number)
{
    const uint32_t shape = (number / (EMA_WALKS * EMA_FADES)) % EMA_SHAPES;
    ema_law_t law = {EMA_R(0.0), EMA_R(1.0), EMA_R(1.0), EMA_R(0.0),
                     EMA_R(0.0), EMA_R(0.0), EMA_R(0.0), EMA_STEADY_LOG};
    law.onset = ema_part(number / (EMA_WALKS * EMA_FADES * EMA_SHAPES));
    law.fade = ema_fades[(number / EMA_WALKS) % EMA_FADES];
    law.walk = ema_walks[number % EMA_WALKS];
    if (shape < EMA_POWERS) {
        law.power = ema_shapes[shape];
    } else {
        law.growth = ema_shapes[shape];
    }
    return law;
}

static ema_law_t ema_stalling(uint32_t number)
{
    uint32_t left = number / EMA_STALL_WALKS;
    uint32_t onset = 0U;
    uint32_t stall = 1U;
    /* so many ends has the stall that begins here */
    while (left >= (EMA_PARTS - stall)) {
        left -= EMA_PARTS - stall;
        ++stall;
        if (stall == EMA_PARTS) {
            onset += 2U;
            stall = onset + 1U;
        }
    }
    const ema_law_t law = {ema_part(onset), ema_part(stall), ema_part(stall + 1U + left),         EMA_R(1.0),
                           EMA_R(0.0),      EMA_R(0.0),      ema_walks[number % EMA_STALL_WALKS], EMA_STALLING_LOG};
    return law;
}

ema_law_t ema_law_of(uint32_t number)
{
    if (number < EMA_LAWS_STILL) {
        ema_law_t law = {EMA_R(0.0), EMA_R(1.0), EMA_R(1.0), EMA_R(0.0),
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

ema_real ema_law_risen(const ema_law_t* law, ema_real own_time)
{
    if (!(own_time > EMA_R(0.0))) {
        return EMA_R(0.0);
    }
    if (law->growth > EMA_R(0.0)) {
        return (ema_exp(ema_min(law->growth * own_time, EMA_FAR)) - EMA_R(1.0)) / (ema_exp(law->growth) - EMA_R(1.0));
    }
    return (law->power > EMA_R(0.0)) ? ema_exp(law->power * ema_log(own_time)) : EMA_R(0.0);
}

ema_real ema_law_rises(const ema_law_t* law, ema_real own_time)
{
    const ema_real begun = ema_max(own_time, EMA_BEGUN);
    if (law->growth > EMA_R(0.0)) {
        return law->growth * ema_exp(law->growth * begun) / (ema_exp(law->growth) - EMA_R(1.0));
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
