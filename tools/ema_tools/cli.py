"""The command `ema`: words to functions. Exit code 0 when it did its job, 1 on a bad input with one line that names it, 2 on wrong usage.

Modules behind a command are imported by the command, so that help and errors come at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, TypeVar

import click

from ema_tools.console import complain, output
from ema_tools.definitions import DefinitionError
from ema_tools.errors import InputError, MissingSignal

Command = TypeVar("Command", bound=Callable[..., Any])

_CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


def json_option(command: Command) -> Command:
    """--json FILE and --force."""
    command = click.option("--force", is_flag=True, help="Overwrite files that exist.")(command)
    return click.option("--json", "json_path", metavar="FILE", help="Write the full result there.")(command)


def precision_option(default: str) -> Callable[[Command], Command]:
    """--precision 32 or 64."""
    return click.option("--precision", type=click.Choice(["32", "64"]), default=default, show_default=True, help="Build of the module: 32 as onboard, 64 for analysis.")


def save(json_path: str | None, result: dict[str, Any], force: bool) -> None:
    """Write --json when it was asked for."""
    if json_path:
        from ema_tools.files import write_json

        write_json(json_path, result, force)


def writable(*paths: str | None, force: bool) -> None:
    """Complain about existing files before the work, not after it."""
    from ema_tools.files import may_write

    for path in paths:
        if path:
            may_write(path, force)


@click.group(context_settings=_CONTEXT)
@click.version_option(package_name="ema_tools", prog_name="ema")
def cli() -> None:
    """Model, identify and watch over an electromechanical actuator.

    ACTUATOR is a TOML file, REC a recording (CSV, .mat or .parquet).
    """


@cli.command()
@click.argument("actuator")
@click.option("--command", "command_text", required=True, metavar="CMD", help="A recording, or chirp, multisine, triangle, trapezoid, step with numbers: chirp:amplitude_mm=2,end_hz=4.")
@click.option("-o", "--output", "out", required=True, metavar="REC.csv", help="The recording to write.")
@click.option("--set", "settings", multiple=True, metavar="NAME=VALUE", help="Change a value of the actuator: screw.csj_Nm=0.3. May be repeated.")
@click.option("--noise", metavar="COLUMN=STD,...", help="Add white noise: position_mm=0.005,current_A=0.03.")
@click.option("--seed", type=int, default=1, show_default=True, help="Seed of the noise.")
@precision_option("64")
@json_option
def simulate(actuator: str, command_text: str, out: str, settings: tuple[str, ...], noise: str | None, seed: int, precision: str, json_path: str | None, force: bool) -> None:
    """Simulate ACTUATOR under a command and write the recording."""
    from ema_tools import simulate as work
    from ema_tools.actuator import read_actuator
    from ema_tools.commands import make_command
    from ema_tools.records import write_record

    writable(out, json_path, force=force)
    model = work.with_settings(read_actuator(actuator), settings)
    std = work.noise_of(noise)
    command = make_command(command_text, model)
    record = work.simulate_record(model, command, int(precision), std, seed)
    comments = [f"Simulated: {model.name}, {command.text}, {precision} bit."]
    if settings:
        comments.append(f"Changed: {', '.join(settings)}.")
    if std:
        comments.append(f"White noise: {', '.join(f'{name} {value:g}' for name, value in std.items())}, seed {seed}.")
    write_record(out, record, tuple(comments), force, 17 if precision == "64" else 9)
    save(json_path, {"command": "simulate", "actuator": actuator, "record": out, "rows": record.rows, "period_s": record.period_s, "settings": list(settings), "noise": std, "seed": seed, "precision": int(precision)}, force)
    output().print(f"{out}: {record.rows} rows, {record.rows * record.period_s:g} s", highlight=False)


@cli.command()
@click.argument("effect", required=False)
@json_option
def effects(effect: str | None, json_path: str | None, force: bool) -> None:
    """Show the library of physical effects, or one EFFECT."""
    from ema_tools import effects as work
    from ema_tools.definitions import load_definitions

    rows = [work.find_effect(effect)] if effect else list(load_definitions().effects)
    save(json_path, {"command": "effects", "effects": [work.describe(row) for row in rows]}, force)
    if effect:
        work.print_one(output(), rows[0])
    else:
        work.print_all(output())


def main() -> None:
    """Entry point: runs the command line and ends the process with its exit code."""
    from ema_tools.native import LibraryError

    try:
        cli(prog_name="ema", standalone_mode=False)
    except (InputError, MissingSignal, LibraryError, DefinitionError) as error:
        complain(str(error))
        sys.exit(1)
    except click.exceptions.Abort:
        complain("interrupted")
        sys.exit(130)
    except click.ClickException as error:
        error.show()
        sys.exit(2)
    except BrokenPipeError:
        sys.exit(0)
