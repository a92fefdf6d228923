"""The machine of two masses that the verdicts are tried on: what it is said to have, it shows."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.hidden.machines import command_mm
from benchmarks.verdicts import two_mass
from benchmarks.verdicts.trials import TWO_MASSES, drawn
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator


def run(changes: dict[str, float], command: str = "triangle") -> Recording:
    return two_mass.measured(two_mass.unit(7, ""), changes, command_mm(command), seed=3)


def lost_motion_mm(one: Recording) -> float:
    """Between the ways forward and back, while the motor moves."""
    ahead = one.motor_position_mm - one.position_mm
    speed = np.gradient(one.motor_position_mm)
    moving = np.abs(speed) > 0.5 * np.max(np.abs(speed))
    return float(np.mean(ahead[moving & (speed > 0.0)]) - np.mean(ahead[moving & (speed < 0.0)]))


def rubbing_Nm(one: Recording) -> float:
    """Half of the torque between the ways forward and back at steady speed."""
    speed = np.gradient(one.motor_position_mm)
    steady = np.abs(speed) > 0.8 * np.median(np.abs(speed))
    current = one.current_A
    gain = two_mass.unit(7, "").sheet["motor.torque_constant_Nm_per_A"]
    return 0.5 * gain * float(np.median(current[steady & (speed > 0.0)]) - np.median(current[steady & (speed < 0.0)]))


@pytest.mark.slow
def test_wear_is_what_the_signals_show() -> None:
    sheet = two_mass.unit(7, "").sheet
    sound = run({})
    worn = run({"screw.csj_Nm": 1.4 * sheet["screw.csj_Nm"], "screw.blk_mm": 2.0 * sheet["screw.blk_mm"]})
    # the contact gives way by less than a micrometre more under the larger friction of the rod
    assert lost_motion_mm(worn) - lost_motion_mm(sound) == pytest.approx(sheet["screw.blk_mm"], abs=2e-3)
    # friction of day and bristles, the bump and grease stay below a tenth of the level
    assert rubbing_Nm(worn) - rubbing_Nm(sound) == pytest.approx(0.4 * sheet["screw.csj_Nm"], rel=0.1)


@pytest.mark.slow
def test_a_day_hangs_on_its_seed_alone() -> None:
    first, again = run({}, "chirp"), run({}, "chirp")
    assert np.array_equal(first.position_mm, again.position_mm) and np.array_equal(first.current_A, again.current_A)
    other = two_mass.measured(two_mass.unit(7, ""), {}, command_mm("chirp"), seed=4)
    assert not np.array_equal(first.position_mm, other.position_mm)


@pytest.mark.slow
def test_step_is_fine_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of the step moves no signal by as much as its sensor's noise."""
    coarse = run({}, "fast chirp")
    monkeypatch.setattr(two_mass, "STEP_S", 0.25 * two_mass.STEP_S)
    fine = run({}, "fast chirp")
    assert float(np.std(coarse.position_mm - fine.position_mm)) < 0.001
    assert float(np.std(coarse.current_A - fine.current_A)) < 0.01


@pytest.mark.slow
def test_no_unit_runs_away() -> None:
    for number in range(3000, 3012):
        one = two_mass.measured(two_mass.unit(number, "coloured"), {}, command_mm("fast chirp"), seed=number)
        assert float(np.max(np.abs(one.position_mm))) < 2.0
        voltage = reference_actuator()["drive.supply_V"]
        assert float(np.max(np.abs(one.voltage_V))) < 1.05 * voltage


def test_every_other_drawn_machine_is_of_two_masses() -> None:
    trials = drawn(40)
    assert sum(one.build == TWO_MASSES for one in trials) == 20
    assert len({one.key for one in trials}) == 40
