"""`ema import`: measurements of others in this project's formats."""

from __future__ import annotations

from dataclasses import asdict

import click

from ema_tools.cli.options import command_line, json_option, save, writable
from ema_tools.words.terminal.console import output, progress


@click.group(name="import")
def import_group() -> None:
    """Bring foreign measurements into this project's formats."""


@import_group.command(name="emps")
@click.argument("file")
@click.option("-o", "--output", "folder", required=True, metavar="DIR", help="Folder for actuator.toml and record.csv.")
@json_option
def import_emps(file: str, folder: str, json_path: str | None, force: bool) -> None:
    """EMPS, a measured ball-screw axis: its FILE.mat and the published reference model."""
    from ema_tools.base.files import keep_apart
    from ema_tools.data.emps import PUBLISHED, PUBLISHED_STD, targets
    from ema_tools.data.emps import import_emps as work
    from ema_tools.results.calibration import RodModel
    from ema_tools.results.files import ImportResult
    from ema_tools.results.provenance import provenance
    from ema_tools.words.terminal import show

    keep_apart([*targets(folder), *filter(None, (json_path,))], (file,))
    writable(json_path=json_path, force=force, made=folder)
    found = work(file, folder, force)
    origin = provenance(command_line(), source=found.actuator.about["source"])
    record = found.record
    save(
        json_path,
        ImportResult("import emps", str(found.actuator_path), str(found.record_path), record.rows, record.period_s, origin),
        force,
    )
    console = output()
    show.say(
        console,
        f"{found.record_path}: {found.record.rows} rows, {found.record.rows * found.record.period_s:g} s; {found.actuator_path}: published reference model",
    )
    published = {"value": PUBLISHED, "std error": PUBLISHED_STD}
    show.force_models(console, "Published", {title: RodModel(**asdict(model)) for title, model in published.items()})
    show.say(console, f"next: ema compare {found.actuator_path} {found.record_path}")


@import_group.command(name="draft")
@click.argument("file")
@click.option("-o", "--output", "target", required=True, metavar="MAP.toml", help="The map to write, to be completed by hand.")
@json_option
def import_draft(file: str, target: str, json_path: str | None, force: bool) -> None:
    """Look at any maker's FILE and write the map of its columns, to be completed."""
    from ema_tools.results.provenance import provenance
    from ema_tools.tasks.import_table import write_draft
    from ema_tools.words.answers.importing import draft
    from ema_tools.words.terminal.importing import print_draft

    writable(target, json_path=json_path, force=force, inputs=(file,))
    found = draft(write_draft(file, target, force), file, target, provenance(command_line(), source=file))
    save(json_path, found, force)
    print_draft(output(), found)


@import_group.command(name="table")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option("--map", "map_path", required=True, metavar="MAP.toml", help="What stands in which column: the completed draft.")
@click.option("-o", "--output", "folder", required=True, metavar="DIR", help="Folder for the records and actuator.toml.")
@json_option
def import_table(files: tuple[str, ...], map_path: str, folder: str, json_path: str | None, force: bool) -> None:
    """Any maker's FILEs, patterns or folders as records, and an actuator to start from.

    CSV, TSV and other text, MATLAB .mat, Parquet, JSON, NumPy .npz.
    """
    from ema_tools.results.provenance import provenance
    from ema_tools.tasks.import_table import import_tables
    from ema_tools.words.answers.importing import tables
    from ema_tools.words.terminal.importing import print_tables

    writable(json_path=json_path, force=force, inputs=(map_path,), made=folder)
    with progress("importing", 1.0) as bar:
        found = import_tables(files, map_path, folder, force, bar.update)
    result = tables(found, provenance(command_line(), map=map_path))
    save(json_path, result, force)
    print_tables(output(), result)
