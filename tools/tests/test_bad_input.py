"""`ema_identify` refuses every bad input of the table with its one line and exit code, and reads what the format allows."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path

import bad_input
import pytest
from bad_input import CASES, PAGE, Case
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

pytestmark = pytest.mark.host

ROOT = Path(__file__).resolve().parents[2]
RECORDING = ROOT / "recordings" / "case_a.csv"
# What may differ between two runs that found the same.
_OF_THE_RUN = ("record", "wall_s", "search_s")


@pytest.fixture(scope="session")
def program() -> Path:
    """The built program: in $EMA_BIN_DIR, else in build/bin."""
    folder = os.environ.get("EMA_BIN_DIR")
    path = (Path(folder) if folder else ROOT / "build" / "bin") / "ema_identify"
    if not path.exists():
        if folder:
            pytest.fail(f"{path} is not there: build the target ema_identify")
        pytest.skip("ema_identify is not built; build it or set EMA_BIN_DIR")
    return path


def run(program: Path, folder: Path, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """Runs the program in `folder`."""
    return subprocess.run([program, *arguments], cwd=folder, capture_output=True, timeout=120, check=False)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.what.replace(" ", "_"))
def test_bad_input(program: Path, tmp_path: Path, case: Case) -> None:
    for name, content in case.files.items():
        (tmp_path / name).write_bytes(content())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    answer = run(program, tmp_path, *case.arguments)
    assert answer.stderr.decode() == case.message + "\n"
    assert answer.returncode == case.exit_code
    if not case.message.startswith("none/new.json"):
        assert answer.stdout == b""
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_page_is_made_from_the_table() -> None:
    assert PAGE.read_text(encoding="utf-8") == bad_input.page(), "run: python tools/tests/bad_input.py"


def identify(program: Path, folder: Path, *arguments: str) -> dict[str, object]:
    """The JSON result without what belongs to the run alone."""
    answer = run(program, folder, "--json", "result.json", "--force", *arguments)
    assert (answer.returncode, answer.stderr) == (0, b"")
    result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    return {key: value for key, value in result.items() if key not in _OF_THE_RUN}


@pytest.fixture(scope="session")
def plain(program: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    """The result of the shipped recording as it is."""
    return identify(program, tmp_path_factory.mktemp("plain"), str(RECORDING))


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
def test_what_the_format_allows_changes_nothing(program: Path, tmp_path: Path, plain: dict[str, object], name: str) -> None:
    (tmp_path / "rec.csv").write_bytes(VARIANTS[name]())
    assert identify(program, tmp_path, "rec.csv") == plain


@pytest.mark.parametrize("steps", ["1", "777", "1000000000"])
def test_slices_change_nothing(program: Path, tmp_path: Path, plain: dict[str, object], steps: str) -> None:
    assert identify(program, tmp_path, "--slice", steps, str(RECORDING)) == plain


def test_the_reference_written_out_changes_nothing(program: Path, tmp_path: Path, plain: dict[str, object]) -> None:
    (tmp_path / "act.txt").write_bytes(b"\xef\xbb\xbf# as built\r\nscrew.csj_Nm = 0.138 # Nm\r\n\r\n drive.mode=voltage\ncontrol.every_steps = 1\nscrew.blk_mm = 0.033")
    assert identify(program, tmp_path, "--config", "act.txt", str(RECORDING)) == plain
    assert identify(program, tmp_path, "--reference", "--seed", str(plain["seed"]), "--", str(RECORDING)) == plain


def test_another_actuator_is_another_answer(program: Path, tmp_path: Path, plain: dict[str, object]) -> None:
    (tmp_path / "act.txt").write_text("screw.csj_Nm = 0.15\nscrew.blk_mm = 0.0375\neffects.constant_load.torque_Nm = 0.001\n", encoding="utf-8")
    found = identify(program, tmp_path, "--config", "act.txt", str(RECORDING))
    assert found["csj_Nm"]["healthy"] == 0.15
    assert found["blk_mm"]["healthy"] == 0.0375
    assert found["csj_Nm"]["shift_percent"] == pytest.approx(100.0, abs=1.0)
    assert found["objective_after_mm2s"] > plain["objective_after_mm2s"]


def test_the_shipped_case(program: Path, plain: dict[str, object]) -> None:
    """Case A has CSJ 0.3 Nm for a healthy 0.138 and BLK 0.04125 mm for 0.033."""
    assert plain["verdict"] == "fault"
    assert plain["adequate"] is True
    assert plain["reasons"] == []
    assert plain["outcome"] == "tolerance"
    assert plain["rows"] == 10000
    assert plain["csj_Nm"]["shift_percent"] == pytest.approx(100.0 * (0.3 / 0.138 - 1.0), abs=0.05)
    assert plain["blk_mm"]["shift_percent"] == pytest.approx(25.0, abs=0.5)
    assert plain["objective_before_mm2s"] == pytest.approx(0.674, abs=0.002)
    assert plain["objective_after_mm2s"] < 1e-6


def test_the_text_says_it_first(program: Path, tmp_path: Path) -> None:
    answer = run(program, tmp_path, str(RECORDING))
    lines = answer.stdout.decode().splitlines()
    assert lines[0] == "CSJ +117.4 %, BLK +25.0 %: fault, CSJ beyond its threshold of +5 % and BLK beyond its threshold of +10 %."
    assert any("40 to 75 s" in line for line in lines)
    assert not list(tmp_path.iterdir())


def test_sixteen_bits_find_the_same_within_their_resolution(program: Path, tmp_path: Path, plain: dict[str, object]) -> None:
    found = identify(program, tmp_path, "--int16", str(RECORDING))
    assert found["record_format"] == "int16"
    assert found["csj_Nm"]["shift_percent"] == pytest.approx(plain["csj_Nm"]["shift_percent"], abs=0.02)
    assert found["blk_mm"]["shift_percent"] == pytest.approx(plain["blk_mm"]["shift_percent"], abs=0.2)
    assert found["residual_rms_mm"] > plain["residual_rms_mm"]


def test_a_jammed_rod_is_no_bad_input(program: Path, tmp_path: Path) -> None:
    """The rod rests at zero: no verdict of health, and the reasons say why."""
    lines = [line.split(",") for line in RECORDING.read_text(encoding="utf-8").splitlines() if line[:1].isdigit()]
    (tmp_path / "rec.csv").write_text("time_s,command_mm,position_mm\n" + "".join(f"{t},{c},0\n" for t, c, *_ in lines), encoding="utf-8")
    answer = run(program, tmp_path, "--json", "result.json", "rec.csv")
    assert answer.returncode == 0
    result = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert result["verdict"] != "healthy"
    if result["verdict"] == "undecided":
        assert answer.stdout.startswith(b"Undecided, no fault is reported: ")
        assert result["reasons"]


def test_force_replaces_a_result(program: Path, tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("x" * 100000, encoding="utf-8")
    identify(program, tmp_path, str(RECORDING))


def test_help(program: Path, tmp_path: Path) -> None:
    answer = run(program, tmp_path, "--help")
    assert answer.returncode == 0
    assert answer.stdout.startswith(b"usage: ema_identify ")


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(edits=st.lists(st.tuples(st.integers(0, 4000), st.binary(min_size=0, max_size=6)), min_size=1, max_size=4))
def test_broken_bytes_are_read_or_refused_in_one_line(program: Path, tmp_path: Path, edits: list[tuple[int, bytes]]) -> None:
    content = bytearray(bad_input.text(bad_input.rows()))
    for place, put in edits:
        content[place : place + len(put)] = put
    (tmp_path / "rec.csv").write_bytes(content)
    answer = run(program, tmp_path, "rec.csv")
    message = answer.stderr.decode()
    if answer.returncode == 0:
        assert message == ""
    else:
        assert answer.returncode == 1
        assert answer.stdout == b""
        assert message.startswith("rec.csv: ")
        assert message.count("\n") == 1
