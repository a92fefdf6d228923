"""Whether a record can answer at all."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

Severity = Literal["blocks", "weakens", "fine"]


@dataclass(frozen=True)
class SignalEntry:
    """One signal of the record."""

    present: bool
    hides: str | None  # what the record does not show without it; None where it is there


@dataclass(frozen=True)
class Remark:
    """One thing that was looked at."""

    topic: str
    severity: Severity  # blocks: no answer means anything; weakens: some effects cannot be seen; fine: nothing wrong
    text: str  # what is the case
    next: str | None = None  # what to do; None where nothing is to be done


@dataclass(frozen=True)
class Validity:
    """The judgement of a record."""

    answerable: bool = True  # whether anything that follows means something
    sentence: str = ""
    signals: dict[str, SignalEntry] = field(default_factory=dict)  # by column
    remarks: tuple[Remark, ...] = ()  # the gravest first
    coverage: dict[str, float | None] = field(default_factory=dict)  # numbers about the motion, units in their names
