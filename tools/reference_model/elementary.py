"""Sine, cosine, exponential, logarithm and power from additions and multiplications alone.

A library's functions differ in the last bit between machines; these do not, so that stored reference vectors can be
compared byte by byte. Error below 4e-16 of the largest value in reach (sine and cosine for |x| < 1e5), power below 1e-14.

Source: argument reduction after W. J. Cody and W. Waite, Software Manual for the Elementary Functions (1980); series of
Taylor (sine, cosine, exponential) and of the inverse hyperbolic tangent (logarithm).
"""

from __future__ import annotations

import math

from ema_tools.base.compiled import compiled

TWO_PI = 6.283185307179586
# pi/2 and ln 2 in parts whose products with a small whole number are exact.
_HALF_PI_1 = 1.5707963267341256
_HALF_PI_2 = 6.077100506303966e-11
_HALF_PI_3 = 2.0222662487959506e-21
_LN2_1 = 0.6931471804855391
_LN2_2 = 7.440617110012397e-11


@compiled
def _sine_series(x: float) -> float:
    square = x * x
    term = x
    total = 0.0
    order = 1.0
    while order < 20.0:
        total += term
        term = -term * square / ((order + 1.0) * (order + 2.0))
        order += 2.0
    return total


@compiled
def _cosine_series(x: float) -> float:
    square = x * x
    term = 1.0
    total = 0.0
    order = 0.0
    while order < 20.0:
        total += term
        term = -term * square / ((order + 1.0) * (order + 2.0))
        order += 2.0
    return total


@compiled
def sin(x: float) -> float:
    """Sine of `x` in rad."""
    quarters = math.floor(x / 1.5707963267948966 + 0.5)
    rest = ((x - quarters * _HALF_PI_1) - quarters * _HALF_PI_2) - quarters * _HALF_PI_3
    turn = quarters - 4.0 * math.floor(quarters / 4.0)
    if turn == 0.0:
        return _sine_series(rest)
    if turn == 1.0:
        return _cosine_series(rest)
    if turn == 2.0:
        return -_sine_series(rest)
    return -_cosine_series(rest)


@compiled
def cos(x: float) -> float:
    """Cosine of `x` in rad."""
    quarters = math.floor(x / 1.5707963267948966 + 0.5)
    rest = ((x - quarters * _HALF_PI_1) - quarters * _HALF_PI_2) - quarters * _HALF_PI_3
    turn = quarters - 4.0 * math.floor(quarters / 4.0)
    if turn == 0.0:
        return _cosine_series(rest)
    if turn == 1.0:
        return -_sine_series(rest)
    if turn == 2.0:
        return -_cosine_series(rest)
    return _sine_series(rest)


@compiled
def exp(x: float) -> float:
    """Exponential of `x`; 0 below -700."""
    if x < -700.0:
        return 0.0
    whole = math.floor(x / 0.6931471805599453 + 0.5)
    rest = (x - whole * _LN2_1) - whole * _LN2_2
    term = 1.0
    total = 0.0
    order = 1.0
    while order < 18.0:
        total += term
        term = term * rest / order
        order += 1.0
    return math.ldexp(total, int(whole))


@compiled
def log(x: float) -> float:
    """Natural logarithm of `x` > 0."""
    mantissa, exponent = math.frexp(x)
    if mantissa < 0.7071067811865476:
        mantissa = mantissa * 2.0
        exponent = exponent - 1
    ratio = (mantissa - 1.0) / (mantissa + 1.0)
    square = ratio * ratio
    power = ratio
    total = 0.0
    order = 1.0
    while order < 26.0:
        total += power / order
        power *= square
        order += 2.0
    return exponent * _LN2_1 + (2.0 * total + exponent * _LN2_2)


@compiled
def power(base: float, exponent: float) -> float:
    """`base` >= 0 to the power `exponent` > 0."""
    if base == 0.0:
        return 0.0
    return exp(exponent * log(base))
