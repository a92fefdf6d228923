"""Output shown in a document against the real one: words alike, numbers close, wrapped as the document likes, with an ellipsis where something was left out."""

from __future__ import annotations

import re
from pathlib import Path

_NUMBER = re.compile(r"[+−-]?\d[\d.]*(?:e[+-]?\d+|×10[⁻⁰¹²³⁴-⁹]+)?")
_PLAIN = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")
_SHARE = 0.05
# Below this a share says nothing: it is rounding.
_LEAST = 1e-3


def blocks(document: Path, language: str = "") -> list[str]:
    """The contents of the document's fenced blocks of one language."""
    text = document.read_text(encoding="utf-8")
    found = re.findall(r"^```(\w*)\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return [content for name, content in found if name == language]


def _value(text: str) -> float:
    return float(text.translate(_PLAIN).replace("×10", "e").rstrip("."))


def _unit(shown: str) -> float:
    """What the one digit that says something counts, of 0.2 a tenth: rounding alone moves it from machine to machine; 0 of numbers with more digits, and of whole ones."""
    alone = re.fullmatch(r"[+−-]?0\.(0*[1-9])", shown.rstrip("."))
    return 10.0 ** -len(alone[1]) if alone else 0.0


def _near(shown: str, real: str) -> bool:
    one, other = _value(shown), _value(real)
    least = _LEAST if abs(other) > 10.0 * _LEAST or one == 0.0 else 0.0
    return abs(one - other) <= max(least, _SHARE * abs(other), 1.01 * _unit(shown))


def _alike(shown: str, real: str) -> bool:
    if _NUMBER.sub("#", shown) != _NUMBER.sub("#", real):
        return False
    return all(map(_near, _NUMBER.findall(shown), _NUMBER.findall(real)))


def _words(text: str) -> list[str]:
    """Words without what a machine changes: seconds."""
    return re.sub(r"\b[\d.]+ s\b", "SECONDS s", text).split()


def missing_from(shown: str, real: str) -> str:
    """The first part of `shown` that `real` does not have in this order, with the word at which it ends to agree; empty when all of it is there."""
    there = _words(real)
    start = 0
    for part in re.split("…", shown):
        wanted = _words(part)
        best, place = -1, start
        for first in range(start, len(there) - len(wanted) + 1):
            agreed = next((k for k, word in enumerate(wanted) if not _alike(word, there[first + k])), len(wanted))
            if agreed > best:
                best, place = agreed, first
            if agreed == len(wanted):
                break
        if best < len(wanted):
            found = there[place + best] if best >= 0 else "nothing"
            return f"{' '.join(wanted[: best + 1])!r}, really {found!r}"
        start = place + len(wanted)
    return ""
