"""Checks which C file may include which; no library serves, since linters know allowed system headers but no levels.

A file of src includes only its own level and lower ones, and nothing of port; inside a level no two include each other.
A public header belongs to the level of the C file with its name; one without a C file passes on what it includes. A
header of src and the C file with its name count as one where circles are sought. Ports use public headers; the desk
alone shows single blocks to the tools.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from sources import c_files, run, without_comments

# Level -> levels whose headers it may see.
ALLOWED = {
    "base": {"base"},
    "effects": {"base", "effects"},
    "blocks": {"base", "effects", "blocks"},
    "plant": {"base", "effects", "blocks", "plant"},
    "signal": {"base", "signal"},
    "search": {"base", "search"},
    "ident": {"base", "effects", "blocks", "plant", "signal", "search", "ident"},
    "session": {"base", "effects", "blocks", "plant", "signal", "search", "ident", "session"},
    "trend": {"base", "trend"},
}
# Port -> levels whose private headers it may see.
PORT_SEES = {"port/desk": {"base", "effects", "blocks"}}
# What of the C library the module may use: types, limits, memory copies; square root behind one header.
SYSTEM = {"stdint.h", "stddef.h", "stdbool.h", "float.h", "limits.h", "string.h"}
SYSTEM_ONLY_IN = {"math.h": "src/base/ema_math.h"}

INCLUDE = re.compile(r'^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)


def area(root: Path, path: Path) -> str:
    """`include`, `src/<level>` or `port/<name>`."""
    parts = path.relative_to(root).parts
    return "include" if parts[0] == "include" else "/".join(parts[:2])


def check(root: Path) -> tuple[list[str], int]:
    """Problems, and the number of includes of the project's own headers that were looked at."""
    files = c_files(root, "src", "include", "port")
    level_of_stem = {
        path.stem: area(root, path).split("/")[1] for path in files if path.suffix == ".c" and area(root, path).startswith("src/")
    }
    problems: list[str] = []
    direct: dict[Path, list[Path]] = {}
    looked_at = 0

    def resolve(path: Path, name: str) -> Path | None:
        beside = path.parent / name
        candidates = [beside, root / "include" / name, root / "src" / name, *sorted((root / "port").glob(f"*/{name}"))]
        return next((candidate.resolve() for candidate in candidates if candidate.is_file()), None)

    for path in files:
        where = area(root, path)
        shown = path.relative_to(root)
        direct[path.resolve()] = []
        if where.startswith("src/") and where.split("/")[1] not in ALLOWED:
            problems.append(f"{shown}: src has no level {where.split('/')[1]}: move the file or extend ALLOWED in check_layers.py")
            continue
        text = without_comments(path.read_text(encoding="utf-8"), keep_strings=True)
        for match in INCLUDE.finditer(text):
            line = text.count("\n", 0, match.start(1 if match.group(1) else 2)) + 1
            own, system = match.group(1), match.group(2)
            if system is not None:
                if where.startswith("port/") or system in SYSTEM or SYSTEM_ONLY_IN.get(system) == str(shown):
                    continue
                problems.append(f"{shown}:{line}: <{system}> is not for the module: use what src/base offers, or move this to port")
                continue
            looked_at += 1
            target = resolve(path, own)
            if target is None:
                problems.append(f"{shown}:{line}: {own} is no header of the project: correct the name")
                continue
            direct[path.resolve()].append(target)
            there = area(root.resolve(), target)
            if where == "include" and there != "include":
                problems.append(f"{shown}:{line}: a public header includes {there}: move {own} to include/ema or hide it in a .c file")
            elif where.startswith("src/") and there.startswith("port/"):
                problems.append(f"{shown}:{line}: the module includes {there}: nothing in src may know a port")
            elif where.startswith("port/") and there.startswith("src/") and there.split("/")[1] not in PORT_SEES.get(where, set()):
                problems.append(f"{shown}:{line}: a port includes the private header {own}: use what include/ema offers")

    def reach(path: Path, seen: set[Path]) -> set[Path]:
        for target in direct.get(path, []):
            if target not in seen:
                seen.add(target)
                reach(target, seen)
        return seen

    for path in files:
        where = area(root, path)
        if not where.startswith("src/") or where.split("/")[1] not in ALLOWED:
            continue
        level = where.split("/")[1]
        for target in sorted(reach(path.resolve(), set())):
            there = area(root.resolve(), target)
            other = level_of_stem.get(target.stem) if there == "include" else there.split("/")[1]
            if there.startswith("port/") or other is None or other in ALLOWED[level]:
                continue
            problems.append(
                f"{path.relative_to(root)}: level {level} sees {target.name} of level {other}: move the code up, or what it needs down"
            )
    return problems + circles(root, direct), looked_at


def circles(root: Path, direct: dict[Path, list[Path]]) -> list[str]:
    """Headers and C files of src, taken by their names, that include each other, also by way of others."""
    private = {path for path in direct if area(root.resolve(), path).startswith("src/")}
    below: dict[str, set[str]] = {}
    for path in private:
        below.setdefault(path.stem, set()).update(target.stem for target in direct[path] if target in private and target.stem != path.stem)

    def way(start: str, end: str, seen: tuple[str, ...]) -> tuple[str, ...]:
        for name in sorted(below.get(start, ())):
            if name == end:
                return (*seen, start, end)
            if name not in seen and name != start:
                found = way(name, end, (*seen, start))
                if found:
                    return found
        return ()

    found: dict[frozenset[str], tuple[str, ...]] = {}
    for name in sorted(below):
        ring = way(name, name, ())
        if ring:
            found.setdefault(frozenset(ring), ring)
    return [f"{' -> '.join(ring)}: a circle: move what both need into a header of its own" for ring in found.values()]


if __name__ == "__main__":
    sys.exit(run("layers", "includes", check, __doc__))
