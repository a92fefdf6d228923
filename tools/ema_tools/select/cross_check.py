"""What all signals of a record say of a CSJ and BLK that one signal gave: whether they agree, whether something else would explain the record as well, and what is left unexplained.

The search by itself sees the rod position and two values. Here the machine is taken for known, by its actuator file or by healthy repeats of the same command, and everything that
was recorded is held against it, over the whole record and in every part of it, whichever way the verdict went.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.select.beside_fault import named, on_unit, rivals, takes_away
from ema_tools.select.known_machine import Compared, KnownMachine, MachineFit, blocks, disturbs, remarks_of
from ema_tools.select.open_state import OpenStd, open_state
from ema_tools.select.sensors import VOLTAGE, Suspect, odd_signal, suspect, without_voltage
from ema_tools.select.strategies.strategy import LEAST_LIMIT
from ema_tools.select.whole_search import WholeSearch, searched

# What was found: the known machine with another CSJ and BLK explains everything; an effect is missing; something is missing that no effect explains; an effect
# explains the record as well as a fault does.
Kind = Literal["adequate", "missing", "unknown", "rival"]

LITTLE_LEFT = "what is left is too little beside the fault to be its cause"
_HARDLY = 0.01  # of what a fault explains: a remainder that could not be its cause if it lay along it, a tenth of its size [judgement]


@dataclass(frozen=True)
class _Said:
    faults: Mapping[str, float] = field(default_factory=dict)
    shift: Mapping[str, float] = field(default_factory=dict)
    open: Mapping[str, OpenStd] = field(default_factory=dict)
    effects: tuple[str, ...] = ()
    values: Mapping[str, float] = field(default_factory=dict)
    std: Mapping[str, float] = field(default_factory=dict)
    there: bool = False
    as_given: bool = False
    withheld: bool = False
    left_out: str = ""
    sensor: Suspect | None = None


@dataclass(frozen=True)
class CrossCheck(_Said):
    """What all signals say. `effects`: the missing one or the rival, then those that look like it; `values`, `std`: of that effect; `faults`: CSJ and BLK by name, beside it
    where one is missing; `shift`: of these from the machine that is known, relative; `open`: how far they may be off for how machines differ from day to day; `against`: healthy
    repeats that the record was compared with; `signals`: that were compared; `skipped`: why nothing was sought; `there`: the model holds the effect, at another size;
    `as_given`: the actuator's file holds it at this very size, which the healthy repeats do not show; `withheld`: it takes the search of all effects to name it, and what it leaves beside CSJ and
    BLK keeps the answer open; `left_out`: the signal without which the others name it; `sensor`: whose own error what is unknown looks like."""

    kind: Kind = "adequate"
    against: int = 0
    signals: tuple[str, ...] = ()
    skipped: str = ""
    wall_s: float = 0.0

    @property
    def unusable(self) -> bool:
        """Whether nothing was sought because the record cannot answer."""
        return self.kind == "unknown" and bool(self.skipped)


def cross_check(
    actuator: Actuator, record: Record, beside: Compared, estimates: Mapping[str, float], least: Mapping[str, float], doubted: bool
) -> CrossCheck:
    """Holds `estimates` of CSJ and BLK, by name, against all signals. `beside`: the record with what is known of its machine; `least`: the shift of each that is called a fault,
    relative; `doubted`: the search itself found the model not adequate."""
    begun = time.perf_counter()
    repeats = len(beside.repeats)

    def said(kind: Kind, what: _Said | None = None, skipped: str = "") -> CrossCheck:
        told = what or _Said()
        return CrossCheck(
            **vars(told), kind=kind, against=repeats, signals=beside.signals, skipped=skipped, wall_s=time.perf_counter() - begun
        )

    remarks = remarks_of(actuator, record)
    why_not = blocks(remarks)
    if why_not:
        return said("unknown", skipped=why_not)
    known = beside.known
    base = known.base(estimates)
    plainly = (repeats > 0 or not doubted) and known.plain(base)
    # what a unit always has grows with its friction: beside a large fault a little of it hides nothing
    hardly = not plainly and (repeats > 0 or not doubted) and not known.at_reach(base) and known.left_of(base) < _HARDLY
    if plainly or hardly:
        plain = _faults(known, base)
        stands = open_state(known, base, base.cost - known.floor if hardly else 0.0)
        beyond = [name for name, shift in plain.shift.items() if shift > least[name]]
        instead = {name: rivals(known, base, name, least[name]) for name in beyond}
        confidence = known.actuator["verdict.confidence_std"]
        doubt = {name: stands[name].doubt(confidence, known.actuator[name]) for name in beyond}
        sure = [name for name in beyond if not instead[name] and plain.shift[name] - doubt[name] > least[name]]
        for found in filter(None, instead.values()):
            # beside a fault that stands whatever explains the other, the other's doubt changes nothing
            if any(_beside_all(known, found, name, least[name]) for name in sure):
                continue
            return said("rival", _with_effect(replace(plain, open=stands), found[0], [one.effect for one in found[1:]], actuator))
        why = "the residual is as small as those of the healthy records" if repeats else "every residual is as small as its sensor's noise"
        why = LITTLE_LEFT if hardly else why
        return said("adequate", replace(plain, open=stands), why)
    why_not = disturbs(remarks)
    if why_not:
        return said("unknown", skipped=why_not)
    verdict, best, alike = named(known, base)
    if verdict == "unknown" or best is None:
        return said("unknown") if repeats == 0 else _by_search(said, known, searched(known.evidence if repeats else beside.unit), actuator)
    sensor = suspect(known.evidence) if repeats > 0 else None
    if sensor is not None and sensor.cost < best.cost - LEAST_LIMIT:
        return said("unknown", _Said(sensor=sensor))
    # what the effect leaves beyond noise says that the machine is not as its file says
    as_filed = repeats > 0 or best.cost - known.floor < 6.0 * np.sqrt(2.0 * known.evidence.numbers)
    best = best if as_filed else on_unit(beside.unit, best)
    return said("missing", _with_effect(_faults(known, best), best, alike, actuator))


def _by_search(said: Callable[[Kind, _Said], CrossCheck], known: KnownMachine, found: WholeSearch, actuator: Actuator) -> CrossCheck:
    """What the whole search says of a record that no effect beside CSJ and BLK alone explains, or what the signals say without one of them."""
    if found.effect is None or takes_away(known, found.faults):
        sensor = found.sensor or odd_signal(known.evidence)
        as_asked = _without_voltage(known) if sensor is None else None
        if as_asked is None:
            return said("unknown", _Said(sensor=sensor))
        best, alike = as_asked
        return said("missing", replace(_with_effect(_faults(known, best), best, alike, actuator), withheld=True, left_out=VOLTAGE))
    one = found.effect
    machine = {name: known.actuator[name] for name in known.faults}
    fit = MachineFit(one.name, {**machine, **found.faults, **one.values}, one.std, math.nan)
    return said("missing", replace(_with_effect(_faults(known, fit), fit, one.alike[1:], actuator), withheld=True))


def _without_voltage(known: KnownMachine) -> tuple[MachineFit, tuple[str, ...]] | None:
    """The effect that the other signals name where the recorded voltage contradicts them, with what looks like it."""
    evidence = without_voltage(known.evidence)
    if evidence is None:
        return None
    others = KnownMachine(evidence)
    verdict, best, alike = named(others, others.base({}))
    return (best, tuple(alike)) if verdict == "missing" and best is not None and others.plain(best) else None


def _beside_all(known: KnownMachine, rivalling: Sequence[MachineFit], fault: str, least: float) -> bool:
    """Whether a shift is a fault beside each of these effects."""
    return all(one.values[fault] / known.actuator[fault] - 1.0 > least for one in rivalling)


def _faults(known: KnownMachine, fit: MachineFit) -> _Said:
    """CSJ and BLK of a fit, and their shifts from the machine that is known."""
    values = {name: fit.values[name] for name in known.faults}
    return _Said(faults=values, shift={name: value / known.actuator[name] - 1.0 for name, value in values.items()})


def _with_effect(said: _Said, one: MachineFit, alike: Sequence[str], actuator: Actuator) -> _Said:
    own = {name: value for name, value in one.values.items() if name.startswith(f"effects.{one.effect}.")}
    return replace(
        said,
        effects=(one.effect, *alike),
        values=own,
        std={name: one.std[name] for name in own if name in one.std},
        there=one.effect in actuator.active_effects,
    )
