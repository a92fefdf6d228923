"""What surrounds a command: names that are not UTF-8, pipes, a closed output, Ctrl-C."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest
from scipy.io import savemat

from ema_tools.data.actuator import read_actuator
from ema_tools.data.records import COLUMNS, read_record
from ema_tools.library.definitions import library_folder
from support import RECORDINGS, REFERENCE, ROOT, complaint, run_ema

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT / "tools")}
# A byte that is no UTF-8, as the system hands it over and as it is shown.
ODD, SHOWN = "a\udcffb", r"a\xffb"

pytestmark = pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="needs names of any bytes, and /proc")


def ema(*arguments: object, folder: Path, **how: object) -> subprocess.CompletedProcess[bytes]:
    """The command in a process of its own."""
    command = [sys.executable, "-m", "ema_tools", *(str(argument) for argument in arguments)]
    return subprocess.run(command, cwd=folder, env=ENVIRONMENT, check=False, **how)  # type: ignore[call-overload]


def short(path: Path, rows: int = 1500) -> Path:
    """The begin of a recording, at `path`."""
    lines = (RECORDINGS / "case_a_noisy.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[: rows + 8]), encoding="utf-8")
    return path


@pytest.mark.slow
def test_every_command_takes_a_name_that_is_not_utf8(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    actuator, record = f"{ODD}.toml", f"{ODD}.csv"
    Path(actuator).write_bytes(REFERENCE.read_bytes())
    Path(record).write_bytes((RECORDINGS / "healthy.csv").read_bytes())
    read_actuator(actuator).changed({}, {"name": ""}).write(actuator, force=True)
    for arguments in (
        ("simulate", actuator, "--command", record, "-o", f"s{ODD}.csv", "--json", f"s{ODD}.json"),
        ("compare", actuator, record, "--json", f"c{ODD}.json"),
        ("calibrate", actuator, record, "-o", f"k{ODD}.toml", "--json", f"k{ODD}.json", "--balances-only"),
        ("identify", f"k{ODD}.toml", record, "--fitted", f"i{ODD}.toml", "--json", f"i{ODD}.json"),
        ("add", actuator, "winding_heating", "--set", "rise_degC=30", "-o", f"w{ODD}.toml", "--json", f"w{ODD}.json"),
        ("export", actuator, "-o", f"{ODD}.h", "--flat", f"{ODD}.txt", "--json", f"e{ODD}.json"),
        ("report", f"i{ODD}.json", f"c{ODD}.json", "-o", f"{ODD}.html", "--json", f"r{ODD}.json"),
        ("effects", "spring_load", "--json", f"{ODD}.json"),
    ):
        ran = run_ema(*arguments)
        assert ran.code == 0, ran
        found = Path(arguments[-1] if arguments[-1] != "--balances-only" else arguments[-2])
        text = found.read_text(encoding="utf-8")
        json.loads(text)
        assert r"\udc" not in text
    assert json.loads(Path(f"i{ODD}.json").read_text(encoding="utf-8"))["name"] == f"{SHOWN}.csv"
    assert read_actuator(f"k{ODD}.toml").about["source"].endswith(f"calibrated on {SHOWN}.csv")
    assert SHOWN in Path(f"{ODD}.html").read_text(encoding="utf-8")
    assert complaint(run_ema("compare", f"none{ODD}.toml", record)) == rf"none{SHOWN}.toml: no such file or directory: check the path"
    assert complaint(run_ema("compare", actuator, f"none{ODD}.csv")).startswith("nonea?b.csv: there is no such file")  # the C reader's line


def test_every_format_takes_a_name_that_is_not_utf8(tmp_path: Path) -> None:
    good = read_record(short(tmp_path / "good.csv"))
    columns = {"time_s": good.time_s, **{name: good.recorded(name) for name in good.present}}
    savemat(os.fsencode(tmp_path / "m.mat").decode(), columns)
    (tmp_path / "m.mat").rename(tmp_path / f"{ODD}.mat")
    pyarrow.parquet.write_table(pyarrow.table(columns), tmp_path / "p.parquet")
    (tmp_path / "p.parquet").rename(tmp_path / f"{ODD}.parquet")
    for ending in ("mat", "parquet"):
        record = read_record(tmp_path / f"{ODD}.{ending}", read_actuator(REFERENCE))
        assert record.file == f"{SHOWN}.{ending}"
        assert all(np.array_equal(record.recorded(name), good.recorded(name)) for name in COLUMNS[1:] if name in good.present)


def test_a_name_that_is_not_utf8_reaches_the_terminal(tmp_path: Path) -> None:
    ran = ema("add", REFERENCE, "winding_heating", "--set", "rise_degC=30", "-o", f"{ODD}.toml", folder=tmp_path, capture_output=True)
    assert (ran.returncode, ran.stdout.decode(), ran.stderr) == (0, f"{SHOWN}.toml written\n", b"")


@pytest.mark.slow
def test_a_pipe_is_read_once(tmp_path: Path) -> None:
    path = short(tmp_path / "r.csv")
    expected = ema("compare", REFERENCE, path, folder=tmp_path, capture_output=True)
    with subprocess.Popen(["cat", path], stdout=subprocess.PIPE) as source:
        ran = ema("compare", REFERENCE, "/dev/stdin", folder=tmp_path, stdin=source.stdout, capture_output=True)
    assert ran.returncode == expected.returncode == 0, ran.stderr
    assert ran.stdout.decode().replace("/dev/stdin", str(path)).replace("stdin", "r.csv") == expected.stdout.decode()
    # a file behind /dev/stdin is no pipe
    with path.open("rb") as opened:
        assert ema("compare", REFERENCE, "/dev/stdin", folder=tmp_path, stdin=opened, capture_output=True).returncode == 0


def test_what_is_wrong_in_a_pipe_is_said_of_the_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=lambda: pipe.write_text("time_s,command_mm,position_mm\n0,1\n", encoding="utf-8"))
    writer.start()
    assert complaint(run_ema("compare", REFERENCE, pipe)).startswith(f"{pipe}: row 2, position_mm: 2 fields where the header has 3")
    writer.join()


@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_a_closed_output_is_no_traceback(tmp_path: Path, closed: str) -> None:
    ran = subprocess.run(
        f'"{sys.executable}" -m ema_tools effects {closed}',
        shell=True,
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=ENVIRONMENT,
        check=False,
    )
    assert ran.returncode == (1 if closed.startswith(">") else 0)
    assert ran.stderr == ("ema: standard output: is closed: send it to a file or to /dev/null\n" if closed == ">&-" else "")


@pytest.mark.parametrize("loaded", ["numpy", "libema_desk64"])
def test_ctrl_c_is_one_line_at_any_time(tmp_path: Path, loaded: str) -> None:
    """Interrupted while modules are loaded, and while the command works."""
    launcher = library_folder().parent / "ema"
    # what a shell starts in the background ignores the signal, and so would its children
    heard = ("env", "--default-signal=INT")
    arguments = [*heard, launcher, "simulate", REFERENCE, "--command", "chirp:duration_s=10000", "-o", tmp_path / "r.csv"]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        maps = Path(f"/proc/{process.pid}/maps")
        while loaded not in maps.read_text(encoding="utf-8", errors="replace"):
            assert process.poll() is None
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate()
    assert (process.returncode, out, err) == (130, "", "ema: interrupted\n")
    assert list(tmp_path.iterdir()) == []
