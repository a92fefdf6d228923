"""Checks that a class name of the tools is used once; no library serves, since linters compare no names across files."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

from sources import run


def check(root: Path) -> tuple[list[str], int]:
    """Problems, and the number of classes that were looked at."""
    package = root / "tools" / "ema_tools"
    places: dict[str, list[str]] = {}
    for path in sorted(package.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(f"{path.relative_to(root)}:{node.lineno}")
    problems = [
        f"{where[1]}: class {name} stands at {where[0]}, too: give one of them a name of its own"
        for name, where in places.items()
        if len(where) > 1
    ]
    return problems, sum(map(len, places.values()))


if __name__ == "__main__":
    sys.exit(run("class names", "classes", check, __doc__))
