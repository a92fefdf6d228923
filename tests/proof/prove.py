"""Runs one of the proofs in this folder with Frama-C's Eva and holds what it leaves open against docs/PROOF.md.

Eva goes through all executions that a proof file describes at once and raises an alarm for whatever it cannot exclude. An alarm that the page does not list fails, and so does one
that the page lists and Eva no longer raises. Exit code 77 when Frama-C is not installed.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

SKIP = 77
PAGE = "docs/PROOF.md"

ALARM = re.compile(r"^\[eva:alarm\] ([^:\n]+):(\d+): Warning: \n?((?:[ \t].*\n?)+)", re.MULTILINE)
ROW = re.compile(r"^\| (\w+) \| `([^`]+)` \| ([^|]+) \| (\d+) \| ([^|]+) \|$", re.MULTILINE)
REACHED = re.compile(r"In th(?:ese functions|is function), (\d+) statements reached\s+\(out of (\d+)\)")

# What Eva is told of the elementary functions; every_float.c shows it.
CONTRACTS = ("tests/proof/contracts.h", "tests/proof/states.h")
ELEMENTARY = "ema_floor,ema_exp,ema_log,ema_sin,ema_cos"

# Functions in which paths are kept apart, and how many: a check says nothing once its ways out are merged.
CHECKS = (
    "ema_values_within:1000,ema_ranges_check:1000,ema_tables_check:50,ema_table_check:50,ema_actuator_check:1000,ema_any_actuator:2000,"
    "ema_plant_prepare:100,ema_plant_check:100,ema_model_init:20,ema_run_prepare:20"
)


@dataclass(frozen=True)
class Unit:
    """One proof: its file without `proof_` and `.c`, whether numbers must stay finite in it, and how paths are kept apart."""

    file: str
    finite: bool
    paths: str
    options: tuple[str, ...] = ()
    defines: tuple[str, ...] = ()


def units() -> dict[str, Unit]:
    """The proofs by name."""
    found = {
        "step": Unit("step", False, f"main:10,{CHECKS}"),
        "objective": Unit("objective", False, f"main:10,ema_objective_start:20,ema_objective_run:20,{CHECKS}"),
        "record": Unit("record", False, "main:2000,ema_one_size:50,ema_record_init:100,ema_record_append:100"),
        "blocks": Unit("blocks", True, "", ("-eva-slevel", "50", "-eva-subdivide-non-linear", "50")),
        "wrong": Unit("wrong", True, "", ("-eva-slevel", "10")),
    }
    for dimension in range(1, 9):
        found[f"annealer{dimension}"] = Unit(
            "annealer",
            False,
            "main:20,ema_one_dimension:20,ema_cholesky:2000,ema_solve_lower:200,ema_solve_upper:200,ema_quadratic_terms:100",
            defines=(f"-DEMA_PROOF_DIMENSION={dimension}",),
        )
    return found


# What the proof of faults must find.
FAULTS = {
    "accessing out of bounds index",
    "division by zero",
    "signed overflow",
    "overflow in conversion from floating-point to integer",
    "invalid RHS operand for shift",
    "non-finite float value",
}


def command(frama_c: str, root: Path, unit: Unit) -> list[str]:
    """Frama-C's command line, to be run in `root`."""
    folders = ["include", "tests/proof", "src"]
    preprocess = " ".join(["-include tests/proof/contracts.h", *(f"-I {folder}" for folder in folders), *unit.defines])
    sources = sorted(str(path.relative_to(root)) for path in (root / "src").rglob("*.c"))
    return [
        frama_c,
        "-c11",
        "-machdep",
        "gcc_x86_64",
        f"-cpp-extra-args={preprocess}",
        f"tests/proof/proof_{unit.file}.c",
        *sources,
        "-eva",
        "-eva-no-results",
        "-eva-use-spec",
        ELEMENTARY,
        "-eva-auto-loop-unroll",
        "300",
        "-warn-special-float",
        "non-finite" if unit.finite else "none",
        *(() if unit.finite else ("-eva-slevel", "0", "-eva-split-return", "full")),
        *(("-eva-slevel-function", unit.paths) if unit.paths else ()),
        *unit.options,
    ]


def alarms(log: str) -> list[tuple[str, str, str]]:
    """File, kind and whole text of each alarm; what is stated about elementary functions is none."""
    found = []
    for match in ALARM.finditer(log):
        text = " ".join(match[3].split())
        if match[1] not in CONTRACTS:
            kind = re.sub(r"\.? assert .*|:? precondition .*|'.*", "", text).strip().rstrip(".")
            found.append((match[1], kind, f"{match[1]}:{match[2]}: {text}"))
    return found


def listed(page: str, name: str) -> Counter[tuple[str, str]]:
    """How many alarms of which kind the page lists for a proof, by file."""
    counts: Counter[tuple[str, str]] = Counter()
    for row in ROW.finditer(page):
        if row[1] == name:
            counts[row[2], row[3].strip()] += int(row[4])
    return counts


def broken(log: str) -> str:
    """Why the log is of no finished proof; empty when it is of one."""
    errors = re.findall(r"^\[\w+\] (?:User Error|Failure|Frama-C aborted).*", log, re.MULTILINE)
    if errors:
        return str(errors[0])
    if "done for function main" not in log:
        return "Eva has not ended"
    if "Frama_C_show_each_end" not in log:
        return "no execution reaches the proof's end, so it shows nothing"
    if re.search(r"[1-9]\d* invalid +\d+ total", log):
        return "an assertion is wrong in every execution"
    if re.search(r"Neither code nor specification|no specification for function", log, re.IGNORECASE):
        return "a function is called that Eva knows nothing of"
    return ""


def compare(name: str, log: str, page: str) -> list[str]:
    """Problems of a proof's log against the page."""
    problem = broken(log)
    if problem:
        return [problem]
    found = alarms(log)
    have = Counter((file, kind) for file, kind, _ in found)
    want = listed(page, name)
    problems = [
        f"{text}: not in {PAGE}: exclude it, or list it with its reason"
        for file, kind, text in found
        if have[file, kind] > want[file, kind]
    ]
    problems += [
        f"{PAGE}: {name}: {file}: {kind}: {count} listed, {have[file, kind]} raised: correct the page"
        for (file, kind), count in sorted(want.items())
        if have[file, kind] < count
    ]
    return problems


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", choices=sorted(units()))
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--log", type=Path, help="where Eva's own words go")
    given = parser.parse_args()
    frama_c = shutil.which("frama-c")
    if frama_c is None:
        print("proof: left out: Frama-C is not installed; on Debian it is the package frama-c-base")
        return SKIP
    root = given.root.resolve()
    # Frama-C asks PWD, not the system, which folder it is in.
    run = subprocess.run(
        command(frama_c, root, units()[given.name]),
        cwd=root,
        env={**os.environ, "PWD": str(root)},
        capture_output=True,
        text=True,
        check=False,
    )
    log = run.stdout + run.stderr
    if given.log:
        given.log.write_text(log, encoding="utf-8")
    if given.name == "wrong":
        missed = sorted(FAULTS - {kind for _, kind, _ in alarms(log)})
        problems = [broken(log)] if broken(log) else [f"proof_wrong.c: {fault}: Eva did not find it" for fault in missed]
    else:
        problems = compare(given.name, log, (root / PAGE).read_text(encoding="utf-8"))
    for problem in problems:
        print(problem)
    reached = REACHED.search(log)
    print(f"proof {given.name}: {reached[1] if reached else 0} statements, {len(alarms(log))} alarms, {len(problems)} wrong")
    return 1 if problems or reached is None else 0


if __name__ == "__main__":
    sys.exit(main())
