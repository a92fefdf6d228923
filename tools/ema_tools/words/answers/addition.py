"""The result of `ema add`."""

from __future__ import annotations

from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.library.definitions import load_definitions
from ema_tools.results import addition as result
from ema_tools.results.parts import CurvesEntry, ErrorsEntry, FittedValue, Provenance
from ema_tools.tasks.add import Added
from ema_tools.words.answers.steps import errors, steps
from ema_tools.words.sentences.addition import reason, sentence, set_sentence


def addition(found: Added, record: str, actuator: str, provenance: Provenance, curves: CurvesEntry | None = None) -> result.Addition:
    """What was fitted on a record of that name; `actuator` is the file that was written."""
    fit = found.fit
    return result.Addition(
        name=record,
        actuator=actuator,
        effect=found.effect,
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
