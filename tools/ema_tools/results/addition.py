"""What `ema add` writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE
from ema_tools.results.parts import (
    ComparedErrors,
    CurvesEntry,
    ErrorsEntry,
    FittedValue,
    ForwardErrors,
    Provenance,
    StepEntry,
    WeightedErrors,
)
from ema_tools.results.workbench import BenchEntry


@dataclass(frozen=True)
class Correlation:
    """Two fitted values that this record cannot tell apart."""

    values: tuple[str, str]  # by full name
    correlation: float  # -1..1


@dataclass(frozen=True, kw_only=True)
class Addition:
    """One effect put into a model and fitted, or set to values that were given: then nothing was fitted and the errors are None."""

    command: Literal["add"] = "add"
    name: str | None = field(default=None, metadata=SPARE)  # of the record
    actuator: str  # the file that was written
    effect: str
    sentence: str = ""
    error: ErrorsEntry | WeightedErrors  # the latter where it was fitted
    parameters: dict[str, FittedValue]  # by full name
    effects: tuple[str, ...] | None = field(default=None, metadata=SPARE)  # where several were added at once; `effect` is the first
    error_without: dict[str, float] | None = field(default=None, metadata=SPARE)  # weighted error without each of several effects
    replaced: dict[str, float] | None = None  # what the effect was in the actuator as given; None where it was absent
    correlations: tuple[Correlation, ...] | None = field(default=None, metadata=SPARE)
    steps: tuple[StepEntry, ...] | None = field(default=None, metadata=SPARE)
    recommended: bool | None = field(default=None, metadata=SPARE)
    reason: str | None = field(default=None, metadata=SPARE)  # why it is recommended, or not
    method: Literal["balance", "simulation"] = "simulation"
    method_reason: str = ""  # why this method
    # by the balance of forces; None by simulation
    records: tuple[str, ...] | None = field(default=None, metadata=SPARE)  # that were fitted or held out in turn
    holdout: tuple[str, ...] | None = field(default=None, metadata=SPARE)  # to which nothing was fitted
    error_unit: str | None = field(default=None, metadata=SPARE)
    compared: ComparedErrors | None = field(default=None, metadata=SPARE)
    forward: ForwardErrors | None = field(default=None, metadata=SPARE)
    kept: dict[str, str] | None = field(default=None, metadata=SPARE)  # base values that were not fitted, by full name, and why
    drive_lag_s: float | None = field(default=None, metadata=SPARE)  # by which the drive records late; None where no lag shows
    held: tuple[str, ...] | None = field(default=None, metadata=SPARE)  # effects of the model that stayed as they were
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
    curves: CurvesEntry | None = field(default=None, metadata=SPARE)  # None for a very long record
    workbench: BenchEntry | None = field(default=None, metadata=SPARE)  # what the page simulates; None as of curves
