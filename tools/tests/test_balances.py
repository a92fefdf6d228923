"""The four balances: each accuses its own group of blocks and no other; standard errors hold for correlated residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ema_tools.balances.all import BALANCES, all_balances
from ema_tools.balances.balance import Balance
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import quiet_smoother
from ema_tools.base import leastsquares
from ema_tools.base.errors import InputError
from ema_tools.base.noise import white_noise
from ema_tools.data.actuator import reference_actuator
from support import chirp_record

# What a balance may leave on a record of its own model, in % of the measured side: what filtering and differences cost.
METHOD_PERCENT = {"mechanical": 2.5, "electrical": 0.5, "kinematic": 1e-3, "controller": 1e-6}


def percents(actuator, record):  # type: ignore[no-untyped-def]
    return {name: balance.relative_percent for name, balance in all_balances(actuator, record).items() if isinstance(balance, Balance)}


def test_own_record_closes_every_balance() -> None:
    found = percents(reference_actuator(), chirp_record())
    assert set(found) == set(BALANCES)
    for name, percent in found.items():
        assert percent < METHOD_PERCENT[name]


@pytest.mark.parametrize(
    ("name", "factor", "accused"),
    [
        ("screw.inertia_kgm2", 1.3, "mechanical"),
        ("screw.csj_Nm", 1.3, "mechanical"),
        ("motor.resistance_ohm", 1.3, "electrical"),
        ("motor.back_emf_V_s_per_rad", 1.1, "electrical"),
        ("screw.blk_mm", 2.0, "kinematic"),
        ("control.kp_per_m", 1.1, "controller"),
    ],
)
def test_wrong_value_is_seen_in_its_own_balance_alone(name: str, factor: float, accused: str) -> None:
    record = chirp_record()
    right = percents(reference_actuator(), record)
    wrong = percents(reference_actuator().changed({name: reference_actuator()[name] * factor}), record)
    for balance in BALANCES:
        if balance == accused:
            assert wrong[balance] > 5.0 * right[balance] + 0.3
        else:
            assert wrong[balance] == pytest.approx(right[balance], rel=1e-9)


EFFECTS = [
    {"stribeck_friction.rise": 0.5},
    {"cogging_torque.amplitude_Nm": 0.05},
    {"constant_load.torque_Nm": 0.05},
    {"winding_heating.rise_degC": 80.0},
    {"inverter_dead_time.drop_V": 0.5},
    {"feedback_delay.delay_s": 0.002},
    {"spring_load.stiffness_Nm_per_mm": 0.05},
    {"viscous_asymmetry.asymmetry": 0.8, "screw.viscous_Nm_s_per_rad": 5e-4},
    {"load_dependent_friction.ratio": 0.2},
    {"pitch_ripple.ratio": 0.3},
    {"source_resistance.resistance_ohm": 0.3},
    {"magnet_weakening.loss": 0.1},
    {"supply_sag.sag": 0.1},
    {"viscous_rise.rise": 9.0},
    {"concave_viscous.drag_Nm_per_sqrt_rad_s": 0.008},
    {"quadratic_viscous.drag_Nm_s2_per_rad2": 2e-6},
    {"jam_spot.amplitude_Nm": 0.1, "jam_spot.place_mm": 0.5},
    {"inertia_change.change": 0.3},
    {"gain_drift.drift": 0.3},
    {"coulomb_asymmetry.asymmetry": 0.3},
    {"coulomb_asymmetry.asymmetry": 0.3, "stribeck_friction.rise": 0.5, "screw.dynamic_ratio": 0.8},
    {"coulomb_asymmetry.asymmetry": 0.5, "stribeck_friction.rise": 1.0, "stribeck_friction.speed_rad_s": 60.0},
    {"torque_ripple.ratio": 0.1, "torque_ripple.periods": 2.0},
    {"presliding.stretch_rad": 0.3},
    {"actuation_delay.delay_s": 0.0027},
    {"transmission_compliance.period_s": 0.03, "transmission_compliance.mass_kg": 500.0},
    {
        "learned_torque.gain": 1.0,
        "learned_torque.axis": 3,
        "learned_torque.first": 0.0,
        "learned_torque.last": 6.0,
        "learned_torque.node_03": 0.1,
    },
    {
        "learned_friction.gain": 1.0,
        "learned_friction.axis": 1,
        "learned_friction.first": -2.0,
        "learned_friction.last": 2.0,
        "learned_friction.node_05": 0.1,
    },
    {
        "learned_reading.gain": 1.0,
        "learned_reading.axis": 1,
        "learned_reading.first": -2.0,
        "learned_reading.last": 2.0,
        "learned_reading.node_05": 0.1,
    },
    {"gearbox.efficiency": 0.8, "screw.load_torque_Nm": 0.05},
    {"encoder.resolution_mm": 0.01},
    {"control.every_steps": 2},
    {"control.derivative": 1, "control.average_speed": 1, "control.kd_s_per_m": 1.0},
]


@pytest.mark.parametrize("changes", EFFECTS, ids=[next(iter(change)) for change in EFFECTS])
def test_what_the_actuator_knows_is_in_the_balances(changes: dict[str, float]) -> None:
    actuator = reference_actuator().changed(changes)
    record = chirp_record(actuator, "chirp:duration_s=5")
    known = percents(actuator, record)
    unknown = percents(reference_actuator(), record)
    for name, percent in known.items():
        assert percent < 2.0 * METHOD_PERCENT[name]
    assert any(unknown[name] > 2.0 * known[name] for name in BALANCES)


def test_missing_signals_are_named() -> None:
    record = chirp_record()
    bare = replace(record, motor_position_mm=None, current_A=None, voltage_V=None)
    found = all_balances(reference_actuator(), bare)
    assert found["electrical"] == "voltage_V is not recorded"
    assert found["kinematic"] == "motor_position_mm is not recorded"
    assert found["controller"] == "voltage_V is not recorded"
    assert found["mechanical"] == "motor_position_mm is not recorded, and the rod follows the motor with play"
    no_motor = all_balances(reference_actuator(), replace(record, motor_position_mm=None))
    assert no_motor["mechanical"] == "motor_position_mm is not recorded, and the rod follows the motor with play"
    assert no_motor["controller"] == "motor_position_mm is not recorded, and the loop is closed on the motor encoder"
    assert all_balances(reference_actuator(), replace(record, current_A=None))["mechanical"] == "current_A is not recorded"
    compliant = reference_actuator().changed({"transmission_compliance.period_s": 0.02, "transmission_compliance.mass_kg": 1.0})
    assert "transmission_compliance" in str(all_balances(compliant, chirp_record(compliant))["kinematic"])
    between = reference_actuator().changed({"timing.record_every_steps": 2})
    assert all_balances(between, chirp_record(between))["controller"] == "the control law runs between the recorded rows"


def test_ideal_current_drive_tells_the_current_by_its_command() -> None:
    changes = {
        "drive.mode": 1,
        "drive.current_scale_A": 10.0,
        "drive.command_scale_V": 10.0,
        "control.kp_per_m": 200.0,
        "control.kd_s_per_m": 5.0,
    }
    actuator = reference_actuator().changed(changes)
    record = chirp_record(actuator)
    assert np.max(np.abs(record.voltage_V)) > 1.0
    with_current = percents(actuator, record)
    without = percents(actuator, replace(record, current_A=None))
    assert without["mechanical"] == pytest.approx(with_current["mechanical"], rel=1e-6)
    assert "electrical" not in without


@pytest.mark.parametrize("changes", [{"actuation_delay.delay_s": 0.0027}, {"drive.current_loop_s": 0.002}])
def test_late_current_is_told_by_its_command(changes: dict[str, float]) -> None:
    ideal = {
        "drive.mode": 1,
        "drive.current_scale_A": 10.0,
        "drive.command_scale_V": 10.0,
        "control.kp_per_m": 200.0,
        "control.kd_s_per_m": 5.0,
    }
    actuator = reference_actuator().changed(ideal | changes)
    record = chirp_record(actuator)
    bare = replace(record, current_A=None)
    assert percents(actuator, bare)["mechanical"] == pytest.approx(percents(actuator, record)["mechanical"], rel=1e-6)
    assert percents(actuator, bare)["mechanical"] < 0.6 * percents(reference_actuator().changed(ideal), bare)["mechanical"]


def test_noise_is_measured_and_lowers_the_filter() -> None:
    record = chirp_record()
    assert white_noise(record.position_mm) < 1e-6
    noisy = record.with_noise({"position_mm": 0.005, "motor_position_mm": 0.005}, 1)
    assert white_noise(noisy.position_mm) == pytest.approx(0.005, rel=0.05)
    assert quiet_smoother(reference_actuator(), record) == Smoother(record.period_s, 100.0)
    assert quiet_smoother(reference_actuator(), noisy).cutoff_hz < 100.0


def test_smoother_keeps_slow_and_takes_fast() -> None:
    smoother = Smoother.of(1e-3)
    time_s = 1e-3 * np.arange(5000)
    slow = np.sin(2.0 * np.pi * 3.0 * time_s)
    fast = np.sin(2.0 * np.pi * 90.0 * time_s)
    assert smoother.decimated(slow) == pytest.approx(smoother.kept(slow), abs=0.02)
    assert np.max(np.abs(smoother.decimated(fast)[10:-10])) < 1e-2
    assert smoother.kept(time_s)[0] == pytest.approx(0.05)


def autoregressive(random: np.random.Generator, ratio: float, size: int) -> np.ndarray:
    noise = random.normal(size=size)
    for k in range(1, size):
        noise[k] += ratio * noise[k - 1]
    return noise


@pytest.mark.parametrize("ratio", [0.0, 0.8])
def test_stated_errors_are_the_real_ones(ratio: float) -> None:
    random = np.random.default_rng(5)
    size = 1500
    columns = np.column_stack([np.sin(0.01 * np.arange(size)), np.ones(size)])
    truth = np.array([2.0, -1.0])
    found = [leastsquares.fit([columns @ truth + autoregressive(random, ratio, size)], [columns], ["a", "b"]) for _ in range(300)]
    real = np.std([fit.parameters for fit in found], axis=0)
    stated = np.mean([fit.std for fit in found], axis=0)
    assert np.all(stated / real > 0.8)
    assert np.all(stated / real < 1.25)


def test_what_data_do_not_determine_is_named() -> None:
    ones = np.ones(50)
    with pytest.raises(InputError, match="calibrate: b: no record moves what it acts on"):
        leastsquares.fit([ones], [np.column_stack([ones, 0.0 * ones])], ["a", "b"])
    with pytest.raises(InputError, match=r"calibrate: [ab]: the records do not determine it"):
        leastsquares.fit([ones], [np.column_stack([ones, 2.0 * ones])], ["a", "b"])
