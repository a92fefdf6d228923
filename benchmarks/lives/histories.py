"""Histories of units that wear by no law of the library, and of units that do not, as the benchmark of remaining life draws them.

Histories are of four kinds: even wear, wear that feeds on itself (its rate a power of what has worn, integrated), wear in jumps of random size at random times, and wear that stalls and goes
on; some begin with grease that runs in. A ground test comes every few days, and flights are missing in runs. Readings scatter with heavy tails (Student, 4 degrees of freedom), by a size that is
stated a tenth too small: between what BLK and CSJ scatter by from day to day over their limits, as measured on units of the truth plant (VERDICTS.md, usual scatter: 0.2 % where the limit is 100 %,
0.5 % where it is 50 %). Jumps are from 5 to the limit to as many as would each be as small as that scatter, by the logarithm: with fewer no reading tells of when, and more are even wear. Units that
do not wear are drawn beside them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals

KINDS = ("even", "feeding on itself", "jumps", "stalling")
LIMIT = 50.0  # % [judgement]
LONG = 12_000.0  # days that are simulated [effort]
UNDERSTATED = 1.1  # scatter, beside what is stated of it [judgement]
ONSETS = (0.0, 300.0)  # days before wear begins [judgement]
LENGTHS = (400.0, 1500.0)  # days from there to the limit, but for stalls and chance [judgement]
FED = 10.0  # % of wear by which the rate of wear that feeds on itself has doubled, were its power 1 [judgement]
POWERS = (0.5, 2.0)  # of what has worn, by which the rate of wear that feeds on itself rises [judgement]
JUMPS = (5, 80)  # to the limit: at least, and fewer than, by the logarithm [judgement]
STALLS = (0.2, 0.8)  # of the length: when wear stalls, and how long [judgement]
GREASED = 0.3  # share of the units whose grease runs in [judgement]
GREASES = (1.0, 4.0)  # % by which it falls [judgement]
FADES = (20.0, 80.0)  # days in which [judgement]


SCATTERS = (
    0.1,
    0.5,
)  # % by which readings scatter, by the logarithm: BLK's 0.21 % of a limit of 100 %, and CSJ's 0.50 % (docs/VERDICTS.md) [measured]
HARSH_SCATTERS = (0.35, 2.7)  # the same of days of four times the scatter and +-8 degC: BLK's 0.70 %, and CSJ's 2.7 % [measured]
EVERY = (2.0, 8.0)  # days from one ground test to the next, on the average of a unit [judgement]


@dataclass(frozen=True)
class Draw:
    """What of the drawing the accuracy may hang on: jumps to the limit, stalls, the readings' scatter in % and days between them."""

    jumps: tuple[int, int] = JUMPS
    stalls: tuple[float, float] = STALLS
    scatter: tuple[float, float] = SCATTERS
    every: tuple[float, float] = EVERY


GOALS = Draw()  # what the goals are stated for
AS_ABOVE, HARDER = "as above", "5 .. 19 jumps, every 6 .. 25 days, scatter 0.4 .. 1.5 %"
# The same with one thing otherwise, and with three that are harder, of which the ideal observer is asked, too [judgement]
OTHERWISE: Mapping[str, Draw] = {
    AS_ABOVE: GOALS,
    "scatter of harsh days, 0.35 .. 2.7 %": Draw(scatter=HARSH_SCATTERS),
    "readings a third as often, every 6 .. 25 days": Draw(every=(6.0, 25.0)),
    "5 .. 19 jumps to the limit": Draw(jumps=(5, 20)),
    "stalls of a tenth to three tenths of the length": Draw(stalls=(0.1, 0.3)),
    HARDER: Draw((5, 20), STALLS, (0.4, 1.5), (6.0, 25.0)),
}


def wear_of(kind: str, random: np.random.Generator, draw: Draw = GOALS) -> tuple[Reals, Reals, float]:
    """Days, wear in % and the day on which the limit is reached."""
    days = np.arange(0.0, LONG, 1.0)
    onset, length = random.uniform(*ONSETS), random.uniform(*LENGTHS)
    gone = np.maximum(days - onset, 0.0)
    if kind == "even":
        wear = LIMIT * gone / length
    elif kind == "feeding on itself":
        wear = _feeding(gone, length, random.uniform(*POWERS))
    elif kind == "jumps":
        wear = _jumps(days, onset, length, draw.jumps, random)
    else:
        wear = _stalls(gone, length, draw.stalls, random)
    if random.random() < GREASED:
        wear = wear - random.uniform(*GREASES) * -np.expm1(-days / random.uniform(*FADES))
    return days, wear, float(days[int(np.argmax(wear >= LIMIT))])


def _feeding(gone: Reals, length: float, exponent: float) -> Reals:
    """d wear = C (1 + wear / FED)^exponent, so that the limit is reached after `length`: time as a function of wear, turned round."""
    wear = np.linspace(0.0, 40.0 * LIMIT, 40_000)
    pace = (1.0 + wear / FED) ** -exponent
    time = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]))])
    return np.interp(gone, time * length / np.interp(LIMIT, wear, time), wear)


def _jumps(days: Reals, onset: float, length: float, to_limit: tuple[int, int], random: np.random.Generator) -> Reals:
    """Jumps at random times, as many as make the limit in about `length` days, of sizes that vary by their own mean."""
    jumps = int(by_logarithm(to_limit, random))
    count = int(4 * jumps * LONG / length)
    at = onset + np.cumsum(random.exponential(length / jumps, count))
    size = random.gamma(2.0, 0.5 * LIMIT / jumps, count)
    return np.concatenate([[0.0], np.cumsum(size)])[np.searchsorted(at, days, side="right")]


def _stalls(gone: Reals, length: float, stalls: tuple[float, float], random: np.random.Generator) -> Reals:
    """Even wear that stops once or twice for a while."""
    going = np.ones_like(gone)
    for _ in range(int(random.integers(1, 3))):
        start, lasts = random.uniform(*stalls) * length, random.uniform(*stalls) * length
        going[(gone > start) & (gone < start + lasts)] = 0.0
    return LIMIT / length * np.cumsum(going * (gone > 0.0))


def readings(days: Reals, wear: Reals, until: float, random: np.random.Generator, draw: Draw = GOALS) -> tuple[Reals, Reals, Reals]:
    """Days, readings in % and the standard errors that are stated, with missing flights in runs."""
    mean = random.uniform(*draw.every)
    at = np.cumsum(random.gamma(2.0, 0.5 * mean, int(2.0 * LONG / mean)))
    at = at[at <= until]
    kept = np.ones(at.size, dtype=bool)
    for _ in range(int(random.integers(0, 4))):
        start = int(random.integers(0, at.size + 1))
        kept[start : start + int(random.integers(2, 10))] = False
    at = at[kept]
    std = by_logarithm(draw.scatter, random)
    scatter = UNDERSTATED * std * random.standard_t(4, at.size) / math.sqrt(2.0)
    return at, np.interp(at, days, wear) + scatter, np.full(at.size, std)


def by_logarithm(ends: tuple[float, float], random: np.random.Generator) -> float:
    """A number between two ends, as likely in each of their decades."""
    return math.exp(random.uniform(math.log(ends[0]), math.log(ends[1])))
