"""What each effect costs and how exact it is: a model run with it beside one without, and beside the reference model.

Run `python -m ema_tools.benchmarks.effects`. Every effect stands alone in the healthy reference actuator, at the lower end of its usual size, on the reference
chirp; the float32 module's error is that against the reference model at a hundredth of the step with located events. Times are the shortest of several runs, and
runs without an effect are measured in between, so that the ratio is one of the same minutes. With `--header FILE` the same sizes are written for the program that
counts instructions on the target instead.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from ema_tools.data.actuator import reference_actuator
from ema_tools.design.typical import typical_change
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import Simulation, library
from ema_tools.reference import simulate

Reals = NDArray[np.float64]

STEP_S = 1e-3
ROWS = 10_000
CHIRP = {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0}
GOAL_RATIO = 6.0
RUNS = 12
_PEAK_A = 7.4  # of the healthy run
_SECTION = "effects."
# Tables have no usual size: a wave over the range of its axis, of the size of the effect that acts there too.
_TABLES: Mapping[str, tuple[float, float, float]] = {
    "learned_torque": (1.0, 2.5, 0.02),
    "learned_friction": (0.0, 250.0, 0.02),
    "learned_voltage": (4.0, 7.5, 0.1),
    "learned_reading": (1.0, 2.5, 0.002),
}


@dataclass(frozen=True)
class Cost:
    """Time of a model step, over that without effects, and the rms error of rod position and current."""

    effect: str
    step_ns: float
    ratio: float
    position_um: float
    current_mA: float


def _table(effect: str) -> dict[str, float]:
    axis, range_, size = _TABLES[effect]
    start = f"{_SECTION}{effect}."
    nodes = {f"{start}node_{k:02d}": size * math.sin(0.7 * k) for k in range(16)}
    return {f"{start}gain": 1.0, f"{start}axis": axis, f"{start}first": -range_, f"{start}last": range_, **nodes}


def costed_changes() -> dict[str, dict[str, float]]:
    """Per effect the changed values of the reference actuator under which its cost is measured; an effect whose usual size nobody has told is left out."""
    reference = reference_actuator()
    found = {}
    for effect in load_definitions().effects:
        values = typical_change(reference, effect.name, _PEAK_A)
        if values is not None:
            found[effect.name] = values
        elif effect.name in _TABLES:
            found[effect.name] = _table(effect.name)
    return found


def _run(values: Mapping[str, float], command_mm: Reals, runs: int) -> tuple[float, Simulation]:
    """Shortest time of a model run in seconds, and the run."""
    actuator, options = reference_actuator().changed(values).arrays()
    module = library(32)
    shortest_s = math.inf
    for _ in range(runs):
        start_s = time.perf_counter()
        run = module.simulate(actuator, options, command_mm)
        shortest_s = min(shortest_s, time.perf_counter() - start_s)
    return shortest_s, run


def _rms(error: Reals) -> float:
    return float(np.sqrt(np.mean(error**2)))


def measure() -> tuple[float, list[Cost]]:
    """Time of a model step without effects in ns, and what each effect costs, the dearest first."""
    command_mm = library(64).command("chirp", CHIRP, STEP_S, ROWS)
    plain_s, _ = _run({}, command_mm, RUNS)
    found: list[tuple[str, float, float, float]] = []
    for effect, values in costed_changes().items():
        truth = simulate({name.removeprefix(_SECTION): value for name, value in values.items()}, command_mm)
        with_s, run = _run(values, command_mm, RUNS)
        plain_s = min(plain_s, _run({}, command_mm, RUNS)[0])
        found.append((effect, with_s, 1e3 * _rms(run.position_mm - truth.position_mm), 1e3 * _rms(run.current_A - truth.current_A)))
    per_step = 1e9 / ROWS
    costs = [Cost(name, per_step * with_s, with_s / plain_s, position_um, current_mA) for name, with_s, position_um, current_mA in found]
    return per_step * plain_s, sorted(costs, key=lambda cost: -cost.ratio)


def header() -> str:
    """The values under which every effect is counted on the target, one row each: effect, its value, size."""
    rows = [
        f"EMA_COSTED({effect}, {name.rpartition('.')[2]}, EMA_R({float(value)!r}))"
        for effect, values in costed_changes().items()
        for name, value in values.items()
    ]
    return "\n".join(
        [
            "/* Every effect at the lower end of its usual size: EMA_COSTED(effect, value, size), rows of one effect side by side.",
            " * Written by python -m ema_tools.benchmarks.effects --header; do not edit. */",
            *rows,
            "#undef EMA_COSTED",
            "",
        ]
    )


@click.command()
@click.option(
    "--header", "file", type=click.Path(path_type=Path, dir_okay=False), help="Write the sizes for the target here, and measure nothing."
)
def main(file: Path | None) -> None:
    """Print what each effect costs and how exact it is."""
    if file is not None:
        file.write_text(header(), encoding="utf-8")
        return
    plain_ns, costs = measure()
    table = Table(title=f"float32, {plain_ns:.1f} ns per model step without effects; goal: at most {GOAL_RATIO:g} times as long")
    for heading in ("effect", "ns per step", "times", "rod position, um rms", "current, mA rms", "meets the goal"):
        table.add_column(heading, justify="left" if heading == "effect" else "right")
    for cost in costs:
        meets = "yes" if cost.ratio <= GOAL_RATIO else "no"
        table.add_row(cost.effect, f"{cost.step_ns:.0f}", f"{cost.ratio:.2f}", f"{cost.position_um:.5f}", f"{cost.current_mA:.4f}", meets)
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
