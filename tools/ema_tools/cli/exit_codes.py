"""What a script reads of an answer where it asks for it: the exit code of a verdict. 1 and 2 stay those of a bad input and of a wrong usage."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
    from ema_tools.results.identification import IdentificationResult

Command = TypeVar("Command", bound=Callable[..., Any])

HOLDS, MISSING, FAULT, UNDECIDED = 0, 3, 4, 5


def exit_code_option(command: Command) -> Command:
    """--exit-code."""
    return click.option(
        "--exit-code",
        "by_verdict",
        is_flag=True,
        help=f"Exit with the verdict: {HOLDS} holds or healthy, {MISSING} an effect is missing, {FAULT} fault, {UNDECIDED} undecided or unknown.",
    )(command)


def of_identification(found: IdentificationResult) -> int:
    """The code of `identify`: an effect that is missing comes before a verdict that is undecided for it."""
    if found.verdict == "undecided":
        return MISSING if found.missing_effect is not None and found.guard is not None and found.guard.verdict == "missing" else UNDECIDED
    return FAULT if found.verdict == "fault" else HOLDS


def of_diagnosis(found: DiagnosisResult | DiagnosisByBalanceResult) -> int:
    """The code of `diagnose`: an effect that is missing comes before a changed CSJ or BLK beside it."""
    if found.verdict == "missing":
        return MISSING
    if found.verdict == "unknown":
        return UNDECIDED
    return FAULT if any(one.accepted for one in found.faults.values()) else HOLDS


def leave(code: int) -> None:
    """Ends the command with that code."""
    click.get_current_context().exit(code)
