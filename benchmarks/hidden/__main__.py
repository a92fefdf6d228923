"""`python -m benchmarks.hidden --small` hides a few effects; `--full -o DIR` everything."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from benchmarks.hidden import documents, running, scoring
from benchmarks.hidden.catalogue import FAULTS, FORMS, LIBRARY, OUTSIDE, SEVERITIES
from benchmarks.hidden.trials import FULL, KINDS, TIMED, Plan, perform
from benchmarks.options import folder_option, workers_option
from ema_tools.base.files import write_json
from ema_tools.base.parallel import workers as cores
from ema_tools.words.terminal.console import output, run_command

_SMALL = Plan(
    1,
    severities=("medium",),
    effects=("winding_heating", "sensor_gain", "bus_hum"),
    kinds=("library", "outside", "healthy"),
    healthy=1,
    outside_seeds=1,
    first_machine=2,
)


def _names(text: str | None, known: tuple[str, ...], what: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(",")) if text else ()
    for name in names:
        if name not in known:
            raise click.UsageError(f"{what} {name}: not known: use some of {', '.join(known)}")
    return names


@click.command(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.option("--small", "size", flag_value="small", help="A few trials, under a minute.")
@click.option("--full", "size", flag_value="full", help="What the document shows.")
@click.option("--effects", help="Hide these only, comma between.")
@click.option("--severity", help=f"Of {', '.join(SEVERITIES)}; comma between.")
@click.option("--kinds", help=f"Of {', '.join(KINDS)}; comma between.")
@click.option("--seeds", type=click.IntRange(0), help="Machines per effect and severity.")
@click.option("--first", type=click.IntRange(1), help="Number of the first machine.")
@click.option("--repeats", type=click.IntRange(2), help="Healthy repeats.")
@click.option("--healthy", type=click.IntRange(0), help="Healthy records.")
@click.option("--strangers", type=click.IntRange(0), help="Healthy machines without repeats.")
@click.option("--pairs", type=click.IntRange(0), help="Pairs of effects.")
@click.option("--set-healthy", type=click.IntRange(0), help="Healthy records of each machine that is set otherwise.")
@click.option("--kept", is_flag=True, help="Run nothing: take the trials that the folder holds already.")
@workers_option
@folder_option("hidden")
@click.option(
    "--document",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write the tables there as Markdown, overwritten, and the pictures beside it.",
)
@click.option(
    "--than",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="An earlier document: its figures stand beside those of the goals.",
)
def main(
    size: str | None,
    effects: str | None,
    severity: str | None,
    kinds: str | None,
    seeds: int | None,
    first: int | None,
    repeats: int | None,
    healthy: int | None,
    strangers: int | None,
    pairs: int | None,
    set_healthy: int | None,
    kept: bool,
    workers: int | None,
    folder: Path,
    document: Path | None,
    than: Path | None,
) -> None:
    """Hides effects in machines that the code under test has never seen and reports what it names."""
    begun = time.monotonic()
    plan = _SMALL if size == "small" else FULL
    given: dict[str, Any] = {
        "effects": _names(effects, (*LIBRARY, *FAULTS, *OUTSIDE, *FORMS), "effect"),
        "severities": _names(severity, tuple(SEVERITIES), "severity"),
        "kinds": _names(kinds, KINDS, "kind"),
        "seeds": seeds,
        "first_machine": first,
        "repeats": repeats,
        "healthy": healthy,
        "strangers": strangers,
        "pairs": pairs,
        "set_healthy": set_healthy,
    }
    plan = replace(plan, **{name: value for name, value in given.items() if value not in (None, ())})
    trials = plan.trials()
    if kept:
        there = {row["key"] for row in running.read_rows(folder)}
        trials = [trial for trial in trials if trial.key in there]
    timed = [trial for trial in trials if trial.kind in TIMED]
    rows = running.run([trial for trial in trials if trial.kind not in TIMED], folder, cores() if workers is None else workers, perform)
    rows += running.run(timed, folder, 0, perform, remember=False)
    write_json(folder / "trials.json", {"trials": rows}, force=True)
    console = output()
    scoring.show(console, rows)
    console.print(f"{len(rows)} trials, {running.elapsed(begun)}")
    if document is not None:
        for path in documents.write(rows, document, documents.earlier_in(than) if than else documents.Earlier()):
            console.print(str(path))


if __name__ == "__main__":
    run_command(main)
