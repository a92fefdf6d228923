"""The header that `ema export --signatures` writes, read back: the table as the firmware has it.

Strict: a header that was edited into another layout is refused, not guessed at.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import reason
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import CHANNELS, Table

_REAL = r"(-?\d+(?:\.\d+)?(?:e[-+]\d+)?)f"
_PATTERN = re.compile(rf"\{{(\d+), (\d+), ([12]), (true|false), \{{{_REAL}, {_REAL}, {_REAL}\}}, {_REAL}\}}, /\* (\w+) \*/")
_FAULT = re.compile(rf"\{{(\d+), (\d+), {_REAL}, {_REAL}, {_REAL}\}}, /\* ([\w.]+) \*/")


class _Header:
    """The text of a header, read piece by piece; what is not there as it is written raises InputError."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text

    def fail(self, what: str) -> InputError:
        """The error of a header that is none."""
        return InputError(f"{self.path}: {what}: give the header as `ema export --signatures` wrote it")

    def block(self, head: str, end: str) -> list[str]:
        """The lines between the line that ends with `head` and `end`."""
        begin = self.text.find(f"{head}\n")
        close = self.text.find(f"\n{end}", begin)
        if begin < 0 or close < 0:
            raise self.fail(f"no {head.strip()}")
        return [line.strip() for line in self.text[begin:close].splitlines()[1:]]

    def rows(self, head: str, end: str, row: re.Pattern[str]) -> Iterator[re.Match[str]]:
        """The lines of a block, each of which must be a `row`."""
        for line in self.block(head, end):
            found = row.fullmatch(line)
            if found is None:
                raise self.fail(f"{head}: {line[:40]!r} is no row of it")
            yield found

    def field(self, name: str, value: str) -> re.Match[str]:
        """The member `name` of the table."""
        found = re.findall(rf"^    (.*), /\* {name} \*/$", self.text, re.MULTILINE)
        match = re.fullmatch(value, found[0]) if len(found) == 1 else None
        if match is None:
            raise self.fail(f"no {name}")
        return match

    def count(self, name: str) -> int:
        """A whole number."""
        return int(self.field(name, r"(\d+)U")[1])

    def real(self, name: str) -> float:
        """A real number."""
        return float(self.field(name, _REAL)[1])

    def reals(self, name: str) -> tuple[float, ...]:
        """Real numbers in braces."""
        return tuple(float(text) for text in re.findall(_REAL, self.field(name, rf"\{{{_REAL}(?:, {_REAL})*\}}")[0]))


def read_signatures(path: str | Path) -> Table:
    """The table in the header at `path`. Raises InputError when it is none, or was made with other lists of effects and parameters."""
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{file}: {reason(error) if isinstance(error, OSError) else 'no text'}: name a header of signatures") from None
    return signatures_in(text, file)


def signatures_in(text: str, file: Path) -> Table:
    """The table in the text of a header, which came from `file`; errors as of `read_signatures`."""
    header = _Header(file, text)
    known = load_definitions()
    effects, ids = [effect.name for effect in known.effects], known.ids
    patterns, faults = [], []
    for row in header.rows("static const ema_pattern_t ema_exported_patterns[] = {", "};", _PATTERN):
        place = int(row[1])
        if place >= len(effects) or effects[place] != row[9]:
            raise InputError(f"{file}: {row[9]}: the table was made with another list of effects: export it again")
        patterns.append([place, int(row[2]), int(row[3]), row[4] == "true", *map(float, row.groups()[4:8])])
    for row in header.rows("    { /* fault */", "    },", _FAULT):
        if ids.get(row[6]) != int(row[1]):
            raise InputError(f"{file}: {row[6]}: the table was made with another list of parameters: export it again")
        faults.append([int(row[1]), int(row[2]), *map(float, row.groups()[2:5])])
    units = " ".join(header.block("static const ema_real ema_exported_units[] = {", "};"))
    values = " ".join(header.block("static const int16_t ema_exported_values[] = {", "};"))
    if not re.fullmatch(rf"(?:{_REAL}, ?)+", units) or not re.fullmatch(r"(?:-?\d{1,5}, ?)+", values):
        raise header.fail("numbers are missing")
    channels = tuple(int(place) for place in header.field("channel", r"\{(\d(?:, \d)*)\}")[1].split(", "))
    numbers = np.array([int(value) for value in values.replace(" ", "").rstrip(",").split(",")])
    table = Table(
        version=header.count("version"),
        fingerprint=header.count("fingerprint"),
        record_rows=header.count("record_rows"),
        bin_rows=header.count("bin_rows"),
        bins=header.count("bins"),
        channels=channels,
        nuisances=header.count("nuisances"),
        command_unit_mm=header.real("command_unit_mm"),
        command_apart_mm=header.real("command_apart_mm"),
        reference=header.reals("reference"),
        weight=header.reals("weight"),
        limit=header.real("limit"),
        energy=header.real("energy"),
        patterns=np.array(patterns, dtype=np.float64),
        faults=np.array(faults, dtype=np.float64).reshape(len(faults), 5),
        unit=np.array([float(text) for text in re.findall(_REAL, units)]),
        value=numbers.astype(np.int16),
    )
    counts = {"patterns": len(patterns), "faults": len(faults), "rows": len(table.unit), "channels": len(channels)}
    whole = all(header.count(name) == count for name, count in counts.items()) and max(channels) < len(CHANNELS)
    wanted = table.bins * (1 + len(channels) * (1 + len(table.unit)))
    if not whole or len(table.reference) != len(channels) or len(table.weight) != len(channels) or numbers.size != wanted:
        raise header.fail("its counts do not fit its numbers")
    if np.any(table.value != numbers):
        raise header.fail("a value is no number of 16 bits")
    return table
