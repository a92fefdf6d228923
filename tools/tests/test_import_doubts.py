"""What an import says of scales and units that nobody can read in a file: factors between signals of one motion, and units that are not named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from ema_tools.data.motion_records import read_motion_record
from support import complaint, run_ema

PERIOD_S, INERTIA = 0.01, 2e-4
DRIVEN = ("torque_Nm", "tau", "Nm")


def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Time s, angle rad, speed rad/s and torque Nm of a shaft that goes many turns both ways."""
    time = PERIOD_S * np.arange(1500)
    angle = 60.0 * np.sin(1.1 * time) * np.sin(0.4 * time)
    speed = np.gradient(angle, PERIOD_S)
    return time, angle, speed, INERTIA * np.gradient(speed, PERIOD_S) + 0.02 * np.sign(speed) + 1e-4 * speed


def imported(folder: Path, columns: dict[str, np.ndarray], mapped: list[tuple[str, str, str]], machine: str = "") -> object:
    """`ema import table` of columns by the file's names, `mapped`: column of the record, of the file, unit."""
    folder.mkdir(exist_ok=True)
    rows = np.column_stack(list(columns.values())).tolist()
    lines = [",".join(columns), *(",".join(f"{value:.9g}" for value in row) for row in rows)]
    (folder / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    told = "".join(f'[columns.{name}]\nfrom = "{of}"\nunit = "{unit}"\n' for name, of, unit in mapped)
    (folder / "map.toml").write_text(f"{told}[machine]\n{machine}\n", encoding="utf-8")
    (folder / "i.json").unlink(missing_ok=True)
    return run_ema(
        "import", "table", folder / "log.csv", "--map", folder / "map.toml", "-o", folder / "out", "--json", folder / "i.json", "--force"
    )


def remarks(folder: Path, ran: object) -> list[str]:
    assert ran.code == 0, ran.err  # type: ignore[attr-defined]
    return list(json.loads((folder / "i.json").read_text(encoding="utf-8"))["remarks"])


def test_the_factor_between_position_and_speed_is_told(tmp_path: Path) -> None:
    time, angle, speed, torque = motion()
    columns = {"t": time, "phi": angle, "n": speed, "tau": torque}
    mapped = [("time_s", "t", "s"), ("motor_angle_rad", "phi", "rad"), ("motor_speed_rad_s", "n", "rad/s"), DRIVEN]
    told = remarks(tmp_path, imported(tmp_path, columns, mapped))
    assert any("motor_angle_rad and motor_speed_rad_s agree to 0." in one for one in told), told
    told = remarks(tmp_path, imported(tmp_path, {**columns, "n": 1.1 * speed}, mapped))
    assert any("motor_angle_rad moves 0.909 times as far as motor_speed_rad_s says: they should be one" in one for one in told), told
    ran = imported(tmp_path, {**columns, "n": 4.0 * speed}, mapped)
    assert "motor_angle_rad moves 0.25 times as far as motor_speed_rad_s says" in complaint(ran)
    ran = imported(tmp_path, {**columns, "phi": np.degrees(angle)}, mapped)
    assert "moves 57.3 times as far as motor_speed_rad_s says, as degrees and radians taken for each other would make it" in complaint(ran)


def test_motor_and_rod_say_the_lead(tmp_path: Path) -> None:
    time, angle, _, torque = motion()
    columns = {"t": time, "phi": angle, "x": angle * 5.0 / (2.0 * np.pi), "tau": torque}
    mapped = [("time_s", "t", "s"), ("motor_angle_rad", "phi", "rad"), ("position_mm", "x", "mm"), DRIVEN]
    told = remarks(tmp_path, imported(tmp_path, columns, mapped))
    assert any("position_mm moves 5 mm in one turn of motor_angle_rad: state lead and ratio" in one for one in told), told
    told = remarks(tmp_path, imported(tmp_path, columns, mapped, 'lead = "5 mm"\nratio = 1'))
    assert any("position_mm and motor_angle_rad agree" in one for one in told), told
    assert "lead or ratio in [machine]" in complaint(imported(tmp_path, columns, mapped, 'lead = "10 mm"\nratio = 1'))


@pytest.mark.parametrize("times", [0.25, 3.0])
def test_an_inertia_that_the_records_contradict_is_told(tmp_path: Path, times: float) -> None:
    time, _, speed, torque = motion()
    mapped = [("time_s", "t", "s"), ("motor_speed_rad_s", "n", "rad/s"), DRIVEN]
    columns = {"t": time, "n": speed, "tau": INERTIA * np.gradient(speed, PERIOD_S) + 2e-4 * np.sign(speed)}
    told = remarks(tmp_path, imported(tmp_path, columns, mapped, f'inertia = "{INERTIA / times} kg m^2"'))
    assert any("torque_Nm speeds up" in one and "times the inertia of [machine]: a load that was not counted" in one for one in told), told
    told = remarks(tmp_path, imported(tmp_path, columns, mapped, f'inertia = "{INERTIA} kg m^2"'))
    assert not any("speeds up" in one for one in told), told
    assert torque.size == time.size


def test_a_clock_without_a_unit_is_asked_about(tmp_path: Path) -> None:
    time, _, speed, torque = motion()
    mapped = [("time_s", "t", "ms"), ("motor_speed_rad_s", "n", "rad/s"), DRIVEN]
    columns = {"t": time, "n": speed, "tau": torque}
    said = complaint(imported(tmp_path, columns, mapped))
    assert 'log.csv: "t": no unit is named in the file, and in ms its steps are 1e-05 s and the record is 0.015 s long' in said
    assert 'write unit = "s" in [columns.time_s] of map.toml (steps of 0.01 s), or sure = true there' in said
    # a clock of whole milliseconds read as seconds
    said = complaint(imported(tmp_path, {**columns, "t": np.arange(time.size, dtype=float)}, [("time_s", "t", "s"), *mapped[1:]]))
    assert "in s its steps are 1 s" in said and 'write unit = "ms"' in said
    # where the file names it, or its user is sure, it is as it is
    named = imported(tmp_path, {"t [ms]": time, "n": speed, "tau": torque}, [("time_s", "t [ms]", "ms"), *mapped[1:]])
    assert named.code == 0, named.err  # type: ignore[attr-defined]
    told = remarks(tmp_path, imported(tmp_path, columns, [("time_s", "t", "s"), *mapped[1:]]))
    assert told[0] == 'no unit is named in the file for "t" in s, "n" in rad/s, "tau" in Nm: taken so because map.toml says so'


@pytest.mark.parametrize(("written", "taken", "right"), [("deg", "rad", "deg"), ("rad", "deg", "rad"), ("turn", "rad", "turn")])
def test_an_angle_that_starts_again_after_a_turn_says_its_unit(tmp_path: Path, written: str, taken: str, right: str) -> None:
    time, angle, _, torque = motion()
    turn = {"deg": 360.0, "rad": 2.0 * np.pi, "turn": 1.0}[written]
    wrapped = (angle / (2.0 * np.pi) % 1.0) * turn
    mapped = [("time_s", "t", "s"), ("motor_angle_rad", "phi", taken), DRIVEN]
    columns = {"t": time, "phi": wrapped, "tau": torque}
    said = complaint(imported(tmp_path, columns, mapped))
    assert (
        f'"phi": no unit is named in the file, and it starts again after {turn:.4g}, as an angle in {right} does: write unit = "{right}" in [columns.motor_angle_rad]'
        in said
    )
    ran = imported(tmp_path, columns, [mapped[0], ("motor_angle_rad", "phi", written), DRIVEN])
    assert ran.code == 0, ran.err  # type: ignore[attr-defined]


def test_a_machine_that_would_be_too_fast_is_asked_about(tmp_path: Path) -> None:
    time, angle, speed, torque = motion()
    mapped = [("time_s", "t", "s"), ("motor_angle_rad", "phi", "rad"), DRIVEN]
    said = complaint(imported(tmp_path, {"t": time, "phi": np.degrees(4.0 * angle), "tau": torque}, mapped))
    assert (
        '"phi": no unit is named in the file, and in rad the machine does' in said
        and 'write unit = "deg" in [columns.motor_angle_rad]' in said
    )
    assert imported(tmp_path, {"t": time, "phi": 4.0 * angle, "tau": torque}, mapped).code == 0  # type: ignore[attr-defined]
    said = complaint(
        imported(tmp_path, {"t": time, "n": 60.0 * speed, "tau": torque}, [mapped[0], ("motor_speed_rad_s", "n", "rad/s"), DRIVEN])
    )
    assert 'write unit = "rpm" in [columns.motor_speed_rad_s]' in said


def test_a_linear_machine_is_told_along_its_line(tmp_path: Path) -> None:
    time = PERIOD_S * np.arange(1500)
    way = 300.0 * np.sin(1.1 * time) * np.sin(0.4 * time)
    speed = np.gradient(way, PERIOD_S)
    force = 8.0e-3 * np.gradient(speed, PERIOD_S) + 14.0 * np.sign(speed)
    ran = imported(
        tmp_path,
        {"t": time, "x": way, "F": force},
        [("time_s", "t", "s"), ("position_mm", "x", "mm"), ("force_N", "F", "N")],
        'lead = "32 mm"\nratio = 1\nmass = "8 kg"',
    )
    assert ran.code == 0, ran.err  # type: ignore[attr-defined]
    assert "along the line: mass 8 kg, viscous friction" in ran.out and "dry friction 1" in ran.out  # type: ignore[attr-defined]


def test_an_angle_behind_the_gear_is_held_against_the_motor_s(tmp_path: Path) -> None:
    """A joint has no rod: by a lead of 360 mm a millimetre is a degree, and what contradicts the motor is seen."""
    time, angle, speed, torque = motion()
    columns = {"t": time, "out": np.degrees(angle) / 50.0, "n": speed, "tau": torque}
    mapped = [("time_s", "t", "s"), ("position_mm", "out", "deg"), ("motor_speed_rad_s", "n", "rad/s"), DRIVEN]
    joint = 'ratio = 50\nlead = "360 mm"'
    told = remarks(tmp_path, imported(tmp_path, columns, mapped, joint))
    assert any("position_mm and motor_speed_rad_s agree" in one for one in told), told
    found = read_motion_record(tmp_path / "out" / "log.csv").recorded("position_mm")
    assert np.ptp(found) == pytest.approx(np.ptp(columns["out"]), rel=1e-3)
    assert 'lead = "360 mm" where nothing moves along a line' in complaint(imported(tmp_path, columns, mapped))
    assert "position_mm moves 0.1 times as far" in complaint(imported(tmp_path, columns, mapped, joint.replace("50", "5")))
    assert "run against each other" in complaint(imported(tmp_path, {**columns, "out": -columns["out"]}, mapped, joint))


def test_a_signal_that_is_shorter_than_the_others_is_named(tmp_path: Path) -> None:
    time, angle, _, torque = motion()
    log = {"t": time.tolist(), "phi": angle.tolist(), "tau": torque[:-300].tolist()}
    (tmp_path / "log.json").write_text(json.dumps({"samples": log}), encoding="utf-8")
    entries = [("time_s", "t", "s"), ("motor_angle_rad", "phi", "rad"), DRIVEN]
    (tmp_path / "map.toml").write_text(
        "".join(f'[columns.{name}]\nfrom = "samples.{of}"\nunit = "{unit}"\n' for name, of, unit in entries), encoding="utf-8"
    )
    ran = run_ema("import", "table", tmp_path / "log.json", "--map", tmp_path / "map.toml", "-o", tmp_path / "out")
    assert '"samples.tau" has 1200 values, where the other columns have 1500' in complaint(ran)


def test_two_columns_below_a_title_have_their_names(tmp_path: Path) -> None:
    """Of two fields one unit that nobody knows made the row of units one of names."""
    time, angle, *_ = motion()
    rows = "\n".join(f"{1e3 * at:.0f};{one:.5f}" for at, one in zip(time, 1e3 * angle, strict=True))
    (tmp_path / "log.csv").write_text(f"Achse X1;Gantry 3\nZeit;Istposition\nms;Ink\n{rows}\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(
        "".join(
            f'[columns.{name}]\nfrom = "{of}"\nunit = "{unit}"\n'
            for name, of, unit in (("time_s", "Zeit", "ms"), ("motor_angle_rad", "Istposition", "mrad"), ("current_A", "Iststrom", "A"))
        ),
        encoding="utf-8",
    )
    ran = run_ema("import", "table", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "-o", tmp_path / "out")
    assert 'no column "Iststrom": columns are "Zeit", "Istposition"' in complaint(ran)


def test_what_is_asked_for_in_the_place_of_what_is_done_is_said(tmp_path: Path) -> None:
    time, _, speed, torque = motion()
    for name, odd in (("Sollwert Drehzahl", True), ("Istdrehzahl", False)):
        mapped = [("time_s", "t", "s"), ("motor_speed_rad_s", name, "rad/s"), DRIVEN]
        told = remarks(tmp_path, imported(tmp_path, {"t": time, name: speed, "tau": torque}, mapped))
        assert any(f'"{name}" is what is asked for, by its name, and stands for motor_speed_rad_s' in one for one in told) is odd, told


def test_records_of_earlier_imports_in_a_folder_are_said(tmp_path: Path) -> None:
    time, _, speed, torque = motion()
    columns, mapped = {"t": time, "n": speed, "tau": torque}, [("time_s", "t", "s"), ("motor_speed_rad_s", "n", "rad/s"), DRIVEN]
    assert not any("more records" in one for one in remarks(tmp_path, imported(tmp_path, columns, mapped)))
    (tmp_path / "out" / "yesterday.csv").write_text("time_s\n0\n", encoding="utf-8")
    told = remarks(tmp_path, imported(tmp_path, columns, mapped))
    assert any("holds 1 more records, of earlier imports or other files" in one for one in told), told


def test_grad_is_a_degree(tmp_path: Path) -> None:
    """As German drives write it; the gon, of which 400 are a turn, is called so."""
    time, angle, _, torque = motion()
    for unit, per_rad in (("grad", 180.0 / np.pi), ("Grad", 180.0 / np.pi), ("gon", 200.0 / np.pi)):
        columns = {"t": time, "winkel": per_rad * angle, "tau": torque}
        remarks(tmp_path, imported(tmp_path, columns, [("time_s", "t", "s"), ("motor_angle_rad", "winkel", unit), DRIVEN]))
        record = read_motion_record(tmp_path / "out" / "log.csv")
        assert record.recorded("motor_angle_rad") == pytest.approx(angle, abs=1e-5)
