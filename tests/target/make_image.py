"""Turns an image of configurations into a C array that begins on a boundary of 4 bytes, so that it is read where it lies.

With --flip one bit of it is another, as a worn flash might have it. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

HEADER = "ace_image.h"
LINE = 24


def flipped(data: bytes, bit: int) -> bytes:
    """The bytes with bit `bit`, counted from the first byte's least, turned over. Raises ValueError where there is none."""
    if not 0 <= bit < 8 * len(data):
        raise ValueError(f"--flip {bit}: the image has {8 * len(data)} bits: name one of them")
    made = bytearray(data)
    made[bit // 8] ^= 1 << bit % 8
    return bytes(made)


def source(data: bytes) -> str:
    """A source file that defines what ace_image.h declares."""
    lines = [
        "/* Written by tests/target/make_image.py. */",
        f'#include "{HEADER}"',
        "",
        f"const size_t ace_image_bytes = {len(data)}U;",
        f"_Alignas(uint32_t) const uint8_t ace_image[{len(data)}] = {{",
    ]
    lines += ["    " + ", ".join(f"{byte}U" for byte in data[start : start + LINE]) + "," for start in range(0, len(data), LINE)]
    return "\n".join([*lines, "};", ""])


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("image", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--flip", type=int, help="the bit that is another")
    given = parser.parse_args()
    try:
        data = given.image.read_bytes()
        if not data:
            raise ValueError(f"{given.image.name}: the file is empty: name an image")
        given.out.write_text(source(data if given.flip is None else flipped(data, given.flip)), encoding="utf-8")
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
