"""Histories of other processes than those the benchmark's goals are stated for, with the same readings: a check that the filter's laws are not made for the latter.

Crack growth (Paris' law, its exponent from 1.5 to 4), wear that saturates on top of even wear, wear whose rate changes several times, and a gamma process.
"""

from __future__ import annotations

import numpy as np

from benchmarks.lives.histories import LIMIT, LONG, by_logarithm
from ema_tools.base.arrays import Reals

OTHER_KINDS = ("crack growth", "saturating", "changing rate", "gamma process")
_STARTS_AT_ONCE = 0.3  # share of the units that wear from the first day on [judgement]
_ONSET = 400.0  # days before wear begins at most [judgement]
_LENGTHS = (250.0, 2500.0)  # days from there to the limit, but for chance, by their logarithm [judgement]
_EXPONENTS = (1.5, 4.0)  # of Paris' law [physics]
_CRACKS = (8.0, 60.0)  # % that a crack has at first, by its logarithm [judgement]
_FAR = 1e4  # % beyond which a crack is not followed [layout]
_SATURATES = ((3.0, 20.0), (0.1, 0.5))  # % that saturate, and in which share of the length [judgement]
_RATES = (2, 5, 0.8)  # rates one after the other: at least, fewer than, scatter of their logarithm [judgement]
_SHAPES = (0.005, 0.2)  # of the gamma process in a day, by its logarithm: below one it jumps [judgement]


def other_wear(kind: str, random: np.random.Generator) -> tuple[Reals, Reals, float]:
    """Days, wear in % and the day on which the limit is reached."""
    days = np.arange(0.0, LONG)
    while True:
        onset = 0.0 if random.random() < _STARTS_AT_ONCE else random.uniform(0.0, _ONSET)
        length = by_logarithm(_LENGTHS, random)
        gone = np.maximum(days - onset, 0.0) / length
        if kind == "crack growth":
            wear = _crack(gone, random)
        elif kind == "saturating":
            part, time = random.uniform(*_SATURATES[0]), random.uniform(*_SATURATES[1])
            wear = part * -np.expm1(-gone / time) + (LIMIT - part) * gone
        elif kind == "changing rate":
            wear = _changing(gone, length, random)
        else:
            shape = by_logarithm(_SHAPES, random)
            wear = np.cumsum(random.gamma(shape, 1.0 / shape, days.size) * LIMIT / length * (gone > 0.0))
        if wear[-1] >= LIMIT:
            return days, wear, float(days[int(np.argmax(wear >= LIMIT))])


def _crack(gone: Reals, random: np.random.Generator) -> Reals:
    """d a = C a^(m / 2), which has grown by the limit after 1; in closed form."""
    rest = 1.0 - 0.5 * random.uniform(*_EXPONENTS)
    rest = rest if abs(rest) > 1e-3 else 1e-3
    first = by_logarithm(_CRACKS, random)
    inner = first**rest + ((first + LIMIT) ** rest - first**rest) * gone
    grown: Reals = np.maximum(inner, _FAR ** min(rest, -1e-3)) ** (1.0 / rest) - first
    return np.minimum(grown, _FAR)


def _changing(gone: Reals, length: float, random: np.random.Generator) -> Reals:
    """Rates that change at times as likely as any other."""
    count = int(random.integers(_RATES[0], _RATES[1]))
    rates = np.exp(random.normal(0.0, _RATES[2], count))
    turns = np.sort(random.uniform(0.0, 1.0, count - 1))
    return LIMIT / length * np.cumsum(rates[np.searchsorted(turns, gone)] * (gone > 0.0))
