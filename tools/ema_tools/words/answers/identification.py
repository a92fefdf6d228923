"""The result of `ema identify`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

from ema_tools.base.arrays import Reals
from ema_tools.base.interval import interval_of
from ema_tools.plant.least_squares import FoundValue
from ema_tools.plant.native import Identification
from ema_tools.results import identification as result
from ema_tools.results.parts import CurvesEntry, Provenance, Sensor
from ema_tools.select.cross_check import CrossCheck
from ema_tools.tasks.identify import Identified
from ema_tools.tasks.objective_shape import Shape
from ema_tools.tasks.onboard_search import KEYS, MIN_SHIFTS, identified_of
from ema_tools.tasks.several_values import SeveralValues
from ema_tools.words.answers.steps import field_of, sensor
from ema_tools.words.sentences.identification import reasons, sentence, undetermined_words

# Objections that name an effect, or say that there is none to name.
_NAMING = ("missing", "unknown", "rival")
_ZERO = "the healthy value is zero, and a shift is counted in % of it"


def identification(
    found: Identified, name: str, provenance: Provenance, curves: CurvesEntry | None = None, shape: Shape | None = None, **case: Any
) -> result.IdentificationResult:
    """What was found on a record of that name, with the `shape` of the objective round it; `case` and `noise` where the truth is known."""
    answer = found.answer
    return result.IdentificationResult(
        **case,
        name=name,
        **_values(found),
        objective_before_mm2s=answer.objective_before,
        objective_after_mm2s=answer.objective_after,
        evaluations=answer.evaluations,
        verdict=cast(result.Verdict, found.verdict),
        adequate=found.adequate,
        reasons=reasons(found),
        missing_effect=_missing(found.checked)
        if found.checked is not None and (found.objection in _NAMING or found.stands_beside_effect)
        else None,
        sensor=_sensor(found),
        guard=None if found.checked is None else _guard(found, found.checked),
        table=None if answer.finding is None else result.TableFinding(**vars(answer.finding)),
        sentence=sentence(found),
        residual_rms_mm=answer.residual_rms_mm,
        residual_correlation=answer.residual_correlation,
        outcome=answer.outcome,
        accepted=answer.accepted,
        accepted_uphill=answer.accepted_uphill,
        model_steps=answer.model_steps,
        wall_s=found.wall_s,
        seed=found.seed,
        precision=found.precision,
        baseline=None
        if found.baseline is None
        else result.BaselineEntry(
            dict(found.baseline.values),
            dict(found.baseline.std),
            found.baseline.records,
            {name: interval_of(value, found.baseline.std[name]) for name, value in found.baseline.values.items()},
            found.since,
        ),
        search=result.SearchEntry(found.costs),
        shape=None if shape is None else _shape(shape),
        undetermined={} if shape is None else {KEYS[one.name]: undetermined_words(one) for one in shape.undetermined},
        seeds=tuple(map(_seed, found.seeds)),
        provenance=provenance,
        curves=curves,
    )


def values(several: SeveralValues) -> Mapping[str, Any]:
    """The fields of the result for several values that were searched at once."""

    def finite(number: float) -> float | None:
        return number if math.isfinite(number) else None

    def entry(one: FoundValue) -> result.ValueEntry:
        return result.ValueEntry(
            one.estimate,
            several.interval95(one),
            one.determined if several.determined(one) or one.determined != "yes" else "no",
            one.alike,
            several.before[one.name],
            finite(one.std),
            finite(one.noise_std),
            one.at_bound,
            several.companions.get(one.name),
        )

    found = several.found
    return {
        "values": {one.name: entry(one) for one in found.values},
        "values_search": result.ValuesSearchEntry(
            dict(several.noise), found.misfit_before, found.misfit_after, found.adequate, found.runs, found.starts, found.outcome
        ),
    }


def _values(found: Identified) -> Mapping[str, Any]:
    absent = {
        key: result.NotIdentified(None, None, None, 0.0, _ZERO) for name, key in KEYS.items() if name not in identified_of(found.healthy)
    }
    return absent | {
        KEYS[one.name]: result.EstimateEntry(
            one.estimate,
            one.std,
            one.shift_percent,
            found.interval95(one),
            found.healthy[one.name],
            one.at_bound,
            one.bias,
            found.healthy[MIN_SHIFTS[one.name]],
        )
        for one in found.answer.identified
    }


def _sensor(found: Identified) -> Sensor | None:
    """Whose error is suspected where that is what objects to the answer."""
    checked = found.checked
    if found.objection != "unknown" or checked is None or checked.unusable or checked.sensor is None:
        return None
    return sensor(checked.sensor)


def _guard(found: Identified, checked: CrossCheck) -> result.Guard:
    return result.Guard(
        verdict=checked.kind,
        objection=found.objection,
        signals=checked.signals,
        shift_percent={KEYS[name]: 100.0 * shift for name, shift in checked.shift.items()},
        open_std_percent={KEYS[name]: 100.0 * one.std / abs(found.healthy[name]) for name, one in checked.open.items()},
        skipped=checked.skipped or None,
        wall_s=checked.wall_s,
    )


def _missing(checked: CrossCheck) -> result.MissingEffect:
    return result.MissingEffect(
        checked.effects[0] if checked.effects else None,
        tuple(checked.effects),
        {field_of(name): value for name, value in checked.values.items()},
        {field_of(name): value for name, value in checked.std.items()},
        dict(checked.faults),
        checked.against,
        {field_of(name): interval_of(checked.values[name], std) for name, std in checked.std.items() if name in checked.values},
    )


def _shape(shape: Shape) -> result.ShapeEntry:
    profiles = {
        KEYS[one.name]: result.ProfileEntry(_series(one.values), _series(one.objective), one.limit)
        for one in shape.profiles
        if one.name in KEYS
    }
    surface = shape.surface
    drawn = None
    if surface is not None and surface.names == tuple(KEYS):
        drawn = result.MapEntry(_series(surface.values[0]), _series(surface.values[1]), tuple(map(_series, surface.objective)))
    path = {KEYS[name]: _series(values) for name, values in shape.tried.items()}
    return result.ShapeEntry(**profiles, map=drawn, path=path, path_cost_mm2s=_series(shape.cost))


def _series(values: Reals) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _seed(other: Identification) -> result.Seed:
    values = {KEYS[estimate.name]: estimate.estimate for estimate in other.identified}
    return result.Seed(other.objective_after, other.evaluations, **values)
