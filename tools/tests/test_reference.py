"""The reference model against closed forms, balances and properties that hold for every actuator."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import defaults, load_definitions
from reference_model import commands, elementary, encoder, simulate
from reference_model.actuator import build
from reference_model.commands import chirp, times_s
from reference_model.effects import SITE_FUNCTIONS, example_of, module_of

pytestmark = [
    pytest.mark.release,  # compiling the model takes half a minute; in every run its vectors hold the C
    pytest.mark.skipif(not HAS_NUMBA, reason="numba has no wheel here: the reference would take minutes per record"),
]

NOMINAL = defaults()
KT = NOMINAL["motor.torque_constant_Nm_per_A"]
KE = NOMINAL["motor.back_emf_V_s_per_rad"]
R = NOMINAL["motor.resistance_ohm"]
L = NOMINAL["motor.inductance_H"]
J = NOMINAL["screw.inertia_kgm2"]
D = NOMINAL["screw.viscous_Nm_s_per_rad"]
# The rod moves so little that the loop is open: the command alone sets the output.
OPEN = {
    "screw.lead_mm": 0.01,
    "gearbox.ratio": 1000.0,
    "control.kp_per_m": 1e-3,
    "control.ki_per_m_s": 0.0,
    "screw.blk_mm": 0.0,
}
OPEN_MM_PER_RAD = 0.01 / (2.0 * math.pi * 1000.0)
CURRENT_A = {**OPEN, "drive.mode": 1, "drive.current_scale_A": 10.0}
NAMES = [effect.name for effect in load_definitions().effects]


def held(share: float, steps: int) -> np.ndarray:
    """An open-loop output of `share`, [steps]."""
    return np.full(steps, share * 1e6)


# --- elementary functions, commands ---


@given(st.floats(-1e4, 1e4))
def test_sine_and_cosine(x: float) -> None:
    assert abs(elementary.sin(x) - math.sin(x)) < 5e-16
    assert abs(elementary.cos(x) - math.cos(x)) < 5e-16


@given(st.floats(-600.0, 600.0))
def test_exponential(x: float) -> None:
    assert elementary.exp(x) == pytest.approx(math.exp(x), rel=1e-15)


@given(st.floats(1e-12, 1e12), st.floats(0.1, 4.0))
def test_logarithm_and_power(x: float, exponent: float) -> None:
    assert elementary.log(x) == pytest.approx(math.log(x), rel=1e-15, abs=1e-16)
    assert elementary.power(x, exponent) == pytest.approx(x**exponent, rel=5e-14)


def test_commands() -> None:
    t = times_s(10_001)
    sweep = chirp(t)
    assert sweep[0] == 0.0
    assert sweep[2_000] == pytest.approx(2.0 * math.sin(2.0 * math.pi * (0.2 + 3.9 * 4.0 / 20.0)), abs=1e-12)
    assert np.all(chirp(t, duration_s=4.0)[4_000:] == chirp(t, duration_s=4.0)[4_000])
    triangle = commands.triangle(t, 3.0, 0.5)
    assert triangle[[0, 250, 500, 1000, 1500, 1750]] == pytest.approx([0.0, 1.5, 3.0, 0.0, -3.0, -1.5], abs=1e-12)
    flat = commands.trapezoid(t, 3.0, 0.5, 0.5)
    assert flat[[0, 125, 250, 500, 750, 875, 1000, 1125, 1250, 1500]] == pytest.approx(
        [0.0, 1.5, 3.0, 3.0, 3.0, 1.5, 0.0, -1.5, -3.0, -3.0], abs=1e-12
    )
    jump = commands.step(t, 2.0, 0.5)
    assert (jump[499], jump[500]) == (0.0, 2.0)
    assert list(commands.record([1.0, 2.0], 3, 8)) == [1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 2.0]


def test_multisine_has_its_lines_and_no_others() -> None:
    count = 5
    wave = commands.multisine(times_s(2_000), 2.0, 0.5, count)
    assert wave[0] == 0.0
    lines = np.abs(np.fft.rfft(wave - wave.mean())) / 1_000
    assert lines[1 : count + 1] == pytest.approx(np.full(count, 2.0 / math.sqrt(count)), abs=1e-9)
    assert np.all(lines[count + 1 :] < 1e-9)


# --- closed forms ---


def test_steady_speed() -> None:
    record = simulate(OPEN, held(0.5, 800))
    speed = record.speed_mm_s[-1] / OPEN_MM_PER_RAD
    assert speed == pytest.approx((KT * 12.0 / R - NOMINAL["screw.csj_Nm"]) / (D + KT * KE / R), rel=1e-9)


def test_locked_rotor_current() -> None:
    record = simulate({**OPEN, "screw.csj_Nm": 100.0}, held(0.25, 30))
    expected = 6.0 / R * (1.0 - np.exp(-R / L * record.time_s))
    assert record.current_A == pytest.approx(expected, abs=1e-9)
    assert np.all(record.motor_position_mm == 0.0)


def test_coast_down() -> None:
    friction = 0.05
    pulse, steps = 50, 400
    command = np.where(np.arange(steps) < pulse, 5e5, 0.0)
    record = simulate({**CURRENT_A, "screw.csj_Nm": friction}, command)
    released = record.speed_mm_s[pulse] / OPEN_MM_PER_RAD
    drive = KT * 5.0 - friction
    assert released == pytest.approx(drive / D * -math.expm1(-D / J * pulse * 1e-3), rel=1e-9)
    coasting = np.count_nonzero(record.speed_mm_s[pulse:] > 0.0) * 1e-3
    stop = J / D * math.log1p(D * released / friction)
    assert stop < coasting <= stop + 1e-3
    way = J / D * (released - friction / D * math.log1p(D * released / friction))
    assert (record.motor_position_mm[-1] - record.motor_position_mm[pulse]) / OPEN_MM_PER_RAD == pytest.approx(way, rel=1e-7)


def test_breaks_away_at_the_static_level_and_slides_on_the_dynamic_one() -> None:
    # the current rises by 10 A/s: it reaches the static level of 0.3 Nm after 0.3 / kt / 10 s
    ramp = np.arange(800) * 1e-3 * 1e6
    record = simulate({**CURRENT_A, "screw.csj_Nm": 0.3, "screw.dynamic_ratio": 0.6}, ramp)
    first = np.argmax(record.speed_mm_s > 0.0)
    level = KT * record.current_A[first - 1]
    assert level == pytest.approx(0.3, abs=KT * 10.0 * 1e-3)
    assert level > 0.3
    rise = (record.speed_mm_s[first] - record.speed_mm_s[first - 1]) / OPEN_MM_PER_RAD / 1e-3
    assert rise == pytest.approx((level - 0.18) / J, rel=0.01)


def test_dead_band_width() -> None:
    play = 0.3
    record = simulate({"screw.blk_mm": play}, commands.triangle(times_s(2_000), 2.0, 1.0))
    lag = record.motor_position_mm - record.position_mm
    assert lag.max() == pytest.approx(0.5 * play, abs=1e-12)
    assert lag.min() == pytest.approx(-0.5 * play, abs=1e-12)
    # the rod rests at the motor's extreme minus half the play, wherever in a step the reversal lies
    resting = record.speed_mm_s == 0.0
    assert np.all(np.diff(record.position_mm)[resting[:-1] & resting[1:] & (np.abs(lag[:-1]) < 0.49 * play)] == 0.0)


def test_end_of_travel() -> None:
    record = simulate({"screw.travel_mm": 1.0}, chirp(times_s(1_000), 2.0, 1.0, 1.0, 1.0))
    assert np.abs(record.motor_position_mm).max() == pytest.approx(1.0, abs=1e-12)
    at_end = record.motor_position_mm >= 1.0 - 1e-12
    assert np.count_nonzero(at_end) > 20
    assert np.all(record.speed_mm_s[at_end] == 0.0)


def test_torque_saturation_sets_the_acceleration() -> None:
    record = simulate({**CURRENT_A, "motor.torque_limit_Nm": 0.3, "screw.viscous_Nm_s_per_rad": 0.0}, held(1.0, 20))
    assert np.diff(record.speed_mm_s)[1:] / OPEN_MM_PER_RAD == pytest.approx(np.full(18, (0.3 - 0.138) / J * 1e-3), rel=1e-9)


@pytest.mark.parametrize("inductance", [0.0, 8e-4])
def test_current_limit(inductance: float) -> None:
    record = simulate({"drive.current_limit_A": 4.0, "motor.inductance_H": inductance}, np.full(300, 5.0))
    assert record.current_A.max() == 4.0
    assert record.current_A.min() >= -4.0
    assert np.count_nonzero(record.current_A == 4.0) > 10


def test_current_loop_follows_with_its_time_constant() -> None:
    values = {**CURRENT_A, "drive.current_loop_s": 2e-3, "screw.csj_Nm": 10.0}
    record = simulate(values, held(0.3, 20))
    assert record.current_A == pytest.approx(3.0 * -np.expm1(-record.time_s / 2e-3), abs=1e-9)
    needed = R * record.current_A + L * (3.0 - record.current_A) / 2e-3
    assert record.voltage_V == pytest.approx(needed, abs=1e-9)


def test_current_loop_that_lacks_voltage_applies_the_bus() -> None:
    values = {**CURRENT_A, "drive.current_loop_s": 1e-4, "drive.supply_V": 5.0, "screw.csj_Nm": 10.0}
    record = simulate(values, held(1.0, 10))
    assert np.all(record.voltage_V == 5.0)
    assert record.current_A == pytest.approx(5.0 / R * -np.expm1(-R / L * record.time_s), abs=1e-9)


@pytest.mark.parametrize(("load", "speed_sign"), [(0.1, 1.0), (-0.1, 1.0), (0.1, -1.0)])
def test_efficiency_opposing_and_aiding(load: float, speed_sign: float) -> None:
    eta = 0.7
    record = simulate({**OPEN, "gearbox.efficiency": eta, "screw.load_torque_Nm": load}, held(0.5 * speed_sign, 800))
    speed = record.speed_mm_s[-1] / OPEN_MM_PER_RAD
    lost = (1.0 / eta - 1.0) * abs(load) if load * speed_sign > 0.0 else (1.0 - eta) * abs(load)
    net = KT * 12.0 * speed_sign / R - load - speed_sign * (0.138 + lost)
    assert speed == pytest.approx(net / (D + KT * KE / R), rel=1e-9)


def test_energy_balance() -> None:
    fine = {"timing.step_s": 1e-5, "control.every_steps": 100, "screw.blk_mm": 0.0, "screw.dynamic_ratio": 0.8}
    command = chirp(times_s(50_000, 1e-5), 2.0, 2.0, 6.0, 0.5)
    record = simulate(fine, command, oversample=2)
    speed = record.speed_mm_s / (5.0 / (2.0 * math.pi * 4.0))
    i = record.current_A

    def integral(power: np.ndarray) -> float:
        return float(np.sum(0.5 * (power[1:] + power[:-1])) * 1e-5)

    given_in = float(np.sum(record.voltage_V[:-1] * 0.5 * (i[1:] + i[:-1])) * 1e-5)
    lost = integral(R * i * i) + integral(D * speed * speed + 0.8 * 0.138 * np.abs(speed))
    stored = 0.5 * L * i[-1] ** 2 + 0.5 * J * speed[-1] ** 2
    assert given_in == pytest.approx(lost + stored, rel=2e-5)


def test_integrator_does_not_wind_up() -> None:
    far = {"control.ki_per_m_s": 4_000.0, "control.output_limit": 0.6}
    command = commands.step(times_s(1_200), 12.0, 0.0)
    overshoot = simulate(far, command).position_mm.max()
    assert overshoot < simulate({**far, "control.anti_windup_per_s": 0.0}, command).position_mm.max() - 1.0


def test_cascade_holds_its_speed_limit() -> None:
    values = {
        "control.structure": 1,
        "control.position_gain_per_s": 30.0,
        "control.speed_gain_s_per_m": 10.0,
        "control.speed_integral_per_m": 400.0,
        "control.speed_limit_m_s": 0.02,
    }
    record = simulate(values, commands.step(times_s(800), 20.0, 0.0))
    assert record.speed_mm_s[300] == pytest.approx(20.0, rel=0.01)


def test_control_and_record_periods() -> None:
    record = simulate({"control.every_steps": 4, "timing.record_every_steps": 2}, chirp(times_s(400), 2.0, 2.0, 2.0, 1.0))
    assert record.time_s.size == 200
    assert record.time_s[1] == 2e-3
    assert np.array_equal(record.voltage_V[0::2], record.voltage_V[1::2])


def test_delay_is_exact_for_parabolas_and_whole_steps() -> None:
    times = np.arange(40.0)
    history = 0.3 * times * times - 2.0 * times + 1.0
    for delay in (0.0, 3.0, 2.25, 0.6):
        part = build({**NOMINAL, "encoder.delay_s": delay * 1e-3}).encoder
        age = 30.0 - delay
        assert encoder.feedback_mm(part, 1e-3, history, 30) == pytest.approx(0.3 * age * age - 2.0 * age + 1.0, abs=1e-10)
    assert encoder.feedback_mm(part, 1e-3, history, 0) == pytest.approx(history[0], abs=1e-15)


def test_resolution_rounds_to_the_nearest() -> None:
    part = build({**NOMINAL, "encoder.resolution_mm": 0.01}).encoder
    for value, seen in ((0.0149, 0.01), (0.0151, 0.02), (-0.0149, -0.01), (-0.0151, -0.02)):
        assert encoder.feedback_mm(part, 1e-3, np.array([value]), 0) == pytest.approx(seen, abs=1e-15)


def test_rod_sensor_errors_reach_the_loop_when_it_looks_there() -> None:
    steady = commands.step(times_s(4_000), 10.0, 0.0)
    values = {
        "control.ki_per_m_s": 4_000.0,
        "encoder.side": 1,
        "encoder.rod_gain_error": 0.01,
        "encoder.rod_offset_mm": 0.2,
    }
    record = simulate({**values, "screw.csj_Nm": 0.0, "screw.blk_mm": 0.0}, steady)
    assert record.position_mm[-1] == pytest.approx(10.0, abs=1e-3)
    assert record.motor_position_mm[-1] == pytest.approx((10.0 - 0.2) / 1.01, abs=1e-3)


# --- accuracy ---


def test_error_of_case_a_before_the_search() -> None:
    sweep = chirp(times_s(10_000))
    healthy = simulate({}, sweep)
    case_a = simulate({"screw.csj_Nm": 0.3, "screw.blk_mm": 0.04125}, sweep)
    assert healthy.e_int_mm2s(case_a) == pytest.approx(0.674, abs=0.002)
    assert np.abs(healthy.current_A).max() == pytest.approx(7.4, abs=0.1)
    assert np.abs(healthy.voltage_V).max() / 24.0 == pytest.approx(0.74, abs=0.005)


def test_located_events_leave_no_step_size_in_the_result() -> None:
    sweep = chirp(times_s(2_500), 2.0, 0.2, 4.0, 2.5)
    values = {"screw.dynamic_ratio": 0.7}
    coarse = simulate(values, sweep, oversample=25)
    fine = simulate(values, sweep, oversample=100)
    assert np.abs(coarse.position_mm - fine.position_mm).max() < 1e-9
    assert np.abs(coarse.current_A - fine.current_A).max() < 1e-6


def digest(count: int) -> str:
    """Bits of a short record that passes through every elementary function."""
    values: dict[str, float] = {"encoder.resolution_mm": 0.001, "encoder.delay_s": 0.0015}
    for name in NAMES:
        values |= example_of(name)
    record = simulate(values, chirp(times_s(count), 2.0, 5.0, 40.0, 0.1))
    return hashlib.sha256(b"".join(getattr(record, name).tobytes() for name in record.__dataclass_fields__)).hexdigest()


def test_same_bits_without_compilation() -> None:
    program = "import sys; sys.path.insert(0, 'tests'); import test_reference; print(test_reference.digest(30))"
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    folder = Path(__file__).parents[1]
    plain = subprocess.run([sys.executable, "-c", program], env=environment, cwd=folder, capture_output=True, text=True, check=True)
    assert plain.stdout.strip() == digest(30)


# --- effects ---


@pytest.mark.parametrize("name", NAMES)
def test_effect_has_its_functions_and_an_example_in_range(name: str) -> None:
    effect = load_definitions().effect(name)
    module = module_of(name)
    assert all(callable(getattr(module, function)) for function in SITE_FUNCTIONS[effect.site])
    example = example_of(name)
    assert example[effect.size.name] != effect.size.nominal
    for key, value in example.items():
        assert load_definitions().find(key).lower <= value <= load_definitions().find(key).upper


@pytest.mark.parametrize("name", NAMES)
def test_effect_at_its_zero_is_absent_and_otherwise_acts(name: str) -> None:
    sweep = chirp(times_s(200), 2.0, 2.0, 8.0, 0.2)
    effect = load_definitions().effect(name)
    example = example_of(name)
    around = {key: value for key, value in example.items() if not key.startswith(name + ".")}
    without = simulate(around, sweep)
    at_zero = simulate({**example, effect.size.name: effect.size.nominal}, sweep)
    for channel in without.__dataclass_fields__:
        assert np.array_equal(getattr(without, channel), getattr(at_zero, channel))
    shown = simulate(example, sweep)
    # an error of the rod sensor does not reach the current of a loop that is closed over the motor
    assert max(np.abs(shown.current_A - without.current_A).max(), np.abs(shown.position_mm - without.position_mm).max()) > 1e-3


def test_stribeck_starts_at_its_rise() -> None:
    ramp = np.arange(600) * 1e-3 * 1e6
    values = {**CURRENT_A, "screw.csj_Nm": 0.1, "stribeck_friction.rise": 0.8, "stribeck_friction.speed_rad_s": 5.0}
    record = simulate(values, ramp)
    first = np.argmax(record.speed_mm_s > 0.0)
    assert KT * record.current_A[first - 1] == pytest.approx(0.18, abs=KT * 10.0 * 1e-3)


def test_stribeck_vanishes_at_speed() -> None:
    plain = simulate(OPEN, held(0.5, 800))
    risen = simulate({**OPEN, "stribeck_friction.rise": 2.0, "stribeck_friction.speed_rad_s": 5.0}, held(0.5, 800))
    assert risen.speed_mm_s[-1] == pytest.approx(plain.speed_mm_s[-1], rel=1e-9)


def test_constant_load_and_spring_shift_the_torque_at_rest() -> None:
    # with integral action the current at a standstill under way balances load and friction
    slow = commands.triangle(times_s(8_000), 2.0, 0.125)
    values = {"screw.csj_Nm": 0.02, "screw.viscous_Nm_s_per_rad": 0.0}
    plain = simulate(values, slow).current_A
    loaded = simulate({**values, "constant_load.torque_Nm": 0.05}, slow).current_A
    middle = slice(500, 1_900)
    assert np.mean(loaded[middle] - plain[middle]) * KT == pytest.approx(0.05, rel=0.01)
    sprung = simulate({**values, "spring_load.stiffness_Nm_per_mm": 0.04}, slow)
    torque = (sprung.current_A[middle] - plain[middle]) * KT
    assert np.polyfit(sprung.motor_position_mm[middle], torque, 1)[0] == pytest.approx(0.04, rel=0.02)


def test_winding_heating_is_a_larger_resistance() -> None:
    sweep = chirp(times_s(200), 2.0, 2.0, 8.0, 0.2)
    hot = simulate({"winding_heating.rise_degC": 50.0}, sweep)
    same = simulate({"motor.resistance_ohm": R * (1.0 + 0.00393 * 50.0)}, sweep)
    assert np.array_equal(hot.current_A, same.current_A)


def test_dead_time_takes_its_voltage() -> None:
    record = simulate({**OPEN, "screw.csj_Nm": 100.0, "inverter_dead_time.drop_V": 1.0}, held(0.25, 100))
    final = record.current_A[-1]
    assert R * final + final / math.hypot(final, 0.2) == pytest.approx(6.0, rel=1e-9)
    at_once = simulate({**OPEN, "screw.csj_Nm": 100.0, "inverter_dead_time.drop_V": 1.0, "motor.inductance_H": 0.0}, held(0.25, 3))
    assert at_once.current_A[0] == pytest.approx(final, rel=1e-9)


def test_presliding_stretches_by_the_logarithm_of_the_pull() -> None:
    ramp = held(1.0, 3_000) * np.linspace(0.0, 0.15, 3_000)
    record = simulate({**OPEN, "screw.csj_Nm": 0.3, "presliding.stretch_rad": 0.05}, ramp)
    pull = KT * record.current_A[-1] / 0.3
    assert 0.5 < pull < 1.0
    assert record.motor_position_mm[-1] / OPEN_MM_PER_RAD == pytest.approx(-0.05 * math.log(1.0 - pull), rel=2e-3)


def test_presliding_tends_to_sticking() -> None:
    sweep = chirp(times_s(400), 2.0, 2.0, 4.0, 0.4)
    stuck = simulate({}, sweep).motor_position_mm
    far, near = (np.abs(simulate({"presliding.stretch_rad": x}, sweep).motor_position_mm - stuck).max() for x in (4e-2, 2.5e-3))
    # a spring takes up the speed at which the shaft would have stuck: its way falls with the root of the stretch
    assert near < 0.3 * far


def test_presliding_rests_at_an_end_of_travel_until_pulled_back() -> None:
    command = np.concatenate([held(0.3, 300), held(-0.3, 300)])
    record = simulate(
        {**OPEN, "presliding.stretch_rad": 0.05, "screw.travel_mm": 0.01, "screw.lead_mm": 1.0, "gearbox.ratio": 10.0}, command
    )
    assert record.motor_position_mm[299] == pytest.approx(0.01, abs=1e-12)
    assert record.speed_mm_s[299] == 0.0
    assert record.current_A[299] == pytest.approx(0.3 * 24.0 / R, rel=1e-6)
    assert record.motor_position_mm[-1] == pytest.approx(-0.01, abs=1e-12)


def test_output_delay_moves_the_current_of_a_locked_rotor() -> None:
    values = {**OPEN, "screw.csj_Nm": 100.0}
    late = simulate({**values, "drive.output_delay_s": 2.4e-3}, held(0.25, 20))
    expected = 6.0 / R * -np.expm1(-R / L * np.maximum(late.time_s - 2.4e-3, 0.0))
    assert late.current_A == pytest.approx(expected, abs=1e-9)
    assert late.voltage_V == pytest.approx(np.full(20, 6.0))
    at_once = simulate({**values, "motor.inductance_H": 0.0, "drive.output_delay_s": 2e-3}, held(0.25, 4))
    assert at_once.current_A == pytest.approx([0.0, 0.0, 6.0 / R, 6.0 / R])


def test_asymmetric_friction_at_steady_speed() -> None:
    for sign in (1.0, -1.0):
        record = simulate({**OPEN, "screw.friction_asymmetry": 0.3}, held(sign * 0.5, 800))
        speed = sign * record.speed_mm_s[-1] / OPEN_MM_PER_RAD
        friction = NOMINAL["screw.csj_Nm"] * (1.0 + sign * 0.3)
        assert speed == pytest.approx((KT * 12.0 / R - friction) / (D + KT * KE / R), rel=1e-9)


def test_torque_limit_holds_with_a_ripple_of_the_torque_constant() -> None:
    values = {**OPEN, "screw.csj_Nm": 0.2, "motor.torque_limit_Nm": 0.19, "torque_ripple.ratio": 0.5}
    assert np.all(simulate(values, held(1.0, 100)).motor_position_mm == 0.0)


def test_inertia_change_acts_on_the_total() -> None:
    sweep = chirp(times_s(200), 2.0, 2.0, 8.0, 0.2)
    soft = {"transmission_compliance.period_s": 0.02, "transmission_compliance.mass_kg": 50.0}
    changed = simulate({**soft, "inertia_change.change": 0.2}, sweep)
    same = simulate({**soft, "screw.inertia_kgm2": J * 1.2}, sweep)
    assert np.array_equal(changed.current_A, same.current_A)


def test_compliant_rod_rings_at_its_period_and_decays() -> None:
    values = {
        "transmission_compliance.period_s": 0.05,
        "transmission_compliance.mass_kg": 2.0,
        "transmission_compliance.damping_ratio": 0.02,
        "screw.blk_mm": 0.0,
        "control.ki_per_m_s": 0.0,
    }
    record = simulate(values, commands.step(times_s(1_000), 2.0, 0.0))
    stuck = np.nonzero(np.diff(record.motor_position_mm))[0][-1] + 1
    stretch = record.position_mm[stuck:] - record.motor_position_mm[stuck]
    assert stretch.size > 300
    crossings = np.nonzero((stretch[:-1] < 0.0) & (stretch[1:] >= 0.0))[0]
    ratio = math.sqrt(1.0 - 0.02**2)
    assert np.diff(crossings).mean() * 1e-3 == pytest.approx(0.05 / ratio, rel=0.01)
    peaks = [stretch[a:b].max() for a, b in pairwise(crossings)]
    assert peaks[1] / peaks[0] == pytest.approx(math.exp(-2.0 * math.pi * 0.02 / ratio), rel=0.02)


def test_feedback_delay_adds_to_the_encoders() -> None:
    sweep = chirp(times_s(200), 2.0, 2.0, 8.0, 0.2)
    one = simulate({"feedback_delay.delay_s": 1e-3, "encoder.delay_s": 0.5e-3}, sweep)
    other = simulate({"encoder.delay_s": 1.5e-3}, sweep)
    assert np.array_equal(one.position_mm, other.position_mm)


# --- what holds for every actuator ---


@settings(max_examples=40)
@given(
    csj=st.floats(0.0, 1.5),
    blk=st.floats(0.0, 0.5),
    ratio=st.floats(0.2, 1.0),
    limit=st.floats(0.05, 1.0),
    gain=st.floats(10.0, 2_000.0),
    travel=st.floats(0.2, 5.0),
    amplitude=st.floats(-5.0, 5.0),
    side=st.integers(0, 1),
    structure=st.integers(0, 1),
)
def test_limits_hold(
    csj: float,
    blk: float,
    ratio: float,
    limit: float,
    gain: float,
    travel: float,
    amplitude: float,
    side: int,
    structure: int,
) -> None:
    values = {
        "screw.csj_Nm": csj,
        "screw.blk_mm": blk,
        "screw.dynamic_ratio": ratio,
        "control.output_limit": limit,
        "control.kp_per_m": gain,
        "control.structure": structure,
        "control.position_gain_per_s": 20.0,
        "control.speed_gain_s_per_m": 5.0,
        "screw.travel_mm": travel,
        "encoder.side": side,
    }
    command = chirp(times_s(150), amplitude, 3.0, 25.0, 0.15)
    record = simulate(values, command, oversample=25)
    assert np.abs(record.motor_position_mm - record.position_mm).max() <= 0.5 * blk + 1e-12
    assert np.abs(record.motor_position_mm).max() <= travel * (1.0 + 1e-12)
    assert np.abs(record.voltage_V).max() <= limit * 24.0 * (1.0 + 1e-15)
    # the machine is symmetric, so the opposite command makes the opposite record, bit for bit
    mirrored = simulate(values, -command, oversample=25)
    assert np.array_equal(mirrored.position_mm, -record.position_mm)
    assert np.array_equal(mirrored.current_A, -record.current_A)


def test_bad_values_are_named() -> None:
    still = np.zeros(3)
    with pytest.raises(KeyError, match="csj_Nm"):
        simulate({"screw.csj": 0.1}, still)
    with pytest.raises(ValueError, match=r"screw\.csj_Nm = -1"):
        simulate({"screw.csj_Nm": -1.0}, still)
    with pytest.raises(ValueError, match=r"screw\.csj_Nm = nan"):
        simulate({"screw.csj_Nm": math.nan}, still)
    heavy = {"transmission_compliance.period_s": 0.02, "transmission_compliance.mass_kg": 500.0, "screw.inertia_kgm2": 1e-6}
    with pytest.raises(ValueError, match="lower the mass"):
        simulate(heavy, still)
