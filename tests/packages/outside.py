"""What the checks of the packages share: running programs as a stranger to the project would, and the verdict."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

# What would lead a program back into the project, or into an environment of the session that runs the checks.
LEADING_BACK = (
    "PYTHONPATH",
    "PYTHONHOME",
    "CPATH",
    "C_INCLUDE_PATH",
    "LIBRARY_PATH",
    "LD_LIBRARY_PATH",
    "PKG_CONFIG_PATH",
    "CMAKE_PREFIX_PATH",
)


class PackageError(Exception):
    """What a package lacks, in one line or with the output of the program that said so."""


def environment(**more: str) -> dict[str, str]:
    """The process's environment without whatever leads back into the project, and with `more`."""
    kept = {name: value for name, value in os.environ.items() if name not in LEADING_BACK and not name.startswith("EMA_")}
    return {**kept, **more}


def run(command: Sequence[str | Path], folder: Path, also: Mapping[str, str] | None = None) -> str:
    """What a program prints, run in `folder`. Raises PackageError with its output when it fails."""
    words = [str(word) for word in command]
    try:
        ran = subprocess.run(
            words,
            cwd=folder,
            env=environment(**(also or {})),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            check=False,
        )
    except FileNotFoundError:
        raise PackageError(f"{words[0]}: not on this machine: install the package that has it") from None
    if ran.returncode != 0:
        raise PackageError(f"this failed with {ran.returncode}: {' '.join(words)}\n{ran.stdout[-6000:]}")
    return ran.stdout


def expect(holds: bool, message: str) -> None:
    """Raises PackageError with `message` when what was expected does not hold."""
    if not holds:
        raise PackageError(message)


def fresh(folder: Path) -> Path:
    """`folder`, empty."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def version_of(root: Path) -> str:
    """The project's version, which every package has."""
    found = re.search(r"project\(EMA VERSION ([\d.]+)", (root / "CMakeLists.txt").read_text(encoding="utf-8"))
    expect(found is not None, "CMakeLists.txt: no project(EMA VERSION ...)")
    return found.group(1) if found is not None else ""


def bits(folder: Path, sources: Sequence[Path], includes: Sequence[Path], flags: Sequence[str]) -> str:
    """What the outside project prints, compiled with these files and flags as whoever took the package would."""
    project = shutil.copytree(Path(__file__).resolve().parent / "project", folder / "outside", dirs_exist_ok=True)
    compiler = environment().get("CC", "cc")
    asked = [*(f"-I{one}" for one in includes), *flags]
    run([compiler, "-std=c11", "-O1", *asked, "main.c", *sources, "-lm", "-o", "outside"], project)
    said = run([project / "outside"], folder)
    expect(said.startswith("0 ok: "), f"built from the package, the outside project says {said}")
    return said


def bits_of_sources(root: Path, work: Path) -> str:
    """The same from copies of the sources."""
    copy = work / "sources"
    for name in ("include", "src"):
        shutil.copytree(root / name, copy / name)
    return bits(work, sorted(copy.glob("src/*/*.c")), [copy / "include", copy / "src"], ["-ffp-contract=off", "-fno-math-errno"])


def main(name: str, check: Callable[[argparse.Namespace], str], *options: str) -> int:
    """Entry point of a check: --root, --work and `options`; prints what was shown, or why not."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    for option in options:
        parser.add_argument(option, default="")
    arguments = parser.parse_args()
    arguments.root = arguments.root.resolve()
    arguments.work = fresh(arguments.work.resolve())
    try:
        print(f"{name}: {check(arguments)}")
    except PackageError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    return 0
