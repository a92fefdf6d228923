"""Friction on a day of another temperature, and of a unit whose healthy runs scatter: what that explains is healthy, what a healthy answer may not hide is not, and a unit that repeats well on a
day like the others loses nothing by it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import Record
from ema_tools.tasks.identify import Identified, identify
from ema_tools.words.sentences.identification import reasons, sentence
from support import chirp_record

KNOWN = reference_actuator()
NOISE = {"position_mm": 0.005, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
CSJ, WINDING, GREASE = "screw.csj_Nm", "motor.resistance_ohm", "screw.viscous_Nm_s_per_rad"
# healthy runs, friction over its nominal value
STEADY, APART = (1.0, 1.002, 0.997), (1.0, 1.045, 0.965)


def _run(friction: float, seed: int, warmer_degC: float = 0.0) -> Record:
    """A run with copper and grease as they are at that temperature, and friction as told."""
    values = {CSJ: friction, WINDING: 1.0 + 0.00393 * warmer_degC, GREASE: math.exp(-0.03 * warmer_degC)}
    day = KNOWN.changed({name: share * KNOWN[name] for name, share in values.items()})
    return replace(chirp_record(day).with_noise(NOISE, seed), file=f"run_{seed}.csv")


def _found(today: float, healthy: tuple[float, ...] = STEADY, warmer_degC: float = 0.0) -> Identified:
    return identify(KNOWN, _run(today, 1, warmer_degC), [_run(one, seed) for seed, one in enumerate(healthy, 2)])


@pytest.mark.slow
def test_a_shift_that_temperature_explains_as_well_is_healthy_and_says_so() -> None:
    found = _found(1.06, warmer_degC=8.0)
    assert found.sound_by_scatter and found.verdict == "healthy" and found.adequate and reasons(found) == ()
    assert "is no more than another temperature than that of the healthy records explains; +15 % would be" in sentence(found)
    low, high = found.interval95(found.answer.identified[0])
    assert low is not None and high is not None and low < KNOWN[CSJ] and high > 1.06 * KNOWN[CSJ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("today", "healthy"), [(1.06, STEADY), (1.25, APART)], ids=["a steady unit on a day like the others", "more than the runs differ by"]
)
def test_what_is_more_than_the_healthy_runs_show_is_a_fault(today: float, healthy: tuple[float, ...]) -> None:
    found = _found(today, healthy)
    assert found.verdict == "fault" and not found.sound_by_scatter


@pytest.mark.slow
@pytest.mark.parametrize(("today", "healthy", "warmer_degC"), [(1.12, APART, 0.0), (1.06, STEADY, 30.0), (1.12, STEADY, 8.0)])
def test_what_a_healthy_answer_may_not_hide_is_undecided(today: float, healthy: tuple[float, ...], warmer_degC: float) -> None:
    assert _found(today, healthy, warmer_degC).verdict == "undecided"
