"""Runs the example firmware on the emulated board and wants: the fault found, no tick late, no slice too long, and the bits of the board without hardware.

Then it asks for the impossible, a tick without any delay and a slice that is too short, and wants exactly that to be reported. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

import emulate

# An instruction takes 8 ns: 125 MHz at one instruction per cycle.
SHIFT = 3
ROWS = 10000
# What the simulated machine has, and how near the estimates come: its integration and the record's 0.12 um are the difference.
TRUE = (0.3, 0.04125)
WITHIN = (0.002, 0.02)
ANSWER = ("estimate", "std", "shift_percent", "objective_after", "evaluations", "random", "verdict", "adequate", "reasons")
OK, LATE, OVERRUN = 0, 1, 2
FAULT = "1"


def lines_of(output: str) -> list[list[str]]:
    """The report, line by line, cut at blanks."""
    return [line.split() for line in output.splitlines() if line.strip()]


def value_of(lines: list[list[str]], name: str) -> str:
    """The only value of `name`. Raises ValueError."""
    found = [line for line in lines if line[0] == name]
    if len(found) != 1 or len(found[0]) < 2:
        raise ValueError(f"{len(found)} lines `{name}` in the report instead of one")
    return found[0][1]


def problems_of(output: str, exit_code: int) -> list[str]:
    """What is wrong with the report of the normal run."""
    lines = lines_of(output)
    count = {name: int(value_of(lines, name)) for name in ("ticks", "ticks_searching", "late_ticks", "slices", "overruns", "slice_us", "allowed_us", "tick_us")}
    estimates = [float(line[2]) for line in lines if line[0] == "estimate"]
    wanted = {
        f"exit code {exit_code}, status {value_of(lines, 'status')}": exit_code == OK and value_of(lines, "status") == "ok",
        f"{count['ticks']} ticks, {count['ticks_searching']} of them while it searched": count["ticks"] == ROWS + count["ticks_searching"] > ROWS + 1000,
        f"{count['late_ticks']} late ticks": count["late_ticks"] == 0,
        f"a tick of {count['tick_us']} us": 0 < count["tick_us"] < 1000,
        f"{count['overruns']} overruns in {count['slices']} slices": count["overruns"] == 0 and count["slices"] > 1000,
        f"a slice of {count['slice_us']} us, {count['allowed_us']} allowed": 0 < count["slice_us"] <= count["allowed_us"],
        f"verdict {value_of(lines, 'verdict')}": value_of(lines, "verdict") == FAULT and value_of(lines, "adequate") == "1",
        f"estimates {estimates}": len(estimates) == len(TRUE)
        and all(abs(found / true - 1.0) <= within for found, true, within in zip(estimates, TRUE, WITHIN, strict=True)),
    }
    return [what for what, good in wanted.items() if not good]


def refusal_problems(board: str, program: Path) -> list[str]:
    """What is wrong with the two runs that must not be well."""
    problems = []
    for arguments, code, name, count in ((["200", "500"], OVERRUN, "overrun", "overruns"), (["200", "2000", "0"], LATE, "late", "late_ticks")):
        run = emulate.run(board, program, arguments, shift=SHIFT)
        lines = lines_of(run.output)
        if run.exit_code != code or value_of(lines, "status") != name or int(value_of(lines, count)) < 1:
            problems.append(f"with {' '.join(arguments)}: exit code {run.exit_code}, status {value_of(lines, 'status')}, {value_of(lines, count)} {count}: not `{name}`")
    return problems


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True)
    parser.add_argument("--target", type=Path, required=True, help="the firmware")
    parser.add_argument("--host", type=Path, required=True, help="the same on the board without hardware")
    given = parser.parse_args()
    try:
        run = emulate.run(given.board, given.target, [], shift=SHIFT)
        problems = problems_of(run.output, run.exit_code)
        host = subprocess.run([str(given.host)], capture_output=True, text=True, check=False)
        ours, theirs = ([line for line in lines_of(output) if line[0] in ANSWER] for output in (host.stdout, run.output))
        if ours != theirs or len(ours) < len(ANSWER):
            problems.append(f"the board without hardware answers otherwise: {ours} instead of {theirs}")
        problems += refusal_problems(given.board, given.target)
    except (FileNotFoundError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for problem in problems:
        print(f"example: {problem}", file=sys.stderr)
    sys.stdout.write(run.output)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
