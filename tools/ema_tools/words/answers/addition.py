"""The result of `ema add`."""

from __future__ import annotations

from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import Actuator, row_of, shown
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import called
from ema_tools.results import addition as result
from ema_tools.results.parts import ComparedErrors, CurvesEntry, ErrorsEntry, FittedValue, Provenance, StepEntry
from ema_tools.select.force_refit import ForceRefit
from ema_tools.tasks.add import Added
from ema_tools.tasks.add_by_balance import BalanceAdded
from ema_tools.words.answers.steps import FIRST, FORCE_UNIT, REFITTED, errors, forward, steps
from ema_tools.words.sentences.addition import reason, reason_by_balance, sentence, sentence_by_balance, set_sentence


def addition(found: Added, record: str, actuator: str, provenance: Provenance, curves: CurvesEntry | None = None) -> result.Addition:
    """What was fitted on a record of that name; `actuator` is the file that was written."""
    fit = found.fit
    return result.Addition(
        name=record,
        actuator=actuator,
        effect=found.effect,
        effects=found.effects or None,
        error_without=dict(found.without) or None,
        sentence=sentence(found),
        error=errors(found.errors),
        parameters={
            name: FittedValue(value, fit.std.get(name), row_of(name).unit, name in fit.at_bound, interval_of(value, fit.std.get(name)))
            for name, value in fit.values.items()
        },
        correlations=tuple(result.Correlation((first, second), value) for first, second, value in found.correlations),
        steps=steps(found.steps),
        recommended=found.recommended,
        reason=reason(found),
        provenance=provenance,
        curves=curves,
    )


def setting(made: Actuator, effect: str, before: Actuator, actuator: str, provenance: Provenance) -> result.Addition:
    """An effect whose values were given and not fitted; `before`: the actuator as given, `actuator`: the file that was written."""
    row = load_definitions().effect(effect)
    names = [value.name for value in row.parameters]
    there = effect in before.active_effects
    return result.Addition(
        actuator=actuator,
        effect=effect,
        sentence=set_sentence(effect, before[row.size.name] if there else None),
        error=ErrorsEntry(None, None),
        parameters={f"effects.{name}": FittedValue(made[name], None, row_of(f"effects.{name}").unit) for name in names},
        replaced={f"effects.{name}": before[name] for name in names} if there else None,
        provenance=provenance,
    )


def addition_by_balance(found: BalanceAdded, actuator: str, provenance: Provenance, because: str) -> result.Addition:
    """What was fitted by the balance of forces; `because`: why by this method."""
    forces = found.forces
    given, before, after = forces.given, forces.refitted, forces.errors
    return result.Addition(
        name=found.records[0].file,
        actuator=actuator,
        effect=called(found.effect),
        sentence=sentence_by_balance(found),
        error=ErrorsEntry(given.training, after.training, forces.floor_percent, given.holdout, after.holdout),
        parameters=fitted_values(forces),
        steps=(
            StepEntry((), FIRST, given.training, given.holdout),
            StepEntry((), REFITTED, before.training, before.holdout),
            StepEntry((called(found.effect),), called(found.effect), after.training, after.holdout),
        ),
        recommended=found.recommended,
        reason=reason_by_balance(found),
        method="balance",
        method_reason=because,
        records=tuple(record.file for record in found.records),
        holdout=tuple(record.file for record in found.holdout),
        error_unit=FORCE_UNIT,
        compared=ComparedErrors(*found.compared),
        forward=forward(found.forward),
        kept=dict(forces.kept),
        held=forces.held,
        drive_lag_s=forces.actuator.drive_lag_s or None,
        provenance=provenance,
    )


def fitted_values(forces: ForceRefit) -> dict[str, FittedValue]:
    """Values of a fit by the balance under their names in the actuator's file, those that were fitted."""
    found = {}
    for name, value in forces.values.items():
        row, at_end = row_of(name), name in forces.at_ends
        # a value on its end does not move
        std = None if at_end else forces.std.get(name)
        if name not in forces.kept and (at_end or std is not None):
            found[shown(row)] = FittedValue(value, std, row.unit, at_end, interval_of(value, std))
    return found
