"""Simulation of an actuator into a recording: what `ema simulate` does."""

from __future__ import annotations

from collections.abc import Iterable

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator, nearest, parsed, row_of
from ema_tools.data.commands import SampledCommand
from ema_tools.data.records import COLUMNS, Record, from_simulation
from ema_tools.library.one_at_a_site import clash
from ema_tools.plant.native import library


def with_settings(actuator: Actuator, settings: Iterable[str]) -> Actuator:
    """A copy with each `name=value` set. Raises InputError that names the setting and the nearest known name."""
    changes = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}: no value: write --set section.field=value")
        row = row_of(name.strip())
        changes[row.name] = parsed(row, value.strip(), "--set ")
    changed = actuator.changed(changes)
    if two := clash(changed.values):
        raise InputError(f"--set: {two}")
    return changed


def noise_of(text: str | None) -> dict[str, float]:
    """Standard deviations by column from `column=std,...`. Raises InputError that names the column."""
    std = {}
    for part in filter(None, (text or "").split(",")):
        name, _, value = part.partition("=")
        name = name.strip()
        if name not in COLUMNS[1:]:
            raise InputError(f"--noise {part}: unknown column{nearest(name, COLUMNS[1:])}: columns are {', '.join(COLUMNS[1:])}")
        try:
            std[name] = float(value)
        except ValueError:
            raise InputError(f"--noise {part}: not a number: write for example --noise position_mm=0.005") from None
        if not 0.0 <= std[name] < float("inf"):
            raise InputError(f"--noise {part}: not a standard deviation: give a number that is zero or more")
    return std


def simulate_record(
    actuator: Actuator, command: SampledCommand, bits: int = 64, noise: dict[str, float] | None = None, seed: int = 1
) -> Record:
    """The record that the actuator leaves under `command`, with white noise where asked. Raises InputError when the model refuses."""
    values, options = actuator.arrays()
    simulation = library(bits).simulate(values, options, command.samples_mm, command.start_mm)
    record = from_simulation(simulation, command.samples_mm, actuator.record_period_s)
    return record.with_noise(noise or {}, seed)
