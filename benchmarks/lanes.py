"""What runs side by side save: time of a model step in them beside one of the single model, per effect, in one run.

Run `python -m benchmarks.lanes [--bits 32|64] [--runs N] [--document FILE]`. Every effect stands alone in the reference actuator as in `benchmarks.effects`; the runs differ in dry
friction, inertia and the size of the effect by a small step each, as candidates and derivatives do. Times are the shortest of several, single and many measured in turns, of the
processor's time so that neighbours on the machine count less. Spans that left the lanes are a share of all spans of the motion.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from benchmarks.effects import CHIRP, ROWS, STEP_S, costed_changes
from ema_tools.base.files import write_text
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.lanes import lanes
from ema_tools.plant.native import OUTPUTS, Simulation, library
from ema_tools.words.terminal.console import run_command

Reals = NDArray[np.float64]

GOAL_PLAIN = 4.0
GOAL_EFFECT = 3.0
REPEATS = 7
STEP = 0.002  # from one run to the next, of a value
NO_EFFECT = "none"
_HEADINGS = (
    "effect",
    "single, ns per step",
    "in lanes, ns per step",
    "times as fast",
    "left the lanes",
    "same bits",
    "meets the goal",
)


@dataclass(frozen=True)
class Saving:
    """Time of a model step of one run in ns, alone and in lanes, whether all bits are the same, and the share of spans that left the lanes."""

    effect: str
    single_ns: float
    lanes_ns: float
    same: bool
    left: float

    @property
    def ratio(self) -> float:
        """How many times as fast."""
        return self.single_ns / self.lanes_ns


def _rows(changes: Mapping[str, float], runs: int) -> tuple[Reals, NDArray[np.int32]]:
    reference = reference_actuator().values
    found = []
    options = reference_actuator().arrays()[1]
    for k in range(runs):
        moved = {name: reference[name] * (1.0 + STEP * (k + 1)) for name in ("screw.csj_Nm", "screw.inertia_kgm2")}
        size = dict(list(changes.items())[:1])
        values, options = (
            reference_actuator().changed({**moved, **changes, **{name: value * (1.0 - STEP * k) for name, value in size.items()}}).arrays()
        )
        found.append(values)
    return np.array(found), options


def _same(one: Simulation, many: object) -> bool:
    return isinstance(many, np.ndarray) and many.tobytes() == np.array([getattr(one, name) for name in OUTPUTS]).tobytes()


def measure(bits: int, runs: int) -> list[Saving]:
    """A row without effects, and one for each effect."""
    module, beside = library(bits), lanes(bits, runs)
    if beside is None:
        raise SystemExit("the project was built without ema_lanes: build it again")
    command_mm = module.command("chirp", CHIRP, STEP_S, ROWS)
    found = []
    for effect, changes in {NO_EFFECT: {}, **costed_changes()}.items():
        values, options = _rows(changes, runs)
        single_s = lanes_s = math.inf
        left = 0.0
        for _ in range(REPEATS):
            start_s = time.process_time()
            for row in values:
                # dropped at once: none of them waits for new memory
                module.simulate(row, options, command_mm)
            middle_s = time.process_time()
            with beside.simulated(values, options, command_mm, 0.0) as together:
                lanes_s = min(lanes_s, time.process_time() - middle_s)
            single_s = min(single_s, middle_s - start_s)
            left = together.left / max(together.spans, 1)
        alone = [module.simulate(row, options, command_mm) for row in values]
        same = all(_same(one, many) for one, many in zip(alone, module.simulate_many(values, options, command_mm), strict=True))
        per_step = 1e9 / (ROWS * runs)
        found.append(Saving(effect, per_step * single_s, per_step * lanes_s, same, left))
    return found


def table(savings: Sequence[Saving], title: str) -> Table:
    """What the terminal shows."""
    shown = Table(title=title)
    for heading in _HEADINGS:
        shown.add_column(heading, justify="left" if heading == "effect" else "right")
    for saving in savings:
        shown.add_row(*_cells(saving))
    return shown


def _cells(saving: Saving) -> tuple[str, ...]:
    goal = GOAL_PLAIN if saving.effect == NO_EFFECT else GOAL_EFFECT
    return (
        saving.effect,
        f"{saving.single_ns:.1f}",
        f"{saving.lanes_ns:.1f}",
        f"{saving.ratio:.2f}",
        f"{100.0 * saving.left:.2f} %",
        "yes" if saving.same else "no",
        "yes" if saving.ratio >= goal else "no",
    )


def document(of_bits: Mapping[int, Sequence[Saving]], runs: int) -> str:
    """What docs/LANES.md says, by the bits of a real number."""
    parts = [
        f"""# How many times as fast runs are side by side

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`, in the project's folder with the build's Python, on a machine with nothing else to do:

    python -m benchmarks.lanes --runs {runs} --document docs/LANES.md

{" ".join((__doc__ or "").partition(chr(10) + chr(10))[2].partition("]`. ")[2].split())}

The goal is {GOAL_PLAIN:g} times without effects and {GOAL_EFFECT:g} with any. The tools simulate in float32; in float64 half as many numbers fit a vector. How it is done: [DESIGN](DESIGN.md).
"""
    ]
    for bits, savings in of_bits.items():
        beside = lanes(bits, runs)
        assert beside is not None
        ranked = sorted(savings, key=lambda saving: (saving.effect != NO_EFFECT, -saving.ratio))
        with_effects = [saving for saving in savings if saving.effect != NO_EFFECT]
        reached = sum(saving.ratio >= GOAL_EFFECT for saving in with_effects)
        parts.append(
            f"""## float{bits}

{runs} runs at once in {beside.count} lanes of `{beside.path.name}`, one core. {reached} of {len(with_effects)} effects reach {GOAL_EFFECT:g} times.

| {" | ".join(_HEADINGS)} |
|---|{"---:|" * (len(_HEADINGS) - 1)}
"""
            + "".join(f"| {' | '.join(_cells(saving))} |\n" for saving in ranked)
        )
    return "\n".join(parts)


@click.command()
@click.option("--bits", type=click.Choice(["32", "64"]), default="32", show_default=True, help="Of a real number, on the terminal.")
@click.option("--runs", type=click.IntRange(2), default=32, show_default=True, help="Runs at once.")
@click.option(
    "--document", "file", type=click.Path(path_type=Path, dir_okay=False), help="Write the tables of both as Markdown, overwritten."
)
def main(bits: str, runs: int, file: Path | None) -> None:
    """Time runs side by side beside runs one after the other, for every effect."""
    if file is not None:
        write_text(file, document({each: measure(each, runs) for each in (32, 64)}, runs), True)
        return
    savings = measure(int(bits), runs)
    beside = lanes(int(bits), runs)
    assert beside is not None
    title = f"float{bits}, {runs} runs, {beside.path.name}, {beside.count} lanes; goal: {GOAL_PLAIN:g} times without effects, {GOAL_EFFECT:g} with"
    Console(width=150).print(table(savings, title))


if __name__ == "__main__":
    run_command(main)
