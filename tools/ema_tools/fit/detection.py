"""From which shift on a test sees it, at a chosen rate of false alarms: thresholds of CSJ and BLK, each alone and both together, by what the estimates scatter.

A reading of today is held against the mean of healthy runs, and the scatter is what those runs show beside what is usual, so thresholds are Student's for one value and Hotelling's for both
(H. Hotelling, Ann. Math. Statist. 2, 1931). The shape of the scatter of both together is known from the model's sensitivities, its size is shown by the runs; the joint test is then an F test
of as many degrees of freedom as the single ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, start_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import simulate_channels
from ema_tools.fit.interval import slopes

USUAL_WEIGHT = 2.0  # the usual scatter counts as much as this many healthy records that had shown it [judgement]
FALSE_ALARM = 0.01  # of ground tests of a healthy machine, unless told: what thresholds are made for [judgement]
POWER = 0.95  # share of shifts that are to be found, unless told [judgement]
_ALWAYS_ONE_SIDED = 2  # single tests that share the false alarms: CSJ and BLK, each upwards, since wear makes nothing smaller [physics]
UNSEEN_STDS = 3.0  # of what a machine may be today are stated where nothing shows them, as the module has it [chance]
_SMALL = 0.25  # of a standard deviation is a machine moved to see what shows it: less drowns in the model's events, more is not linear [precision]
_BLIND = 1e4  # %, the standard deviation of a value of which a record says nothing [precision]
_SELDOM = 1e-4  # a rate below this is not told more exactly [chance]
_QUANTILES = 400  # of the scatter that runs may show [precision]


def beyond(false_alarm: float) -> float:
    """Share of the readings of one healthy value that lie below its threshold, where the single tests share the false alarms."""
    return 1.0 - false_alarm / _ALWAYS_ONE_SIDED


@dataclass(frozen=True)
class ShiftTest:
    """A test at `false_alarm`, that finds a shift with `power`, by the scatter that `runs` healthy runs show; None where the scatter is known without."""

    false_alarm: float = FALSE_ALARM
    power: float = POWER
    runs: int | None = None

    @property
    def freedom(self) -> float:
        """Degrees of freedom of the scatter that is shown."""
        return math.inf if self.runs is None else USUAL_WEIGHT + self.runs - 1.0

    @property
    def widened(self) -> float:
        """By how much a reading scatters more against the mean of the healthy runs than about the truth."""
        return 1.0 if self.runs is None else math.sqrt(1.0 + 1.0 / self.runs)

    def threshold(self, tests: int = _ALWAYS_ONE_SIDED) -> float:
        """Of one value, in standard deviations of its scatter, where `tests` share the false alarms."""
        return float(self.widened * -_student(self.false_alarm / tests, self.freedom))

    def found(self, tests: int = _ALWAYS_ONE_SIDED) -> float:
        """The shift of one value, in standard deviations, that exceeds its threshold with `power`, on a machine whose scatter is the usual one."""
        limit = self.threshold(tests) / self.widened * self._shown()
        return self.widened * _shift(lambda shift: float(np.mean(special.ndtr(shift - limit))), self.power)

    def missed(self) -> float:
        """How many standard deviations above a threshold a shift must lie to be found with `power`."""
        return self.widened * float(special.ndtri(self.power))

    def exceeded(self, thresholds: Sequence[float]) -> float:
        """How often a healthy machine of the usual scatter exceeds one of these thresholds, in standard deviations of what is read of each value."""
        return float(min(1.0, sum(special.ndtr(-one / self.widened) for one in thresholds)))

    def threshold_together(self) -> float:
        """Of both together: the distance of their shift in standard deviations of its direction."""
        return self.widened * math.sqrt(self._squared())

    def found_together(self) -> float:
        """The distance that exceeds it with `power`, alike."""
        limit = self._squared() * self._shown() ** 2
        return self.widened * _shift(lambda shift: float(np.mean(1.0 - special.chndtr(limit, 2, shift**2))), self.power)

    def usual_false_alarms(self, tests: int = _ALWAYS_ONE_SIDED) -> float:
        """How often a machine whose scatter is the usual one exceeds one of its thresholds: more seldom than one of which nothing is known before its runs."""
        limit = self.threshold(tests) / self.widened * self._shown()
        return float(tests * np.mean(special.ndtr(-limit)))

    def usual_false_alarms_together(self) -> float:
        """The same of both together."""
        return float(np.mean(special.chdtrc(2, self._squared() * self._shown() ** 2)))

    def spread(self, is_stated: bool = False) -> float:
        """The standard deviation of a reading against the mean of the healthy runs whose normal 95 % interval holds, in standard deviations of the scatter that they show: what so few
        show of the scatter is not known better than their mean, unless it `is_stated`."""
        return self.widened if is_stated else self.widened**2

    def _shown(self) -> Reals:
        """The scatter that the runs show over the true one, where that is the usual: its quantiles, [k]."""
        if self.runs is None or self.runs < 2:
            return np.ones(1)
        places = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
        return np.asarray(np.sqrt((USUAL_WEIGHT + special.chdtri(self.runs - 1, 1.0 - places)) / self.freedom))

    def _squared(self) -> float:
        if self.runs is None:
            return float(special.chdtri(2, self.false_alarm))
        return 2.0 * float(special.fdtri(2, self.freedom, 1.0 - self.false_alarm))


def _student(share: float, freedom: float) -> float:
    """Below it lies this share of Student's distribution; of the normal one where the freedom has no end."""
    return float(special.stdtrit(freedom, share) if math.isfinite(freedom) else special.ndtri(share))


def _shift(share: Callable[[float], float], power: float) -> float:
    """The shift of which a test finds this share."""
    farthest = 1.0
    while share(farthest) < power:
        farthest *= 2.0
    return float(optimize.brentq(lambda shift: share(shift) - power, 0.0, farthest))


def false_alarms(threshold: float, runs: int, tests: int = _ALWAYS_ONE_SIDED) -> float:
    """How often a healthy machine exceeds one of its thresholds, of which each lies so many shown standard deviations off: what `ShiftTest.threshold` takes the other way."""
    test = ShiftTest(runs=runs)
    return float(min(1.0, tests * special.stdtr(test.freedom, -threshold / test.widened)))


def rate_text(share: float) -> str:
    """A rate of false alarms in words: what lies far out in the tail is not told exactly, since no few runs show that the scatter is normal there."""
    return f"less than {100.0 * _SELDOM:g} %" if share < _SELDOM else f"at most {100.0 * share:.2g} %"


@dataclass(frozen=True)
class Scatter:
    """How the estimates of `names` lie about the truth, in % of the healthy values: `noise` [n, n] by the sensors alone, `whole` with what differs from run to run. `today` [n]: how far they
    move for what a known machine may be today without anybody knowing, standard deviations; zero where nobody asked."""

    names: tuple[str, ...]
    noise: Reals
    whole: Reals
    today: Reals

    def std(self, name: str) -> float:
        """Standard deviation of one estimate, in %."""
        place = self.names.index(name)
        return math.sqrt(float(self.whole[place, place]))

    def noise_std(self, name: str) -> float:
        """The same by the sensors alone: what the onboard module states."""
        place = self.names.index(name)
        return math.sqrt(float(self.noise[place, place]))

    def alone(self, name: str) -> float:
        """Shift of one value alone, in %, that is one standard deviation of both together."""
        place = self.names.index(name)
        return 1.0 / math.sqrt(float(np.linalg.inv(self.whole)[place, place]))


def scatter_by_search(
    actuator: Actuator, record: Record, names: Sequence[str], noise: float, own_percent: Mapping[str, float], day_searched: bool
) -> Scatter:
    """Of a least-squares search by the rod position alone, as the onboard one, whose sensor has white `noise` (rms, mm, per row).

    `own_percent`: what each value itself differs by from run to run. With `day_searched` grease and winding are searched beside; what scatters and is not searched moves the estimates.
    """
    searched = [name for name in spreads.DAY if day_searched and name not in names and actuator[name] > 0.0]
    columns, moving = _columns(actuator, record, [*names, *searched], {"position_mm": 1.0})
    every = np.column_stack([columns[name] for name in (*names, *searched)])
    follow: Reals = np.asarray(np.linalg.pinv(every)[: len(names)], dtype=np.float64)
    found = _inverse(every.T @ every / noise**2)[: len(names), : len(names)]
    moved = np.column_stack([np.zeros(len(names)), *(follow @ column for column in moving.values())])
    followed = moved @ moved.T
    return Scatter(tuple(names), found, found + followed + _own(names, own_percent), _today(actuator, record, follow))


def _today(actuator: Actuator, record: Record, follow: Reals) -> Reals:
    """How far estimates that follow the rod position by `follow` [n, rows] move for what the machine may be today, in %, [n]."""
    start = start_of(actuator, record)
    here = simulate_channels(actuator, record, ("position_mm",), start)[0]

    def moved(spread: spreads.Spread) -> Reals:
        try:
            there = simulate_channels(actuator.changed(spread.changes(actuator, 1.0)), record, ("position_mm",), start)[0]
        except InputError:
            return np.zeros(len(follow))  # it cannot be so
        return np.asarray(follow @ (there - here))

    return np.asarray(np.sqrt(np.sum(np.square(each(moved, spreads.of_today(actuator))), axis=0)), dtype=np.float64)


def unseen_by_search(actuator: Actuator, record: Record, names: Sequence[str], shown_mm: float, day_searched: bool) -> Reals:
    """How far the same search may be off for what the machine may be today, in %, [n], while less of it than `shown_mm` (rms) stays in the rod position."""
    searched = [name for name in spreads.DAY if day_searched and name not in names and actuator[name] > 0.0]
    columns, _ = _columns(actuator, record, [*names, *searched], {"position_mm": 1.0})
    every = np.column_stack([columns[name] for name in (*names, *searched)])
    start = start_of(actuator, record)
    here = simulate_channels(actuator, record, ("position_mm",), start)[0]

    def hidden(spread: spreads.Spread) -> Reals:
        try:
            there = simulate_channels(actuator.changed(spread.changes(actuator, _SMALL)), record, ("position_mm",), start)[0]
        except InputError:
            return np.zeros(len(names))  # it cannot be so
        moved = (there - here) / _SMALL
        taken = np.linalg.pinv(every) @ moved
        left = float(np.sqrt(np.mean(np.square(moved - every @ taken))))
        deviations = min(UNSEEN_STDS, shown_mm / left) if left > 0.0 else UNSEEN_STDS
        return np.asarray(deviations * taken[: len(names)], dtype=np.float64)

    rest = [one for one in spreads.of_today(actuator) if one.title not in searched]
    return np.asarray(np.sqrt(np.sum(np.square(each(hidden, rest)), axis=0)), dtype=np.float64)


def scatter_by_signals(
    actuator: Actuator, record: Record, names: Sequence[str], noise: Mapping[str, float], own_percent: Mapping[str, float]
) -> Scatter:
    """The least that any unbiased estimate by the signals of `noise` (rms by name, per row) can have, with what else differs from run to run."""
    columns, moving = _columns(actuator, record, names, {name: std**-2.0 for name, std in noise.items()})
    every = np.column_stack([*(columns[name] for name in names), *moving.values()])
    known = np.diag([0.0] * len(names) + [1.0] * len(moving))
    found = _inverse(every.T @ every + known)[: len(names), : len(names)]
    return Scatter(tuple(names), found, found + _own(names, own_percent), np.zeros(len(names)))


def _own(names: Sequence[str], own_percent: Mapping[str, float]) -> Reals:
    return np.diag([own_percent.get(name, 0.0) ** 2 for name in names])


def _columns(
    actuator: Actuator, record: Record, names: Sequence[str], weights: Mapping[str, float]
) -> tuple[dict[str, Reals], dict[str, Reals]]:
    """How the weighted signals move per % of each value, and per standard deviation of what else scatters from run to run, by name."""
    scattering = [one for one in spreads.from_run_to_run(actuator) if one.title not in names and one.moves(actuator)]
    found = slopes(actuator, record, names, weights, scattering)
    moving = {one.title: one.in_unit(actuator) * found[one.title] for one in scattering}
    return {name: 0.01 * actuator[name] * found[name] for name in names}, moving


def _inverse(normal: Reals) -> Reals:
    """Covariance by a normal matrix per squared %, as far as one asks: where nothing moves it is that of `_BLIND`."""
    return np.asarray(np.linalg.inv(normal + np.eye(len(normal)) / _BLIND**2))
