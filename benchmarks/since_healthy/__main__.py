"""`python -m benchmarks.since_healthy --units 1 -o DIR --document docs/SINCE_HEALTHY.md` asks what has happened to machines without a known controller; interrupted, the same call
goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.options import folder_option, workers_option
from benchmarks.since_healthy.document import written
from benchmarks.since_healthy.trials import perform, plan
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--units", type=click.IntRange(1), default=1, show_default=True, help="Units of each of six kinds.")
@workers_option
@folder_option("since_healthy")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(units: int, workers: int | None, folder: Path, document: Path | None) -> None:
    """Changes one thing in machines of six kinds and counts how often their records, beside healthy ones, say which."""
    begun = time.monotonic()
    rows = running.run(plan(units), folder, cores() if workers is None else workers, perform)
    text = written(rows, f"python -m benchmarks.since_healthy --units {units} -o DIR --document docs/SINCE_HEALTHY.md")
    running.told(text, "## Goals", f"{len(rows)} answers", begun, document)


if __name__ == "__main__":
    run_command(main)
