"""The result of `ema diagnose`, by the balance of forces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.balances.motion import Motion, at_points
from ema_tools.base.interval import interval95
from ema_tools.compare.validity import RecordRemark, RecordValidity
from ema_tools.data.actuator import Actuator, row_of, shown
from ema_tools.fit.division import By
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import called, record_of
from ema_tools.results import diagnosis as result
from ema_tools.results.localisation import Localisation, Pictures
from ema_tools.results.parts import ComparedErrors, CurvesEntry, EffectEntry, ErrorsEntry, Provenance, StepEntry
from ema_tools.select.balance_bench import FoldErrors
from ema_tools.select.base_values import BaseValue
from ema_tools.select.force_steps import ForceStep, ForceSteps, Refusal
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Change
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer
from ema_tools.words.answers.localisation import localisation
from ema_tools.words.answers.steps import FIRST, FORCE_UNIT, REFITTED, field_of, forward, loads
from ema_tools.words.answers.validity import validity
from ema_tools.words.sentences.balance import TELLING, next_step, sentence, swing_called
from ema_tools.words.sentences.base_values import contradiction
from ema_tools.words.sentences.machine_units import units_of

_SPEEDS = 200  # that friction is worked out at [layout]
_MODES: dict[By, Literal["laps of one record", "stretches of one record", "several records"]] = {
    "lap": "laps of one record",
    "block": "stretches of one record",
    "record": "several records",
}


def diagnosis_by_balance(
    found: BalanceAnswer, provenance: Provenance, curves: CurvesEntry | None = None
) -> result.DiagnosisByBalanceResult:
    """What was found on the records."""
    way = found.forces
    last = way.errors
    kept = {step.effect for step in found.accepted}
    return result.DiagnosisByBalanceResult(
        name=found.record.file,
        verdict=found.verdict,
        sentence=sentence(found),
        records=tuple(record.file for record in found.records),
        holdout=tuple(record.file for record in found.holdout),
        mode=_MODES[way.division.by] if found.healthy is None else "against healthy records",
        effects=(*(_accepted(way, step) for step in found.accepted), *(_refused(one) for one in way.refused if one.effect not in kept)),
        faults={fault: entry for fault, name in FAULTS.items() for entry in _fault(found, name, fault)},
        standing=_standing(found),
        healthy=None if found.healthy is None else _healthy(found, found.healthy),
        as_well=found.as_well or None,
        changes={shown(row_of(one.name)): _change(found, one) for one in found.changes},
        error=ErrorsEntry(way.given.training, last.training, found.floor_percent, way.given.holdout, last.holdout),
        error_unit=FORCE_UNIT,
        floor_from=found.floor_from,
        forward=forward(found.forward),
        rivals=tuple(dict.fromkeys(called(other) for step in found.accepted for other in step.alike if other not in kept)),
        next_experiment=next_step(found),
        unexplained=found.unexplained,
        untellable=(found.verdict == "unknown" and found.untellable) or None,
        steps=_steps(way),
        forces=forces_of(way, found.compared),
        base={shown(row_of(one.name)): _base(one) for one in found.base},
        rod_m_per_rad=units_of(found.known, found.records).m_per_rad,
        friction=_with_measured(friction(way.actuator, float(np.max(np.abs(way.curves["speed_rad_s"])))), found),
        drive_lag_s=way.actuator.drive_lag_s or None,
        gate=validity(_with_contradiction(found)),
        where=localisation(found.where) if found.where is not None else Localisation(pictures=found.pictures or Pictures()),
        provenance=provenance,
        curves=curves,
    )


def _standing(found: BalanceAnswer) -> dict[str, dict[str, float]]:
    """Effects that the healthy machine has, with their values by field."""
    if found.healthy is None:
        return {}
    return {
        name: {row.field: found.known[row.name] for row in load_definitions().effect(name).parameters} for name in found.healthy.standing
    }


def _healthy(found: BalanceAnswer, machine: HealthyByBalance) -> result.HealthyEntry:
    values = {
        shown(row_of(name)): result.HealthyValue(value, machine.refit.std.get(name), machine.scatter.get(name), row_of(name).unit)
        for name, value in machine.refit.values.items()
        if name in machine.refit.std and name not in machine.refit.kept
    }
    return result.HealthyEntry(
        tuple(record.file for record in machine.records),
        values,
        "records" if machine.sure else "parts of records",
        not machine.sure,
        found.healthy_percent,
        machine.times,
    )


def _base(one: BaseValue) -> result.BaseEntry:
    return result.BaseEntry(
        one.value,
        one.std if math.isfinite(one.std) else None,
        one.interval95,
        row_of(one.name).unit,
        one.stated,
        "import" if one.by_import else "file",
        one.times if math.isfinite(one.times) else None,
        one.contradicts,
        one.kept or None,
        one.at_end,
        one.hardly_seen,
        one.error_as_stated_percent if math.isfinite(one.error_as_stated_percent) else None,
    )


def _of_all(found: BalanceAnswer) -> RecordValidity:
    """The judgement of the first record, with what is said of others and not of it, each once."""
    first, said = found.gates[0], {remark.topic for remark in found.gates[0].remarks}
    more = []
    for record, gate in zip(found.records[1:], found.gates[1:], strict=True):
        for remark in gate.remarks:
            if remark.topic not in said:
                said.add(remark.topic)
                more.append(replace(remark, text=remark.text if record.file in remark.text else f"{record.file}: {remark.text}"))
    return replace(first, remarks=(*first.remarks, *more)) if more else first


def _with_contradiction(found: BalanceAnswer) -> RecordValidity:
    """The judgement of all records, with what the fit says against the actuator's file: a scale that is wrong passes every other look."""
    gate, text = _of_all(found), contradiction(found.base, found.record, units_of(found.known, found.records))
    return replace(gate, remarks=(RecordRemark("scale", "weakens", text), *gate.remarks)) if text else gate


def _change(found: BalanceAnswer, one: Change) -> result.ChangeEntry:
    change = one.today - one.healthy
    percent = 100.0 * change / one.healthy if abs(change) <= TELLING * abs(one.healthy) else None
    called = swing_called(one.name, found.known, units_of(found.known, found.records)) or None
    return result.ChangeEntry(
        one.healthy, one.today, percent, interval95(change, one.std), one.limit, one.counts, row_of(one.name).unit, called
    )


def _fault(found: BalanceAnswer, name: str, fault: str) -> Iterator[EffectEntry]:
    """A fault's value that has changed."""
    for one in found.changed:
        if one.name == name:
            field = row_of(name).field
            yield EffectEntry(
                name=fault,
                alike=(fault,),
                parameters={field: one.today},
                std={field: one.std},
                interval95={field: interval95(one.today, one.std)},
                score=abs(one.today - one.healthy),
                limit=one.limit,
                accepted=True,
                shift_percent=100.0 * (one.today / one.healthy - 1.0) if one.healthy else None,
            )


def friction(actuator: Actuator, fastest_rad_s: float) -> result.FrictionShape | None:
    """Steady friction of a model over the speeds of the records; None where it is least at standstill, as without a bump."""
    speeds = np.concatenate(([0.0], np.geomspace(1e-3, 1.0, _SPEEDS) * fastest_rad_s))
    nothing = np.zeros_like(speeds)
    motion = Motion(nothing, np.maximum(speeds, 1e-9), nothing, nothing, nothing)
    level = actuator["screw.csj_Nm"] * actuator["screw.dynamic_ratio"]
    drag = level + at_points(actuator, motion, "FRICTION", level_Nm=level) - at_points(actuator, motion, "TORQUE")
    total = drag + adjusted(actuator)["screw.viscous_Nm_s_per_rad"] * speeds
    least = int(np.argmin(total))
    if not least or not total[least] > 0.0:
        return None
    return result.FrictionShape(float(total[0]), float(total[least]), float(speeds[least]), 100.0 * float(total[0] / total[least] - 1.0))


def _with_measured(shape: result.FrictionShape | None, found: BalanceAnswer) -> result.FrictionShape | None:
    """A model's friction beside that of runs at constant speed, where there are enough."""
    bump = found.bump if shape is not None else None
    if shape is None or bump is None:
        return shape
    return replace(shape, measured=result.MeasuredFriction(bump.slowest_rad_s, bump.above_percent, bump.least_at_rad_s))


def _steps(way: ForceSteps) -> tuple[StepEntry, ...]:
    steps = [
        StepEntry((), FIRST, way.given.training, way.given.holdout),
        StepEntry((), REFITTED, way.refitted.training, way.refitted.holdout, values=loads(way.refitted_values)),
    ]
    names: tuple[str, ...] = ()
    for step in way.steps:
        names = (*names, called(step.effect))
        steps.append(StepEntry(names, called(step.effect), step.errors.training, step.errors.holdout, values=loads(step.values)))
    return tuple(steps)


def _accepted(way: ForceSteps, step: ForceStep) -> EffectEntry:
    """One accepted effect, with its size as the last joint fit has it."""
    place = way.steps.index(step)
    before = way.steps[place - 1].errors if place else way.refitted
    values, std = _numbers(step.effect, way.steps[-1].values), _numbers(step.effect, way.steps[-1].std)
    return EffectEntry(
        name=called(step.effect),
        alike=(called(step.effect), *map(called, step.alike)),
        parameters=values,
        std=dict(std),
        interval95={name: interval95(values[name], doubt) for name, doubt in std.items() if name in values},
        score=before.holdout**2 - step.errors.holdout**2,
        limit=0.0,
        accepted=True,
    )


def _refused(one: Refusal) -> EffectEntry:
    return EffectEntry(
        name=called(one.effect),
        alike=(called(one.effect),),
        parameters=_numbers(one.effect, one.values),
        std=dict(_numbers(one.effect, one.std)),
        score=0.0,
        limit=0.0,
        accepted=False,
        reason=one.reason,
    )


def _numbers(effect: str, values: Mapping[str, float]) -> dict[str, float]:
    """Values of one effect by field."""
    own = {name: value for name, value in values.items() if name.startswith(f"{effect}.")}
    base_value = record_of(effect).base_value
    found = own or {name: value for name, value in values.items() if name == base_value}
    return {field_of(name): float(value) for name, value in found.items()}


def forces_of(way: ForceSteps, compared: tuple[float, float] | None = None) -> result.Forces:
    """The balance, effect by effect; `compared`: what `ema compare` reads before and after."""
    known, effects = way.actuator, way.actuator.active_effects
    names = (*MECHANICAL_PARAMETERS, *(row.name for row in load_definitions().effect_values if row.effect in effects))
    division = way.division
    return result.Forces(
        result.ForceSummary(_errors(way.given), _errors(way.refitted), way.floor_percent, ComparedErrors(*compared) if compared else None),
        tuple(_step(step, step.effect in effects) for step in way.steps),
        tuple(map(_refusal, way.refused)),
        {name: known[name] for name in names},
        result.LapsEntry(
            division.count, division.laps[0].period_rows * (way.period_s or 0.0) or None, division.folds, division.folds, division.by
        ),
        {name: tuple(values.tolist()) for name, values in way.curves.items()},
    )


def _errors(one: FoldErrors) -> result.ForceErrors:
    return result.ForceErrors(one.training, one.holdout, one.each)


def _values(values: Mapping[str, float], std: Mapping[str, float]) -> dict[str, result.ForceValue]:
    return {name: result.ForceValue(value, std.get(name), row_of(name).unit) for name, value in values.items()}


def _step(step: ForceStep, kept: bool) -> result.ForceStepEntry:
    return result.ForceStepEntry(
        **vars(_errors(step.errors)),
        effects=(called(step.effect),),
        added=called(step.effect),
        alike=(called(step.effect), *map(called, step.alike)),
        parameters=_values(step.values, step.std),
        elsewhere={by: result.Elsewhere(before, after) for by, (before, after) in step.elsewhere.items()},
        recommended=True,
        reason="",
        kept=kept,
    )


def _refusal(one: Refusal) -> result.ForceRefusal:
    there = vars(_errors(one.errors)) if one.errors is not None else {}
    return result.ForceRefusal(
        effect=called(one.effect), reason=one.reason, parameters=_values(one.values, one.std), recommended=False, **there
    )
