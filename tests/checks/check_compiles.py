"""Compiles without linking, for facts that the build does not show.

`headers`: every header of include and src compiles alone, and twice. `clang`: clang's own warning about hidden
conversions between float types, which gcc lacks; without clang the check is skipped (exit code 77).
Both in float32 and in float64.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from sources import c_files, finish

SKIP = 77
CLANGS = ("clang", *(f"clang-{version}" for version in range(22, 13, -1)))
COMMON = ["-std=c11", "-fsyntax-only", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]


def include_flags(root: Path) -> list[str]:
    """Search path of a file of the module."""
    folders = [root / "include", *sorted(path for path in (root / "src").glob("*") if path.is_dir()), root / "port" / "host"]
    return [flag for folder in folders for flag in ("-I", str(folder))]


def compile_errors(compiler: str, flags: list[str], file: Path) -> str:
    """The compiler's first error line, empty when there is none."""
    run = subprocess.run([compiler, *COMMON, *flags, str(file)], capture_output=True, text=True, check=False)
    if run.returncode == 0:
        return ""
    lines = run.stderr.strip().splitlines()
    return next((line for line in lines if "error:" in line), lines[-1] if lines else "the compiler failed")


def check_headers(root: Path, compiler: str) -> tuple[list[str], int]:
    """Each header included twice in an otherwise empty file."""
    problems: list[str] = []
    headers = c_files(root, "include", "src", suffixes=(".h",))
    with tempfile.TemporaryDirectory() as folder:
        for header in headers:
            unit = Path(folder) / f"{header.stem}.c"
            # ISO C wants at least one declaration in a file.
            unit.write_text(f'#include "{header}"\n#include "{header}"\nextern int ema_header_check;\n', encoding="utf-8")
            for real64 in (0, 1):
                error = compile_errors(compiler, [*include_flags(root), f"-DEMA_REAL64={real64}"], unit)
                if error:
                    problems.append(f"{header.relative_to(root)} alone, EMA_REAL64={real64}: {error}")
    return problems, len(headers)


def check_clang(root: Path, compiler: str) -> tuple[list[str], int]:
    """Every C file of the module and its ports with clang's float conversion warnings as errors."""
    problems: list[str] = []
    files = [file for file in c_files(root, "src", "port", suffixes=(".c",)) if "cortex_m" not in file.parts]
    for file in files:
        for real64 in (0, 1):
            flags = [*include_flags(root), f"-DEMA_REAL64={real64}", "-Wimplicit-float-conversion", "-Wfloat-conversion",
                     "-Wdouble-promotion"]
            error = compile_errors(compiler, flags, file)
            if error:
                problems.append(f"{file.relative_to(root)}, EMA_REAL64={real64}: {error}")
    return problems, len(files)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("headers", "clang"))
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--compiler", default="cc")
    arguments = parser.parse_args()
    root = arguments.root.resolve()
    if arguments.what == "headers":
        problems, checked = check_headers(root, arguments.compiler)
        return finish("headers", problems, checked, "headers")
    clang = next((path for name in CLANGS if (path := shutil.which(name))), None)
    if clang is None:
        print("clang: not on this machine, check skipped: install the package clang to run it")
        return SKIP
    problems, checked = check_clang(root, clang)
    return finish("clang", problems, checked, "files")


if __name__ == "__main__":
    sys.exit(main())
