"""What is left after the best known effects."""

from __future__ import annotations

from dataclasses import dataclass

from ema_tools.results.codec import Series
from ema_tools.results.localisation import BinsEntry


@dataclass(frozen=True)
class RankedEntry:
    """One axis that the unknown may repeat with."""

    axis: str
    friction: bool  # counted against the motion
    explained_percent: float  # of its square, on passes to which nothing was fitted
    of_excess_percent: float  # the same of what scatter leaves


@dataclass(frozen=True)
class UnknownOver:
    """Over which axis an unknown stands, and how well it repeats there."""

    by: str  # the axis
    axis_unit: str
    unit: str
    explained_percent: float  # as in `Ranked`
    friction: bool  # counted against the motion


@dataclass(frozen=True)
class UnknownPicture(BinsEntry, UnknownOver):
    """The unknown over an axis; the file states first what it is."""


@dataclass(frozen=True)
class UnknownEntry:
    """What one balance leaves."""

    balance: str
    what: str  # torque, voltage or reading, in words
    unit: str
    rms: float
    floor_rms: float  # of healthy repeats; 0 without them
    sentence: str
    ranking: tuple[RankedEntry, ...]  # best first
    pictures: tuple[UnknownPicture, ...]


@dataclass(frozen=True)
class LearnedEntry:
    """A table effect that stands for an unknown."""

    effect: str  # of the library
    axis: str
    axis_unit: str
    first: float  # end of the axis that was seen, in its unit
    last: float
    nodes: Series  # in the unit of the unknown, evenly from first to last
    explained_percent: float
    sentence: str


@dataclass(frozen=True)
class Unexplained:
    """All that is left, the most telling balance first."""

    sentence: str
    balances: tuple[UnknownEntry, ...]
    learned: LearnedEntry | None  # what could be flown without a name; None where nothing repeats
