"""The result of `ema diagnose`, by simulation."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import cast

from ema_tools.base.interval import interval95
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.results import diagnosis as result
from ema_tools.results.parts import CurvesEntry, EffectEntry, Provenance
from ema_tools.select.outcome import Diagnosis as Searched
from ema_tools.select.outcome import Named
from ema_tools.tasks.diagnose import Answer
from ema_tools.words.answers.localisation import localisation
from ema_tools.words.answers.steps import errors, field_of, sensor, steps
from ema_tools.words.answers.unexplained import unexplained
from ema_tools.words.answers.validity import validity
from ema_tools.words.sentences.diagnosis import hidden, record_next, sentence

# Effects that are listed.
_LISTED = 12


def diagnosis(found: Answer, provenance: Provenance, curves: CurvesEntry | None = None) -> result.DiagnosisResult:
    """What was found on the record."""
    named = [one for one in found.diagnosis.named if one.name not in FAULTS]
    relative = found.evidence.relative
    return result.DiagnosisResult(
        name=found.record.file,
        verdict=cast(result.Verdict, found.verdict),
        sentence=sentence(found),
        mode="against healthy repeats" if relative else "without healthy repeats",
        cannot_see=hidden(found) or None,
        effects=tuple(_effect(one, found.diagnosis) for one in named[:_LISTED]),
        rivals=tuple(dict.fromkeys(name for names in found.rivals for name in names[1:])),
        faults={one.name: _fault(one, found) for one in found.faults},
        standing=_standing(found) if relative else {},
        unit_shift_percent={field_of(name): 100.0 * shift for name, shift in found.unit_shift.items()},
        error=errors(found.errors),
        next_experiment=record_next(found),
        unexplained=found.diagnosis.unexplained,
        unnamed=found.diagnosis.unnamed,
        steps=steps(found.steps),
        gate=validity(found.gate),
        where=localisation(found.where, found.sensor),
        unknown=unexplained(found.left, found.learned) if found.left else None,
        sensor=sensor(found.sensor) if found.sensor is not None else None,
        provenance=provenance,
        curves=curves,
    )


def _standing(found: Answer) -> dict[str, dict[str, float]]:
    effects = (load_definitions().effect(name) for name in found.known.active_effects)
    return {effect.name: {value.field: found.known[value.name] for value in effect.parameters} for effect in effects}


def _effect(one: Named, found: Searched) -> EffectEntry:
    at_bound = found.fit.at_bound if found.fit is not None else ()
    return EffectEntry(
        name=one.name,
        alike=tuple(name for name in one.alike if name not in FAULTS),
        looks_like_fault=tuple(name for name in one.alike if name in FAULTS and name != one.name),
        parameters={field_of(name): value for name, value in one.values.items()},
        std={field_of(name): value for name, value in one.std.items()},
        interval95={field_of(name): interval95(one.values[name], std) for name, std in one.std.items()},
        at_bound=tuple(field_of(name) for name in one.values if name in at_bound),
        score=one.score,
        limit=one.limit,
        accepted=one.accepted,
        probability=one.probability,
    )


def _fault(one: Named, found: Answer) -> EffectEntry:
    """A changed CSJ or BLK, also in % of what the healthy machine has."""
    name = FAULTS[one.name]
    healthy, (low, high) = found.known[name], interval95(one.values[name], one.std.get(name, math.nan))
    ends = (None, None) if low is None or high is None else (100.0 * (low / healthy - 1.0), 100.0 * (high / healthy - 1.0))
    return replace(_effect(one, found.diagnosis), shift_percent=100.0 * (one.values[name] / healthy - 1.0), shift_interval95=ends)
