"""Commands of a menu with the model's runs under them, whether they are safe, and the noise that their records will have."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, nearest
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record, from_simulation
from ema_tools.design.menu import Offence, SafeRange
from ema_tools.plant.native import CHANNELS, Simulation, library

# Noise of the sensors, rms, at a record rate of 1 kHz, as of common encoders and current sensors [physics]
USUAL_NOISE: Mapping[str, float] = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03}
_VOLTAGE_NOISE = 1e-3  # that of the voltage as a share of the supply: the noise of a position through the gain of a stiff loop [physics]
_NOISE_PERIOD_S = 1e-3  # record period of the noise above [physics]


@dataclass(frozen=True)
class CommandRun:
    """A command and the model's run under it."""

    title: str
    text: str
    record: Record
    run: Simulation


def _simulated(actuator: Actuator, command_mm: Reals) -> Simulation:
    values, options = actuator.arrays()
    return library(32).simulate(values, options, command_mm, 0.0)


def run_of(actuator: Actuator, title: str, text: str) -> CommandRun:
    """The model's run under the command that `text` asks for. Raises InputError for one that does not exist."""
    command = make_command(text, actuator)
    run = _simulated(actuator, command.samples_mm)
    return CommandRun(title, text, from_simulation(run, command.samples_mm, actuator.record_period_s), run)


def safe_of(
    runs: Sequence[CommandRun], actuator: Actuator, values: Mapping[str, Mapping[str, float]], limits: SafeRange
) -> tuple[list[CommandRun], dict[str, Offence]]:
    """The commands that are safe on the machine as known and with the `values` of each of the effects, and why the others are not."""

    def why(one: CommandRun) -> Offence | None:
        found = limits.offence(one.run, one.record.command_mm, actuator, one.record.period_s)
        for effect, changes in values.items():
            if found is not None:
                break
            run = _simulated(actuator.changed(changes), one.record.command_mm)
            found = limits.offence(run, one.record.command_mm, actuator, one.record.period_s, effect)
        return found

    reasons = each(why, runs)
    return [one for one, reason in zip(runs, reasons, strict=True) if reason is None], {
        f"{one.title} ({one.text})": reason for one, reason in zip(runs, reasons, strict=True) if reason is not None
    }


def checked_channels(channels: Sequence[str]) -> tuple[str, ...]:
    """The channels in the order of CHANNELS. Raises InputError for one that does not exist."""
    for channel in channels:
        if channel not in CHANNELS:
            raise InputError(f"--channels {channel}: no such signal{nearest(channel, CHANNELS)}: signals are {', '.join(CHANNELS)}")
    return tuple(channel for channel in CHANNELS if channel in channels)


def noise_rms(actuator: Actuator, noise: Mapping[str, float] | None = None) -> dict[str, float]:
    """Noise of the channels, rms at 1 kHz: the usual, and `noise` in its place."""
    return {**USUAL_NOISE, "voltage_V": _VOLTAGE_NOISE * actuator["drive.supply_V"], **(noise or {})}


def rows_noise(actuator: Actuator) -> float:
    """By how much a row of the actuator's records is noisier than one at 1 kHz."""
    return math.sqrt(_NOISE_PERIOD_S / actuator.record_period_s)
