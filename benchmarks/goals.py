"""What a benchmark of answers is held to: shares of its rows, and a table of goals that are met or not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Rows = Sequence[Mapping[str, Any]]
# Of answers about machines: named rightly, at least; wrongly, and healthy ones accused, at most, % [judgement]
RIGHT_PERCENT, WRONG_PERCENT, ACCUSED_PERCENT = 95.0, 1.0, 0.5


@dataclass(frozen=True)
class Goal:
    """What is counted, how much of it was wanted, and the share that was reached, in % and in words."""

    title: str
    limit: str
    reached: tuple[float, str]
    met: bool


def share(rows: Rows, holds: Callable[[Any], bool]) -> tuple[float, str]:
    """In %, and in words with the counts."""
    count = sum(holds(row) for row in rows)
    percent = 100.0 * count / len(rows) if rows else 0.0
    return percent, f"{percent:.1f} % ({count} of {len(rows)})" if rows else "-"


def at_least(title: str, reached: tuple[float, str]) -> Goal:
    """Rightly named."""
    return Goal(title, f">= {RIGHT_PERCENT:g} %", reached, reached[0] >= RIGHT_PERCENT)


def at_most(title: str, reached: tuple[float, str]) -> Goal:
    """Wrongly named."""
    return Goal(title, f"<= {WRONG_PERCENT:g} %", reached, reached[0] <= WRONG_PERCENT)


def rarely(title: str, reached: tuple[float, str]) -> Goal:
    """Accused without a reason."""
    return Goal(title, f"<= 1 of {100.0 / ACCUSED_PERCENT:g}", reached, reached[0] <= ACCUSED_PERCENT)


def table(goals: Sequence[Goal]) -> list[str]:
    """As Markdown, with its heading."""
    return [
        "## Goals",
        "",
        "| goal | limit | met | reached |",
        "|---|---|---|---:|",
        *(f"| {one.title} | {one.limit} | {'yes' if one.met else '**no**'} | {one.reached[1]} |" for one in goals),
        "",
    ]
