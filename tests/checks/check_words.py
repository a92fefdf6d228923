"""Words that may not stand in the sources: heap, stdio, clocks, hidden double, the C library's transcendentals,
compiler extensions in src and include; notes to oneself and paths of one machine in the whole tree.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from pathlib import Path

from sources import c_files, finish, without_comments, without_float64_branch

# Group of words in code -> what to do instead.
MODULE_WORDS = {
    "malloc calloc realloc free alloca aligned_alloc": "memory is the caller's",
    "printf fprintf sprintf snprintf vprintf puts putchar fopen fputs stdout stderr": "output belongs in port",
    "time clock gettimeofday rand srand": "a result depends on the inputs alone; use ema_random",
    "exit abort assert getenv system setjmp longjmp signal goto errno": "return a status",
    "double long_double": "use ema_real",
    "sin cos tan asin acos atan atan2 sinh cosh tanh exp exp2 expm1 log log2 log10 log1p pow cbrt hypot fmod remainder"
    " erf tgamma lgamma sinf cosf tanf asinf acosf atanf atan2f sinhf coshf tanhf expf exp2f expm1f logf log2f log10f"
    " log1pf powf cbrtf hypotf fmodf remainderf": "the C library's bits differ between machines; use ema_math",
    "__attribute__ __builtin_expect __asm__ asm typeof __typeof__ __extension__": "plain C11 only, except in base/ema_compiler.h",
}
# The one header that may use compiler extensions, and the extension that it uses.
COMPILER_HEADER, COMPILER_WORD = "src/base/ema_compiler.h", "__attribute__"
TREE_SUFFIXES = {".c", ".h", ".def", ".py", ".md", ".toml", ".txt", ".cmake", ".json", ".in", ".yml", ".sh", ".html"}
# Written in two pieces so that this file does not accuse itself.
TREE_PATTERNS = {
    r"\b(TO" r"DO|FIX" r"ME|XX" r"X)\b": "finish it or leave it out",
    r"(?<![\w.$}/~])/(work|root|home|tmp|Users)" r"/": "no path of one machine",
}


def check_module(root: Path) -> tuple[list[str], int]:
    """Problems of src and include, and the number of files read."""
    reasons = {word: reason for words, reason in MODULE_WORDS.items() for word in words.split()}
    pattern = re.compile(r"\b(" + "|".join(sorted(map(re.escape, reasons), key=len, reverse=True)) + r")\b")
    problems: list[str] = []
    files = c_files(root, "src", "include")
    for path in files:
        # The contents of an #include line are names of files, not code.
        code = re.sub(r"(?m)^\s*#\s*include.*$", "", without_comments(path.read_text(encoding="utf-8")))
        for number, line in enumerate(without_float64_branch(code).split("\n"), start=1):
            for match in pattern.finditer(line):
                word = match.group(1)
                # A word of the C library is only forbidden where it is called or named as a type, not as a field.
                if line[: match.start()].rstrip().endswith((".", "->")):
                    continue
                if word == COMPILER_WORD and path == root / COMPILER_HEADER:
                    continue
                problems.append(f"{path.relative_to(root)}:{number}: `{word}` is not for the module: {reasons[word]}")
    return problems, len(files)


def check_tree(root: Path) -> list[str]:
    """Problems of every text file of the project."""
    paths: list[Path] = []
    for folder, folders, names in os.walk(root):
        # Build folders change while the tests run, and hold other people's files.
        folders[:] = [
            name for name in folders if name not in (".git", "__pycache__") and not (Path(folder) == root and name.startswith("build"))
        ]
        paths += [Path(folder) / name for name in names]
    problems: list[str] = []
    for path in sorted(paths):
        if path.suffix not in TREE_SUFFIXES and path.name != "run":
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), start=1):
            for pattern, reason in TREE_PATTERNS.items():
                match = re.search(pattern, line)
                if match:
                    problems.append(f"{path.relative_to(root)}:{number}: `{match.group(0)}`: {reason}")
    return problems


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    root = parser.parse_args().root.resolve()
    problems, checked = check_module(root)
    return finish("words", problems + check_tree(root), checked, "files of the module")


if __name__ == "__main__":
    sys.exit(main())
