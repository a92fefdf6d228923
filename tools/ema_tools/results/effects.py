"""What `ema effects` writes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class EffectValue:
    """One value of an effect."""

    field: str
    unit: str
    zero: float | None  # the size at which the effect is absent; None for a value that is no size
    nominal: float
    lower: float  # end of its range
    upper: float
    text: str  # what it means


@dataclass(frozen=True)
class LibraryEffect:
    """One effect of the library."""

    name: str
    acts_on: str
    learned: bool  # a table, no physical effect
    own: bool  # the user's
    equation: str
    source: str
    signature: str  # what it looks like in a record
    look_alikes: tuple[str, ...]
    parameters: tuple[EffectValue, ...]


@dataclass(frozen=True)
class Effects:
    """The library, or one effect of it."""

    command: Literal["effects"]
    effects: tuple[LibraryEffect, ...]
