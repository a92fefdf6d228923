"""Checks the symbols of the compiled module; no library serves: nm lists them, and the rule is the project's own.

The module needs nothing but itself and memory copies, and keeps no writable data. A whole-program fact that no warning shows: an unexpected library call (heap, stdio, a transcendental, a square root
that was not inlined) is an undefined symbol, and a global is a symbol in a writable section.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from sources import fail, finish

# The compiler itself calls these, whatever the sources say.
ALLOWED = {
    "memcpy",
    "memset",
    "memmove",
    "memcmp",
    "__memcpy_chk",
    "__memset_chk",
    "__memmove_chk",
    "__stack_chk_fail",
    "_GLOBAL_OFFSET_TABLE_",
}
WRITABLE = (".data", ".bss", ".tdata", ".tbss", "*COM*")


def check_table(table: str, library: str) -> tuple[list[str], int]:
    """Problems in a symbol table as `nm --format=sysv` prints it, and the number of functions defined."""
    defined: set[str] = set()
    needed: dict[str, str] = {}
    writable: list[tuple[str, str, str]] = []
    functions = 0
    member = library
    for line in table.splitlines():
        if line.startswith(("Symbols from ", "Undefined symbols from ")):
            member = line.removesuffix(":").split("[")[-1].rstrip("]")
        fields = [field.strip() for field in line.split("|")]
        if len(fields) != 7 or fields[0] == "Name":
            continue
        name, kind, symbol_type, section = fields[0], fields[2], fields[3], fields[6]
        if kind == "U" or section == "*UND*":
            needed.setdefault(name, member)
            continue
        defined.add(name)
        functions += 1 if symbol_type == "FUNC" else 0
        # .data.rel.ro is written by the loader alone.
        if section.startswith(WRITABLE) and not section.startswith(".data.rel.ro"):
            writable.append((name, member, section))
    problems = [
        f"{library}({member}): needs {name}: keep it out of src, or inline it"
        for name, member in sorted(needed.items())
        if name not in defined and name not in ALLOWED
    ]
    problems += [
        f"{library}({member}): {name} lies in {section}: make it const, or part of the caller's state" for name, member, section in writable
    ]
    return problems, functions


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nm", required=True)
    parser.add_argument("libraries", nargs="+", type=Path)
    arguments = parser.parse_args()
    problems: list[str] = []
    functions = 0
    for library in arguments.libraries:
        run = subprocess.run([arguments.nm, "--format=sysv", str(library)], capture_output=True, text=True, check=False)
        if run.returncode != 0:
            return fail(f"symbols: {arguments.nm} cannot read {library}: {run.stderr.strip().splitlines()[-1]}: build it first")
        found, count = check_table(run.stdout, library.name)
        if count == 0:
            return fail(f"symbols: {library.name} defines no function: build it first")
        problems += found
        functions += count
    return finish("symbols", problems, functions, "functions")


if __name__ == "__main__":
    sys.exit(main())
