/* When one integration step resolves the effects that act over it, and where inside it that is looked at. */
#ifndef EMA_RESOLVE_H
#define EMA_RESOLVE_H

#include "ema/detail/ema_real.h"

/* How far the forces inside a step may be off an even rise to be taken for one, as a share of the torques at work; and
 * off the polynomial through four points where they are not even. Of the voltage a quarter as much, which has no twist.
 * What rises or twists more than is tame may be a ripple too fast for so few points, and has to fit at more. */
#define EMA_TOL_LINEAR EMA_R(1.0e-5)
#define EMA_TOL_POLYNOMIAL EMA_R(1.0e-3)
#define EMA_TOL_TWIST EMA_R(1.0e-3)
#define EMA_SHARE_OF_INPUT EMA_R(0.25)

/* A torque that bends by less than this share of its rise, and hardly twists, is no ripple too fast for four points;
 * and what the polynomial leaves of its bend, be it a kink, is less than the second share of it. */
#define EMA_TOL_BEND EMA_R(0.25)
#define EMA_TOL_BEND_RESIDUAL EMA_R(0.1)

/* Bend and twist, as in ema_response_t, of what is off an even rise at the nodes. */
#define EMA_BEND_OF_SUM EMA_R(2.5)
#define EMA_TWIST_OF_DIFFERENCE EMA_R(5.590169943749474)

/* A fraction s of a segment, there s (1 - s), and the integral of that up to there. */
typedef struct {
    ema_real at;
    ema_real bubble;
    ema_real turn;
} ema_node_t;

/* The inner two of the four points of Lobatto's rule, which integrates fifth powers; and two to look at afterwards: one
 * that shows an end that was predicted badly as well as what is left between the four, and the middle. */
static const ema_node_t ema_nodes[4] = {
    {EMA_R(0.27639320225002101), EMA_R(0.19999999999999998), EMA_R(0.03115841385833824)},
    {EMA_R(0.72360679774997894), EMA_R(0.20000000000000001), EMA_R(0.1355082528083284)},
    {EMA_R(0.90000000000000002), EMA_R(0.089999999999999983), EMA_R(0.16200000000000001)},
    {EMA_R(0.5), EMA_R(0.25), EMA_R(0.083333333333333329)},
};

#endif
