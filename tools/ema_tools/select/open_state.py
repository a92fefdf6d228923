"""How far CSJ and BLK may be off for what the machine may be today without anybody knowing: winding, grease, magnets, supply, gain, inverter.

By slopes at the fit where the signals tell such a state apart. Where it moves the answer much, slopes do not settle that: reversals jump a step, and what is left between two slopes that are alike
is as large as what would tell one from the other. There the model is fitted with the state at two sizes, and the costs of these fits say how far it may go (a profile of the likelihood; S. A. Murphy
and A. W. van der Vaart, J. Am. Stat. Assoc. 95, 2000).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.nuisance import Spread
from ema_tools.select.known_machine import LAST_STEPS, SMALL_SHARE, KnownMachine, MachineFit

_STEP = 0.02  # of a value, for its slope: large against reversals that jump a step [precision]
_TOLD = 10.0  # a state of one standard deviation that costs more is told by the record, and slopes say how well: what reversals leave between them is less [precision]
_SURELY_TOLD = 400.0  # and one that costs so much by the slopes does so by whatever reversals leave between them, which is a tenth of it on a slow triangle [measured]
_MUCH = 0.01  # of a value: what moves it by less, one standard deviation of it, is left to the slopes [judgement]


@dataclass(frozen=True)
class OpenStd:
    """A standard error, what of the machine's present state does most to it, by name, and its part that is not noise; `moved`: by how much the value would be another if what the record itself
    says of that state were fitted beside it."""

    std: float
    most: str
    beyond: float = 0.0
    moved: float = 0.0

    def doubt(self, sure: float, healthy: float) -> float:
        """How far a shift may be off for what the machine may be today, relative to the `healthy` value; `sure`: in so many standard deviations."""
        return (sure * self.std + self.moved) / abs(healthy)


@dataclass(frozen=True)
class _Profile:
    """What a state does to each fault, by name: by how much it would be another where the record says it is, and how uncertain that is, standard deviations."""

    moved: Mapping[str, float]
    std: Mapping[str, float]


def open_state(known: KnownMachine, base: MachineFit, left: float = 0.0) -> dict[str, OpenStd]:
    """Standard errors of CSJ and BLK where the machine may be today as far from what is known of it as machines go, by name; with a cost `left` that may lie along either of them."""
    here = known.residual(base.values)
    machine = known.actuator.changed(base.values)
    wanted = [one for one in spreads.of_today(machine) if not set(one.names) & set(known.faults)]

    def slope(changes: Mapping[str, float], step: float) -> Reals:
        return (known.residual({**base.values, **changes}) - here) / step

    own = each(lambda name: slope({name: (1.0 + _STEP) * base.values[name]}, _STEP * base.values[name]), known.faults)
    today = each(lambda one: slope(one.changes(machine, SMALL_SHARE), SMALL_SHARE), wanted)
    profiles = _profiles(
        known, base, machine, [one for one, column in zip(wanted, today, strict=True) if _left_open(known, base, own, column)]
    )
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
        found[name] = OpenStd(std, worst, math.sqrt(max(std**2 - noise**2, 0.0)), moved)
    return found


def _marginal(own: Sequence[Reals], today: Sequence[Reals], place: int) -> float:
    """Standard error of the value at `place` by the slopes [n] of what is free and of what has a spread of 1; infinite where the record says nothing of it."""
    slopes = np.column_stack([*own, *today])
    known = np.concatenate([np.zeros(len(own)), np.ones(len(today))])
    try:
        return float(np.sqrt(np.linalg.inv(slopes.T @ slopes + np.diag(known))[place, place]))
    except np.linalg.LinAlgError:
        return float("inf")


def _left_open(known: KnownMachine, base: MachineFit, own: Sequence[Reals], column: Reals) -> bool:
    """Whether a state whose standard deviation moves the residual by `column` [n] moves a fault much where nothing else follows it, and may be no other than the fault to the record."""
    slopes = np.column_stack(own)
    follows = np.linalg.lstsq(slopes, column, rcond=None)[0]
    rest = column - slopes @ follows
    much = any(abs(float(one)) > _MUCH * base.values[name] for one, name in zip(follows, known.faults, strict=True))
    return much and float(rest @ rest) < _SURELY_TOLD


def _profiles(known: KnownMachine, base: MachineFit, machine: Actuator, states: Sequence[Spread]) -> dict[str, _Profile]:
    """Of each of these states that the record does not tell well, by its name; those of which the model refuses a size are left out."""
    sides = [(one, size) for one in states for size in _sizes(one)]
    fits = each(lambda side: _with(known, base, side[0].changes(machine, side[1])), sides)
    found: dict[str, _Profile] = {}
    for one in states:
        pair = [(size, fit) for (other, size), fit in zip(sides, fits, strict=True) if other is one and fit is not None]
        if len(pair) == 2 and min(fit.cost - base.cost for _, fit in pair) < _TOLD:
            found[one.title] = _profile(known, base, [size for size, _ in pair], [fit for _, fit in pair])
    return found


def _sizes(one: Spread) -> tuple[float, float]:
    """Two sizes of a state, in its standard deviations: what is none on the data sheet is not less."""
    return (-1.0, 1.0) if one.relative else (1.0, 2.0)


def _with(known: KnownMachine, base: MachineFit, changes: Mapping[str, float]) -> MachineFit | None:
    """The fit beside a state; what the state itself is stays."""
    return known.fit("", {**base.values, **changes}, [name for name in known.free if name not in changes], LAST_STEPS)


def _profile(known: KnownMachine, base: MachineFit, sizes: Sequence[float], pair: Sequence[MachineFit]) -> _Profile:
    """By the parabola through the costs at these sizes and at none, beside the state's own spread of 1."""
    slope, bend = np.linalg.solve([[size, size**2] for size in sizes], [one.cost - base.cost for one in pair])
    shown = 1.0 + max(float(bend), 0.0)
    at = -0.5 * float(slope) / shown
    # a state that cannot be less than none is none at least
    at = max(at, 0.0) if min(sizes) > 0.0 else at
    per = {
        name: float(np.dot(sizes, [one.values[name] - base.values[name] for one in pair]) / np.dot(sizes, sizes)) for name in known.faults
    }
    return _Profile({name: at * one for name, one in per.items()}, {name: abs(one) / math.sqrt(shown) for name, one in per.items()})
