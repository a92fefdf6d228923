"""Builds the module by every compiler that is there, at every level, and writes what comes out of it as docs/BUILDS.md: code, stack and bits.

    python3 tests/target/builds.py --tables build-cortex-m4f/tests/target/records --work build/builds -o docs/BUILDS.md

Each build identifies recorded case A by `ema_answer`, on the machine itself, under QEMU's user emulation or on an emulated board, and must print what the first one printed. A compiler that
is not there is left out and said so. Python's standard library alone; no test, since few machines have all of the compilers.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import emulate
import same_answer
import stack

LEVELS = ("-O0", "-Og", "-Os", "-O2", "-O3")
EXACT = ("-std=c11", "-ffp-contract=off", "-fno-math-errno", "-ffunction-sections", "-fdata-sections")
ANSWER = ("a", "1", "1000", "real")


class BuildError(Exception):
    """What went wrong, with what to do."""


@dataclass(frozen=True)
class Machine:
    """A compiler and what runs its programs: nothing on this machine, a command before the program, or a board. `bare`: no C library, so that nothing is linked and run."""

    title: str
    compiler: str
    flags: tuple[str, ...] = ()
    runner: tuple[str, ...] = ()
    board: str = ""
    bare: bool = False
    levels: tuple[str, ...] = LEVELS

    @property
    def graph(self) -> bool:
        """Whether the compiler writes a call graph with the frames."""
        return "clang" not in self.compiler


def _cortex(core: str, *unit: str) -> tuple[str, ...]:
    return (f"-mcpu={core}", "-mthumb", *(("-mfloat-abi=hard", f"-mfpu={unit[0]}") if unit else ("-mfloat-abi=soft",)))


MACHINES = (
    Machine("gcc, x86-64", "gcc"),
    Machine("clang, x86-64", "clang", levels=("-O0", "-Os", "-O2", "-O3")),
    Machine("gcc, Cortex-M3, no float unit", "arm-none-eabi-gcc", _cortex("cortex-m3"), board="mps2-an385"),
    Machine("gcc, Cortex-M4F", "arm-none-eabi-gcc", _cortex("cortex-m4", "fpv4-sp-d16"), board="mps2-an386"),
    Machine("gcc, Cortex-M7", "arm-none-eabi-gcc", _cortex("cortex-m7", "fpv5-sp-d16"), board="mps2-an500"),
    Machine("gcc, Cortex-M33", "arm-none-eabi-gcc", _cortex("cortex-m33", "fpv5-sp-d16"), board="mps2-an505"),
    Machine("gcc, RISC-V, RV64GC", "riscv64-linux-gnu-gcc", ("-static",), ("qemu-riscv64",)),
    Machine("gcc, PowerPC, big-endian", "powerpc-linux-gnu-gcc", ("-static",), ("qemu-ppc",)),
    Machine(
        "clang, WebAssembly",
        "clang",
        ("--target=wasm32", "-mbulk-memory", "-isystem", "port/wasm/include"),
        bare=True,
        levels=("-Os", "-O2", "-O3"),
    ),
)


@dataclass(frozen=True)
class Built:
    """What came of a machine at a level: bytes of code and constants of the whole module, the deepest public function's stack, and its answer."""

    code: int
    stack: int | None
    answer: str


def ran(command: Sequence[str | Path], what: str) -> str:
    """The output of a command. Raises BuildError."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise BuildError(f"{what}: {(done.stderr or done.stdout).strip()[-400:]}")
    return done.stdout


def version_of(compiler: str) -> str:
    """The first number in what a compiler says of itself."""
    found = re.search(r"\d+\.\d+\.\d+", ran([compiler, "--version"], compiler))
    return found.group(0) if found else "unknown"


@dataclass(frozen=True)
class Build:
    """One machine at one level, in a folder of its own."""

    root: Path
    tables: Path
    machine: Machine
    level: str
    work: Path

    @property
    def folder(self) -> Path:
        """Of its objects."""
        return self.work / re.sub(r"\W+", "_", f"{self.machine.title}{self.level}")

    def includes(self) -> list[str]:
        """Folders of headers, as flags."""
        folders = [
            self.root / "include",
            *sorted(path for path in (self.root / "src").iterdir() if path.is_dir()),
            self.root / "tests/target",
            self.root / "port/cortex_m",
            self.root / "port/cortex_m/example",
            self.tables,
        ]
        return [f"-I{folder}" for folder in folders]

    def objects(self, sources: Sequence[Path], name: str) -> list[Path]:
        """Compiles, on all cores. Raises BuildError."""
        folder = self.folder / name
        folder.mkdir(parents=True, exist_ok=True)
        graph = ["-fcallgraph-info=su"] if self.machine.graph else []
        board = ["-DEMA_BOARD_AN505"] if self.machine.board == "mps2-an505" else []
        flags = [flag for flag in self.machine.flags if flag != "-static"]

        def made(source: Path) -> Path:
            made_of = folder / f"{source.stem}.o"
            ran(
                [
                    self.machine.compiler,
                    *(str(self.root / flag) if flag.startswith("port/") else flag for flag in flags),
                    *EXACT,
                    self.level,
                    *graph,
                    *board,
                    *self.includes(),
                    "-c",
                    source,
                    "-o",
                    made_of,
                ],
                source.name,
            )
            return made_of

        with ThreadPoolExecutor() as pool:
            return list(pool.map(made, sources))

    def program(self, name: str, module: Sequence[Path]) -> Path:
        """Links `tests/target/<name>.c` with the recorded cases. Raises BuildError."""
        target = self.root / "tests/target"
        own = self.objects([target / f"{name}.c", target / "ema_recorded.c"], name)
        linked = self.folder / name / "program"
        link: list[str | Path] = ["-lm"]
        if self.machine.board:
            port = self.root / "port/cortex_m"
            own += self.objects([port / "startup.c", port / "ema_counter.c"], "board")
            script = port / ("mps2-an505.ld" if self.machine.board == "mps2-an505" else "mps2.ld")
            link = ["-nostartfiles", "--specs=rdimon.specs", "-Wl,--gc-sections", "-Wl,-u,ema_vectors", f"-L{port}", f"-T{script}", "-lm"]
        ran(
            [self.machine.compiler, *self.machine.flags, *own, *module, "-o", linked, *link],
            f"{self.machine.title} {self.level}: linking {name}",
        )
        return linked

    def run(self, program: Path, arguments: Sequence[str]) -> str:
        """What a program prints. Raises BuildError."""
        if not self.machine.board:
            return ran([*self.machine.runner, program, *arguments], program.name)
        done = emulate.run(self.machine.board, program, list(arguments))
        if done.exit_code != 0:
            raise BuildError(f"{self.machine.title} {self.level}: ended with {done.exit_code}: {done.output.strip()[-200:]}")
        return done.output

    def made(self) -> Built:
        """All that is told of it. Raises BuildError and what it calls."""
        module = self.objects(sorted((self.root / "src").glob("*/*.c")), "module")
        sizer = "llvm-size" if self.machine.bare else self.machine.compiler.replace("gcc", "size") if self.machine.graph else "size"
        tool = (
            shutil.which(sizer)
            or next((found for number in range(25, 10, -1) if (found := shutil.which(f"{sizer}-{number}"))), None)
            or "size"
        )
        code = sum(int(line.split()[0]) for line in ran([tool, *module], tool).splitlines()[1:])
        deepest = None
        if self.by_graph:
            soft = "-mfloat-abi=soft" in self.machine.flags
            deepest = max(size for size, _ in stack.worst_of(self.folder / "module", self.root / "include/ema", soft).values())
        if self.machine.bare:
            return Built(code, deepest, "")
        answer, _ = same_answer.shared_part(self.run(self.program("ema_answer", module), ANSWER), f"{self.machine.title} {self.level}")
        return Built(code, deepest, answer)

    @property
    def by_graph(self) -> bool:
        """Whether the stack is bounded: by gcc for the cores, of whose library's frames the bound knows."""
        return bool(self.machine.board) and self.machine.graph


def table(found: Sequence[tuple[Machine, str, Built]]) -> list[str]:
    """The rows of the document. The bits are those of the first that ran."""
    first = next(built.answer for _, _, built in found if built.answer)
    rows = ["| compiler and machine | level | code and constants, bytes | deepest stack, bytes | bits |", "|---|---|---:|---:|---|"]
    for machine, level, built in found:
        bits = "by the page's own test" if machine.bare else "equal" if built.answer == first else "**other**"
        cells = (built.code, built.stack)
        rows.append(
            f"| {machine.title} | `{level}` | {' | '.join('-' if cell is None else f'{cell:,}'.replace(',', ' ') for cell in cells)} | {bits} |"
        )
    return rows


def document(found: Sequence[tuple[Machine, str, Built]], versions: Sequence[str], left_out: Sequence[str]) -> str:
    """BUILDS.md."""
    return "\n".join(
        [
            "# Builds",
            "",
            "Written by a command; do not edit. To write it again, after `cmake --workflow --preset cortex-m4f`, which writes the recorded cases as a table:",
            "",
            "    python3 tests/target/builds.py --tables build-cortex-m4f/tests/target/records --work build/builds -o docs/BUILDS.md",
            "",
            f"The same C files, with `{' '.join(EXACT)}` and the level, by {', '.join(versions)}.",
            "Code and constants are the sum over all of the module's objects with every effect, more than any firmware links: what the four calls take stands in [BUDGETS](BUDGETS.md).",
            "The stack is the bound of [stack.py](../tests/target/stack.py), from the compiler's call graph, over all public functions.",
            "Bits: every line of a whole identification of case A, estimates, errors, objective, evaluations and the state of the random numbers, against those of the first row,",
            "by the processor itself, QEMU's user emulation, or an emulated board.",
            "The longest slice is counted where the emulator counts instructions, over effects, commands and records on the Cortex-M4F, in [BUDGETS](BUDGETS.md#the-longest-slice);",
            "its plain steps of work are the same in every build.",
            "WebAssembly is linked into the page of a diagnosis, whose tests hold its bits against the library's.",
            *(["", f"Left out, since this machine lacks them: {', '.join(left_out)}."] if left_out else []),
            "",
            *table(found),
            "",
        ]
    )


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tables", type=Path, required=True, help="folder of ema_recorded_tables.inc")
    parser.add_argument("--work", type=Path, required=True, help="folder of the objects, made anew")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the document, overwritten")
    given = parser.parse_args()
    root = Path(__file__).resolve().parents[2]
    if not (given.tables / "ema_recorded_tables.inc").is_file():
        print(f"{given.tables}: no ema_recorded_tables.inc: run cmake --workflow --preset cortex-m4f first", file=sys.stderr)
        return 1
    shutil.rmtree(given.work, ignore_errors=True)
    found: list[tuple[Machine, str, Built]] = []
    left_out, versions = [], {}
    for machine in MACHINES:
        missing = [
            tool for tool in (machine.compiler, *machine.runner, *([emulate.QEMU] if machine.board else ())) if shutil.which(tool) is None
        ]
        if missing:
            left_out.append(f"{machine.title} ({missing[0]})")
            continue
        versions[machine.compiler] = f"{machine.compiler} {version_of(machine.compiler)}"
        for level in machine.levels:
            print(f"{machine.title} {level}", flush=True)
            try:
                found.append((machine, level, Build(root, given.tables.resolve(), machine, level, given.work.resolve()).made()))
            except (BuildError, same_answer.WrongAnswerError, stack.StackError, FileNotFoundError) as error:
                print(error, file=sys.stderr)
                return 1
    given.output.write_text(document(found, list(versions.values()), left_out), encoding="utf-8")
    first = next(built.answer for _, _, built in found if built.answer)
    return 1 if any(built.answer not in ("", first) for _, _, built in found) else 0


if __name__ == "__main__":
    sys.exit(main())
