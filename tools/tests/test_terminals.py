"""Voltage that was recorded at the motor's terminals is told from that which the controller asks for."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ema_tools.base.noise import resolution
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record, from_simulation
from ema_tools.plant.native import library
from ema_tools.select.baseline import _counts_alike
from ema_tools.select.terminals import drop_V

BRIDGE_V, LINE_OHM = 0.05, 0.02


def runs(actuator: Actuator, command: str, at_terminals: bool, count: int = 3) -> list[Record]:
    """Healthy runs with noise of the sensors, as the actuator is, behind a bridge or not."""
    asked = make_command(command, actuator).samples_mm
    values, options = actuator.arrays()
    clean = from_simulation(library(64).simulate(values, options, asked, float(asked[0])), asked, actuator.record_period_s)
    found = []
    for seed in range(count):
        random = np.random.default_rng(seed)
        noisy = {
            name: clean.recorded(name) + size * random.normal(size=clean.rows)
            for name, size in (("position_mm", 2e-3), ("motor_position_mm", 2e-3), ("current_A", 0.03), ("voltage_V", 0.01))
        }
        if at_terminals:
            current = clean.recorded("current_A")
            noisy["voltage_V"] -= BRIDGE_V * np.tanh(current / 0.2) + LINE_OHM * current
        found.append(clean.with_columns(noisy))
    return found


@pytest.mark.parametrize("command", ["chirp", "triangle:start_hz=1"])
def test_a_bridges_drop_is_found(command: str) -> None:
    unit = reference_actuator()
    # the line's loss goes with the current too, so that the drop alone is found to a third
    assert drop_V(unit, runs(unit, command, True)) == pytest.approx(BRIDGE_V, rel=0.35)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"control.kp_per_m": 1.03},
        {"drive.supply_V": 0.97},
        {"screw.csj_Nm": 1.5},
        {"motor.resistance_ohm": 1.2},
        {"effects.inverter_dead_time.drop_V": 0.1, "effects.inverter_dead_time.width_A": 0.2},
    ],
)
def test_what_is_asked_for_is_left_in(changes: dict[str, float]) -> None:
    known = reference_actuator()
    unit = known.changed({name: value * (1.0 if name.startswith("effects") else known[name]) for name, value in changes.items()})
    assert drop_V(known, runs(unit, "chirp", False)) == 0.0


def test_without_the_signals_nothing_is_said() -> None:
    unit = reference_actuator()
    (record,) = runs(unit, "chirp", True, 1)
    absent = Record(record.period_s, record.command_mm, record.position_mm, voltage_V=record.voltage_V, file="alone")
    assert drop_V(unit, [absent]) == 0.0


@pytest.mark.parametrize("step", [0.02, 1e-3, 0.25])
def test_resolution_is_the_step_of_a_count(step: float) -> None:
    signal = np.sin(np.linspace(0.0, 6.0, 4000))
    assert resolution(step * np.round(signal / step)) == pytest.approx(step)
    assert resolution(signal) == 0.0
    assert resolution(np.zeros(100)) == 0.0


def test_counts_err_alike_where_noise_does_not_tell_them_apart() -> None:
    """Against drawn counts: what many noisy runs of one way have in common, and by what they differ."""
    differs, alike = _counts_alike()
    way = np.linspace(0.0, 40.0, 8000)
    random = np.random.default_rng(3)
    for noise in (0.05, 0.12, 0.3):
        counted = np.round(way + noise * random.normal(size=(60, way.size)))
        common = float(np.var(counted.mean(axis=0) - way))
        within = float(np.mean(np.var(counted, axis=0, ddof=1)))
        assert np.interp(within, differs, alike) == pytest.approx(common - within / 60, abs=3e-3)
    assert alike[0] == pytest.approx(1.0 / 12.0, rel=0.01) and math.isclose(alike[-1], 0.0, abs_tol=1e-12)
