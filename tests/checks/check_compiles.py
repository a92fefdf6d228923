"""Compiles without linking, for facts that the build does not show.

No library serves: CMake's own check of header sets knows neither private headers, nor two precisions, nor a second
inclusion, and none knows blocks of C in documents. `headers`: every header of include and src compiles alone, and twice.
`snippets`: every block of C in README.md and docs compiles, and none is indented instead of fenced; rows of effects are
compiled as effects of the user.
All in float32 and in float64.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from sources import c_files, finish

# Documents that live by their C: one in which no block is found has lost it, or hides it from this check.
DOCUMENTS = ("README.md", "docs/FIRMWARE.md", "docs/ONBOARD_DIAGNOSIS.md", "docs/YOUR_OWN_EFFECT.md", "docs/ADD_AN_EFFECT.md")
BLOCK = re.compile(r"^ {0,3}```+[ \t]*[cC]\b[^\n]*\n(.*?)^ {0,3}```", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"^ {0,3}```.*?^ {0,3}```", re.MULTILINE | re.DOTALL)
# A statement or declaration in an indented block, where nothing compiles it.
INDENTED = re.compile(r"^(?: {4}|\t).*;[ \t]*(?:/\*.*)?$", re.MULTILINE)
ROW = re.compile(r"^EMA_EFFECT\((\w+),", re.MULTILINE)
# Names in the documents of headers that `ema export` writes, and the exported headers of the example firmware.
EXPORTED = {"ema_actuator_data.h": "ace_actuator.h", "ema_signatures.h": "ace_signatures.h"}
# Whatever reads rows of effects: their sites, the structures, the ranges of their values.
ROWS_READ = ("effects/ema_effect_sites.h", "base/ema_actuator.c")
UNITY = ["-DUNITY_INCLUDE_DOUBLE", "-DUNITY_SUPPORT_64"]
COMMON = ["-std=c11", "-fsyntax-only", "-ffp-contract=off", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]


def include_flags(root: Path) -> list[str]:
    """Search path of a file of the module."""
    folders = [
        root / "include",
        root / "src",
        root / "port" / "host",
        root / "port" / "desk",
    ]
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


def blocks_of(root: Path, document: Path) -> list[str]:
    """The document's blocks of C, each beginning with its place; an effect that the library already has gets another name."""
    text = document.read_text(encoding="utf-8")
    taken = set(ROW.findall((root / "include/ema/ema_effects.def").read_text(encoding="utf-8")))
    blocks = []
    for match in BLOCK.finditer(text):
        line = text.count("\n", 0, match.start(1)) + 1
        blocks.append(f'#line {line} "{document.relative_to(root)}"\n{match[1]}')
    for name in {name for block in blocks for name in ROW.findall(block)} & taken:
        blocks = [block.replace(name, f"{name}_shown") for block in blocks]
    return blocks


def check_snippets(
    root: Path, compiler: str, exported: Path, also: list[str], documents: tuple[str, ...] = DOCUMENTS
) -> tuple[list[str], int]:
    """Every block of C in the documents. `exported`: folder of headers that `ema export` wrote; `also`: folders of headers that are not the project's."""
    problems: list[str] = []
    checked = 0
    found = sorted({root / "README.md", *(root / name for name in documents), *(root / "docs").rglob("*.md")})
    for document in found:
        if not document.is_file():
            problems.append(f"{document.relative_to(root)}: not there: correct DOCUMENTS in check_compiles.py")
            continue
        blocks = blocks_of(root, document)
        checked += len(blocks)
        if not blocks and str(document.relative_to(root)) in documents:
            problems.append(
                f"{document.relative_to(root)}: no block of C in it: begin one with ```c, or take the document out of DOCUMENTS in check_compiles.py"
            )
        text = FENCED.sub(lambda block: "\n" * block[0].count("\n"), document.read_text(encoding="utf-8"))
        problems += [
            f"{document.relative_to(root)}:{text.count(chr(10), 0, line.start()) + 1}: C in an indented block is not compiled: begin a block with ```c"
            for line in INDENTED.finditer(text)
        ]
        with tempfile.TemporaryDirectory() as folder:
            problems += [
                f"{document.relative_to(root)}, {error}" for error in snippet_errors(root, compiler, exported, also, Path(folder), blocks)
            ]
    return problems, checked


def snippet_errors(root: Path, compiler: str, exported: Path, also: list[str], folder: Path, blocks: list[str]) -> list[str]:
    """First error of each of a document's blocks, in each precision."""
    errors: list[str] = []
    for name, header in EXPORTED.items():
        (folder / name).write_text(f'#include "{exported / header}"\n', encoding="utf-8")
    rows = [block for block in blocks if ROW.search(block)]
    flags = [
        "-I",
        str(folder),
        *include_flags(root),
        "-I",
        str(root / "tests/support"),
        *UNITY,
        *(flag for place in also for flag in ("-isystem", place)),
    ]
    units = [block for block in blocks if block not in rows]
    if rows:
        (folder / "own_effects.def").write_text("\n".join(rows), encoding="utf-8")
        flags.append('-DEMA_OWN_EFFECTS="own_effects.def"')
        flags.append("-DEMA_CONFIG_SCHEMA=0U")  # as CMake gives it for other lists; nothing is linked here
        units.insert(0, "".join(f'#include "{name}"\n' for name in ROWS_READ))
    for number, text in enumerate(units):
        unit = folder / f"snippet_{number}.c"
        unit.write_text(text, encoding="utf-8")
        for real64 in (0, 1):
            error = compile_errors(compiler, [*flags, f"-DEMA_REAL64={real64}"], unit)
            if error:
                errors.append(f"EMA_REAL64={real64}: {error}")
    return errors


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("headers", "snippets"))
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--compiler", default="cc")
    parser.add_argument("--exported", type=Path, help="snippets: folder of headers that `ema export` wrote")
    parser.add_argument("--also", action="append", default=[], help="snippets: a folder of headers that are not the project's")
    arguments = parser.parse_args()
    root = arguments.root.resolve()
    if arguments.what == "headers":
        problems, checked = check_headers(root, arguments.compiler)
        return finish("headers", problems, checked, "headers")
    problems, checked = check_snippets(root, arguments.compiler, arguments.exported, arguments.also)
    return finish("snippets", problems, checked, "blocks of C")


if __name__ == "__main__":
    sys.exit(main())
