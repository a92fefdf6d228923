"""Checks the call graph of the module; no library serves, since linters see one file at a time and gcc only writes the graph down.

Forbidden are recursion, calls through a pointer, frames of unknown size, and calls of anything outside but memory copies.
The sources are compiled for it once more without optimisation, so that every call that they hold is in gcc's graph: an optimised build hides some of them, a recursion at
the end of a function for instance, which becomes a loop. The graph must hold every function that the built library defines, or it is not the library's.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from check_compiles import include_flags
from check_symbols import ALLOWED
from sources import c_files, fail, finish

sys.path.insert(0, str(Path(__file__).parents[1] / "target"))
import stack  # beside the target's tests, which read the same graph

SKIP = 77
# One instruction each in the optimised build, which check_symbols holds to that.
INSTRUCTIONS = {"sqrt", "sqrtf", "fabs", "fabsf"}
# What gcc makes of one function for its own use.
CLONE = re.compile(r"\.(part|constprop|isra|cold|lto_priv)(\.\d+)?")


def name_of(title: str) -> str:
    """The function's name in the sources; the graph puts the file before one that is static."""
    return title.rsplit(":", 1)[-1]


def cycles(calls: dict[str, set[str]]) -> list[list[str]]:
    """Every ring of calls that a walk through the graph meets, once: the functions from the first to the one that calls it again."""
    found: list[list[str]] = []
    done: set[str] = set()
    for start in sorted(calls):
        if start in done:
            continue
        path = [start]
        open_calls = [iter(sorted(calls[start]))]
        while path:
            callee = next(open_calls[-1], None)
            if callee is None:
                open_calls.pop()
                done.add(path.pop())
            elif callee in path:
                found.append(path[path.index(callee) :])
            elif callee not in done:
                path.append(callee)
                open_calls.append(iter(sorted(calls.get(callee, ()))))
    return found


def check_graph(graph: stack.Graph, defined: set[str]) -> list[str]:
    """Problems in a call graph of a library that defines these functions."""
    known = {name_of(title) for title in graph.frames}
    problems = [
        f"{name}: the library defines it, the call graph does not hold it: build the library from these sources"
        for name in sorted(defined - known)
    ]
    for caller, callees in sorted(graph.calls.items()):
        for callee in sorted(callees - graph.frames.keys()):
            plain = callee.removeprefix("__builtin_")
            if callee == stack.INDIRECT:
                problems.append(f"{name_of(caller)}: calls through a pointer: call the function by its name")
            elif plain not in ALLOWED | INSTRUCTIONS:
                problems.append(f"{name_of(caller)}: calls {plain}, which the module does not define: keep it out of src")
    problems += [
        " -> ".join(map(name_of, [*ring, ring[0]])) + ": recursion: write it as a loop with a bound" for ring in cycles(graph.calls)
    ]
    return problems


def graph_of(root: Path, compiler: str, real64: int) -> stack.Graph:
    """The call graph of the module's sources. Raises stack.StackError, also for a source that does not compile."""
    graph = stack.Graph()
    root = root.resolve()
    sources = c_files(root, "src", suffixes=(".c",))
    with tempfile.TemporaryDirectory() as folder:
        flags = [
            "-std=c11",
            "-O0",
            "-ffp-contract=off",
            "-fno-math-errno",
            "-fcallgraph-info=su",
            f"-DEMA_REAL64={real64}",
            *include_flags(root),
        ]
        if sources:
            run = subprocess.run([compiler, *flags, "-c", *map(str, sources)], cwd=folder, capture_output=True, text=True, check=False)
            if run.returncode != 0:
                raise stack.StackError(run.stderr.strip().splitlines()[0])
        for path in sorted(Path(folder).glob("*.ci")):
            graph.add(path.read_text(encoding="utf-8"))
    return graph


def functions_of(nm: str, library: Path) -> set[str]:
    """Names of the functions in the library, as the sources call them."""
    run = subprocess.run([nm, "--format=sysv", str(library)], capture_output=True, text=True, check=False)
    fields = [[field.strip() for field in line.split("|")] for line in run.stdout.splitlines()]
    return {CLONE.sub("", row[0]) for row in fields if len(row) == 7 and row[3] == "FUNC" and row[6] != "*UND*"}


def has_graph(compiler: str) -> bool:
    """Whether the compiler writes call graphs: gcc from 10 on does."""
    run = subprocess.run([compiler, "-fcallgraph-info=su", "-E", "-"], input="", capture_output=True, text=True, check=False)
    return run.returncode == 0


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", required=True, type=Path)
    parser.add_argument("--compiler", required=True)
    parser.add_argument("--nm", required=True)
    parser.add_argument("libraries", nargs=2, type=Path, help="the library in float32, and in float64")
    given = parser.parse_args()
    if not has_graph(given.compiler):
        print(f"calls: left out: {given.compiler} writes no call graph; gcc does")
        return SKIP
    problems: list[str] = []
    functions = 0
    for real64, library in enumerate(given.libraries):
        defined = functions_of(given.nm, library)
        if not defined:
            return fail(f"calls: {library} defines no function: build it first")
        try:
            graph = graph_of(given.root, given.compiler, real64)
        except stack.StackError as error:
            return fail(f"calls: {error}")
        problems += [f"{library.name}: {problem}" for problem in check_graph(graph, defined)]
        functions += len(graph.frames)
    return finish("calls", problems, functions, "functions")


if __name__ == "__main__":
    sys.exit(main())
