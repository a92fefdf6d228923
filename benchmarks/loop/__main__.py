"""`python -m benchmarks.loop -o DIR --document docs/LOOP.md` follows the tool's advice on every machine; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.loop.document import written
from benchmarks.loop.trials import trials
from benchmarks.loop.walk import perform
from benchmarks.options import folder_option
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--sample", type=click.IntRange(1), help="So many walks, evenly from the list; all unless given.")
@click.option("--walk", "numbers", type=int, multiple=True, help="These walks alone, by number, again; their files stay in FOLDER/NUMBER.")
@click.option("--workers", type=click.IntRange(0), default=2, show_default=True, help="Processes; 0 for this one.")
@click.option("--kept", is_flag=True, help="Run nothing: take the walks that the folder holds already.")
@folder_option("loop")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(sample: int | None, numbers: tuple[int, ...], workers: int, kept: bool, folder: Path, document: Path | None) -> None:
    """Walks along the advised commands and counts how each walk ends."""
    begun = time.monotonic()
    wanted = trials(sample)
    if numbers:
        rows = []
        for trial in trials():
            if trial.number in numbers:
                place = folder / str(trial.number)
                place.mkdir(parents=True)
                rows.append(perform(trial, keep=place))
        running.told(written(rows, ""), "## By kind", f"{len(rows)} walks", begun, None)
        return
    if kept:
        there = {row["key"] for row in running.read_rows(folder)}
        wanted = [trial for trial in wanted if trial.key in there]
    rows = running.run(wanted, folder, workers, perform, remember=False)
    given = f" --sample {sample}" if sample else ""
    text = written(sorted(rows, key=lambda row: row["number"]), f"python -m benchmarks.loop{given} -o DIR --document docs/LOOP.md")
    running.told(text, "## Goals", f"{len(rows)} walks", begun, document)


if __name__ == "__main__":
    run_command(main)
