"""Holds the order of the tools' folders: a file imports only from its own folder and from those that stand below it; no two files import each other.

The order is the table LAYERS, top first. What stands in one line may not import each other. A folder, or a module beside the folders, that the table does
not have fails: give it its place. Imports that are made inside a function count too.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path

from sources import run

PACKAGE = "ema_tools"
# Top first: each may import what stands in a line below it. Folders and modules by their name in the package.
LAYERS: tuple[tuple[str, ...], ...] = (
    ("__main__",),
    ("benchmarks", "vectors"),
    ("cli",),
    ("words",),
    ("tasks",),
    ("design",),
    ("select",),
    ("compare",),
    ("fit",),
    ("balances",),
    ("results",),
    ("truth",),
    ("reference",),
    ("data",),
    ("plant",),
    ("library",),
    ("base",),
)
# A folder that is to share nothing with what it is held against may import these alone: names and nominal values, what the shipped records were made with, and samples of commands.
ONLY: dict[str, tuple[tuple[str, ...], ...]] = {
    "truth": (("base",), ("library", "definitions"), ("data", "own_unit"), ("data", "story"), ("reference", "commands")),
}


def places() -> dict[str, int]:
    """Name to its line of the table."""
    return {name: line for line, names in enumerate(LAYERS) for name in names}


def module_of(package: Path, path: Path) -> tuple[str, ...]:
    """Dotted name below the package, of the folder itself for an `__init__.py`."""
    parts = path.relative_to(package).with_suffix("").parts
    return parts[:-1] if parts[-1] == "__init__" else parts


def imports_of(
    tree: ast.Module, modules: set[tuple[str, ...]], own: tuple[str, ...], is_package: bool
) -> list[tuple[int, tuple[str, ...]]]:
    """Line and module, below the package, of every import of the project's own."""
    found: list[tuple[int, tuple[str, ...]]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            named = [alias.name.split(".") for alias in node.names]
            found += [(node.lineno, tuple(parts[1:])) for parts in named if parts[0] == PACKAGE]
        elif isinstance(node, ast.ImportFrom):
            parts = (node.module or "").split(".") if node.module else []
            if node.level:
                base = (PACKAGE, *own[: len(own) - node.level + (1 if is_package else 0)])
                parts = [*base, *parts]
            if parts[:1] != [PACKAGE]:
                continue
            below = tuple(parts[1:])
            found += [(node.lineno, (*below, alias.name) if (*below, alias.name) in modules else below) for alias in node.names]
    return found


def circles(uses: dict[tuple[str, ...], set[tuple[str, ...]]]) -> list[str]:
    """One line for each ring of modules that import each other; an `__init__` that offers its own modules is none."""
    found: dict[frozenset[tuple[str, ...]], str] = {}

    def walk(way: list[tuple[str, ...]], done: set[tuple[str, ...]]) -> None:
        for target in sorted(uses.get(way[-1], ())):
            if target in way:
                ring = way[way.index(target) :]
                found.setdefault(frozenset(ring), " -> ".join(".".join(name) or PACKAGE for name in (*ring, target)))
            elif target not in done:
                walk([*way, target], done)
        done.add(way[-1])

    done: set[tuple[str, ...]] = set()
    for start in sorted(uses):
        if start not in done:
            walk([start], done)
    return [f"{ring}: a circle: move what both need below them" for ring in found.values()]


def check(root: Path) -> tuple[list[str], int]:
    """Problems, and the number of imports of the project's own that were looked at."""
    package = root / "tools" / PACKAGE
    files = {module_of(package, path): path for path in sorted(package.rglob("*.py"))}
    line_of, problems, looked_at = places(), [], 0
    uses: dict[tuple[str, ...], set[tuple[str, ...]]] = {}
    for module, path in files.items():
        shown = path.relative_to(root)
        if not module:
            continue
        if module[0] not in line_of:
            problems.append(f"{shown}: {module[0]} has no place: give it one in LAYERS of check_python_layers.py")
            continue
        imported = imports_of(ast.parse(path.read_text(encoding="utf-8")), set(files), module, path.name == "__init__.py")
        for number, target in imported:
            looked_at += 1
            if not target:
                continue
            uses.setdefault(module, set()).add(target)
            here, there = module[0], target[0]
            if here == there or there not in line_of:
                continue
            allowed = ONLY.get(here)
            if allowed is not None and not any(target[: len(one)] == one for one in allowed):
                problems.append(f"{shown}:{number}: {here} imports {'.'.join(target)}, which it is to stay independent of")
            if line_of[there] <= line_of[here]:
                problems.append(f"{shown}:{number}: {here} imports {'.'.join(target)}, which does not stand below it")
    return problems + circles(uses), looked_at


if __name__ == "__main__":
    sys.exit(run("python layers", "imports", check, __doc__))
