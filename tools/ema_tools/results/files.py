"""What the commands write that make files: simulate, export, import, report, demo."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE
from ema_tools.results.parts import Provenance


@dataclass(frozen=True)
class SimulationResult:
    """A recording that was made."""

    command: Literal["simulate"]
    actuator: str  # file
    record: str  # file
    rows: int
    period_s: float  # from row to row
    settings: tuple[str, ...]  # name=value, as they were given
    noise: dict[str, float]  # standard deviation by column, in its unit
    seed: int  # of the noise
    precision: int  # bits of the module's numbers


@dataclass(frozen=True)
class SignatureTable:
    """The table for the onboard diagnosis."""

    bytes: int
    signals: tuple[str, ...]
    rows: int
    bins: int  # of each row
    rate_hz: float  # of the bins
    effects: tuple[str, ...]
    limit: float  # units of cost that an effect must take off
    energy: float  # of the healthy repeats, units of cost
    misfit: dict[str, float]  # of the healthy machine and its model, times the noise of a bin, rms, by signal
    warning: str | None  # what speaks against the table


@dataclass(frozen=True)
class UnitEntry:
    """A unit of an image."""

    name: str
    identity: str  # eight hexadecimal digits: checksum of the configuration, as packed results carry it
    signatures_bytes: int  # of its table; 0 without one


@dataclass(frozen=True)
class ImageEntry:
    """The binary image that firmware reads in flash."""

    file: str
    bytes: int
    schema: str  # eight hexadecimal digits: number of the lists of values that it was made for
    units: tuple[UnitEntry, ...]


@dataclass(frozen=True)
class ExportResult:
    """The configuration that firmware compiles in."""

    command: Literal["export"]
    actuator: str  # file
    header: str | None  # file; None where an image alone was asked for
    flat: str | None  # file; None where it was not asked for
    effects: tuple[str, ...]  # that the actuator has
    signatures: str | None = field(default=None, metadata=SPARE)  # file
    table: SignatureTable | None = field(default=None, metadata=SPARE)
    warnings: tuple[str, ...] | None = field(default=None, metadata=SPARE)  # why the search would not reach its lowest cost
    image: ImageEntry | None = field(default=None, metadata=SPARE)
    source: str | None = field(default=None, metadata=SPARE)  # file with the constant that the header declares


@dataclass(frozen=True)
class ImportResult:
    """A foreign measurement in this project's formats."""

    command: Literal["import emps"]
    actuator: str  # file
    record: str  # file
    rows: int
    period_s: float  # from row to row
    provenance: Provenance


@dataclass(frozen=True)
class ReportResult:
    """A page of results."""

    command: Literal["report"]
    results: tuple[str, ...]  # files
    page: str  # file


@dataclass(frozen=True, kw_only=True)
class LoopResult:
    """What the loop of compare, diagnose, add and identify ended with."""

    command: Literal["loop"] = "loop"
    verdict: Literal["healthy", "fault", "undecided"]
    sentence: str  # of the last result
    reason: str  # why there is no verdict, and what to record; empty with one
    commands: tuple[tuple[str, ...], ...]  # that were run, as argument lists
    machine: str | None  # file of the last model that was written; None where no effect was added
    page: str  # file
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first


@dataclass(frozen=True)
class DemoResult:
    """What the demo left."""

    command: Literal["demo"]
    page: str  # file
    results: tuple[str, ...]  # names of files beside it


@dataclass(frozen=True)
class DraftResult:
    """A map to complete."""

    command: Literal["import draft"]
    source: str  # file that was looked at
    map: str  # file
    guessed: dict[str, str]  # columns of the record and the file's own names of what was taken for them
    open: tuple[str, ...]  # entries that are still to be filled in
    remarks: tuple[str, ...]  # what is to be checked of a guess, by the record's column
    provenance: Provenance


@dataclass(frozen=True)
class ImportedRecord:
    """One record of a constant rate."""

    record: str  # file
    rows: int
    period_s: float  # from row to row
    columns: tuple[str, ...]  # besides time_s


@dataclass(frozen=True)
class ImportedFile:
    """What became of one file."""

    source: str  # file
    records: tuple[ImportedRecord, ...]
    remarks: tuple[str, ...]  # what was done to it, or is odd about it


@dataclass(frozen=True)
class SignalSource:
    """Of what a signal at the motor shaft or at the rod is made."""

    origin: Literal["recorded", "converted", "integrated", "differentiated"]
    column: str


@dataclass(frozen=True)
class TableImportResult:
    """A maker's files as records, and an actuator to start from."""

    command: Literal["import table"]
    map: str  # file
    actuator: str  # file
    values: dict[str, float]  # of the actuator, those that are stated
    estimated: tuple[str, ...]  # of these, those that come from the records and not from the map
    files: tuple[ImportedFile, ...]
    signals: dict[str, SignalSource]  # what the records say of the machine, and how
    remarks: tuple[str, ...]  # about all records together
    provenance: Provenance
