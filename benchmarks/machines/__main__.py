"""`python -m benchmarks.machines --units 3 --healthy 9 -o DIR --document docs/MACHINES.md` asks about machines without a known controller; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.machines.document import written
from benchmarks.machines.observer import observed
from benchmarks.machines.trials import perform, plan
from benchmarks.options import folder_option, workers_option
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--units", type=click.IntRange(1), default=1, show_default=True, help="Units of each of six kinds.")
@click.option(
    "--healthy", type=click.IntRange(0), default=0, help="Units of each kind that are asked without an effect, where more than those."
)
@workers_option
@folder_option("machines")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(units: int, healthy: int, workers: int | None, folder: Path, document: Path | None) -> None:
    """Hides effects in machines of six kinds and counts which of them are named from motion and drive alone."""
    begun = time.monotonic()
    count = cores() if workers is None else workers
    trials = plan(units, healthy)
    rows = running.run(trials, folder, count, perform)
    best = running.run(trials, folder / "observer", count, observed)
    called = f"--units {units}" + (f" --healthy {healthy}" if healthy > units else "")
    text = written(rows, best, f"python -m benchmarks.machines {called} -o DIR --document docs/MACHINES.md")
    running.told(text, "## Goals", f"{len(rows)} answers", begun, document)


if __name__ == "__main__":
    run_command(main)
