"""The command of a simulation, from what the user typed: a recording, or a name with numbers such as `chirp:amplitude_mm=2`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.files import readable
from ema_tools.data.actuator import Actuator, nearest
from ema_tools.data.records import read_record, start_of
from ema_tools.plant.native import COMMAND_KINDS, COMMAND_NUMBERS, library

# What a command takes, with the numbers that hold when none is given; duration_s is the length of the record.
DEFAULTS: dict[str, dict[str, float]] = {
    "chirp": {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0},
    "multisine": {"amplitude_mm": 2.0, "start_hz": 0.2, "count": 20.0, "duration_s": 10.0},
    "triangle": {"amplitude_mm": 2.0, "start_hz": 0.5, "duration_s": 10.0},
    "trapezoid": {"amplitude_mm": 2.0, "start_hz": 0.5, "share": 0.5, "duration_s": 10.0},
    "step": {"amplitude_mm": 2.0, "time_s": 0.5, "duration_s": 2.0},
}
_ROWS_MAX = 10_000_000


@dataclass(frozen=True)
class SampledCommand:
    """Samples of a command [rows] at the actuator's record period, where the rod starts, and how it was asked for."""

    samples_mm: Reals
    start_mm: float
    text: str


def explain() -> str:
    """The commands and their numbers, for help texts."""
    return "; ".join(f"{kind}:{','.join(f'{name}={value:g}' for name, value in numbers.items())}" for kind, numbers in DEFAULTS.items())


def parsed_numbers(kind: str, text: str) -> dict[str, float]:
    """The numbers of `key=value,...` over the defaults of `kind`. Raises InputError that names the key."""
    numbers = dict(DEFAULTS[kind])
    for part in filter(None, text.split(",")):
        key, equals, value = part.partition("=")
        key = key.strip()
        if not equals or key not in numbers:
            raise InputError(f"command {kind}: {part}: unknown number{nearest(key, numbers)}: use {', '.join(numbers)} as key=value")
        try:
            numbers[key] = float(value)
        except ValueError:
            raise InputError(f"command {kind}: {key}={value}: not a number: write for example {key}={numbers[key]:g}") from None
        if not np.isfinite(numbers[key]):
            raise InputError(f"command {kind}: {key}={value}: not a finite number: write for example {key}={DEFAULTS[kind][key]:g}")
    if not numbers["duration_s"] > 0.0:
        raise InputError(f"command {kind}: duration_s={numbers['duration_s']:g}: not above zero: write for example duration_s=10")
    return numbers


def make_command(text: str, actuator: Actuator) -> SampledCommand:
    """The command that `text` asks for. Raises InputError for an unknown one, a bad number or a record at another rate."""
    kind, _, numbers_text = text.partition(":")
    period_s = actuator.record_period_s
    if kind in COMMAND_KINDS:
        numbers = parsed_numbers(kind, numbers_text)
        asked = numbers["duration_s"] / period_s
        if not 0.5 < asked < _ROWS_MAX + 0.5:
            raise InputError(f"command {kind}: duration_s={numbers['duration_s']:g}: {asked:.0f} rows: ask for 1 to {_ROWS_MAX}")
        rows = round(asked)
        given = {name: numbers[name] for name in COMMAND_NUMBERS if name in numbers}
        samples = library().command(kind, given, period_s, rows)
        return SampledCommand(samples, 0.0, f"{kind}:{','.join(f'{name}={value:g}' for name, value in numbers.items())}")
    if not Path(text).exists():
        raise InputError(
            f"command {text}: neither a file nor a command{nearest(kind, DEFAULTS)}: use a recording or one of {', '.join(DEFAULTS)}"
        )
    record = read_record(text, actuator)
    return SampledCommand(record.command_mm, start_of(actuator, record), readable(Path(text).name))
