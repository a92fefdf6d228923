"""Runs the example firmware on the emulated board, on three machines, and wants: the right verdict on each, no tick late, no slice too long, and the bits of the
board without hardware.

The machines: a worn one, whose fault must be found; a healthy one; and a healthy one that hides an effect, with which the estimates alone would be a fault that is
not there: the table must name it and the verdict must be taken back. Then the worn one is asked for the impossible, a tick without any delay and a slice that is too
short, and exactly that must be reported. With --unit the machine is a unit with standing errors, which the firmware knows by its own model and of which the board plays
recorded chirps: sound, worn, and with something that the model lacks. With --image the worn one's configuration is a unit of a binary image in flash: every bit of the
answer must be that of the compiled one, and of an image with one bit turned over nothing may be used. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import emulate

# An instruction takes 8 ns: 125 MHz at one instruction per cycle.
SHIFT = 3
ROWS = 10000
# How near the estimates come: the machine's integration and the record's 0.12 um are the difference. The table is linear in the effect's size.
WITHIN = (0.002, 0.02)
SIZE_WITHIN = 0.05
# The same in % for a recorded unit: its friction differs from day to day, by 1.5 % for the temperature alone.
SHIFT_WITHIN = (3.0, 3.0)
# Shifts of CSJ and BLK from which the reference actuator calls a fault, in %.
FAULT_FROM = (5.0, 10.0)
ANSWER = (
    "estimate",
    "std",
    "half_95",
    "shift_percent",
    "objective_after",
    "evaluations",
    "random",
    "verdict",
    "adequate",
    "reasons",
    "finding",
    "effect",
    "size",
    "score",
    "limit",
    "energy",
    "packet",
)
OK, LATE, OVERRUN = 0, 1, 2
HEALTHY, FAULT, UNDECIDED = "0", "1", "2"
VERDICTS = {HEALTHY: "HEALTHY", FAULT: "FAULT", UNDECIDED: "UNDECIDED"}
REASON_EFFECT = 256


@dataclass(frozen=True)
class Machine:
    """A machine and what must come of it; `true`: CSJ and BLK in Nm and mm, or None where an effect is hidden and the estimates mean nothing; `title`: in docs/FIRMWARE.md.

    Of a recorded unit `shifts` of CSJ and BLK in % take the place of `true`.
    """

    program: str
    title: str
    verdict: str
    true: tuple[float, float] | None
    effect: str = "none"
    size: float = 0.0
    shifts: tuple[float, float] | None = None
    values: int = 2


WORN = Machine("ace", "worn as in case A: +117.4 %, +25.0 %", FAULT, (0.3, 0.04125))
MACHINES = (
    WORN,
    Machine("ace_healthy", "healthy", HEALTHY, (0.138, 0.033)),
    Machine(
        "ace_hidden",
        "healthy, with a dead time of the inverter of 0.3 V, which the model lacks",
        UNDECIDED,
        None,
        "inverter_dead_time",
        0.3,
    ),
)
SLICE_STEPS = "200"
_UNIT = "a unit with standing errors, by its own model"
UNIT = (
    Machine("ace_unit_sound", f"{_UNIT}: sound, 3 degC warmer", HEALTHY, None, shifts=(0.0, 0.0), values=4),
    Machine("ace_unit_worn", "the same: +20 %, +50 %, 3 degC colder", FAULT, None, shifts=(20.0, 50.0), values=4),
    Machine("ace_unit_hidden", "the same: sound, with such a dead time", UNDECIDED, None, "inverter_dead_time", 0.3, values=4),
)


# The worn unit by an image, the program whose configuration is compiled in, and the one whose image is damaged.
IMAGE, COMPILED, DAMAGED = replace(UNIT[1], program="ace_image_sound"), "ace_unit_worn", "ace_image_damaged"
UNKNOWN, CHECKSUM = 5, "7"


def lines_of(output: str) -> list[list[str]]:
    """The report, line by line, cut at blanks."""
    return [line.split() for line in output.splitlines() if line.strip()]


def value_of(lines: list[list[str]], name: str) -> str:
    """The only value of `name`. Raises ValueError."""
    found = [line for line in lines if line[0] == name]
    if len(found) != 1 or len(found[0]) < 2:
        raise ValueError(f"{len(found)} lines `{name}` in the report instead of one")
    return found[0][1]


def problems_of(output: str, exit_code: int, machine: Machine = WORN) -> list[str]:
    """What is wrong with the report of the normal run."""
    lines = lines_of(output)
    count = {
        name: int(value_of(lines, name))
        for name in ("ticks", "ticks_searching", "late_ticks", "slices", "overruns", "slice_us", "allowed_us", "tick_us")
    }
    wanted = {
        f"exit code {exit_code}, status {value_of(lines, 'status')}": exit_code == OK and value_of(lines, "status") == "ok",
        f"{count['ticks']} ticks, {count['ticks_searching']} of them while it searched": count["ticks"]
        == ROWS + count["ticks_searching"]
        > ROWS + 200,
        f"{count['late_ticks']} late ticks": count["late_ticks"] == 0,
        f"a tick of {count['tick_us']} us": 0 < count["tick_us"] < 1000,
        f"{count['overruns']} overruns in {count['slices']} slices": count["overruns"] == 0 and count["slices"] > 500,
        f"a slice of {count['slice_us']} us, {count['allowed_us']} allowed": 0 < count["slice_us"] <= count["allowed_us"],
        f"verdict {value_of(lines, 'verdict')}": value_of(lines, "verdict") == machine.verdict,
        **wanted_of(lines, machine),
    }
    return [what for what, good in wanted.items() if not good]


def wanted_of(lines: list[list[str]], machine: Machine) -> dict[str, bool]:
    """What the report must say of the machine's values and of what its model lacks, and whether it does."""
    values = {name: [float(line[2]) for line in lines if line[0] == name] for name in ("estimate", "shift_percent", "size")}
    reasons = int(value_of(lines, "reasons"), 16)
    finding, effect, adequate = (value_of(lines, name) for name in ("finding", "effect", "adequate"))
    named = f"finding {finding}, effect {effect}"
    if machine.effect == "none":
        if machine.true is not None:
            near = [
                abs(found / true - 1.0) <= within for found, true, within in zip(values["estimate"], machine.true, WITHIN, strict=False)
            ]
        else:
            wanted = zip(values["shift_percent"], machine.shifts or (), SHIFT_WITHIN, strict=False)
            near = [abs(found - true) <= within for found, true, within in wanted]
        return {
            f"estimates {values['estimate']}": len(values["estimate"]) == machine.values and len(near) == len(WITHIN) and all(near),
            f"adequate {adequate}, reasons {reasons}": adequate == "1" and reasons == 0,
            named: finding == "adequate" and effect == "none",
        }
    return {
        f"shifts {values['shift_percent']}: no false fault to be taken back": any(
            found > least for found, least in zip(values["shift_percent"][: len(FAULT_FROM)], FAULT_FROM, strict=True)
        ),
        f"adequate {adequate}, reasons {reasons}": adequate == "0" and bool(reasons & REASON_EFFECT),
        named: finding == "missing" and effect == machine.effect,
        f"size {values['size']}": len(values["size"]) == 1 and abs(values["size"][0] / machine.size - 1.0) <= SIZE_WITHIN,
    }


def row_of(output: str, machine: Machine) -> str:
    """The machine's row in docs/FIRMWARE.md."""
    lines = lines_of(output)
    shifts = [f"{float(line[2]):+.1f} %" for line in lines if line[0] == "shift_percent"][: len(FAULT_FROM)]
    size = next(float(line[2]) for line in lines if line[0] == "size")
    finding = value_of(lines, "finding") + (f": `{value_of(lines, 'effect')}`, {size:.3g}" if size != 0.0 else "")
    verdict = f"`{VERDICTS[value_of(lines, 'verdict')]}`"
    return f"| {' | '.join([machine.title, *shifts, finding, verdict])} |"


def refusal_problems(board: str, program: Path) -> list[str]:
    """What is wrong with the two runs that must not be well."""
    problems = []
    for arguments, code, name, count in (
        (["200", "500"], OVERRUN, "overrun", "overruns"),
        ([SLICE_STEPS, "2000", "0"], LATE, "late", "late_ticks"),
    ):
        run = emulate.run(board, program, arguments, shift=SHIFT)
        lines = lines_of(run.output)
        if run.exit_code != code or value_of(lines, "status") != name or int(value_of(lines, count)) < 1:
            problems.append(
                f"with {' '.join(arguments)}: exit code {run.exit_code}, status {value_of(lines, 'status')}, {value_of(lines, count)} {count}: not `{name}`"
            )
    return problems


def damaged_problems(board: str, program: Path) -> list[str]:
    """What is wrong with the run whose image has one bit turned over."""
    run = emulate.run(board, program, [], shift=SHIFT)
    lines = lines_of(run.output)
    told = [value_of(lines, name) for name in ("status", "image", "ticks")]
    if run.exit_code != UNKNOWN or told != ["unknown", CHECKSUM, "0"]:
        return [f"a damaged image: exit code {run.exit_code}, {told}: not refused for its checksum before a tick"]
    return []


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True)
    parser.add_argument("--target", type=Path, required=True, help="folder of the firmware for each machine")
    parser.add_argument("--host", type=Path, required=True, help="the same on the board without hardware")
    parser.add_argument("--unit", action="store_true", help="the recorded unit instead of the three machines")
    parser.add_argument("--image", action="store_true", help="the worn unit, its configuration in a binary image")
    parser.add_argument("--page", type=Path, required=True, help="docs/FIRMWARE.md, which shows what comes of it")
    given = parser.parse_args()
    problems = []
    try:
        page = given.page.read_text(encoding="utf-8").splitlines()
        for machine in (IMAGE,) if given.image else UNIT if given.unit else MACHINES:
            run = emulate.run(given.board, given.target / machine.program, [SLICE_STEPS], shift=SHIFT)
            sys.stdout.write(f"{machine.program}\n{run.output}\n")
            problems += [f"{machine.program}: {problem}" for problem in problems_of(run.output, run.exit_code, machine)]
            if row_of(run.output, machine) not in page:
                problems.append(f"{machine.program}: {given.page.name} has no row `{row_of(run.output, machine)}`")
            other = COMPILED if given.image else machine.program
            host = subprocess.run([str(given.host / other)], capture_output=True, text=True, check=False)
            ours, theirs = ([line for line in lines_of(output) if line[0] in ANSWER] for output in (host.stdout, run.output))
            if ours != theirs or len(ours) < len(ANSWER):
                problems.append(f"{machine.program}: the board without hardware answers otherwise: {ours} instead of {theirs}")
        if given.image:
            problems += damaged_problems(given.board, given.target / DAMAGED)
        elif not given.unit:
            problems += refusal_problems(given.board, given.target / WORN.program)
    except (FileNotFoundError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for problem in problems:
        print(f"example: {problem}", file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
