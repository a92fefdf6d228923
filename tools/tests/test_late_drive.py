"""A drive that records late, friction that differs by place, a voltage as the drive and a winding that has changed: machines written down here, by fine steps, and no model of the project's."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.base.lag import lagged, remembered
from ema_tools.data.actuator import Actuator, read_actuator
from ema_tools.data.motion_records import MotionRecord, write_motion_record
from ema_tools.data.voltage_drive import with_current
from ema_tools.select.drive_lag import drive_lag_s
from ema_tools.select.force_balance import ONE_MOTION, improve_by_forces
from ema_tools.select.force_refit import add_by_forces, refit_by_forces
from ema_tools.select.healthy_balance import healthy_machine
from ema_tools.select.torque_patterns import NOT_SHARED
from ema_tools.tasks.diagnose_by_balance import answer_against, answer_by_balance, gates_of
from support import complaint, run_ema

FINE_S, EVERY = 1e-4, 20  # a record has rows of 2 ms
INERTIA, VISCOUS, CSJ = 9e-4, 1.5e-3, 0.22
LEAD_MM = 10.0
RESISTANCE, INDUCTANCE, CONSTANT = 1.2, 2e-3, 0.1
STROKE_RAD = 60.0

TOML = f"""[actuator]
name = "axis"
[gearbox]
ratio = 1.0
[screw]
lead_mm = {LEAD_MM}
inertia_kgm2 = {1.03 * INERTIA}
viscous_Nm_s_per_rad = {0.9 * VISCOUS}
csj_Nm = {1.1 * CSJ}
[motor]
torque_constant_Nm_per_A = {CONSTANT}
back_emf_V_s_per_rad = {CONSTANT}
resistance_ohm = {RESISTANCE}
inductance_H = {INDUCTANCE}
"""


def machine(folder: Path, more: str = "") -> Actuator:
    path = folder / "axis.toml"
    path.write_text(TOML.replace('name = "axis"\n', f'name = "axis"\n{more}'), encoding="utf-8")
    return read_actuator(path, complete=False)


def behind(values: Reals, lag_s: float) -> Reals:
    """What a filter of the first order makes of values at the fine steps."""
    if not lag_s:
        return values
    found, share, at = np.empty_like(values), -math.expm1(-FINE_S / lag_s), float(values[0])
    for place, value in enumerate(values.tolist()):
        at += share * (value - at)
        found[place] = at
    return found


def moves(seed: int, fastest_rad_s: float) -> tuple[Reals, Reals]:
    """Angle and speed at the fine steps: there and back between the ends, faster and slower, rounded at the turns."""
    random = np.random.default_rng(seed)
    legs: list[Reals] = []
    side, total = 1.0, 0.0
    while total < 12.0:
        top = fastest_rad_s * float(random.uniform(0.3, 1.0))
        whole = 2.0 * STROKE_RAD * 0.9 / top
        ramp = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, round(0.1 / FINE_S))) ** 2
        legs.append(side * top * np.concatenate([ramp, np.ones(round(whole / FINE_S)), ramp[::-1]]))
        side, total = -side, total + whole + 0.2
    speed = np.concatenate(legs)
    return -0.9 * STROKE_RAD + np.concatenate(([0.0], np.cumsum(speed)[:-1])) * FINE_S, speed


def record(
    seed: int, fastest_rad_s: float, lag_s: float = 0.0, motion_lag_s: float = 0.0, placed: float = 0.0, csj: float = CSJ
) -> MotionRecord:
    """Rows of the motor's angle and torque; `placed`: share by which friction steps up on the one half of the stroke and down on the other."""
    angle, speed = moves(seed, fastest_rad_s)
    friction = csj * (1.0 + placed * np.tanh((angle - 0.1 * STROKE_RAD) / (0.15 * STROKE_RAD)))
    torque = INERTIA * np.gradient(speed, FINE_S) + VISCOUS * speed + friction * np.tanh(speed / 0.05)
    random = np.random.default_rng([7, seed])
    shown, seen = behind(torque, lag_s)[::EVERY], behind(angle, motion_lag_s)[::EVERY]
    return MotionRecord(FINE_S * EVERY, f"run_{seed}.csv").with_columns(
        {
            "motor_angle_rad": seen + random.normal(0.0, 1e-5, seen.size),
            "torque_Nm": shown + random.normal(0.0, 2e-3, shown.size),
        }
    )


def runs(count: int = 3, first: int = 0, **values: float) -> list[MotionRecord]:
    return [record(first + seed, (40.0, 80.0, 130.0, 60.0)[seed % 4], **values) for seed in range(count)]


def test_a_filter_of_the_first_order() -> None:
    """Against its step response, and a ramp that it follows late by its time constant."""
    time = np.arange(400) * 1e-3
    assert lagged(np.ones(400), 1e-3, 0.01) == pytest.approx(np.ones(400))
    ramp = lagged(time, 1e-3, 0.01)
    assert ramp[100:] == pytest.approx(time[100:] - 0.01, abs=1e-5)
    assert np.array_equal(lagged(time, 1e-3, 0.0), time)
    sine = lagged(np.sin(50.0 * time), 1e-3, 0.01)
    assert np.max(np.abs(sine[200:])) == pytest.approx(1.0 / math.hypot(1.0, 0.5), rel=1e-2)
    both = lagged(np.column_stack([time, 2.0 * time]), 1e-3, 0.01)
    assert both[:, 1] == pytest.approx(2.0 * both[:, 0])


def test_a_rest_is_remembered() -> None:
    rest = np.zeros(20, dtype=bool)
    rest[5:8] = True
    assert np.flatnonzero(remembered(rest, 1e-3, 1e-3)).tolist() == list(range(5, 13))
    assert np.flatnonzero(remembered(rest, 1e-3, -1e-3)).tolist() == list(range(5, 13))
    assert np.array_equal(remembered(rest, 1e-3, 0.0), rest)
    assert not remembered(np.zeros(20, dtype=bool), 1e-3, 1e-3).any()


@pytest.mark.parametrize(("lag_s", "motion_lag_s"), [(0.0008, 0.0), (0.003, 0.0), (0.0, 0.0015), (0.0, 0.0)])
def test_the_lag_is_found(tmp_path: Path, lag_s: float, motion_lag_s: float) -> None:
    """To a tenth, or a tenth of a row of 2 ms, within which nobody saw the friction turn over; either way round, and none where there is none."""
    found = drive_lag_s(machine(tmp_path), runs(lag_s=lag_s, motion_lag_s=motion_lag_s))
    assert found == pytest.approx(lag_s - motion_lag_s, rel=0.1, abs=0.1 * FINE_S * EVERY)


@pytest.mark.slow
def test_a_healthy_machine_behind_a_filter_lacks_nothing(tmp_path: Path) -> None:
    known, records = machine(tmp_path), runs(lag_s=0.0015)
    found = answer_by_balance(known, records)
    assert found.verdict == "adequate" and not found.accepted
    assert found.actuator.drive_lag_s == pytest.approx(0.0015, rel=0.1)
    # without it most of what is left is the lag
    stated = improve_by_forces(known.with_drive_lag(0.0), records)
    assert stated.refitted.training > 3.0 * found.forces.refitted.training
    calibrated = refit_by_forces(known, records)
    assert calibrated.actuator.drive_lag_s == pytest.approx(0.0015, rel=0.1)
    assert calibrated.values["screw.csj_Nm"] == pytest.approx(CSJ, rel=0.02)


@pytest.mark.slow
def test_friction_has_changed_behind_a_filter(tmp_path: Path) -> None:
    found = answer_by_balance(machine(tmp_path), runs(3, 10, lag_s=0.0015, csj=1.25 * CSJ), healthy=runs(4, lag_s=0.0015))
    assert not found.accepted
    changed = {one.name: one.today / one.healthy for one in found.changed}
    assert changed == {"screw.csj_Nm": pytest.approx(1.25, rel=0.02)}


@pytest.mark.release
def test_friction_that_differs_by_place_is_named(tmp_path: Path) -> None:
    """In several motions, in either form of asking, with its largest change; one motion alone does not tell it from friction by speed."""
    known, records = machine(tmp_path), runs(placed=0.25, lag_s=0.001)
    found = improve_by_forces(known, records)
    assert [step.effect for step in found.steps] == ["learned_friction"]
    assert found.actuator["learned_friction.axis"] == 1.0
    # a tenth of the step is the level's, whose waves have no mean, and six of them overshoot it by as much
    assert found.actuator["learned_friction.gain"] == pytest.approx(1.2 * 0.25 * CSJ, rel=0.1)
    assert found.steps[-1].errors.holdout < 0.4 * found.refitted.holdout
    added = add_by_forces(known, "learned_friction", records)
    assert added.errors.training == pytest.approx(found.steps[-1].errors.training, rel=1e-9)
    alone = improve_by_forces(known, records[:1])
    assert next(one.reason for one in alone.refused if one.effect == "learned_friction") == ONE_MOTION


@pytest.mark.slow
def test_records_that_share_no_place_tell_no_friction_by_place(tmp_path: Path) -> None:
    """What is seen of the one half of the stroke says nothing of the other; everything else is answered as ever."""
    apart = []
    for shift, one in zip((0.0, 3.0 * STROKE_RAD), runs(2), strict=True):
        apart.append(one.with_columns({"motor_angle_rad": one.recorded("motor_angle_rad") + shift}))
    found = improve_by_forces(machine(tmp_path), apart)
    assert not found.steps
    assert next(one.reason for one in found.refused if one.effect == "learned_friction") == NOT_SHARED


def written(folder: Path, records: Sequence[MotionRecord]) -> list[str]:
    files = [str(folder / f"{place}_{one.file}") for place, one in enumerate(records)]
    for file, one in zip(files, records, strict=True):
        write_motion_record(Path(file), one)
    return files


@pytest.mark.slow
def test_the_command_says_names_and_writes_it(tmp_path: Path) -> None:
    machine(tmp_path)
    files, actuator, new = written(tmp_path, runs(placed=0.25, lag_s=0.002)), tmp_path / "axis.toml", tmp_path / "new.toml"
    ran = run_ema("diagnose", actuator, *files, "--fitted", new, "--json", tmp_path / "found.json")
    assert ran.code == 0, ran.err
    assert "missing is position friction (position_friction" in ran.out
    better = read_actuator(new, complete=False)
    # beside an effect of another form than the table's
    assert better.drive_lag_s == pytest.approx(0.002, rel=0.25)
    assert f"The drive is recorded {1e3 * better.drive_lag_s:.2g} ms behind the motion" in " ".join(ran.out.split())
    assert "drive_lag_s" in new.read_text(encoding="utf-8")
    # what was written is what was said, and is compared by it
    again = run_ema(
        "add", actuator, "position_friction", *(part for file in files for part in ("--fit", file)), "-o", tmp_path / "add.toml"
    )
    assert again.code == 0 and "(position_friction) added" in again.out
    shown = run_ema("effects", "position_friction")
    assert shown.code == 0 and "learned_friction" in shown.out
    assert "drive_lag_s = 2: not a time" in complaint(run_ema("compare", _stated(tmp_path, "drive_lag_s = 2\n"), files[0]))


def _stated(folder: Path, line: str) -> Path:
    (folder / "other").mkdir()
    machine(folder / "other") if not line else (folder / "other" / "axis.toml").write_text(
        TOML.replace('name = "axis"\n', f'name = "axis"\n{line}'), encoding="utf-8"
    )
    return folder / "other" / "axis.toml"


def electrical(seed: int, resistance_ohm: float = RESISTANCE, drive: bool = False) -> MotionRecord:
    """A motor with its voltage at the terminals; its current beside it where `drive`."""
    angle, speed = moves(seed, 90.0)
    torque = INERTIA * np.gradient(speed, FINE_S) + VISCOUS * speed + CSJ * np.tanh(speed / 0.05)
    current = torque / CONSTANT
    voltage = resistance_ohm * current + INDUCTANCE * np.gradient(current, FINE_S) + CONSTANT * speed
    random = np.random.default_rng([11, seed])
    columns = {"motor_angle_rad": angle[::EVERY], "terminal_voltage_V": voltage[::EVERY] + random.normal(0.0, 0.02, angle[::EVERY].size)}
    if drive:
        columns["current_A"] = current[::EVERY] + random.normal(0.0, 0.02, angle[::EVERY].size)
    return MotionRecord(FINE_S * EVERY, f"motor_{seed}.csv").with_columns(columns)


def test_a_voltage_is_a_drive_where_the_winding_is_stated(tmp_path: Path) -> None:
    known, given = machine(tmp_path), electrical(1)
    made = with_current(given, known)
    assert made.current_A is not None
    true = electrical(1, drive=True).recorded("current_A")
    # but for noise and the turns of the motion, where the current jumps between rows
    assert float(np.sqrt(np.mean((made.current_A - true) ** 2))) < 0.05 * float(np.sqrt(np.mean(true**2)))
    assert with_current(electrical(1, drive=True), known).current_A is not made.current_A
    bare = known.changed({})
    assert with_current(given, bare).current_A is not None
    found = refit_by_forces(known, [with_current(electrical(seed), known) for seed in (1, 2, 3)])
    assert found.values["screw.csj_Nm"] == pytest.approx(CSJ, rel=0.03)


@pytest.mark.release
def test_a_winding_that_has_changed_is_said(tmp_path: Path) -> None:
    known, healthy = machine(tmp_path), [electrical(seed, drive=True) for seed in (1, 2, 3)]
    shown = healthy_machine(known, healthy)
    warmer = [electrical(4, 1.15 * RESISTANCE, True), electrical(5, 1.15 * RESISTANCE, True)]
    found = answer_against(shown, warmer, (), gates_of(known, warmer))
    changed = {one.name: one.today / one.healthy for one in found.changed}
    assert changed == {"motor.resistance_ohm": pytest.approx(1.15, rel=0.02)}
    today = [electrical(4, drive=True), electrical(5, drive=True)]
    same = answer_against(shown, today, (), gates_of(known, today))
    assert not same.changed and same.verdict == "adequate"
