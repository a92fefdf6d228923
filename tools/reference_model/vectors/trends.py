"""Readings of units and what is said of them after some: the vectors of the trend. The source is the desk's reference, which works all readings out at once; the module goes reading by reading."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.fit.wear import outlook
from reference_model.vectors.parts import normal_draws

COLUMNS = ("odds", "now", "now_std", "by", "rate", "rate_std", "low", "median", "high", "reached", "drifts", "towards")
FALSE_ALARM = 0.01  # [chance]
TOLERANCE = {"f64": 2e-6, "f32": 5e-4}
WHY = (
    "float64: the fit of Mills' ratio, 5e-8, over the slope of the share that has reached the limit; float32: rounding of the"
    " covariance at each of up to 48 knots, 1e-4 in what was measured over 200 histories"
)
_DIGITS = 8  # of what is stored: the reference's libraries differ in the last bits between machines [precision]
_GRID = 64.0  # readings are whole sixty-fourths, which float32 holds [layout]


@dataclass(frozen=True)
class TrendCase:
    """One unit: what its value does by the day, over how many tests, in % with that scatter, and its limit."""

    name: str
    shows: str
    wear: Callable[[float], float]
    count: int
    every_days: float
    std: float
    limit: float
    looks: tuple[int, ...]
    first_day: float = 0.0


CASES = (
    TrendCase(
        "even", "wear that goes on, older readings joined", lambda day: 0.05 * max(0.0, day - 100.0), 70, 10.0, 0.75, 50.0, (6, 30, 48, 49, 70)
    ),
    TrendCase("steps", "three steps, and a reading far off", lambda day: 9.0 * (day // 150.0), 40, 12.0, 1.0, 40.0, (20, 40), 7300.0),
    TrendCase("falls", "a value that falls towards a limit below zero, faster and faster", lambda day: -((day / 60.0) ** 2), 30, 8.0, 0.5, -30.0, (12, 30)),
    TrendCase("still", "no wear, grease that runs in, two tests on one day", lambda day: 3.0 * math.exp(-day / 40.0), 36, 9.0, 0.5, 50.0, (36,)),
    TrendCase("beyond", "the limit lies behind it", lambda day: 0.4 * day, 20, 10.0, 1.0, 50.0, (20,)),
)  # fmt: skip


def readings(case: TrendCase) -> tuple[Reals, Reals, Reals]:
    """Days, values and standard errors, [count] each."""
    since: Reals = case.every_days * np.arange(case.count, dtype=np.float64)
    drawn = np.array([normal for stream in range(1 + case.count // 32) for normal in normal_draws(len(case.name), stream)])[: case.count]
    value = np.array([case.wear(float(day)) for day in since]) + case.std * drawn
    if case.name == "steps":
        value[15] += 25.0
    if case.name == "still":
        since[20] = since[19]
    return case.first_day + since, np.round(value * _GRID) / _GRID, np.full(case.count, case.std, dtype=np.float64)


def said(case: TrendCase) -> Reals:
    """What is said after each of the looks, [looks, columns]; -1 for a time that is open."""
    days, values, stds = readings(case)
    rows = []
    for count in case.looks:
        found = outlook(days[:count], values[:count], stds[:count], case.limit, FALSE_ALARM)
        if found is None:
            raise ValueError(f"{case.name}: nothing is said after {count} readings: look later")
        drift, life = found.drift, found.life
        times = [one if math.isfinite(one) else -1.0 for one in (life.low, life.median, life.high)]
        towards = drift.changed and drift.by / case.limit > 0.0
        numbers = (found.odds, life.now, found.now_std, drift.by, found.rate, found.rate_std, *times, life.reached, drift.changed, towards)
        rows.append([float(f"{float(one):.{_DIGITS}g}") for one in numbers])
    return np.array(rows)
