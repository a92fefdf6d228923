"""What each effect costs and how exact it is: a model run with it beside one without, and beside the reference model.

Run `python -m benchmarks.effects`. Every effect stands alone in the healthy reference actuator, at the lower end of its usual size, on the reference
chirp; the float32 module's error is that against the reference model at a hundredth of the step with located events. Times are the shortest of several
runs, all effects and none by turns, so that what slows the machine for a while slows none alone. With `--header FILE` the same sizes are written for the program that
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
from ema_tools.plant.native import library
from reference_model import simulate

Reals = NDArray[np.float64]

STEP_S = 1e-3
ROWS = 10_000
CHIRP = {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0}
GOAL_RATIO = 6.0
RUNS = 60
_PLAIN = "no effect"
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


def _seconds(changes: Mapping[str, Mapping[str, float]], command_mm: Reals) -> dict[str, float]:
    """Shortest time of a model run in seconds, by the name of its changes; all of them in turn, so that what slows the machine for a while slows none alone."""
    given = {name: reference_actuator().changed(values).arrays() for name, values in changes.items()}
    module = library(32)
    found = dict.fromkeys(given, math.inf)
    for _ in range(RUNS):
        for name, (actuator, options) in given.items():
            start_s = time.perf_counter()
            module.simulate(actuator, options, command_mm)
            found[name] = min(found[name], time.perf_counter() - start_s)
    return found


def _rms(error: Reals) -> float:
    return float(np.sqrt(np.mean(error**2)))


def measure() -> tuple[float, list[Cost]]:
    """Time of a model step without effects in ns, and what each effect costs, the dearest first."""
    command_mm = library(64).command("chirp", CHIRP, STEP_S, ROWS)
    changes = costed_changes()
    seconds = _seconds({_PLAIN: {}, **changes}, command_mm)
    plain_s = seconds.pop(_PLAIN)
    per_step = 1e9 / ROWS
    costs = []
    for effect, values in changes.items():
        truth = simulate({name.removeprefix(_SECTION): value for name, value in values.items()}, command_mm)
        run = library(32).simulate(*reference_actuator().changed(values).arrays(), command_mm)
        position_um, current_mA = (1e3 * _rms(one) for one in (run.position_mm - truth.position_mm, run.current_A - truth.current_A))
        costs.append(Cost(effect, per_step * seconds[effect], seconds[effect] / plain_s, position_um, current_mA))
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
            " * Written by python -m benchmarks.effects --header; do not edit. */",
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
