"""Parts that results of several commands share."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from ema_tools.results.codec import SPARE, Series, key

# What made a result: the command line, versions of the tool and of what it uses, and whatever else names the inputs; all as text, by what it is.
Provenance = dict[str, str]


EXPLAINED = 1.1  # times the noise level: a model that leaves no more on a record lacks nothing that this record shows [judgement]
MUCH_LEFT = 2.0  # times the noise level: so much is no other form of what was found [judgement]
_NOISELESS = 0.1  # of a record without noise: a weighted error below a tenth of what its signals are trusted to [precision]


@dataclass(frozen=True)
class Channels:
    """Signals of one record or of one simulation, row by row; None where a signal is not there."""

    position_mm: Series  # rod position
    motor_position_mm: Series | None = field(default=None, metadata=SPARE)  # motor encoder, expressed at the rod
    current_A: Series | None = field(default=None, metadata=SPARE)  # motor current
    voltage_V: Series | None = field(default=None, metadata=SPARE)  # voltage applied to the motor
    speed_mm_s: Series | None = field(default=None, metadata=SPARE)  # rod speed


@dataclass(frozen=True, kw_only=True)
class CurvesEntry:
    """A record beside simulations of it, for the page; a comparison has `model`, the others `before` and, where something was found, `after`."""

    start_s: float = 0.0  # time of the first row
    period_s: float  # from row to row
    measured: Channels
    model: Channels | None = field(default=None, metadata=SPARE)  # the model that was compared
    before: Channels | None = field(default=None, metadata=SPARE)  # the first model
    after: Channels | None = field(default=None, metadata=SPARE)  # the last model


@dataclass(frozen=True)
class ErrorsEntry:
    """The error from the first model to the last, one weighting throughout: weighted rms, 1 is sensor noise; by the balance % of the drive's force."""

    before: float | None  # of the first model; None where nothing was fitted
    after: float | None  # of the last model
    floor: float | None = None  # what a record with nothing new has; None where it is not known
    holdout_before: float | None = None  # of the first model on the record held out; None without one
    holdout_after: float | None = None  # of the last model there

    @property
    def explained(self) -> bool | None:
        """Whether the last model leaves no more than noise; None where the errors are not known."""
        return None if self.after is None or self.floor is None else self.after <= max(EXPLAINED * self.floor, _NOISELESS)

    @property
    def leaves_much(self) -> bool:
        """Whether the last model leaves so much that something else is there beside what was found."""
        return self.after is not None and self.floor is not None and self.after > max(MUCH_LEFT * self.floor, _NOISELESS)


@dataclass(frozen=True)
class ComparedErrors:
    """The mechanical balance of all rows of all records that were given to be fitted, as `ema compare` has it of each, % of the drive's force."""

    before: float | None  # of the actuator as given
    after: float | None  # of the last model


@dataclass(frozen=True)
class ForwardErrors:
    """The forward solution beside the balance: the motion that the model makes under the measured drive, over windows of half a second, in % of the motor's speed; None where it cannot be solved.

    The drive is also foretold from the motion alone, every effect that reads the drive reading the foretold one, in % of the drive.
    """

    before: float | None  # of the actuator as given
    after: float | None  # of the last model
    holdout_before: float | None = None  # the same on the records held out; None without any
    holdout_after: float | None = None
    drive_before: float | None = None  # of the drive foretold, base values refitted
    drive_after: float | None = None  # of the last model
    reads_drive: tuple[str, ...] = ()  # effects of the last model that read the measured drive


@dataclass(frozen=True)
class WeightedErrors(ErrorsEntry):
    """Errors as weighted rms, with the floor of the record held out."""

    holdout_floor: float | None = None  # what the record held out would have with nothing new


@dataclass(frozen=True)
class StepEntry:
    """One model of the way from the first to the last."""

    effects: tuple[str, ...]  # that it holds
    added: str  # what came last, in words where it is no effect
    error_training: float  # on the record that was fitted, as in `Errors`
    error_holdout: float | None  # on the record held out; None without one
    # the same with what scatters no farther than is credible, which is what one reads: wear is no scatter; None in older files, and by the balance
    told_training: float | None = field(default=None, metadata=SPARE)
    told_holdout: float | None = field(default=None, metadata=SPARE)
    # what makes this model of the first, by full name: its effects, and what scatters as far as it moved, by the balance its base values; None in older files, and where they were not kept
    values: dict[str, float] | None = field(default=None, metadata=SPARE)

    @property
    def told(self) -> tuple[float, float | None]:
        """The errors that one reads, on the record that was fitted and on the one held out."""
        return (self.error_training, self.error_holdout) if self.told_training is None else (self.told_training, self.told_holdout)


@dataclass(frozen=True)
class FittedValue:
    """One fitted value of an actuator."""

    value: float  # in its unit
    std: float | None  # standard error, in the same unit; None where the record does not determine it
    unit: str = ""
    at_bound: bool = False  # whether it lies on an end of its range
    interval95: tuple[float | None, float | None] | None = field(
        default=None, metadata=SPARE
    )  # lower and upper end; None where nothing was fitted


@dataclass(frozen=True, kw_only=True)
class EffectEntry:
    """One effect of a ranking, or a changed CSJ or BLK. Values by the last word of their names, in the units of the actuator file."""

    name: str  # as in the library
    # effects that this record cannot tell from it, itself first
    alike: tuple[str, ...] = field(default=(), metadata=key("class"))
    # csj or blk, where this record cannot tell them from it
    looks_like_fault: tuple[str, ...] | None = field(default=None, metadata=SPARE)
    parameters: dict[str, float] = field(default_factory=dict)
    std: dict[str, float | None] = field(default_factory=dict)  # standard errors
    # lower and upper end; None for what was refused
    interval95: dict[str, tuple[float | None, float | None]] | None = field(default=None, metadata=SPARE)
    # values on an end of their range; None where it was not looked at
    at_bound: tuple[str, ...] | None = field(default=None, metadata=SPARE)
    score: float  # what it takes off: units of cost, or squared % of the held-out force
    limit: float  # what it must take off, alike
    accepted: bool
    # that it is there, look-alikes included, 0..1; by simulation
    probability: float | None = field(default=None, metadata=SPARE)
    reason: str | None = field(default=None, metadata=SPARE)  # why it was refused
    # of a changed CSJ or BLK: in % of the healthy machine's, with the ends of its 95 % interval
    shift_percent: float | None = field(default=None, metadata=SPARE)
    shift_interval95: tuple[float | None, float | None] | None = field(default=None, metadata=SPARE)


def together(effects: Sequence[EffectEntry], rivals: Sequence[str]) -> tuple[str, ...]:
    """The first accepted effect that has rivals, followed by them; empty where none has."""
    accepted = [one for one in effects if one.accepted]
    for one in accepted:
        own = tuple(name for name in rivals if name in (*one.alike, *(one.looks_like_fault or ())) and name != one.name)
        if own:
            return (one.name, *own)
    return (accepted[0].name, *rivals) if accepted and rivals else ()


@dataclass(frozen=True)
class Sensor:
    """The sensor that the unknown looks like: it reads factor times the signal plus offset, late."""

    channel: str  # time_s where it is the recorder's clock
    share: float  # of the excess, 0..1
    cost: float  # what stays, units of cost
    factor: float
    offset: float  # in the signal's unit
    late_s: float
    sentence: str
    next: str  # what to do


@dataclass(frozen=True)
class Place:
    """A part of a record, and how much of a residual lies there."""

    name: str  # residual and part, in words
    share_percent: float  # of the squared residual
    time_share: float | None  # of the record's time, 0..1; None for a part that is no part of the time
    source: str = ""  # which residual
    by: str = ""  # by what it was divided; empty for the balances among themselves
    part: str = ""  # which part
    share: float | None = field(default=None, metadata=SPARE)  # the share again, 0..1

    @property
    def time_percent(self) -> float:
        """Of the record's time; 0 for a part that is no part of the time."""
        return 100.0 * (self.time_share or 0.0)

    @property
    def surprise(self) -> float:
        """How much more of the residual than of the time lies here, in %; what a part must have to say something."""
        if not self.share_percent > self.time_percent > 0.0:
            return 0.0
        return self.share_percent * math.log(self.share_percent / self.time_percent)
