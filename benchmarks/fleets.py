"""`python -m benchmarks.fleets --units 500 --records 20 -o docs`: how fast a fleet is judged.

Measured is the speed and the memory, with a worker killed on the way.

Records are of the reference actuator under the reference chirp with sensor noise, some of them faulty; the units share their files by links, since what is measured is the work and not the
verdicts (VERDICTS.md counts those).
"""

from __future__ import annotations

import os
import resource
import tempfile
from datetime import date, timedelta
from pathlib import Path

import click
import psutil

from benchmarks.flights import simulate
from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.manifest import read_manifest
from ema_tools.results.store import read_rows
from ema_tools.tasks.fleet import RESULTS, planned, run_fleet
from ema_tools.words.terminal.console import run_command

_HEALTHY = 3  # healthy runs of a unit
_DISTINCT = 20  # records that are simulated; the units' files are links to them


def make_fleet(folder: Path, units: int, records: int) -> None:
    """A fleet by folder names."""
    machine = reference_actuator()
    pool = folder.with_name("records")
    pool.mkdir()
    for number in range(_DISTINCT):
        simulate(pool / f"{number}.csv", machine, 0.0 if number < _HEALTHY else 2.0 * number, 0.0, number)
    folder.mkdir()
    machine.write(folder / "reference.toml")
    for unit in range(units):
        own = folder / f"unit_{unit:04d}"
        own.mkdir()
        for number in range(records):
            day = date(2026, 1, 1) + timedelta(days=7 * number)
            healthy = "_healthy" if number < _HEALTHY else ""
            os.link(pool / f"{number % _DISTINCT}.csv", own / f"{day}{healthy}.csv")


def measured(folder: Path, out: Path, workers: int) -> tuple[int, float, list[float], int]:
    """Records judged, seconds of processor that the workers took, memory of this process after each tenth of them in MB, and workers that were killed on the way."""
    entries = read_manifest(folder)
    batches, wanted = planned(entries, out, guarded=False)
    memory: list[float] = []
    own = psutil.Process()
    killed = 0

    def done(good: int, bad: int) -> None:
        nonlocal killed
        while len(memory) < 10 and good + bad >= len(entries) * (len(memory) + 1) / 10.0:
            memory.append(own.memory_info().rss / 1e6)
        if not killed and good + bad > len(entries) / 3:
            at_work = [one for one in own.children(recursive=True) if "spawn_main" in " ".join(one.cmdline())]
            at_work[-1].kill()
            killed = 1

    # of the processor and not of the clock, so that other work on the machine changes nothing; the workers' start is in it, and the killed one's lost batch
    begun = _processor_s()
    count, _ = run_fleet(batches, workers=workers, done=done)
    took = _processor_s() - begun
    kept = [row.key for row in read_rows(out / RESULTS)]
    if sorted(kept) != sorted(wanted.values()) or count != len(entries):
        raise InputError(
            f"{len(kept)} rows of {len(entries)} records, {len(set(kept))} of them different: a record was lost, or judged twice"
        )
    return count, took, memory, killed


def _processor_s() -> float:
    """Seconds of processor of all workers that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def document(found: tuple[int, float, list[float], int], workers: int, units: int, records: int) -> str:
    """What docs/FLEET_SPEED.md says."""
    count, took, memory, killed = found
    return f"""# How fast a fleet is judged

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    python -m benchmarks.fleets --units {units} --records {records} --workers {workers} -o docs

{" ".join((__doc__ or "").partition(chr(10) + chr(10))[2].split())}

| | |
|---|---:|
| records of {units} units | {count} |
| workers | {workers}, {killed} of them killed on the way |
| lost, or judged twice | none |
| records a second of one core | {count / took:.2f} |
| memory of the process that leads, after a tenth and at the end | {memory[0]:.0f} MB, {memory[-1]:.0f} MB |
"""


@click.command()
@click.option("--units", type=click.IntRange(1), default=10, show_default=True)
@click.option("--records", type=click.IntRange(4), default=20, show_default=True, help="Of each unit.")
@click.option("--workers", type=click.IntRange(2), default=2, show_default=True)
@click.option("-o", "--output", "out", type=click.Path(path_type=Path), required=True, help="Folder of the document.")
def main(units: int, records: int, workers: int, out: Path) -> None:
    """Judge a made-up fleet, and write what was measured."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        make_fleet(folder / "fleet", units, records)
        found = measured(folder / "fleet", folder / "out", workers)
    write_text(out / "FLEET_SPEED.md", document(found, workers, units, records), True)


if __name__ == "__main__":
    run_command(main)
