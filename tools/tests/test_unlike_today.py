"""A mistake in today's record is said of today's record, not of the healthy ones."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.tasks.identify import identify
from ema_tools.words.sentences.identification import sentence
from support import chirp_record

KNOWN = reference_actuator()
NOISE = {"position_mm": 0.005, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
# what the file does not hold: the model cannot read a run of this unit by itself
OTHER = {"effects.stribeck_friction.rise": 0.5, "effects.stribeck_friction.speed_rad_s": 15.0}


def _run(seed: int, file: str, command: str = "chirp") -> Record:
    return replace(chirp_record(KNOWN.changed(OTHER), command).with_noise(NOISE, seed), file=file)


def _cut(record: Record, rows: int) -> Record:
    names = ("command_mm", "position_mm", "motor_position_mm", "current_A", "voltage_V")
    return replace(record, **{name: getattr(record, name)[:rows] for name in names})


@pytest.mark.parametrize(
    ("today", "said"),
    [
        (
            lambda: _cut(_run(1, "today.csv"), 6000),
            r"today\.csv: .*its 6000 rows are the beginning of the command of healthy_2\.csv.*cut off",
        ),
        (lambda: _run(1, "today.csv", "chirp:amplitude_mm=1.5"), r"today\.csv: command_mm: not the command of healthy_2\.csv"),
        (
            lambda: replace(one := _run(1, "today.csv"), command_mm=one.position_mm, position_mm=one.command_mm),
            r"today\.csv: .*before its command, which no machine does",
        ),
    ],
    ids=["cut off", "another command", "command and position exchanged"],
)
def test_what_is_unlike_the_healthy_records_is_today_s(today: Callable[[], Record], said: str) -> None:
    with pytest.raises(InputError, match=said):
        identify(KNOWN, today(), [_run(seed, f"healthy_{seed}.csv") for seed in (2, 3)])


@pytest.mark.slow
def test_a_rod_sensor_that_is_held_for_a_while_is_said() -> None:
    today = _run(1, "today.csv")
    position_mm = np.array(today.position_mm)
    position_mm[6000:6400] = position_mm[6000]
    found = identify(KNOWN, replace(today, position_mm=position_mm), [_run(seed, f"healthy_{seed}.csv") for seed in (2, 3)])
    assert found.verdict == "undecided"
    assert "position_mm repeats one value for 400 rows from row 6001, where the motor turns on" in sentence(found)
