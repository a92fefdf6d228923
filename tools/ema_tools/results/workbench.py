"""What the page's workbench needs of a result: the actuator and the record themselves, so that the page can simulate and fit."""

from __future__ import annotations

from dataclasses import dataclass, field

from ema_tools.results.codec import SPARE


@dataclass(frozen=True, kw_only=True)
class SpreadEntry:
    """Values that move together, by their full names: one standard deviation, as a share of each where `relative`, else in their unit."""

    names: tuple[str, ...]
    std: float
    relative: bool


@dataclass(frozen=True, kw_only=True)
class WeighedEntry:
    """How a diagnosis weighs a record: its errors are the rms of what is left of `target`, each line of the spectrum times its weight. By channel, packed as columns are."""

    rows: int  # that are turned into lines
    target: dict[str, str]  # what the model should show, all rows of the record
    weights: dict[str, str]  # of the lines
    spread: tuple[SpreadEntry, ...] = ()  # values that may move within a prior
    zeros: dict[str, float] = field(default_factory=dict)  # standard deviation of each sensor's zero, in its unit
    gains: dict[str, float] = field(default_factory=dict)  # standard deviation of each sensor's gain, relative
    unit: dict[str, float] = field(default_factory=dict)  # values of the model that `gains` and `slight` change
    slight: tuple[dict[str, float], ...] = ()  # what varies, and effects that every machine has a little of ...
    sizes: tuple[float, ...] = ()  # ... each by so many standard deviations


@dataclass(frozen=True, kw_only=True)
class BenchEntry:
    """One actuator and one record. `columns` by name, those that are recorded: little-endian float32 in base64, the very numbers that the module takes."""

    actuator: str  # the text of its file
    actuator_file: str
    header: str  # what `ema export` writes of it
    record_file: str
    start_s: float  # time of the first row
    period_s: float  # from row to row
    columns: dict[str, str]
    usual: dict[str, float] = field(
        default_factory=dict
    )  # values of each effect at the lower end of its usual size on this machine, by full name
    weighed: WeighedEntry | None = field(
        default=None, metadata=SPARE
    )  # of a diagnosis or an addition; without, signals are weighed by their white noise
