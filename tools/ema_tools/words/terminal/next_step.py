"""The last line of an answer: what to do next, with a command that can be copied; the same as on the result's page."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import IdentificationResult
from ema_tools.words.page.results import shown
from ema_tools.words.page.several_page import own_answers


def say_next(console: Console, found: IdentificationResult | ComparisonResult | MapResult) -> None:
    """Prints it, unless a reason of the answer has said the same already."""
    last = own_answers(shown(found, found.command, found.name or "")).replies[-1]
    said = " ".join(found.reasons) if isinstance(found, IdentificationResult) else ""
    if last.command and last.command not in said:
        console.print(Text(f"Next: {last.short[:1].lower()}{last.short[1:]}: {last.command}"))
