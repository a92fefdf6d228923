"""`python -m benchmarks.robustness -o DIR` searches with every setting of the designs; interrupted, the same call goes on."""

from __future__ import annotations

import time
from pathlib import Path

import click

from benchmarks.hidden import running
from benchmarks.options import folder_option, workers_option
from benchmarks.robustness.design import EFFECTS, drawn, one_at_a_time
from benchmarks.robustness.document import written
from benchmarks.robustness.trials import perform, warnings_of
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import run_command


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--settings", "count", type=click.IntRange(1), default=512, show_default=True, help="Settings of each of the two designs.")
@click.option("--records", type=click.IntRange(0), default=24, show_default=True, help="Records on which the shipped settings are moved.")
@click.option("--effects", help=f"Effects that the model lacks, of {', '.join(EFFECTS)}; comma between. All unless told.")
@workers_option
@folder_option("robustness")
@click.option("--document", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables there as Markdown, overwritten.")
def main(count: int, records: int, effects: str | None, workers: int | None, folder: Path, document: Path | None) -> None:
    """Searches with settings of all kinds and reports which reach the lowest point."""
    begun = time.monotonic()
    chosen = tuple(EFFECTS) if effects is None else tuple(name.strip() for name in effects.split(","))
    for name in chosen:
        if name not in EFFECTS:
            raise click.UsageError(f"effect {name}: not known: use some of {', '.join(EFFECTS)}")
    settings = [*drawn("sensible", count, 4, chosen), *drawn("any", count, 2, chosen), *one_at_a_time(records, 2, chosen)]
    rows = running.run(settings, folder, cores() if workers is None else workers, perform, remember=False)
    # not kept with the searches: rules can be changed without searching again
    warned = {setting.key: warnings_of(setting) for setting in settings}
    rows = [{**row, "warnings": warned[row["key"]]} for row in rows]
    text = written(rows, "python -m benchmarks.robustness -o DIR --document docs/ROBUSTNESS.md")
    running.told(text, "## Goals", f"{len(rows)} settings", begun, document)


if __name__ == "__main__":
    run_command(main)
