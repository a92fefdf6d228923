"""What `ema calibrate` writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE
from ema_tools.results.parts import ComparedErrors, Provenance


@dataclass(frozen=True)
class Calibrated:
    """One value, in its unit."""

    before: float
    after: float
    std: float | None  # standard error
    change_percent: float | None  # None where it was zero before
    unit: str
    source: Literal["balance", "loop", "search"]  # what gave it; the last is the onboard module's own
    at_bound: bool
    interval95: tuple[float | None, float | None] = (None, None)  # lower and upper end, by the standard error


@dataclass(frozen=True)
class RodModel:
    """The mechanics at the rod: force = mass * acceleration + viscous * speed + coulomb * sign of the speed + offset."""

    mass_kg: float | None
    viscous_N_s_per_m: float | None
    coulomb_N: float | None
    offset_N: float | None


@dataclass(frozen=True)
class ChannelErrors:
    """Rms of measured minus simulated by channel, in the unit of its name."""

    before: dict[str, float]
    after: dict[str, float]
    noise: dict[str, float]  # of the sensor


@dataclass(frozen=True)
class OwnMachineEntry:
    """What two or more runs of one command show beside base values; the verdict counts against it, at the desk and onboard."""

    records: int  # of that command
    standing: dict[str, float]  # effects that the unit always has: how many times as long a model step takes with each
    scatter_percent: dict[str, float]  # by which the onboard search reads one run apart from another, standard deviations, by full name
    least_percent: dict[str, float]  # shifts that are called a fault, by full name
    exceeded: dict[str, float] = field(
        default_factory=dict
    )  # share of the ground tests of a healthy unit that exceed them, 0..1, by full name
    found_percent: dict[str, float] = field(
        default_factory=dict
    )  # shifts from which on the onboard module calls 95 % of the faults one, by full name
    doubt: str = ""  # why two runs may not both be healthy, in words
    # by which a reading of the rod position alone may be off under this command, by full name; empty where it is less than a threshold
    unseen_percent: dict[str, float] = field(default_factory=dict)
    # what a degree more makes of CSJ, and the standard error of that; null where the rod position does not tell the day's temperature
    csj_per_degC_percent: float | None = None
    csj_per_degC_std_percent: float | None = None


@dataclass(frozen=True)
class ForceCalibration:
    """What a calibration by the balance of forces has in place of errors by channel, % of the drive's force."""

    records: tuple[str, ...]
    by: Literal["lap", "block", "record"]  # what is held out in turn
    fitted_percent: float | None  # of what slides, all of it fitted
    each_held_out_percent: tuple[float | None, ...]  # of each part when it is held out
    floor_percent: float | None  # how far one lap is from the others; None where it is not known
    compared: ComparedErrors
    held: tuple[str, ...]  # effects of the model that stayed as they were


@dataclass(frozen=True)
class CalibrationResult:
    """Base parameters fitted to healthy records."""

    command: Literal["calibrate"]
    actuator: str  # the file that was written
    parameters: dict[str, Calibrated]  # by full name
    at_rod: dict[str, RodModel]  # before, after, std; empty where the mechanics were not calibrated
    error: ChannelErrors
    left_out: dict[str, str]  # names to why they were not calibrated by their balance
    method: Literal["balance", "simulation"] = "simulation"
    method_reason: str = ""  # why this method
    forces: ForceCalibration | None = field(default=None, metadata=SPARE)  # None by simulation
    far: dict[str, float] = field(
        default_factory=dict
    )  # constants of the machine that came out this many times what the file said, by full name
    own_machine: OwnMachineEntry | None = None  # None where no two records run the same command, or it was not wanted
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
