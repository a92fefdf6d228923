"""Which instructions of the module's object code a run of the suite on the target has reached, and which of its branches went both ways: docs/OBJECT_COVERAGE.md.

    cmake --build build-cortex-m4f --target object_coverage

Runs every unit test and the programs that identify recorded cases on the emulated board, by a plugin of QEMU (counted/qemu_reached.c) that notes the blocks of instructions that were run and how they
were left. The code is that of the library's objects as the firmware links it. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import emulate

# Programs beside the unit tests, with their arguments.
# Programs of test sources; the others hold builds that leave something out, which is other code.
PROGRAMS = ("ema_tests_f32", "ema_tests_open")
IDENTIFIES = (("ema_answer", ("a", "1", "1000", "int16")), ("ema_answer", ("u", "1", "1000", "int16")))
FUNCTION = re.compile(r"^[0-9a-f]+ <(\w+)>:$")
INSTRUCTION = re.compile(r"^\s*([0-9a-f]+):\t((?:[0-9a-f]{4} ?)+)\s*\t(\S+)")
CONDITIONAL = re.compile(r"^(b(eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)(\.[nw])?|cbn?z)$")
AT_LEAST_PERCENT = 99.0
AT_LEAST_BRANCHES_PERCENT = 97.0
SHOWN = 40


class ObjectCoverageError(Exception):
    """What went wrong, with what to do."""


@dataclass
class Function:
    """A function of an object file: where its instructions begin, from its own beginning, which of them are conditional branches, and what of it was reached."""

    name: str
    file: str
    bytes: int = 0
    instructions: dict[int, int] = field(default_factory=dict)  # bytes of each by its offset
    branches: set[int] = field(default_factory=set)
    reached: set[int] = field(default_factory=set)
    fell: set[int] = field(default_factory=set)
    branched: set[int] = field(default_factory=set)

    def ways_missed(self) -> int:
        """Ways out of conditional branches that were not taken."""
        return 2 * len(self.branches) - len(self.fell & self.branches) - len(self.branched & self.branches)

    def missed(self) -> int:
        """Instructions that were not reached."""
        return len(self.instructions.keys() - self.reached)


def said(command: list[str]) -> list[str]:
    """Lines that a program prints. Raises ObjectCoverageError."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ObjectCoverageError(f"{command[0]}: {done.stderr.strip()[-200:]}")
    return done.stdout.splitlines()


def symbols_of(nm: str, program: Path) -> list[tuple[str, int, int]]:
    """Name, address without the bit that says Thumb, and bytes of every function. Raises ObjectCoverageError."""
    rows = [line.split() for line in said([nm, "-S", str(program)])]
    return [(row[3], int(row[0], 16) & ~1, int(row[1], 16)) for row in rows if len(row) == 4 and row[2] in "tT"]


def functions_of(objdump: str, nm: str, objects: Path) -> dict[tuple[str, int], Function]:
    """Every function of the library's objects, by name and bytes: copies of one that stands in a header are one. Raises ObjectCoverageError."""
    found: dict[tuple[str, int], Function] = {}
    for path in sorted([*objects.rglob("*.o"), *objects.rglob("*.obj")]):
        own: list[Function] = []
        first = 0
        size_of = {name: size for name, _, size in symbols_of(nm, path)}
        for line in said([objdump, "-d", str(path)]):
            head, code = FUNCTION.match(line), INSTRUCTION.match(line)
            if head:
                own.append(Function(head[1], path.name.split(".")[0], size_of.get(head[1], 0)))
                first = int(line.split()[0], 16)
            elif code and own:
                offset, size = int(code[1], 16) - first, len(code[2].replace(" ", "")) // 2
                # what fills up to a word is never reached
                if not code[3].startswith((".", "nop")) and offset < own[-1].bytes:
                    own[-1].instructions[offset] = size
                    if CONDITIONAL.match(code[3]):
                        own[-1].branches.add(offset)
        for function in own:
            found.setdefault((function.name, function.bytes), function)
    if not found:
        raise ObjectCoverageError(f"{objects}: no objects: build the module first")
    return found


def take(functions: dict[tuple[str, int], Function], symbols: Sequence[tuple[str, int, int]], blocks: str) -> None:
    """Marks what the blocks of one program have reached; `symbols`: name, address and bytes."""
    placed = [(address, functions[name, size]) for name, address, size in symbols if (name, size) in functions]
    places = {address + offset: (function, offset) for address, function in placed for offset in function.instructions}
    for line in blocks.splitlines():
        begin, end, fell, branched = (int(word, 16) for word in line.split())
        at = begin
        while at < end and at in places:
            function, offset = places[at]
            function.reached.add(offset)
            at += function.instructions[offset]
            if at == end and offset in function.branches:
                function.fell.update({offset} if fell else ())
                function.branched.update({offset} if branched else ())


def share(part: int, whole: int) -> str:
    """In percent, rounded down to a tenth, so that 100.0 is all."""
    return f"{(1000 * part // whole) / 10 if whole else 100.0:.1f}"


def counts_of(functions: Sequence[Function]) -> tuple[int, int, int, int]:
    """Instructions, those not reached, ways out of conditional branches, those not taken."""
    return (
        sum(len(function.instructions) for function in functions),
        sum(function.missed() for function in functions),
        sum(2 * len(function.branches) for function in functions),
        sum(function.ways_missed() for function in functions),
    )


def document(functions: Sequence[Function], programs: int, compiler: str) -> str:
    """docs/OBJECT_COVERAGE.md."""
    names = sorted({function.file for function in functions})
    counts = {name: counts_of([function for function in functions if function.file == name]) for name in names}
    all_of, missed, ways, untaken = counts_of(functions)
    lines = [
        "# Coverage of the object code",
        "",
        f"Which instructions of the module, as arm-none-eabi-gcc {compiler} with `-Os` makes them for a Cortex-M4F, a run of the suite on the emulated board has executed:",
        f"{programs} programs, the unit tests and two whole identifications. Written by",
        "",
        "    cmake --build build-cortex-m4f --target object_coverage",
        "",
        f"which fails below {AT_LEAST_PERCENT:g} % of the instructions or {AT_LEAST_BRANCHES_PERCENT:g} % of the ways out of conditional branches.",
        "What lines, branches and conditions of the source are reached, on the host: [COVERAGE](COVERAGE.md).",
        "",
        "An instruction that a condition before it skips (an IT block) counts as executed with its block: the emulator does not say. Tables of branches and calls are no conditional branches.",
        "Firmware that has another compiler or level has other object code: the command is its measurement, too.",
        "",
        "| | instructions | not reached | ways out of conditional branches | not taken |",
        "|---|---:|---:|---:|---:|",
        f"| all {len(names)} files | {all_of} | {missed} | {ways} | {untaken} |",
        f"| reached, % | {share(all_of - missed, all_of)} | | {share(ways - untaken, ways)} | |",
        *(f"| `{name}` | {' | '.join(str(count) for count in own)} |" for name, own in counts.items() if own[1] or own[3]),
        "",
    ]
    left = sorted((function for function in functions if function.missed()), key=lambda function: (-function.missed(), function.name))
    if left:
        lines += ["| function | instructions not reached | of |", "|---|---:|---:|"]
        lines += [f"| `{function.name}` | {function.missed()} | {len(function.instructions)} |" for function in left[:SHOWN]]
        lines += [f"| {len(left) - SHOWN} more | {sum(function.missed() for function in left[SHOWN:])} | |"] if len(left) > SHOWN else []
        lines += [""]
    return "\n".join(lines)


def sources_of(folder: Path) -> list[str]:
    """Names of the test sources that the build put into the program of this folder. Raises FileNotFoundError."""
    return re.findall(r"EMA_TEST_SOURCE_ROW\((\w+)\)", (folder / "ema_test_sources.def").read_text(encoding="utf-8"))


def problems_of(functions: Sequence[Function]) -> list[str]:
    """What is less than it has to be."""
    all_of, missed, ways, untaken = counts_of(functions)
    wanted = (("instructions", all_of, missed, AT_LEAST_PERCENT), ("ways out of branches", ways, untaken, AT_LEAST_BRANCHES_PERCENT))
    return [
        f"{share(whole - part, whole)} % of the {what} reached, at least {least:g} wanted"
        for what, whole, part, least in wanted
        if 100.0 * (whole - part) < least * whole
    ]


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--board", required=True, help="QEMU's name of the machine")
    parser.add_argument("--nm", required=True, help="nm of the cross compiler")
    parser.add_argument("--objdump", required=True, help="objdump of the cross compiler")
    parser.add_argument("--compiler", required=True, help="version of the cross compiler")
    parser.add_argument("--objects", type=Path, required=True, help="folder of the library's objects")
    parser.add_argument("--programs", type=Path, required=True, help="folder of the unit tests")
    parser.add_argument("--answer", type=Path, required=True, help="the program ema_answer")
    parser.add_argument("--work", type=Path, required=True, help="folder for what the programs reach")
    parser.add_argument("document", type=Path, help="written")
    given = parser.parse_args()
    source = Path(__file__).resolve().parent / "counted/qemu_reached.c"
    try:
        given.work.mkdir(parents=True, exist_ok=True)
        plugin = emulate.plugin_for(emulate.QEMU, source, "reached", given.work)
        functions = functions_of(given.objdump, given.nm, given.objects)
        runs: list[tuple[Path, tuple[str, ...]]] = [
            (given.programs / name, (source,)) for name in PROGRAMS for source in sources_of(given.programs.parent / name)
        ]
        runs += [(given.answer.with_name(name), arguments) for name, arguments in IDENTIFIES]
        for program, arguments in runs:
            reached = given.work / "reached"
            done = emulate.run(given.board, program, list(arguments), plugin=f"{plugin},reached={reached}")
            if done.exit_code != 0:
                raise ObjectCoverageError(f"{program.name} ended with {done.exit_code}: {done.output.strip()[-200:]}")
            take(functions, symbols_of(given.nm, program), reached.read_text(encoding="utf-8"))
    except (ObjectCoverageError, FileNotFoundError) as error:
        print(f"object_coverage: {error}", file=sys.stderr)
        return 1
    given.document.write_text(document(list(functions.values()), len(runs), given.compiler), encoding="utf-8")
    problems = problems_of(list(functions.values()))
    for problem in problems:
        print(f"object_coverage: {problem}", file=sys.stderr)
    print(f"{given.document.name} written: {len(functions)} functions, {len(runs)} programs")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
