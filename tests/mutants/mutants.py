"""Applies the faults of mutants.toml one at a time to a copy of the tree and prints which test catches each, as a Markdown table.

Without --suite the tests named in the table run, first those of the quick suite, then the long ones. With --suite that whole suite runs for every fault, until its first
failure. The copy and its build are kept in --work, so that a second run builds what has changed alone. No library serves: tools for mutation make every possible small
change of one language, and their runs would take weeks here. Exit code 1: a fault is caught by nothing, or its text is not found once.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDERS = ("src", "port/host", "tools/ema_tools")
SUFFIXES = {".c", ".h", ".def", ".py"}
MARKS = {"quick": "not slow and not release", "long": "slow and not release"}
LABELS = {"quick": ["-LE", "long|release"], "long": ["-L", "long"]}
NO_TEST_RAN = 5  # of pytest
TIMEOUT_S = 3600.0
FAILED = re.compile(r"^FAILED tests/(\S+)|^ERROR tests/(\S+)", re.MULTILINE)
FAILED_C = re.compile(r":(test_\w+):FAIL")
FAILED_CTEST = re.compile(r"^\s*\d+ - (\S+) \(", re.MULTILINE)


class MutantError(Exception):
    """A fault that cannot be applied, or a copy that cannot be built or fails without a fault."""


@dataclass(frozen=True)
class Mutant:
    """One fault: `new` in place of `old`, and the tests that should see it."""

    name: str
    module: str
    fault: str
    old: str
    new: str
    tests: tuple[str, ...]


@dataclass(frozen=True)
class Caught:
    """The test that failed, and the suite that it belongs to; empty where none failed."""

    test: str = ""
    suite: str = ""


def read_mutants(path: Path) -> list[Mutant]:
    """The table. Raises MutantError for a name that is used twice."""
    rows = tomllib.loads(path.read_text(encoding="utf-8"))["mutant"]
    mutants = [Mutant(**{**row, "tests": tuple(row["tests"])}) for row in rows]
    names = [mutant.name for mutant in mutants]
    if len(set(names)) < len(names):
        raise MutantError(f"{path.name}: a name is used twice: {', '.join(sorted({name for name in names if names.count(name) > 1}))}")
    return mutants


def place_of(mutant: Mutant, tree: Path) -> Path:
    """The one file that holds the fault's text once. Raises MutantError."""
    found = []
    for folder in FOLDERS:
        for path in sorted((tree / folder).rglob("*")):
            if path.suffix in SUFFIXES and path.is_file():
                found += [path] * path.read_text(encoding="utf-8").count(mutant.old)
    if len(found) != 1:
        places = ", ".join(str(path.relative_to(tree)) for path in found) or "nowhere"
        raise MutantError(f"{mutant.name}: its text must stand once, and stands {places}: correct `old` in mutants.toml")
    return found[0]


def copy_tree(tree: Path) -> None:
    """Bring the copy up to date with the files of this clone that git knows or does not ignore; files that did not change keep their times."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    wanted = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
    for folder, folders, names in os.walk(tree):
        folders[:] = [name for name in folders if Path(folder) != tree or not name.startswith("build")]
        for name in names:
            if (Path(folder) / name).relative_to(tree).as_posix() not in wanted:
                (Path(folder) / name).unlink()
    for name in sorted(wanted):
        source, target = ROOT / name, tree / name
        if not target.is_file() or target.read_bytes() != source.read_bytes():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)


def run(command: list[str], folder: Path) -> tuple[int, str]:
    """Exit code and output of a command; nothing that Python has compiled is kept, since a fault may have the size and the time of the file that it replaces."""
    build = folder if folder.name == "build" else folder.parent / "build"
    environment = {
        **os.environ,
        "EMA_LIBRARY_DIR": str(build / "lib"),
        "EMA_BIN_DIR": str(build / "bin"),
        "OPENBLAS_NUM_THREADS": "1",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment, timeout=TIMEOUT_S)
    except subprocess.TimeoutExpired:
        return 1, ""
    return done.returncode, done.stdout + done.stderr


class Tree:
    """A copy of the tree with a build of its own."""

    def __init__(self, folder: Path, jobs: int) -> None:
        self.folder, self.build, self.jobs = folder, folder / "build", jobs

    def make(self, *targets: str) -> bool:
        """Build the targets, or everything; False where that fails."""
        return run(["cmake", "--build", ".", f"-j{self.jobs}", *(["--target", *targets] if targets else [])], self.build)[0] == 0

    def prepare(self) -> None:
        """Copy and build. Raises MutantError."""
        self.folder.mkdir(parents=True, exist_ok=True)
        copy_tree(self.folder)
        code, output = run(["cmake", "--preset", "test"], self.folder)
        if code != 0 or not self.make():
            raise MutantError(f"{self.folder}: cannot be built: {(output.strip().splitlines() or ['see cmake --build --preset test'])[-1]}")

    def c_test(self, name: str) -> str:
        """What fails in a C test; empty where it passes. Raises MutantError."""
        if not self.make(f"ema_tests_{name.rpartition('_')[2]}"):
            raise MutantError(f"{name} does not compile: correct `new` in mutants.toml")
        code, output = run(["ctest", "-R", f"^{name}$", "--no-tests=error", "--output-on-failure"], self.build)
        failed = FAILED_C.search(output)
        return "" if code == 0 else f"{name}: {failed[1]}" if failed else name

    def python_tests(self, files: tuple[str, ...], suite: str, *more: str) -> str:
        """What fails first in files of tools/tests, or in all of them; empty where everything passes."""
        command = [str(self.build / "venv/bin/python"), "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", MARKS[suite], *more]
        code, output = run([*command, *(f"tests/{name}" for name in files)], self.folder / "tools")
        failed = FAILED.search(output)
        return "" if code in (0, NO_TEST_RAN) else (failed[1] or failed[2]) if failed else "pytest ends without a result"

    def named(self, tests: tuple[str, ...]) -> Caught:
        """The first of the named tests that fails. Raises MutantError."""
        files = tuple(name for name in tests if name.endswith(".py"))
        for name in tests:
            if name not in files and (failed := self.c_test(name)):
                return Caught(failed, "quick")
        # the libraries may be those of the fault before
        if files and not self.make():
            raise MutantError("the libraries do not compile: correct `new` in mutants.toml")
        for suite in MARKS:
            if files and (failed := self.python_tests(files, suite)):
                return Caught(failed, suite)
        return Caught()

    def whole(self, suite: str) -> Caught:
        """The first failure of a whole suite: C and the checks, then Python. Raises MutantError."""
        if not self.make():
            raise MutantError("the tree does not compile: correct `new` in mutants.toml")
        code, output = run(
            ["ctest", *LABELS[suite], "-E", "^python", f"-j{self.jobs}", "--stop-on-failure", "--output-on-failure"], self.build
        )
        if code != 0:
            failed = FAILED_CTEST.search(output)
            return Caught(failed[1] if failed else "ctest", suite)
        failed_python = self.python_tests((), suite, "-n", str(self.jobs))
        return Caught(failed_python, suite) if failed_python else Caught()


def tried(mutant: Mutant, tree: Tree, suite: str | None) -> Caught:
    """What catches a fault. The copy is as it was afterwards. Raises MutantError."""
    path = place_of(mutant, tree.folder)
    sound = path.read_text(encoding="utf-8")
    path.write_text(sound.replace(mutant.old, mutant.new), encoding="utf-8")
    try:
        return tree.whole(suite) if suite else tree.named(mutant.tests)
    finally:
        path.write_text(sound, encoding="utf-8")


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", action="append", metavar="NAME", help="this fault alone; may be given more than once")
    parser.add_argument("--suite", choices=tuple(MARKS), help="the whole suite for every fault, in place of the tests that the table names")
    parser.add_argument("--list", action="store_true", help="only look whether every fault's text stands once")
    parser.add_argument("--work", type=Path, default=ROOT / "build-mutants", help="folder of the copy (default: build-mutants)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    survived = 0
    try:
        mutants = read_mutants(HERE / "mutants.toml")
        unknown = set(given.only or ()) - {mutant.name for mutant in mutants}
        if unknown:
            raise MutantError(f"--only: no fault is called {', '.join(sorted(unknown))}: see mutants.toml")
        mutants = [mutant for mutant in mutants if not given.only or mutant.name in given.only]
        named = tuple(dict.fromkeys(name for mutant in mutants for name in mutant.tests))
        lost = [name for name in named if name.endswith(".py") and not (ROOT / "tools/tests" / name).is_file()]
        if lost:
            raise MutantError(f"mutants.toml names tests that are not there: {', '.join(lost)}")
        for mutant in mutants:
            place_of(mutant, ROOT)
        if given.list:
            print(f"{len(mutants)} faults, each text stands once")
            return 0
        tree = Tree(given.work.resolve() / "tree", given.jobs)
        tree.prepare()
        without = tree.whole(given.suite) if given.suite else tree.named(named)
        if without.test:
            raise MutantError(f"{without.test} fails without any fault: mend that first")
        print("| mutant | module | fault | caught by | suite | s |\n|---|---|---|---|---|---|", flush=True)
        for mutant in mutants:
            start = time.monotonic()
            caught = tried(mutant, tree, given.suite)
            survived += not caught.test
            shown = f"`{caught.test}` | {caught.suite}" if caught.test else "nothing |"
            print(f"| {mutant.name} | {mutant.module} | {mutant.fault} | {shown} | {time.monotonic() - start:.0f} |", flush=True)
    except MutantError as error:
        print(f"mutants: {error}", file=sys.stderr)
        return 1
    print(f"\n{len(mutants)} faults, {len(mutants) - survived} caught, {survived} not")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
