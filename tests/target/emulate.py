"""Runs a program for an emulated board in QEMU and hands on what it prints and its exit code.

Python's standard library alone. As a program it is CMake's emulator of the cross builds; the measurements import `run`.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

QEMU = "qemu-system-arm"
TIMED_OUT = 124
# Of QEMU's plugin interface: each QEMU takes some.
PLUGIN_VERSIONS = range(1, 9)
# What Unity prints at the end of every program.
UNITY_SUMMARY = re.compile(r"^(\d+) Tests (\d+) Failures (\d+) Ignored\s*$", re.MULTILINE)


@dataclass(frozen=True)
class Run:
    """What came of a program."""

    output: str
    exit_code: int


def run(
    board: str,
    program: Path,
    arguments: list[str],
    *,
    shift: int | None = None,
    timeout_s: float = 1700.0,
    plugin: str | None = None,
    folder: Path | None = None,
) -> Run:
    """Starts `program` on `board` with its arguments. With `shift`, each instruction takes 2^shift ns of the emulated time and the run is the same every time.
    `plugin`: of QEMU, a file and its options. `folder`: where the program finds its files.

    Raises FileNotFoundError with what to do when QEMU or the program is missing.
    """
    qemu = shutil.which(QEMU)
    if qemu is None:
        raise FileNotFoundError(f"{QEMU} not found: install the package qemu-system-arm")
    if not program.is_file():
        raise FileNotFoundError(f"{program} not found: build it first")
    # Commas separate QEMU's options and blanks the program's arguments.
    words = [program.name, *arguments]
    wrong = next((word for word in words if not re.fullmatch(r"[\w.+/=-]+", word)), None)
    if wrong is not None:
        raise ValueError(f"argument `{wrong}`: only letters, digits and . + / = - reach the emulated program")
    command = [
        qemu,
        "-machine",
        board,
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        "none",
        "-chardev",
        "stdio,id=console,signal=off",
        "-semihosting-config",
        "enable=on,target=native,chardev=console," + ",".join(f"arg={word}" for word in words),
        "-kernel",
        str(program.absolute()),
    ]
    if shift is not None:
        command += ["-icount", f"shift={shift},sleep=off"]
    if plugin is not None:
        command += ["-plugin", plugin]
    try:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=timeout_s,
            check=False,
            cwd=folder,
        )
    except subprocess.TimeoutExpired as error:
        return Run((error.stdout or b"").decode(errors="replace"), TIMED_OUT)
    return Run(done.stdout.decode(errors="replace").replace("\r\n", "\n"), done.returncode)


def plugin_for(emulator: str, source: Path, option: str, work: Path) -> Path:
    """A plugin, built as this emulator takes it and tried with `option=FILE`. Raises FileNotFoundError with what the emulator says when it takes none."""
    said = ""
    for version in PLUGIN_VERSIONS:
        made = work / f"{source.stem}_{version}.so"
        command = ["gcc", "-std=c11", "-O2", "-shared", "-fPIC", f"-DQEMU_PLUGIN_VERSION={version}", str(source), "-o", str(made)]
        built = subprocess.run(command, capture_output=True, text=True, check=False)
        if built.returncode != 0:
            raise FileNotFoundError(f"{source.name}: {built.stderr.strip()[-200:]}")
        (work / "tried").write_bytes(bytes(8))
        machine = ["-machine", "none", "-display", "none"] if "-system-" in emulator else []
        trial = [emulator, *machine, "-plugin", f"{made},{option}={work / 'tried'}", "no_such_program"]
        said = subprocess.run(trial, capture_output=True, text=True, check=False, timeout=60.0).stderr
        if "plugin" not in said:
            return made
    raise FileNotFoundError(f"{emulator} takes no plugin: {said.strip()}")


def unity_verdict(result: Run) -> str:
    """Why a run of a Unity program is no success; empty when it is one. A program that ran no test is none."""
    summary = UNITY_SUMMARY.findall(result.output)
    if result.exit_code == TIMED_OUT:
        return "the program did not end in its time"
    if result.exit_code != 0:
        return f"the program ended with {result.exit_code}"
    if len(summary) != 1:
        return f"the program printed {len(summary)} summaries of its tests, not one"
    tests, failures, _ignored = (int(number) for number in summary[0])
    if tests == 0 or failures != 0:
        return f"{tests} tests, {failures} failed"
    return ""


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True, help="QEMU's name of the machine")
    parser.add_argument("--unity", action="store_true", help="the program must have run tests, all of them well")
    parser.add_argument("--shift", type=int, help="an instruction takes 2^N ns of emulated time")
    parser.add_argument("--expect", type=int, help="succeed when the program ends with this code, and fail otherwise")
    parser.add_argument("--timeout", type=float, default=1700.0, help="seconds")
    parser.add_argument("program", type=Path)
    parser.add_argument("arguments", nargs="*")
    given = parser.parse_args()
    try:
        result = run(given.board, given.program, given.arguments, shift=given.shift, timeout_s=given.timeout)
    except (FileNotFoundError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    sys.stdout.write(result.output)
    if given.unity:
        problem = unity_verdict(result)
        if problem:
            print(f"{given.program.name}: {problem}", file=sys.stderr)
            return 1
    if given.expect is not None:
        print(f"{given.program.name} ended with {result.exit_code}")
        return 0 if result.exit_code == given.expect else 1
    return result.exit_code


if __name__ == "__main__":
    sys.exit(main())
