"""The last line of an answer: what to do next, with a command that can be copied; the same as on the result's page and in `next` of the JSON result."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.results.identification import IdentificationResult
from ema_tools.words.advice import Advised, advice_of


def say_next(console: Console, found: Advised) -> bool:
    """Prints the advice, unless a reason of the answer has the same command; returns whether there is a command."""
    advice = advice_of(found)
    said = " ".join(found.reasons) if isinstance(found, IdentificationResult) else ""
    if advice.arguments and advice.command not in said:
        console.print(Text(advice.printed))
    return bool(advice.arguments)
