"""Today's tools beside those of an earlier state: what their sources count, and how long the same diagnoses and the same model runs take, in turn, in one run.

git worktree add EARLIER REV && (cd EARLIER && cmake --preset test && cmake --build --preset test)
python -m ema_tools.benchmarks.against REV EARLIER --document docs/STRUCTURE.md
"""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from ema_tools.base.files import write_text
from ema_tools.benchmarks import frozen
from ema_tools.benchmarks.effects import CHIRP, ROWS, STEP_S, costed_changes
from ema_tools.benchmarks.structure import counted, sources

_ROOT = Path(__file__).resolve().parents[3]
_CASES = {
    "with five repeats": "repeats stribeck_friction medium",
    "without healthy repeats": "alone stribeck_friction large",
    "with command and rod position alone": "position stribeck_friction medium",
}
_TURNS = 3
_RUNS = 12
# Either state's names of the same two things.
_TIMED = f"""
import json, sys, time
import numpy as np
try:
    from ema_tools.plant.native import library
    from ema_tools.data.actuator import reference_actuator
except ImportError:
    from ema_tools.native import library
    from ema_tools.actuator import reference_actuator
command = library(64).command("chirp", {CHIRP!r}, {STEP_S!r}, {ROWS!r})
given = {{}}
for name, changes in json.loads(sys.stdin.read()).items():
    try:
        given[name] = reference_actuator().changed(changes).arrays()
    except (KeyError, ValueError):
        pass  # an effect that joined later
found = dict.fromkeys(given, float("inf"))
for _ in range({_RUNS}):  # all in turn, so that what slows the machine for a while slows none alone
    for name, (values, options) in given.items():
        begun = time.perf_counter()
        library(32).simulate(values, options, command)
        found[name] = min(found[name], 1e9 * (time.perf_counter() - begun) / command.size)
print(json.dumps(found))
"""
# The benchmark of hidden effects times this in a process that is warm; the earlier state's leaves out what it asks of a record beforehand.
_ANSWERED = """
from ema_tools.benchmarks.hidden.trials import FULL, perform
timed = next(one for one in FULL.trials() if one.kind == "time" and one.effects == ("stribeck_friction",))
print(min(perform(timed)["run_s"] for _ in range(2)))
"""
_DIAGNOSE = "import sys; from ema_tools.cli import main; sys.argv[0] = 'ema'; main()"
_INSTRUCTIONS = re.compile(r"^\| (no effect|\w+) \| ([\d ]+) \|", re.MULTILINE)


def _environment(state: Path) -> dict[str, str]:
    return {
        **os.environ,
        "PYTHONPATH": str(state / "tools"),
        "EMA_LIBRARY_DIR": str(state / "build/lib"),
        "EMA_BIN_DIR": str(state / "build/bin"),
    }


def _run(state: Path, code: str, arguments: Sequence[str], given: str, folder: Path) -> str:
    command = [sys.executable, "-c", code, *arguments]
    return subprocess.run(command, cwd=folder, env=_environment(state), input=given, capture_output=True, text=True, check=True).stdout


def diagnoses_s(states: Sequence[Path]) -> dict[str, list[float]]:
    """Seconds on the clock of a whole `ema diagnose`, the shortest of some turns, by the kind of record and state."""
    found = {}
    for title, name in _CASES.items():
        case = next(one for one in frozen.CASES if one.name == name)
        shortest = [float("inf")] * len(states)
        with tempfile.TemporaryDirectory() as folder:
            made = frozen.made(case, Path(folder))
            assert made is not None  # only records of another machine may be absent
            actuator, *arguments = made
            for turn in range(_TURNS):
                for place, state in enumerate(states):
                    begun = time.perf_counter()
                    # each state reads its own file of the same machine: the earlier one refuses keys that came later
                    own = str(state / "actuators" / actuator)
                    _run(state, _DIAGNOSE, ["diagnose", own, *arguments, "--json", f"{turn}_{place}.json"], "", Path(folder))
                    shortest[place] = min(shortest[place], time.perf_counter() - begun)
        found[title] = shortest
    with tempfile.TemporaryDirectory() as folder:
        turns = [[float(_run(state, _ANSWERED, [], "", Path(folder))) for state in states] for _ in range(_TURNS)]
    found["with five repeats, from records to answer in a warm process"] = [
        min(turn[place] for turn in turns) for place in range(len(states))
    ]
    return found


def steps_ns(states: Sequence[Path]) -> dict[str, list[float]]:
    """Nanoseconds of a model step without and with each effect, by effect and state; the shorter of two turns. Not a number where a state does not have the effect."""
    given = json.dumps({"no effect": {}, **costed_changes()})
    with tempfile.TemporaryDirectory() as folder:
        turns = [[json.loads(_run(state, _TIMED, [], given, Path(folder))) for state in states] for _ in range(2)]
    return {name: [min(turn[place].get(name, math.nan) for turn in turns) for place in range(len(states))] for name in turns[0][-1]}


def _instructions(budgets: str) -> dict[str, str]:
    section = budgets.partition("## One model step")[2].partition("\n## ")[0]
    return dict(_INSTRUCTIONS.findall(section))


def _row(name: str, *cells: str) -> str:
    return f"| {name} | {' | '.join(cells)} |"


def document(revision: str, earlier: Path) -> str:
    """The page."""
    then, now = counted(sources(revision)), counted(sources())
    states = (earlier, _ROOT)
    lines = [
        "# The tools before and after they were laid out anew",
        "",
        "Written by a command; do not edit. The earlier state is the last before the move. To write it again, after `cmake --workflow --preset test`:",
        "",
        f"    git worktree add build/earlier {revision}",
        "    (cd build/earlier && cmake --preset test && cmake --build --preset test)",
        f"    build/venv/bin/python -m ema_tools.benchmarks.against {revision} build/earlier --document docs/STRUCTURE.md",
        "",
        "## Sources",
        "",
        "| | before | after |",
        "|---|---:|---:|",
        *(_row(name, then[name], value) for name, value in now.items()),
        "",
        "More files and lines: typed results, one record per effect, other forms of effects in the truth plant, and these benchmarks are new.",
        "",
        "## A diagnosis",
        "",
        f"Seconds on the clock of the whole command on {os.cpu_count()} cores, or without its start where that is said; the shortest of {_TURNS} turns, both states in turn.",
        "What a second is worth differs between machines and between days; the last column does not.",
        "",
        "| 10 s of chirp at 1 kHz | before | after | before / after |",
        "|---|---:|---:|---:|",
        *(_row(name, f"{old:.1f}", f"{new:.1f}", f"{old / new:.1f}") for name, (old, new) in diagnoses_s(states).items()),
        "",
        "## A model step",
        "",
        f"Nanoseconds on this machine in float32, and over a step without effects: the shortest of {2 * _RUNS} runs of a 10 s chirp, all of them in turn,",
        "one effect at a time at the lower end of its usual size.",
        "",
        "| | before, ns | after, ns | before, times | after, times |",
        "|---|---:|---:|---:|---:|",
        *_steps(steps_ns(states)),
        "",
        "Instructions on a Cortex-M4F, mean, from docs/BUDGETS.md of both states:",
        "",
        "| | before | after |",
        "|---|---:|---:|",
        *_on_target(_instructions((earlier / "docs/BUDGETS.md").read_text(encoding="utf-8"))),
        "",
    ]
    return "\n".join(lines)


def _steps(found: Mapping[str, Sequence[float]]) -> list[str]:
    plain = found["no effect"]
    order = sorted(found, key=lambda name: -found[name][1])
    return [
        _row(
            name,
            *("-" if math.isnan(value) else f"{value:.0f}" for value in found[name]),
            *("-" if math.isnan(value) else f"{value / base:.2f}" for value, base in zip(found[name], plain, strict=True)),
        )
        for name in order
    ]


def _on_target(before: Mapping[str, str]) -> list[str]:
    after = _instructions((_ROOT / "docs/BUDGETS.md").read_text(encoding="utf-8"))
    return [_row(name, before[name], value) for name, value in after.items() if name in before]


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("revision", help="the commit of the earlier state")
    parser.add_argument("earlier", type=Path, help="a checkout of it, built")
    parser.add_argument("--document", type=Path, help="write the page there; on the terminal when absent")
    arguments = parser.parse_args()
    text = document(arguments.revision, arguments.earlier.resolve())
    if arguments.document:
        write_text(arguments.document, text, force=True)
    else:
        print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
