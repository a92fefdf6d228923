"""Worst stack of every public function of the module, from gcc's call graph of a cross build (-fcallgraph-info=su).

A frame is what gcc says, a function's worst is its frame and that of its deepest callee. Recursion, a call through a pointer, a frame of unknown size and a function
that nothing defines are errors, so the numbers are bounds. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path

NODE = re.compile(r'^node: \{ title: "([^"]*)" label: "([^"]*)"( shape : ellipse)? \}$')
EDGE = re.compile(r'^edge: \{ sourcename: "([^"]*)" targetname: "([^"]*)"')
FRAME = re.compile(r"\\n(\d+) bytes \(([^)]*)\)")
INDIRECT = "__indirect_call"
# What the compiler calls by itself; newlib's and libgcc's versions for these cores push no more than this.
LIBRARY_BYTES = {
    "memcpy": 16,
    "memset": 16,
    "memmove": 16,
    "memcmp": 16,
    "sqrtf": 16,
    "__aeabi_ul2f": 16,
    "__aeabi_l2f": 16,
    "__aeabi_f2ulz": 32,
}
# The same where the processor has no float unit: no routine of libgcc pushes more than nine registers and sets three words aside, newlib's square root less than twice that.
SOFT_BYTES, SOFT_SQUARE_ROOT = 48, 96
PUBLIC = re.compile(r"\b(ema_\w+)\(")


class StackError(Exception):
    """Why a bound cannot be given."""


@dataclass
class Graph:
    """Frames in bytes and callees, by the function's name in the graph."""

    frames: dict[str, int] = field(default_factory=dict)
    calls: dict[str, set[str]] = field(default_factory=dict)
    soft: bool = False  # the processor has no float unit
    own: bool = False  # of the module's own functions alone: another library's frames are not known

    def add(self, text: str) -> None:
        """Adds one file of gcc's graph."""
        for line in text.splitlines():
            node, edge = NODE.match(line), EDGE.match(line)
            if node and not node[3]:
                frame = FRAME.search(node[2])
                if frame is None or frame[2] not in ("static", "dynamic,bounded"):
                    raise StackError(f"{node[1]}: a frame of unknown size: keep arrays of variable length out")
                self.frames[node[1]] = int(frame[1])
            elif edge:
                self.calls.setdefault(edge[1], set()).add(edge[2])

    def frame(self, name: str) -> int:
        """Bytes of the only function `name`, of whatever file. Raises StackError."""
        found = [size for title, size in self.frames.items() if title.rsplit(":", 1)[-1] == name]
        if len(found) != 1:
            raise StackError(f"{name}: {len(found)} such functions in the call graph instead of one")
        return found[0]

    def worst(self, name: str, above: tuple[str, ...] = ()) -> tuple[int, tuple[str, ...]]:
        """Bytes and the chain of calls that takes them."""
        if name in above:
            raise StackError(f"{' -> '.join(above)} -> {name}: recursion")
        if name == INDIRECT:
            raise StackError(f"{above[-1]}: calls through a pointer: name the function")
        if name not in self.frames:
            plain = name.removeprefix("__builtin_")
            if self.own and (plain in LIBRARY_BYTES or plain.startswith("_")):
                return 0, (plain,)
            if self.soft and plain.startswith("__aeabi_"):
                return SOFT_BYTES, (plain,)
            if self.soft and plain == "sqrtf":
                return SOFT_SQUARE_ROOT, (plain,)
            if plain not in LIBRARY_BYTES:
                raise StackError(f"{above[-1] if above else 'list'}: {name} is not in the call graph: is the whole module built?")
            return LIBRARY_BYTES[plain], (plain,)
        deepest: tuple[int, tuple[str, ...]] = (0, ())
        for callee in sorted(self.calls.get(name, ())):
            deepest = max(deepest, self.worst(callee, (*above, name)), key=lambda found: found[0])
        return self.frames[name] + deepest[0], (name.rsplit(":", 1)[-1], *deepest[1])


def load(folder: Path, soft: bool = False, own: bool = False) -> Graph:
    """The graph of every .ci file below `folder`; `soft`: of a processor without a float unit; `own`: without the library's frames. Raises StackError when there is none."""
    files = sorted(folder.rglob("*.ci"))
    if not files:
        raise StackError(f"{folder}: no call graph: build with -fcallgraph-info=su")
    graph = Graph(soft=soft, own=own)
    for path in files:
        graph.add(path.read_text(encoding="utf-8"))
    return graph


def public_functions(include: Path) -> list[str]:
    """Names declared in the public headers."""
    names: set[str] = set()
    for path in sorted(include.rglob("*.h")):
        for line in re.sub(r"/\*.*?\*/", "", path.read_text(encoding="utf-8"), flags=re.DOTALL).splitlines():
            if line and not line.startswith(("#", " ", "typedef")):
                names.update(PUBLIC.findall(line))
    return sorted(names)


def worst_of(objects: Path, include: Path, soft: bool = False) -> dict[str, tuple[int, tuple[str, ...]]]:
    """Worst stack of every public function. Raises StackError."""
    graph = load(objects, soft)
    names = public_functions(include)
    if not names:
        raise StackError(f"{include}: no public function: name the folder include/ema")
    return {name: graph.worst(name) for name in names}


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("objects", type=Path, help="folder with the .ci files of the library")
    parser.add_argument("include", type=Path, help="folder of the public headers")
    given = parser.parse_args()
    try:
        found = worst_of(given.objects, given.include)
    except StackError as error:
        print(error, file=sys.stderr)
        return 1
    for name, (size, chain) in sorted(found.items(), key=lambda item: -item[1][0]):
        print(f"{size:6d}  {name}: {' > '.join(chain)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
