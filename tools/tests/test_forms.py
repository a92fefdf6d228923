"""Other forms of the library's effects in the truth plant: each against a closed form, a balance of the record's own signals, or the limit in which it is known."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.truth import Sensors, forms, simulate_truth
from benchmarks.truth.climate import at_temperature
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import defaults
from reference_model import Recording, simulate
from reference_model.commands import chirp, times_s, triangle

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not HAS_NUMBA, reason="numba has no wheel here: the truth plant would take minutes per record"),
]

SHEET = defaults()
LEVEL_NM, VISCOUS = SHEET["screw.csj_Nm"], SHEET["screw.viscous_Nm_s_per_rad"]
KT, OHM = SHEET["motor.torque_constant_Nm_per_A"], SHEET["motor.resistance_ohm"]
MM_PER_RAD = SHEET["screw.lead_mm"] / (2.0 * math.pi * SHEET["gearbox.ratio"])
# The shaft is held by its friction and the voltage is proportional to the command.
HELD = {"control.ki_per_m_s": 0.0, "screw.csj_Nm": 1.4}
VOLT_PER_MM = 1e-3 * SHEET["control.kp_per_m"] * SHEET["drive.supply_V"]


def rms(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square of a difference."""
    return float(np.sqrt(np.mean((one - other) ** 2)))


def steady(values: dict[str, float], speed_rad_s: float) -> tuple[float, float]:
    """Motor torque and speed on a ramp of `speed_rad_s`, when the loop has nearly settled."""
    run = simulate_truth(values, speed_rad_s * MM_PER_RAD * times_s(3_000), step_s=2e-5)
    turned_rad = np.diff(run.motor_position_mm)[-200:] / MM_PER_RAD
    assert turned_rad == pytest.approx(1e-3 * speed_rad_s, rel=0.05)
    return KT * float(run.current_A[-200:].mean()), 1e3 * float(turned_rad.mean())


@pytest.mark.parametrize("speed_rad_s", [4.0, 15.0])
@pytest.mark.parametrize("name", ["stribeck_gauss", "stribeck_hess_soom", "stribeck_tustin"])
def test_friction_over_speed(name: str, speed_rad_s: float) -> None:
    found, speed_rad_s = steady({f"{name}.rise": 0.2, f"{name}.speed_rad_s": 8.0}, speed_rad_s)
    dry = {
        "stribeck_gauss": math.exp(-((speed_rad_s / 8.0) ** 2)),
        "stribeck_hess_soom": 64.0 / (64.0 + speed_rad_s**2),
        "stribeck_tustin": math.exp(-speed_rad_s / 8.0),
    }[name]
    film = 1.0 - dry if name == "stribeck_tustin" else 1.0
    assert found == pytest.approx(LEVEL_NM * (1.0 + 0.2 * dry) + film * VISCOUS * speed_rad_s, rel=1e-3)


def contact_Nm(run: Recording) -> np.ndarray:
    """What the contact carries, from the balance of the record: torque without inertia and grease, [rows]."""
    angle = run.motor_position_mm / MM_PER_RAD
    speed = np.gradient(angle, 1e-3)
    return np.asarray(KT * run.current_A - SHEET["screw.inertia_kgm2"] * np.gradient(speed, 1e-3) - VISCOUS * speed)


@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0])
def test_dahl_loads_and_unloads_by_its_exponent(exponent: float) -> None:
    def left(at_first: float, turn: np.ndarray) -> np.ndarray:
        """What the contact still lacks to carry all, after a turn in units of the stretch."""
        return {
            0.5: np.maximum(np.sqrt(at_first) - 0.5 * turn, 0.0) ** 2,
            1.0: at_first * np.exp(-turn),
            1.5: (at_first**-0.5 + 0.5 * turn) ** -2.0,
            2.0: 1.0 / (1.0 / at_first + turn),
        }[exponent]

    run = simulate_truth({"dahl.stretch_rad": 0.1, "dahl.exponent": exponent}, triangle(times_s(2_000), 0.7, 0.5), step_s=5e-6)
    angle, carried = run.motor_position_mm / MM_PER_RAD, contact_Nm(run) / LEVEL_NM
    turns = [20, *(20 + np.flatnonzero(np.diff(np.sign(np.diff(angle[20:])))) + 1)]
    assert angle[turns[1]] > 0.15
    assert carried[20 : turns[1]] == pytest.approx(1.0 - left(1.0, angle[20 : turns[1]] / 0.1), abs=0.01)
    # backwards the same curve, entered where the contact lacks what it carried and all
    first, last = min(itertools.pairwise(turns), key=lambda stretch: angle[stretch[1]] - angle[stretch[0]])
    assert angle[first] - angle[last] > 0.15
    back = slice(first + 3, last - 3)
    assert carried[back] == pytest.approx(left(1.0 + carried[first], (angle[first] - angle[back]) / 0.1) - 1.0, abs=0.02)


def test_dahl_of_exponent_one_is_the_reference_models() -> None:
    sweep = chirp(times_s(1_000), 2.0, 0.5, 4.0, 1.0)
    expected = simulate({"presliding.stretch_rad": 0.02}, sweep)
    without = simulate({}, sweep)
    found = simulate_truth({"dahl.stretch_rad": 0.02}, sweep, step_s=5e-6)
    assert rms(expected.current_A, without.current_A) > 1e-2
    assert rms(found.current_A, expected.current_A) < 1e-4
    assert rms(found.position_mm, expected.position_mm) < 1e-6
    # the closed form of the contact holds for any length of turn
    halves = forms.dahl_after.__wrapped__ if hasattr(forms.dahl_after, "__wrapped__") else forms.dahl_after
    other = {"dahl.stretch_rad": 0.1, "dahl.exponent": 1.5}
    kind = np.dtype([(name, np.float64) for name in other])
    v = np.array([tuple(other.values())], dtype=kind)[0]
    assert halves(v, halves(v, 0.2, 0.03), 0.04) == pytest.approx(halves(v, 0.2, 0.07), rel=1e-12)


def test_lugre_rises_towards_rest_and_stretches_before_it_slides() -> None:
    values = {"lugre.stretch_rad": 0.05, "lugre.static_rise": 0.2, "lugre.stribeck_rad_s": 6.0, "lugre.damping_ratio": 0.05}
    for asked_rad_s in (4.0, 40.0):
        found, speed_rad_s = steady(values, asked_rad_s)
        assert found == pytest.approx(LEVEL_NM * (1.0 + 0.2 * math.exp(-((speed_rad_s / 6.0) ** 2))) + VISCOUS * speed_rad_s, rel=2e-3)
    # slower than the Stribeck speed the bristles are a spring that yields: load = static * (1 - exp(-turn / (static * stretch)))
    run = simulate_truth(values, triangle(times_s(400), 0.35, 0.5), step_s=5e-6)
    angle = run.motor_position_mm / MM_PER_RAD
    loading = slice(20, int(np.argmax(np.diff(angle) * 1e3 > 0.5)))
    assert angle[loading.stop] > 0.03
    assert contact_Nm(run)[loading] / LEVEL_NM == pytest.approx(1.2 * (1.0 - np.exp(-angle[loading] / 0.06)), abs=0.015)


@pytest.mark.parametrize("form", ["sign", "tanh"])
def test_dead_time_at_rest(form: str) -> None:
    def current_A(volt: float, shape: dict[str, float]) -> np.ndarray:
        command = np.full(40, volt / VOLT_PER_MM)
        return simulate_truth({**HELD, f"dead_time_{form}.drop_V": 0.3, **shape}, command, step_s=1e-6).current_A

    time_s = 1e-3 * np.arange(40)
    shape = {"dead_time_tanh.width_A": 1e-3} if form == "tanh" else {}
    rising = 1.0 - np.exp(-time_s * OHM / SHEET["motor.inductance_H"])
    for side in (1.0, -1.0):
        assert current_A(1.2 * side, shape) == pytest.approx(side * 0.9 / OHM * rising, abs=2e-3)
    if form == "sign":
        assert np.all(current_A(0.25, shape) == 0.0)


def test_dead_time_with_a_narrow_edge_tends_to_the_hard_one() -> None:
    sweep = chirp(times_s(1_000), 2.0, 0.5, 4.0, 1.0)
    hard = simulate_truth({"dead_time_sign.drop_V": 0.3}, sweep)
    wide, narrow = (
        simulate_truth({"dead_time_tanh.drop_V": 0.3, "dead_time_tanh.width_A": width}, sweep, step_s=5e-6) for width in (0.2, 0.02)
    )
    effect = rms(hard.current_A, simulate_truth({}, sweep).current_A)
    assert rms(narrow.current_A, hard.current_A) < 0.1 * effect
    assert rms(narrow.current_A, hard.current_A) < 0.3 * rms(wide.current_A, hard.current_A)
    with pytest.raises(ValueError, match="without inductance"):
        simulate_truth({"dead_time_sign.drop_V": 0.3, "motor.inductance_H": 0.0}, sweep)


def test_winding_warms_with_its_time_constant_to_where_loss_and_cooling_meet() -> None:
    volt = 1.3
    command = np.full(3_000, volt / VOLT_PER_MM)
    hot = simulate_truth({**HELD, "winding_warming.rise_degC_per_W": 40.0, "winding_warming.time_s": 0.3}, command, step_s=5e-5)
    # (1 + a T) T = Rth V^2 / R
    a = forms.COPPER_PER_DEGC
    last_degC = (-1.0 + math.sqrt(1.0 + 4.0 * a * 40.0 * volt**2 / OHM)) / (2.0 * a)
    assert last_degC > 40.0
    assert hot.current_A[-1] == pytest.approx(volt / (OHM * (1.0 + a * last_degC)), rel=1e-4)
    slight = simulate_truth({**HELD, "winding_warming.rise_degC_per_W": 1.0, "winding_warming.time_s": 0.3}, command, step_s=5e-5)
    warmer_degC = (volt / (OHM * slight.current_A[50:]) - 1.0) / a
    expected = volt**2 / OHM * (1.0 - np.exp(-1e-3 * np.arange(50, 3_000) / 0.3))
    assert warmer_degC == pytest.approx(expected, abs=0.02)


def test_two_thermal_masses_are_one_where_the_housing_has_no_share() -> None:
    sweep = chirp(times_s(1_000), 2.0, 0.5, 4.0, 1.0)
    one = simulate_truth({"winding_warming.rise_degC_per_W": 20.0, "winding_warming.time_s": 0.4}, sweep)
    two = {"winding_and_housing.degC_per_W": 20.0, "winding_and_housing.time_s": 0.4}
    alone = simulate_truth({**two, "winding_and_housing.housing_share": 0.0}, sweep)
    late = simulate_truth({**two, "winding_and_housing.housing_share": 0.5}, sweep)
    effect = rms(one.current_A, simulate_truth({}, sweep).current_A)
    assert rms(alone.current_A, one.current_A) < 1e-3 * effect
    assert rms(late.current_A, one.current_A) > 0.2 * effect


def test_friction_fades_to_its_share_and_leaves_the_drag() -> None:
    sweep = chirp(times_s(2_000), 2.0, 0.5, 4.0, 2.0)
    without = simulate_truth({}, sweep)
    faded = simulate_truth({"friction_fade.share": 0.2, "friction_fade.time_s": 0.01}, sweep)
    less = simulate_truth({"screw.csj_Nm": 0.8 * 0.138}, sweep)
    assert rms(faded.current_A, less.current_A) < 0.1 * rms(faded.current_A, without.current_A)


def test_elastic_stop_gives_way_by_the_seals_force() -> None:
    values = {"elastic_stop.compliance_mm_per_N": 2e-4, "elastic_stop.seal_share": 0.1}
    seal_N = 0.1 * LEVEL_NM / (1e-3 * MM_PER_RAD)
    run = simulate_truth(values, 20.0 * MM_PER_RAD * times_s(2_000), step_s=1e-5)
    gap = run.motor_position_mm[-300:] - run.position_mm[-300:]
    assert gap == pytest.approx(0.5 * SHEET["screw.blk_mm"] + 2e-4 * seal_N, rel=1e-3)
    assert KT * run.current_A[-300:].mean() == pytest.approx(LEVEL_NM + 20.0 * VISCOUS, rel=1e-3)


def test_elastic_stop_tends_to_the_rigid_play() -> None:
    sweep = chirp(times_s(1_000), 2.0, 0.5, 4.0, 1.0)
    rigid = simulate_truth({}, sweep)
    far, near = (
        rms(
            simulate_truth(
                {"elastic_stop.compliance_mm_per_N": compliance, "elastic_stop.mass_kg": 1.0, "elastic_stop.seal_share": 0.02},
                sweep,
                step_s=5e-6,
            ).position_mm,
            rigid.position_mm,
        )
        for compliance in (4e-4, 4e-5)
    )
    assert far > 2e-3
    assert near < 0.25 * far


@pytest.mark.parametrize("name", list(forms.DEFAULTS))
def test_a_form_at_its_zero_is_absent_bit_for_bit(name: str) -> None:
    sweep = chirp(times_s(300), 2.0, 1.0, 4.0, 0.3)
    size = f"{name}.{next(iter(forms.DEFAULTS[name]))}"
    still, zero = simulate_truth({}, sweep), simulate_truth({size: 0.0}, sweep)
    shown = simulate_truth({size: {"winding_and_housing": 5.0, "elastic_stop": 1e-4}.get(name, 0.05)}, sweep)
    for channel in ("position_mm", "motor_position_mm", "current_A", "voltage_V"):
        assert np.array_equal(getattr(still, channel), getattr(zero, channel))
    assert rms(shown.current_A, still.current_A) > 1e-5
    with pytest.raises(KeyError, match=f"{name}.nothing"):
        simulate_truth({f"{name}.nothing": 1.0}, sweep)


def test_the_motors_own_voltage() -> None:
    sweep = chirp(times_s(1_000), 2.0, 0.5, 4.0, 1.0)

    def both(values: dict[str, float]) -> tuple[Recording, Recording]:
        return simulate_truth(values, sweep), simulate_truth(values, sweep, at_terminals=True)

    asked, own = both({})
    assert own.voltage_V == pytest.approx(asked.voltage_V, abs=1e-9)
    assert np.array_equal(own.current_A, asked.current_A)
    asked, own = both({"dead_time_tanh.drop_V": 0.4, "dead_time_tanh.width_A": 0.1})
    assert own.voltage_V == pytest.approx(asked.voltage_V - 0.4 * np.tanh(asked.current_A / 0.1), abs=1e-9)
    asked, own = both({"source_resistance.resistance_ohm": 0.2})
    share = asked.voltage_V / SHEET["drive.supply_V"]
    assert own.voltage_V == pytest.approx(asked.voltage_V - 0.2 * np.abs(asked.current_A) * share, abs=1e-9)
    asked, own = both({"actuation_delay.delay_s": 1e-3})
    assert own.voltage_V[1:] == pytest.approx(asked.voltage_V[:-1], abs=1e-9)
    asked, own = both({"current_limit.limit_A": 2.5})
    held = np.abs(asked.current_A) == 2.5
    inside = held & np.roll(held, 1) & np.roll(held, -1)
    back = SHEET["motor.back_emf_V_s_per_rad"] / MM_PER_RAD * np.gradient(asked.motor_position_mm, 1e-3)
    assert inside.sum() > 50
    assert np.abs(own.voltage_V - OHM * asked.current_A - back)[inside].max() < 0.05
    assert np.abs(asked.voltage_V - own.voltage_V)[inside].max() > 0.5
    # behind a hard edge the winding of a resting motor without current sees nothing
    resting = simulate_truth({**HELD, "dead_time_sign.drop_V": 0.3}, np.full(20, 0.25 / VOLT_PER_MM), at_terminals=True)
    assert resting.voltage_V == pytest.approx(0.0, abs=1e-12)


def test_coloured_noise_keeps_its_size_and_has_its_corner() -> None:
    still = np.zeros(60_000)
    white = Sensors(position_noise_mm=0.005, motor_position_noise_mm=0.005, current_noise_A=0.03)
    run = simulate_truth({}, still, sensors=replace(white, position_corner_hz=20.0), step_s=1e-3, seed=5)
    alone = simulate_truth({}, still, sensors=white, step_s=1e-3, seed=5)
    assert np.array_equal(run.current_A, alone.current_A)
    for noise in (run.position_mm, run.motor_position_mm):
        assert noise.std() == pytest.approx(0.005, rel=0.05)
        for rows in (1, 5, 10):
            kept = np.corrcoef(noise[rows:], noise[:-rows])[0, 1]
            assert kept == pytest.approx(math.exp(-2.0 * math.pi * 20.0 * 1e-3 * rows), abs=0.03)
        assert np.std([simulate_truth({}, still[:1], sensors=replace(white, position_corner_hz=20.0), seed=k).position_mm[0] for k in range(400)]) == pytest.approx(0.005, rel=0.12)  # fmt: skip


def test_temperature_moves_what_it_should() -> None:
    values = {"motor.resistance_ohm": 2.0, "screw.viscous_Nm_s_per_rad": 1e-4, "screw.csj_Nm": 0.1, "screw.blk_mm": 0.03}
    assert at_temperature(values, 0.0) == values
    warm = at_temperature(values, 8.0)
    assert warm["motor.resistance_ohm"] == pytest.approx(2.0628800, rel=1e-7)
    assert warm["screw.blk_mm"] == 0.03
    assert at_temperature(values, math.log(2.0) / 0.03)["screw.viscous_Nm_s_per_rad"] == pytest.approx(5e-5)
    assert at_temperature(values, -20.0)["screw.csj_Nm"] == pytest.approx(0.1 * math.exp(0.1))
