"""`ema_identify` reads what the format allows, says what the module found, and its answer depends on nothing else."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path

import pytest

import bad_input
from host_program import PROGRAM, ROOT, run
from support import run_ema

pytestmark = [pytest.mark.host, PROGRAM]

RECORDING = ROOT / "recordings" / "case_a.csv"
# What may differ between two runs that found the same.
_OF_THE_RUN = ("record", "wall_s", "search_s")


def identify(folder: Path, *arguments: str) -> dict[str, object]:
    """The JSON result without what belongs to the run alone."""
    answer = run(folder, "--json", "result.json", "--force", *arguments)
    assert (answer.returncode, answer.stderr) == (0, b"")
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return {key: value for key, value in result.items() if key not in _OF_THE_RUN}


@pytest.fixture(scope="session")
def plain(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    """The result of the shipped recording as it is."""
    return identify(tmp_path_factory.mktemp("plain"), str(RECORDING))


def _columns(order: list[str], quote: str) -> bytes:
    """The shipped recording with its columns in another order, one more of text, and every field quoted."""
    lines = [line for line in RECORDING.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    places = [names.index(name) for name in order]
    written = []
    for number, line in enumerate(lines):
        fields = line.split(",")
        extra = "note" if number == 0 else f"row {number}, fine" if quote else "fine"
        written.append(",".join(f"{quote}{value}{quote}" for value in [*(fields[place] for place in places), extra]))
    return ("\n".join(written) + "\n").encode()


VARIANTS = {
    "byte_order_mark": lambda: b"\xef\xbb\xbf" + RECORDING.read_bytes(),
    "crlf": lambda: RECORDING.read_bytes().replace(b"\n", b"\r\n"),
    "comments_and_blank_lines": lambda: RECORDING.read_bytes().replace(b"\n0.5,", b"\n\n# half a second, and a comma\n  \n0.5,"),
    "no_last_line_end": lambda: RECORDING.read_bytes().rstrip(b"\n"),
    "order_and_quotes": lambda: _columns(["position_mm", "voltage_V", "time_s", "command_mm"], '"'),
    "required_columns_and_text": lambda: _columns(["command_mm", "time_s", "position_mm"], ""),
    "blanks_around_numbers": lambda: RECORDING.read_bytes().replace(b",", b" ,\t"),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_what_the_format_allows_changes_nothing(tmp_path: Path, plain: dict[str, object], name: str) -> None:
    (tmp_path / "rec.csv").write_bytes(VARIANTS[name]())
    assert identify(tmp_path, "rec.csv") == plain


@pytest.mark.parametrize("steps", ["1", "777", "1000000000"])
def test_slices_change_nothing(tmp_path: Path, plain: dict[str, object], steps: str) -> None:
    assert identify(tmp_path, "--slice", steps, str(RECORDING)) == plain


def test_the_reference_written_out_changes_nothing(tmp_path: Path, plain: dict[str, object]) -> None:
    (tmp_path / "act.txt").write_bytes(
        b"\xef\xbb\xbf# as built\r\nscrew.csj_Nm = 0.138 # Nm\r\n\r\n drive.mode=voltage\ncontrol.every_steps = 1\nscrew.blk_mm = 0.033"
    )
    assert identify(tmp_path, "--config", "act.txt", str(RECORDING)) == plain
    assert identify(tmp_path, "--reference", "--seed", str(plain["seed"]), "--", str(RECORDING)) == plain


def test_another_actuator_is_another_answer(tmp_path: Path, plain: dict[str, object]) -> None:
    (tmp_path / "act.txt").write_text(
        "screw.csj_Nm = 0.15\nscrew.blk_mm = 0.0375\neffects.constant_load.torque_Nm = 0.001\n", encoding="utf-8"
    )
    found = identify(tmp_path, "--config", "act.txt", str(RECORDING))
    assert found["csj_Nm"]["healthy"] == 0.15
    assert found["blk_mm"]["healthy"] == 0.0375
    assert found["csj_Nm"]["shift_percent"] == pytest.approx(100.0, abs=1.0)
    assert found["objective_after_mm2s"] > plain["objective_after_mm2s"]


def test_the_shipped_case(plain: dict[str, object]) -> None:
    """Case A has CSJ 0.3 Nm for a healthy 0.138 and BLK 0.04125 mm for 0.033."""
    assert plain["verdict"] == "fault"
    assert plain["adequate"] is True
    assert plain["reasons"] == []
    assert plain["outcome"] == "tolerance"
    assert plain["rows"] == 10000
    assert plain["csj_Nm"]["shift_percent"] == pytest.approx(100.0 * (0.3 / 0.138 - 1.0), abs=0.05)
    # as shipped, so that the page knows from where on a shift is called a fault
    assert (plain["csj_Nm"]["threshold_percent"], plain["blk_mm"]["threshold_percent"]) == (5.0, 10.0)
    assert plain["blk_mm"]["shift_percent"] == pytest.approx(25.0, abs=0.5)
    assert plain["objective_before_mm2s"] == pytest.approx(0.674, abs=0.002)
    assert plain["objective_after_mm2s"] < 1e-6
    for fault in (plain["csj_Nm"], plain["blk_mm"]):
        half = 1.96 * math.hypot(fault["std"], fault["bias"])
        assert fault["interval95"] == pytest.approx([fault["estimate"] - half, fault["estimate"] + half], rel=1e-6)


def test_the_text_says_it_first(tmp_path: Path) -> None:
    answer = run(tmp_path, str(RECORDING))
    lines = answer.stdout.decode().splitlines()
    assert lines[0] == "CSJ +117.4 %, BLK +25.0 %: fault, CSJ beyond its threshold of +5 % and BLK beyond its threshold of +10 %."
    assert any("40 to 75 s" in line for line in lines)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_only_what_is_surely_a_fault_is_called_one(tmp_path: Path) -> None:
    """Under a slow chirp the rod does not tell friction from what the inverter loses: beside a play that has grown, half a volt of that is no fault of the friction."""
    noise = ("--noise", "position_mm=0.002,motor_position_mm=0.002,current_A=0.03,voltage_V=0.02")
    sheet, command = ROOT / "actuators" / "reference.toml", "chirp:amplitude_mm=3,start_hz=0.1,end_hz=2,duration_s=10"

    def recorded(name: str, seed: int, *changes: str) -> Path:
        sets = [text for change in changes for text in ("--set", change)]
        path = tmp_path / f"{name}.csv"
        assert run_ema("simulate", sheet, "--command", command, *noise, "--seed", seed, *sets, "-o", path).code == 0
        return path

    healthy = [recorded(f"h{seed}", seed, f"screw.csj_Nm={csj}") for seed, csj in ((1, 0.1435), (2, 0.1441), (3, 0.1438))]
    today = recorded("today", 9, "screw.csj_Nm=0.1438", "screw.blk_mm=0.0495", "effects.inverter_dead_time.drop_V=0.5")
    unit, flat = tmp_path / "unit.toml", tmp_path / "unit.txt"
    assert run_ema("calibrate", sheet, *healthy, "-o", unit).code == 0
    assert run_ema("export", unit, "-o", tmp_path / "unit.h", "--flat", flat).code == 0
    lines = run(tmp_path, "--config", str(flat), str(today)).stdout.decode().splitlines()
    assert ": fault, BLK beyond its threshold of " in lines[0] and lines[0].endswith("; whether CSJ is one too is not sure."), lines[0]


def test_sixteen_bits_find_the_same_within_their_resolution(tmp_path: Path, plain: dict[str, object]) -> None:
    found = identify(tmp_path, "--int16", str(RECORDING))
    assert found["record_format"] == "int16"
    assert found["csj_Nm"]["shift_percent"] == pytest.approx(plain["csj_Nm"]["shift_percent"], abs=0.02)
    assert found["blk_mm"]["shift_percent"] == pytest.approx(plain["blk_mm"]["shift_percent"], abs=0.2)
    assert found["residual_rms_mm"] > plain["residual_rms_mm"]


def test_the_scale_of_the_integers_is_the_targets(tmp_path: Path, plain: dict[str, object]) -> None:
    """A finer scale leaves less of the rounding in the residual than that of the travel."""
    coarse = identify(tmp_path, "--int16", str(RECORDING))
    fine = identify(tmp_path, "--int16", "--full-scale", "4", str(RECORDING))
    assert plain["residual_rms_mm"] < fine["residual_rms_mm"] < 0.3 * coarse["residual_rms_mm"]


def test_a_jammed_rod_is_no_bad_input(tmp_path: Path) -> None:
    """The rod rests at zero: no verdict of health, and the reasons say why."""
    lines = [line.split(",") for line in RECORDING.read_text(encoding="utf-8").splitlines() if line[:1].isdigit()]
    (tmp_path / "rec.csv").write_text("time_s,command_mm,position_mm\n" + "".join(f"{t},{c},0\n" for t, c, *_ in lines), encoding="utf-8")
    answer = run(tmp_path, "--json", "result.json", "rec.csv")
    assert answer.returncode == 0
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert result["verdict"] != "healthy"
    if result["verdict"] == "undecided":
        assert answer.stdout.startswith(b"Undecided, no fault is reported: ")
        assert result["reasons"]


def test_what_is_not_determined_has_no_standard_error(tmp_path: Path) -> None:
    lines = [line.split(",") for line in RECORDING.read_text(encoding="utf-8").splitlines() if line[:1].isdigit()]
    (tmp_path / "rec.csv").write_text(
        "time_s,command_mm,position_mm\n" + "".join(f"{t},{0.014 * float(c)},0\n" for t, c, *_ in lines), encoding="utf-8"
    )
    answer = run(tmp_path, "--json", "result.json", "rec.csv")
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert "the record does not determine the parameters" in result["reasons"]
    assert result["csj_Nm"]["std"] is None and result["blk_mm"]["std"] is None
    assert result["csj_Nm"]["interval95"] == [None, None]
    rows = [line.split() for line in answer.stdout.decode().splitlines() if line.startswith(("CSJ  Nm", "BLK  mm"))]
    assert [row[3] for row in rows] == ["-", "-"]


def test_force_replaces_a_result(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("x" * 100000, encoding="utf-8")
    identify(tmp_path, str(RECORDING))


def test_help(tmp_path: Path) -> None:
    answer = run(tmp_path, "--help")
    assert answer.returncode == 0
    assert answer.stdout.startswith(b"usage: ema_identify ")


def test_a_healthy_actuator(tmp_path: Path) -> None:
    answer = run(tmp_path, str(ROOT / "recordings" / "healthy.csv"))
    first = answer.stdout.decode().splitlines()[0]
    assert first.endswith(" %: healthy, both within their thresholds of 5 % and 10 %.")
    assert b"verdict     healthy; the model explains the recording\n" in answer.stdout


def test_a_search_that_is_cut_short(tmp_path: Path) -> None:
    """With ten model runs nothing is known, and the program says so."""
    (tmp_path / "act.txt").write_text("search.evaluation_budget = 10\n", encoding="utf-8")
    answer = run(tmp_path, "--config", "act.txt", "--json", "result.json", str(RECORDING))
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert answer.returncode == 0
    assert answer.stdout.startswith(b"Undecided, no fault is reported: ")
    assert result["verdict"] == "undecided"
    assert result["outcome"] == "budget"
    assert "the evaluations were used up while the cost still fell" in result["reasons"]
    for reason in result["reasons"]:
        assert f"  because   {reason}\n".encode() in answer.stdout


def test_names_with_quotes_and_line_ends(tmp_path: Path) -> None:
    name = 'a "b"\\\n\u00e9\x01.csv'
    (tmp_path / name).write_bytes(RECORDING.read_bytes())
    answer = run(tmp_path, "--json", "result.json", name)
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["record"] == name
    assert 'recording   a "b"\\?\u00e9?.csv: 10000 rows' in answer.stdout.decode()


@pytest.mark.skipif(sys.platform != "linux", reason="needs the device that is always full")
def test_a_full_disk(tmp_path: Path) -> None:
    (tmp_path / "result.json").symlink_to("/dev/full")
    answer = run(tmp_path, "--json", "result.json", "--force", str(RECORDING))
    assert answer.returncode == 1
    assert answer.stderr == b"result.json: the file could not be written to its end; check that there is room on the disk\n"


def test_a_run_that_fails_leaves_results_alone(tmp_path: Path) -> None:
    """--force or not."""
    (tmp_path / "result.json").write_text("mine", encoding="utf-8")
    (tmp_path / "rec.csv").write_bytes(bad_input.with_row(40, "0.04,x,1"))
    assert run(tmp_path, "--json", "result.json", "--force", "rec.csv").returncode == 1
    assert (tmp_path / "result.json").read_text(encoding="utf-8") == "mine"
