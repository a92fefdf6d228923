"""`python -m ema_tools.benchmarks.fleets --units 500 --records 20 -o docs`: how fast a fleet is judged, and sixty flights to case A.

Measured is the speed and the memory, with a worker killed on the way. The sixty flights go from healthy to the paper's case A.

Records are of the reference actuator under the reference chirp with sensor noise, some of them faulty; the units share their files by links, since what is measured is the work and not the
verdicts (VERDICTS.md counts those).
"""

from __future__ import annotations

import os
import tempfile
import time
from datetime import date, timedelta
from pathlib import Path

import click
import numpy as np
import psutil

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.data.manifest import read_manifest
from ema_tools.data.records import write_record
from ema_tools.results.fleet import FleetUnitEntry
from ema_tools.results.provenance import provenance
from ema_tools.results.store import read_rows
from ema_tools.tasks.fleet import RESULTS, planned, run_fleet
from ema_tools.tasks.history import FALSE_ALARM, LIMITS, histories
from ema_tools.tasks.simulate import simulate_record
from ema_tools.words.answers.fleet import fleet_result
from ema_tools.words.page.trend import drawing
from ema_tools.words.terminal.console import run_command

_NOISE = {"position_mm": 0.002, "motor_position_mm": 0.002, "current_A": 0.03, "voltage_V": 0.01}
_HEALTHY = 3  # healthy runs of a unit
_DISTINCT = 20  # records that are simulated; the units' files are links to them
_FLIGHTS = 60
_CASE_A = {"csj": 1.17, "blk": 0.25}  # shifts of the paper's case A as the reference has it
_STYLE = (
    "<style>svg{font:11px sans-serif;background:#fff}text{fill:#555}.grid{stroke:#e4e7ea}polyline,path{fill:none;stroke:#0a6aa8;stroke-width:1.4}"
    ".dots{stroke-linecap:round;stroke-width:4}.noise{stroke:#8a6d00;stroke-dasharray:5 4}.back{stroke:#888;stroke-dasharray:4 4}"
    ".band{stroke:none;fill:#c8501e;opacity:.18}.band.after{fill:#0a6aa8}</style>"
)


def simulate(path: Path, machine: Actuator, csj: float, blk: float, seed: int, scatter: float = 0.0) -> None:
    """One record with its friction and play risen by these shares."""
    random = np.random.default_rng(seed)
    worn = machine.changed(
        {
            "screw.csj_Nm": machine["screw.csj_Nm"] * (1.0 + csj) * (1.0 + scatter * random.normal()),
            "screw.blk_mm": machine["screw.blk_mm"] * (1.0 + blk),
        }
    )
    write_record(path, simulate_record(worn, make_command("chirp", machine), 64, _NOISE, seed), (), True, 9)


def make_fleet(folder: Path, units: int, records: int) -> None:
    """A fleet by folder names."""
    machine = reference_actuator()
    pool = folder.with_name("records")
    pool.mkdir()
    for number in range(_DISTINCT):
        simulate(pool / f"{number}.csv", machine, 0.0 if number < _HEALTHY else 0.02 * number, 0.0, number)
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
    """Records judged, seconds, memory of this process after each tenth of them in MB, and workers that were killed on the way."""
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

    begun = time.perf_counter()
    count, _ = run_fleet(batches, workers=workers, done=done)
    took = time.perf_counter() - begun
    kept = [row.key for row in read_rows(out / RESULTS)]
    if sorted(kept) != sorted(wanted.values()) or count != len(entries):
        raise InputError(
            f"{len(kept)} rows of {len(entries)} records, {len(set(kept))} of them different: a record was lost, or judged twice"
        )
    return count, took, memory, killed


def flights(folder: Path) -> FleetUnitEntry:
    """Sixty flights of one unit on its way to case A, of which some are missing, judged as a fleet of one."""
    machine = reference_actuator()
    own = folder / "flights" / "case_a"
    own.mkdir(parents=True)
    machine.write(folder / "flights" / "reference.toml")
    random = np.random.default_rng(1)
    for flight in range(_FLIGHTS):
        if flight >= _HEALTHY and random.random() < 0.15:
            continue
        gone = max(0, flight - 10) / (_FLIGHTS - 11)
        healthy = "_healthy" if flight < _HEALTHY else ""
        day = date(2026, 1, 1) + timedelta(days=2 * flight)
        simulate(own / f"{day}{healthy}.csv", machine, _CASE_A["csj"] * gone**1.5, _CASE_A["blk"] * gone, flight, scatter=0.004)
    batches, _ = planned(read_manifest(folder / "flights"), folder / "judged", guarded=False)
    run_fleet(batches)
    limits = {**LIMITS, "csj": 150.0}
    units = histories(read_rows(folder / "judged" / RESULTS), limits)
    return fleet_result(units, limits, FALSE_ALARM, len(units[0].rows), 0.0, provenance("ema fleet")).units[0]


def document(found: tuple[int, float, list[float], int], workers: int, units: int, records: int, unit: FleetUnitEntry) -> str:
    """What docs/FLEET_SPEED.md says."""
    count, took, memory, killed = found
    words = "\n".join(f"- {trend.sentence}" for trend in unit.trends.values())
    return f"""# How fast a fleet is judged

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    python -m ema_tools.benchmarks.fleets --units {units} --records {records} --workers {workers} -o docs

{" ".join((__doc__ or "").partition(chr(10) + chr(10))[2].split())}

| | |
|---|---:|
| records of {units} units | {count} |
| workers | {workers}, {killed} of them killed on the way |
| lost, or judged twice | none |
| records a second and worker | {count / took / workers:.2f} |
| memory of the process that leads, after a tenth and at the end | {memory[0]:.0f} MB, {memory[-1]:.0f} MB |

## Sixty flights to case A

A unit's friction rises to the paper's case A, the faster the farther it is gone, and its play evenly, from the eleventh flight on; a few flights are missing.
The limit of CSJ is set to +150 % and not reached yet:

{words}

![CSJ over days, with the interval of the time until its limit](fleet_case_a_csj.svg)

![BLK over days](fleet_case_a_blk.svg)
"""


@click.command()
@click.option("--units", type=click.IntRange(1), default=10, show_default=True)
@click.option("--records", type=click.IntRange(4), default=20, show_default=True, help="Of each unit.")
@click.option("--workers", type=click.IntRange(2), default=2, show_default=True)
@click.option("-o", "--output", "out", type=click.Path(path_type=Path), required=True, help="Folder of the document and its pictures.")
def main(units: int, records: int, workers: int, out: Path) -> None:
    """Judge a made-up fleet, and sixty flights of a unit that wears, and write what was measured."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        make_fleet(folder / "fleet", units, records)
        found = measured(folder / "fleet", folder / "out", workers)
        unit = flights(folder)
    write_text(out / "FLEET_SPEED.md", document(found, workers, units, records, unit), True)
    for name, trend in unit.trends.items():
        svg = drawing(name, trend).replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1)
        write_text(out / f"fleet_case_a_{name}.svg", svg.replace(">", f">{_STYLE}", 1) + "\n", True)


if __name__ == "__main__":
    run_command(main)
