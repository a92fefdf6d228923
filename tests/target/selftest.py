"""The self-test on the target: passed by the module as it is built, refused where products are contracted, all or those of one file, and where one bit of its constants is another.

Python's standard library alone.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import emulate

PASSED, ARITHMETIC, CONSTANTS, MODEL, SEARCH = 0, 3, 4, 5, 6
# Constants that the test must look at: ranges, series and polynomials.
TABLES = ("ema_bounds", "ema_exp_inside", "ema_inverse")
# Ranges come first as parameters', which are looked at, then as effects', which are not: builds differ in them.
LOOKED_AT_BYTES = {"ema_bounds": 256}
# Of a function its constants alone, which lie behind its code.
LITERAL_BYTES = {"ema_exp_inside": 32}
# Spread over a table and over a word: the lowest and the highest bit of a fraction, an exponent's, the sign.
BITS = (0, 22, 25, 31)
PROGRAM_HEADER = struct.Struct("<8I")


class SelftestError(Exception):
    """What the self-test did not see."""


@dataclass(frozen=True)
class Flip:
    """One bit of a table."""

    table: str
    offset: int
    bit: int


def symbols(nm: str, program: Path) -> dict[str, tuple[int, int]]:
    """Address and bytes of every symbol that has a size."""
    ran = subprocess.run([nm, "-S", str(program)], capture_output=True, text=True, check=True)
    rows = [line.split() for line in ran.stdout.splitlines()]
    return {row[3]: (int(row[0], 16), int(row[1], 16)) for row in rows if len(row) == 4}


def place_in_file(image: bytes, address: int) -> int:
    """Where an address of a 32-bit ELF file lies in it. Raises SelftestError where nothing is loaded there."""
    first, size, count = struct.unpack_from("<I", image, 28)[0], *struct.unpack_from("<2H", image, 42)
    for place in range(count):
        kind, offset, begin, _, stored, _, _, _ = PROGRAM_HEADER.unpack_from(image, first + place * size)
        if kind == 1 and begin <= address < begin + stored:
            return int(offset + address - begin)
    raise SelftestError(f"nothing is loaded at {address:#x}")


def flips(found: dict[str, tuple[int, int]]) -> list[Flip]:
    """The bits to try: of the second (the compiler may keep a copy of the first), a middle and the last word of each table, another one each."""
    missing = [name for name in TABLES if name not in found]
    if missing:
        raise SelftestError(f"no table {missing[0]} in the program: name today's constants in TABLES")
    chosen = []
    for turn, name in enumerate(TABLES):
        size = found[name][1]
        first = size - LITERAL_BYTES.get(name, size)
        words = min(size - first, LOOKED_AT_BYTES.get(name, sys.maxsize)) // 4
        for place, word in enumerate((1, words // 2, words - 1)):
            chosen.append(Flip(name, first + 4 * word, BITS[(turn + place) % len(BITS)]))
    return chosen


def outcome(board: str, program: Path) -> int:
    """Exit code of a program on the board."""
    return emulate.run(board, program, [], timeout_s=60.0).exit_code


def check(given: argparse.Namespace) -> int:
    """How many damaged images were refused."""
    if (code := outcome(given.board, given.program)) != PASSED:
        raise SelftestError(f"{given.program.name}: outcome {code} of a sound module")
    if (code := outcome(given.board, given.contracted)) != ARITHMETIC:
        raise SelftestError(f"{given.contracted.name}: outcome {code} where products are contracted, not {ARITHMETIC}")
    if (code := outcome(given.board, given.mixed)) != SEARCH:
        raise SelftestError(f"{given.mixed.name}: outcome {code} where the products of a fit are contracted, not {SEARCH}")
    image = given.program.read_bytes()
    found = symbols(given.nm, given.program)
    chosen = flips(found)
    with tempfile.TemporaryDirectory() as folder:
        damaged = Path(folder).resolve() / "damaged.elf"
        for flip in chosen:
            place = place_in_file(image, found[flip.table][0] + flip.offset + flip.bit // 8)
            damaged.write_bytes(image[:place] + bytes([image[place] ^ (1 << (flip.bit % 8))]) + image[place + 1 :])
            if (code := outcome(given.board, damaged)) not in (CONSTANTS, MODEL, SEARCH):
                raise SelftestError(f"{flip.table}: outcome {code} with bit {flip.bit} at byte {flip.offset} another")
    return len(chosen)


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", required=True, help="QEMU's name of the machine")
    parser.add_argument("--nm", required=True, help="nm of the cross compiler")
    parser.add_argument("--contracted", type=Path, required=True, help="the program with a module whose products are contracted")
    parser.add_argument("--mixed", type=Path, required=True, help="the program with a search whose fit alone is contracted")
    parser.add_argument("program", type=Path)
    given = parser.parse_args()
    try:
        print(f"selftest: passed as built, refused contracted, in a file alone and with {check(given)} damaged constants")
    except (SelftestError, OSError, subprocess.CalledProcessError) as error:
        print(f"selftest: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
