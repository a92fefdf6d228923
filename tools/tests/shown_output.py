"""Output shown in a document against what this machine prints: words alike, wrapped as the document likes, with an ellipsis where something was left out.

In `tools`, `PYTHONPATH=.:..:tests ../build/venv/bin/python -m shown_output` writes this machine's numbers into README.md and docs/WALK_THROUGH.md; the words are written by hand.
"""

from __future__ import annotations

import contextlib
import re
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

from demo_run import demo_run
from ema_tools.library.definitions import library_folder
from shared_results import shared_result
from support import ROOT, run_ema

README, WALK_THROUGH = ROOT / "README.md", ROOT / "docs" / "WALK_THROUGH.md"
# What numbers of two machines may differ by: their libraries round sines and exponentials differently, so a search ends a little beside; and the last digit shown may round the other way.
SHARE = 0.05

_NUMBER = re.compile(r"[+−-]?\d[\d.]*(?:e[+-]?\d+|×10[⁻⁰¹²³⁴-⁹]+)?")
_PLAIN = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")


def blocks(document: Path, language: str = "") -> list[str]:
    """The contents of the document's fenced blocks of one language."""
    text = document.read_text(encoding="utf-8")
    found = re.findall(r"^```(\w*)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return [content for name, content in found if name == language]


def _is_near(shown: str, real: str) -> bool:
    plain, other = (text.translate(_PLAIN).replace("×10", "e").rstrip(".") for text in (shown, real))
    digits, _, power = plain.partition("e")
    last_digit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2])) if "." in digits else 0.0
    return abs(float(plain) - float(other)) <= SHARE * abs(float(other)) + 1.01 * last_digit


def _is_same_word(shown: str, real: str) -> bool:
    return _NUMBER.sub("#", shown) == _NUMBER.sub("#", real)


def _is_alike(shown: str, real: str) -> bool:
    return _is_same_word(shown, real) and all(map(_is_near, _NUMBER.findall(shown), _NUMBER.findall(real)))


def _words(text: str) -> list[str]:
    """Words without what every run changes: seconds."""
    return re.sub(r"\b[\d.]+ s\b", "SECONDS s", text).split()


def _aligned(shown: str, real: str, is_alike: Callable[[str, str], bool]) -> tuple[list[str], str]:
    """The words of `real` that are those of `shown`, in this order, and the first part of `shown` that `real` does not have, with the word at which it ends to agree."""
    there = _words(real)
    aligned: list[str] = []
    start = 0
    for part in shown.split("…"):
        wanted = _words(part)
        best, place = -1, start
        for first in range(start, len(there) - len(wanted) + 1):
            agreed = next((k for k, word in enumerate(wanted) if not is_alike(word, there[first + k])), len(wanted))
            if agreed > best:
                best, place = agreed, first
            if agreed == len(wanted):
                break
        if best < len(wanted):
            found = there[place + best] if best >= 0 else "nothing"
            return aligned, f"{' '.join(wanted[: best + 1])!r}, really {found!r}"
        start = place + len(wanted)
        aligned += there[place:start]
    return aligned, ""


def missing_from(shown: str, real: str) -> str:
    """The first part of `shown` that `real` does not have, with the word at which it ends to agree; empty when all of it is there."""
    return _aligned(shown, real, _is_alike)[1]


def renewed(shown: str, real: str) -> str:
    """`shown` with the numbers of `real`. Raises ValueError where the words are others."""
    aligned, missing = _aligned(shown, real, _is_same_word)
    if missing:
        raise ValueError(f"other words: {missing}: write them by hand")
    words = iter(aligned)
    return re.sub(r"[^\s…]+", lambda word: word[0] if (new := next(words)) == "SECONDS" else new, shown)


def walk() -> list[tuple[str, str]]:
    """The commands of docs/WALK_THROUGH.md with the output shown below them, empty where there is none."""
    found: list[tuple[str, str]] = []
    for block in blocks(WALK_THROUGH):
        if block.startswith("build/"):
            found += [(line, "") for line in block.splitlines()]
        else:
            found[-1] = (found[-1][0], block)
    return found


@shared_result
def walked(commands: tuple[str, ...]) -> dict[str, str]:
    """What every command prints, in their order; what they write goes to a folder of its own."""
    build = library_folder().parent
    printed = {}
    with tempfile.TemporaryDirectory() as folder:
        for command in commands:
            typed = (
                re.sub(r"build/(\w+\.(?:json|toml|h)|loop$)", rf"{folder}/\1", command)
                .replace("docs walk", f"{folder} walk")
                .replace("build/", f"{build}/")
            )
            if command.startswith("build/ema "):
                # the shell expands its braces; the tools, which take as long to start as many a command takes, run here
                typed = f"printf '%s\\n' {typed}"
            done = subprocess.run(["bash", "-c", typed], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
            assert done.returncode == 0, f"{command}\n{done.stderr}"
            printed[command] = done.stdout
            if command.startswith("build/ema "):
                with contextlib.chdir(ROOT):
                    ran = run_ema(*done.stdout.splitlines()[1:])
                assert ran.code == 0, f"{command}\n{ran.err}"
                printed[command] = ran.out
            printed[command] = printed[command].replace(folder, "build")
    return printed


def shown_by_demo() -> list[tuple[str, str]]:
    """The blocks of README.md that show the demo's output, with what it prints here."""
    return [(block, demo_run()[1]) for block in blocks(README) if "recorded 5 times" in block or "paper's" in block]


def shown_by_walk() -> list[tuple[str, str]]:
    """The blocks of docs/WALK_THROUGH.md that show output, with what their commands print here."""
    steps = walk()
    printed = walked(tuple(command for command, _ in steps))
    return [(block, printed[command]) for command, block in steps if block]


if __name__ == "__main__":
    for document, shown in ((README, shown_by_demo()), (WALK_THROUGH, shown_by_walk())):
        text = document.read_text(encoding="utf-8")
        for block, real in shown:
            text = text.replace(block, renewed(block, real))
        document.write_text(text, encoding="utf-8")
