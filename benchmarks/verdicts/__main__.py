"""`python -m benchmarks.verdicts --units 60 --days 5 --drawn 5000 -o DIR` asks `ema identify` about that many records; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.options import folder_option, workers_option
from benchmarks.verdicts.document import written
from benchmarks.verdicts.trials import drawn, perform, units
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--units", "count", type=click.IntRange(0), default=6, show_default=True, help="Units judged against their own healthy runs.")
@click.option("--days", type=click.IntRange(1), default=1, show_default=True, help="Sound and worn days of each.")
@click.option("--drawn", "draws", type=click.IntRange(0), default=20, show_default=True, help="Records drawn at random.")
@click.option("--first", type=click.IntRange(0), default=0, show_default=True, help="Number of the first drawn record.")
@workers_option
@folder_option("verdicts")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(count: int, days: int, draws: int, first: int, workers: int | None, folder: Path, document: Path | None) -> None:
    """Asks for verdicts on units and records that the code under test has never seen, and reports how often they are right."""
    begun = time.monotonic()
    trials = [*units("unit", count, days), *units("flight", count, days), *drawn(draws, first)]
    rows = running.run(trials, folder, cores() if workers is None else workers, perform)
    text = written(rows, f"python -m benchmarks.verdicts --units {count} --days {days} --drawn {draws} -o DIR --document docs/VERDICTS.md")
    running.told(text, "## Goals", f"{len(rows)} answers", begun, document)


if __name__ == "__main__":
    run_command(main)
