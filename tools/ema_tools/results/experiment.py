"""What `ema next` writes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from ema_tools.results.parts import Provenance


@dataclass(frozen=True)
class Pair:
    """Two effects on one command."""

    effects: tuple[str, str]
    separation: float  # in standard deviations of the noise


@dataclass(frozen=True)
class OptionEntry:
    """One command of the menu."""

    title: str
    command: str  # as --command takes it
    separation: float  # of the pair that is told apart worst, in standard deviations of the noise
    pairs: tuple[Pair, ...]
    shown: dict[str, float]  # how well it shows each effect, alike
    peak_current_A: float
    peak_speed_mm_s: float


@dataclass(frozen=True)
class SafeLimits:
    """What a command may ask of the machine."""

    stroke_mm: float  # from the middle
    speed_mm_s: float | None  # None where nothing limits it
    current_A: float
    output: float  # share of the controller's range, 0..1


@dataclass(frozen=True)
class Experiment:
    """The command that separates effects best."""

    command: Literal["next"]
    effects: tuple[str, ...]
    channels: tuple[str, ...]  # that are recorded
    sizes: dict[str, dict[str, float]]  # effect to its values, by the last word of their names
    larger: float  # how many times larger than first asked
    needed: float  # separation from which on two effects are told apart
    sentence: str
    best: OptionEntry | None  # None where no command separates them all
    options: tuple[OptionEntry, ...]  # best first
    unsafe: dict[str, str]  # commands that were left out, and why
    limits: SafeLimits
    confused: tuple[tuple[str, str], ...]  # pairs that no command separates
    advice: tuple[str, ...]  # what would separate them
    provenance: Provenance
