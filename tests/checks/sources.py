"""What the checks of the sources share: finding C files, seeing code without comments and strings, and the verdict."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

_TOKEN = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.DOTALL)
_INCLUDE_LINE = re.compile(r"^\s*#\s*include\b", re.MULTILINE)


def c_files(root: Path, *folders: str, suffixes: tuple[str, ...] = (".c", ".h", ".def")) -> list[Path]:
    """All C files below the given folders of the project, sorted by path."""
    found = [path for folder in folders for path in (root / folder).rglob("*") if path.suffix in suffixes]
    return sorted(path for path in found if path.is_file())


def without_comments(text: str, keep_strings: bool = False) -> str:
    """The text with comments (and strings, unless kept) blanked out; line numbers stay as they were."""

    def blank(match: re.Match[str]) -> str:
        token = match.group(0)
        if keep_strings and token[0] in "\"'":
            return token
        return re.sub(r"[^\n]", " ", token)

    return _TOKEN.sub(blank, text)


def without_float64_branch(text: str) -> str:
    """The text with the lines that only the float64 build sees (`#if EMA_REAL64` up to `#else`) blanked out."""
    kept: list[str] = []
    stack: list[bool] = []
    for line in text.split("\n"):
        directive = re.match(r"\s*#\s*(if|ifdef|ifndef|else|elif|endif)\b(.*)", line)
        word = directive.group(1) if directive else ""
        if word in ("if", "ifdef", "ifndef"):
            stack.append(word == "if" and directive is not None and directive.group(2).strip() == "EMA_REAL64")
        elif word in ("else", "elif") and stack:
            stack[-1] = False
        elif word == "endif" and stack:
            stack.pop()
        kept.append("" if any(stack) and not word else line)
    return "\n".join(kept)


def finish(name: str, problems: Iterable[str], checked: int, what: str) -> int:
    """Print the verdict of a check; 1 when something is wrong or nothing was there to check."""
    problems = list(problems)
    for problem in problems:
        print(problem)
    if checked == 0:
        print(f"{name}: found no {what} to check: run it from the project, with --root")
        return 1
    print(f"{name}: {checked} {what}, {len(problems)} wrong")
    return 1 if problems else 0


def run(name: str, what: str, check: Callable[[Path], tuple[list[str], int]], description: str | None) -> int:
    """Entry point of a check that looks at the project alone: `check` of the folder after --root, and its verdict."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--root", type=Path, required=True)
    problems, looked_at = check(parser.parse_args().root.resolve())
    return finish(name, problems, looked_at, what)


def fail(message: str) -> int:
    """Print one line and give the exit code of a check that could not be made."""
    print(message, file=sys.stderr)
    return 1
