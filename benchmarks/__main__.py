"""Runs the accuracy trials and writes the document that holds their figures: `python -m benchmarks -o docs/RESULTS.md`."""

from __future__ import annotations

import sys
from pathlib import Path

import click
import numpy as np

from benchmarks import accuracy
from benchmarks.document import missed, written
from benchmarks.speed import measure
from ema_tools.base.files import write_text
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.cases import CASES
from ema_tools.words.terminal.console import complain, progress, run_command


@click.command()
@click.option("--seeds", default=100, show_default=True, type=click.IntRange(1), help="Searches per case and start without noise.")
@click.option("--noise-seeds", default=50, show_default=True, type=click.IntRange(2), help="Noisy records per case.")
@click.option(
    "--recordings", default="recordings", show_default=True, type=click.Path(path_type=Path), help="Folder of the shipped recordings."
)
@click.option("--speed", type=click.Path(path_type=Path), help="Benchmark program of the C module; its figures are added.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Document to write, overwritten; else the terminal.")
def run(seeds: int, noise_seeds: int, recordings: Path, speed: Path | None, output: Path | None) -> None:
    """Accuracy of the onboard identification on cases A, B and C."""
    actuator = reference_actuator()
    records = accuracy.truth_records(recordings)
    chirp_mm = records["A"].command_mm
    total = len(CASES) * (5 * seeds + seeds + noise_seeds)
    with progress("identifications", total) as bar:
        own = accuracy.own(actuator, chirp_mm, seeds, bar.update)
        truth = accuracy.truth(actuator, records, seeds, lambda done: bar.update(len(CASES) * 5 * seeds + done))
        noise = accuracy.noise(actuator, records, noise_seeds, lambda done: bar.update(len(CASES) * 6 * seeds + done))
    bounds = [accuracy.cramer_rao_percent(actuator, case, chirp_mm) for case in CASES]
    text = written(own, truth, noise, bounds, seeds, noise_seeds, measure(speed) if speed else None)
    if output:
        write_text(output, text, force=True)
    else:
        click.echo(text, nl=False)
    problems = missed(own, truth, noise, bounds)
    for problem in problems:
        complain(problem)
    if problems:
        sys.exit(1)


if __name__ == "__main__":
    np.seterr(all="raise")
    run_command(run)
