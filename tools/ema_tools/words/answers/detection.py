"""The result of `ema next --detect`."""

from __future__ import annotations

from collections.abc import Mapping

from ema_tools.design.detection import Detection, Limit, Sight
from ema_tools.results import detection as result
from ema_tools.results.parts import Provenance
from ema_tools.words.answers.experiment import limits_of
from ema_tools.words.sentences import detection as say
from ema_tools.words.sentences.experiment import offence


def detection(found: Detection, provenance: Provenance) -> result.DetectionResult:
    """What was found, for the present command and those beside it."""
    one_way = dict.fromkeys(found.one_way, say.ONE_WAY)
    return result.DetectionResult(
        command="next",
        detect=True,
        false_alarm=found.test.false_alarm,
        power=found.test.power,
        runs=found.test.runs,
        channels=found.channels,
        sentence=say.sentence(found),
        present=_sight(found.present, found),
        best=_sight(found.best, found) if found.best is not None else None,
        options=tuple(_sight(one, found) for one in found.options),
        unsafe={command: offence(one) for command, one in found.unsafe.items()} | one_way,
        limits=limits_of(found.limits),
        provenance=provenance,
    )


def _sight(one: Sight, found: Detection) -> result.SightEntry:
    return result.SightEntry(
        one.title,
        one.command,
        one.duration_s,
        _limits(one.onboard),
        _limits(one.signals),
        dict(one.verdict),
        one.false_alarms,
        one.over_wanted,
        one.serves_for(found.present),
        one.peak_current_A,
        one.peak_speed_mm_s,
    )


def _limits(found: Mapping[str, Limit]) -> dict[str, result.LimitEntry]:
    return {name: result.LimitEntry(one.std, one.threshold, one.alone, one.together, one.today) for name, one in found.items()}
