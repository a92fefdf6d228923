"""Effects fitted beside CSJ and BLK on a record of a known machine: which one is missing, and which would do as well as a fault.

A missing effect moves CSJ and BLK far from where they belong, where signatures mislead; so every effect is fitted beside them in the nonlinear model, and the costs are compared.
Where the one that is named leaves more than noise, without repeats, its size is that of a unit which differs from its file as units do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import row_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import FAR, FAR_ROUNDS, Evidence, settled
from ema_tools.fit.refit import refit
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of
from ema_tools.library.shapes import penalty
from ema_tools.select.known_machine import LAST_STEPS, KnownMachine, MachineFit, Start
from ema_tools.select.strategies.strategy import LEAST_LIMIT

# Steps of one fit: all effects by size alone, the better ones from two starts; then the few best with all their values [effort]
_FIRST_STEPS, _SECOND_STEPS = 4, 8
_SECOND, _LAST = 6, 3  # how many effects go on to the second and the last of these fits [effort]
_ALIKE = 9.0  # fits whose costs differ by less than three standard deviations cannot be told apart [chance]
# As much again as the best one leaves beyond noise: where its own form leaves something, forms are not told apart by less [judgement]
_NEARLY = 1.0
_LEAST_SHARE = 0.05  # the share of the excess over sensor noise that a named effect must take off ... [judgement]
_UNEXPLAINED = 0.1  # ... and with more than this share left the answer is that something is missing, not what [judgement]
_LEAST_ERRORS = 2.0  # a named effect's size differs from none by so many standard errors [chance]
_TAKEN = 0.4  # of CSJ or BLK: nothing takes so much of it away [judgement]
_RIVALS = 20  # effects that are fitted in a fault's place, by their signatures: the best was never past the 18th [measured]
_RIVAL_SHARE = 0.1  # of what a fault explains: an effect that leaves more after its first fit is no rival .. [judgement]
_RIVAL_OF_TODAY = (
    0.25  # .. but one that comes and goes unseen with the day, whose first fit of few steps may be far from its end [judgement]
)


def beside(known: KnownMachine, base: MachineFit, only: str | None = None) -> list[MachineFit]:
    """Every effect, or `only` one, fitted beside CSJ and BLK, best first; the few best with all their values."""
    sizes = _sizes()
    healthy = {name: known.actuator[name] for name in known.faults}
    tasks: list[tuple[str, Mapping[str, float]]] = [
        (one.effect, {**one.values, **{name: base.values[name] for name in known.faults}}) for one in known.starts(base, only)
    ]
    first = _best_of_each(each(lambda task: known.fit(task[0], task[1], (sizes[task[0]], *known.faults), _FIRST_STEPS), tasks))[:_SECOND]
    tasks = [(one.effect, values) for one in first for values in (one.values, {**one.values, **healthy})]
    second = _best_of_each(each(lambda task: known.fit(task[0], task[1], (sizes[task[0]], *known.faults), _SECOND_STEPS), tasks))[:_LAST]
    return _with_all_values(known, second)


def _sizes() -> dict[str, str]:
    """Name of the size of each effect."""
    return {effect.name: f"effects.{effect.size.name}" for effect in load_definitions().effects}


def _with_all_values(
    known: KnownMachine, fits: Sequence[MachineFit], ends: Mapping[str, tuple[float, float]] | None = None
) -> list[MachineFit]:
    """The fits gone on with, all values free but whole numbers, inside `ends` where given; best first."""

    def last(one: MachineFit) -> MachineFit | None:
        shape = (name for name in one.values if name.startswith("effects.") and not name.endswith(".periods"))
        return known.fit(one.effect, one.values, (*known.free, *shape), LAST_STEPS, ends)

    return _best_of_each(each(last, fits))


def _best_of_each(fits: Sequence[MachineFit | None]) -> list[MachineFit]:
    """The best fit of each effect, best first."""
    best: dict[str, MachineFit] = {}
    for one in sorted((one for one in fits if one is not None), key=lambda one: one.cost + penalty([one.effect])):
        best.setdefault(one.effect, one)
    return list(best.values())


def _rival_share(effect: str) -> float:
    return _RIVAL_OF_TODAY if record_of(effect).today > 0.0 else _RIVAL_SHARE


def rivals(known: KnownMachine, base: MachineFit, fault: str, least: float) -> list[MachineFit]:
    """Effects that explain the record as well as the shift of `fault` does in `base`, which then is no larger than half of `least`, relative; best first.

    Half: what leaves a shift just below what is called a fault explains nothing.
    """
    healthy, most = known.actuator[fault], 0.5 * least
    ends = {fault: ((1.0 - most) * healthy, (1.0 + most) * healthy)}
    held = {**base.values, fault: float(np.clip(base.values[fault], *ends[fault]))}
    without = known.fit("", held, known.free, _FIRST_STEPS, ends)
    if without is None:
        return []
    shown = without.cost - base.cost
    unit = max(1.0, base.cost / known.evidence.numbers)
    sizes = _sizes()
    starts = sorted(known.starts(without, held=fault), key=lambda one: -one.gain)[:_RIVALS]

    def first(one: Start) -> MachineFit | None:
        return known.fit(one.effect, {**without.values, **one.values}, (sizes[one.effect], *known.free), _FIRST_STEPS, ends)

    near = [one for one in _best_of_each(each(first, starts)) if one.cost - base.cost < _rival_share(one.effect) * shown][:_SECOND]
    return [
        known.with_whole_std(one)
        for one in _with_all_values(known, near, ends)
        if one.cost + penalty([one.effect]) < base.cost + _ALIKE * unit
    ]


def named(known: KnownMachine, base: MachineFit) -> tuple[str, MachineFit | None, tuple[str, ...]]:
    """Verdict, the best effect, what looks like it."""
    numbers = known.evidence.numbers
    excess = max(base.cost - known.floor, 1e-9)
    fits = [one for one in beside(known, base) if not takes_away(known, one.values)]
    if not fits:
        return "unknown", None, ()
    unit = max(1.0, fits[0].cost / numbers)  # where the misfit that is left is more than noise, it is the yardstick
    least = max(LEAST_LIMIT * unit, _LEAST_SHARE * excess)
    fits = _without_needless(fits, least)
    best = fits[0]
    size, zero = next((name, row_of(name).nominal) for name in best.values if name.startswith(f"effects.{best.effect}."))
    if abs(best.values[size] - zero) < _LEAST_ERRORS * best.std.get(size, 0.0):
        return "unknown", None, ()
    if base.cost - best.cost - penalty([best.effect]) < least:
        return "unknown", None, ()
    if best.cost - known.floor > max(_UNEXPLAINED * excess, 6.0 * np.sqrt(2.0 * numbers)):
        return "unknown", None, ()
    near = max(_ALIKE * unit, _NEARLY * (best.cost - known.floor))
    alike = [one.effect for one in fits[1:] if one.cost - best.cost < near]
    alike += record_of(best.effect).inseparable
    return "missing", known.with_whole_std(best), tuple(dict.fromkeys(alike))


def takes_away(known: KnownMachine, values: Mapping[str, float]) -> bool:
    """Whether CSJ or BLK fell much from what healthy repeats show, which wear does not do: then what stands beside them is something else."""
    return known.evidence.relative and any(values[name] < (1.0 - _TAKEN) * known.actuator[name] for name in known.faults if name in values)


def _without_needless(fits: Sequence[MachineFit], least: float) -> list[MachineFit]:
    """Without the fit of an effect that is another one in a special case and takes off less than `least` beyond that one."""
    costs = {one.effect: one.cost for one in fits}
    return [one for one in fits if costs.get(record_of(one.effect).special_case, np.inf) - one.cost >= least]


def beside_faults(evidence: Evidence, effect: str) -> tuple[dict[str, float], dict[str, float]]:
    """On the evidence of a machine that is known: CSJ and BLK as they are without `effect`, and the values of all three fitted together.

    Raises InputError when the record shows nothing of the effect.
    """
    known = KnownMachine(evidence)
    base = known.base({})
    fits = beside(known, base, effect)
    if not fits:
        raise InputError(f"{effect}: the record shows nothing of it: nothing can be fitted")
    own = {name: value for name, value in fits[0].values.items() if name.startswith("effects.")}
    return {name: base.values[name] for name in known.faults}, {**own, **{name: fits[0].values[name] for name in known.faults}}


def on_unit(unit: Evidence, named: MachineFit) -> MachineFit:
    """The named effect's size where the machine may differ from its file as units do from their data sheet; `named` itself where that leaves nothing of the effect."""
    values = {name: value for name, value in named.values.items() if name.startswith(f"effects.{named.effect}.")}
    try:
        fit = refit(settled(unit, values, rounds=FAR_ROUNDS, reach=FAR), values)
    except InputError:
        return named
    if not fit.determined(named.effect):
        return named
    machine = spreads.moved(unit.actuator, unit.spread, fit.deviations())
    return MachineFit(
        named.effect,
        {**named.values, **{name: machine[name] for name in named.values if name in machine}, **fit.values},
        {**named.std, **fit.std},
        named.cost,
    )
