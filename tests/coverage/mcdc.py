"""Conditions of decisions that were shown to matter alone (MC/DC), read from what clang's llvm-cov exports.

llvm-cov's own totals cannot be used: it counts a decision of a header once for each file that includes it, gives no pair for a condition that is known when
compiling, and joins builds with different effects. Here a decision is one place in one function, and a condition that is known when compiling is not counted.
Python's standard library alone.
"""

from __future__ import annotations

import json
import subprocess
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# Kinds of llvm's mapping regions.
EXPANSION = 1
CONDITION = 6

Key = tuple[str, str, tuple[int, ...], int]


class ReadError(Exception):
    """Why the export cannot be read."""


@dataclass
class Decision:
    """One decision: which of its conditions were shown to matter alone; how many are known when compiling, which never are; and the code of the others."""

    shown: list[bool]
    known: int
    conditions: list[str]

    @property
    def count(self) -> int:
        """Conditions that tests can show."""
        return len(self.shown) - self.known

    @property
    def missed(self) -> int:
        """Those that were not shown."""
        return self.shown.count(False) - self.known

    def missing(self) -> list[str]:
        """The code of those, as far as it can be told: not where some conditions are known when compiling and some others were shown."""
        if self.known:
            return self.conditions if self.missed == self.count else []
        return [text for text, shown in zip(self.conditions, self.shown, strict=True) if not shown]

    def join(self, other: Decision) -> None:
        """Another build's or another file's run of the same decision; the build with fewer known conditions says how many there are."""
        self.shown = [mine or others for mine, others in zip(self.shown, other.shown, strict=True)]
        if other.known < self.known:
            self.known, self.conditions = other.known, other.conditions


def inside(place: list[int], area: list[int]) -> bool:
    """Whether (line, column, end line, end column) lies within another."""
    return (area[0], area[1]) <= (place[0], place[1]) and (place[2], place[3]) <= (area[2], area[3])


def code_at(files: dict[str, list[str]], name: str, place: list[int]) -> str:
    """The text of a place, in one line."""
    if name not in files:
        files[name] = Path(name).read_text(encoding="utf-8").splitlines()
    lines = files[name][place[0] - 1 : place[2]]
    if len(lines) > 1:
        return " ".join([lines[0][place[1] - 1 :], *lines[1:-1], lines[-1][: place[3] - 1]])
    return lines[0][place[1] - 1 : place[3] - 1]


Row = list[int]


def held_by(function: dict[str, Any], owner: int, area: Row) -> frozenset[int]:
    """Which conditions lie in an area of the function's file `owner`, themselves or by the macro that they stand in."""
    above = {row[6]: (row[5], row[:4]) for row in function["regions"] if row[7] == EXPANSION}
    found = set()
    for number, row in enumerate(function["branches"]):
        file, place = row[6], row[:4]
        while file != owner and file in above:
            file, place = above[file]
        if row[8] == CONDITION and file == owner and inside(place, area):
            found.add(number)
    return frozenset(found)


def owners_of(function: dict[str, Any], records: list[tuple[Row, list[bool]]]) -> list[tuple[int, frozenset[int]]] | None:
    """In which file of the function each decision lies, and its conditions: llvm says lines and columns alone, which may fit several files and every use of a macro. Every
    condition belongs to one decision, and what is known when compiling has none: that leaves one answer. None when it leaves no answer."""
    candidates: list[list[tuple[int, frozenset[int]]]] = []
    for area, shown in records:
        held = [(owner, held_by(function, owner, area)) for owner in range(len(function["filenames"]))]
        candidates.append([(owner, mine) for owner, mine in held if mine and 0 <= len(shown) - len(mine) <= shown.count(False)])
    whole = frozenset(number for number, row in enumerate(function["branches"]) if row[8] == CONDITION)

    def choose(nth: int, used: frozenset[int]) -> list[tuple[int, frozenset[int]]] | None:
        if nth == len(records):
            return [] if used == whole else None
        for owner, mine in candidates[nth]:
            rest = None if mine & used else choose(nth + 1, used | mine)
            if rest is not None:
                return [(owner, mine), *rest]
        return None

    return choose(0, frozenset())


def decisions_of(function: dict[str, Any], files: dict[str, list[str]]) -> dict[Key, Decision]:
    """The decisions of one function by file, function, place and how often that place came before (a macro used more than once)."""
    records: list[tuple[Row, list[bool]]] = sorted(
        ((row[:4], row[-1]) for row in function.get("mcdc_records", [])), key=lambda record: record[0]
    )
    owners = owners_of(function, records)
    if owners is None:
        raise ReadError(f"{function['name']}: its {len(records)} decisions and their conditions do not fit together")
    result: dict[Key, Decision] = {}
    before: dict[tuple[str, tuple[int, ...]], int] = defaultdict(int)
    for (area, shown), (owner, mine) in zip(records, owners, strict=True):
        file, short, place = function["filenames"][owner], function["name"].rpartition(":")[2], tuple(area)
        conditions = [function["branches"][number] for number in sorted(mine)]
        texts = [code_at(files, function["filenames"][row[6]], row[:4]) for row in conditions]
        result[(file, short, place, before[(file, place)])] = Decision(list(shown), len(shown) - len(mine), texts)
        before[(file, place)] += 1
    return result


def join(all_of_them: dict[Key, Decision], more: dict[Key, Decision]) -> None:
    """Adds what another file or another build showed."""
    for key, decision in more.items():
        if key in all_of_them:
            all_of_them[key].join(decision)
        else:
            all_of_them[key] = decision


def read(exported: dict[str, Any]) -> dict[Key, Decision]:
    """Every decision of one export; a function of a header stands in it once for each file that includes it."""
    result: dict[Key, Decision] = {}
    files: dict[str, list[str]] = {}
    for function in exported["data"][0]["functions"]:
        join(result, decisions_of(function, files))
    return result


def export(llvm_cov: str, llvm_profdata: str, objects: list[Path], profiles: list[Path], work: Path) -> dict[str, Any]:
    """What llvm-cov says of object files after runs that left these profiles."""
    merged = work / "merged.profdata"
    subprocess.run([llvm_profdata, "merge", "-sparse", *map(str, profiles), "-o", str(merged)], check=True)
    sources = [str(objects[0]), *(part for file in objects[1:] for part in ("-object", str(file)))]
    run = subprocess.run(
        [llvm_cov, "export", "-format=text", f"-instr-profile={merged}", *sources], check=True, capture_output=True, text=True
    )
    return dict(json.loads(run.stdout))
