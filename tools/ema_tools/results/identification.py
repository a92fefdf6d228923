"""What `ema identify` writes, and `ema demo` for the paper's cases."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE, Series, key
from ema_tools.results.parts import CurvesEntry, ErrorsEntry, Provenance, Sensor
from ema_tools.results.workbench import BenchEntry

# Values that can be identified.
KEYS = ("csj_Nm", "blk_mm")

Verdict = Literal["healthy", "fault", "undecided"]
GuardVerdict = Literal["adequate", "missing", "unknown", "rival"]
Determined = Literal["yes", "together", "no"]
Objection = Literal["missing", "unknown", "rival", "signals", "open", "healthy"]


@dataclass(frozen=True)
class EstimateEntry:
    """One identified value, in the unit of its name."""

    estimate: float
    std: float | None  # standard error; None where the record does not determine the value
    shift_percent: float  # of the healthy value
    # lower and upper end: counted is all that moves the estimate, not sensor noise alone; None where the record does not determine the value
    interval95: tuple[float | None, float | None] = (None, None)
    healthy: float | None = field(default=None, metadata=SPARE)
    at_bound: bool = False  # of the search
    bias: float | None = field(
        default=None, metadata=SPARE
    )  # how far it may be off besides, for what lasts in the residual; None as the standard error
    threshold_percent: float | None = field(default=None, metadata=SPARE)  # smallest shift that is called a fault; None in older files


@dataclass(frozen=True)
class NotIdentified:
    """A value that was not searched, and why."""

    estimate: None
    std: None
    shift_percent: None
    healthy: float
    reason: str
    interval95: None = None


@dataclass(frozen=True)
class MissingEffect:
    """The effect behind an estimate that is no fault, or that would explain the record as well as one; values by the last word of their names."""

    name: str | None  # None where no effect of the library explains the record
    alike: tuple[str, ...] = field(metadata=key("class"))  # effects that this record cannot tell from it, itself first
    parameters: dict[str, float]
    std: dict[str, float | None]
    beside_it: dict[str, float]  # CSJ and BLK beside it, by full name
    against_healthy_records: int  # that it was compared with
    interval95: dict[str, tuple[float | None, float | None]] = field(default_factory=dict)  # lower and upper end of each of the parameters


@dataclass(frozen=True)
class Guard:
    """What all signals of the record say of the answer."""

    verdict: GuardVerdict  # rival: an effect explains the record as well as a fault does
    objection: Objection | None = None  # why the module's answer does not stand; None where it does
    signals: tuple[str, ...] = ()  # that were compared
    shift_percent: dict[str, float] = field(
        default_factory=dict
    )  # CSJ and BLK by all signals, beside the missing effect where there is one
    open_std_percent: dict[str, float] = field(default_factory=dict)  # how far they may be off for what machines differ from day to day
    _: KW_ONLY
    skipped: str | None  # why nothing was sought
    wall_s: float


@dataclass(frozen=True)
class BaselineEntry:
    """Healthy values found on healthy records."""

    values: dict[str, float]  # by full name
    std: dict[str, float | None]  # standard errors
    records: int
    interval95: dict[str, tuple[float | None, float | None]] = field(default_factory=dict)  # lower and upper end, by full name
    without: tuple[str, ...] = ()  # effects of the model that the healthy records do not have: counted for today's record alone


@dataclass(frozen=True)
class SearchEntry:
    """The search, run by run."""

    cost_mm2s: Series  # of every model run; of one given up early what had come together; with weights no longer mm2 s


@dataclass(frozen=True)
class ProfileEntry:
    """The objective along one value, the others at their best as far as a straight valley goes."""

    value: Series  # in the unit of the name
    objective_mm2s: Series
    limit_mm2s: float  # values with less lie inside the 95 % region by what the residual is


@dataclass(frozen=True)
class MapEntry:
    """The objective over both values."""

    csj_Nm: Series
    blk_mm: Series
    objective_mm2s: tuple[Series, ...]  # a row for each BLK, in it a number for each CSJ


@dataclass(frozen=True)
class ShapeEntry:
    """The objective round the estimates, and the way of the search over it."""

    csj_Nm: ProfileEntry | None = field(default=None, metadata=SPARE)
    blk_mm: ProfileEntry | None = field(default=None, metadata=SPARE)
    map: MapEntry | None = None  # None where one value was searched alone, or nobody asked
    path: dict[str, Series] = field(
        default_factory=dict
    )  # values of the model runs by key, in their order; a run whose values are not known is left out
    path_cost_mm2s: Series = ()


@dataclass(frozen=True)
class Seed:
    """The answer of one further seed."""

    objective_after_mm2s: float | None
    evaluations: int
    csj_Nm: float | None = field(default=None, metadata=SPARE)
    blk_mm: float | None = field(default=None, metadata=SPARE)


@dataclass(frozen=True)
class TableFinding:
    """What a flight's table of signatures says of the record at the best point; scores in variances of the noise."""

    kind: Literal["adequate", "missing", "unknown", "none"]  # none: the record runs another command
    effect: str | None
    runner_up: str | None
    alike: tuple[str, ...]  # that cannot be told from the effect, itself among them
    score: float
    runner_up_score: float
    limit: float
    size: float  # of the effect, in its own unit
    energy: float
    moved: tuple[float, float]  # changes of the table's CSJ and BLK that the residual still asks for, Nm and mm


@dataclass(frozen=True)
class ValueEntry:
    """One of several values that were searched at once, in the unit of its name."""

    estimate: float
    interval95: tuple[float | None, float | None] | None  # None where the record does not determine the value
    determined: Determined  # yes; together: only with another value, which does the same to the signals; no: it does too little to them
    alike: str | None  # the other value that is most like it to the signals, by full name
    before: float  # what the actuator has
    std: float | None = None  # standard error by the residual's own size; None where the value is not told from the others
    noise_std: float | None = None  # by the sensors' noise alone
    at_bound: bool = False  # of the search
    companion: str | None = None  # the value that moved in the same proportion, by full name


@dataclass(frozen=True)
class ValuesSearchEntry:
    """The search for several values at once."""

    noise: dict[str, float]  # rms of the signals that were compared, by their names
    misfit_before: float  # rms of the residual over the noise
    misfit_after: float
    adequate: bool  # whether the values explain the record
    runs: int  # model runs
    starts: int  # descents that were begun
    outcome: str  # what ended the search


@dataclass(frozen=True, kw_only=True)
class IdentificationResult:
    """CSJ and BLK of one record."""

    command: Literal["identify", "demo"] = "identify"
    name: str | None = None  # of the record
    case: str | None = field(default=None, metadata=SPARE)  # letter of the paper's case whose truth is known
    noise: str | None = field(default=None, metadata=SPARE)  # the sensor noise in a record of a case, in words
    csj_Nm: EstimateEntry | NotIdentified | None = field(default=None, metadata=SPARE)  # static dry friction
    blk_mm: EstimateEntry | NotIdentified | None = field(default=None, metadata=SPARE)  # backlash at the rod
    objective_before_mm2s: float  # with healthy values; with weights no longer mm2 s
    objective_after_mm2s: float
    evaluations: int  # model runs
    verdict: Verdict = "undecided"
    adequate: bool = False  # whether the model explains the record
    reasons: tuple[str, ...] = ()  # why it is undecided
    missing_effect: MissingEffect | None = None  # None where nothing stands behind the estimates
    sensor: Sensor | None = field(default=None, metadata=SPARE)  # whose own error what is unknown looks like; None where none is suspected
    guard: Guard | None = None  # None where nobody looked
    table: TableFinding | None = None  # None where no table was given
    sentence: str = ""
    # the weighted error of the model, as in a comparison; None where nobody looked at all signals
    error: ErrorsEntry | None = field(default=None, metadata=SPARE)
    residual_rms_mm: float | None = None
    residual_correlation: float | None = None  # of neighbouring rows, -1..1
    outcome: str | None = None  # what ended the search
    accepted: int | None = None  # candidates that the search took
    accepted_uphill: int | None = None  # of them those that were worse
    model_steps: int | None = None
    wall_s: float | None = None  # time of the search
    seed: int | None = None
    precision: int | None = None  # bits of the module's numbers
    baseline: BaselineEntry | None = None  # None where the actuator's healthy values were taken
    search: SearchEntry | None = None
    shape: ShapeEntry | None = field(default=None, metadata=SPARE)  # None where nobody asked
    undetermined: dict[str, str] = field(default_factory=dict)  # values that the record does not determine, by key, a sentence each
    seeds: tuple[Seed, ...] = ()  # further seeds that were asked for
    values: dict[str, ValueEntry] | None = field(default=None, metadata=SPARE)  # by full name; None where none were asked for
    values_search: ValuesSearchEntry | None = field(default=None, metadata=SPARE)
    warnings: tuple[str, ...] | None = field(
        default=None, metadata=SPARE
    )  # why the search would not reach its lowest cost with its settings
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
    curves: CurvesEntry | None = field(default=None, metadata=SPARE)  # None for a very long record
    workbench: BenchEntry | None = field(default=None, metadata=SPARE)  # what the page simulates; None as of curves

    @property
    def estimates(self) -> dict[str, EstimateEntry]:
        """What was identified, by key."""
        return {name: one for name in KEYS if isinstance(one := getattr(self, name), EstimateEntry)}

    @property
    def left_out(self) -> dict[str, NotIdentified]:
        """What was not identified, by key."""
        return {name: one for name in KEYS if isinstance(one := getattr(self, name), NotIdentified)}
