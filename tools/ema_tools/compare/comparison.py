"""Measured against simulated: error per channel, the four balances, and where the model fails. What `ema compare` does."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.all import BALANCES, all_balances
from ema_tools.balances.balance import Balance
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import filter_of
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.noise import white_noise
from ema_tools.base.progress import Report
from ema_tools.compare.readings import ReadingError, reading_against_model
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, simulated
from ema_tools.plant.native import OUTPUTS, Simulation

UNITS = {"position_mm": "mm", "motor_position_mm": "mm", "current_A": "A", "voltage_V": "V", "speed_mm_s": "mm/s"}
TITLES = {
    "position_mm": "rod position",
    "motor_position_mm": "motor position",
    "current_A": "current",
    "voltage_V": "voltage",
    "speed_mm_s": "rod speed",
}
_BINS = 5  # equal parts of each axis of the machine's state: as many as a reader of a table takes in [layout]
# Ends of the times since the last reversal: play and stretch of the contacts are over after the first, friction's bump after the second [judgement]
_SINCE_REVERSAL_S = (0.0, 0.02, 0.1, 0.5, math.inf)
_LOWEST_BAND_HZ = 0.5  # octaves begin here: slower is the command's own sweep [layout]
FLOOR_MARGIN = 1.5  # a balance within this many times what noise and method make of it says nothing against the model [judgement]


@dataclass(frozen=True)
class ChannelError:
    """Measured minus simulated of one channel: rms in its unit and 100 * norm over the norm of the measured; NaN when that is zero."""

    rmse: float
    relative_percent: float


@dataclass(frozen=True)
class BalanceError:
    """A balance's residual: rms and share of its measured side in %; then the rms that the record's white sensor noise makes of it, and the rms that
    the method itself leaves on a record of the model, where nothing is wrong. `reason` says why there is none; the numbers are then NaN.
    """

    unit: str
    rms: float
    relative_percent: float
    noise_rms: float
    method_rms: float
    resting_percent: float
    reason: str = ""

    @property
    def excess_percent(self) -> float:
        """Share of the measured side that neither noise nor method explains, %; 0 within the margin."""
        floor = math.hypot(self.noise_rms, self.method_rms)
        if self.reason or not self.rms > FLOOR_MARGIN * floor:
            return 0.0
        return self.relative_percent * math.sqrt(1.0 - (floor / self.rms) ** 2)


@dataclass(frozen=True)
class ErrorPart:
    """A part of a residual: which residual, by what it was divided, which part, its share of the squared residual and of the time."""

    source: str
    by: str
    part: str
    share: float
    time_share: float | None

    @property
    def surprise(self) -> float:
        """How much more of the residual than of the time lies here; what a part must have to say something."""
        if self.time_share is None or not self.share > self.time_share > 0.0:
            return 0.0
        return self.share * math.log(self.share / self.time_share)


@dataclass(frozen=True)
class Comparison:
    """The whole answer on the record called `record`; `simulation` [rows] is what was compared with the record, None where nothing can be simulated; `unlike`: signals that are not this
    machine's in sign or size, and what to do, in words; `reading`: the error of one sensor's reading that explains what the balances leave."""

    record: str
    channels: dict[str, ChannelError]
    balances: dict[str, BalanceError]
    where: tuple[ErrorPart, ...]
    simulation: Simulation | None
    unlike: tuple[str, ...] = ()
    reading: ReadingError | None = None


def compare(actuator: Actuator, record: Record, bits: int = 64, report: Report | None = None) -> Comparison:
    """Compare the C model with a record; `report` is told of the three passes. Raises InputError when the model refuses the actuator, and for a record too short for any filter."""
    smoother = Smoother.of(record.period_s)
    if record.rows < smoother.least_rows:
        raise InputError(
            f"{record.file}: {record.rows} rows, {record.rows * record.period_s:g} s, too few for any filter: record {smoother.least_rows * record.period_s:g} s or more, best a chirp of ten"
        )
    simulation = simulated(actuator, record, bits)
    inner = smoother.inner
    channels: dict[str, ChannelError] = {}
    errors: dict[str, Balance] = {}
    for name in OUTPUTS:
        measured = record.channel(name)
        if measured is None:
            continue
        difference = inner(measured - getattr(simulation, name))
        errors[name] = Balance(name, UNITS[name], inner(record.time_s), inner(measured), difference)
        channels[name] = ChannelError(errors[name].rms, errors[name].relative_percent)
    of_balances = filter_of(actuator, record)
    found, balances = judged_balances(actuator, record, simulation, of_balances, report)
    where = _where(actuator, record, found, errors, balances)
    reading = None
    if any(not one.reason and one.excess_percent > 0.0 for one in balances.values()):
        floors = {name: math.hypot(one.noise_rms, one.method_rms) for name, one in balances.items()}
        reading = reading_against_model(actuator, record, found, floors, of_balances)
    return Comparison(record.file, channels, balances, where, simulation, reading=reading)


def judged_balances(
    actuator: Actuator, record: Record, simulation: Simulation, smoother: Smoother, report: Report | None = None
) -> tuple[dict[str, Balance | str], dict[str, BalanceError]]:
    """The four balances of a record, and their errors beside what noise and method leave; `simulation` is the model's run of the record."""
    # One filter for all three, so that what noise and method leave is comparable with what the record leaves.
    passes = []
    for like in (record, _with_own_noise(record), _as_recorded(simulation, record)):
        passes.append(all_balances(actuator, like, smoother))
        if report is not None:
            report(len(passes), "")
    found, noisy, own = passes
    return found, {name: _balance_error(found[name], noisy[name], own[name]) for name in BALANCES}


def _with_own_noise(record: Record) -> Record:
    """The record with as much white noise again as it seems to hold, to see what noise makes of a result."""
    random = np.random.default_rng(1)
    measured = {name: record.recorded(name) for name in ("position_mm", "motor_position_mm", "current_A") if name in record.present}
    return record.with_columns({name: values + random.normal(0.0, white_noise(values), record.rows) for name, values in measured.items()})


def _as_recorded(simulation: Simulation, record: Record) -> Record:
    """The simulated run as a record with the same channels."""
    return record.with_columns({name: getattr(simulation, name) for name in OUTPUTS if name in record.present})


def _balance_error(found: Balance | str, noisy: Balance | str, own: Balance | str) -> BalanceError:
    if isinstance(found, str):
        return BalanceError("", math.nan, math.nan, math.nan, math.nan, math.nan, found)
    noise = float(np.sqrt(np.mean((noisy.residual - found.residual) ** 2))) if isinstance(noisy, Balance) else 0.0
    method = own.rms if isinstance(own, Balance) else 0.0
    return BalanceError(found.unit, found.rms, found.relative_percent, noise, method, found.resting_percent)


def _where(
    actuator: Actuator, record: Record, found: dict[str, Balance | str], errors: dict[str, Balance], balances: dict[str, BalanceError]
) -> tuple[ErrorPart, ...]:
    """Every residual divided by state and frequency, and the balances among themselves, largest share first."""
    places = []
    weights = {name: error.excess_percent**2 for name, error in balances.items() if not error.reason}
    total = sum(weights.values())
    if total > 0.0:
        places = [ErrorPart("all balances", "", name, weight / total, None) for name, weight in weights.items()]
    states = states_of(actuator, record)
    for balance in found.values():
        if isinstance(balance, Balance):
            places += divided(f"{balance.name} balance", balance, states, record.first_time_s)
    for name, error in errors.items():
        places += divided(TITLES[name], error, states, record.first_time_s)
    return tuple(sorted(places, key=lambda place: -place.share))


@dataclass(frozen=True)
class State:
    """A signal on every row [rows] and the edges of its parts."""

    by: str
    values: Reals
    edges: tuple[float, ...]
    parts: tuple[str, ...]
    period_s: float


def even_parts(by: str, values: Reals, unit: str, period_s: float) -> State | None:
    """Parts of equal width between the lowest and the highest value; None when nothing changes."""
    low, high = float(np.min(values)), float(np.max(values))
    # A size begins at zero; its smallest sample is only close to it.
    low = 0.0 if 0.0 < low < 0.01 * high else low
    if not high > low:
        return None
    edges = tuple(float(edge) for edge in np.linspace(low, high, _BINS + 1))
    parts = tuple(f"{first:.3g} to {last:.3g} {unit}" for first, last in pairwise(edges))
    return State(by, values, edges, parts, period_s)


def states_of(actuator: Actuator, record: Record) -> list[State]:
    """By what residuals are divided: time, speed, direction, position, place in the screw's lead, current where recorded, time since the last reversal."""
    period_s = record.period_s
    smooth = Smoother.of(period_s).smooth(record.position_mm)
    speed = np.gradient(smooth, period_s)
    moving = np.abs(speed) > 0.01 * float(np.max(np.abs(speed), initial=0.0))
    direction = np.sign(speed) * moving
    states = [
        even_parts("time", record.time_s, "s", period_s),
        even_parts("speed", np.abs(speed), "mm/s", period_s),
        even_parts("position", smooth, "mm", period_s),
    ]
    lead = actuator["screw.lead_mm"]
    if np.ptp(smooth) > lead:
        # within one turn of the screw it says no more than the position
        states.append(even_parts("place in the lead", np.mod(smooth, lead), "mm", period_s))
    if record.current_A is not None:
        states.append(even_parts("current", np.abs(record.current_A), "A", period_s))
    return [state for state in (*states, *reversal_parts(direction, period_s)) if state is not None]


def reversal_parts(direction: Reals, period_s: float) -> tuple[State, State]:
    """The direction of motion [rows], -1, 0 or 1, and the time since the last reversal."""
    parts = tuple(f"{first:g} s or more" if math.isinf(last) else f"{first:g} to {last:g} s" for first, last in pairwise(_SINCE_REVERSAL_S))
    return (
        State("direction", direction, (-1.5, -0.5, 0.5, 1.5), ("retracting", "resting", "extending"), period_s),
        State("time since reversal", since_reversal_s(direction, period_s), _SINCE_REVERSAL_S, parts, period_s),
    )


def since_reversal_s(direction: Reals, period_s: float) -> Reals:
    """Time since the rod last left rest or changed direction, s [rows]."""
    rows = np.arange(direction.size)
    starts = np.concatenate(([True], (direction[1:] != direction[:-1]) & (direction[1:] != 0.0)))
    last = np.maximum.accumulate(np.where(starts, rows, 0))
    return np.asarray((rows - last) * period_s, dtype=np.float64)


def divided(source: str, balance: Balance, states: list[State], first_time_s: float) -> list[ErrorPart]:
    """Shares of one residual by every state and by frequency."""
    square = balance.residual**2
    total = float(np.sum(square))
    if not total > 0.0:
        return []
    places = _by_frequency(source, balance)
    for state in states:
        rows = np.clip(np.round((balance.time_s - first_time_s) / state.period_s).astype(int), 0, state.values.size - 1)
        index = np.clip(np.searchsorted(state.edges, state.values[rows], side="right") - 1, 0, len(state.parts) - 1)
        for place, part in enumerate(state.parts):
            here: NDArray[np.bool_] = index == place
            share = float(np.sum(square[here])) / total
            if share > 0.0:
                places.append(ErrorPart(source, state.by, part, share, float(np.mean(here))))
    return places


def _by_frequency(source: str, balance: Balance) -> list[ErrorPart]:
    """Shares of a residual by octaves from half a hertz."""
    period_s = float(balance.time_s[1] - balance.time_s[0]) if balance.time_s.size > 1 else 1.0
    power = np.abs(np.fft.rfft(balance.residual)) ** 2
    frequency = np.fft.rfftfreq(balance.residual.size, period_s)
    octave = np.where(
        frequency < _LOWEST_BAND_HZ, 0, 1 + np.floor(np.log2(np.maximum(frequency, _LOWEST_BAND_HZ) / _LOWEST_BAND_HZ))
    ).astype(int)
    found = []
    for place in range(int(octave.max(initial=0)) + 1):
        share = float(np.sum(power[octave == place]) / np.sum(power))
        low, high = (0.0, _LOWEST_BAND_HZ) if place == 0 else (_LOWEST_BAND_HZ * 2.0 ** (place - 1), _LOWEST_BAND_HZ * 2.0**place)
        if share > 0.0:
            found.append(ErrorPart(source, "frequency", f"{low:g} to {high:g} Hz", share, None))
    return found
