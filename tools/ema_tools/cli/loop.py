"""`ema loop`: compare, diagnose, add and identify as each result advises, until a verdict or until a person must decide."""

from __future__ import annotations

import contextlib
import io
import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ema_tools.base.errors import InputError
from ema_tools.cli.greedy import TakesHealthy, healthy_option
from ema_tools.cli.options import command_line, json_option, save, writable
from ema_tools.words.terminal.console import output

if TYPE_CHECKING:
    from ema_tools.results.reading import Result

_COMMANDS_MAX = 10  # of one loop: each model that is added needs three [effort]
# Options whose file goes to the folder, and what it is called there.
_WRITES = {"-o": "model", "--report": "page"}


@click.command(cls=TakesHealthy, short_help="Compare, diagnose, add and identify, until a verdict.")
@click.argument("actuator")
@click.argument("record")
@healthy_option("Records of the healthy machine under the same command, two or more; those that ACTUATOR names when there are none.")
@click.option("--holdout", metavar="REC", help="A validation record, to which nothing is fitted, best of another command.")
@click.option(
    "-o", "--output", "out", required=True, metavar="DIR", help="Folder of the machine file, the results, the page and commands.txt."
)
@json_option
def loop(actuator: str, record: str, healthy: tuple[str, ...], holdout: str | None, out: str, json_path: str | None, force: bool) -> None:
    """Compare ACTUATOR's model with RECORD, and do what each result advises: diagnose, add what is missing, identify.

    It ends at a verdict, or at the reason why there is none and what to record. DIR/commands.txt has the commands that were run; run one after the other they give the same.
    """
    from ema_tools.base.files import write_text
    from ema_tools.data.any_record import record_files
    from ema_tools.results.addition import Addition
    from ema_tools.results.files import LoopResult
    from ema_tools.results.identification import IdentificationResult
    from ema_tools.results.provenance import provenance
    from ema_tools.results.reading import read_result
    from ema_tools.words.advice import Advised, advice_of
    from ema_tools.words.page import write_report

    healthy = record_files(healthy, holdout)
    folder = Path(out)
    page, listed, kept = folder / "report.html", folder / "commands.txt", folder / "machine.toml"
    writable(str(page), str(listed), str(kept), json_path=json_path, force=force, inputs=(actuator, record, *healthy), made=folder)
    console = output()
    advised: tuple[str, ...] = ("ema", "compare", actuator, record, *(["--healthy", *healthy] if healthy else []))
    commands: list[tuple[str, ...]] = []
    files: list[Path] = []
    machine: str | None = None
    while True:
        file = folder / f"{len(commands) + 1}_{advised[1]}.json"
        arguments = (*_in_folder(advised, folder, len(commands) + 1, holdout), "--json", str(file), *(["--force"] if force else []))
        console.print(f"{len(commands) + 1}  {shlex.join(arguments)}", style="bold", soft_wrap=True, highlight=False)
        _run(arguments)
        found = read_result(file)
        commands.append(arguments)
        if isinstance(found, Advised):
            files.append(file)
        console.print(_sentence(found), highlight=False)
        machine = found.actuator if isinstance(found, Addition) and found.recommended else machine
        following = tuple(getattr(found, "next", ()))
        decided = isinstance(found, IdentificationResult) and found.verdict != "undecided"
        if decided or not following or following[0] in commands or len(commands) == _COMMANDS_MAX:
            break
        advised = following[0]
    verdict = found.verdict if isinstance(found, IdentificationResult) else "undecided"
    write_report(files, page, command_line(), force)
    write_text(listed, "".join(f"{shlex.join(command)}\n" for command in commands), force)
    advice = advice_of(found) if not decided and isinstance(found, Advised) else None
    if machine is not None:
        shutil.copyfile(machine, kept)
    result = LoopResult(
        verdict=verdict,
        sentence=_sentence(found),
        reason="" if advice is None else advice.reason,
        commands=tuple(commands),
        machine=None if machine is None else str(kept),
        page=str(page),
        provenance=provenance(command_line(), actuator=actuator, record=record),
        next=following,
    )
    save(json_path, result, force)
    console.print()
    console.print(f"Verdict after {len(commands)} commands: {verdict}.{f' {result.reason}.' if result.reason else ''}", highlight=False)
    if advice is not None and advice.arguments:
        console.print(advice.printed, highlight=False, soft_wrap=True)
    console.print(", ".join(f"{name} written" for name in (result.machine, str(page), str(listed)) if name), highlight=False)


def _in_folder(arguments: Sequence[str], folder: Path, count: int, holdout: str | None) -> tuple[str, ...]:
    """The advised command with the files that it writes in `folder`, and with the validation record where it takes one."""
    words = list(arguments)
    for option, stem in _WRITES.items():
        if option in words:
            place = words.index(option) + 1
            words[place] = str(folder / f"{count}_{stem}{Path(words[place]).suffix}")
    if holdout and words[1] in ("diagnose", "add") and "--holdout" not in words:
        words += ["--holdout", holdout]
    return tuple(words)


def _run(arguments: Sequence[str]) -> None:
    """Runs a command of this program in this process; what it prints is in its result. Raises InputError as the command does."""
    group = click.get_current_context().find_root().command
    words = list(arguments[1:])
    with contextlib.redirect_stdout(io.StringIO()):
        code = group.main(words, prog_name="ema", standalone_mode=False, obj=tuple(words))
    if code:
        raise InputError(f"{shlex.join(arguments)}: ended with exit code {code}: run it by hand to see why")


def _sentence(found: Result) -> str:
    return str(getattr(found, "sentence", ""))
