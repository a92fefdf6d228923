"""Records of machines whose controller is not known: reading, what follows of their signals, and actuators that leave things out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.data.actuator import Actuator, read_actuator, reference_actuator
from ema_tools.data.motion_records import COLUMNS, MotionRecord, of_controlled, read_motion_record, write_motion_record
from ema_tools.data.motion_signals import (
    Train,
    disturbance_torque,
    drive_torque,
    integrated,
    motor_angle,
    motor_speed,
    origins,
    rod_position,
    rod_speed,
)
from ema_tools.data.records import read_record
from ema_tools.data.tables.rate import even, pieces_of
from support import RECORDINGS, REFERENCE, chirp_record, complaint, run_ema

N = 0.4  # mm/rad
TRAIN = Train(N)


def a_record(**columns: np.ndarray) -> MotionRecord:
    return MotionRecord(0.001).with_columns(columns)


def swing(rows: int = 2000) -> tuple[np.ndarray, np.ndarray]:
    """Angle and speed of a swing, [rows] at 1 ms."""
    phase = 2.0 * np.pi * 1.5 * 0.001 * np.arange(rows)
    return 1.0 - np.cos(phase), 2.0 * np.pi * 1.5 * np.sin(phase)


@pytest.mark.parametrize("period_s", [1e-5, 6.4e-3, 0.128, 1.0])
@pytest.mark.parametrize("ending", ["csv", "mat", "parquet"])
def test_every_rate_and_format_is_read_as_it_was_written(tmp_path: Path, period_s: float, ending: str) -> None:
    random = np.random.default_rng(3)
    record = MotionRecord(period_s, "r.csv", 0.5).with_columns({name: np.round(random.normal(size=50), 9) for name in COLUMNS})
    path = tmp_path / f"r.{ending}"
    columns = {"time_s": record.time_s, "other": np.zeros(50), **{name: record.recorded(name) for name in COLUMNS}}
    if ending == "csv":
        write_motion_record(path, record, ("a comment",))
    elif ending == "mat":
        savemat(path, columns)
    else:
        pyarrow.parquet.write_table(pyarrow.table(columns), path)
    found = read_motion_record(path)
    assert found.period_s == pytest.approx(period_s, rel=1e-9)
    assert found.first_time_s == 0.5
    assert found.present == tuple(COLUMNS)
    for name in COLUMNS:
        np.testing.assert_allclose(found.recorded(name), record.recorded(name), rtol=1e-11)


def test_a_record_with_a_command_is_read_by_both_readers() -> None:
    path = RECORDINGS / "case_a.csv"
    old, new = read_record(path), read_motion_record(path)
    assert new.period_s == pytest.approx(old.period_s)
    for name in old.present:
        np.testing.assert_array_equal(new.recorded(name), old.recorded(name))
        np.testing.assert_array_equal(of_controlled(old).recorded(name), old.recorded(name))


def csv(*lines: str) -> str:
    return "\n".join(lines) + "\n"


ROWS = [f"{0.001 * k:.3f},{k},{2 * k}" for k in range(20)]
BAD = [
    (
        "no drive",
        csv("time_s,motor_speed_rad_s", *(row.rpartition(",")[0] for row in ROWS)),
        "r.csv: no drive: needs one of the columns torque_Nm",
    ),
    (
        "no motion",
        csv("time_s,torque_Nm", *(row.rpartition(",")[0] for row in ROWS)),
        "r.csv: no motion: needs one of the columns position_mm",
    ),
    ("no time", csv("t,motor_speed_rad_s,torque_Nm", *ROWS), "r.csv: time_s: column missing"),
    ("nothing", csv("time_s,a,b", *ROWS), "r.csv: none of the columns command_mm"),
    (
        "cell",
        csv("time_s,motor_speed_rad_s,torque_Nm", *ROWS[:5], "0.005,x,1", *ROWS[6:]),
        'r.csv: row 7, motor_speed_rad_s: "x" is not a finite number',
    ),
    (
        "empty",
        csv("time_s,motor_speed_rad_s,torque_Nm", *ROWS[:5], "0.005,1,", *ROWS[6:]),
        "r.csv: row 7, torque_Nm: holds no finite number",
    ),
    ("gap", csv("time_s,motor_speed_rad_s,torque_Nm", *ROWS[:5], *ROWS[8:]), "r.csv: row 7, time_s: the rate is not constant"),
    ("short", csv("time_s,motor_speed_rad_s,torque_Nm", *ROWS[:4]), "r.csv: has 4 rows: at least 8 are needed"),
    (
        "slow",
        csv("time_s,motor_speed_rad_s,torque_Nm", *(f"{5 * k},{k},{k}" for k in range(20))),
        "r.csv: time_s: steps of 5 s: records have",
    ),
    (
        "fields",
        csv("time_s,motor_speed_rad_s,torque_Nm", *ROWS[:5], "0.005,1,1,1", *ROWS[6:]),
        "r.csv, row 7: 4 fields where other rows have 3",
    ),
]


@pytest.mark.parametrize(("content", "said"), [one[1:] for one in BAD], ids=[one[0] for one in BAD])
def test_what_is_wrong_is_told(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "r.csv").write_text(content, encoding="utf-8")
    with pytest.raises(InputError) as told:
        read_motion_record(tmp_path / "r.csv")
    assert str(told.value).startswith(said)
    assert "\n" not in str(told.value)


def test_every_motion_gives_the_motor_and_the_rod() -> None:
    angle, speed = swing()
    of_name = {
        "motor_angle_rad": angle,
        "motor_speed_rad_s": speed,
        "motor_position_mm": N * angle,
        "position_mm": N * angle,
        "speed_mm_s": N * speed,
    }
    for name, values in of_name.items():
        record = a_record(**{name: values})
        np.testing.assert_allclose(motor_angle(record, TRAIN).values, angle, atol=1e-4)
        np.testing.assert_allclose(motor_speed(record, TRAIN).values[1:-1], speed[1:-1], atol=1e-3)
        np.testing.assert_allclose(rod_position(record, TRAIN).values, N * angle, atol=1e-4)
        np.testing.assert_allclose(rod_speed(record, TRAIN).values[1:-1], N * speed[1:-1], atol=1e-3)
    assert motor_angle(a_record(motor_speed_rad_s=speed), TRAIN).origin == "integrated"
    assert motor_speed(a_record(motor_speed_rad_s=speed, motor_angle_rad=angle), TRAIN).origin == "recorded"
    assert motor_speed(a_record(position_mm=angle), TRAIN).origin == "differentiated"


def test_what_cannot_be_had_is_told_and_never_made_up() -> None:
    angle, speed = swing()
    with pytest.raises(MissingSignal, match="lead_mm and the gearbox's ratio are not known"):
        motor_speed(a_record(position_mm=angle), Train())
    with pytest.raises(MissingSignal, match="the rod does not follow the motor at once"):
        motor_angle(a_record(position_mm=angle), Train(N, loose=True))
    with pytest.raises(MissingSignal, match="neither position_mm nor speed_mm_s"):
        rod_position(a_record(motor_angle_rad=angle), Train())
    with pytest.raises(MissingSignal, match="torque_constant_Nm_per_A is not known"):
        drive_torque(a_record(current_A=angle), TRAIN, None)
    assert set(origins(a_record(motor_speed_rad_s=speed, torque_Nm=angle), Train(), None)) == {
        "motor_angle_rad",
        "motor_speed_rad_s",
        "torque_Nm",
    }


def test_every_drive_gives_the_torque() -> None:
    torque = swing()[0]
    for name, values in {"torque_Nm": torque, "force_N": torque / (1e-3 * N), "current_A": torque / 0.06}.items():
        np.testing.assert_allclose(drive_torque(a_record(**{name: values}), TRAIN, 0.06).values, torque, rtol=1e-12)
    both = a_record(disturbance_Nm=torque, disturbance_N=torque)
    np.testing.assert_allclose(disturbance_torque(both, TRAIN), torque * (1.0 + 1e-3 * N))
    assert not disturbance_torque(a_record(torque_Nm=torque), TRAIN).any()


@settings(max_examples=100)
@given(
    period=st.sampled_from([1e-5, 1e-3, 6.4e-3, 1.0 / 3000.0, 0.128, 1.0]),
    rows=st.integers(20, 300),
    start=st.floats(0.0, 1e4),
    digits=st.integers(7, 12),
)
def test_an_even_rate_is_found_however_it_was_rounded(period: float, rows: int, start: float, digits: int) -> None:
    stamps = np.round(start + period * np.arange(rows), digits)
    found = even(stamps)
    assert found is not None
    # the last row is off by no more than the rounding of the stamps and a hundredth of a step
    assert abs(found[1] - period) * rows <= 2.0 * (10.0**-digits + 0.02 * period)


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data(), rows=st.integers(60, 200), jitter=st.floats(0.0, 0.4))
def test_pieces_hold_the_signal_at_a_constant_rate(data: st.DataObject, rows: int, jitter: float) -> None:
    random = np.random.default_rng(rows)
    time_s = 0.01 * (np.arange(rows) + jitter * random.uniform(-1.0, 1.0, rows))
    lost = data.draw(st.lists(st.tuples(st.integers(10, rows - 10), st.integers(1, 12)), max_size=3))
    kept = np.ones(rows, dtype=bool)
    for first, count in lost:
        kept[first : first + count] = False
    numbers = np.arange(2, rows + 2)
    pieces, _ = pieces_of(time_s[kept], {"torque_Nm": 3.0 * time_s[kept]}, numbers[kept])
    for piece in pieces:
        values = piece.columns["torque_Nm"]
        times = piece.first_time_s + piece.period_s * np.arange(values.size)
        # a straight line stays one, inside the record, whatever was filled or resampled; a row is off an even rate by a hundredth of
        # a step, as is the first that it begins at, and the step is rounded by two hundredths over the record
        off_s = 0.04 * piece.period_s + 1e-9
        np.testing.assert_allclose(values, 3.0 * times, atol=3.0 * off_s)
        assert times[0] >= time_s[0] - off_s
        assert times[-1] <= time_s[-1] + off_s
    longest = max((count for _, count in lost), default=0)
    if longest == 0:
        assert len(pieces) == 1


BARE = "[screw]\ninertia_kgm2 = 1e-5\nviscous_Nm_s_per_rad = 1e-5\ncsj_Nm = 0.01\n"


def read(text: str, folder: Path, complete: bool = False) -> Actuator:
    (folder / "m.toml").write_text(text, encoding="utf-8")
    return read_actuator(folder / "m.toml", complete)


def test_a_bare_motor_is_a_machine(tmp_path: Path) -> None:
    actuator = read(BARE, tmp_path)
    assert actuator["screw.csj_Nm"] == 0.01
    assert actuator["screw.blk_mm"] == 0.0
    assert actuator["gearbox.efficiency"] == 1.0
    for name in (
        "screw.lead_mm",
        "gearbox.ratio",
        "control.kp_per_m",
        "drive.mode",
        "motor.resistance_ohm",
        "timing.step_s",
        "screw.travel_mm",
    ):
        with pytest.raises(MissingSignal, match=f"m.toml: {name} is not stated"):
            actuator[name]
    assert actuator.written_text() == BARE
    changed = actuator.changed({"screw.csj_Nm": 0.02, "screw.lead_mm": 3.0})
    assert changed["screw.lead_mm"] == 3.0
    again = read(changed.written_text(), tmp_path)
    assert again.absent == changed.absent
    assert again["screw.csj_Nm"] == 0.02


def test_only_what_nobody_can_know_may_be_left_out(tmp_path: Path) -> None:
    for line in BARE.splitlines()[1:]:
        with pytest.raises(InputError, match=f"{line.partition(' ')[0]} is missing"):
            read(BARE.replace(line + "\n", ""), tmp_path)
    with pytest.raises(InputError, match=r"control\.derivative is missing"):
        read(BARE + '[control]\nstructure = "pid"\n', tmp_path)
    # where all of it is there, nothing may be left out
    whole = REFERENCE.read_text(encoding="utf-8")
    with pytest.raises(InputError, match=r"motor\.inductance_H is missing"):
        read("\n".join(line for line in whole.splitlines() if not line.startswith("inductance_H")), tmp_path)
    assert read(whole, tmp_path).values == reference_actuator().values
    assert read(whole, tmp_path).absent == frozenset()


def test_a_command_that_simulates_says_what_is_absent(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(BARE, encoding="utf-8")
    record = RECORDINGS / "healthy.csv"
    said = "m.toml: [control] and [drive] absent: this command simulates the machine and needs them; "
    for arguments in (
        ("simulate", tmp_path / "m.toml", "--command", "chirp", "-o", tmp_path / "r.csv"),
        ("identify", tmp_path / "m.toml", record),
    ):
        assert complaint(run_ema(*arguments)).startswith(said)
    whole = REFERENCE.read_text(encoding="utf-8")
    start, end = whole.index("[drive]"), whole.index("[motor]")
    (tmp_path / "m.toml").write_text(whole[:start] + whole[end:], encoding="utf-8")
    assert complaint(run_ema("identify", tmp_path / "m.toml", record)).startswith("m.toml: [drive] absent: this command simulates")


def test_the_record_of_a_simulation_is_one_of_any_machine() -> None:
    record = of_controlled(chirp_record())
    angle = motor_angle(record, Train(reference_actuator().lead_mm_per_rad, loose=True))
    assert angle.column == "motor_position_mm"
    moved = integrated(motor_speed(record, Train(reference_actuator().lead_mm_per_rad, loose=True)).values, record.period_s)
    np.testing.assert_allclose(moved, angle.values - angle.values[0], atol=0.02 * float(np.ptp(angle.values)))
