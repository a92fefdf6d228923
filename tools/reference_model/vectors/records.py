"""From a case to its numbers: the command and the reference model's rows."""

from __future__ import annotations

import numpy as np

from ema_tools.library.definitions import load_definitions
from reference_model import commands, simulate
from reference_model.vectors.cases import CHANNELS, Case, Command

OVERSAMPLE = 100  # integration steps of the reference per model step


def samples(command: Command, count: int, step_s: float) -> np.ndarray:
    """The command in mm at every step, [count]."""
    time_s = commands.times_s(count, step_s)
    if command.kind == "CHIRP":
        return commands.chirp(time_s, command.amplitude_mm, command.start_hz, command.end_hz, command.duration_s)
    if command.kind == "MULTISINE":
        return commands.multisine(time_s, command.amplitude_mm, command.start_hz, command.count)
    if command.kind == "TRIANGLE":
        return commands.triangle(time_s, command.amplitude_mm, command.start_hz)
    if command.kind == "TRAPEZOID":
        return commands.trapezoid(time_s, command.amplitude_mm, command.start_hz, command.share)
    if command.kind == "STEP":
        return commands.step(time_s, command.amplitude_mm, command.time_s)
    raise ValueError(f"{command.kind}: no such kind of command: use CHIRP, MULTISINE, TRIANGLE, TRAPEZOID or STEP")


def samples_of(case: Case) -> np.ndarray:
    """The command of a case, one per model step."""
    nominal = load_definitions().find("timing.step_s").nominal
    return samples(case.command, case.steps, case.values.get("timing.step_s", nominal))


def rows_of(case: Case) -> np.ndarray:
    """Every `every_rows`-th record row of the reference model, [rows, channels]."""
    record = simulate(case.values, samples_of(case), case.start_mm, OVERSAMPLE)
    return np.stack([getattr(record, channel) for channel in CHANNELS], axis=1)[:: case.every_rows]
