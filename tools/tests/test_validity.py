"""Record validity: what a record cannot answer is said before anything is concluded from it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from ema_tools.compare.validity import RecordRemark, RecordValidity, judge, lag_s
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.emps import import_emps
from ema_tools.data.records import Record
from ema_tools.results.codec import to_json
from ema_tools.words.answers.validity import validity
from ema_tools.words.sentences.validity import sentence
from support import chirp_record, emps_path

NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03}


@cache
def good(seed: int = 0) -> Record:
    """A record of the reference actuator over more than a screw lead, as its sensors show it."""
    return chirp_record(text="chirp:amplitude_mm=4,end_hz=2").with_noise(NOISE, seed)


def repeats() -> list[Record]:
    return [replace(good(seed), file=f"repeat {seed}") for seed in range(1, 6)]


def remark(gate: RecordValidity, topic: str) -> RecordRemark:
    """The gravest remark on a topic."""
    return next(one for one in gate.remarks if one.topic == topic)


def held(values: np.ndarray, first: int, rows: int) -> np.ndarray:
    """A signal that keeps one value for so many rows."""
    return np.where((np.arange(values.size) >= first) & (np.arange(values.size) < first + rows), values[first], values)


def test_good_record_passes_without_reservation() -> None:
    gate = judge(reference_actuator(), good(), repeats())
    assert gate.answerable
    assert sentence(gate) == "This record can answer: signals, clock, saturation and coverage are in order."
    assert {one.severity for one in gate.remarks} == {"fine"}
    assert {one.topic for one in gate.remarks} == {"signals", "repeats", "coverage", "units", "clock", "sampling", "saturation"}


@pytest.mark.parametrize(
    ("change", "topic", "said"),
    [
        (lambda r: replace(r, position_mm=-r.position_mm), "units", "rod position runs opposite to the model"),
        (lambda r: replace(r, current_A=-r.current_A), "units", "current runs opposite to the model"),
        (lambda r: replace(r, position_mm=1e-3 * r.position_mm), "units", "as if it were in a thousand times the unit"),
        (lambda r: replace(r, current_A=1e3 * r.current_A), "units", "as if it were in a thousandth of the unit"),
        (lambda r: replace(r, voltage_V=r.voltage_V / 24.0), "units", "as if it were in a share of the supply"),
        (lambda r: replace(r, motor_position_mm=np.zeros(r.rows)), "coverage", "rod moves 0 mm"),
        (lambda r: replace(r, current_A=np.zeros(r.rows)), "units", "current_A does not change while the command does"),
        (lambda r: replace(r, position_mm=r.command_mm, command_mm=r.position_mm), "clock", "before its command, which no machine does"),
        (
            lambda r: replace(r, position_mm=held(held(r.position_mm, 300, 150), 5000, r.rows)),
            "stuck",
            "from row 5001, where the motor turns on",
        ),
        (
            lambda r: replace(r, motor_position_mm=held(r.motor_position_mm, 5000, 700)),
            "stuck",
            "motor_position_mm repeats one value for 700 rows from row 5001, where the rod moves on",
        ),
        (lambda r: replace(r, current_A=held(r.current_A, 5000, 700)), "stuck", "from row 5001, where the motor turns on"),
        (lambda r: replace(r, voltage_V=held(r.voltage_V, 5000, 700)), "stuck", "from row 5001, where the motor turns on"),
        (lambda r: replace(r, current_A=r.voltage_V, voltage_V=r.current_A), "columns", "which no winding does"),
        (lambda r: replace(r, position_mm=r.motor_position_mm, motor_position_mm=r.position_mm), "columns", "which no play does"),
        (lambda r: replace(r, position_mm=r.command_mm + 1e-4), "columns", "position_mm is the command"),
    ],
)
def test_wrong_sign_or_unit_blocks(change: Callable[[Record], Record], topic: str, said: str) -> None:
    record = change(good())
    if topic == "coverage":
        record = replace(record, position_mm=np.zeros(record.rows))
    # against repeats, a record with another command is refused before its clock is looked at
    gate = judge(reference_actuator(), record, repeats() if topic != "clock" else ())
    assert not gate.answerable
    found = remark(gate, topic)
    assert found.severity == "blocks" and said in found.text and found.next
    assert sentence(gate).startswith("This record cannot answer: ")


@pytest.mark.parametrize(
    ("change", "topic", "said"),
    [
        (lambda r: replace(r, current_A=None), "signals", "torque effects and electrical effects look alike"),
        (lambda r: replace(r, motor_position_mm=None), "signals", "play, compliance"),
        (lambda r: replace(r, current_A=np.clip(r.current_A, -2.5, 2.5)), "clipping", "its sensor clips, or the drive limits it"),
        (
            lambda r: replace(r, current_A=r.current_A + 20.0 * (np.arange(r.rows) == 4122)),
            "spikes",
            "current_A jumps by +20 A in row 4123 and back: no machine does",
        ),
        (
            lambda r: replace(r, position_mm=r.position_mm - 3.0 * np.isin(np.arange(r.rows), (700, 701, 3000))),
            "spikes",
            "position_mm jumps by -2.99 mm in row 701 and back, and so do 2 other rows",
        ),
        (
            lambda r: replace(r, position_mm=held(r.position_mm, 5000, 150)),
            "stuck",
            "position_mm repeats one value for 150 rows from row 5001, where the motor turns on",
        ),
        (lambda r: replace(r, position_mm=np.concatenate((np.zeros(30), r.position_mm[:-30]))), "clock", "ms later than in the model"),
        (
            lambda r: replace(r, motor_position_mm=np.concatenate((np.zeros(8), r.motor_position_mm[:-8]))),
            "clock",
            "rod and motor position are",
        ),
    ],
)
def test_what_is_doubtful_weakens(change: Callable[[Record], Record], topic: str, said: str) -> None:
    gate = judge(reference_actuator(), change(good()), repeats())
    assert gate.answerable and "reservation" in sentence(gate)
    found = remark(gate, topic)
    assert found.severity == "weakens" and said in found.text and found.next


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("chirp:amplitude_mm=2", "0.76 of a screw lead"),
        ("chirp:amplitude_mm=0.3", "the motor turns"),
        ("triangle:amplitude_mm=5,start_hz=0.1", "acceleration takes"),
        ("step:amplitude_mm=10,duration_s=3", "one direction only"),
    ],
)
def test_what_the_motion_does_not_cover_is_said(command: str, said: str) -> None:
    gate = judge(reference_actuator(), chirp_record(text=command).with_noise(NOISE, 1))
    assert any(one.topic == "coverage" and one.severity == "weakens" and said in one.text for one in gate.remarks), gate.remarks


def test_drive_at_its_limit_is_said() -> None:
    weak = reference_actuator().changed({"drive.supply_V": 7.0})
    gate = judge(weak, chirp_record(weak, "chirp:amplitude_mm=4,end_hz=6"))
    assert remark(gate, "saturation").severity == "weakens"


def test_repeats_that_are_none() -> None:
    model, record = reference_actuator(), good()
    assert "standing error" in remark(judge(model, record), "repeats").text
    other = replace(good(1), command_mm=1.1 * record.command_mm, file="other.csv")
    assert remark(judge(model, record, [other, *repeats()]), "repeats").text == "other.csv holds another command than simulated"
    assert "is the record itself" in remark(judge(model, record, [record, *repeats()]), "repeats").text
    poor = replace(good(1), current_A=None, file="poor.csv")
    assert remark(judge(model, record, [poor, *repeats()]), "repeats").text.startswith("poor.csv lacks current_A")
    assert remark(judge(model, record, repeats()[:2]), "repeats").severity == "weakens"


@pytest.mark.parametrize(
    "change",
    [
        lambda r: replace(r, current_A=r.voltage_V, voltage_V=r.current_A),
        lambda r: replace(r, position_mm=r.motor_position_mm, motor_position_mm=r.position_mm),
        lambda r: replace(r, current_A=held(r.current_A, 5000, 2000)),
    ],
)
def test_repeat_with_exchanged_columns_or_a_held_sensor_is_named(change: Callable[[Record], Record]) -> None:
    wrong = replace(change(good(9)), file="third.csv")
    blocking = [one for one in judge(reference_actuator(), good(), [*repeats(), wrong]).remarks if one.severity == "blocks"]
    assert [one.text.startswith("third.csv is no repeat: ") for one in blocking] == [True]


@pytest.mark.parametrize("command", ["chirp:amplitude_mm=4,end_hz=0.5", "multisine", "triangle:amplitude_mm=2,start_hz=0.2", "chirp"])
@pytest.mark.parametrize(
    "changes", [{}, {"screw.blk_mm": 0.0}, {"screw.blk_mm": 0.2}, {"encoder.rod_gain_error": -0.01}, {"screw.csj_Nm": 0.28}]
)
def test_columns_that_are_right_are_not_called_exchanged(command: str, changes: dict[str, float]) -> None:
    """Neither wear nor a sensor whose gain is off turns play or back-EMF round."""
    machine = reference_actuator().changed(changes)
    gate = judge(reference_actuator(), chirp_record(machine, command).with_noise(NOISE, 3))
    assert not [one.text for one in gate.remarks if one.topic == "columns"]


def test_record_of_a_few_rows_blocks() -> None:
    record = chirp_record(text="chirp:duration_s=0.1")
    gate = judge(reference_actuator(), record)
    assert not gate.answerable and "too few" in sentence(gate)


def test_lag_is_found_between_the_rows() -> None:
    time = np.arange(2000) * 1e-3
    wave = np.sin(2.0 * np.pi * 3.0 * time) + np.sin(2.0 * np.pi * 5.3 * time)
    late = np.sin(2.0 * np.pi * 3.0 * (time - 0.0023)) + np.sin(2.0 * np.pi * 5.3 * (time - 0.0023))
    assert lag_s(late, wave, 1e-3) == pytest.approx(0.0023, abs=2e-4)
    assert lag_s(wave, late, 1e-3) == pytest.approx(-0.0023, abs=2e-4)


def test_result_is_json_with_every_signal() -> None:
    record = replace(good(), voltage_V=None)
    result = json.loads(json.dumps(to_json(validity(judge(reference_actuator(), record, repeats()))), allow_nan=False))
    assert result["answerable"] is True
    assert result["signals"]["voltage_V"]["present"] is False and "supply" in result["signals"]["voltage_V"]["hides"]
    assert result["signals"]["current_A"] == {"present": True, "hides": None}
    assert result["coverage"]["stroke_leads"] > 1.0


def test_measured_axis_is_not_refused(tmp_path: Path) -> None:
    """EMPS: a stiff loop, a current drive, no current recorded."""
    found = import_emps(emps_path(), tmp_path / "emps")
    gate = judge(found.actuator, found.record)
    assert gate.answerable, sentence(gate)
    said = [one.text for one in gate.remarks if one.topic == "signals"]
    assert "current_A is not recorded; the command of the ideal current drive stands for it" in said
    assert {one.topic for one in gate.remarks if one.severity != "fine"} == {"repeats"}
