"""Puts one effect into a model: fits it to a record, says by how much the error falls there and on a record held out, and whether to keep it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.compare import unexplained as unknowns
from ema_tools.compare.localisation import where
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, View, settled
from ema_tools.fit.refit import Fit, polished, refit
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.select.baseline import gather
from ema_tools.select.beside_fault import beside_faults, known_machine
from ema_tools.select.candidates import signatures
from ema_tools.select.holdout import Errors, Step, fitted_machine, walk
from ema_tools.select.search import LEAST_LIMIT, Diagnosis
from ema_tools.tasks.diagnose import answerable, check_records, healthy_of, size_text

_STARTS = 4
_ROUNDS = 3
# Two fitted values that move together beyond this cannot be told apart.
_CORRELATED = 0.95
# What moves before the effect is added to a machine that is known.
_FAULTS_ALONE = "CSJ and BLK alone"
# The error on a record held out must fall, by more than the rounding of what is reported.
_FALL = 1e-3


@dataclass(frozen=True)
class Added:
    """The model with the effect, what was fitted, and whether it is recommended; `actuator` is what `ema add` writes. `refitted`: the model held the effect before."""

    effect: str
    actuator: Actuator
    fit: Fit
    errors: Errors
    steps: tuple[Step, ...]
    recommended: bool
    reason: str
    correlations: tuple[tuple[str, str, float], ...]
    refitted: bool = False

    @property
    def fitted(self) -> Actuator:
        """The machine as the record shows it: with the effect, and with CSJ and BLK as far as they were fitted beside it."""
        return self.actuator.changed(self.fit.values)

    def sentence(self) -> str:
        """What was done and what came of it."""
        own = self.fit.of_effect(self.effect)
        size = next(iter(own))
        done = "was there and is refitted" if self.refitted else "added"
        errors = f"{self.errors.before:.3g} before, {self.errors.after:.3g} after, floor {self.errors.floor:.3g}"
        text = f"{self.effect} {done}, {row_of(size).field} {size_text(size, own[size], self.fit.std.get(size))}: weighted error {errors}"
        if self.errors.holdout_before is not None:
            text += f"; on the record held out {self.errors.holdout_before:.3g} before, {self.errors.holdout_after:.3g} after"
        return f"{text}. {'Recommended' if self.recommended else 'Not recommended'}: {self.reason}."

    def result(self) -> dict[str, Any]:
        """For JSON: the keys that programs read, and more."""
        return {
            "effect": self.effect,
            "sentence": self.sentence(),
            "error": self.errors.result(),
            "parameters": {
                name: {"value": value, "std": self.fit.std.get(name), "unit": row_of(name).unit, "at_bound": name in self.fit.at_bound}
                for name, value in self.fit.values.items()
            },
            "correlations": [{"values": [first, second], "correlation": value} for first, second, value in self.correlations],
            "steps": [
                {
                    "effects": list(step.effects),
                    "added": step.added or "as given",
                    "error_training": step.error,
                    "error_holdout": step.holdout,
                }
                for step in self.steps
            ],
            "recommended": self.recommended,
            "reason": self.reason,
        }


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
    tell = report or (lambda _share, _text: None)
    row = next((row for row in load_definitions().effects if row.name == effect), None)
    if row is None:
        raise InputError(f"{effect}: no such effect: ema effects lists the library")
    check_records(record, healthy, holdout)
    answerable(actuator, record, healthy_of(record, healthy))
    evidence = gather(actuator, record, healthy_of(record, healthy), report=lambda share, text: tell(0.5 * share, text))
    here = settled(evidence, {})
    tell(0.6, f"fitting {effect}")
    fit = _learned(evidence, here, effect, record, healthy) if row.is_learned else _fitted(here, effect)
    before = here.cost
    diagnosis = Diagnosis("missing", fit, (), (), (fit,), before, fit.cost, evidence.expected_cost(), 0.0, LEAST_LIMIT)
    tell(0.9, "the record held out")
    errors, steps = walk(diagnosis, evidence, holdout, healthy_of(holdout, healthy) if holdout is not None else ())
    correlations = tuple(_correlations(fit))
    recommended, reason = _judged(fit, effect, errors, before, correlations)
    own = fit.of_effect(effect)
    tell(1.0, "done")
    return Added(
        effect,
        fitted_machine(evidence, fit).changed(own),
        fit,
        errors,
        steps,
        recommended,
        reason,
        correlations,
        effect in actuator.active_effects,
    )


def add_to_known(actuator: Actuator, effect: str, record: Record, holdout: Record | None = None, report: Report | None = None) -> Added:
    """Fits `effect` to a record of a machine that is as `actuator` says but for its CSJ and BLK, which are free: what is written keeps their healthy values. Raises InputError as `add` does."""
    tell = report or (lambda _share, _text: None)
    if next((row.is_learned for row in load_definitions().effects if row.name == effect), True):
        raise InputError(
            f"{effect}: a table that is learned, or no effect at all: --known takes the physical effects that ema effects lists"
        )
    tell(0.1, f"fitting {effect} beside CSJ and BLK")
    check_records(record, (), holdout)
    answerable(actuator, record, ())
    evidence = known_machine(actuator, record)
    alone, together = beside_faults(evidence, effect)
    before = settled(evidence, alone).cost
    fit = polished(refit(settled(evidence, together, rounds=1), together), _ROUNDS)
    diagnosis = Diagnosis("missing", fit, (), (), (fit,), before, fit.cost, evidence.expected_cost(), 0.0, LEAST_LIMIT)
    tell(0.9, "the record held out")
    errors, steps = walk(diagnosis, evidence, holdout)
    steps = (steps[0], replace(steps[1], added=_FAULTS_ALONE, holdout=None), *steps[2:])
    correlations = tuple(_correlations(fit))
    recommended, reason = _judged(fit, effect, errors, before, correlations)
    tell(1.0, "done")
    return Added(
        effect,
        actuator.changed(fit.of_effect(effect)),
        fit,
        errors,
        steps,
        recommended,
        reason,
        correlations,
        effect in actuator.active_effects,
    )


def set_result(actuator: Actuator, effect: str, before: Actuator) -> dict[str, Any]:
    """For JSON: an effect whose values were given and not fitted, in the keys of `Added.result`; `replaced`: what it was in the actuator `before`, None where it was absent."""
    row = load_definitions().effect(effect)
    own = {f"effects.{value.name}": actuator[value.name] for value in row.parameters}
    there = {f"effects.{value.name}": before[value.name] for value in row.parameters} if effect in before.active_effects else None
    was = f"{effect} was there with {row.size.field} = {before[row.size.name]:g}; it is now" if there else f"{effect}"
    return {
        "effect": effect,
        "sentence": f"{was} set to given values; nothing was fitted.",
        "replaced": there,
        "error": dict.fromkeys(("before", "after", "floor", "holdout_before", "holdout_after")),
        "parameters": {name: {"value": value, "std": None, "unit": row_of(name).unit, "at_bound": False} for name, value in own.items()},
    }


def _fitted(here: View, effect: str) -> Fit:
    """The effect at its best; against healthy repeats beside CSJ and BLK where they have changed too, which may hide the effect until they are fitted with it."""
    evidence = here.evidence
    found = signatures(here, only=effect)[:_STARTS]
    fits = each(lambda signature: refit(here, signature.start()), found)
    tries = [polished(min(fits, key=lambda fit: fit.cost), _ROUNDS)] if fits else []
    if evidence.relative and any(evidence.actuator[value] > 0.0 for value in FAULTS.values()):
        _, together = beside_faults(evidence, effect)
        tries.append(polished(refit(settled(evidence, together, rounds=1), together), _ROUNDS))
    if not tries:
        raise InputError(f"{effect}: the record shows nothing of it: nothing can be fitted")
    # a changed CSJ and BLK count only where they take off more than noise can make them
    return min(tries, key=lambda fit: fit.cost + (len(fit.effects) - 1) * LEAST_LIMIT)


def _learned(evidence: Evidence, here: View, effect: str, record: Record, healthy: Sequence[Record]) -> Fit:
    """The table that the balances suggest, its gain fitted in the loop."""
    machine = fitted_machine(evidence, None)
    places = where(machine, record, healthy_of(record, healthy), evidence.whiten, evidence.channels)
    tables = [table for one in unknowns.left_over(machine, record, places) if (table := unknowns.learned(one)) is not None]
    table = next((table for table in tables if table.effect == effect), None)
    if table is None:
        there = f"; {tables[0].effect} would fit" if tables else ""
        raise InputError(f"{effect}: nothing in the record repeats in a way that it could hold{there}: ema diagnose draws what is left")
    gain = f"effects.{effect}.gain"
    shape = {name: value for name, value in table.changes.items() if name != gain}
    return refit(here, {gain: 1.0}, shape)


def _correlations(fit: Fit) -> list[tuple[str, str, float]]:
    """Pairs of fitted values that move together, strongest first."""
    names = fit.fitted
    spread = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    matrix = fit.covariance / np.outer(spread, spread)
    pairs = [(names[i], names[k], float(matrix[i, k])) for i in range(len(names)) for k in range(i)]
    return sorted((pair for pair in pairs if abs(pair[2]) > _CORRELATED), key=lambda pair: -abs(pair[2]))


def _judged(fit: Fit, effect: str, errors: Errors, before: float, correlations: Sequence[tuple[str, str, float]]) -> tuple[bool, str]:
    if before - fit.cost < LEAST_LIMIT:
        return False, "the error on the fitted record does not fall by more than noise can make it"
    if not fit.determined(effect):
        return False, "its size could as well be none beside what the model does not explain: ema diagnose says what would explain more"
    bound = [name for name in fit.at_bound if effect_of(name) == effect]
    if bound:
        return False, f"{bound[0]} lies on a bound of its range, so the effect stands in for another one"
    if (
        errors.holdout_before is not None
        and errors.holdout_after is not None
        and errors.holdout_after > (1.0 - _FALL) * errors.holdout_before
    ):
        return False, "the error on the record held out does not fall"
    size = next(iter(fit.of_effect(effect)))
    tied = [pair for pair in correlations if size in pair[:2]]
    if tied:
        other = tied[0][1] if tied[0][0] == size else tied[0][0]
        return True, f"the error falls, but its size cannot be told from {other} (correlation {tied[0][2]:.2f}) on this record"
    held = (
        " on the fitted record and on the one held out"
        if errors.holdout_before is not None
        else " on the fitted record; no record was held out"
    )
    return True, f"the error falls{held}"
