"""What `ema diagnose` writes: by simulation of all signals, or by the balance of forces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE, Series, key
from ema_tools.results.localisation import Localisation
from ema_tools.results.parts import (
    ComparedErrors,
    CurvesEntry,
    EffectEntry,
    ErrorsEntry,
    ForwardErrors,
    Provenance,
    Sensor,
    StepEntry,
    WeightedErrors,
)
from ema_tools.results.unexplained import Unexplained
from ema_tools.results.validity import Validity
from ema_tools.results.workbench import BenchEntry

Verdict = Literal["adequate", "missing", "unknown"]
Method = Literal["balance", "simulation"]
# Of the balance's floor: how far laps are from each other, what is left of healthy records, how far records are from each other in the same motion, noise alone.
FloorFrom = Literal["laps", "healthy records", "estimate", "noise"]


@dataclass(frozen=True, kw_only=True)
class DiagnosisResult:
    """Which effect is missing, by simulation."""

    command: Literal["diagnose"] = "diagnose"
    name: str | None = None  # of the record
    verdict: Verdict
    sentence: str = ""
    method: Method = "simulation"
    method_reason: str = ""  # why this method
    mode: Literal["against healthy repeats", "without healthy repeats"] = "against healthy repeats"
    cannot_see: str | None = None  # what this kind of evidence hides
    effects: tuple[EffectEntry, ...] = ()  # best first
    rivals: tuple[str, ...] = ()  # effects or faults that explain the record as well as an accepted effect
    faults: dict[str, EffectEntry] = field(default_factory=dict)  # changes of csj and blk, by name
    standing: dict[str, dict[str, float]] = field(default_factory=dict)  # effects that the healthy machine has, with their values
    # without healthy records: CSJ and BLK where they lie farther from the data sheet than units do
    unit_shift_percent: dict[str, float] = field(default_factory=dict)
    error: WeightedErrors
    next_experiment: str = ""  # what to do next
    unexplained: float | None = None  # share of the excess that stays, 0..1
    # probability of a cause that the library does not hold, 0..1; by simulation
    unnamed: float | None = field(default=None, metadata=SPARE)
    steps: tuple[StepEntry, ...] = ()
    gate: Validity = field(default_factory=Validity)
    where: Localisation = field(default_factory=Localisation)
    unknown: Unexplained | None = None
    sensor: Sensor | None = None
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
    curves: CurvesEntry | None = field(default=None, metadata=SPARE)  # None for a very long record
    workbench: BenchEntry | None = field(default=None, metadata=SPARE)  # what the page simulates; None as of curves


@dataclass(frozen=True)
class ForceErrors:
    """Relative errors of the mechanical balance, % of the drive's force."""

    training_percent: float | None  # of the parts fitted
    holdout_percent: float | None  # of the part held out
    each_held_out_percent: tuple[float | None, ...]  # of each part when it is held out


@dataclass(frozen=True)
class ForceValue:
    """One value that the balance was fitted with."""

    value: float  # in its unit
    std: float | None
    unit: str


@dataclass(frozen=True)
class Elsewhere:
    """Error at places or speeds to which nothing was fitted, before and after an effect."""

    before_percent: float | None
    after_percent: float | None


@dataclass(frozen=True)
class ForceStepEntry(ForceErrors):
    """One effect that was added, with the errors after it."""

    effects: tuple[str, ...]
    added: str
    alike: tuple[str, ...] = field(metadata=key("class"))
    parameters: dict[str, ForceValue]  # by full name
    elsewhere: dict[str, Elsewhere]  # by what was left out
    recommended: bool
    reason: str
    kept: bool  # whether the last model holds it


@dataclass(frozen=True, kw_only=True)
class ForceRefusal:
    """One effect that was not added, and why; errors where it could be fitted."""

    effect: str
    reason: str
    parameters: dict[str, ForceValue]
    training_percent: float | None = field(default=None, metadata=SPARE)
    holdout_percent: float | None = field(default=None, metadata=SPARE)
    each_held_out_percent: tuple[float | None, ...] | None = field(default=None, metadata=SPARE)
    recommended: bool


@dataclass(frozen=True)
class ForceSummary:
    """The errors before any effect."""

    given: ForceErrors  # of the model as it was given
    refitted: ForceErrors  # of its base values refitted
    floor_percent: float | None  # how far one lap is from the others; None where it is not known
    compared: ComparedErrors | None = field(default=None, metadata=SPARE)


@dataclass(frozen=True)
class LapsEntry:
    """How the records were divided."""

    count: int  # laps, stretches of time or records
    period_s: float | None  # of the laps
    parts: int
    held_out_part: int
    by: Literal["lap", "block", "record"] = "lap"


@dataclass(frozen=True)
class Forces:
    """The mechanical balance, effect by effect."""

    error: ForceSummary
    steps: tuple[ForceStepEntry, ...]
    refused: tuple[ForceRefusal, ...]
    values: dict[str, float]  # of the last model, by full name
    laps: LapsEntry
    curves: dict[str, Series]  # torque and residuals before and after, Nm, for a picture


@dataclass(frozen=True)
class MeasuredFriction:
    """The same of runs at constant speed, without any model: the slowest that was run both ways, and where friction is least."""

    slowest_rad_s: float
    above_least_percent: float
    least_at_rad_s: float


@dataclass(frozen=True)
class FrictionShape:
    """Steady friction forward, dry and viscous, that falls from standstill to a minimum."""

    standstill_Nm: float
    minimum_Nm: float
    minimum_at_rad_s: float  # speed of the motor
    above_minimum_percent: float  # at standstill
    measured: MeasuredFriction | None = None  # None where too few speeds were kept both ways, or friction is least at the slowest


@dataclass(frozen=True)
class BaseEntry:
    """One base value as the balance fitted it, beside what was stated of it, in its unit."""

    value: float
    std: float | None  # None where it was not fitted
    interval95: tuple[float | None, float | None]
    unit: str
    stated: float
    stated_from: Literal["file", "import"]  # import: a start that an import put there, nobody stated it
    times: float | None  # fitted over stated; None where nothing was stated, or nothing fitted
    contradicts: bool  # whether what is stated is farther off than the doubt of both
    kept: str | None = None  # why it was not fitted
    at_bound: bool = False  # on an end of where it may be
    hardly_seen: bool = False  # far from what is stated, and the error would hardly be larger with that
    error_as_stated_percent: float | None = None  # force error of the parts fitted with the value as stated, all else fitted anew


@dataclass(frozen=True)
class HealthyValue:
    """One value of the healthy machine, in its unit."""

    value: float
    std: float | None  # standard error over all healthy records
    scatter: float | None  # from record to record, standard deviation
    unit: str


@dataclass(frozen=True)
class HealthyEntry:
    """What the healthy records show."""

    records: tuple[str, ...]
    values: dict[str, HealthyValue]  # by full name
    over: Literal["records", "parts of records"]  # what the scatter was taken over: parts where there are too few records
    uncertain: bool  # whether the scatter is hardly known
    error_percent: float | None  # what is left of them, in % of today's drive
    times: float  # so many standard deviations a value must differ to be a change


@dataclass(frozen=True)
class ChangeEntry:
    """One value of the healthy machine as today's records have it, in its unit."""

    healthy: float
    today: float
    change_percent: float | None  # None where it was zero
    interval95: tuple[float | None, float | None]  # of the change
    limit: float  # a change must be larger
    counts: bool  # whether it is, and every part held out says so
    unit: str
    called: str | None = field(default=None, metadata=SPARE)  # what it is on this machine, where its name does not say so


@dataclass(frozen=True, kw_only=True)
class DiagnosisByBalanceResult:
    """Which effects are missing, by the mechanical balance of one record or of several."""

    command: Literal["diagnose"] = "diagnose"
    name: str | None = None  # of the first record
    records: tuple[str, ...] = ()  # that were fitted or held out in turn
    holdout: tuple[str, ...] = ()  # to which nothing was fitted
    verdict: Verdict
    sentence: str = ""
    method: Method = "balance"
    method_reason: str = ""  # why this method
    mode: Literal["laps of one record", "stretches of one record", "several records", "against healthy records"]
    effects: tuple[EffectEntry, ...] = ()  # accepted ones in the order of addition, then those that were refused
    rivals: tuple[str, ...] = ()  # effects that explain the records as well as an accepted effect
    # with healthy records a changed csj, and a blk where both positions are recorded
    faults: dict[str, EffectEntry] = field(default_factory=dict)
    standing: dict[str, dict[str, float]] = field(default_factory=dict)  # effects that the healthy machine has, with their values
    healthy: HealthyEntry | None = field(default=None, metadata=SPARE)  # None without healthy records
    # with healthy records effects that explain these about as well, beside values that have not changed; None where there are none
    as_well: tuple[str, ...] | None = field(default=None, metadata=SPARE)
    changes: dict[str, ChangeEntry] = field(default_factory=dict)  # of the healthy machine's values, by full name
    error: ErrorsEntry
    error_unit: str
    floor_from: FloorFrom | None = None  # what error.floor is taken from
    forward: ForwardErrors | None = field(default=None, metadata=SPARE)
    next_experiment: str = ""  # what to do next
    unexplained: float | None = None  # share of the excess that stays, 0..1; None where no floor is known
    # unknown for the reason alone that these records do not tell whether what is left, which is much, is chance
    untellable: bool | None = field(default=None, metadata=SPARE)
    steps: tuple[StepEntry, ...] = ()
    forces: Forces
    # base values of the last model, with healthy records those of the healthy machine, by full name; None in files of before
    base: dict[str, BaseEntry] | None = field(default=None, metadata=SPARE)
    # rod travel per motor angle of a machine of which everything was recorded along its line, and which is told in N, kg and mm; None of any other
    rod_m_per_rad: float | None = field(default=None, metadata=SPARE)
    friction: FrictionShape | None = None  # None where friction is least at standstill
    drive_lag_s: float | None = field(default=None, metadata=SPARE)  # by which the drive records late; None where no lag shows
    gate: Validity = field(default_factory=Validity)
    where: Localisation = field(default_factory=Localisation)
    unknown: Unexplained | None = None  # none: nothing is drawn of it
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
    curves: CurvesEntry | None = field(default=None, metadata=SPARE)  # None for a very long record
    workbench: BenchEntry | None = field(default=None, metadata=SPARE)  # what the page simulates; None as of curves
