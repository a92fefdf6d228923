"""A sensor's own error is told from physics: it shows in one signal alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.select.baseline import gather
from ema_tools.select.sensors import Suspect, suspect
from ema_tools.tasks.diagnose import answer
from ema_tools.words.answers.diagnosis import diagnosis
from ema_tools.words.sentences.diagnosis import record_next, sentence
from support import chirp_record

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
LATE_ROWS = 2


@cache
def run(seed: int, **changes: float) -> Record:
    """A run of the reference actuator, changed, as its sensors show it."""
    return chirp_record(reference_actuator().changed({name.replace("__", "."): value for name, value in changes.items()})).with_noise(
        NOISE, seed
    )


def repeats() -> list[Record]:
    return [replace(run(seed), file=f"repeat {seed}") for seed in range(1, 5)]


def suspected(record: Record) -> Suspect | None:
    return suspect(gather(reference_actuator(), record, repeats()))


@pytest.mark.parametrize(
    ("change", "channel", "factor", "offset", "late_ms"),
    [
        (lambda r: replace(r, current_A=1.2 * r.current_A), "current_A", 1.2, 0.0, 0.0),
        pytest.param(lambda r: replace(r, current_A=r.current_A + 0.5), "current_A", 1.0, 0.5, 0.0, marks=pytest.mark.slow),
        pytest.param(lambda r: replace(r, voltage_V=0.9 * r.voltage_V - 1.0), "voltage_V", 0.9, -1.0, 0.0, marks=pytest.mark.slow),
        (
            lambda r: replace(r, motor_position_mm=np.concatenate((np.zeros(LATE_ROWS), r.motor_position_mm[:-LATE_ROWS]))),
            "motor_position_mm",
            1.0,
            0.0,
            LATE_ROWS,
        ),
    ],
    ids=["gain", "zero", "both", "late"],
)
def test_an_error_of_one_sensor_is_suspected(
    change: Callable[[Record], Record], channel: str, factor: float, offset: float, late_ms: float
) -> None:
    found = suspected(change(run(9)))
    assert found is not None and found.channel == channel and found.share > 0.9
    assert found.factor == pytest.approx(factor, abs=0.005)
    assert found.offset == pytest.approx(offset, abs=0.02)
    # the signal moves a little more than its slope says
    assert 1e3 * found.late_s == pytest.approx(late_ms, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{}, {"screw__csj_Nm": 0.16}, {"effects__magnet_weakening__loss": 0.04}, {"effects__stribeck_friction__rise": 0.3}]
)
def test_physics_and_nothing_are_not(changes: dict[str, float]) -> None:
    assert suspected(run(9, **changes)) is None


@pytest.mark.slow
def test_the_answer_says_so_and_what_to_do() -> None:
    found = answer(reference_actuator(), replace(run(9), current_A=1.2 * np.asarray(run(9).current_A)), repeats())
    assert found.verdict == "unknown" and found.effects == ()
    assert "looks like the sensor of the current (current_A), not like the machine: it reads 1.2 times the signal" in sentence(found)
    assert record_next(found) == "Next: check the sensor of the current (scale, zero, delay) and record again."
    told = diagnosis(found, {}).sensor
    assert told is not None and told.channel == "current_A"
