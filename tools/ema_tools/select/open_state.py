"""How far CSJ and BLK may be off for what the machine may be today without anybody knowing: winding, grease, magnets, supply, gain, inverter.

By slopes at the fit where the signals tell such a state apart. Where it moves the answer much, slopes do not settle that: reversals jump a step, and what is left between two slopes that are alike
is as large as what would tell one from the other. There the model is fitted with the state at two sizes, and the costs of these fits say how far it may go (a profile of the likelihood; S. A. Murphy
and A. W. van der Vaart, J. Am. Stat. Assoc. 95, 2000).

How uncertain a value is hangs there on how far such a state usually goes. A machine may be farther off than usual today; so a size that is told reaches, besides, over every value at which
a state up to `_FARTHEST` of its usual deviations explains the record as well.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.nuisance import Spread
from ema_tools.select.known_machine import LAST_STEPS, SMALL_SHARE, KnownMachine, MachineFit
from ema_tools.select.strategies.strategy import LEAST_LIMIT

_STEP = 0.02  # of a value, for its slope: large against reversals that jump a step [precision]
_TOLD = 10.0  # a state of one standard deviation that costs more is told by the record, and slopes say how well: what reversals leave between them is less [precision]
_SURELY_TOLD = 1e4  # and one that costs so much by the slopes does so by whatever reversals leave between them, which is 2000 on a slow triangle of small stroke [measured]
_MUCH = 0.01  # of a value: what moves it by less, one standard deviation of it, is left to the slopes [judgement]
_FARTHEST = 6.0  # of a state's standard deviations: a drop of 0.6 V in the inverter, a gain 12 % off [judgement]
_FAR = (3.0, _FARTHEST)  # sizes that are fitted to learn how far a state may go [effort]
_APART = 0.1  # of a state's standard deviation: nearer to a size that is fitted, another one shows nothing [precision]
_FINE = 121  # places along a state at which costs and values are read off [precision]
_AS_WELL = 4.0  # of the cost: a value of 95 % certainty leaves no more above the best [chance]


@dataclass(frozen=True)
class Reach:
    """How far `below` and `above` a value those lie that a state beyond its usual deviations would make, and that explain the record as well; `by`: the state that goes farthest."""

    below: float = 0.0
    above: float = 0.0
    by: str = ""

    @classmethod
    def of(cls, value: float, ends: Mapping[str, tuple[float, float]]) -> Reach:
        """From the least and the largest value of each state, by its name; not a number where there is none."""
        off = {title: (value - least, most - value) for title, (least, most) in ends.items() if math.isfinite(least)}
        below, above = (max([0.0, *(pair[side] for pair in off.values())]) for side in (0, 1))
        return cls(below, above, max(off, key=lambda title: max(off[title])))


@dataclass(frozen=True)
class OpenStd:
    """A standard error, what of the machine's present state does most to it, by name, and its part that is not noise; `moved`: by how much the value would be another if what the record itself
    says of that state were fitted beside it; `reach`: how far it may be off where that state is beyond its usual deviations. `pulled`: as `moved` of a state that surely explains more than none of
    it does: the reach holds that for a size, to its side, and a verdict has to count it.
    """

    std: float
    most: str
    beyond: float = 0.0
    moved: float = 0.0
    reach: Reach = Reach()
    pulled: float = 0.0

    def doubt(self, sure: float, healthy: float) -> float:
        """How far a shift may be off for what the machine may be today, relative to the `healthy` value; `sure`: in so many standard deviations."""
        return (sure * self.std + self.moved + self.pulled) / abs(healthy)


@dataclass(frozen=True)
class _Profile:
    """What a state does to each fault, by name: by how much it would be another where the record says it is, and how uncertain that is, standard deviations."""

    moved: Mapping[str, float]
    std: Mapping[str, float]


@dataclass(frozen=True)
class _Sizes:
    """The fits beside one state: its sizes, in its standard deviations, none among them, in their order."""

    state: Spread
    sizes: tuple[float, ...]
    fits: tuple[MachineFit, ...]

    def with_fits(self, others: Sequence[tuple[float, MachineFit | None]]) -> _Sizes:
        """With more of them; those that the model refused are left out."""
        both = sorted(
            [*zip(self.sizes, self.fits, strict=True), *((size, fit) for size, fit in others if fit is not None)], key=lambda one: one[0]
        )
        return replace(self, sizes=tuple(size for size, _ in both), fits=tuple(fit for _, fit in both))

    def as_well(self, name: str, best: float, limit: float) -> tuple[float, float]:
        """The least and the largest value of `name` at which this state leaves no more than `limit` above the cost `best`; between two sizes by straight lines. Not a number where none does."""
        costs = np.array([one.cost for one in self.fits]) - best
        values = np.array([one.values[name] for one in self.fits])
        fine = np.union1d(np.linspace(self.sizes[0], self.sizes[-1], _FINE), self.sizes)
        inside = np.interp(fine, self.sizes, values)[np.interp(fine, self.sizes, costs) <= limit]
        return (float(inside.min()), float(inside.max())) if inside.size else (math.nan, math.nan)


def open_state(known: KnownMachine, base: MachineFit, left: float = 0.0) -> dict[str, OpenStd]:
    """Standard errors of CSJ and BLK where the machine may be today as far from what is known of it as machines go, by name; with a cost `left` that may lie along either of them."""
    here = known.residual(base.values)
    machine = known.actuator.changed(base.values)
    wanted = [one for one in spreads.of_today(machine) if not set(one.names) & set(known.faults)]
    own, today = _slopes(known, base, here, wanted)
    apart = [_apart(own, column) for column in today]
    left_open = [one for one, (follows, rest) in zip(wanted, apart, strict=True) if _left_open(known, base, follows, rest)]
    farther = [
        one for one, (follows, rest) in zip(wanted, apart, strict=True) if one in left_open or _wanted(known, base, follows, rest, here)
    ]
    near = _near(known, base, machine, farther)
    surely = [one for one in near if _takes_off(one, base, LEAST_LIMIT)]
    elsewhere = [_profile(known, base, one) for one in surely]
    profiles = {
        one.state.title: _profile(known, base, one) for one in near if one not in surely and one.state in left_open and _is_open(one, base)
    }
    reach = _reach(known, base, machine, [one for one in near if one.state.title in profiles or _takes_off(one, base)])
    found = {}
    for place, name in enumerate(known.faults):
        alone = [_marginal(own, [column], place) for column in today]
        worst = wanted[int(np.argmax(alone))].title if wanted else ""
        along = math.sqrt(left / float(own[place] @ own[place])) if left > 0.0 else 0.0
        noise = _marginal(own, [], place)
        by_profile = {title: one.std[name] for title, one in profiles.items()}
        if by_profile:
            worst = max(by_profile, key=lambda title: by_profile[title])
        std = math.hypot(max(_marginal(own, today, place), math.hypot(noise, *by_profile.values())), along)
        moved = max((abs(one.moved[name]) for one in profiles.values()), default=0.0)
        pulled = max((abs(one.moved[name]) for one in elsewhere), default=0.0)
        found[name] = OpenStd(std, worst, math.sqrt(max(std**2 - noise**2, 0.0)), moved, reach[name], pulled)
    return found


def std_by_data_sheet(known: KnownMachine, base: MachineFit) -> dict[str, float]:
    """Standard errors of CSJ and BLK themselves, by name, on a machine of which nothing but its data sheet and this record is known."""
    sheet = [one for one in spreads.from_data_sheet(known.actuator.changed(base.values)) if not set(one.names) & set(known.faults)]
    own, columns = _slopes(known, base, known.residual(base.values), sheet)
    return {name: _marginal(own, columns, place) for place, name in enumerate(known.faults)}


def _slopes(known: KnownMachine, base: MachineFit, here: Reals, states: Sequence[Spread]) -> tuple[list[Reals], list[Reals]]:
    """How the residual, which is `here` [n] at the fit, moves with each fault, per unit of it, and with each of these states, per standard deviation, [n] each."""
    machine = known.actuator.changed(base.values)

    def slope(changes: Mapping[str, float], step: float) -> Reals:
        return (known.residual({**base.values, **changes}) - here) / step

    own = each(lambda name: slope({name: (1.0 + _STEP) * base.values[name]}, _STEP * base.values[name]), known.faults)
    return own, each(lambda one: slope(one.changes(machine, SMALL_SHARE), SMALL_SHARE), states)


def _marginal(own: Sequence[Reals], today: Sequence[Reals], place: int) -> float:
    """Standard error of the value at `place` by the slopes [n] of what is free and of what has a spread of 1; infinite where the record says nothing of it."""
    slopes = np.column_stack([*own, *today])
    known = np.concatenate([np.zeros(len(own)), np.ones(len(today))])
    try:
        return float(np.sqrt(np.linalg.inv(slopes.T @ slopes + np.diag(known))[place, place]))
    except np.linalg.LinAlgError:
        return float("inf")


def _apart(own: Sequence[Reals], column: Reals) -> tuple[Reals, Reals]:
    """By how much each fault follows a state whose standard deviation moves the residual by `column` [n], and what of that no fault follows [n]."""
    slopes = np.column_stack(own)
    follows = np.linalg.lstsq(slopes, column, rcond=None)[0]
    return np.asarray(follows), np.asarray(column - slopes @ follows)


def _moves(known: KnownMachine, base: MachineFit, follows: Reals) -> bool:
    """Whether a state moves a fault much."""
    return any(abs(float(one)) > _MUCH * base.values[name] for one, name in zip(follows, known.faults, strict=True))


def _left_open(known: KnownMachine, base: MachineFit, follows: Reals, rest: Reals) -> bool:
    """Whether a state moves a fault much where nothing else follows it, and may be no other than the fault to the record."""
    return _moves(known, base, follows) and float(rest @ rest) < _SURELY_TOLD


def _wanted(known: KnownMachine, base: MachineFit, follows: Reals, rest: Reals, here: Reals) -> bool:
    """Whether a state would explain more of what is left `here` [n] than chance does, and move a fault much there."""
    told = float(rest @ rest)
    size = -float(rest @ here) / told if told > 0.0 else 0.0
    return size * size * told > _AS_WELL and _moves(known, base, size * follows)


def _near(known: KnownMachine, base: MachineFit, machine: Actuator, states: Sequence[Spread]) -> list[_Sizes]:
    """Each of these states at two sizes beside none; those of which the model refuses one are left out."""
    none = [_Sizes(one, (0.0,), (base,)) for one in states]
    near = _fitted(known, base, machine, [(one, _sizes(one.state)) for one in none])
    return [one for one in near if len(one.sizes) == 3]


def _sizes(one: Spread) -> tuple[float, ...]:
    """Two sizes of a state, in its standard deviations: what is none on the data sheet is not less."""
    return (-1.0, 1.0) if one.relative else (1.0, 2.0)


def _fitted(known: KnownMachine, base: MachineFit, machine: Actuator, asked: Sequence[tuple[_Sizes, Sequence[float]]]) -> list[_Sizes]:
    """Each with the fits at further sizes; what the state itself is stays in them."""

    def fit(side: tuple[Spread, float]) -> MachineFit | None:
        changes = side[0].changes(machine, side[1])
        return known.fit("", {**base.values, **changes}, [name for name in known.free if name not in changes], LAST_STEPS)

    fits = iter(each(fit, [(one.state, size) for one, sizes in asked for size in sizes]))
    return [one.with_fits([(size, next(fits)) for size in sizes]) for one, sizes in asked]


def _is_open(one: _Sizes, base: MachineFit) -> bool:
    """Whether the record tells a state of a usual size as badly as that."""
    return min(fit.cost for size, fit in zip(one.sizes, one.fits, strict=True) if size != 0.0) - base.cost < _TOLD


def _parabola(one: _Sizes, base: MachineFit) -> tuple[float, float]:
    """Slope and half the bend of the cost along a state at none of it, by its two sizes."""
    pair = [(size, fit) for size, fit in zip(one.sizes, one.fits, strict=True) if size != 0.0]
    slope, bend = np.linalg.solve([[size, size**2] for size, _ in pair], [fit.cost - base.cost for _, fit in pair])
    return float(slope), float(bend)


def _profile(known: KnownMachine, base: MachineFit, one: _Sizes) -> _Profile:
    """By the parabola through the costs at two sizes and at none, beside the state's own spread of 1."""
    slope, bend = _parabola(one, base)
    shown = 1.0 + max(bend, 0.0)
    at = -0.5 * slope / shown
    # a state that cannot be less than none is none at least
    at = at if one.state.relative else max(at, 0.0)
    per = {
        name: float(np.dot(one.sizes, [fit.values[name] - base.values[name] for fit in one.fits]) / np.dot(one.sizes, one.sizes))
        for name in known.faults
    }
    return _Profile({name: at * size for name, size in per.items()}, {name: abs(size) / math.sqrt(shown) for name, size in per.items()})


def _takes_off(one: _Sizes, base: MachineFit, limit: float = _AS_WELL) -> bool:
    """Whether the state at one of its sizes explains more than none of it does, by more than this of the cost."""
    return min(fit.cost for fit in one.fits) < base.cost - limit


def _reach(known: KnownMachine, base: MachineFit, machine: Actuator, near: Sequence[_Sizes]) -> dict[str, Reach]:
    """How far each fault lies off, by name, where one of these states is farther off than usual and explains the record as well as the best of them."""
    if not near:
        return dict.fromkeys(known.faults, Reach())
    far = _fitted(known, base, machine, [(one, _further(one, base)) for one in near])
    best = min(fit.cost for one in far for fit in one.fits)
    limit = _AS_WELL * max(1.0, best / known.evidence.numbers)
    return {name: Reach.of(base.values[name], {one.state.title: one.as_well(name, best, limit) for one in far}) for name in known.faults}


def _further(one: _Sizes, base: MachineFit) -> list[float]:
    """Sizes that show how far the state may go: far ones, and the one at which it explains most."""
    far = [side * size for side in ((-1.0, 1.0) if one.state.relative else (1.0,)) for size in _FAR]
    slope, bend = _parabola(one, base)
    best = -0.5 * slope / bend if bend > 0.0 else 0.0
    lowest = -_FARTHEST if one.state.relative else 0.0
    is_new = lowest < best < _FARTHEST and all(abs(best - size) > _APART for size in (*one.sizes, *far))
    return [*far, best] if is_new else far
