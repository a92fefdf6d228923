"""Machines whose controller nobody knows: several records of motion and drive alone, of a plant that shares nothing with the module."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.machines import plants
from benchmarks.machines.observer import observed
from benchmarks.machines.plants import EFFECTS, Machine, records
from benchmarks.machines.trials import HEALTHY, MachineTrial, actuator_of, perform, plan, right, wrong
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.base.errors import InputError
from ema_tools.compare.motion_validity import judge_motion
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.motion_records import MotionRecord, of_controlled, write_motion_record
from ema_tools.fit.division import divided
from ema_tools.select.balance_bench import Bench
from ema_tools.select.balance_setting import Setting
from ema_tools.select.few_samples import too_few
from ema_tools.select.force_balance import SAME_SWING, improve_by_forces
from ema_tools.select.torque_patterns import NO_SCREW, NOT_PLACED, patterns_of
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer
from ema_tools.tasks.method import chosen, diagnosed
from ema_tools.words.answers.steps import forward
from ema_tools.words.sentences.balance import forward_sentence, sentence
from ema_tools.words.sentences.machine_units import units_of
from support import chirp_record, run_ema

quick = pytest.mark.skipif(not HAS_NUMBA, reason="the plant takes minutes a record without Numba")


@pytest.mark.slow
@quick
@pytest.mark.parametrize(
    ("kind", "command", "effect"),
    [
        ("bare motor", "sweeps", "cogging_torque"),
        pytest.param("ball screw", "pick and place", "spring_load", marks=pytest.mark.release),
        pytest.param("bare motor", "start and stop", "stribeck_friction", marks=pytest.mark.release),
        pytest.param("belt", "sweeps", "quadratic_viscous", marks=pytest.mark.release),
        pytest.param("joint with an arm", "sweeps", "constant_load", marks=pytest.mark.slow),
        pytest.param("linear motor", "pick and place", "viscous_asymmetry", marks=pytest.mark.release),
        pytest.param("lead screw", "steady speeds", "constant_load", marks=pytest.mark.slow),
    ],
)
def test_the_hidden_effect_is_named_without_a_controller(kind: str, command: str, effect: str) -> None:
    row = perform(MachineTrial(kind, 0, command, effect, "medium"))
    assert right(row) and not wrong(row), row
    assert row["verdict"] == "missing" and row["error"][1] < 0.5 * row["error"][0]


@pytest.mark.slow
@quick
@pytest.mark.parametrize("command", ["sweeps", pytest.param("steady speeds", marks=pytest.mark.slow)])
def test_a_healthy_machine_is_accused_of_nothing(command: str) -> None:
    row = perform(MachineTrial("bare motor", 0, command, HEALTHY))
    assert not wrong(row), row


@pytest.mark.slow
@quick
def test_an_effect_that_tells_every_part_better_than_a_constant_torque_comes_before_it() -> None:
    unit = Machine("lead screw", 42, {"viscous_asymmetry": EFFECTS["viscous_asymmetry"]})
    found = improve_by_forces(actuator_of(unit.kind, unit.number), plants.records_of_day(unit, "sweeps", 9))
    first = found.steps[0]
    assert first.effect == "viscous_asymmetry" and "constant_load" in first.alike
    assert found.actuator["viscous_asymmetry.asymmetry"] == pytest.approx(EFFECTS["viscous_asymmetry"], abs=0.06)


@pytest.mark.slow
@quick
def test_one_drag_is_told_where_two_changed_values_tell_what_was_held_out_worse() -> None:
    kind, number, command = "lead screw", 43, "sweeps"
    large = {"quadratic_viscous": 2.5 * EFFECTS["quadratic_viscous"]}
    healthy = [one for day in (1, 2) for one in plants.records_of_day(Machine(kind, number, {}), command, day)]
    today = plants.records_of_day(Machine(kind, number, large), command, 9)
    found = diagnosed(actuator_of(kind, number), today, healthy)
    assert isinstance(found, BalanceAnswer)
    assert [step.effect for step in found.accepted] == ["quadratic_viscous"] and not found.changed


def swept(top_rad_s: float, seed: int, rows: int = 4000) -> MotionRecord:
    """A shaft with Stribeck friction that swings, as long as `rows` of 5 ms."""
    time, random = np.arange(rows) * 5e-3, np.random.default_rng(seed)
    speed = top_rad_s * np.sin(0.9 * time + seed) * np.sin(0.13 * time)
    level = 0.03 * (1.0 + 0.5 * np.exp(-np.abs(speed) / 8.0))
    torque = 1e-4 * np.gradient(speed, 5e-3) + level * np.sign(speed) + 2e-5 * speed + random.normal(0.0, 4e-4, time.size)
    return MotionRecord(5e-3, f"run {seed}").with_columns({"motor_speed_rad_s": speed, "torque_Nm": torque})


def test_what_is_held_out_is_judged() -> None:
    answer = diagnosed(actuator_of("bare motor", 0), [swept(90.0, 1)])
    assert isinstance(answer, BalanceAnswer)
    told = f"{sentence(answer)} {forward_sentence(forward(answer.forward))}"
    assert "nan" not in told and "nothing could be held out" not in told, told


def test_a_third_of_a_second_confirms_nothing() -> None:
    with pytest.raises(InputError, match=r"run 1: \d+ samples of motion are left .* record [\d.]+ s of motion or more"):
        diagnosed(actuator_of("bare motor", 0), [swept(90.0, 1, 60)])


def servo(step_rad: float, period_s: float, seconds: float = 20.0) -> MotionRecord:
    """A geared motor that swings, its angle recorded in steps of `step_rad`, without noise; 0: as fine as numbers are."""
    time = np.arange(0.0, seconds, period_s)
    angle = 90.0 * np.sin(2.0 * np.pi * 0.5 * time) + 30.0 * np.sin(2.0 * np.pi * 0.9 * time)
    speed = np.gradient(angle, period_s)
    torque = 3e-7 * np.gradient(speed, period_s) + 1.2e-3 * np.sign(speed) + 1e-6 * speed
    seen = np.round(angle / step_rad) * step_rad if step_rad else angle
    return MotionRecord(period_s, "servo").with_columns({"motor_angle_rad": seen, "torque_Nm": torque})


def few_of(record: MotionRecord, inertia_kgm2: float = 3e-7) -> str:
    """What is answered of too few samples; empty where there are enough."""
    actuator = actuator_of("bare motor", 0).changed({"screw.inertia_kgm2": inertia_kgm2})
    return too_few(actuator, Bench(actuator, [record]))


def test_steps_that_leave_too_few_samples_are_named() -> None:
    assert few_of(servo(0.0, 0.01)) == ""
    told = few_of(servo(0.35, 0.01))
    assert re.search(
        r"because motor_angle_rad comes in steps of 0\.35 rad, 35 rad/s from row to row: slower motion looks like rest, beside which 0\.1 s are lost",
        told,
    ), told
    assert re.search(r"record motor_angle_rad in finer steps or the speed, or [\d.]+ s of motion or more", told), told


def test_steps_that_need_a_wide_filter_are_named() -> None:
    # an inertia that needs more torque by far, of which steps make noise
    assert few_of(servo(0.0, 0.002, 5.0), 3e-5) == ""
    told = few_of(servo(0.35, 0.002, 5.0), 3e-5)
    assert re.search(
        r"because motor_angle_rad comes in steps of 0\.35 rad, which needs a filter of 0\.\d+ s: record motor_angle_rad in finer steps or the speed",
        told,
    ), told


def test_rows_that_are_too_rare_are_named() -> None:
    slow = servo(0.0, 0.05, 20.0)
    told = few_of(slow)
    assert re.search(
        r"because rows every 0\.05 s need a filter of 0\.5 s: record more rows a second, or [\d.]+ s of motion or more", told
    ), told


def test_a_short_record_is_told_no_other_cause() -> None:
    told = few_of(swept(90.0, 1, 60))
    assert "left behind the filter, too few to confirm anything by others: record" in told, told


def test_a_machine_that_moves_one_way_is_said_to() -> None:
    record = swept(90.0, 1)
    speed = np.abs(record.recorded("motor_speed_rad_s")) + 1.0
    forward_only = record.with_columns({"motor_speed_rad_s": speed, "torque_Nm": 0.03 + 2e-5 * speed + 1e-4 * np.gradient(speed, 5e-3)})
    answer = diagnosed(actuator_of("bare motor", 0), [forward_only])
    assert isinstance(answer, BalanceAnswer)
    assert [one.topic for one in answer.gates[0].remarks if "one way only" in one.text] == ["coverage"]


@pytest.mark.slow
@quick
@pytest.mark.parametrize(
    ("kind", "command", "periods"),
    [
        ("belt", "start and stop", 1.0 / 3.0),
        pytest.param("joint with an arm", "start and stop", 0.2, marks=pytest.mark.release),
        pytest.param("lead screw", "pick and place", 4.37, marks=pytest.mark.slow),
    ],
)
def test_what_swings_once_per_turn_of_a_pulley_is_found(kind: str, command: str, periods: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """No whole number of periods per motor turn, and no pure sine: the plant adds a second wave of 15 %."""
    monkeypatch.setitem(plants.KINDS, kind, replace(plants.KINDS[kind], periods=periods))  # type: ignore[arg-type]
    answer = diagnosed(actuator_of(kind, 0), records(Machine(kind, 0, {"cogging_torque": 0.25}), command))
    assert isinstance(answer, BalanceAnswer)
    assert [step.effect for step in answer.accepted if step.effect != "presliding"] == ["cogging_torque"]
    # the way of a record holds some tens of turns, and its second wave pulls a little
    assert answer.actuator["cogging_torque.periods"] == pytest.approx(periods, rel=5e-3)
    assert units_of(answer.known, answer.records).swing(answer.actuator["cogging_torque.periods"]) in sentence(answer)
    assert answer.last.training < 0.3 * answer.forces.refitted.training


def test_the_plan_asks_only_for_what_records_can_show() -> None:
    trials = plan(1)
    assert len({trial.key for trial in trials}) == len(trials)
    assert {trial.effect for trial in trials} == {HEALTHY, *EFFECTS}
    assert not any(trial.effect == "spring_load" and trial.kind == "bare motor" for trial in trials)


def spinning(speed_rad_s: float, seed: int, wave_Nm: float = 0.0, start_rad: float = 0.0) -> MotionRecord:
    """A shaft of known friction that turns: 5 s, speed and torque alone."""
    random, time = np.random.default_rng(seed), np.arange(1000) * 5e-3
    speed = speed_rad_s * (1.0 + 0.02 * np.sin(3.0 * time))
    angle = start_rad + np.cumsum(speed) * 5e-3
    wave = wave_Nm * (np.sin(angle) + 0.3 * np.sin(2.0 * angle))
    torque = 0.02 * np.sign(speed) + 1e-4 * speed + wave + random.normal(0.0, 2e-4, time.size)
    return MotionRecord(5e-3, f"run {seed}").with_columns({"motor_speed_rad_s": speed, "torque_Nm": torque})


@pytest.mark.slow
def test_a_swing_once_per_turn_is_named_where_nobody_knows_where_records_begin() -> None:
    actuator = actuator_of("lead screw", 0)
    runs = [spinning(speed, seed, 2e-3, 1.7 * seed) for seed, speed in enumerate((2.0, -3.0, 5.0, -7.0, 9.0))]
    found = improve_by_forces(actuator, runs)
    (wave,) = [step for step in found.steps if "cogging_torque" in (step.effect, *step.alike)]
    assert wave.values[f"{wave.effect}.periods" if f"{wave.effect}.periods" in wave.values else "cogging_torque.periods"] == 1.0
    size = next(value for name, value in wave.values.items() if name.startswith(wave.effect) and "periods" not in name)
    assert wave.effect != "cogging_torque" or size == pytest.approx(2e-3, rel=0.05)
    # its second harmonic is no effect of its own
    reasons = {one.effect: one.reason for one in found.refused}
    assert SAME_SWING in reasons.values() or len([step for step in found.steps if "periods" in str(step.values)]) == 1


@pytest.mark.slow
def test_friction_that_falls_with_speed_gives_the_viscous_friction_back() -> None:
    """Without the effect the records put viscous friction below zero; held there, it would turn up as another effect."""
    found = improve_by_forces(actuator_of("bare motor", 0), [swept(top, seed) for seed, top in enumerate((15.0, 40.0, 90.0, 150.0))])
    (step,) = found.steps
    truth = {"stribeck_friction.rise": 0.5, "stribeck_friction.speed_rad_s": 8.0, "stribeck_friction.shape": 1.0}
    assert step.effect == "stribeck_friction"
    # three standard errors of a fit in which shape and speed are free as well
    assert all(step.values[name] == pytest.approx(value, abs=3.0 * step.std[name]) for name, value in truth.items())
    assert step.values["screw.viscous_Nm_s_per_rad"] == pytest.approx(2e-5, abs=3.0 * step.std["screw.viscous_Nm_s_per_rad"])


@pytest.mark.slow
def test_noise_alone_has_no_phase() -> None:
    found = improve_by_forces(
        actuator_of("lead screw", 0), [spinning(speed, seed) for seed, speed in enumerate((2.0, -3.0, 5.0, -7.0, 9.0))]
    )
    assert not found.steps


def test_what_acts_at_a_place_is_not_asked_of_records_without_one() -> None:
    screw, motor = actuator_of("lead screw", 0), actuator_of("bare motor", 0)
    placeless = Setting.of(screw, [spinning(5.0, 1)], [improve_smoother(screw)])
    assert patterns_of(placeless, "spring_load") == NOT_PLACED and patterns_of(placeless, "jam_spot") == NOT_PLACED
    bare = Setting.of(motor, [spinning(5.0, 1)], [improve_smoother(motor)])
    assert patterns_of(bare, "pitch_ripple") == NO_SCREW
    assert not isinstance(patterns_of(bare, "quadratic_viscous"), str)


def improve_smoother(actuator: object) -> object:
    """The filter of such a record."""
    from ema_tools.balances.mechanical import quiet_smoother

    return quiet_smoother(actuator, spinning(5.0, 1))  # type: ignore[arg-type]


def test_records_are_held_out_in_turn_and_many_by_speed() -> None:
    few = divided([spinning(speed, 1) for speed in (1.0, 2.0, 3.0)])
    assert (few.by, few.count, few.folds) == ("record", 3, 3) and [int(part[0]) for part in few.fold] == [0, 1, 2]
    many = divided([spinning(float(speed), 1) for speed in range(1, 13)])
    assert many.folds == 4 and [int(part[0]) for part in many.fold] == [0, 1, 2, 3] * 3
    apart = divided([spinning(1.0, 1)], [spinning(2.0, 1)])
    alone = divided([spinning(1.0, 1)])
    assert apart.apart and apart.folds == alone.folds + 1 and int(apart.fold[1][0]) == alone.folds
    assert alone.by == "lap" and divided([MotionRecord(5e-3).with_columns({"motor_speed_rad_s": np.arange(100.0)})]).by == "block"


def test_what_was_recorded_changes_nothing() -> None:
    """The balance of a record of a controlled machine is that of the same record read as one of any machine."""
    from ema_tools.balances.mechanical import mechanical, quiet_smoother

    actuator = reference_actuator()
    record = chirp_record(actuator, "chirp:duration_s=3")
    smoother = quiet_smoother(actuator, record)
    one, other = mechanical(actuator, record, smoother), mechanical(actuator, of_controlled(record), smoother)
    assert other.residual == pytest.approx(one.residual, abs=1e-9 * float(np.max(np.abs(one.measured))))


def test_the_method_is_chosen_and_said() -> None:
    actuator = reference_actuator()
    record = chirp_record(actuator, "chirp:duration_s=1")
    bare = spinning(5.0, 1)
    assert chosen(actuator, [record]).method == "simulation"
    assert chosen(actuator, [record, record]).method == "balance"
    assert chosen(actuator, [bare]).because == "run 1 holds no command_mm and no position_mm, without which nothing is simulated"
    with pytest.raises(InputError, match="--method simulation: 2 records"):
        chosen(actuator, [record, record], asked="simulation")
    with pytest.raises(InputError, match="--method simulation: run 1 holds no command_mm"):
        chosen(actuator, [bare], asked="simulation")
    assert chosen(actuator, [bare], [bare]).method == "balance"
    assert chosen(actuator, [record], [record]).method == "simulation"
    assert chosen(actuator, [record], [record], asked="balance").method == "balance"


@quick
@pytest.mark.slow
def test_the_command_writes_what_programs_read(tmp_path: Path) -> None:
    actuator = actuator_of("bare motor", 0)
    actuator.write(tmp_path / "machine.toml")
    names = []
    for number, record in enumerate(records(Machine("bare motor", 0, {"quadratic_viscous": 0.5}), "sweeps")):
        names.append(tmp_path / f"{number}.csv")
        write_motion_record(names[-1], record)
    ran = run_ema(
        "diagnose",
        tmp_path / "machine.toml",
        *names[:2],
        "--holdout",
        names[2],
        "--json",
        tmp_path / "d.json",
        "--fitted",
        tmp_path / "new.toml",
    )
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    assert (result["method"], result["mode"]) == ("balance", "several records")
    assert result["effects"][0]["name"] == "quadratic_viscous" and result["effects"][0]["accepted"]
    assert result["error"]["holdout_after"] < 0.5 * result["error"]["holdout_before"]
    assert result["holdout"] == ["2.csv"] and result["records"] == ["0.csv", "1.csv"]
    assert "By the balance of forces: 0.csv holds no command_mm" in ran.out.replace("\n", " ")
    again = run_ema("diagnose", tmp_path / "new.toml", *names[:2])
    assert again.code == 0 and "quadratic_viscous" not in again.out.split("Force error")[0]


@pytest.mark.slow
def test_a_folder_holds_the_record_that_is_held_out_too(tmp_path: Path) -> None:
    actuator_of("bare motor", 0).write(tmp_path / "machine.toml")
    for number in range(3):
        write_motion_record(tmp_path / f"{number}.csv", swept(90.0, number))
    ran = run_ema("diagnose", tmp_path / "machine.toml", tmp_path, "--holdout", tmp_path / "1.csv", "--json", tmp_path / "d.json")
    assert ran.code == 0, ran.err
    result = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    assert (result["holdout"], result["records"]) == (["1.csv"], ["0.csv", "2.csv"])


def steady_friction(seed: int, inertia_kgm2: float = 1e-4, level_Nm: float = 0.03, sign: float = 1.0) -> MotionRecord:
    """A shaft with nothing but inertia and dry friction that swings; `sign`: of its drive as it was recorded."""
    time, random = np.arange(4000) * 5e-3, np.random.default_rng(seed)
    speed = 90.0 * np.sin(0.9 * time + seed) * np.sin(0.13 * time)
    torque = inertia_kgm2 * np.gradient(speed, 5e-3) + level_Nm * np.sign(speed) + random.normal(0.0, 4e-4, time.size)
    return MotionRecord(5e-3, f"run {seed}").with_columns({"motor_speed_rad_s": speed, "torque_Nm": sign * torque})


def test_a_drive_of_the_wrong_sign_blocks_fitted_and_held_out() -> None:
    machine, turned = actuator_of("bare motor", 0), steady_friction(2, sign=-1.0)
    assert not [one for one in judge_motion(machine, steady_friction(2)).remarks if one.topic == "signs"]
    for fitted, held_out in (([turned], None), ([steady_friction(0), steady_friction(1)], turned)):
        with pytest.raises(InputError, match=r"^run 2: the drive has the other sign than the motion"):
            diagnosed(machine, fitted, (), held_out)


@pytest.mark.slow
def test_nothing_is_adequate_beside_a_record_of_another_machine() -> None:
    machine, own = actuator_of("bare motor", 0), [steady_friction(number) for number in range(3)]
    alone = diagnosed(machine, own[:2], (), own[2])
    assert isinstance(alone, BalanceAnswer) and (alone.verdict, alone.unseen) == ("adequate", "")
    another = steady_friction(3, 1e-3, 0.3)
    for fitted, held_out in ((own, another), ([*own, another], None)):
        found = diagnosed(machine, fitted, (), held_out)
        assert isinstance(found, BalanceAnswer)
        assert found.verdict == "unknown" and "of run 3: it may be another machine's" in found.unseen, found.unseen


@pytest.mark.slow
def test_another_inertia_than_the_healthy_one_is_another_machine() -> None:
    own = [steady_friction(number) for number in range(5)]
    found = diagnosed(actuator_of("bare motor", 0), [steady_friction(6, 4e-4)], own)
    assert isinstance(found, BalanceAnswer)
    assert any("times that of the healthy records" in one.text for gate in found.gates for one in gate.remarks)


def test_a_record_is_not_its_own_healthy_reference() -> None:
    run, another = (chirp_record(reference_actuator(), f"chirp:duration_s={duration_s}") for duration_s in (1, 2))
    with pytest.raises(InputError, match="healthy is the record itself"):
        diagnosed(reference_actuator(), [another, run], [run])


def in_contact(command: int, rise: float) -> MotionRecord:
    """A shaft whose contact stretches 0.02 rad before it slides, by Dahl, and sticks at rest by `rise`; the motion as asked, its torque with noise."""
    random, time = np.random.default_rng(command), np.arange(5000) * 2e-3
    if command < 2:
        angle = sum(
            size * np.sin(2.0 * np.pi * hz * time + random.uniform(0.0, 6.0))
            for hz, size in ((0.2, 8.0), (0.53, 4.0), (1.1, 1.8), (2.3, 0.6))
        )
    else:
        levels = np.repeat(random.permutation(np.outer([1.0, -1.0], [1.0, 3.0, 7.0, 15.0, 40.0]).ravel()), 500)
        window = np.hanning(151)
        angle = np.cumsum(np.convolve(np.pad(levels, 75, mode="edge"), window / window.sum(), "valid")) * 2e-3
    speed = np.gradient(angle, 2e-3)
    stretch = np.zeros(time.size)
    for row, way in enumerate(np.diff(angle) / 0.02, start=1):
        stretch[row] = np.sign(way) - (np.sign(way) - stretch[row - 1]) * np.exp(-abs(way))
    level = 0.02 * (1.0 + rise / (1.0 + (speed / 8.0) ** 2))
    torque = 2e-5 * np.gradient(speed, 2e-3) + level * stretch + 1e-4 * speed + random.normal(0.0, 2e-4, time.size)
    return MotionRecord(2e-3, f"run {command}").with_columns({"motor_angle_rad": angle, "torque_Nm": torque})


@pytest.mark.parametrize("command", range(3))
@pytest.mark.parametrize(("rows", "side"), [(0, ""), (20, "behind"), (-30, "ahead of")])
def test_a_drive_of_another_clock_is_told_and_a_contact_that_yields_is_none(command: int, rows: int, side: str) -> None:
    record, actuator = in_contact(command, 0.3), actuator_of("bare motor", 0).changed({"screw.inertia_kgm2": 2e-5})
    late = record.with_columns({"torque_Nm": np.roll(record.recorded("torque_Nm"), rows)})
    remarks = [one.text for one in judge_motion(actuator, late).remarks if one.topic == "clock"]
    told = [re.match(r"the drive is about (\d+) ms (behind|ahead of) the motion", one) for one in remarks]
    # to a step of the search, and half of one of the record
    assert [(one[2], abs(float(one[1]) - 2.0 * abs(rows)) <= 6.0) for one in told if one] == ([(side, True)] if side else []), remarks


@pytest.mark.release
def test_two_effects_that_are_refused_alone_are_named_together() -> None:
    actuator = actuator_of("bare motor", 0).changed({"screw.inertia_kgm2": 2e-5})
    found = improve_by_forces(actuator, [in_contact(command, 0.6) for command in range(4)])
    assert {step.effect for step in found.steps} == {"presliding", "stribeck_friction"}
    values = found.steps[-1].values
    # the library's rise falls with another power of the speed, so that what both have is the friction at standstill
    assert values["screw.csj_Nm"] * (1.0 + values["stribeck_friction.rise"]) == pytest.approx(0.032, rel=0.1)
    assert found.steps[-1].values["presliding.stretch_rad"] == pytest.approx(0.02, rel=0.2)
    # and without the rise the contact alone is
    alone = improve_by_forces(actuator, [in_contact(command, 0.0) for command in range(4)])
    assert [step.effect for step in alone.steps] == ["presliding"]


@pytest.mark.slow
@quick
def test_the_observer_names_what_is_large_and_guesses_at_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound beside which the answers are told: sure of every usual size, and no better than a coin where nothing is hidden."""
    trial = MachineTrial("lead screw", 0, "pick and place", "torque_ripple", "medium")
    assert observed(trial)["chance"] > 0.999
    monkeypatch.setitem(EFFECTS, "torque_ripple", 1e-7)  # type: ignore[arg-type]
    assert observed(trial)["chance"] == pytest.approx(0.5, abs=0.01)
