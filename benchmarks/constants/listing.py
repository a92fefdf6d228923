"""Finds the constants in the sources: module, name, value, and the comment that gives the reason. Nothing is imported or run.

A constant is a name at the top of a module, or in the body of a class, that is bound to numbers: a number, a tuple or table of them, or what arithmetic makes of them. The numbers that
a class hands to a call, as a strategy does for its limits, count each by its keyword. Zero, and in a class one, are the absence of something and steer nothing.
"""

from __future__ import annotations

import ast
import re
import tokenize
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import StringIO
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "tools" / "ema_tools"
# Folders, and modules of others, whose numbers decide what is named.
STEERING = ("base", "library", "data.records", "balances", "fit", "compare", "select", "design", "tasks")
# What may have set a number: the word in brackets that ends its comment.
SET_BY: Mapping[str, str] = {
    "physics": "how machines, sensors or commands are",
    "chance": "what noise alone reaches seldom enough",
    "measured": "on the reference actuator or on machines of the benchmark",
    "precision": "what arithmetic and the simulation resolve",
    "effort": "the time or memory that it may take",
    "layout": "agreed with a format or a picture",
    "judgement": "a round number that nobody has measured",
}
_BRACKET = re.compile(r"\s*\[(\w+)\]$")
_MODULES = ("np", "math")
_CALLS = ("range", "np.arange", "np.array", "math.sqrt", "float", "int")


@dataclass(frozen=True)
class Constant:
    """One constant. `module`: dotted, below the package; `name`: of a class's behind the class, of a keyword behind both; `text`: its value as written; `reason`: its comment without `set_by`."""

    module: str
    name: str
    line: int
    text: str
    reason: str
    set_by: str

    @property
    def key(self) -> str:
        """What it is called in files."""
        return f"{self.module}:{self.name}"


@dataclass(frozen=True)
class Bound:
    """A name and the expression that it is bound to, in a tree; `keyword`: the node that holds the expression, for one handed to a call."""

    name: str
    value: ast.expr
    statement: ast.stmt
    keyword: ast.keyword | None = None


def numbers_of(node: ast.expr) -> list[float] | None:
    """The numbers that are written in an expression; None where it is made of anything else."""
    if isinstance(node, ast.Constant):
        return [node.value] if isinstance(node.value, (int, float)) and not isinstance(node.value, bool) else None
    if isinstance(node, ast.Name):
        return []
    if isinstance(node, ast.Attribute):
        return [] if isinstance(node.value, ast.Name) and node.value.id in _MODULES else None
    if isinstance(node, ast.Dict):
        return _all(node.values)
    if isinstance(node, (ast.Tuple, ast.List)):
        return _all(node.elts)
    if isinstance(node, ast.BinOp):
        return _all([node.left, node.right])
    if isinstance(node, (ast.UnaryOp, ast.Starred)):
        return numbers_of(node.operand if isinstance(node, ast.UnaryOp) else node.value)
    if isinstance(node, ast.Call) and ast.unparse(node.func) in _CALLS and not node.keywords:
        return _all(node.args)
    return None


def _all(nodes: list[ast.expr]) -> list[float] | None:
    found: list[float] = []
    for node in nodes:
        numbers = numbers_of(node)
        if numbers is None:
            return None
        found += numbers
    return found


def _steers(node: ast.expr, neutral: tuple[float, ...] = (0.0,)) -> bool:
    return any(abs(number) not in neutral for number in numbers_of(node) or ())


def _assigned(statement: ast.stmt) -> Iterator[tuple[str, ast.expr]]:
    """Names bound by a statement, those of `A, B = 1, 2` one by one."""
    if isinstance(statement, ast.AnnAssign) and statement.value is not None and isinstance(statement.target, ast.Name):
        yield statement.target.id, statement.value
    elif isinstance(statement, ast.Assign):
        for target in statement.targets:
            if isinstance(target, ast.Name):
                yield target.id, statement.value
            elif isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
                yield from (
                    (one.id, value) for one, value in zip(target.elts, statement.value.elts, strict=True) if isinstance(one, ast.Name)
                )


def bound_in(tree: ast.Module) -> Iterator[Bound]:
    """The constants of one module, in the order in which they stand there."""
    for statement in tree.body:
        for name, value in _assigned(statement):
            if _steers(value):
                yield Bound(name, value, statement)
        if isinstance(statement, ast.ClassDef) and not any("Enum" in ast.unparse(base) for base in statement.bases):
            yield from _of_class(statement)


def _of_class(owner: ast.ClassDef) -> Iterator[Bound]:
    for statement in owner.body:
        for name, value in _assigned(statement):
            if isinstance(value, ast.Call) and not _steers(value):
                for keyword in value.keywords:
                    if _steers(keyword.value):
                        yield Bound(f"{owner.name}.{name}.{keyword.arg}", keyword.value, statement, keyword)
            elif _steers(value, (0.0, 1.0)):
                yield Bound(f"{owner.name}.{name}", value, statement)


def _comments(text: str) -> tuple[dict[int, str], dict[int, str]]:
    """Comments by their line: those that fill it, and those behind code."""
    lines = text.splitlines()
    alone: dict[int, str] = {}
    behind: dict[int, str] = {}
    for token in tokenize.generate_tokens(StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            place = alone if not lines[token.start[0] - 1][: token.start[1]].strip() else behind
            place[token.start[0]] = token.string.lstrip("# ").strip()
    return alone, behind


def _reason(bound: Bound, alone: Mapping[int, str], behind: Mapping[int, str]) -> str:
    """The comment behind a constant, else the one that stands directly above it."""
    first, last = bound.statement.lineno, bound.statement.end_lineno or bound.statement.lineno
    if bound.keyword is not None:
        own = behind.get(bound.keyword.value.end_lineno or 0, "")
        if own:
            return own
    found = " ".join(behind[line] for line in range(first, last + 1) if line in behind) if bound.keyword is None else ""
    if found:
        return found
    above: list[str] = []
    line = first - 1
    while line in alone:
        above.insert(0, alone[line])
        line -= 1
    return " ".join(above)


def steering_modules(package: Path = PACKAGE) -> dict[str, Path]:
    """Dotted name to file."""
    found = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        if any(name == one or name.startswith(f"{one}.") for one in STEERING):
            found[name] = path
    return found


def constants_in(module: str, text: str) -> list[Constant]:
    """The constants of one module's source."""
    alone, behind = _comments(text)
    found = []
    for bound in bound_in(ast.parse(text)):
        reason = _reason(bound, alone, behind)
        told = _BRACKET.search(reason)
        found.append(
            Constant(
                module,
                bound.name,
                bound.value.lineno,
                ast.unparse(bound.value),
                _BRACKET.sub("", reason),
                told.group(1) if told else "",
            )
        )
    return found


@lru_cache(maxsize=1)
def constants() -> tuple[Constant, ...]:
    """All that steer, by module."""
    return tuple(one for module, path in steering_modules().items() for one in constants_in(module, path.read_text(encoding="utf-8")))


def without_reason(found: tuple[Constant, ...]) -> list[str]:
    """What is wrong with the reasons, one line each that says what to write."""
    words = ", ".join(SET_BY)
    lines = []
    for one in found:
        if not one.reason or one.set_by not in SET_BY:
            fault = "its comment does not say what set it" if one.reason else "no comment"
            place = f"{one.module.replace('.', '/')}.py:{one.line}: {one.name}"
            lines.append(f"{place}: {fault}: say what it is and, last and in brackets, what set it: one of {words}")
    return lines


class Reads(ast.NodeVisitor):
    """Which constants a module reads: its own, those that it imports by name, and those behind a module that it imports."""

    def __init__(self, module: str, own: set[str], known: Mapping[str, set[str]]) -> None:
        self.module, self.known = module, known
        self.names = {name: f"{module}:{name}" for name in own}
        self.modules: dict[str, str] = {}
        self.found: set[str] = set()

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Names by which constants or their modules go here."""
        origin = (node.module or "").removeprefix(PACKAGE.name).removeprefix(".")
        for alias in node.names:
            called = alias.asname or alias.name
            if alias.name in self.known.get(origin, ()):
                self.names[called] = f"{origin}:{alias.name}"
            below = f"{origin}.{alias.name}".removeprefix(".")
            if below in self.known:
                self.modules[called] = below

    def key_of(self, node: ast.expr) -> str | None:
        """The constant that an expression reads."""
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            return self.names.get(node.id)
        if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and isinstance(node.value, ast.Name):
            origin = self.modules.get(node.value.id, "")
            return f"{origin}:{node.attr}" if node.attr in self.known.get(origin, ()) else None
        return None

    def visit_Name(self, node: ast.Name) -> None:
        """A name that is read."""
        self.found |= {key for key in [self.key_of(node)] if key}

    def visit_Attribute(self, node: ast.Attribute) -> None:
        """A name of a module that is read."""
        self.found |= {key for key in [self.key_of(node)] if key}
        self.generic_visit(node)


def known_names() -> dict[str, set[str]]:
    """By module the names that are bound at its top; what a class holds is reached through the class."""
    found: dict[str, set[str]] = {module: set() for module in steering_modules()}
    for one in constants():
        if "." not in one.name:
            found[one.module].add(one.name)
    return found


def unused(package: Path = PACKAGE) -> list[str]:
    """Keys of constants that nothing in the package reads."""
    known = known_names()
    read: set[str] = set()
    for path in package.rglob("*.py"):
        parts = path.relative_to(package).with_suffix("").parts
        module = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        reads = Reads(module, known.get(module, set()), known)
        reads.visit(ast.parse(path.read_text(encoding="utf-8")))
        read |= reads.found
    return [f"{module}:{name}" for module, names in known.items() for name in sorted(names) if f"{module}:{name}" not in read]
