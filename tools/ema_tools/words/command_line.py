"""A command as it is typed: taken apart, and the name of a file that it writes."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ema_tools.library.definitions import load_definitions

# Commands whose lines are taken apart, and those of their options that stand for themselves.
_COMMANDS = {"diagnose", "add", "identify", "compare", "map"}
_GREEDY = "--healthy"  # takes every word behind it, as the shell expands a pattern
_NAMES = 100  # of one new file that are tried [layout]
_ARGUMENTS = 2  # an actuator, and a record or an effect [layout]
_FLAGS = {"--force", "--known", "--no-guard", "--exit-code"}


@dataclass(frozen=True)
class CommandLine:
    """A command line taken apart: actuator, records, and options by name."""

    actuator: str
    records: tuple[str, ...]
    options: dict[str, tuple[str, ...]]

    def again(self, *wanted: str) -> list[str]:
        """Options as they were given."""
        said: list[str] = []
        for name in wanted:
            values = self.options.get(name, ())
            said += [name, *values] if name == _GREEDY and values else [part for value in values for part in (name, value)]
        return said


def line_of(command: str) -> CommandLine | None:
    """The parts of a command line that compares, identifies, diagnoses, adds or maps; None where it is none of these."""
    try:
        tokens = shlex.split(command)
    except ValueError:
        return None
    if len(tokens) < 3 or tokens[0] != "ema" or tokens[1] not in _COMMANDS:
        return None
    places: list[str] = []
    options: dict[str, list[str]] = {}
    rest = iter(tokens[2:])
    takes_all = False
    for token in rest:
        if token in _FLAGS:
            takes_all = False
            continue
        if token.startswith("-") and len(token) > 1:
            name, has, value = token.partition("=")
            options.setdefault(name, []).append(value if has else next(rest, ""))
            takes_all = name == _GREEDY
        elif takes_all:
            options[_GREEDY].append(token)
        else:
            places.append(token)
    # the last of them are the arguments, where these would be wanting
    healthy = options.get(_GREEDY, [])
    wanting = min(max(0, _ARGUMENTS - len(places)), max(0, len(healthy) - 1))
    places += healthy[len(healthy) - wanting :]
    del healthy[len(healthy) - wanting :]
    if not places:
        return None
    effects = {row.name for row in load_definitions().effects}
    words = [word for word in places[2:] if word not in effects]
    records = (*words, *options.get("--fit", ())) if tokens[1] == "add" else tuple(places[1:])
    return CommandLine(places[0], records, {name: tuple(values) for name, values in options.items()})


def new_model(record: str, effects: Sequence[str]) -> str:
    """Path of a new actuator file next to the record, named after the effects that it adds, that no file has yet."""
    return new_file(Path(record).with_name(f"with_{'_and_'.join(effects)}.toml"))


def new_file(place: Path) -> str:
    """The path, or one with a number behind it, that no file has yet: nothing is overwritten."""
    names = (place, *(place.with_stem(f"{place.stem}_{number}") for number in range(2, _NAMES)))
    return str(next((name for name in names if not name.exists()), place))
