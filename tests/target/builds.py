"""Builds the module by every compiler that is there, at every level, and writes what comes out of it as docs/BUILDS.md: code, stack, the longest slice and bits.

    python3 tests/target/builds.py --tables build-cortex-m4f/tests/target/records --exported build/exported --work build/builds -o docs/BUILDS.md

Each build identifies recorded case A by `ema_answer` and must print what the first one printed; and it looks for the longest slice by `ema_worst`, whose instructions are counted by the emulator
of the board, by a plugin of QEMU's user emulation (counted/qemu_count.c), or by wasmtime (counted/run_wasm.py, where this Python has that package). A compiler or emulator that is not there is
left out and said so. Python's standard library alone; no test, since few machines have all of the compilers.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path

import emulate
import same_answer
import stack

LEVELS = ("-O0", "-Og", "-Os", "-O2", "-O3")
EXACT = ("-std=c11", "-ffp-contract=off", "-fno-math-errno", "-ffunction-sections", "-fdata-sections")
ANSWER = ("a", "1", "1000", "real")
# What ema_worst ends with.
MOST = re.compile(r"^most slice (\d+) work (\d+) stack (\d+)$", re.MULTILINE)
WASI = Path("/usr/include/wasm32-wasi"), Path("/usr/lib/wasm32-wasi")


class BuildError(Exception):
    """What went wrong, with what to do."""


@dataclass(frozen=True)
class Machine:
    """A compiler and what runs its programs and counts: an emulator of the processor, a board, or wasmtime."""

    title: str
    compiler: str
    flags: tuple[str, ...] = ()
    emulator: str = ""
    board: str = ""
    wasm: bool = False
    levels: tuple[str, ...] = LEVELS

    @property
    def graph(self) -> bool:
        """Whether the compiler writes a call graph with the frames."""
        return "clang" not in self.compiler


def _cortex(core: str, *unit: str) -> tuple[str, ...]:
    return (f"-mcpu={core}", "-mthumb", *(("-mfloat-abi=hard", f"-mfpu={unit[0]}") if unit else ("-mfloat-abi=soft",)))


MACHINES = (
    Machine("gcc, x86-64", "gcc", ("-static",), "qemu-x86_64"),
    Machine("clang, x86-64", "clang", ("-static",), "qemu-x86_64", levels=("-O0", "-Os", "-O2", "-O3")),
    Machine("gcc, Cortex-M3, no float unit", "arm-none-eabi-gcc", _cortex("cortex-m3"), board="mps2-an385"),
    Machine("gcc, Cortex-M4F", "arm-none-eabi-gcc", _cortex("cortex-m4", "fpv4-sp-d16"), board="mps2-an386"),
    Machine("gcc, Cortex-M7", "arm-none-eabi-gcc", _cortex("cortex-m7", "fpv5-sp-d16"), board="mps2-an500"),
    Machine("gcc, Cortex-M33", "arm-none-eabi-gcc", _cortex("cortex-m33", "fpv5-sp-d16"), board="mps2-an505"),
    Machine("gcc, RISC-V, RV64GC", "riscv64-linux-gnu-gcc", ("-static",), "qemu-riscv64"),
    Machine("gcc, PowerPC, big-endian", "powerpc-linux-gnu-gcc", ("-static",), "qemu-ppc"),
    Machine(
        "clang, WebAssembly",
        "clang",
        ("--target=wasm32-wasi", "-mbulk-memory", "-isystem", str(WASI[0])),
        wasm=True,
        levels=("-Os", "-O2", "-O3"),
    ),
)


@dataclass(frozen=True)
class Built:
    """What came of a machine at a level: bytes of code and constants of the whole module, stack of the deepest public function and as used, instructions and work of the longest slice, its answer."""

    code: int
    stack: int | None
    used: int | None = None
    slice: int | None = None
    work: int | None = None
    answer: str = ""


def ran(command: Sequence[str | Path], what: str, counter: Path | None = None) -> str:
    """The output of a command, which is told of a file with a count. Raises BuildError."""
    environment = {**os.environ, **({} if counter is None else {"EMA_COUNTER": str(counter)})}
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, env=environment)
    if done.returncode != 0:
        raise BuildError(f"{what}: {(done.stderr or done.stdout).strip()[-400:]}")
    return done.stdout


def version_of(compiler: str) -> str:
    """The first number in what a compiler says of itself."""
    found = re.search(r"\d+\.\d+\.\d+", ran([compiler, "--version"], compiler))
    return found.group(0) if found else "unknown"


def counts_wasm() -> bool:
    """Whether this Python runs WebAssembly and counts its instructions."""
    return importlib.util.find_spec("wasmtime") is not None


@dataclass(frozen=True)
class Build:
    """One machine at one level, in a folder of its own."""

    root: Path
    exported: Path
    tables: Path
    machine: Machine
    level: str
    work: Path
    plugin: Path | None = None

    @property
    def folder(self) -> Path:
        """Of its objects."""
        return self.work / re.sub(r"\W+", "_", f"{self.machine.title}{self.level}")

    def includes(self) -> list[str]:
        """Folders of headers, as flags."""
        folders = [
            *([] if self.machine.board else [self.root / "tests/target/counted"]),
            self.root / "include",
            self.root / "src",
            self.root / "tests/target",
            self.root / "port/cortex_m",
            self.exported,
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
                    *flags,
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
        counter = [] if self.machine.board else [target / f"counted/ema_counter_{'wasm' if self.machine.wasm else 'shared'}.c"]
        own = self.objects([target / f"{name}.c", target / "ema_recorded.c", *counter], name)
        linked = self.folder / name / "program"
        link: list[str | Path] = [f"-L{WASI[1]}"] if self.machine.wasm else ["-lm"]
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
        what = f"{self.machine.title} {self.level}: {program.parent.name}"
        if self.machine.wasm:
            return ran([sys.executable, "-B", self.root / "tests/target/counted/run_wasm.py", program, *arguments], what)
        if self.plugin is not None:
            counter = self.folder / "counter"
            counter.write_bytes(bytes(8))
            return ran([self.machine.emulator, "-plugin", f"{self.plugin},counter={counter}", program, *arguments], what, counter)
        done = emulate.run(self.machine.board, program, list(arguments), shift=6)
        if done.exit_code != 0:
            raise BuildError(f"{self.machine.title} {self.level}: ended with {done.exit_code}: {done.output.strip()[-200:]}")
        return done.output

    def found(self) -> Built:
        """All that is told of it, kept in its folder. Raises BuildError and what it calls."""
        kept = self.folder / "built.json"
        if not kept.is_file():
            built = self.made()
            kept.write_text(json.dumps(asdict(built)), encoding="utf-8")
        return Built(**json.loads(kept.read_text(encoding="utf-8")))

    def made(self) -> Built:
        """The same, built and run. Raises BuildError and what it calls."""
        module = self.objects(sorted((self.root / "src").glob("*/*.c")), "module")
        sizer = "llvm-size" if self.machine.wasm else self.machine.compiler.replace("gcc", "size") if self.machine.graph else "size"
        tool = (
            shutil.which(sizer)
            or next((found for number in range(25, 10, -1) if (found := shutil.which(f"{sizer}-{number}"))), None)
            or "size"
        )
        code = sum(int(line.split()[0]) for line in ran([tool, *module], tool).splitlines()[1:])
        deepest = None
        if self.machine.graph:
            soft = "-mfloat-abi=soft" in self.machine.flags
            graph = stack.load(self.folder / "module", soft, own=not self.machine.board)
            deepest = max(graph.worst(name)[0] for name in stack.public_functions(self.root / "include/ema"))
        if self.machine.wasm and not counts_wasm():
            return Built(code, deepest)
        answer, _ = same_answer.shared_part(self.run(self.program("ema_answer", module), ANSWER), f"{self.machine.title} {self.level}")
        most = MOST.search(self.run(self.program("ema_worst", module), ["slices"]))
        if most is None:
            raise BuildError(f"{self.machine.title} {self.level}: ema_worst did not come to its end")
        longest, work, used = (int(number) for number in most.groups())
        return Built(code, deepest, used or None, longest, work, answer)


def table(found: Sequence[tuple[Machine, str, Built]]) -> list[str]:
    """The rows of the document. The bits are those of the first that ran."""
    first = next(built.answer for _, _, built in found if built.answer)
    rows = [
        "| compiler and machine | level | code and constants, bytes | stack, bytes: bound | used | longest slice, instructions | bits |",
        "|---|---|---:|---:|---:|---:|---|",
    ]
    for machine, level, built in found:
        bits = "by the page's own test" if not built.answer else "equal" if built.answer == first else "**other**"
        cells = " | ".join("-" if cell is None else grouped(cell) for cell in (built.code, built.stack, built.used, built.slice))
        rows.append(f"| {machine.title} | `{level}` | {cells} | {bits} |")
    return rows


def grouped(number: int) -> str:
    """With its thousands apart."""
    return f"{number:,}".replace(",", " ")


def work_of(found: Sequence[tuple[Machine, str, Built]]) -> int:
    """The most work of a slice, one number of all builds. Raises BuildError."""
    works = {built.work for _, _, built in found if built.work is not None}
    if len(works) != 1:
        raise BuildError(f"the longest slice is counted {sorted(works)} plain steps: it must be the same in every build")
    return works.pop()


def document(found: Sequence[tuple[Machine, str, Built]], versions: Sequence[str], left_out: Sequence[str]) -> str:
    """BUILDS.md."""
    return "\n".join(
        [
            "# Builds",
            "",
            "Written by a command; do not edit. To write it again, after `cmake --workflow --preset cortex-m4f`, which writes the recorded cases as a table:",
            "",
            "    python3 tests/target/builds.py --tables build-cortex-m4f/tests/target/records --exported build/exported --work build/builds -o docs/BUILDS.md",
            "",
            f"The same C files, with `{' '.join(EXACT)}` and the level, by {', '.join(versions)}.",
            "Code and constants are the sum over all of the module's objects with every effect, more than any firmware links: what the four calls take stands in [BUDGETS](BUDGETS.md).",
            "",
            "The stack's bound is that of [stack.py](../tests/target/stack.py), from the compiler's call graph, over all public functions; beside an operating system",
            "without what the C library's copies and square roots take. Used is what the sessions of the next column painted over.",
            "",
            "The longest slice is of 200, in the build's own instructions, found by [ema_worst](../tests/target/ema_worst.c) in whole sessions on records that no machine makes and, with the",
            "effects that have the longest slices where all were looked at ([BUDGETS](BUDGETS.md#the-longest-slice), the Cortex-M4F), free and with the highest friction, under six commands each.",
            "They are counted by the emulator of the board; by a plugin of QEMU's user emulation, for x86-64 too; and of WebAssembly by wasmtime, whose instructions are the format's own, each some",
            "of a processor, where the Python that runs the command has that package and wasi-libc is installed. They are no times.",
            f"In the module's own measure the longest slice of model steps was counted {work_of(found)} plain steps, in every build the same: the command fails where one differs.",
            "",
            "Bits: every line of a whole identification of case A, estimates, errors, objective, evaluations and the state of the random numbers, against those of the first row.",
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
    parser.add_argument("--exported", type=Path, required=True, help="folder of what the example firmware compiles in")
    parser.add_argument("--work", type=Path, required=True, help="folder of the objects, made anew")
    parser.add_argument("--resume", action="store_true", help="keep what a run before, of the same sources, has finished in it")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the document, overwritten")
    given = parser.parse_args()
    root = Path(__file__).resolve().parents[2]
    if not (given.tables / "ema_recorded_tables.inc").is_file():
        print(f"{given.tables}: no ema_recorded_tables.inc: run cmake --workflow --preset cortex-m4f first", file=sys.stderr)
        return 1
    if not given.resume:
        shutil.rmtree(given.work, ignore_errors=True)
    given.work.mkdir(parents=True, exist_ok=True)
    found: list[tuple[Machine, str, Built]] = []
    left_out, versions = [], {}
    for machine in MACHINES:
        tools = [machine.compiler, machine.emulator, emulate.QEMU if machine.board else ""]
        missing = [tool for tool in tools if tool and shutil.which(tool) is None]
        missing += [str(folder) for folder in WASI if machine.wasm and not folder.is_dir()]
        if missing:
            left_out.append(f"{machine.title} ({missing[0]})")
            continue
        versions[machine.compiler] = f"{machine.compiler} {version_of(machine.compiler)}"
        for level in machine.levels:
            print(f"{machine.title} {level}", flush=True)
            try:
                counts = root / "tests/target/counted/qemu_count.c"
                plugin = emulate.plugin_for(machine.emulator, counts, "counter", given.work.resolve()) if machine.emulator else None
                built = Build(root, given.exported.resolve(), given.tables.resolve(), machine, level, given.work.resolve(), plugin).found()
                found.append((machine, level, built))
                print(f"  {built.slice} instructions, {built.used} bytes", flush=True)
            except (BuildError, same_answer.WrongAnswerError, stack.StackError, FileNotFoundError) as error:
                print(error, file=sys.stderr)
                return 1
    try:
        given.output.write_text(document(found, list(versions.values()), left_out), encoding="utf-8")
    except BuildError as error:
        print(error, file=sys.stderr)
        return 1
    first = next(built.answer for _, _, built in found if built.answer)
    return 1 if any(built.answer not in ("", first) for _, _, built in found) else 0


if __name__ == "__main__":
    sys.exit(main())
