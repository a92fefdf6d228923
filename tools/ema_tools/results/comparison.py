"""What `ema compare` writes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from ema_tools.results.codec import SPARE
from ema_tools.results.parts import CurvesEntry, ErrorsEntry, Place, Provenance
from ema_tools.results.workbench import BenchEntry


@dataclass(frozen=True)
class ChannelErrorEntry:
    """Measured minus simulated of one channel."""

    rmse: float  # in the unit
    relative_percent: float | None  # 100 * norm over norm of the measured; None where that is zero
    unit: str = ""


@dataclass(frozen=True)
class BalanceErrorEntry:
    """The residual of one balance; numbers are None where it cannot be drawn."""

    rms: float | None  # in the unit
    relative_percent: float | None  # of the measured side; of the drive torque for the mechanical balance
    unit: str = ""
    noise_rms: float | None = None  # what the record's white sensor noise makes of it
    method_rms: float | None = None  # what the method leaves on a record of the model
    resting_percent: float | None = None  # of the time at rest, where friction answers whatever there is
    excess_percent: float | None = None  # what of relative_percent neither noise nor method explains; 0 within their margin
    reason: str | None = None  # why it cannot be drawn


@dataclass(frozen=True, kw_only=True)
class ComparisonResult:
    """A model against a record."""

    command: Literal["compare"] = "compare"
    name: str | None = None  # of the record
    channels: dict[str, ChannelErrorEntry]  # by column
    balances: dict[str, BalanceErrorEntry]  # mechanical, electrical, kinematic, controller
    # the weighted error: of the model as given, with today's CSJ, BLK and nuisance parameters, and of a record with nothing new; None where nothing can be simulated
    error: ErrorsEntry | None = field(default=None, metadata=SPARE)
    today: dict[str, float] | None = field(default=None, metadata=SPARE)  # CSJ and BLK with which `error.after` is reached, by full name
    where: tuple[Place, ...] = ()  # largest share first
    sentence: str = ""
    unlocated_event_steps: int = 0  # of the simulation: steps in which more happened than the module resolves
    provenance: Provenance = field(default_factory=dict)
    next: tuple[tuple[str, ...], ...] = ()  # advised commands as argument lists; empty where a new record must be made first
    curves: CurvesEntry | None = field(default=None, metadata=SPARE)  # None for a very long record
    workbench: BenchEntry | None = field(default=None, metadata=SPARE)  # what the page simulates; None as of curves

    @property
    def explained(self) -> bool | None:
        """Whether the model explains the record: by the weighted error, else by every balance; None where nothing says so."""
        if self.error is not None and self.error.explained is not None:
            return self.error.explained
        known = [one.excess_percent for one in self.balances.values() if one.excess_percent is not None]
        return all(excess == 0.0 for excess in known) if known else None
