"""`ema fleet`: many recordings of many units judged, and their pages."""

from __future__ import annotations

import time
from pathlib import Path

import click

from ema_tools.cli.options import command_line, json_option, save, writable
from ema_tools.words.terminal.console import complain, output, progress

_NAMED = 5  # recordings that could not be judged, named on the terminal [layout]


@click.command(short_help="Judge many recordings of many units, and say which drift.")
@click.argument("folder")
@click.option(
    "-o", "--output", "out", required=True, metavar="DIR", help="Folder of the results and pages; what is done there is not done again."
)
@click.option("--scheduler", metavar="ADDRESS", help="A Dask cluster whose workers see the same folders; this machine's cores when absent.")
@click.option("--workers", type=click.IntRange(1), help="Processes on this machine; as many as it has cores when absent.")
@click.option(
    "--guarded",
    is_flag=True,
    help="Hold every answer against all signals and name a missing effect, as ema identify does: some seconds a recording.",
)
@click.option(
    "--limit",
    "limit_text",
    metavar="csj=PERCENT,blk=PERCENT",
    help="Shifts at which a unit is taken out of service. [default: csj=50,blk=100]",
)
@click.option(
    "--false-alarm",
    type=click.FloatRange(0.001, 0.2),
    default=0.01,
    show_default=True,
    help="Share of units without change that may be said to drift.",
)
@json_option
def fleet(
    folder: str,
    out: str,
    scheduler: str | None,
    workers: int | None,
    guarded: bool,
    limit_text: str | None,
    false_alarm: float,
    json_path: str | None,
    force: bool,
) -> None:
    """Judge the recordings in FOLDER, one folder a unit or named in FOLDER/manifest.csv, and say which units drift, since when, and when each reaches its limit.

    Results stand in DIR/results as Parquet, pages in DIR/fleet.html and DIR/units. A call that was interrupted goes on where it stopped, and new recordings are added.
    """
    from ema_tools.base.files import write_text
    from ema_tools.data.manifest import read_manifest
    from ema_tools.results.provenance import provenance
    from ema_tools.results.store import drop_superseded, read_rows
    from ema_tools.tasks.fleet import RESULTS, planned, run_fleet
    from ema_tools.tasks.history import histories, limits_of
    from ema_tools.words.answers.fleet import fleet_result
    from ema_tools.words.page.fleet import fleet_page, unit_page
    from ema_tools.words.terminal.fleet import print_fleet

    if scheduler and workers:
        raise click.UsageError("--workers is of this machine: a --scheduler has its own")
    writable(json_path=json_path, force=force)
    limits = limits_of(limit_text)
    entries = read_manifest(Path(folder))
    place = Path(out)
    batches, wanted = planned(entries, place, guarded)
    left = sum(len(batch.entries) for batch in batches)
    begun = time.monotonic()
    if batches:
        with progress("judging", left) as bar:

            def done(good: int, bad: int) -> None:
                count = good + bad
                rate = count / max(time.monotonic() - begun, 1e-9)
                bar.update(count, f"{rate:.2g} a second, {bad} not judged, {(left - count) / rate:.0f} s left")

            run_fleet(batches, scheduler, workers, done)
    known = set(wanted.values())
    drop_superseded(place / RESULTS, wanted)
    units = histories((row for row in read_rows(place / RESULTS) if row.key in known), limits, false_alarm)
    command, took = command_line(), time.monotonic() - begun
    origin = provenance(command, **({"scheduler": scheduler} if scheduler else {}))
    result = fleet_result(units, limits, false_alarm, left, took, origin)
    pages = {name: f"units/{number:05d}.html" for number, name in enumerate(sorted(one.unit for one in units), 1)}
    for told, one in zip(result.units, units, strict=True):
        write_text(place / pages[one.unit], unit_page(told, one.rows, "../fleet.html", command), True)
    write_text(place / "fleet.html", fleet_page(result, pages, command), True)
    print_fleet(output(), result)
    bad = [row for one in units for row in one.bad]
    for row in bad[:_NAMED]:
        complain(f"{row.unit}: {row.reason}")
    if len(bad) > _NAMED:
        complain(f"and {len(bad) - _NAMED} more that could not be judged: {place / 'fleet.html'} names them")
    save(json_path, result, force)
    output().print(f"{left} of {len(entries)} recordings judged now, in {took:.1f} s; {place / 'fleet.html'} written", highlight=False)
