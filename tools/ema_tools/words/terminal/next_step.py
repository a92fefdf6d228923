"""The last line of an answer: what to do next, with a command that can be copied; the same as on the result's page and in `next` of the JSON result."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.results.addition import Addition
from ema_tools.results.calibration import CalibrationResult
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import IdentificationResult
from ema_tools.words import advice


def say_next(
    console: Console,
    found: IdentificationResult | ComparisonResult | MapResult | Addition | DiagnosisResult | DiagnosisByBalanceResult | CalibrationResult,
) -> bool:
    """Prints the advice, unless a reason of the answer has the same command; returns whether there is a command."""
    reply = advice.reply_to(found)
    said = " ".join(found.reasons) if isinstance(found, IdentificationResult) else ""
    if reply.command and reply.command not in said:
        console.print(Text(advice.sentence(reply)))
    return bool(reply.command)
