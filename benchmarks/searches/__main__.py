"""`python -m benchmarks.searches -o DIR` holds the onboard annealer against other searches on its own objective; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.options import folder_option, workers_option
from benchmarks.searches.document import written
from benchmarks.searches.problems import KINDS
from benchmarks.searches.trials import perform, trials
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--starts", "two", type=click.IntRange(0), default=100, show_default=True, help="Starts of each search for two values.")
@click.option("--eight", type=click.IntRange(0), default=12, show_default=True, help="Starts of each search for eight values.")
@click.option("--kinds", help=f"Of {', '.join(KINDS)}; comma between. All unless told.")
@workers_option
@folder_option("searches")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(two: int, eight: int, kinds: str | None, workers: int | None, folder: Path, document: Path | None) -> None:
    """Searches for two and for eight values by a dozen ways, and ranks them."""
    begun = time.monotonic()
    chosen = KINDS if kinds is None else tuple(name.strip() for name in kinds.split(","))
    for name in chosen:
        if name not in KINDS:
            raise click.UsageError(f"kind {name}: not known: use some of {', '.join(KINDS)}")
    rows = running.run(trials(two, eight, chosen), folder, cores() if workers is None else workers, perform, remember=False)
    text = written(rows, f"python -m benchmarks.searches --starts {two} --eight {eight} -o DIR --document docs/SEARCHES.md")
    running.told(text, "## Ranks", f"{len(rows)} searches", begun, document)


if __name__ == "__main__":
    run_command(main)
