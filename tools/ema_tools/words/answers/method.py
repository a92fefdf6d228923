"""The result of `ema diagnose`, by whichever method."""

from __future__ import annotations

from dataclasses import replace

from ema_tools.results import diagnosis as result
from ema_tools.results.parts import CurvesEntry, Provenance
from ema_tools.tasks.diagnose import Answer
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer
from ema_tools.words.answers.balance import diagnosis_by_balance
from ema_tools.words.answers.diagnosis import diagnosis as by_simulation


def diagnosis(
    found: Answer | BalanceAnswer, provenance: Provenance, curves: CurvesEntry | None = None, because: str = ""
) -> result.DiagnosisResult | result.DiagnosisByBalanceResult:
    """What was found on the record; `because`: why by this method."""
    if isinstance(found, Answer):
        return replace(by_simulation(found, provenance, curves), method_reason=because)
    return replace(diagnosis_by_balance(found, provenance, curves), method_reason=because)
