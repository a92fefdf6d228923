"""Checks that the name of a real number in a public structure or list ends in its unit; no library knows units in C names.

Units and the names without one stand in unit_names.txt, with a reason each; a name there that nothing uses is wrong too.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from sources import c_files, fail, finish, without_comments

STRUCT = re.compile(r"\bstruct\b[^;{(]*\{")
FIELD = re.compile(r"(?:^|[;{}])\s*(?:const\s+)?(ema_real|float|double)\b\s*(?:const\b\s*)?([^;(){}]+);", re.MULTILINE)
ROW = re.compile(r"\b(?:EMA_PARAM\(\s*\w+\s*,|EMA_P\()\s*([A-Za-z]\w*)\s*,\s*[-+.\d]")


def read_names(path: Path) -> tuple[set[str], set[str]]:
    """Units and dimensionless names of the data file: lines `unit NAME` and `plain NAME reason`."""
    units: set[str] = set()
    plain: set[str] = set()
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] == "unit" and len(words) == 2:
            units.add(words[1])
        elif words[0] == "plain" and len(words) >= 3:
            plain.add(words[1])
        else:
            raise ValueError(f"{path.name}:{number}: `{line}` is neither `unit NAME` nor `plain NAME reason`: correct the line")
    return units, plain


def struct_bodies(code: str) -> list[tuple[int, str]]:
    """Offset and text between the braces of every outermost structure."""
    bodies: list[tuple[int, str]] = []
    end = 0
    for match in STRUCT.finditer(code):
        if match.start() < end:
            continue
        depth, end = 1, match.end()
        while end < len(code) and depth > 0:
            depth += {"{": 1, "}": -1}.get(code[end], 0)
            end += 1
        bodies.append((match.end(), code[match.end() : end - 1]))
    return bodies


def names_in(path: Path) -> list[tuple[int, str]]:
    """Line and name of every real number that the file declares in a structure or a list."""
    code = without_comments(path.read_text(encoding="utf-8"))
    if path.suffix == ".def":
        return [(code.count("\n", 0, match.start()) + 1, match.group(1)) for match in ROW.finditer(code)]
    found: list[tuple[int, str]] = []
    for offset, body in struct_bodies(re.sub(r"(?m)^[ \t]*#(?:[^\n\\]|\\\n)*", lambda m: re.sub(r"[^\n]", " ", m.group(0)), code)):
        position = 0
        while match := FIELD.search(body, position):
            position = match.end() - 1
            line = code.count("\n", 0, offset + match.start(2)) + 1
            for declarator in match.group(2).split(","):
                found.append((line, re.sub(r"\[.*", "", declarator).strip(" *\n\t")))
    return found


def unknown_compound(name: str, units: set[str]) -> str:
    """The unit at the end of a name of which it is only the last part, as in `_per_sqrt_A`; empty where there is none."""
    ends = sorted((unit for unit in units if name.endswith("_" + unit)), key=len)
    before = name[: -len(ends[-1]) - 1] if ends else ""
    return ends[-1] if ends and before.endswith(("_per", "_sqrt")) else ""


def check(root: Path, names: Path) -> tuple[list[str], int]:
    """Problems, and the number of names looked at."""
    units, plain = read_names(names)
    problems: list[str] = []
    used: set[str] = set()
    looked_at = 0
    for path in c_files(root, "include", suffixes=(".h", ".def")):
        for line, name in names_in(path):
            looked_at += 1
            if name in plain:
                used.add(name)
            elif part := unknown_compound(name, units):
                problems.append(
                    f"{path.relative_to(root)}:{line}: `{name}` ends in a unit that {names.name} does not have, of which `{part}` is only the last part:"
                    f" add `unit ...` there, and its printed text in tools/ema_tools/library/definitions.py"
                )
            elif not any(name.endswith("_" + unit) for unit in units):
                problems.append(
                    f"{path.relative_to(root)}:{line}: `{name}` has no unit: end it in one (_Nm, _rad_s, ...),"
                    f" or list it in {names.name} with the reason"
                )
    problems += [f"{names.name}: `{name}` names nothing any more: remove the line" for name in sorted(plain - used)]
    return problems, looked_at


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--root", type=Path, required=True)
    parser.add_argument("--names", type=Path, default=Path(__file__).with_name("unit_names.txt"))
    arguments = parser.parse_args()
    try:
        problems, looked_at = check(arguments.root.resolve(), arguments.names)
    except ValueError as error:
        return fail(str(error))
    return finish("units", problems, looked_at, "names")


if __name__ == "__main__":
    sys.exit(main())
