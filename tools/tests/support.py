"""What the tests of the command `ema` share: the project's files, and the command run inside this process."""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.records import Record
from ema_tools.tasks.simulate import simulate_record

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "actuators" / "reference.toml"
RECORDINGS = ROOT / "recordings"
# What the build exports for the example firmware (target `exported`), beside its libraries.
EXPORTED = Path(os.environ.get("EMA_LIBRARY_DIR", ROOT / "build" / "lib")).resolve().parent / "exported"


@dataclass(frozen=True)
class Ran:
    """Exit code and what was printed."""

    code: int
    out: str
    err: str


def run_ema(*arguments: object) -> Ran:
    """The command line `ema` with these arguments."""
    from ema_tools.cli import main

    out, err = io.StringIO(), io.StringIO()
    before = sys.argv
    sys.argv = ["ema", *(str(argument) for argument in arguments)]
    code = 0
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            main()
    except SystemExit as end:
        code = int(end.code or 0)
    finally:
        sys.argv = before
    return Ran(code, out.getvalue(), err.getvalue())


_COMMANDS = """
import contextlib, io, json, sys
from ema_tools.cli import main
printed = []
for command in json.loads(sys.argv[1]):
    sys.argv = ["ema", *command]
    with contextlib.redirect_stdout(io.StringIO()) as out:
        try:
            main()
        except SystemExit as end:
            if end.code:
                raise
    printed.append(out.getvalue())
print(json.dumps(printed))
"""


def ema_elsewhere(commands: Sequence[Sequence[object]], folder: Path, environment: Mapping[str, str]) -> list[str]:
    """What each command prints, in `folder` with other libraries or sources; all in one process, since starting the tools takes as long as most of them."""
    asked = json.dumps([[str(part) for part in command] for command in commands])
    ran = subprocess.run(
        [sys.executable, "-c", _COMMANDS, asked], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=1200
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    printed: list[str] = json.loads(ran.stdout)
    return printed


def complaint(ran: Ran) -> str:
    """The one line of a refused input; fails when it is not exactly that."""
    assert ran.code == 1, ran
    assert ran.out == ""
    lines = ran.err.splitlines()
    assert len(lines) == 1, ran.err
    assert lines[0].startswith("ema: ")
    return lines[0].removeprefix("ema: ")


def emps_path() -> Path:
    """EMPS's measured data, or the test is skipped."""
    shared = Path(os.environ.get("EMA_SHARED", ROOT.parent / "shared"))
    path = shared / "measurements" / "emps" / "DATA_EMPS.mat"
    if not path.is_file():
        pytest.skip(f"DATA_EMPS.mat is not in {path.parent}: point EMA_SHARED at the folder above measurements")
    return path


def lead_screw_folder() -> Path:
    """The measured lead-screw drive's files as its drive wrote them, or the test is skipped."""
    shared = Path(os.environ.get("EMA_SHARED", ROOT.parent / "shared"))
    folder = shared / "measurements" / "lead_screw_drive_1"
    if not (folder / "steady_state").is_dir():
        pytest.skip(f"lead_screw_drive_1 is not in {folder.parent}: point EMA_SHARED at the folder above measurements")
    return folder


def chirp_record(actuator: Actuator | None = None, text: str = "chirp", bits: int = 64) -> Record:
    """The record that an actuator (the reference one) leaves under a command."""
    model = actuator or reference_actuator()
    return simulate_record(model, make_command(text, model), bits)
