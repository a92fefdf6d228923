"""`ema import draft` and `ema import table`: files of any maker become records; what is wrong is told in one sentence that says what to write."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from ema_tools.data.actuator import read_actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.motion_records import of_controlled, read_motion_record, write_motion_record
from ema_tools.data.tables.table_map import read_map
from ema_tools.results.files import DraftResult, TableImportResult
from ema_tools.results.reading import read_result
from ema_tools.tasks.simulate import simulate_record
from foreign_files import FORMATS, FRICTION, INERTIA, MAP, PLAIN_MAP, RPM, VISCOUS, columns, run, text
from support import RECORDINGS, ROOT, complaint, run_ema


def imported(folder: Path, name: str, content: str | bytes, table_map: str = MAP, *more: object) -> Path:
    """A file and its map, imported; the folder of the records."""
    (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return of_files(folder, table_map, folder / name, *more)


def of_files(folder: Path, table_map: str, *files: object) -> Path:
    (folder / "map.toml").write_text(table_map, encoding="utf-8")
    ran = run_ema("import", "table", *files, "--map", folder / "map.toml", "-o", folder / "out", "--json", folder / "i.json")
    assert ran.code == 0, ran.err
    return folder / "out"


def refused(folder: Path, content: str, table_map: str = MAP, name: str = "a.csv") -> str:
    """What is said of a file and a map that cannot be right; nothing is written."""
    shutil.rmtree(folder / "out", ignore_errors=True)
    (folder / name).write_text(content, encoding="utf-8")
    (folder / "map.toml").write_text(table_map, encoding="utf-8")
    said = complaint(run_ema("import", "table", folder / name, "--map", folder / "map.toml", "-o", folder / "out"))
    assert not (folder / "out").exists()
    return said


def said_of(folder: Path) -> list[str]:
    """The remarks of the last import about its first file."""
    return json.loads((folder / "i.json").read_text(encoding="utf-8"))["files"][0]["remarks"]


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_the_same_record(tmp_path: Path, name: str) -> None:
    write, table_map = FORMATS[name]
    write(tmp_path / name)
    out = of_files(tmp_path, table_map, tmp_path / name)
    record = read_motion_record(out / f"{name.rpartition('.')[0]}.csv")
    time_s, speed, torque = run()
    assert record.period_s == 0.005
    assert record.present == ("motor_speed_rad_s", "torque_Nm")
    np.testing.assert_allclose(record.time_s, time_s, atol=1e-12)
    np.testing.assert_allclose(record.recorded("motor_speed_rad_s"), speed, rtol=1e-8, atol=1e-9)
    np.testing.assert_allclose(record.recorded("torque_Nm"), torque, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("name", FORMATS)
def test_the_draft_of_every_format_is_the_map_but_for_what_only_the_user_knows(tmp_path: Path, name: str) -> None:
    write, _ = FORMATS[name]
    write(tmp_path / name)
    ran = run_ema("import", "draft", tmp_path / name, "-o", tmp_path / "map.toml", "--json", tmp_path / "d.json")
    assert ran.code == 0, ran.err
    draft = json.loads((tmp_path / "d.json").read_text(encoding="utf-8"))
    assert set(draft["guessed"]) == {"time_s", "motor_speed_rad_s", "torque_Nm"}
    content = (tmp_path / "map.toml").read_text(encoding="utf-8")
    known = {"time_s": "ms", "motor_speed_rad_s": "rpm", "torque_Nm": "mNm", "machine": ""}
    for entry in draft["open"]:
        table, _, key = entry.removeprefix("columns.").partition(".")
        said = complaint(run_ema("import", "table", tmp_path / name, "--map", tmp_path / "map.toml", "-o", tmp_path / "out"))
        assert "is still to be filled in" in said
        if table == "machine":
            content = content.replace(f'{key} = "?"', f"# {key}")
        else:
            before, mark, after = content.partition(f"[columns.{table}]")
            content = before + mark + after.replace(f'{key} = "?"', f'{key} = "{known[table]}"', 1)
        (tmp_path / "map.toml").write_text(content, encoding="utf-8")
    out = of_files(tmp_path, content, tmp_path / name)
    record = read_motion_record(out / f"{name.rpartition('.')[0]}.csv")
    np.testing.assert_allclose(record.recorded("torque_Nm"), run()[2], rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("name", ["struct.mat", "array.npz", "frame.parquet", "lists.json"])
@pytest.mark.parametrize("share", [0.1, 0.6, 0.99])
def test_a_file_that_was_cut_off_is_refused_in_a_sentence(tmp_path: Path, name: str, share: float) -> None:
    write, its_map = FORMATS[name]
    write(tmp_path / name)
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: int(share * len(whole))])
    (tmp_path / "map.toml").write_text(its_map, encoding="utf-8")
    for command in (
        ("draft", str(tmp_path / name), "-o", str(tmp_path / "new.toml")),
        ("table", str(tmp_path / name), "--map", str(tmp_path / "map.toml"), "-o", str(tmp_path / "out")),
    ):
        assert name in complaint(run_ema("import", *command))


def test_the_actuator_starts_from_the_records_and_has_no_controller(tmp_path: Path) -> None:
    out = imported(tmp_path, "a.csv", text())
    actuator = read_actuator(out / "actuator.toml", complete=False)
    assert actuator["screw.inertia_kgm2"] == pytest.approx(INERTIA, rel=0.05)
    assert actuator["screw.csj_Nm"] == pytest.approx(FRICTION, rel=0.05)
    assert actuator["screw.load_torque_Nm"] == 0.0
    assert actuator["screw.viscous_Nm_s_per_rad"] == pytest.approx(VISCOUS, rel=0.3)
    assert not actuator.has("control.kp_per_m")
    assert not actuator.has("screw.lead_mm")
    assert "[control]" not in (out / "actuator.toml").read_text(encoding="utf-8")
    said = complaint(run_ema("simulate", out / "actuator.toml", "--command", "chirp", "-o", tmp_path / "s.csv"))
    assert said.startswith("actuator.toml: [control] and [drive] absent: this command simulates the machine and needs them")


def test_the_machine_of_the_map_stands_in_the_actuator(tmp_path: Path) -> None:
    machine = '[machine]\nname = "bench 3"\ninertia = "30 g cm^2"\nmass = "2 kg"\nlead = "5 mm"\nratio = 2\ntorque_constant = "25.9 mNm/A"\nfriction = "0.4 Ncm"\n'
    actuator = read_actuator(imported(tmp_path, "a.csv", text(), MAP + machine) / "actuator.toml", complete=False)
    assert actuator.name == "bench 3"
    assert actuator["screw.inertia_kgm2"] == pytest.approx(3e-6 + 2.0 * (0.005 / (4.0 * np.pi)) ** 2, rel=1e-5)
    assert (actuator["screw.lead_mm"], actuator["gearbox.ratio"], actuator["motor.torque_constant_Nm_per_A"]) == (5.0, 2.0, 0.0259)
    assert actuator["screw.csj_Nm"] == 0.004


UNITS = [
    ("motor_speed_rad_s", "deg/s", np.degrees(1.0)),
    ("motor_speed_rad_s", "turn/s", 1.0 / (2.0 * np.pi)),
    ("motor_speed_rad_s", "counts/s", 4096.0 / (2.0 * np.pi)),
    ("motor_speed_rad_s", "U/min", 1.0 / RPM),
    ("motor_speed_rad_s", "min-1", 1.0 / RPM),
    ("torque_Nm", "%", 100.0 / 0.05),
    ("torque_Nm", "0.1 %", 1000.0 / 0.05),
    ("torque_Nm", "Ncm", 100.0),
    ("torque_Nm", "ozin", 1.0 / 0.00706155),
    ("torque_Nm", "lbf in", 1.0 / 0.1129848),
    ("torque_Nm", "N·m", 1.0),
]


@pytest.mark.parametrize(("name", "unit", "per_unit"), UNITS, ids=str)
def test_units(tmp_path: Path, name: str, unit: str, per_unit: float) -> None:
    time_s, speed, torque = run()
    values = {"motor_speed_rad_s": speed, "torque_Nm": torque}
    values[name] = values[name] * per_unit
    lines = ["t,n,m", *(f"{a!r},{b!r},{c!r}" for a, b, c in zip(time_s.tolist(), *(one.tolist() for one in values.values()), strict=True))]
    units = {"motor_speed_rad_s": "rad/s", "torque_Nm": "Nm", name: unit}
    table_map = f"""
[columns.time_s]
from = "t"
unit = "s"
[columns.motor_speed_rad_s]
from = "n"
unit = "{units["motor_speed_rad_s"]}"
[columns.torque_Nm]
from = "m"
unit = "{units["torque_Nm"]}"
[machine]
counts_per_turn = 4096
nominal_torque = "50 mNm"
"""
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), table_map) / "a.csv")
    np.testing.assert_allclose(record.recorded("motor_speed_rad_s"), speed, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(record.recorded("torque_Nm"), torque, rtol=1e-6, atol=1e-12)


def rows_of(content: str) -> list[str]:
    return content.splitlines()


def test_lost_rows_are_filled_and_gaps_cut(tmp_path: Path) -> None:
    lines = rows_of(text())
    out = imported(tmp_path, "a.csv", "\n".join([*lines[:100], *lines[102:250], *lines[290:]]))
    first, second = (read_motion_record(out / f"a_{k}.csv") for k in (1, 2))
    assert (first.rows, second.rows) == (249, 111)
    assert second.first_time_s == pytest.approx(0.005 * 289)
    np.testing.assert_allclose(second.recorded("torque_Nm"), run()[2][289:], atol=1e-9)
    np.testing.assert_allclose(first.recorded("motor_speed_rad_s"), run()[1][:249], atol=0.25)
    assert said_of(tmp_path) == [
        "2 rows are missing: filled by straight lines",
        "nothing is recorded for 0.205 s before row 249: cut there",
    ]


def test_uneven_time_is_resampled(tmp_path: Path) -> None:
    time_s, _, _ = run()
    random = np.random.default_rng(1)
    uneven = np.sort(time_s + random.uniform(-0.0012, 0.0012, time_s.size))
    phase = 2.0 * np.pi * 1.3 * uneven
    lines = ["Time [ms],Motor speed [rpm],Torque [mNm]"]
    lines += [
        f"{1e3 * t!r},{float(40.0 * np.sin(p) / RPM)!r},{float(5.0 * np.sin(p))!r}"
        for t, p in zip(uneven.tolist(), phase.tolist(), strict=True)
    ]
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), MAP + '[machine]\ninertia = "30 g cm^2"\n') / "a.csv")
    np.testing.assert_allclose(record.recorded("motor_speed_rad_s"), 40.0 * np.sin(2.0 * np.pi * 1.3 * record.time_s), atol=0.03)
    assert "resampled" in said_of(tmp_path)[0]


def test_rounded_stamps_are_an_even_rate(tmp_path: Path) -> None:
    _, speed, torque = run()
    stamps = np.floor(np.arange(400) * 0.4)  # ms of a clock that shows whole ones only, at 2.5 kHz
    lines = [
        "Time [ms],Motor speed [rpm],Torque [mNm]",
        *(f"{t:.0f},{n!r},{m!r}" for t, n, m in zip(stamps, speed.tolist(), torque.tolist(), strict=True)),
    ]
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines)) / "a.csv")
    assert record.period_s == pytest.approx(0.0004, rel=1e-3)
    assert record.rows == 400
    assert "rounded" in said_of(tmp_path)[0]


def test_a_clock_that_begins_again_cuts(tmp_path: Path) -> None:
    lines = rows_of(text(rows=100))
    out = imported(tmp_path, "a.csv", "\n".join([*lines, *lines[1:]]))
    assert read_motion_record(out / "a_2.csv").rows == 100
    assert said_of(tmp_path) == ["time begins again in row 102: cut there"]


def test_signals_with_rates_of_their_own_come_to_the_slowest(tmp_path: Path) -> None:
    lines = rows_of(text())
    sparse = [lines[0], *(line if k % 4 == 0 else line.rpartition(",")[0] + "," for k, line in enumerate(lines[1:]))]
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(sparse)) / "a.csv")
    assert record.period_s == 0.02
    np.testing.assert_allclose(record.recorded("torque_Nm"), run()[2][::4], atol=1e-9)
    assert "rates of their own" in said_of(tmp_path)[0]


def test_empty_cells_are_no_rate_of_their_own(tmp_path: Path) -> None:
    lines = rows_of(text())
    holed = [line.rpartition(",")[0] + "," if k in (7, 8, 40) else line for k, line in enumerate(lines)]
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(holed)) / "a.csv")
    assert record.period_s == 0.005
    kept = np.delete(np.arange(record.rows), (6, 7, 39))
    np.testing.assert_allclose(record.recorded("torque_Nm")[kept], run()[2][kept], atol=1e-9)
    assert said_of(tmp_path) == ["3 of torque_Nm's cells hold no number, the first in row 8: filled by straight lines"]


def test_dates_and_times_of_day(tmp_path: Path) -> None:
    lines = rows_of(text())
    for first, stamp in (
        (
            "2024-02-29 23:59:59.000",
            lambda k: f"2024-{'02-29 23:59:' if k < 200 else '03-01 00:00:'}{(59000 + 5 * k) % 60000 / 1000:06.3f}",
        ),
        ("23:59:59,000", lambda k: f"{'23:59' if k < 200 else '00:00'}:{(59000 + 5 * k) % 60000 / 1000:06.3f}"),
    ):
        folder = tmp_path / first.replace(" ", "_").replace(":", "")
        folder.mkdir()
        content = "\n".join([lines[0], *(f"{stamp(k)},{line.partition(',')[2]}" for k, line in enumerate(lines[1:]))])
        out = imported(folder, "a.csv", content, MAP.replace('unit = "ms"', 'unit = "datetime"'))
        record = read_motion_record(out / "a.csv")
        assert (record.period_s, record.rows) == (0.005, 400)


def test_seconds_since_an_epoch_count_from_the_first_row(tmp_path: Path) -> None:
    """A record keeps twelve digits of its time: of a date in ms since 1970 none is left for a step of 5 ms."""
    lines = rows_of(text())
    content = "\n".join([lines[0], *(f"{1_700_000_000_000 + 5 * k},{line.partition(',')[2]}" for k, line in enumerate(lines[1:]))])
    record = read_motion_record(imported(tmp_path, "a.csv", content) / "a.csv")
    assert (record.period_s, record.rows, record.first_time_s) == (0.005, 400, 0.0)


def test_a_wrapped_angle_is_counted_on(tmp_path: Path) -> None:
    time_s, speed, torque = run()
    angle = np.cumsum(speed) * 0.005
    lines = [
        "t,phi,m",
        *(
            f"{t!r},{float(np.degrees(a) % 360.0)!r},{m!r}"
            for t, a, m in zip(time_s.tolist(), angle.tolist(), torque.tolist(), strict=True)
        ),
    ]
    table_map = '[columns.time_s]\nfrom = 1\nunit = "s"\n[columns.motor_angle_rad]\nfrom = 2\nunit = "deg"\n[columns.torque_Nm]\nfrom = 3\nunit = "Nm"\n'
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), table_map) / "a.csv")
    found = record.recorded("motor_angle_rad")
    np.testing.assert_allclose(found - found[0], angle - angle[0], atol=1e-9)
    assert "starts again" in said_of(tmp_path)[0]


def edited(old: str, new: str, table_map: str = MAP) -> str:
    assert old in table_map
    return table_map.replace(old, new, 1)


def cells(row: int, column: int, put: str) -> str:
    """The run with one cell of a row, numbered as in the file, replaced."""
    lines = rows_of(text())
    parts = lines[row - 1].split(",")
    parts[column] = put
    lines[row - 1] = ",".join(parts)
    return "\n".join(lines)


WRONG = [
    (
        "cell",
        cells(17, 1, "fault"),
        MAP,
        'a.csv, row 17, "Motor speed [rpm]": "fault" is not a number: correct it, or leave the cell empty for no number',
    ),
    ("fields", cells(17, 1, "1,2"), MAP, "a.csv, row 17: 4 fields where other rows have 3"),
    (
        "column",
        text(),
        edited('"Torque [mNm]"', '"Torque"'),
        'a.csv: no column "Torque" (did you mean "Torque [mNm]"?): columns are "Time [ms]", "Motor speed [rpm]", "Torque [mNm]": correct from in [columns.torque_Nm] of map.toml',
    ),
    ("number of a column", text(), edited('from = "Torque [mNm]"', "from = 7"), "a.csv: has no column 7 with numbers, but 3 others"),
    (
        "unit of another thing",
        text(),
        edited('unit = "rpm"', 'unit = "mm/s"'),
        'map.toml: columns.motor_speed_rad_s.unit = "mm/s": is the unit of a speed along a line, motor_speed_rad_s is a speed of rotation: use one of "rad/s", "rpm"',
    ),
    ("frequency", text(), edited('unit = "rpm"', 'unit = "1/s"'), "is the unit of another thing, motor_speed_rad_s is a speed of rotation"),
    ("unknown unit", text(), edited('unit = "rpm"', 'unit = "rqm"'), 'unit = "rqm": no unit that is known: use one of "rad/s", "rpm"'),
    (
        "other than in the file",
        text(),
        edited('unit = "rpm"', 'unit = "deg/s"'),
        'a.csv: "Motor speed [rpm]" is in rpm by the file, in deg/s by map.toml: correct unit in [columns.motor_speed_rad_s], or write sure = true there',
    ),
    (
        "time",
        text().replace("[ms]", ""),
        edited(' [ms]"\nunit = "ms"', '"\nunit = "min"'),
        "a.csv: time: steps of 300 s: records have 1e-05 to 1 s",
    ),
    (
        "share",
        text().replace("[mNm]", ""),
        edited(' [mNm]"\nunit = "mNm"', '"\nunit = "%"'),
        'write nominal_torque = "..." with its unit in [machine]',
    ),
    ("counts", text().replace("[rpm]", ""), edited(' [rpm]"\nunit = "rpm"', '"\nunit = "counts/s"'), "write counts_per_turn = 4096"),
    (
        "sign",
        text(),
        edited('unit = "mNm"', 'unit = "mNm"\nsign = -1'),
        "a.csv: torque_Nm slows down while the speed rises and brakes in both directions, as motor_speed_rad_s has it: write sign = 1 in [columns.torque_Nm] of map.toml, or the other",
    ),
    ("no drive", text(), MAP.partition("[columns.torque_Nm]")[0], "map.toml: no drive: write one of [columns.torque_Nm]"),
    (
        "no motion",
        text(),
        edited("columns.motor_speed_rad_s", "columns.temperature_C"),
        "map.toml: no motion: write one of [columns.position_mm]",
    ),
    (
        "no time",
        text(),
        edited("columns.time_s", "columns.command_mm"),
        'map.toml: no time: write [columns.time_s] with from and unit, or with period = "1 ms"',
    ),
    ("unknown column", text(), edited("torque_Nm", "torque_mNm"), "map.toml: columns.torque_mNm: unknown column (did you mean torque_Nm?)"),
    ("two meanings", text(), edited('"Torque [mNm]"', '"Motor speed [rpm]"'), "are from the same column of the file"),
    (
        "number without unit",
        text(),
        MAP + "[machine]\ninertia = 3e-6\n",
        'has no unit: write it as a text with its unit, for example inertia = "21.9 g cm^2"',
    ),
    ("entry", text(), MAP + '[machine]\nledd = "2 mm"\n', "map.toml: machine.ledd: unknown entry (did you mean lead?)"),
    (
        "speed in another unit",
        text().replace("[rpm]", ""),
        edited(' [rpm]"\nunit = "rpm"', '"\nunit = "rad/s"') + '[machine]\ninertia = "30 g cm^2"\n',
        "a.csv: torque_Nm speeds up 0.0987 times the inertia of [machine]: correct unit or scale in [columns.torque_Nm] or [columns.motor_speed_rad_s]",
    ),
    (
        "lead alone",
        text(),
        MAP + '[machine]\nlead = "2 mm"\n',
        "map.toml: machine.ratio: is not stated beside lead: write ratio = 1 for direct drive",
    ),
    (
        "a line without its length",
        text(),
        MAP + '[machine]\ntorque_constant = "40 N/A"\n',
        "map.toml: machine.torque_constant = 40 N/A: counts along a line, and no lead says how far a turn goes: write lead and ratio",
    ),
    (
        "another unit",
        text(),
        MAP + '[machine]\ntorque_constant = "40 V"\n',
        'not a number with a unit that fits: write for example "25.9 mNm/A", or along a line "40 N/A"',
    ),
    ("left open", text(), MAP + '[machine]\nlead = "?"\n', "map.toml: machine.lead: is still to be filled in"),
    (
        "sign of what",
        text(),
        edited('unit = "rpm"', 'unit = "rpm"\nsign = 2'),
        "columns.motor_speed_rad_s.sign = 2: write 1, or -1 where the file counts against",
    ),
    (
        "a counter",
        "\n".join(f"{line},{k}" for k, line in enumerate(rows_of(text()))),
        edited('"Torque [mNm]"', "4"),
        'a.csv: "0": only counts the rows',
    ),
    (
        "ten times too much",
        text(),
        MAP + '[machine]\nnominal_torque = "0.2 mNm"\n',
        "a.csv: torque_Nm: is 24.1 times nominal_torque of [machine] in its middle: correct unit",
    ),
    ("nothing", "", MAP, "a.csv: is empty"),
    ("no table", "hello\nworld\n", MAP, "a.csv: no rows with two or more numbers are found"),
    ("no TOML", text(), "from = = 1", "map.toml: not TOML"),
]


@pytest.mark.parametrize(("content", "table_map", "said"), [one[1:] for one in WRONG], ids=[one[0] for one in WRONG])
def test_what_is_wrong_is_told_in_one_sentence(tmp_path: Path, content: str, table_map: str, said: str) -> None:
    assert said in refused(tmp_path, content, table_map)


def test_two_signals_of_one_motion_must_agree(tmp_path: Path) -> None:
    time_s, speed, torque = run()
    angle = 20.0 + np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1])) * 0.005))
    lines = ["t,n,phi,m", *(",".join(map(repr, row)) for row in np.column_stack([time_s, speed, angle, torque]).tolist())]

    def table_map(sign: int, unit: str) -> str:
        return (
            '[columns.time_s]\nfrom = "t"\nunit = "s"\n[columns.motor_speed_rad_s]\nfrom = "n"\nunit = "rad/s"\n'
            f'[columns.motor_angle_rad]\nfrom = "phi"\nunit = "{unit}"\nsign = {sign}\n[columns.torque_Nm]\nfrom = "m"\nunit = "Nm"\n'
        )

    assert "run against each other: change sign in [columns.motor_angle_rad]" in refused(tmp_path, "\n".join(lines), table_map(-1, "rad"))
    assert (
        "motor_angle_rad moves 0.0175 times as far as motor_speed_rad_s says, as degrees and radians taken for each other would make it: correct from, unit or scale"
        in refused(tmp_path, "\n".join(lines), table_map(1, "deg"))
    )
    assert read_motion_record(imported(tmp_path, "b.csv", "\n".join(lines), table_map(1, "rad")) / "b.csv").rows == 400


def test_a_load_that_is_lowered_is_only_remarked(tmp_path: Path) -> None:
    lines = ["Time [ms],Motor speed [rpm],Torque [mNm]", *(f"{5 * k},{100.0 + 0.1 * (k % 3)},{-3.0 - 0.01 * (k % 5)}" for k in range(300))]
    imported(tmp_path, "a.csv", "\n".join(lines), MAP + '[machine]\ninertia = "20 g cm^2"\n')
    assert "moves one way only" in json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))["remarks"][0]
    # without an inertia nothing shows it
    assert "machine.inertia: is not stated, and the speed does not change enough" in refused(tmp_path, "\n".join(lines), MAP, "b.csv")


def test_files_that_are_named_alike_are_told_apart(tmp_path: Path) -> None:
    for folder in ("slow", "fast"):
        (tmp_path / "raw" / folder).mkdir(parents=True)
        (tmp_path / "raw" / folder / "1.csv").write_text(text(), encoding="utf-8")
    out = of_files(tmp_path, MAP, tmp_path / "raw")
    assert sorted(path.name for path in out.iterdir()) == ["actuator.toml", "fast_1.csv", "slow_1.csv"]
    # a pattern, and nothing overwritten
    said = complaint(run_ema("import", "table", tmp_path / "raw" / "**" / "*.csv", "--map", tmp_path / "map.toml", "-o", out))
    assert "exists already" in said
    assert "no file is named like this" in complaint(
        run_ema("import", "table", tmp_path / "*.xyz", "--map", tmp_path / "map.toml", "-o", out)
    )


def test_inputs_are_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(text(), encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    said = complaint(run_ema("import", "table", tmp_path / "a.csv", "--map", tmp_path / "map.toml", "-o", tmp_path, "--force"))
    assert "is read by this command and would be overwritten" in said
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == text()


def test_a_motor_along_a_line_is_told_by_what_its_data_sheet_says(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    along = ('"40 N/A"', '"32 V s/m"', '"12 N"', '"20 N s/m"')
    m_per_rad = 0.032 / (2.0 * np.pi * 2.0)
    shaft = [40.0 * m_per_rad, 32.0 * m_per_rad, 12.0 * m_per_rad, 20.0 * m_per_rad**2]
    names = ("torque_constant", "back_emf", "friction", "viscous")
    path.write_text(
        MAP + '[machine]\nlead = "32 mm"\nratio = 2\n' + "".join(f"{name} = {value}\n" for name, value in zip(names, along, strict=True))
    )
    assert [read_map(path).machine[name] for name in names] == pytest.approx(shaft, rel=1e-12)


@pytest.mark.parametrize("late_s", [0.02, 0.0123, -0.015])
def test_a_column_of_another_clock_is_moved_to_where_it_belongs(tmp_path: Path, late_s: float) -> None:
    time_s, speed, torque = run()
    late = np.interp(time_s - late_s, time_s, torque)
    lines = ["t,n,m", *(",".join(map(repr, row)) for row in np.column_stack([time_s, speed, late]).tolist())]
    table_map = (
        '[columns.time_s]\nfrom = "t"\nunit = "s"\n[columns.motor_speed_rad_s]\nfrom = "n"\nunit = "rad/s"\n'
        f'[columns.torque_Nm]\nfrom = "m"\nunit = "Nm"\ndelay = "{1e3 * late_s} ms"\n'
    )
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), table_map) / "a.csv")
    assert record.torque_Nm is not None and record.motor_speed_rad_s is not None
    assert record.rows == time_s.size - math.ceil(abs(late_s) / record.period_s - 1e-9)
    # by straight lines there and back: off by what the torque bends in a row
    assert np.max(np.abs(np.interp(record.time_s, time_s, speed) - record.motor_speed_rad_s)) < 1e-6 * np.max(np.abs(speed))
    inside = slice(5, -5)
    off = np.interp(record.time_s, time_s, torque)[inside] - record.torque_Nm[inside]
    assert np.quantile(np.abs(off), 0.95) < 0.02 * np.ptp(torque)


def test_a_stated_layout_is_taken(tmp_path: Path) -> None:
    stated = '[file]\nnames_row = 2\nfirst_row = 4\ndelimiter = "comma"\ndecimal = "point"\nencoding = "utf-8"\n'
    lines = rows_of(text())
    content = "\n".join(["1,2,3", lines[0], "a,b,c", *lines[1:]])
    assert read_motion_record(imported(tmp_path, "a.csv", content, stated + MAP) / "a.csv").rows == 400
    assert "no rows with two or more numbers are found with the delimiter" in refused(
        tmp_path, text(), stated.replace('"comma"', '"bar"') + MAP, "b.csv"
    )


def test_scale_offset_and_a_time_that_is_not_there(tmp_path: Path) -> None:
    found = columns()
    lines = ["n,m", *(f"{n!r},{m!r}" for n, m in zip(found["Motor speed [rpm]"].tolist(), found["Torque [mNm]"].tolist(), strict=True))]
    table_map = '[columns.time_s]\nperiod = "5 ms"\n[columns.motor_speed_rad_s]\nfrom = "n"\nunit = "rpm"\n'
    table_map += (
        '[columns.current_A]\nfrom = "m"\nscale = 0.1\noffset = 0.5\nsign = 1\nunit = "A"\n[machine]\ntorque_constant = "10 mNm/A"\n'
    )
    record = read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), table_map) / "a.csv")
    assert record.period_s == 0.005
    np.testing.assert_allclose(record.recorded("current_A"), 100.0 * run()[2] + 0.5, rtol=1e-9)


def test_plain_names_serve_too(tmp_path: Path) -> None:
    content = text(";", two_rows=True)
    assert read_motion_record(imported(tmp_path, "a.csv", content, PLAIN_MAP) / "a.csv").rows == 400


def test_columns_without_a_name_are_taken_by_their_number_in_the_file(tmp_path: Path) -> None:
    beside = ["Record Length,400", "Source,CH1", *[","] * 398]
    lines = [f"{first},,{line}" for first, line in zip(beside, rows_of(text())[1:], strict=True)]
    table_map = MAP.replace('"Time [ms]"', "4").replace('"Motor speed [rpm]"', "5").replace('"Torque [mNm]"', "6")
    out = imported(tmp_path, "scope.csv", "\n".join(lines), table_map)
    np.testing.assert_allclose(read_motion_record(out / "scope.csv").recorded("torque_Nm"), run()[2], atol=1e-12)
    ran = run_ema("import", "draft", tmp_path / "scope.csv", "-o", tmp_path / "draft.toml")
    assert ran.code == 0, ran.err
    # nothing says what they are, but one rises as a clock does
    assert "[columns.time_s]\nfrom = 4  # guessed by it rises by the same step" in (tmp_path / "draft.toml").read_text(encoding="utf-8")


def test_a_voltage_and_the_motor_s_data_are_a_drive(tmp_path: Path) -> None:
    time_s, speed, torque = run()
    volts = 2.0 * torque / 0.03 + 0.03 * speed
    lines = ["t,n,u", *(",".join(map(repr, row)) for row in np.column_stack([time_s, speed, volts]).tolist())]
    table_map = '[columns.time_s]\nfrom = "t"\nunit = "s"\n[columns.motor_speed_rad_s]\nfrom = "n"\nunit = "rad/s"\n[columns.voltage_V]\nfrom = "u"\nunit = "V"\n'
    assert "map.toml: machine.torque_constant: a voltage is a drive with the motor's data alone" in refused(
        tmp_path, "\n".join(lines), table_map
    )
    motor = '[machine]\ntorque_constant = "30 mNm/A"\nback_emf = "30 mV s/rad"\nresistance = "2 ohm"\n'
    out = imported(tmp_path, "a.csv", "\n".join(lines), table_map + motor)
    assert read_motion_record(out / "a.csv").present == ("motor_speed_rad_s", "voltage_V")
    actuator = read_actuator(out / "actuator.toml", complete=False)
    assert actuator["screw.csj_Nm"] == pytest.approx(FRICTION, rel=0.05)
    assert actuator["motor.resistance_ohm"] == 2.0


REFERENCE_MAP = """
[columns.time_s]
from = "time_s"
unit = "s"
[columns.{motion}]
from = "{motion}"
unit = "{unit}"
[columns.current_A]
from = "current_A"
unit = "A"
sign = {sign}
[machine]
lead = "5 mm"
ratio = 4
inertia = "600 g cm^2"
torque_constant = "61.2 mNm/A"
"""


@pytest.mark.parametrize("command", ["chirp", "multisine", "triangle", "trapezoid"])
@pytest.mark.parametrize("load_Nm", [-0.15, 0.05])
def test_no_sign_is_doubted_that_is_right_and_each_that_is_wrong_is_told(tmp_path: Path, command: str, load_Nm: float) -> None:
    machine = reference_actuator().changed({"screw.load_torque_Nm": load_Nm})
    noise = {"position_mm": 0.003, "motor_position_mm": 0.003, "current_A": 0.03}
    record = simulate_record(machine, make_command(command, machine), 64, noise, 2)
    write_motion_record(tmp_path / "a.csv", of_controlled(record))
    for motion, unit in (("motor_position_mm", "mm"), ("position_mm", "mm"), ("speed_mm_s", "mm/s")):
        (tmp_path / "map.toml").write_text(REFERENCE_MAP.format(motion=motion, unit=unit, sign=1), encoding="utf-8")
        ran = run_ema("import", "table", tmp_path / "a.csv", "--map", tmp_path / "map.toml", "-o", tmp_path / motion)
        assert ran.code == 0, ran.err
        (tmp_path / "map.toml").write_text(REFERENCE_MAP.format(motion=motion, unit=unit, sign=-1), encoding="utf-8")
        said = complaint(run_ema("import", "table", tmp_path / "a.csv", "--map", tmp_path / "map.toml", "-o", tmp_path / "wrong"))
        assert "write sign = 1 in [columns.current_A] of map.toml" in said


def test_results_are_read_back_as_their_types(tmp_path: Path) -> None:
    imported(tmp_path, "a.csv", text())
    found = read_result(tmp_path / "i.json")
    assert isinstance(found, TableImportResult)
    assert found.files[0].records[0].columns == ("motor_speed_rad_s", "torque_Nm")
    assert run_ema("import", "draft", tmp_path / "a.csv", "-o", tmp_path / "d.toml", "--json", tmp_path / "d.json").code == 0
    draft = read_result(tmp_path / "d.json")
    assert isinstance(draft, DraftResult)
    assert draft.open == ("machine.inertia",)


def test_the_other_commands_load_none_of_the_readers() -> None:
    said = "import sys; import ema_tools.cli; print([name for name in ('pandas', 'pint', 'scipy', 'pyarrow') if name in sys.modules])"
    ran = subprocess.run(
        [sys.executable, "-c", said], capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": str(ROOT / "tools")}
    )
    assert ran.stdout.strip() == "[]"
    heavy = "import sys; from ema_tools.data.records import read_record; read_record(sys.argv[1]); print([name for name in ('pandas', 'pint') if name in sys.modules])"
    ran = subprocess.run(
        [sys.executable, "-c", heavy, RECORDINGS / "healthy.csv"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": str(ROOT / "tools")},
    )
    assert ran.stdout.strip() == "[]"


@pytest.mark.parametrize("odd", [0, 1, 2])
def test_one_file_of_another_sign_is_named(tmp_path: Path, odd: int) -> None:
    """Most of the rows go along with the motion; the file that does not is told by itself."""
    time_s = 0.002 * np.arange(3000)
    files = []
    for number in range(3):
        speed = (30.0 + 10.0 * number) * np.sin(2.0 * np.pi * (0.5 + 0.3 * number) * time_s)
        torque = (1e-5 * np.gradient(speed, 0.002) + 2e-3 * np.sign(speed)) * (-1.0 if number == odd else 1.0)
        files.append(tmp_path / f"{number}.csv")
        lines = [",".join(map(repr, row)) for row in np.column_stack([1e3 * time_s, speed / RPM, 1e3 * torque]).tolist()]
        files[-1].write_text("\n".join(["Time [ms],Motor speed [rpm],Torque [mNm]", *lines]), encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAP, encoding="utf-8")
    said = complaint(run_ema("import", "table", *files, "--map", tmp_path / "map.toml", "-o", tmp_path / "out"))
    assert f"{odd}.csv: torque_Nm goes against motor_speed_rad_s, unlike the other records" in said
    assert "with the other sign in [columns.torque_Nm] than in map.toml" in said
    assert not (tmp_path / "out").exists()
    of_files(tmp_path, MAP, *(file for number, file in enumerate(files) if number != odd))


@pytest.mark.parametrize("several", [False, True], ids=["one frequency", "a sweep"])
def test_a_spring_that_outweighs_the_inertia_is_no_wrong_sign(tmp_path: Path, several: bool) -> None:
    time_s = 0.002 * np.arange(2000)
    rate = 2.0 * np.pi * (1.0 + (1.5 if several else 0.0) * time_s / time_s[-1])
    phase = np.concatenate(([0.0], np.cumsum(rate[1:] * 0.002)))
    angle = 3.0 * np.sin(phase)
    speed = np.gradient(angle, 0.002)
    torque = 1e-6 * np.gradient(speed, 0.002) + 0.02 * angle + 2e-3 * np.sign(speed)
    lines = ["Time [ms],Motor speed [rpm],Torque [mNm]"]
    lines += [",".join(map(repr, row)) for row in np.column_stack([1e3 * time_s, speed / RPM, 1e3 * torque]).tolist()]
    table_map = MAP + '[machine]\ninertia = "10 g cm^2"\n'
    assert read_motion_record(imported(tmp_path, "a.csv", "\n".join(lines), table_map) / "a.csv").rows == 2000
    said = refused(tmp_path, "\n".join(lines), edited('unit = "mNm"', 'unit = "mNm"\nsign = -1', table_map), "b.csv")
    assert "write sign = 1 in [columns.torque_Nm]" in said
    # nor is it taken for an inertia that nobody stated: a sweep tells the two, one frequency cannot
    if several:
        (tmp_path / "i.json").unlink()
        actuator = read_actuator(imported(tmp_path, "c.csv", "\n".join(lines), MAP) / "actuator.toml", complete=False)
        assert actuator["screw.inertia_kgm2"] == pytest.approx(1e-6, rel=0.05)
    else:
        assert "machine.inertia: is not stated, and the speed does not change enough" in refused(tmp_path, "\n".join(lines), MAP, "c.csv")


def test_units_that_names_end_with_are_guessed(tmp_path: Path) -> None:
    rows = "".join(
        f"{k},{np.sin(0.01 * k):.5f},{np.cos(0.01 * k):.5f},{0.1 * np.cos(0.01 * k):.6f},{np.sin(0.02 * k):.5f}\n" for k in range(300)
    )
    (tmp_path / "log.csv").write_text("t_ms,q_deg,w_rads,T_Nm,axis_A\n" + rows)
    assert run_ema("import", "draft", tmp_path, "-o", tmp_path / "map.toml").code == 0
    columns = tomllib.loads((tmp_path / "map.toml").read_text())["columns"]
    assert {name: (one["from"], one["unit"]) for name, one in columns.items()} == {
        "time_s": ("t_ms", "ms"),
        "motor_angle_rad": ("q_deg", "deg"),
        "motor_speed_rad_s": ("w_rads", "rads"),
        "torque_Nm": ("T_Nm", "Nm"),
        "current_A": ("axis_A", "A"),
    }


def test_time_that_falls_is_said(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time_s,motor_speed_rad_s,torque_Nm\n" + "".join(f"{-0.01 * k:.2f},{k},0.1\n" for k in range(50)))
    (tmp_path / "map.toml").write_text(
        "".join(
            f'[columns.{name}]\nfrom = "{name}"\nunit = "{unit}"\n'
            for name, unit in (("time_s", "s"), ("motor_speed_rad_s", "rad/s"), ("torque_Nm", "Nm"))
        )
    )
    ran = run_ema("import", "table", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "-o", tmp_path / "out")
    assert "time falls from row to row: write the rows in the order of time" in complaint(ran)


def test_a_torque_in_the_place_of_a_speed_contradicts_the_angle(tmp_path: Path) -> None:
    time = 0.002 * np.arange(4000)
    angle, speed = 20.0 * np.sin(1.3 * time), 26.0 * np.cos(1.3 * time)
    torque = 0.02 * np.sign(speed) + 1e-4 * speed
    rows = "".join(f"{t:.3f},{a:.5f},{m:.6f},{w:.5f}\n" for t, a, w, m in zip(time, angle, speed, torque, strict=True))
    (tmp_path / "log.csv").write_text("t,angle,w,T\n" + rows)
    names = (("time_s", "t", "s"), ("motor_angle_rad", "angle", "rad"), ("motor_speed_rad_s", "w", "rad/s"), ("torque_Nm", "T", "N m"))
    (tmp_path / "map.toml").write_text("".join(f'[columns.{name}]\nfrom = "{of}"\nunit = "{unit}"\n' for name, of, unit in names))
    ran = run_ema("import", "table", tmp_path / "log.csv", "--map", tmp_path / "map.toml", "-o", tmp_path / "out")
    said = complaint(ran)
    assert "motor_angle_rad moves" in said and "times as far as motor_speed_rad_s says: correct from, unit or scale" in said


def test_a_copy_of_a_record_is_said_where_it_comes_in(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(text(), encoding="utf-8")
    of_files(tmp_path, MAP, tmp_path / "a.csv", tmp_path / "b.csv")
    first, second = (one["remarks"] for one in json.loads((tmp_path / "i.json").read_text(encoding="utf-8"))["files"])
    assert not first
    assert second == ["the same samples came as a.csv, too: one of the two is enough, and a diagnosis refuses both together"]
