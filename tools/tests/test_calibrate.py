"""Calibration: values come back from healthy records, with standard errors that hold."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record, read_record, write_record
from ema_tools.tasks.calibrate import PLAY, calibrate, free_parameters
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema

UNIT = RECORDINGS / "unit"
WRONG = {
    "screw.csj_Nm": 0.2,
    "screw.inertia_kgm2": 8e-5,
    "screw.viscous_Nm_s_per_rad": 2e-4,
    "motor.resistance_ohm": 1.2,
    "motor.inductance_H": 1e-3,
    "screw.blk_mm": 0.05,
}
NOISE = {"position_mm": 0.005, "motor_position_mm": 0.005, "current_A": 0.03}


def test_healthy_record_gives_the_values_of_the_independent_plant() -> None:
    record = read_record(RECORDINGS / "healthy.csv", reference_actuator())
    found = calibrate(reference_actuator().changed(WRONG), [record])
    assert {parameter.source for parameter in found.parameters} == {"loop"}
    for name in WRONG:
        assert found.actuator[name] == pytest.approx(reference_actuator()[name], rel=1e-3)
    assert found.errors_after["position_mm"] < 1e-6 < found.errors_before["position_mm"]


def test_balances_alone_come_near() -> None:
    record = read_record(RECORDINGS / "healthy.csv", reference_actuator())
    found = calibrate(reference_actuator().changed(WRONG), [record], loop=False)
    assert {parameter.source for parameter in found.parameters} == {"balance"}
    for name, accuracy in (
        ("screw.csj_Nm", 0.01),
        ("screw.inertia_kgm2", 0.01),
        ("motor.resistance_ohm", 0.01),
        ("motor.back_emf_V_s_per_rad", 0.01),
        ("screw.blk_mm", 0.001),
    ):
        assert found.actuator[name] == pytest.approx(reference_actuator()[name], rel=accuracy)


@pytest.mark.slow
def test_stated_errors_hold_under_sensor_noise() -> None:
    truth = reference_actuator()
    record = chirp_record()
    deviations = []
    for seed in range(6):
        found = calibrate(truth, [record.with_noise(NOISE, seed)], loop=True)
        deviations.append([(parameter.after - truth[parameter.name]) / parameter.std for parameter in found.parameters])
    rms = np.sqrt(np.mean(np.square(deviations), axis=0))
    assert np.all(rms < 2.0)
    assert np.mean(rms) > 0.4


@pytest.mark.parametrize(
    ("command", "rows", "name"),
    [
        ("step:amplitude_mm=0", 2000, "screw.csj_Nm"),
        ("triangle:amplitude_mm=2,start_hz=0.02,duration_s=5", 5000, "motor.inductance_H"),
        ("chirp", 300, "motor.inductance_H"),
        ("chirp", 120, "screw.inertia_kgm2"),
    ],
)
def test_what_a_record_does_not_determine_is_named(command: str, rows: int, name: str) -> None:
    """No motion, no acceleration, hardly a row: the fit runs to where the model cannot be stepped, which is no fault of the step."""
    full = chirp_record(text=command)
    record = full.with_columns({column: full.recorded(column)[:rows] for column in full.present}).with_noise(NOISE, 1)
    with pytest.raises(InputError, match=rf"^calibrate: {name}: (the records do not determine it|no record moves what it acts on): "):
        calibrate(reference_actuator(), [record])


def test_a_record_too_short_for_the_balances_says_so() -> None:
    full = chirp_record()
    record = full.with_columns({column: full.recorded(column)[:120] for column in full.present})
    left_out = calibrate(reference_actuator(), [record], loop=False).left_out
    assert left_out and all("rows are too few for any filter, 200 are needed" in why for why in left_out.values())


def test_effects_that_the_actuator_has_are_not_calibrated_into_its_values() -> None:
    changes = {"winding_heating.rise_degC": 60.0, "constant_load.torque_Nm": 0.03, "stribeck_friction.rise": 0.3}
    truth = reference_actuator().changed(changes)
    found = calibrate(truth.changed({"motor.resistance_ohm": 1.2, "screw.load_torque_Nm": 0.01}), [chirp_record(truth)], loop=False)
    assert found.actuator["motor.resistance_ohm"] == pytest.approx(truth["motor.resistance_ohm"], rel=0.01)
    assert found.actuator["screw.load_torque_Nm"] == pytest.approx(0.0, abs=2e-3)
    assert found.actuator["screw.csj_Nm"] == pytest.approx(truth["screw.csj_Nm"], rel=0.03)


def test_more_records_lower_the_errors() -> None:
    records = [chirp_record().with_noise(NOISE, seed) for seed in range(4)]
    one = calibrate(reference_actuator(), records[:1], ["screw.csj_Nm", "screw.blk_mm"], loop=True)
    four = calibrate(reference_actuator(), records, ["screw.csj_Nm", "screw.blk_mm"], loop=True)
    for first, second in zip(one.parameters, four.parameters, strict=True):
        assert 0.35 < second.std / first.std < 0.7


def test_what_is_free_depends_on_the_signals() -> None:
    record = chirp_record()
    bare = replace(record, motor_position_mm=None, current_A=None, voltage_V=None)
    assert free_parameters(reference_actuator(), [bare]) == ("screw.csj_Nm", "screw.blk_mm")
    assert len(free_parameters(reference_actuator(), [record])) == 8
    assert "screw.blk_mm" not in free_parameters(reference_actuator().changed({"screw.blk_mm": 0.0}), [record])
    found = calibrate(reference_actuator().changed({"screw.csj_Nm": 0.2, "screw.blk_mm": 0.05}), [bare])
    assert found.actuator["screw.csj_Nm"] == pytest.approx(0.138, rel=1e-4)
    assert found.actuator["screw.blk_mm"] == pytest.approx(0.033, rel=1e-3)
    with pytest.raises(InputError, match="nothing to fit without the closed loop"):
        calibrate(reference_actuator(), [bare], loop=False)


def test_value_that_the_record_does_not_determine_is_named() -> None:
    with pytest.raises(InputError, match=r"calibrate: screw\.travel_mm: the records do not determine it"):
        calibrate(reference_actuator(), [chirp_record()], ["screw.travel_mm"], loop=True)
    with pytest.raises(InputError, match=r"screw.csj: unknown value \(did you mean screw.csj_Nm\?\)"):
        calibrate(reference_actuator(), [chirp_record()], ["screw.csj"])


def test_command_keeps_the_comments_and_the_original(tmp_path: Path) -> None:
    original = tmp_path / "a.toml"
    original.write_text(
        "# my machine\n" + REFERENCE.read_text(encoding="utf-8").replace("csj_Nm = 0.138", "csj_Nm = 0.2"), encoding="utf-8"
    )
    before = original.read_text(encoding="utf-8")
    new = tmp_path / "new.toml"
    ran = run_ema("calibrate", original, RECORDINGS / "healthy.csv", "-o", new, "--json", tmp_path / "c.json")
    assert ran.code == 0, ran.err
    assert original.read_text(encoding="utf-8") == before
    assert new.read_text(encoding="utf-8").startswith("# my machine\n")
    assert read_actuator(new)["screw.csj_Nm"] == pytest.approx(0.138, rel=1e-4)
    assert read_actuator(new).about["source"].endswith("; calibrated on healthy.csv")
    assert "exists already" in complaint(run_ema("calibrate", original, RECORDINGS / "healthy.csv", "-o", new))
    assert "is read by this command" in complaint(run_ema("calibrate", original, RECORDINGS / "healthy.csv", "-o", original, "--force"))


def _bare(record: Record) -> Record:
    return replace(record, motor_position_mm=None, current_A=None, voltage_V=None, speed_mm_s=None)


WRONG_RECORDS: dict[str, Callable[[Record], Record]] = {
    "position_mm: sign flipped": lambda record: replace(_bare(record), position_mm=-record.position_mm),
    "position_mm: swapped with the command": lambda record: replace(
        _bare(record), command_mm=record.position_mm, position_mm=record.command_mm
    ),
    "position_mm: of another command": lambda record: replace(
        _bare(record), command_mm=make_command("triangle", reference_actuator()).samples_mm
    ),
    "position_mm: another command, every signal": lambda record: replace(
        record, command_mm=make_command("triangle", reference_actuator()).samples_mm
    ),
    "position_mm: clipped": lambda record: replace(_bare(record), position_mm=np.clip(record.position_mm, -1.0, 1.0)),
    "position_mm: wrong scale": lambda record: replace(_bare(record), position_mm=1.2 * record.position_mm),
    "position_mm: stuck sensor": lambda record: replace(_bare(record), position_mm=np.zeros(record.rows)),
    "current_A: not the motor's": lambda record: replace(_bare(record), current_A=np.random.default_rng(1).normal(0.0, 3.0, record.rows)),
}


@pytest.mark.parametrize("what", WRONG_RECORDS)
def test_record_that_the_model_cannot_follow_is_refused(tmp_path: Path, what: str) -> None:
    write_record(tmp_path / "wrong.csv", WRONG_RECORDS[what](read_record(RECORDINGS / "healthy.csv", reference_actuator())))
    said = complaint(
        run_ema(
            "calibrate",
            REFERENCE,
            RECORDINGS / "healthy.csv",
            tmp_path / "wrong.csv",
            "-o",
            tmp_path / "new.toml",
            "--fit",
            "screw.csj_Nm,screw.blk_mm",
        )
    )
    if "stuck" in what:
        assert said.startswith(
            "wrong.csv: position_mm does not change, while that of healthy.csv does: check that the sensor was connected"
        )
    else:
        assert said.startswith(f"wrong.csv: {what.split(':')[0]}: the calibrated model misses it by ")
        assert said.endswith("then calibrate again")
    assert not (tmp_path / "new.toml").exists()


def test_values_stay_where_the_search_will_look() -> None:
    record = read_record(RECORDINGS / "healthy.csv", reference_actuator())
    for name, bounds, start, bound in (
        ("screw.csj_Nm", {"search.csj_lower_Nm": 0.15}, 0.2, 0.15),
        ("screw.blk_mm", {"search.blk_upper_mm": 0.03}, 0.01, 0.03),
    ):
        narrow = reference_actuator().changed({**bounds, name: start})
        for names, loop in (((name,), True), (None, False)):
            found = calibrate(narrow, [record], names, loop)
            assert found.actuator[name] == pytest.approx(bound, rel=1e-4)
            assert next(parameter for parameter in found.parameters if parameter.name == name).at_bound
    with pytest.raises(InputError, match=r"search.blk_lower_mm = 0.2: not below search.blk_upper_mm = 0.1: correct the bounds"):
        calibrate(reference_actuator().changed({"search.blk_lower_mm": 0.2}), [record])


def test_a_run_that_is_given_twice_says_nothing_of_scatter(tmp_path: Path) -> None:
    healthy = RECORDINGS / "story" / "healthy_1.csv"
    ran = run_ema("calibrate", REFERENCE, healthy, healthy, "-o", tmp_path / "new.toml")
    assert "healthy_1.csv: given twice: give every healthy run once" in complaint(ran)
    assert not (tmp_path / "new.toml").exists()


@pytest.mark.parametrize(
    ("odd", "says"),
    [
        ("in_mA.csv", "in_mA.csv: current_A is 1e+03 times that of healthy_"),
        ("worn.csv", "worn.csv: not of the same state as healthy_1.csv, healthy_2.csv: csj_Nm differs from theirs by "),
    ],
)
@pytest.mark.parametrize("command", [pytest.param("calibrate", marks=pytest.mark.slow), "export"])
def test_the_odd_one_among_healthy_runs_is_named(tmp_path: Path, command: str, odd: str, says: str) -> None:
    """Whatever its place; nothing is written."""
    runs = [UNIT / "healthy_1.csv", UNIT / "healthy_2.csv"]
    given = UNIT / odd
    if not given.exists():
        given = tmp_path / odd
        run = read_record(runs[0], read_actuator(UNIT / "unit.toml"))
        write_record(given, replace(run, current_A=1000.0 * run.recorded("current_A")))
    runs.insert(0, given)
    out = tmp_path / "made"
    healthy = [word for run in runs for word in ("--healthy", str(run))]
    asked = ("export", UNIT / "unit.toml", "-o", tmp_path / "data.h", "--signatures", out, *healthy)
    ran = run_ema(*(("calibrate", REFERENCE, *runs, "-o", out) if command == "calibrate" else asked))
    assert says in complaint(ran)
    assert not out.exists()


@pytest.mark.slow
def test_values_far_from_the_file_are_said(tmp_path: Path) -> None:
    """A lead that is five times too long is made up for by inertia and back-EMF."""
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(re.sub(r"(?m)^lead_mm = 5.0", "lead_mm = 25.4", REFERENCE.read_text(encoding="utf-8")), encoding="utf-8")
    ran = run_ema("calibrate", wrong, UNIT / "healthy_1.csv", "-o", tmp_path / "new.toml", "--json", tmp_path / "told.json")
    assert "Far from the file: screw.inertia_kgm2 is 5.2 times, motor.back_emf_V_s_per_rad is 5.1 times what it said." in " ".join(
        ran.out.split()
    )
    assert set(json.loads((tmp_path / "told.json").read_text(encoding="utf-8"))["far"]) == {
        "screw.inertia_kgm2",
        "motor.back_emf_V_s_per_rad",
    }
    right = run_ema("calibrate", REFERENCE, UNIT / "healthy_1.csv", "-o", tmp_path / "right.toml")
    assert "Far from the file" not in right.out


def test_a_supply_off_its_data_sheet_is_found_and_spoils_no_play() -> None:
    """What the controller asks for is a share of the supply."""
    given = reference_actuator()
    truth = given.changed({"drive.supply_V": 23.6, PLAY: 0.036, "motor.resistance_ohm": 1.03})
    record = chirp_record(truth).with_noise({**NOISE, "voltage_V": 0.01}, 3)
    found = calibrate(given, [record])
    known = {one.name: one for one in found.parameters}
    assert known["drive.supply_V"].after == pytest.approx(23.6, abs=4.0 * known["drive.supply_V"].std)
    assert known[PLAY].after == pytest.approx(0.036, abs=4.0 * known[PLAY].std)
    # as it is stated, it stays
    same = calibrate(given, [chirp_record(given).with_noise({**NOISE, "voltage_V": 0.01}, 3)])
    assert "drive.supply_V" not in {one.name for one in same.parameters}
