"""Runs clang-tidy with the checks of .clang-tidy on every file of src, with each of its compile commands; any warning fails.

A file with a known fault is looked at with the same settings: where it is not found, nothing else was sought either. Without clang-tidy the check is
skipped (exit code 77).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sources import c_files, fail, finish

SKIP = 77
TIDIES = ("clang-tidy", *(f"clang-tidy-{version}" for version in range(22, 13, -1)))
FINDING = re.compile(r"^(/.+?):(\d+):\d+: (?:warning|error): (.*)$")

# A condition that assigns.
SEEDED = "int ema_seeded(int a);\nint ema_seeded(int a)\n{\n    if (a = 3) {\n        return 1;\n    }\n    return 0;\n}\n"


def run_tidy(tidy: str, arguments: list[str], root: Path) -> list[str]:
    """Findings of one run, one line each; a run that fails without one says so."""
    run = subprocess.run(
        [tidy, "--quiet", f"--config-file={root / '.clang-tidy'}", *arguments], capture_output=True, text=True, check=False
    )
    found: list[str] = []
    for line in run.stdout.splitlines():
        match = FINDING.match(line)
        if match is not None:
            path = Path(match.group(1))
            shown = path.relative_to(root) if path.is_relative_to(root) else path.name
            found.append(f"{shown}:{match.group(2)}: {match.group(3).replace(',-warnings-as-errors', '')}")
    if run.returncode != 0 and not found:
        found.append(f"{arguments[-1]}: clang-tidy failed: {(run.stderr or run.stdout).strip().splitlines()[-1:]}")
    return found


def commands(build: Path) -> dict[Path, int]:
    """How many compile commands each file has. Raises ValueError when the build folder has none."""
    listed = build / "compile_commands.json"
    try:
        entries = json.loads(listed.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"{listed}: cannot be read: configure with the preset analysis first ({error.strerror})") from None
    counts: dict[Path, int] = {}
    for entry in entries:
        path = (Path(entry["directory"]) / entry["file"]).resolve()
        counts[path] = counts.get(path, 0) + 1
    return counts


def check(root: Path, build: Path, tidy: str, jobs: int) -> tuple[list[str], int]:
    """Problems, and the number of files looked at."""
    files = c_files(root, "src", suffixes=(".c",))
    known = commands(build)
    problems = [
        f"{file.relative_to(root)}: {known.get(file, 0)} compile commands in {build}: it is built in float32 and in float64, configure again"
        for file in files
        if known.get(file, 0) < 2
    ]
    if not files or problems:
        return problems, len(files)
    with tempfile.TemporaryDirectory() as folder:
        seeded = Path(folder).resolve() / "ema_seeded.c"
        seeded.write_text(SEEDED, encoding="utf-8")
        if not any("ema_seeded.c:4: " in finding for finding in run_tidy(tidy, [str(seeded), "--", "-std=c11"], root)):
            return [f"{tidy}: finds nothing in a file with a known fault: see the checks of .clang-tidy"], len(files)
    # The options of the compiler that built are not all clang's.
    flags = ["-p", str(build), "--extra-arg=-Wno-unknown-warning-option"]
    with ThreadPoolExecutor(jobs) as pool:
        for found in pool.map(lambda file: run_tidy(tidy, [*flags, str(file)], root), files):
            problems += found
    return sorted(set(problems)), len(files)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    tidy = next((path for name in TIDIES if (path := shutil.which(name))), None)
    if tidy is None:
        print("tidy: no clang-tidy on this machine, check skipped: install the package clang-tidy to run it")
        return SKIP
    try:
        problems, checked = check(arguments.root.resolve(), arguments.build.resolve(), tidy, arguments.jobs)
    except ValueError as error:
        return fail(f"tidy: {error}")
    return finish("tidy", problems, checked, "files")


if __name__ == "__main__":
    sys.exit(main())
