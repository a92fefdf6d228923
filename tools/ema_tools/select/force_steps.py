"""What a search by the balance of forces came to: effect by effect, accepted or refused."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator
from ema_tools.fit.division import Division
from ema_tools.select.balance_bench import Fitted, FoldErrors
from ema_tools.select.base_values import BaseValue
from ema_tools.select.force_floor import EstimatedFloor


@dataclass(frozen=True)
class ForceStep:
    """One step: the effect added, with its values and those of the base refitted beside it, their standard errors, what looks alike, and the errors after it."""

    effect: str
    values: Mapping[str, float]
    std: Mapping[str, float]
    alike: tuple[str, ...]
    errors: FoldErrors
    elsewhere: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Refusal:
    """An effect that was not added, why, and its values and errors beside the accepted ones where it could be fitted."""

    effect: str
    reason: str
    values: Mapping[str, float] = field(default_factory=dict)
    std: Mapping[str, float] = field(default_factory=dict)
    errors: FoldErrors | None = None


@dataclass(frozen=True)
class ForceSteps:
    """The whole answer: the actuator with everything that was accepted, the errors of the given model and of its refitted base values, the steps, what was refused, the floor in %,
    NaN where no lap is repeated, and how the records were divided. `curves` are the torque and the residuals before and after, the records one after another, [samples], for a picture;
    `estimated`: the floor where no lap is repeated; `foretold`: error in % of the drive that the refitted base values, and the last model, foretell from the motion alone;
    `base`: the base values of the last model; `motor_turns`: over which the motor moved in all records;
    `refitted_values`: the base values refitted before any effect, by name; `drive_Nm`: rms of the drive in the parts fitted, of which their errors are."""

    actuator: Actuator
    given: FoldErrors
    refitted: FoldErrors
    steps: tuple[ForceStep, ...]
    refused: tuple[Refusal, ...]
    floor_percent: float
    division: Division
    period_s: float | None
    curves: Mapping[str, Reals]
    estimated: EstimatedFloor
    foretold: tuple[float, float]
    base: tuple[BaseValue, ...] = ()
    motor_turns: float = math.inf
    refitted_values: Mapping[str, float] = field(default_factory=dict)
    drive_Nm: float = math.nan

    @property
    def errors(self) -> FoldErrors:
        """Of the last model."""
        return self.steps[-1].errors if self.steps else self.refitted


@dataclass(frozen=True)
class Tried:
    """The best shape of an effect beside what was accepted: its fit, by how much it lowers the squared error of the training laps, and what it explains of them, [training samples]."""

    effect: str
    fit: Fitted
    gain: float
    part: Reals
