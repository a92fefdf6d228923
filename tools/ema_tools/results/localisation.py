"""Where a model fails: balances, signals, parts of the record, and the data of the pictures."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE, Series
from ema_tools.results.parts import Place


@dataclass(frozen=True)
class TermEntry:
    """A simple description of a residual."""

    words: str  # what it is like: proportional to ..., with the sign of ...
    explained_percent: float  # of the excess, on passes to which it was not fitted
    coefficient: float  # of its first column, in the balance's unit


@dataclass(frozen=True)
class BlockEntry:
    """One balance: measured signals and one group of blocks. Numbers are None where it cannot be drawn."""

    name: str
    unit: str  # of the residual
    rms: float | None  # of what exceeds healthy repeats, or of what the model leaves
    floor_rms: float | None  # of repeats, or of noise and method
    relative_percent: float | None  # of the measured side
    share_percent: float  # of the excess of all balances
    telling: bool  # whether it exceeds the floor
    terms: tuple[TermEntry, ...]  # best first
    reason: str | None = None  # why it cannot be drawn


@dataclass(frozen=True)
class SignalErrorEntry:
    """One signal of the closed loop."""

    name: str
    unit: str
    rms: float | None  # of record minus repeats, or minus model
    floor_rms: float | None  # of repeats among each other; None without them
    share_percent: float  # of the weighted square of all signals


@dataclass(frozen=True)
class BinsEntry:
    """A quantity over an axis in equal bins, empty ones left out."""

    center: Series  # in the unit of the axis
    mean: Series  # in the unit of the quantity, as are low and high
    low: Series  # mean minus one standard deviation
    high: Series  # mean plus one standard deviation
    share_percent: Series  # of the square
    time_percent: Series  # of the samples


@dataclass(frozen=True)
class BinsOf:
    """Which residual stands over which axis."""

    source: str  # the balance
    unit: str
    by: str  # the axis
    axis_unit: str
    friction: bool  # whether it is counted against the motion


@dataclass(frozen=True)
class BinPicture(BinsEntry, BinsOf):
    """The residual of a balance over an axis; the file states first what it is."""


@dataclass(frozen=True)
class Points:
    """Points of a picture."""

    x: Series
    y: Series


@dataclass(frozen=True)
class TorqueSpeed:
    """Torque without inertia over the speed of the motor."""

    unit: str
    axis_unit: str
    other: Literal["healthy", "model"]  # what is expected: the healthy repeats, or the model
    points: Points  # of the record
    measured: BinsEntry | None  # of the record; None where the speed does not change, as is the next
    expected: BinsEntry | None


@dataclass(frozen=True)
class TurnTorque:
    """Torque over one turn of the motor, less what the base values need; of the record, and of what the model's effects make."""

    unit: str
    axis_unit: str
    measured: BinsEntry
    model: BinsEntry


@dataclass(frozen=True)
class LinesEntry:
    """Amplitudes over orders, which are periods per turn."""

    order: Series
    amplitude: Series  # in the balance's unit
    chance: Series  # what noise of the residual's size makes of it


@dataclass(frozen=True)
class Orders:
    """The spectrum of a balance over the angle."""

    unit: str
    turns: LinesEntry  # per turn of the motor
    leads: LinesEntry  # per lead of the screw
    stroke_turns: float  # of the motor
    stroke_leads: float


@dataclass(frozen=True)
class Loop:
    """A quantity over the position, to and fro; of the record, and of what it is held against."""

    unit: str
    axis_unit: str
    measured: Points
    model: Points | None = field(default=None, metadata=SPARE)
    healthy: Points | None = field(default=None, metadata=SPARE)


@dataclass(frozen=True)
class Hysteresis:
    """Loops at reversals; None where a signal is missing."""

    play: Loop | None = field(default=None, metadata=SPARE)  # rod minus motor position
    torque: Loop | None = field(default=None, metadata=SPARE)  # torque without inertia


@dataclass(frozen=True)
class Pictures:
    """Data that the page draws."""

    bins: tuple[BinPicture, ...] = ()
    orders: dict[str, Orders] = field(default_factory=dict)  # by balance
    torque_speed: TorqueSpeed | None = field(default=None, metadata=SPARE)  # None where the mechanical balance cannot be drawn
    hysteresis: Hysteresis = field(default_factory=Hysteresis)
    turn: TurnTorque | None = field(default=None, metadata=SPARE)  # None where less than a turn was recorded


@dataclass(frozen=True)
class ReadingEntry:
    """The error of one sensor's reading that explains what the balances leave."""

    channel: str
    kind: Literal["zero", "scale", "delay", "wave"]
    size: float  # of a zero, and the amplitude of a wave, in the signal's unit; of a scale relative; of a delay in s
    periods: int  # of a wave per motor turn; 0 of the others
    share_percent: float  # of the excess of the mechanical, electrical and kinematic balances
    balances: tuple[str, ...]  # in which it shows
    outside_mechanics: bool  # whether it shows in several balances, as a change of the machine does not
    words: str  # what the signal does
    sentence: str


@dataclass(frozen=True)
class Localisation:
    """Where the model fails on a record."""

    relative_to_healthy: bool = False  # whether the record is held against healthy repeats, not against the model
    sentence: str = ""
    blocks: tuple[BlockEntry, ...] = ()
    channels: tuple[SignalErrorEntry, ...] = ()  # largest share first
    places: tuple[Place, ...] = ()  # most telling first
    pictures: Pictures = field(default_factory=Pictures)
    reading: ReadingEntry | None = field(default=None, metadata=SPARE)  # None where no reading's error explains it
