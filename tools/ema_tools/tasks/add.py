"""Puts one effect into a model: fits it to a record, says by how much the error falls there and on a record held out, and whether to keep it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report, untold
from ema_tools.compare.localisation import where
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.nuisance import moved
from ema_tools.fit.refit import POLISHED, Fit, fitted_from, polished, refit
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.select.baseline import gather
from ema_tools.select.beside_fault import beside_faults
from ema_tools.select.candidates import signatures
from ema_tools.select.holdout import ErrorFall, Rung, fitted_machine, walk, weighted
from ema_tools.select.known_machine import known_machine
from ema_tools.select.matched_filter import Screen
from ema_tools.select.outcome import Diagnosis
from ema_tools.select.strategies.strategy import LEAST_LIMIT
from ema_tools.select.whole_search import diagnosed
from ema_tools.tasks.diagnose import answerable, check_records, healthy_of
from ema_tools.tasks.learned_tables import learned_tables, table_fit, today_worn

_CORRELATED = 0.95  # two fitted values that move together beyond this cannot be told apart [judgement]
# What moves before the effect is added to a machine that is known.
_FAULTS_ALONE = "CSJ and BLK alone"
_FALL = 1e-3  # the error on a record held out must fall, by more than the rounding of what is reported [precision]


class Why(Enum):
    """What an addition is judged by; the first four are against it."""

    NOISE = "the error falls by no more than noise can make it"
    UNDETERMINED = "its size could as well be none"
    AT_BOUND = "a value lies on a bound of its range"
    NOT_HELD = "the error on the record held out does not fall"
    TIED = "the error falls, but the size cannot be told from another value"
    FALLS = "the error falls; no record was held out"
    HELD = "the error falls on both records"


@dataclass(frozen=True)
class Judgement:
    """Whether an addition is recommended; `value`: the name of the one on its bound, or of the one that the size cannot be told from, with their `correlation`."""

    why: Why
    value: str = ""
    correlation: float = 0.0

    @property
    def recommended(self) -> bool:
        """Whether to keep the effect."""
        return self.why in (Why.TIED, Why.FALLS, Why.HELD)


@dataclass(frozen=True)
class Added:
    """The model with the effect, what was fitted, and whether it is recommended; `actuator`: as the record shows the machine; `healthy`: the machine that CSJ and BLK are counted from;
    `refitted`: the model held the effect before."""

    effect: str
    healthy: Actuator
    actuator: Actuator
    fit: Fit
    errors: ErrorFall
    steps: tuple[Rung, ...]
    judgement: Judgement
    correlations: tuple[tuple[str, str, float], ...]
    refitted: bool = False
    effects: tuple[str, ...] = ()  # all that were added, where these are several
    without: Mapping[str, float] = field(default_factory=dict)  # weighted error of the model refitted without each of several effects

    @property
    def recommended(self) -> bool:
        """Whether to keep the effect."""
        return self.judgement.recommended

    @property
    def machine(self) -> Actuator:
        """What `ema add` writes: `actuator` with CSJ and BLK of the healthy machine."""
        return self.actuator.keeping(self.healthy, FAULTS.values())

    def with_last_error(self, error: float) -> Added:
        """The same with the weighted error of the last model on the record as `error`."""
        last = replace(self.steps[-1], error=error, told=(error, self.steps[-1].told[1]))
        return replace(self, errors=replace(self.errors, after=error), steps=(*self.steps[:-1], last))

    @property
    def fitted(self) -> Actuator:
        """The machine as the record shows it: with the effect, and with CSJ and BLK as far as they were fitted beside it."""
        return self.actuator.changed(self.fit.values)


def add(
    actuator: Actuator,
    effect: str,
    record: Record,
    healthy: Sequence[Record] = (),
    holdout: Record | None = None,
    report: Report | None = None,
) -> Added:
    """Fits `effect` to a record beside what scatters (with healthy repeats also CSJ and BLK, which may have changed with it), and judges it.

    Raises InputError for an unknown effect, a record that shows nothing of it, and as `gather` does.
    """
    tell = report or untold
    row = next((row for row in load_definitions().effects if row.name == effect), None)
    if row is None:
        raise InputError(f"{effect}: no such effect: ema effects lists the library")
    check_records(record, healthy, holdout)
    answerable(actuator, record, healthy_of(record, healthy))
    evidence = gather(actuator, record, healthy_of(record, healthy), report=lambda share, text: tell(0.5 * share, text))
    tell(0.6, f"fitting {effect}")
    if row.is_learned:
        here = settled(evidence, {})
        worn, accepted = today_worn(here), False
        fit = _learned(evidence, worn, effect, record, healthy)
    else:
        evidence, fit, accepted = _fitted(evidence, (effect,), _faults(evidence))
        here = worn = settled(evidence, {})
    diagnosis = Diagnosis("missing", fit, (), (), (fit,), here.cost, fit.cost, evidence.expected_cost(), 0.0, LEAST_LIMIT)
    tell(0.9, "the record held out")
    errors, steps = walk(diagnosis, evidence, holdout, healthy_of(holdout, healthy) if holdout is not None else ())
    correlations = tuple(_correlations(fit))
    judgement = _judged(fit, effect, errors, worn.cost, correlations, accepted)
    own = fit.of_effect(effect)
    tell(1.0, "done")
    return Added(
        effect,
        evidence.actuator,
        fitted_machine(evidence, fit).changed(own),
        fit,
        errors,
        steps,
        judgement,
        correlations,
        effect in actuator.active_effects,
    )


def add_to_known(actuator: Actuator, effect: str, record: Record, holdout: Record | None = None, report: Report | None = None) -> Added:
    """Fits `effect` to a record of a machine that is as `actuator` says but for its CSJ and BLK, which are free: what is written keeps their healthy values. Raises InputError as `add` does."""
    tell = report or untold
    if effect not in {row.name for row in load_definitions().physical}:
        raise InputError(
            f"{effect}: a table that is learned, or no effect at all: --known takes the physical effects that ema effects lists"
        )
    tell(0.1, f"fitting {effect} beside CSJ and BLK")
    check_records(record, (), holdout)
    answerable(actuator, record, ())
    evidence = known_machine(actuator, record)
    alone, together = beside_faults(evidence, effect)
    faulty = settled(evidence, alone)
    before = faulty.cost
    fit = fitted_from(evidence, together)
    diagnosis = Diagnosis("missing", fit, (), (), (fit,), before, fit.cost, evidence.expected_cost(), 0.0, LEAST_LIMIT)
    tell(0.9, "the record held out")
    errors, steps = walk(diagnosis, evidence, holdout)
    told = weighted(faulty.plain_cost, evidence), None
    own = {**moved(evidence.actuator, evidence.spread, faulty.deviations), **alone}
    steps = (steps[0], replace(steps[1], added=_FAULTS_ALONE, holdout=None, told=told, values=own), *steps[2:])
    correlations = tuple(_correlations(fit))
    judgement = _judged(fit, effect, errors, before, correlations)
    tell(1.0, "done")
    return Added(
        effect,
        actuator,
        actuator.changed(fit.of_effect(effect)),
        fit,
        errors,
        steps,
        judgement,
        correlations,
        effect in actuator.active_effects,
    )


def add_together(
    actuator: Actuator,
    effects: Sequence[str],
    record: Record,
    healthy: Sequence[Record] = (),
    holdout: Record | None = None,
    known: bool = False,
    report: Report | None = None,
) -> Added:
    """Fits several physical effects to a record at once, jointly with CSJ and BLK where healthy repeats or a `known` machine tell them, and judges each by the error without it.

    Raises InputError as `add` does, and for an effect that is learned.
    """
    tell = report or untold
    learned = [effect for effect in effects if effect not in {row.name for row in load_definitions().physical}]
    if learned:
        raise InputError(
            f"{learned[0]}: a learned table is fitted to what the other effects leave: add the others first, then {learned[0]} alone"
        )
    check_records(record, healthy, holdout)
    answerable(actuator, record, healthy_of(record, healthy))
    evidence = known_machine(actuator, record) if known else gather(actuator, record, healthy_of(record, healthy))
    tell(0.5, f"fitting {', '.join(effects)}")
    faults = _faults(evidence, known)
    if known:
        fit, accepted = _one_by_one(evidence, effects, faults), False
    else:
        evidence, fit, accepted = _fitted(evidence, effects, faults)
    here = settled(evidence, {})
    without: dict[str, Fit] = {}
    for effect in effects:
        rest = {name: value for name, value in fit.values.items() if effect_of(name) != effect}
        without[effect] = fitted_from(evidence, rest)
    diagnosis = Diagnosis("missing", fit, (), (), (fit,), here.cost, fit.cost, evidence.expected_cost(), 0.0, LEAST_LIMIT)
    tell(0.9, "the record held out")
    errors, steps = walk(diagnosis, evidence, holdout, healthy_of(holdout, healthy) if holdout is not None else ())
    correlations = tuple(_correlations(fit))
    judged = [_judged(fit, effect, errors, without[effect].cost, correlations, accepted) for effect in effects]
    judgement = next((one for one in judged if not one.recommended), judged[0])
    own = {name: value for effect in effects for name, value in fit.of_effect(effect).items()}
    machine = actuator if known else fitted_machine(evidence, fit)
    tell(1.0, "done")
    return Added(
        effects[0],
        actuator if known else evidence.actuator,
        machine.changed(own),
        fit,
        errors,
        steps,
        judgement,
        correlations,
        effects[0] in actuator.active_effects,
        tuple(effects),
        {effect: weighted(one.cost, evidence) for effect, one in without.items()},
    )


def _faults(evidence: Evidence, known: bool = False) -> list[str]:
    """CSJ and BLK, where the evidence tells them from what scatters and the machine has them."""
    return [name for name, value in FAULTS.items() if (known or evidence.relative) and evidence.actuator[value] > 0.0]


def _fitted(evidence: Evidence, effects: Sequence[str], faults: Sequence[str]) -> tuple[Evidence, Fit, bool]:
    """The effects at their best beside the faults, with the evidence that they are fitted to, and whether the search of `ema diagnose` names them all with this fit: the search among these alone,
    or among all, which may come to them by way of another."""
    for only in ((*effects, *faults), None):
        seen, found = diagnosed(evidence, only=only)
        fit = found.fit
        if fit is not None and set(effects) <= set(fit.effects) <= {*effects, *FAULTS} and found.verdict == "missing":
            accepted = all(one.accepted for one in found.named if one.name in effects)
            break
    else:
        fit, accepted = None, False
    tries = [fit] if fit is not None else []
    if faults or not tries:
        # what has changed with an effect may hide it until all are fitted together
        tries.append(_one_by_one(seen, effects, faults))
    best = min(tries, key=lambda one: one.cost + LEAST_LIMIT * len(one.effects))
    return seen, _in_order(best, effects), accepted and best is fit


def _in_order(fit: Fit, effects: Sequence[str]) -> Fit:
    """The fit with these effects in front, as they were asked for, and what came beside them behind."""
    order = [*effects, *(effect for effect in fit.effects if effect not in effects)]
    places = sorted(range(len(fit.fitted)), key=lambda place: order.index(effect_of(fit.fitted[place])))
    values = {name: fit.values[name] for name in [*(fit.fitted[place] for place in places), *fit.values]}
    return replace(fit, effects=tuple(order), values=values, covariance=fit.covariance[np.ix_(places, places)])


def _one_by_one(evidence: Evidence, effects: Sequence[str], faults: Sequence[str]) -> Fit:
    """All effects and faults at their best: the strongest signature first, all that are in refitted with each that comes."""
    remaining = [*effects, *faults]
    values: dict[str, float] = {}
    here = settled(evidence, values)
    fit: Fit | None = None
    while remaining:
        found = signatures(Screen(here), only=remaining)
        if not found:
            missing = [effect for effect in remaining if effect in effects]
            if missing:
                raise InputError(
                    f"{missing[0]}: the record shows nothing of it{' beside the other effects' if len(effects) > 1 else ''}: nothing can be fitted"
                )
            break
        strongest = found[0]
        remaining.remove(strongest.candidate.effect)
        fit = refit(here, {**values, **strongest.start()})
        values = dict(fit.values)
        here = settled(evidence, values)
    assert fit is not None
    return polished(fit, POLISHED)


def _learned(evidence: Evidence, worn: View, effect: str, record: Record, healthy: Sequence[Record]) -> Fit:
    """The table that the balances suggest beside today's wear, its gain fitted in the loop."""
    places = where(fitted_machine(evidence, None), record, healthy_of(record, healthy), evidence.whiten, evidence.channels)
    tables = learned_tables(worn, record, places)
    table = next((table for table in tables if table.effect == effect), None)
    if table is None:
        there = f"; {tables[0].effect} would fit" if tables else ""
        raise InputError(f"{effect}: nothing in the record repeats in a way that it could hold{there}: ema diagnose draws what is left")
    return table_fit(worn, table)


def _correlations(fit: Fit) -> list[tuple[str, str, float]]:
    """Pairs of fitted values that move together, strongest first."""
    names = fit.fitted
    spread = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    matrix = fit.covariance / np.outer(spread, spread)
    pairs = [(names[i], names[k], float(matrix[i, k])) for i in range(len(names)) for k in range(i)]
    return sorted((pair for pair in pairs if abs(pair[2]) > _CORRELATED), key=lambda pair: -abs(pair[2]))


def _judged(
    fit: Fit, effect: str, errors: ErrorFall, before: float, correlations: Sequence[tuple[str, str, float]], accepted: bool = False
) -> Judgement:
    """What an effect that took the error from the cost `before` is judged by; `accepted`: the search has named it already."""
    if not accepted and before - fit.cost < LEAST_LIMIT:
        return Judgement(Why.NOISE)
    if not accepted and not fit.determined(effect):
        return Judgement(Why.UNDETERMINED)
    bound = [name for name in fit.at_bound if effect_of(name) == effect]
    if bound:
        return Judgement(Why.AT_BOUND, bound[0])
    if (
        errors.holdout_before is not None
        and errors.holdout_after is not None
        and errors.holdout_after > (1.0 - _FALL) * errors.holdout_before
    ):
        return Judgement(Why.NOT_HELD)
    size = next(iter(fit.of_effect(effect)))
    tied = [pair for pair in correlations if size in pair[:2]]
    if tied:
        other = tied[0][1] if tied[0][0] == size else tied[0][0]
        return Judgement(Why.TIED, other, tied[0][2])
    return Judgement(Why.HELD if errors.holdout_before is not None else Why.FALLS)
