"""What the commands share: their common options, and what is written and complained about before the work."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from ema_tools.results.reading import Result

Command = TypeVar("Command", bound=Callable[..., Any])


def json_option(command: Command) -> Command:
    """--json FILE and --force."""
    command = click.option("--force", is_flag=True, help="Overwrite files that exist.")(command)
    return click.option("--json", "json_path", metavar="FILE", help="Write the full result there.")(command)


def precision_option(default: str) -> Callable[[Command], Command]:
    """--precision 32 or 64."""
    return click.option(
        "--precision",
        type=click.Choice(["32", "64"]),
        default=default,
        show_default=True,
        help="Build of the module: 32 as onboard, 64 for analysis.",
    )


def method_option(command: Command) -> Command:
    """--method balance or simulation."""
    return click.option(
        "--method",
        type=click.Choice(["balance", "simulation"]),
        help="By the balance of forces, which takes several records of any motion, or by simulation of all signals; chosen by itself otherwise, and said.",
    )(command)


def fix_option(command: Command) -> Command:
    """--fix NAME or NAME=LOW..HIGH, repeated."""
    return click.option(
        "--fix",
        "fixed",
        multiple=True,
        metavar="NAME[=LOW..HIGH]",
        help="By the balance: keep inertia, viscous, csj or load as stated, or between two ends; or an effect of the model as it is. May be repeated.",
    )(command)


def pictures_option(command: Command) -> Command:
    """--pictures DIR."""
    return click.option(
        "--pictures",
        metavar="DIR",
        help="Write what the result has to show there, for documents: NAME_KIND.svg and .png.",
    )(command)


def save(json_path: str | Path | None, result: Result, force: bool) -> None:
    """Write --json when it was asked for."""
    if json_path:
        from ema_tools.base.files import write_json
        from ema_tools.results.codec import to_json

        write_json(json_path, to_json(result), force)


def writable(
    *paths: str | None, json_path: str | None = None, force: bool, inputs: Iterable[str] = (), made: str | Path | None = None
) -> None:
    """Complain before the work, not after it: about outputs that exist, that are one of the inputs, or that are one file, and a --json whose folder does not exist.

    `made`: the folder that the command makes for its outputs.
    """
    from ema_tools.base.files import has_folder, keep_apart, may_write

    outputs = [path for path in (*paths, json_path) if path]
    keep_apart(outputs, inputs)
    if json_path and not (made and Path(json_path).parent == Path(made)):
        has_folder(json_path)
    for path in outputs:
        may_write(path, force)


def command_line() -> str:
    """What the user typed, or what `ema loop` runs for him, for a result's provenance."""
    context = click.get_current_context(silent=True)
    words = context.find_root().obj if context is not None else None
    return shlex.join(["ema", *(words or sys.argv[1:])])
