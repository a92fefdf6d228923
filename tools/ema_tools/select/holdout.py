"""Errors of one weighting from the first model to the last, on the record that was fitted and on one that was not.

The weighted error is the rms of whitened signals: 1 is what sensor noise alone has where all signals are noisy. A record held out, of another command, is compared with its own
healthy repeats where there are two or more, else with the model itself as it is known of the healthy machine. Only what scatters from run to run may move on it.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, cost_at, raw_cost, settled
from ema_tools.fit.nuisance import moved
from ema_tools.fit.refit import Fit
from ema_tools.results.parts import EXPLAINED
from ema_tools.select.baseline import against_known, alone_against_known
from ema_tools.select.outcome import Diagnosis
from ema_tools.select.run_to_run import freed, varying_as

_SETTLE_ROUNDS = 3  # of linear steps to where what scatters is best on the record held out [effort]
# An effect that a command hardly excites leaves the error of its record as it is; noise moves a weighted rms by half a percent [chance]
_RISE = 1.02
# What moves before any effect is added.
SCATTER = "what scatters from run to run"
UNIT = "the unit's own parameters"


@dataclass(frozen=True)
class ErrorFall:
    """Weighted rms: of the first model, of the last, what a record with nothing new has; and the same on the record held out, None without one."""

    before: float
    after: float
    floor: float
    holdout_before: float | None = None
    holdout_after: float | None = None
    holdout_floor: float | None = None

    @property
    def confirmed(self) -> bool | None:
        """Whether the record held out says the same: its error fell; None without one."""
        if self.holdout_before is None or self.holdout_after is None:
            return None
        return self.holdout_after < self.holdout_before


@dataclass(frozen=True)
class Rung:
    """One model of the way: its effects, what came last (mostly one, both faults where they came together), and the weighted errors; None where there is no record held out.
    What scatters is free in them along its directions, as verdicts need it. `told`: the same two with what scatters no farther than is credible, so that wear is not booked as scatter; of the
    last model the errors themselves. `values`: what makes it of the first model, what scatters included."""

    effects: tuple[str, ...]
    added: str
    error: float
    holdout: float | None
    told: tuple[float, float | None]
    values: Mapping[str, float] = field(default_factory=dict)


def refuted(steps: Sequence[Rung]) -> tuple[str, ...]:
    """Effects whose addition raised the error of the record held out, and all that came after them; none without one."""
    known: set[str] = set()
    for earlier, step in itertools.pairwise(steps):
        if earlier.holdout is not None and step.holdout is not None and step.effects and step.holdout > _RISE * earlier.holdout:
            return tuple(effect for effect in steps[-1].effects if effect not in known)
        known |= set(step.effects)
    return ()


def shows_nothing(steps: Sequence[Rung], errors: ErrorFall) -> bool:
    """Whether the record held out is explained before any effect is added, as a run of the healthy machine is, while the record itself is not."""
    before = next((step.holdout for step in reversed(steps) if not step.effects), None)
    return before is not None and errors.holdout_floor is not None and before <= EXPLAINED * errors.holdout_floor


def weighted(cost: float, evidence: Evidence) -> float:
    """The rms that a cost stands for."""
    return float(np.sqrt(max(cost, 0.0) / evidence.numbers))


def fitted_machine(evidence: Evidence, fit: Fit | None) -> Actuator:
    """The machine beside an answer's effects: as its healthy repeats show it, or without repeats with the unit's own parameters as the record shows them."""
    if evidence.relative:
        return evidence.actuator
    deviations = fit.deviations() if fit is not None else settled(evidence, {}).deviations
    return evidence.actuator.changed(moved(evidence.actuator, evidence.spread, deviations))


def held_out(evidence: Evidence, known: Actuator, record: Record, healthy: Sequence[Record]) -> Evidence:
    """Evidence of a record of another command about the machine `known`; against its own healthy repeats where there are two or more."""
    record = record.on_supply(evidence.supplied)
    if len(healthy) > 1:
        return freed(against_known(known, record, healthy, evidence.channels))
    return varying_as(alone_against_known(evidence, known, record), evidence)


def walk(
    diagnosis: Diagnosis, evidence: Evidence, holdout: Record | None = None, healthy: Sequence[Record] = ()
) -> tuple[ErrorFall, tuple[Rung, ...]]:
    """The fall of the error from the first model over every accepted set of effects, with its twin on `holdout`, a record that nothing was fitted to.

    `healthy`: repeats of the command of `holdout`, where there are any.
    """

    def rung(fit: Fit | None, added: str, cost: float) -> Rung:
        values = fit.values if fit is not None else {}
        deviations = fit.deviations() if fit is not None else settled(evidence, {}).deviations
        error, told = weighted(cost, evidence), weighted(cost_at(evidence, values, deviations), evidence)
        held = told_held = None
        if holdout is not None:
            other = held_out(evidence, fitted_machine(evidence, fit), holdout, healthy)
            there = settled(other, values, rounds=_SETTLE_ROUNDS)
            held, told_held = weighted(there.cost, other), weighted(there.plain_cost, other)
        effects = fit.effects if fit is not None else ()
        return Rung(effects, added, error, held, (told, told_held), {**moved(evidence.actuator, evidence.spread, deviations), **values})

    first = held_out(evidence, evidence.actuator, holdout, healthy) if holdout is not None else None
    given = weighted(raw_cost(evidence), evidence)
    given_held = weighted(raw_cost(first), first) if first is not None else None
    steps = [Rung((), "", given, given_held, (given, given_held))]
    steps.append(rung(None, SCATTER if evidence.relative else UNIT, diagnosis.cost_before))
    known: tuple[str, ...] = ()
    for fit in diagnosis.steps:
        added = " and ".join(effect for effect in fit.effects if effect not in known) or fit.effects[-1]
        steps.append(rung(fit, added, fit.cost))
        known = fit.effects
    steps[-1] = last = replace(steps[-1], told=(steps[-1].error, steps[-1].holdout))
    floor = weighted(diagnosis.cost_floor, evidence)
    return ErrorFall(
        steps[0].error,
        last.error,
        floor,
        steps[0].holdout,
        last.holdout,
        weighted(first.expected_cost(), first) if first is not None else None,
    ), tuple(steps)
