"""Naming by the mechanical balance: hidden effects on a simulated stiff axis, and the measured axis EMPS from its published model to what its laps repeat."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.truth.plant import Sensors, simulate_truth
from ema_tools.balances.mechanical import mechanical, quiet_smoother
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.data.emps import emps_actuator
from ema_tools.data.records import Record, read_record, simulated
from ema_tools.library.registry import named
from ema_tools.results.codec import to_json
from ema_tools.select.balance_setting import Setting
from ema_tools.select.force_balance import EFFECTS_MAX, improve_by_forces
from ema_tools.select.force_judge import REPEATED_MOTION, SIZE_IN_STD
from ema_tools.select.force_steps import ForceSteps
from ema_tools.select.torque_patterns import pattern_of, patterns_of
from ema_tools.words.answers.balance import forces_of
from shared_results import shared_result
from support import chirp_record, emps_path, run_ema

GAINS = {"gtau": 35.0, "kp": 160.0, "kv": 240.0}
NOISE = Sensors(position_noise_mm=5e-5)
HIDDEN = {"coulomb_asymmetry.asymmetry": 0.1, "pitch_ripple.ratio": 0.1, "pitch_ripple.phase_rad": 0.7}


def laps_mm(count: int = 4, speeds_mm_s: tuple[float, ...] = (42.0, 84.0, 126.0), period_s: float = 5.0) -> np.ndarray:
    """There and back in plateaus of speed, smoothed, from rest; one value per millisecond."""
    half = round(500.0 * period_s)
    forward = np.repeat(speeds_mm_s, math.ceil(half / len(speeds_mm_s)))[:half]
    window = np.hanning(201)
    speed = np.convolve(np.tile(np.concatenate([forward, -forward]), count + 1), window / window.sum(), "same")[: count * 2 * half]
    speed[:150] *= np.linspace(0.0, 1.0, 150) ** 2
    return 1e-3 * np.concatenate([[0.0], np.cumsum(speed)[:-1]])


def axis_record(hidden: dict[str, float], seed: int = 1) -> tuple[Actuator, Record]:
    """A stiff axis as it is known, and four laps of it as it is."""
    actuator = emps_actuator(GAINS, 1e-3, "axis")
    run = simulate_truth({**actuator.values, **hidden}, 1.0 + laps_mm(), start_mm=1.0, step_s=5e-5, sensors=NOISE, seed=seed)
    return actuator, Record(1e-3, command_mm=run.command_mm, position_mm=run.position_mm, voltage_V=run.voltage_V, file="axis.csv")


@pytest.fixture(scope="module")
@shared_result
def hidden() -> tuple[Actuator, Record, ForceSteps]:
    actuator, record = axis_record(HIDDEN)
    return actuator, record, improve_by_forces(actuator, (record,))


@pytest.mark.slow
def test_hidden_effects_are_named_with_their_sizes(hidden: tuple[Actuator, Record, ForceSteps]) -> None:
    actuator, _, found = hidden
    assert [step.effect for step in found.steps] == ["constant_load", "pitch_ripple"]
    # While the axis moves, friction that differs by direction is a constant torque: the class is declared.
    assert "coulomb_asymmetry" in found.steps[0].alike
    last = found.steps[-1]
    torque = HIDDEN["coulomb_asymmetry.asymmetry"] * actuator["screw.csj_Nm"]
    for name, true in (
        ("constant_load.torque_Nm", torque),
        ("pitch_ripple.ratio", HIDDEN["pitch_ripple.ratio"]),
        ("pitch_ripple.phase_rad", HIDDEN["pitch_ripple.phase_rad"]),
    ):
        assert last.values[name] == pytest.approx(true, abs=max(4.0 * last.std[name], 0.02 * abs(true))), name
        assert last.std[name] < 0.1 * abs(true)
    assert found.given.holdout > 4.0
    assert last.errors.holdout < 0.3
    assert max(last.errors.each) < 0.3


@pytest.mark.slow
def test_every_step_lowers_the_error_of_laps_held_out(hidden: tuple[Actuator, Record, ForceSteps]) -> None:
    _, _, found = hidden
    before = found.refitted
    for step in found.steps:
        assert step.errors.training < before.training
        assert step.errors.holdout < before.holdout
        assert all(after < earlier for earlier, after in zip(before.each, step.errors.each, strict=True))
        before = step.errors


@pytest.mark.slow
def test_decoys_are_refused_with_a_reason(hidden: tuple[Actuator, Record, ForceSteps]) -> None:
    _, _, found = hidden
    reasons = {refusal.effect: refusal.reason for refusal in found.refused}
    taken = {step.effect for step in found.steps}
    offered = set(reasons) | taken
    assert {
        "stribeck_friction",
        "load_dependent_friction",
        "concave_viscous",
        "cogging_torque",
        "jam_spot",
        "presliding",
        "actuation_delay",
    } <= set(reasons)
    assert offered == set(named())
    assert all(reasons.values())
    assert "takes the same torque up" in reasons["coulomb_asymmetry"]
    assert "takes the same torque up" in reasons["inertia_change"]
    assert "only ratios" in reasons["magnet_weakening"]
    assert "does not show" in reasons["supply_sag"]
    assert "by simulation alone" in reasons["load_dependent_stribeck"]


@pytest.mark.slow
def test_friction_that_rises_as_the_machine_runs_is_no_warming_grease() -> None:
    for fall, named_so in ((0.1, True), (-0.1, False)):
        actuator, record = axis_record({"grease_warming.fall": fall, "grease_warming.time_s": 5.0})
        found = improve_by_forces(actuator, (record,))
        assert ("grease_warming" in [step.effect for step in found.steps]) is named_so, fall


@pytest.mark.slow
def test_the_new_actuator_closes_the_balance(hidden: tuple[Actuator, Record, ForceSteps]) -> None:
    actuator, record, found = hidden
    assert set(found.actuator.active_effects) == {"constant_load", "pitch_ripple"}
    assert mechanical(found.actuator, record).relative_percent < 0.2 * mechanical(actuator, record).relative_percent

    def error(model: Actuator) -> float:
        return float(np.linalg.norm(record.recorded("voltage_V") - simulated(model, record).voltage_V))

    assert error(found.actuator) < 0.4 * error(actuator)


@pytest.mark.slow
def test_healthy_axis_is_left_alone() -> None:
    actuator, record = axis_record({})
    found = improve_by_forces(actuator, (record,))
    assert found.steps == ()
    assert found.actuator.active_effects == ()
    assert found.refitted.holdout < 0.2


@pytest.mark.slow
def test_several_effects_without_the_one_that_they_made_needless() -> None:
    true = {
        "cogging_torque.amplitude_Nm": 5e-4,
        "cogging_torque.periods": 2.0,
        "cogging_torque.phase_rad": 1.0,
        "spring_load.stiffness_Nm_per_mm": 4e-6,
        "load_dependent_friction.ratio": 0.05,
    }
    actuator, record = axis_record(true)
    shares: list[float] = []
    found = improve_by_forces(actuator, (record,), progress=lambda share, _text: shares.append(share))
    assert set(found.actuator.active_effects) == {"cogging_torque", "spring_load", "load_dependent_friction"}
    for name, value in true.items():
        # an effect that reads the drive reads what the base values ask of it, without the other effects
        assert found.actuator[name] == pytest.approx(value, rel=0.06), name
    assert found.steps[-1].errors.holdout < 0.2
    assert shares[-1] == 1.0
    assert all(0.0 <= share <= 1.0 for share in shares)


@pytest.mark.parametrize("changes", [{"pitch_ripple.ratio": 0.2, "pitch_ripple.phase_rad": 0.6}, {"torque_ripple.ratio": 0.1, "torque_ripple.periods": 6.0, "torque_ripple.phase_rad": -1.1},
                                     {"cogging_torque.amplitude_Nm": 0.02, "cogging_torque.phase_rad": 2.0}, {"stribeck_friction.rise": 0.4, "stribeck_friction.shape": 1.5},
                                     {"jam_spot.amplitude_Nm": 0.05, "jam_spot.place_mm": 0.3}, {"quadratic_viscous.drag_Nm_s2_per_rad2": 1e-6}, {"viscous_asymmetry.asymmetry": 0.4}])  # fmt: skip
def test_patterns_are_what_the_balance_makes_of_the_effects(changes: dict[str, float]) -> None:
    """The torque that a pattern stands for is that of the library's own equation, sizes and phases included."""
    actuator = reference_actuator()
    record = chirp_record(actuator, "chirp:duration_s=3")
    smoother = quiet_smoother(actuator, record)
    setting = Setting.of(actuator, (record,), (smoother,))
    effect = next(iter(changes)).split(".")[0]
    true = actuator.changed(changes)
    shape = {name: true[name] for name in patterns_of(setting, effect)[0].shape}
    pattern = pattern_of(setting, effect, shape)
    expected = setting.with_actuator(true).required_Nm() - setting.required_Nm()
    columns = pattern.columns
    coefficients = np.linalg.lstsq(columns, expected, rcond=None)[0]
    moving = ~setting.pieces[0].model.resting
    assert (columns @ coefficients)[moving] == pytest.approx(expected[moving], abs=1e-6 * float(np.max(np.abs(expected))))
    values = pattern.values(coefficients, actuator.values)
    for name, value in changes.items():
        assert values[name] == pytest.approx(value, rel=1e-6), name


def test_record_without_torque_is_refused() -> None:
    rod = np.zeros(100)
    with pytest.raises(MissingSignal, match="current_A is not recorded"):
        improve_by_forces(reference_actuator(), (Record(1e-3, command_mm=rod, position_mm=rod),))


@pytest.fixture(scope="module")
def emps(tmp_path_factory: pytest.TempPathFactory) -> tuple[Actuator, Record, ForceSteps]:
    folder: Path = tmp_path_factory.mktemp("emps_forces")
    ran = run_ema("import", "emps", emps_path(), "-o", folder)
    assert ran.code == 0, ran.err
    actuator = read_actuator(folder / "actuator.toml")
    record = read_record(folder / "record.csv", actuator)
    return actuator, record, improve_by_forces(actuator, (record,))


@pytest.mark.slow
def test_emps_held_out_lap(emps: tuple[Actuator, Record, ForceSteps]) -> None:
    _, record, found = emps
    assert found.division.count == 4
    assert found.division.laps[0].period_rows * record.period_s == pytest.approx(6.24)
    assert found.given.training == pytest.approx(4.05, abs=0.05)
    assert found.given.holdout == pytest.approx(4.02, abs=0.05)
    errors = found.steps[-1].errors
    assert errors.holdout < 2.2
    assert max(errors.each) < 2.3
    assert 0.3 < found.floor_percent < 1.0
    # The published variant with friction by direction comes to 3.11 %.
    assert found.steps[0].effect == "viscous_asymmetry"
    assert found.steps[0].errors.training < 3.11
    assert {"viscous_asymmetry", "concave_viscous", "actuation_delay"} <= {step.effect for step in found.steps}
    assert len(found.steps) <= EFFECTS_MAX
    for step in found.steps:
        size = next(name for name in step.values if name.startswith(f"{step.effect}."))
        assert abs(step.values[size]) > SIZE_IN_STD * step.std[size], step.effect


@pytest.mark.slow
def test_emps_refuses_the_decoys(emps: tuple[Actuator, Record, ForceSteps]) -> None:
    _, _, found = emps
    reasons = {refusal.effect: refusal.reason for refusal in found.refused}
    for decoy in ("stribeck_friction", "load_dependent_friction"):
        assert reasons[decoy]
        assert decoy not in found.actuator.active_effects
    # four laps of one motion: a wave that comes back with them may be anything that does
    for texture in ("cogging_torque", "torque_ripple", "pitch_ripple", "jam_spot"):
        assert texture not in found.actuator.active_effects
    assert REPEATED_MOTION in reasons["cogging_torque"]
    result = json.loads(json.dumps(to_json(forces_of(found)), allow_nan=False))
    assert [step["added"] for step in result["steps"]] == [step.effect for step in found.steps]
    assert result["error"]["floor_percent"] == found.floor_percent


@pytest.mark.slow
def test_emps_is_better_in_the_balance_and_in_the_loop(emps: tuple[Actuator, Record, ForceSteps]) -> None:
    actuator, record, found = emps
    balance = mechanical(found.actuator, record).relative_percent
    assert balance == pytest.approx(found.steps[-1].errors.training, abs=0.1)
    assert balance < 0.55 * mechanical(actuator, record).relative_percent

    def error(model: Actuator, name: str) -> float:
        # the record begins in motion, the model at rest
        return float(np.linalg.norm((record.recorded(name) - getattr(simulated(model, record), name))[50:-50]))

    # a tenth of it is a wave that one motion does not confirm
    assert error(found.actuator, "voltage_V") < 0.65 * error(actuator, "voltage_V")
    assert error(found.actuator, "position_mm") < 0.65 * error(actuator, "position_mm")
