"""The result of `ema diagnose`, by whichever method."""

from __future__ import annotations

from ema_tools.results import diagnosis as result
from ema_tools.results.parts import CurvesEntry, Provenance
from ema_tools.tasks.diagnose import Answer
from ema_tools.tasks.diagnose_by_laps import LapsAnswer
from ema_tools.words.answers.diagnosis import diagnosis as by_simulation
from ema_tools.words.answers.laps import diagnosis_by_laps


def diagnosis(
    found: Answer | LapsAnswer, provenance: Provenance, curves: CurvesEntry | None = None
) -> result.DiagnosisResult | result.DiagnosisByLapsResult:
    """What was found on the record."""
    return by_simulation(found, provenance, curves) if isinstance(found, Answer) else diagnosis_by_laps(found, provenance, curves)
