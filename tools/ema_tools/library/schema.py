"""The number of the two lists that make an actuator: `EMA_CONFIG_SCHEMA`. A configuration that is flown carries it, so that one of other lists is refused.

`python -m ema_tools.library.schema include/ema/detail/ema_schema.h` writes it into that header, for the lists without effects of the user's own.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import sys
from pathlib import Path

from ema_tools.library.definitions import Definitions, project_definitions

_LINE = re.compile(r"^#define EMA_CONFIG_SCHEMA 0x[0-9a-f]{8}U$", re.MULTILINE)


def schema_of(known: Definitions) -> int:
    """The number of these lists: the first 32 bits of the SHA-256 of their names, kinds and order, one row a line."""
    rows = [f"{'whole' if row.is_option else 'real'}({row.name})" for row in known.parameters]
    for effect in known.effects:
        rows += [f"effect({effect.name})", *(f"value({value.field})" for value in effect.parameters)]
    return int.from_bytes(hashlib.sha256("\n".join(rows).encode()).digest()[:4], "big")


def with_schema(header: str, schema: int) -> str:
    """The text of ema_schema.h with this number. Raises ValueError where it has no place for it."""
    text, count = _LINE.subn(f"#define EMA_CONFIG_SCHEMA 0x{schema:08x}U", header)
    if count != 1:
        raise ValueError("the header has not one line `#define EMA_CONFIG_SCHEMA 0x........U`: restore it")
    return text


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("header", type=Path)
    given = parser.parse_args()
    header: Path = given.header
    header.write_text(with_schema(header.read_text(encoding="utf-8"), schema_of(project_definitions())), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
