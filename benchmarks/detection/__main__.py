"""`python -m benchmarks.detection -o DIR --document docs/DETECTION.md`: verdicts against shift, and the computed thresholds against readings; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.detection.document import figure, written
from benchmarks.detection.trials import readings, wears, work
from benchmarks.hidden import running
from benchmarks.options import folder_option, workers_option
from ema_tools.base.files import write_text
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--units", type=click.IntRange(0), default=12, show_default=True, help="Units judged by the flight code.")
@click.option("--desk", type=click.IntRange(0), default=4, show_default=True, help="Of them those judged at the desk, too.")
@click.option("--days", type=click.IntRange(0), default=80, show_default=True, help="Days read for each command and fault.")
@workers_option
@folder_option("detection")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables and the figure there, overwritten.")
def main(units: int, desk: int, days: int, workers: int | None, folder: Path, document: Path | None) -> None:
    """Verdicts against the size of a fault, and thresholds as computed against what is read."""
    begun = time.monotonic()
    jobs: list[running.Job] = [*readings(days), *wears("flight", units), *wears("unit", desk)]
    rows = running.run(jobs, folder, cores() if workers is None else workers, work)
    picture = f"{document.stem.lower()}_curves.svg" if document is not None else ""
    again = f"python -m benchmarks.detection --units {units} --desk {desk} --days {days} -o DIR --document docs/DETECTION.md"
    text = written(rows, again, picture)
    running.told(text, "## ", f"{len(rows)} trials", begun, document)
    if document is not None:
        write_text(document.with_name(picture), figure(rows), force=True)


if __name__ == "__main__":
    run_command(main)
