"""The two lists that make an actuator, read from the C headers `ema_params.def` and `ema_effects.def`, and the user's own `own_effects.def` where the libraries were built with one.

These lists are the single source of names, nominal values, ranges and texts; Python keeps no copy of them.
"""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

_UNITS = (
    ("Nm_per_sqrt_rad_s", "Nm/sqrt(rad/s)"),
    ("Nm_s2_per_rad2", "Nm s2/rad2"),
    ("Nm_s_per_rad", "Nm s/rad"),
    ("V_s_per_rad", "V s/rad"),
    ("Nm_per_mm", "Nm/mm"),
    ("Nm_per_A", "Nm/A"),
    ("per_m_s", "1/(m s)"),
    ("s_per_m", "s/m"),
    ("rad_s", "rad/s"),
    ("kgm2", "kg m2"),
    ("mm2s", "mm2 s"),
    ("m_s", "m/s"),
    ("per_m", "1/m"),
    ("per_s", "1/s"),
    ("percent", "%"),
    ("degC", "degC"),
    ("Nm", "Nm"),
    ("mm", "mm"),
    ("ohm", "ohm"),
    ("rad", "rad"),
    ("kg", "kg"),
    ("V", "V"),
    ("A", "A"),
    ("H", "H"),
    ("s", "s"),
)


class DefinitionError(ValueError):
    """A list is missing or a row of it cannot be read; the message names file, row and what to do."""


def unit_of(field: str) -> str:
    """The unit that the suffix of `field` names, as printed text; empty for a plain number."""
    for suffix, unit in _UNITS:
        if field.endswith("_" + suffix):
            return unit
    return ""


@dataclass(frozen=True)
class Parameter:
    """One row of `ema_params.def`: a real number, or an option (`is_option`) that is a whole number or a choice."""

    section: str
    field: str
    nominal: float
    lower: float
    upper: float
    text: str
    is_option: bool = False
    choices: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name in TOML and in Python: `section.field`."""
        return f"{self.section}.{self.field}"

    @property
    def unit(self) -> str:
        """Unit from the suffix of the field."""
        return unit_of(self.field)


@dataclass(frozen=True)
class EffectParameter:
    """One EMA_P of an effect; the first of an effect is its size and its nominal value is the effect's zero."""

    effect: str
    field: str
    nominal: float
    lower: float
    upper: float
    text: str

    @property
    def name(self) -> str:
        """Name in Python: `effect.field`."""
        return f"{self.effect}.{self.field}"

    @property
    def unit(self) -> str:
        """Unit from the suffix of the field."""
        return unit_of(self.field)


@dataclass(frozen=True)
class Effect:
    """One row of `ema_effects.def`."""

    name: str
    site: str
    memory: int
    substeps: int
    equation: str
    source: str
    look_alikes: tuple[str, ...]
    parameters: tuple[EffectParameter, ...]
    is_learned: bool = False  # no physical effect but a table that holds what was learned from records
    is_own: bool = False  # from the user's own list

    @property
    def nodes(self) -> tuple[EffectParameter, ...]:
        """The nodes of a learned table in their order; nothing for a physical effect."""
        return tuple(row for row in self.parameters if row.field.startswith("node_")) if self.is_learned else ()

    @property
    def size(self) -> EffectParameter:
        """The parameter whose nominal value means that the effect is absent."""
        return self.parameters[0]


@dataclass(frozen=True, eq=False)
class Definitions:
    """Both lists in the order of the files; there is one object of them, which is compared as such."""

    parameters: tuple[Parameter, ...]
    effects: tuple[Effect, ...]

    @property
    def reals(self) -> tuple[Parameter, ...]:
        """The real parameters, in the order of the C structure."""
        return tuple(row for row in self.parameters if not row.is_option)

    @property
    def options(self) -> tuple[Parameter, ...]:
        """The options, in the order of the C structure."""
        return tuple(row for row in self.parameters if row.is_option)

    @property
    def effect_values(self) -> tuple[EffectParameter, ...]:
        """The values of all effects, in the order of the C structure."""
        return tuple(value for effect in self.effects for value in effect.parameters)

    @property
    def rows(self) -> tuple[Parameter | EffectParameter, ...]:
        """The parameters and the values of all effects, in the order of the files."""
        return (*self.parameters, *self.effect_values)

    @property
    def ids(self) -> dict[str, int]:
        """Name to the C library's id: real parameters, then effect values, then options."""
        rows: tuple[Parameter | EffectParameter, ...] = (*self.reals, *self.effect_values, *self.options)
        return {row.name: index for index, row in enumerate(rows)}

    @property
    def sections(self) -> dict[str, tuple[Parameter, ...]]:
        """Section to its rows, in the order of the file."""
        found: dict[str, list[Parameter]] = {}
        for row in self.parameters:
            found.setdefault(row.section, []).append(row)
        return {section: tuple(rows) for section, rows in found.items()}

    @functools.cached_property
    def by_name(self) -> dict[str, Parameter | EffectParameter]:
        """Every row by its `section.field` or `effect.field`."""
        return {row.name: row for row in self.rows}

    def find(self, name: str) -> Parameter | EffectParameter:
        """The row called `section.field` or `effect.field`. Raises KeyError with a message that lists the nearest names."""
        if name in self.by_name:
            return self.by_name[name]
        first = name.split(".", 1)[0]
        near = [row.name for row in self.rows if row.name.split(".", 1)[0] == first]
        known = near or [*self.sections, *(effect.name for effect in self.effects)]
        raise KeyError(f"{name}: no such value; use one of {', '.join(known)}")

    def effect(self, name: str) -> Effect:
        """The effect called `name`. Raises KeyError with a message that lists the effects."""
        for row in self.effects:
            if row.name == name:
                return row
        raise KeyError(f"{name}: no such effect; use one of {', '.join(row.name for row in self.effects)}")


def definition_folder() -> Path:
    """Folder that holds the two lists: EMA_DEFINITIONS, the repository around this file, or the package itself.

    Raises DefinitionError when none of them does.
    """
    return _definition_folder(os.environ.get("EMA_DEFINITIONS"))


@functools.lru_cache
def _definition_folder(named: str | None) -> Path:
    here = Path(__file__).resolve()
    places = [Path(named)] if named else [here.parents[3] / "include" / "ema", here.parents[1] / "include"]
    for place in places:
        if (place / "ema_params.def").is_file() and (place / "ema_effects.def").is_file():
            return place
    raise DefinitionError(f"ema_params.def, ema_effects.def: not in {places[0]}: point EMA_DEFINITIONS at include/ema")


def library_folder() -> Path:
    """Folder of the shared libraries: EMA_LIBRARY_DIR, else `build/lib` of the repository around this file."""
    named = os.environ.get("EMA_LIBRARY_DIR")
    return Path(named) if named else Path(__file__).resolve().parents[3] / "build" / "lib"


def own_folder() -> Path | None:
    """Folder of the user's own `own_effects.def` that the libraries were built with; None without any."""
    return _own_folder(library_folder())


@functools.lru_cache
def _own_folder(libraries: Path) -> Path | None:
    folder = libraries / "own_effects"
    return folder if (folder / "own_effects.def").is_file() else None


_TOKEN = re.compile(
    r"""\s*(?:(?P<string>"(?:[^"\\]|\\.)*")
    |(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)
    |(?P<word>[A-Za-z_]\w*)
    |(?P<mark>[(),]))""",
    re.VERBOSE,
)
_DEFINE = re.compile(r"^#define[ ]+(?P<row>\w+\((?:[^\n\\]|\\\n)*)\n", re.MULTILINE)
_DIRECTIVE = re.compile(r"^#[^\n]*$", re.MULTILINE)
_LEARNED = "_TABLE"  # end of the site of a learned table
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)


def _only_breaks(match: re.Match[str]) -> str:
    return "\n" * match.group().count("\n")


def _tokens(text: str, path: Path) -> Iterator[tuple[str, str, int]]:
    """Tokens (kind, text, row) of a list; comments are skipped but keep their line breaks."""
    blank = _COMMENT.sub(_only_breaks, text)
    place = 0
    while blank[place:].strip():
        match = _TOKEN.match(blank, place)
        row = blank.count("\n", 0, place) + 1
        if match is None:
            raise DefinitionError(f"{path.name}, row {row}: cannot read {blank[place:].strip()[:20]!r}: write EMA_... (a, b, ...)")
        kind = str(match.lastgroup)
        yield kind, match.group(kind), blank.count("\n", 0, match.start(kind)) + 1
        place = match.end()
    yield "end", "", blank.count("\n") + 1


@dataclass(frozen=True)
class _Call:
    """A macro call: its arguments are strings, numbers, words, or lists of calls."""

    name: str
    row: int
    arguments: tuple[object, ...]


class _Reader:
    """Recursive reader of macro calls."""

    def __init__(self, text: str, path: Path) -> None:
        self._path = path
        self._macros: dict[str, tuple[tuple[object, ...], list[_Call]]] = {}
        for match in _DEFINE.finditer(text):
            # a macro of the list: its own call with the names of its arguments, then the calls that it stands for
            head, *body = _Reader(match.group("row").replace("\\\n", "\n"), path).calls()
            self._macros[head.name] = (head.arguments, body)
        plain = _DIRECTIVE.sub("", _DEFINE.sub(_only_breaks, text))
        self._tokens = list(_tokens(plain, path))
        self._place = 0

    def _expanded(self, call: _Call) -> list[_Call]:
        """What `call` stands for: itself, or the calls of the list's own macro with its arguments in them."""
        if call.name not in self._macros:
            return [call]
        names, body = self._macros[call.name]
        if len(names) != len(call.arguments):
            raise DefinitionError(f"{self._path.name}, row {call.row}: {call.name} needs {len(names)} arguments: see its #define")
        given = dict(zip(names, call.arguments, strict=True))
        replaced = (_Call(inner.name, call.row, tuple(given.get(argument, argument) for argument in inner.arguments)) for inner in body)
        return [expanded for inner in replaced for expanded in self._expanded(inner)]

    def _peek(self) -> tuple[str, str, int]:
        return self._tokens[self._place]

    def _next(self) -> tuple[str, str, int]:
        token = self._tokens[self._place]
        self._place += 1
        return token

    def _expect(self, mark: str) -> None:
        kind, text, row = self._next()
        if kind == "end" or text != mark:
            raise DefinitionError(f"{self._path.name}, row {row}: {mark!r} expected, {text!r} found: close the row")

    def calls(self) -> list[_Call]:
        """All calls of the file."""
        found = []
        while self._peek()[0] != "end":
            found.append(self._call())
        return found

    def _call(self) -> _Call:
        kind, name, row = self._next()
        if kind != "word":
            raise DefinitionError(f"{self._path.name}, row {row}: {name!r} is not a macro's name: start the row with EMA_...")
        self._expect("(")
        arguments = [self._argument()]
        while self._peek()[1] == "," and self._peek()[0] == "mark":
            self._next()
            arguments.append(self._argument())
        self._expect(")")
        return _Call(name, row, tuple(arguments))

    def _argument(self) -> object:
        kind, text, row = self._peek()
        if kind == "string":
            joined = ""
            while self._peek()[0] == "string":
                joined += self._next()[1][1:-1].replace('\\"', '"')
            return joined
        if kind == "number":
            self._next()
            return float(text)
        if kind == "word" and self._tokens[self._place + 1][1] == "(":
            inner: list[_Call] = []
            while self._peek()[0] == "word":
                inner += self._expanded(self._call())
            return tuple(inner)
        if kind == "word":
            self._next()
            return text
        raise DefinitionError(f"{self._path.name}, row {row}: an argument is missing before {text!r}: fill the row")


def _typed(call: _Call, kinds: tuple[type, ...], path: Path) -> tuple[Any, ...]:
    """The arguments of `call` when they have the right number and kinds; else DefinitionError."""
    right = len(call.arguments) == len(kinds) and all(
        isinstance(argument, kind) for argument, kind in zip(call.arguments, kinds, strict=True)
    )
    if not right:
        raise DefinitionError(
            f"{path.name}, row {call.row}: {call.name} needs {len(kinds)} arguments of its kind: see the head of the file"
        )
    return call.arguments


def _parameters(path: Path) -> Iterator[Parameter]:
    for call in _Reader(path.read_text(encoding="utf-8"), path).calls():
        if call.name == "EMA_PARAM":
            section, field, nominal, lower, upper, text = _typed(call, (str, str, float, float, float, str), path)
            yield Parameter(str(section), str(field), float(nominal), float(lower), float(upper), str(text))
        elif call.name == "EMA_OPTION":
            kinds = (str, str, float, float, float, str, str)
            section, field, nominal, lower, upper, choices, text = _typed(call, kinds, path)
            names = tuple(str(choices).split("|")) if choices else ()
            yield Parameter(str(section), str(field), float(nominal), float(lower), float(upper), str(text), True, names)
        else:
            raise DefinitionError(f"{path.name}, row {call.row}: {call.name} is not EMA_PARAM or EMA_OPTION: correct the name")


def _effects(path: Path, own: bool = False) -> Iterator[Effect]:
    for call in _Reader(path.read_text(encoding="utf-8"), path).calls():
        if call.name != "EMA_EFFECT":
            raise DefinitionError(f"{path.name}, row {call.row}: {call.name} is not EMA_EFFECT: correct the name")
        kinds = (str, str, float, float, str, str, str, tuple)
        name, site, memory, substeps, equation, source, look_alikes, inner = _typed(call, kinds, path)
        values = []
        for part in inner:
            field, nominal, lower, upper, text = _typed(part, (str, float, float, float, str), path)
            values.append(EffectParameter(str(name), str(field), float(nominal), float(lower), float(upper), str(text)))
        others = tuple(other.strip() for other in str(look_alikes).split(",") if other.strip())
        place = str(site).removesuffix(_LEARNED)
        yield Effect(str(name), place, int(memory), int(substeps), str(equation), str(source), others, tuple(values), place != site, own)


@functools.cache
def read_definitions(folder: Path, own: Path | None = None) -> Definitions:
    """Both lists from `folder`, and the user's from the folder `own`. Raises DefinitionError with file and row."""
    parameters = tuple(_parameters(folder / "ema_params.def"))
    effects = tuple(_effects(folder / "ema_effects.def"))
    if own is not None:
        effects += tuple(_effects(own / "own_effects.def", True))
    names = (
        [row.name for row in parameters]
        + [value.name for effect in effects for value in effect.parameters]
        + [effect.name for effect in effects]
    )
    for name in names:
        if names.count(name) > 1:
            raise DefinitionError(f"{name}: stands twice in the lists: rename one")
    return Definitions(parameters, effects)


def load_definitions() -> Definitions:
    """Both lists from where `definition_folder` finds them, with the user's own effects of the libraries in use."""
    return read_definitions(definition_folder(), own_folder())


def project_definitions() -> Definitions:
    """Both lists as the project has them, without effects of the user's own."""
    known = load_definitions()
    return replace(known, effects=tuple(effect for effect in known.effects if not effect.is_own))


def defaults() -> dict[str, float]:
    """The reference actuator without effects: every `section.field` and `effect.field` at its nominal value."""
    return {row.name: row.nominal for row in load_definitions().rows}


def is_size(name: str) -> bool:
    """Whether a value, `effects.effect.field`, is the size of its effect."""
    return name in {f"effects.{effect.size.name}" for effect in load_definitions().effects}
