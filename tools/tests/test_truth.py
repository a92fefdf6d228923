"""The truth plant: it agrees with the reference as its step shrinks, its sensors do what they say, its files are reproduced."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.truth import Sensors, effects, outside, recordings, scattered, simulate_truth
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.library.definitions import load_definitions
from reference_model import Recording, simulate
from reference_model.commands import chirp, times_s, triangle
from reference_model.effects import example_of
from reference_model.vectors.cases import CASES, Case
from reference_model.vectors.records import samples_of

pytestmark = [
    pytest.mark.release,
    pytest.mark.skipif(not HAS_NUMBA, reason="numba has no wheel here: the truth plant would take minutes per record"),
]

SHIPPED = Path(__file__).parents[2] / "recordings"
CASE_A = {"screw.csj_Nm": 0.3, "screw.blk_mm": 0.04125}
NAMES = [effect.name for effect in load_definitions().effects if hasattr(effects, effect.name)]
# Written as another form of the same physics: they agree to this share of what the effect does to the record. Behind a play the reference begins to slide up to one of its steps late.
VARIANTS = {"inverter_dead_time": 0.06, "presliding": 0.01, "concave_viscous": 0.001, "elastic_backlash": 0.001}


def rms(one: Recording, other: Recording, channel: str) -> float:
    """Root mean square of the difference of a channel."""
    return float(np.sqrt(np.mean((getattr(one, channel) - getattr(other, channel)) ** 2)))


def test_error_against_the_reference_falls_with_the_square_of_the_step() -> None:
    sweep = chirp(times_s(3_000), 2.0, 0.2, 4.0, 3.0)
    reference = simulate(CASE_A, sweep)
    errors = [rms(simulate_truth(CASE_A, sweep, step_s=step), reference, "position_mm") for step in (4e-5, 2e-5, 1e-5)]
    assert errors[2] < 2e-8
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


def test_lugre_tends_to_coulomb_as_the_shaft_stiffens() -> None:
    sweep = chirp(times_s(2_000), 2.0, 0.5, 4.0, 2.0)
    reference = simulate(CASE_A, sweep)
    far, near = (
        rms(simulate_truth(CASE_A, sweep, friction="lugre", presliding_rad=yielding, step_s=1e-6), reference, "motor_position_mm")
        for yielding in (8e-4, 2e-4)
    )
    assert near < 1e-3
    assert near < 0.5 * far


def test_lugre_yields_before_it_slides() -> None:
    values = {"control.ki_per_m_s": 0.0, "screw.csj_Nm": 0.3}
    command = triangle(times_s(500), 0.1, 2.0)
    stiff = simulate_truth(values, command)
    soft = simulate_truth(values, command, friction="lugre", presliding_rad=1e-2, step_s=2e-6)
    assert np.all(stiff.motor_position_mm == 0.0)
    moved = np.abs(soft.motor_position_mm).max() / (5.0 / (8.0 * np.pi))
    # the torque stays below the level, so the bristles take less than their yield
    assert 1e-4 < moved < 1e-2


@pytest.mark.parametrize("name", NAMES)
def test_hides_effects_as_the_reference_has_them(name: str) -> None:
    sweep = chirp(times_s(800), 2.0, 1.0, 4.0, 0.8)
    hidden = simulate_truth(example_of(name), sweep, step_s=4e-6)
    expected = simulate(example_of(name), sweep)
    without = simulate_truth({}, sweep)
    seen = {channel: rms(hidden, without, channel) for channel in ("position_mm", "current_A")}
    assert max(seen.values()) > 1e-3
    if name in VARIANTS:
        for channel, size in seen.items():
            # neither the same formula nor another effect
            assert 1e-7 < rms(hidden, expected, channel) < VARIANTS[name] * size
        return
    assert rms(hidden, expected, "position_mm") < 2e-6
    assert rms(hidden, expected, "motor_position_mm") < 1e-7
    assert rms(hidden, expected, "current_A") < 2e-5


@pytest.mark.parametrize("case", [case for case in CASES if not case.name.startswith("effect_")], ids=lambda case: case.name)
def test_agrees_in_every_block(case: Case) -> None:
    command = samples_of(case)[:1_000]
    truth = simulate_truth(case.values, command, start_mm=case.start_mm, step_s=2e-6)
    reference = simulate(case.values, command, case.start_mm)
    scale = max(1.0, float(np.abs(reference.motor_position_mm).max()))
    assert np.abs(truth.position_mm - reference.position_mm).max() < 2e-8 * scale
    assert np.abs(truth.motor_position_mm - reference.motor_position_mm).max() < 2e-8 * scale
    assert rms(truth, reference, "current_A") < 2e-5
    assert rms(truth, reference, "voltage_V") < 2e-5
    assert rms(truth, reference, "speed_mm_s") < 2e-4


def test_what_it_cannot_hide_it_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    # learned tables stand for what has no name, so no machine hides one
    missing = {effect.name for effect in load_definitions().effects if not effect.is_learned} - {*NAMES}
    assert not missing, (
        f"{sorted(missing)}: the truth plant cannot hide it: write a function of that name in truth/effects.py, and its term where it acts"
    )
    with pytest.raises(ValueError, match="learned_torque: no machine has a learned table"):
        simulate_truth(example_of("learned_torque"), np.zeros(3))
    monkeypatch.delattr(effects, "spring_load")
    with pytest.raises(ValueError, match="spring_load: the truth plant cannot hide it yet"):
        simulate_truth(example_of("spring_load"), np.zeros(3))
    simulate_truth({}, np.zeros(3))


@pytest.mark.parametrize("name", list(outside.DEFAULTS))
def test_effects_outside_the_library_show_in_proportion_and_vanish_at_zero(name: str) -> None:
    size = f"{name}.{next(iter(outside.DEFAULTS[name]))}"
    small = {
        "broken_ball": 0.01,
        "encoder_eccentricity": 0.01,
        "lead_error": 0.002,
        "bus_hum": 0.02,
        "speed_hump": 0.005,
        "command_dead_band": 0.004,
        "magnetic_lag": 0.05,
    }
    sweep = chirp(times_s(2_000), 2.0, 0.5, 4.0, 2.0)
    step = small.get(name, 0.5)
    without = simulate_truth({}, sweep, step_s=5e-5)
    once, twice = (simulate_truth({size: factor * step}, sweep, step_s=5e-5) for factor in (1.0, 2.0))
    assert np.array_equal(simulate_truth({size: 0.0}, sweep, step_s=5e-5).current_A, without.current_A)
    channel = "position_mm" if name == "lead_error" else "current_A"
    assert rms(once, without, channel) > 1e-4
    assert rms(twice, without, channel) == pytest.approx(2.0 * rms(once, without, channel), rel=0.25)


def test_effects_outside_the_library_do_what_they_say() -> None:
    sweep = chirp(times_s(2_000), 2.0, 0.5, 4.0, 2.0)
    without = simulate_truth({}, sweep)
    wobbling = simulate_truth({"lead_error.amplitude_mm": 0.005, "lead_error.phase_rad": 0.3}, sweep)
    expected = 0.005 * np.sin(2.0 * np.pi * without.position_mm / 5.0 + 0.3)
    assert wobbling.position_mm - without.position_mm == pytest.approx(expected, abs=1e-12)
    assert np.array_equal(wobbling.current_A, without.current_A)
    # one period per turn is too fast for the loop: the reading shows the error, the rod hardly follows it
    eccentric = simulate_truth({"encoder_eccentricity.error_rad": 0.02}, sweep)
    amplitude = 0.02 * 5.0 / (8.0 * np.pi)
    assert rms(eccentric, without, "motor_position_mm") == pytest.approx(amplitude / np.sqrt(2.0), rel=0.1)
    assert rms(eccentric, without, "position_mm") < 0.5 * amplitude
    leaking = simulate_truth({"integrator_leak.rate_per_s": 50.0}, sweep)
    assert rms(leaking, simulate_truth({"control.ki_per_m_s": 0.0}, sweep), "voltage_V") < 0.5 * rms(
        without, simulate_truth({"control.ki_per_m_s": 0.0}, sweep), "voltage_V"
    )
    still = simulate_truth({"command_dead_band.width_mm": 5.0}, sweep)
    assert np.all(still.motor_position_mm == 0.0)
    with pytest.raises(KeyError, match=r"bus_hum\.ripple"):
        simulate_truth({"bus_hum.ripple": 0.1}, sweep)


def test_the_voltage_has_noise_of_its_own() -> None:
    sweep = chirp(times_s(2_000), 2.0, 0.5, 2.0, 2.0)
    noisy = simulate_truth({}, sweep, sensors=Sensors(voltage_noise_V=0.01, voltage_resolution_V=0.02))
    clean = simulate_truth({}, sweep)
    assert np.std(noisy.voltage_V - clean.voltage_V) == pytest.approx(np.hypot(0.01, 0.02 / np.sqrt(12.0)), rel=0.1)
    assert np.array_equal(noisy.current_A, clean.current_A)


def test_sensors() -> None:
    sweep = chirp(times_s(4_000), 2.0, 0.5, 2.0, 4.0)
    clean = simulate_truth({}, sweep)
    noisy = simulate_truth({}, sweep, sensors=Sensors(position_noise_mm=0.005, current_noise_A=0.03), seed=7)
    error = noisy.position_mm - clean.position_mm
    assert error.std() == pytest.approx(0.005, rel=0.05)
    assert abs(error.mean()) < 0.005 * 4.0 / np.sqrt(4_000)
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 4.0 / np.sqrt(4_000)
    assert (noisy.current_A - clean.current_A).std() == pytest.approx(0.03, rel=0.05)
    assert np.array_equal(noisy.motor_position_mm, clean.motor_position_mm)

    coarse = simulate_truth({}, sweep, sensors=Sensors(position_resolution_mm=0.01, current_gain_error=0.02, current_offset_A=0.1))
    assert np.abs(coarse.position_mm / 0.01 - np.round(coarse.position_mm / 0.01)).max() < 1e-9
    assert np.abs(coarse.position_mm - clean.position_mm).max() <= 0.005 + 1e-12
    assert coarse.current_A == pytest.approx(1.02 * clean.current_A + 0.1, abs=1e-12)


def test_noise_in_the_loop_moves_the_machine() -> None:
    sweep = chirp(times_s(500), 2.0, 0.5, 2.0, 0.5)
    moved = simulate_truth({}, sweep, sensors=Sensors(feedback_noise_mm=0.01), seed=3)
    assert rms(moved, simulate_truth({}, sweep), "voltage_V") == pytest.approx(0.01e-3 * 400.0 * 24.0, rel=0.3)


def test_seed_decides() -> None:
    sweep = chirp(times_s(300), 2.0, 0.5, 2.0, 0.5)
    sensors = Sensors(position_noise_mm=0.005)
    one, same, other = (simulate_truth({}, sweep, sensors=sensors, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(one.position_mm, same.position_mm)
    assert not np.array_equal(one.position_mm, other.position_mm)


def test_scatter() -> None:
    spread = {"screw.csj_Nm": 0.02, "motor.resistance_ohm": 0.01}
    days = [scattered({}, spread, seed) for seed in range(300)]
    assert days[0] == scattered({}, spread, 0)
    friction = np.array([day["screw.csj_Nm"] for day in days])
    assert friction.mean() == pytest.approx(0.138, rel=0.005)
    assert friction.std() / 0.138 == pytest.approx(0.02, rel=0.15)
    assert len({day["gearbox.ratio"] for day in days}) == 1


def test_bad_requests_are_named() -> None:
    with pytest.raises(ValueError, match="coulomb, lugre"):
        simulate_truth({}, np.zeros(3), friction="dahl")
    with pytest.raises(KeyError, match="csj_Nm"):
        simulate_truth({"screw.csj": 1.0}, np.zeros(3))


def test_shipped_recordings_are_reproduced(tmp_path: Path) -> None:
    for made in recordings.write(tmp_path):
        shipped = SHIPPED / made.name
        assert made.read_bytes() == shipped.read_bytes(), f"{made.name}: run python -m benchmarks.truth.recordings recordings"
        assert shipped.stat().st_size < 1 << 20
    assert {path.name for path in tmp_path.iterdir()} == {f"{shipped.name}.csv" for shipped in recordings.SHIPPED}


def test_shipped_recordings_show_what_they_say() -> None:
    def read(name: str) -> np.ndarray:
        lines = [line for line in (SHIPPED / f"{name}.csv").read_text().splitlines() if not line.startswith("#")]
        assert lines[0] == "time_s,command_mm,position_mm,motor_position_mm,current_A,voltage_V"
        return np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])

    healthy, case_a, noisy = read("healthy"), read("case_a"), read("case_a_noisy")
    assert healthy.shape == (10_000, 6)
    assert np.allclose(np.diff(healthy[:, 0]), 1e-3, atol=1e-9)
    assert np.sum((healthy[:, 2] - case_a[:, 2]) ** 2) * 1e-3 == pytest.approx(0.674, abs=0.002)
    assert (noisy - case_a)[:, [2, 3, 4]].std(axis=0) == pytest.approx([0.005, 0.005, 0.03], rel=0.05)
    assert np.array_equal(noisy[:, 5], case_a[:, 5])


def test_unwritten_folder_is_named(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("sys.argv", ["recordings", str(tmp_path / "absent")])
    assert recordings.main() == 1
    assert "not a folder" in capsys.readouterr().err
