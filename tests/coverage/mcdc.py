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


def decisions_of(function: dict[str, Any], files: dict[str, list[str]]) -> dict[Key, Decision]:
    """The decisions of one function by file, function, place and how often that place came before (a macro used more than once)."""
    names: list[str] = function["filenames"]
    conditions = [row for row in function["branches"] if row[8] == CONDITION]
    above = {row[6]: (row[5], row[:4]) for row in function["regions"] if row[7] == EXPANSION}

    def belongs(number: int, place: list[int], owner: int, area: list[int]) -> bool:
        while number != owner and number in above:
            number, place = above[number]
        return number == owner and inside(place, area)

    places: dict[tuple[int, ...], list[list[bool]]] = defaultdict(list)
    for record in function.get("mcdc_records", []):
        places[tuple(record[:4])].append(record[-1])
    result: dict[Key, Decision] = {}
    for place, records in places.items():
        area = list(place)
        # A decision's conditions lie where it lies, or in macros that are called from there.
        owners = [number for number in range(len(names)) if any(belongs(row[6], row[:4], number, area) for row in conditions)]
        if len(owners) != len(records):
            raise ReadError(f"{function['name']}: {len(records)} decisions at {place}, but {len(owners)} places for them")
        for nth, (owner, shown) in enumerate(zip(owners, records, strict=True)):
            mine = [row for row in conditions if belongs(row[6], row[:4], owner, area)]
            known = len(shown) - len(mine)
            if known < 0 or shown.count(False) < known:
                raise ReadError(f"{function['name']}: conditions at {place} that are known when compiling cannot be told from the others")
            texts = [code_at(files, names[row[6]], row[:4]) for row in mine]
            short = function["name"].rpartition(":")[2]
            result[(names[owner], short, place, nth)] = Decision(list(shown), known, texts)
    total = sum(decision.known for decision in result.values())
    if total != sum(len(shown) for records in places.values() for shown in records) - len(conditions):
        raise ReadError(f"{function['name']}: a condition belongs to no decision or to two")
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
    run = subprocess.run([llvm_cov, "export", "-format=text", f"-instr-profile={merged}", *sources], check=True, capture_output=True, text=True)
    return dict(json.loads(run.stdout))
