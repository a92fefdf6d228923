"""Turns recordings into a C table: command, rod position and current of every row, as bit patterns of float32.

The values are rounded once, as the host program's parser of recordings does, so both get the same inputs. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import csv
import struct
import sys
from pathlib import Path

COLUMNS = ("command_mm", "position_mm", "current_A")


def rows_of(path: Path) -> list[tuple[int, ...]]:
    """The bits of the columns, row by row. Raises ValueError for a recording without rows or without one of the columns."""
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(line for line in file if not line.startswith("#"))
        missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
        if missing:
            raise ValueError(f"{path.name}: no column {missing[0]}: name a recording of the project")
        rows = [tuple(struct.unpack("<I", struct.pack("<f", float(row[name])))[0] for name in COLUMNS) for row in reader]
    if not rows:
        raise ValueError(f"{path.name}: no rows: name a recording of the project")
    return rows


def table(path: Path, head: str) -> str:
    """One array, whose declaration begins with `head`."""
    rows = rows_of(path)
    lines = [f"{head}[{len(rows)}][{len(COLUMNS)}] = {{"]
    for start in range(0, len(rows), 5):
        lines.append("    " + " ".join("{" + ", ".join(f"0x{bits:08X}U" for bits in row) + "}," for row in rows[start : start + 5]))
    return "\n".join([*lines, "};", ""])


def source(path: Path, header: str) -> str:
    """A source file that defines what `header` declares: the array, named like it, and the number of its rows."""
    name = Path(header).stem
    lines = [f'#include "{header}"', "", f"const uint32_t {name}_rows = {len(rows_of(path))}U;", ""]
    return "\n".join([*lines, table(path, f"const uint32_t {name}")])


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--header", help="write a source file for one recording, of what this header declares")
    parser.add_argument("recordings", nargs="+", type=Path)
    given = parser.parse_args()
    try:
        if given.header:
            tables = [source(path, given.header) for path in given.recordings]
        else:
            tables = [table(path, f"static const uint32_t {path.stem}") for path in given.recordings]
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    given.out.write_text("/* Written by tests/target/make_records.py. */\n" + "\n".join(tables), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
