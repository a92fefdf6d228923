"""The package imported with constants changed, or with every reading of the constants noted.

The source is changed before it is compiled, so a name that another module imported, the default of a parameter and an attribute of a class hold the changed value too. It has to be
installed before anything that holds or reads constants is imported: in a process of its own.
"""

from __future__ import annotations

import ast
import builtins
import sys
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from typing import Any

from benchmarks.constants.listing import PACKAGE, Reads, bound_in, known_names

Rewrite = Callable[[str, ast.Module], ast.Module]
_SCALED, _READ = "__ema_scaled__", "__ema_read__"


def scaled(value: Any, factor: float) -> Any:
    """The value with every number in it times a factor; whole numbers stay whole, and above zero where they were."""
    if isinstance(value, bool):
        return value
    if isinstance(value, int):
        return max(round(value * factor), 1) if value > 0 else round(value * factor)
    if isinstance(value, float) or hasattr(value, "dtype"):
        return value * factor
    if isinstance(value, dict):
        return {name: scaled(one, factor) for name, one in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(scaled(one, factor) for one in value)
    return value


class _Loader(SourceFileLoader):
    """Compiles a module from its rewritten source, past what is compiled on the disk."""

    rewrite: Rewrite

    def get_code(self, fullname: str) -> types.CodeType:
        """The module's code."""
        path = self.get_filename(fullname)
        tree = self.rewrite(fullname.removeprefix(f"{PACKAGE.name}."), ast.parse(self.get_data(path)))
        code: types.CodeType = compile(ast.fix_missing_locations(tree), path, "exec")
        return code


class _Finder(MetaPathFinder):
    def __init__(self, rewrite: Rewrite) -> None:
        self.rewrite = rewrite

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: types.ModuleType | None = None) -> ModuleSpec | None:
        """The package's own modules, by a loader that rewrites."""
        if not fullname.startswith(f"{PACKAGE.name}."):
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            loader = _Loader(spec.loader.name, spec.loader.path)
            loader.rewrite = self.rewrite
            spec.loader = loader
        return spec


def _install(rewrite: Rewrite, helpers: Mapping[str, Callable[..., Any]]) -> None:
    early = sorted(name for module in known_names() if (name := f"{PACKAGE.name}.{module}") in sys.modules)
    if early:
        raise RuntimeError(f"{early[0]} is imported already: change constants in a process of its own, before anything else")
    for name, helper in helpers.items():
        setattr(builtins, name, helper)
    sys.meta_path.insert(0, _Finder(rewrite))


def install_change(keys: Iterable[str], factor: float) -> dict[str, bool]:
    """From here on the constants of these keys, module:name, are imported times a factor. The result tells, of those that were imported, whether that changed them."""
    names: dict[str, list[str]] = {}
    for key in keys:
        module, _, name = key.partition(":")
        names.setdefault(module, []).append(name)
    changed: dict[str, bool] = {}

    def helper(key: str, value: Any) -> Any:
        there = scaled(value, factor)
        changed[key] = repr(there) != repr(value)
        return there

    def rewrite(origin: str, tree: ast.Module) -> ast.Module:
        bound = {one.name: one.value for one in bound_in(tree) if one.name in names.get(origin, ())}
        for name in names.get(origin, ()):
            value = bound[name]
            # the call takes the place of the expression wherever it stands
            call = ast.Call(ast.Name(_SCALED, ast.Load()), [ast.Constant(f"{origin}:{name}"), value], [])
            _Replaced(value, call).visit(tree)
        return tree

    _install(rewrite, {_SCALED: helper})
    return changed


class _Replaced(ast.NodeTransformer):
    """One node of a tree in place of another."""

    def __init__(self, node: ast.expr, other: ast.expr) -> None:
        self.node, self.other = node, other

    def visit(self, node: ast.AST) -> Any:
        """The other one where the node is, what is below it left as it is."""
        return self.other if node is self.node else self.generic_visit(node)


def install_notes() -> tuple[set[str], set[str]]:
    """From here on the keys of constants that are read come into the first set, those that were read while a module was imported, whose use cannot be told, into the second.

    What a class holds is read through the class, which cannot be told either.
    """
    known = known_names()
    read: set[str] = set()
    imported: set[str] = set()

    def helper(key: str, value: Any) -> Any:
        read.add(key)
        return value

    def rewrite(origin: str, tree: ast.Module) -> ast.Module:
        reads = Reads(origin, known.get(origin, set()), known)
        reads.visit(tree)
        noted = _Noted(reads)
        tree = noted.visit(tree)
        imported.update(noted.outside)
        return tree

    _install(rewrite, {_READ: helper})
    return read, imported


class _Noted(ast.NodeTransformer):
    """Every reading of a constant inside a function told to the note taker."""

    def __init__(self, reads: Reads) -> None:
        self.reads = reads
        self.depth = 0
        self.outside: set[str] = set()

    def _function(self, node: Any) -> Any:
        arguments, body = node.args, node.body
        # defaults and decorators are worked out where the function is made
        node.args = self.visit(arguments)
        if hasattr(node, "decorator_list"):
            node.decorator_list = [self.visit(one) for one in node.decorator_list]
        self.depth += 1
        node.body = [self.visit(one) for one in body] if isinstance(body, list) else self.visit(body)
        self.depth -= 1
        return node

    visit_FunctionDef = visit_AsyncFunctionDef = visit_Lambda = _function

    def _reading(self, node: ast.expr) -> ast.expr:
        key = self.reads.key_of(node)
        if key is None:
            return node
        if not self.depth:
            self.outside.add(key)
            return node
        return ast.Call(ast.Name(_READ, ast.Load()), [ast.Constant(key), node], [])

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """A name."""
        return self._reading(node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """A name of a module, or what holds one."""
        found = self._reading(node)
        if found is node:
            node.value = self.visit(node.value)
        return found
