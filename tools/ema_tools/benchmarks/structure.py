"""How the tools are laid out, in numbers, today and at an earlier state of the project.

    python -m ema_tools.benchmarks.structure                 # as they are
    python -m ema_tools.benchmarks.structure --than REV      # beside those of a commit

Counted are the sources alone; nothing is run. Where an effect may be named on purpose (the reference model, the truth plant, benchmarks and vectors, its own record) is left out of its places.
"""

from __future__ import annotations

import argparse
import ast
import io
import re
import subprocess
import sys
import tarfile
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

_ROOT = Path(__file__).resolve().parents[3]
_PACKAGE = "tools/ema_tools/"
_LIST = "include/ema/ema_effects.def"
_ROW = re.compile(r"^EMA_EFFECT\((?!name\b)(\w+),", re.MULTILINE)
_APART = ("reference/", "truth/", "benchmarks/", "vectors/")
_CONSTANT = re.compile(r"_?[A-Z][A-Z0-9_]*$")


def sources(revision: str = "") -> dict[str, str]:
    """Text by path of the tools and the list of effects, as they are or at a commit."""
    if not revision:
        paths = [*(_ROOT / _PACKAGE).rglob("*.py"), _ROOT / _LIST]
        return {path.relative_to(_ROOT).as_posix(): path.read_text(encoding="utf-8") for path in sorted(paths)}
    packed = subprocess.run(["git", "archive", revision, _PACKAGE, _LIST], cwd=_ROOT, capture_output=True, check=True).stdout
    found: dict[str, str] = {}
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        for member in archive:
            file = archive.extractfile(member) if member.isfile() else None
            if file is not None and member.name.endswith((".py", ".def")):
                found[member.name] = file.read().decode()
    return found


def _circles(trees: Mapping[str, ast.Module]) -> int:
    """Groups of files that import each other, in a round about way or not."""
    names = {path.removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in trees}
    uses: dict[str, set[str]] = {}
    for module, path in names.items():
        wanted: set[str] = set()
        for node in ast.walk(trees[path]):
            if isinstance(node, ast.ImportFrom) and node.module:
                inner = [f"{node.module}.{alias.name}" for alias in node.names]
                wanted |= {name if name.removeprefix("ema_tools.") in names else node.module for name in inner}
        uses[module] = {other for other in names if f"ema_tools.{other}" in wanted and other != module}
    reach = {module: _reached(module, uses) for module in names}
    return len({frozenset(other for other in reach[one] if one in reach[other]) for one in names if one in reach[one]})


def _reached(start: str, uses: Mapping[str, set[str]]) -> set[str]:
    done: set[str] = set()
    waiting = list(uses[start])
    while waiting:
        module = waiting.pop()
        if module not in done:
            done.add(module)
            waiting += uses[module]
    return done


def _constants(tree: ast.Module) -> Iterator[str]:
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target] if isinstance(node, ast.AnnAssign) else []
        for target in targets:
            for name in target.elts if isinstance(target, ast.Tuple) else (target,):
                if isinstance(name, ast.Name) and _CONSTANT.match(name.id):
                    yield name.id


def counted(found: Mapping[str, str]) -> dict[str, str]:
    """The rows of the table, by what is counted."""
    effects = [name for name in _ROW.findall(found[_LIST]) if not name.startswith("learned_")]
    own = {path.removeprefix(_PACKAGE): text for path, text in found.items() if path.startswith(_PACKAGE)}
    trees = {path: ast.parse(text) for path, text in own.items()}
    acting = {path: text for path, text in own.items() if not path.startswith(_APART)}
    places = [sum(bool(re.search(rf"\b{name}\b", text)) for text in acting.values()) for name in effects]
    classes = Counter(node.name for path in acting for node in ast.walk(trees[path]) if isinstance(node, ast.ClassDef))
    asked = [
        node
        for path in acting
        for node in ast.walk(trees[path])
        if isinstance(node, ast.Attribute)
        and node.attr == "relative"
        and not (isinstance(node.value, ast.Name) and node.value.id in ("self", "one"))
    ]
    lines = {path: text.count("\n") for path, text in own.items()}
    return {
        "files": str(len(own)),
        "lines": str(sum(lines.values())),
        "lines of the longest file": str(max(lines.values())),
        "files that name an effect, besides its equations: mean over the effects": f"{sum(places) / len(places):.1f}",
        "the same of the effect with most": str(max(places)),
        "class names that stand more than once": str(sum(count > 1 for count in classes.values())),
        "times that the mode (healthy repeats or none) is asked for": str(len(asked)),
        "constants of modules": str(sum(len(list(_constants(trees[path]))) for path in acting)),
        "circles of imports": str(_circles({path: trees[path] for path in acting})),
    }


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--than", default="", help="a commit to stand beside today")
    arguments = parser.parse_args()
    today = counted(sources())
    then = counted(sources(arguments.than)) if arguments.than else {}
    print(f"| | {'before | ' if then else ''}today |\n|---|{'---:|' if then else ''}---:|")
    for name, value in today.items():
        print(f"| {name} | {then[name] + ' | ' if then else ''}{value} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
