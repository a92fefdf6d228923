"""The recordings that ship with the project: `python -m benchmarks.truth.recordings OUTDIR` writes them byte for byte.

Those of the paper's cases lie in OUTDIR; OUTDIR/story holds the runs of one unit for the demo, see `ema_tools.data.story`, and OUTDIR/unit those of another one, which the flight code
judges by its own model, see `ema_tools.data.own_unit`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from benchmarks.truth.climate import at_temperature
from benchmarks.truth.plant import Sensors, scattered, simulate_truth
from ema_tools.base.recording import Recording
from ema_tools.data import own_unit, story
from reference_model.commands import chirp, multisine, times_s

COLUMNS = ("time_s", "command_mm", "position_mm", "motor_position_mm", "current_A", "voltage_V")
ROWS = 10_000
SEED = 20_240_517


@dataclass(frozen=True)
class ShippedRecord:
    """One file: the shifted fault parameters, the sensors, and what it shows."""

    name: str
    title: str
    csj_Nm: float
    blk_mm: float
    sensors: Sensors = field(default_factory=Sensors)


NOISY = Sensors(position_noise_mm=0.005, motor_position_noise_mm=0.005, current_noise_A=0.03)
SHIPPED = (
    ShippedRecord("healthy", "healthy", 0.138, 0.033),
    ShippedRecord("case_a", "case A: moderate seizure, low backlash", 0.3, 0.04125),
    ShippedRecord("case_b", "case B: low seizure, high backlash", 0.1449, 0.066),
    ShippedRecord("case_c", "case C: one percent more of each", 0.13938, 0.03333),
    ShippedRecord("case_a_noisy", "case A with sensor noise", 0.3, 0.04125, NOISY),
)


@dataclass(frozen=True)
class Run:
    """One file of the story: the machine's values, the command [rows] in mm, and the seed of the day's scatter and of the sensors."""

    name: str
    title: str
    values: Mapping[str, float]
    command_mm: np.ndarray
    seed: int


STORY_SENSORS = Sensors(
    position_noise_mm=0.002,
    motor_position_noise_mm=0.002,
    current_noise_A=0.03,
    voltage_noise_V=0.01,
    position_resolution_mm=5e-4,
    motor_position_resolution_mm=5e-4,
    current_resolution_A=0.01,
    voltage_resolution_V=0.01,
)
# As many decimals as the sensors resolve; the command is rounded before it is run.
STORY_DECIMALS = {"time_s": 3, "command_mm": 5, "position_mm": 4, "motor_position_mm": 4, "current_A": 2, "voltage_V": 2}


# Those of the other unit err and its loop sees a little noise.
UNIT_SENSORS = replace(STORY_SENSORS, current_gain_error=-0.002, current_offset_A=0.008, feedback_noise_mm=2e-4)
# A contact that yields is integrated in shorter steps than Coulomb's: 0.1 nm of those of 2 us.
UNIT_STEP_S = 1e-5


def record(shipped: ShippedRecord) -> Recording:
    """The record of one file, from the truth plant on the reference chirp."""
    values = {"screw.csj_Nm": shipped.csj_Nm, "screw.blk_mm": shipped.blk_mm}
    return simulate_truth(values, chirp(times_s(ROWS)), sensors=shipped.sensors, seed=SEED)


def as_text(shipped: ShippedRecord, recording: Recording) -> str:
    """The file: a head that says what made it, the names, the rows with nine significant digits."""
    noise = "none"
    if shipped.sensors != Sensors():
        noise = (
            f"white, {shipped.sensors.position_noise_mm * 1e3:g} um rms on both positions,"
            f" {shipped.sensors.current_noise_A * 1e3:g} mA rms on the current, seed {SEED}"
        )
    lines = [
        f"# Reference actuator, {shipped.title}. Simulated, not measured on a machine.",
        "# Made by the truth plant (python -m benchmarks.truth.recordings): Heun's method at 10 us, Coulomb friction",
        "# with reversals found by bisection. Command: chirp 2 mm, 0.1 to 4 Hz, 10 s, held for 1 ms.",
        f"# True values: CSJ {shipped.csj_Nm:g} Nm, BLK {shipped.blk_mm:g} mm. Sensor noise: {noise}.",
        ",".join(COLUMNS),
    ]
    channels = [getattr(recording, column) for column in COLUMNS]
    # adding zero turns a negative zero into zero
    lines += [",".join(f"{value + 0.0:.9g}" for value in row) for row in zip(*channels, strict=True)]
    return "\n".join(lines) + "\n"


def story_runs() -> tuple[Run, ...]:
    """The runs of the story: the healthy ones, then today under the same command and under another one."""
    sweep = np.round(chirp(times_s(ROWS)), STORY_DECIMALS["command_mm"])
    other = np.round(multisine(times_s(ROWS), 2.0, 0.3, 8), STORY_DECIMALS["command_mm"])
    healthy = tuple(
        Run(story.healthy_name(run), f"healthy, run {run} of {story.HEALTHY_RUNS}", story.UNIT, sweep, SEED + 10 * run)
        for run in range(1, story.HEALTHY_RUNS + 1)
    )
    return (
        *healthy,
        Run(story.TODAY, "today", story.today(), sweep, SEED + 60),
        Run(story.HELD_OUT, "today, another command", story.today(), other, SEED + 70),
    )


def run_record(run: Run) -> Recording:
    """The record of one run: the machine as the day's scatter makes it, seen through the sensors."""
    values = scattered(run.values, story.SCATTER, run.seed)
    return simulate_truth(values, run.command_mm, sensors=STORY_SENSORS, seed=run.seed + 1)


def run_as_text(run: Run, recording: Recording) -> str:
    """The file. Its head does not tell what acts on the machine: that is for `ema diagnose` to find."""
    command = "chirp 2 mm, 0.1 to 4 Hz, 10 s" if run.name != story.HELD_OUT else "8 harmonics of 0.3 Hz, 2 mm, 10 s"
    lines = [
        f"# One unit of the reference actuator: {run.title}. Simulated, not measured on a machine.",
        "# Made by the truth plant (python -m benchmarks.truth.recordings): Heun's method at 10 us, Coulomb friction",
        f"# with reversals found by bisection. Command: {command}, held for 1 ms.",
        "# Sensors: 2 um rms on both positions, 30 mA on the current, 10 mV on the voltage; friction, grease and winding scatter from run to run.",
        ",".join(STORY_DECIMALS),
    ]
    return _text(lines, recording)


def _text(lines: list[str], recording: Recording) -> str:
    """A head and the rows with the decimals of the sensors."""
    channels = [getattr(recording, column) for column in STORY_DECIMALS]
    # Rounding first, then adding zero: no negative zero is left.
    rows = zip(
        *(np.round(channel, decimals) + 0.0 for channel, decimals in zip(channels, STORY_DECIMALS.values(), strict=True)), strict=True
    )
    form = ",".join(f"{{:.{decimals}f}}" for decimals in STORY_DECIMALS.values())
    return "\n".join([*lines, *(form.format(*row) for row in rows)]) + "\n"


def write_story(folder: Path) -> list[Path]:
    """Write the story's files into `folder`, which must exist; return their paths."""
    paths = []
    for run in story_runs():
        path = folder / f"{run.name}.csv"
        path.write_text(run_as_text(run, run_record(run)), encoding="utf-8", newline="\n")
        paths.append(path)
    return paths


def unit_record(day: own_unit.Day, seed: int) -> Recording:
    """The record of one day of the unit with standing errors: its temperature, the day's scatter, the unit's sensors."""
    values = at_temperature(scattered({**own_unit.UNIT, **day.changes}, own_unit.SCATTER, seed), day.warmer_degC)
    sweep = np.round(chirp(times_s(ROWS)), STORY_DECIMALS["command_mm"])
    return simulate_truth(
        values, sweep, friction="lugre", presliding_rad=own_unit.YIELDS_RAD, step_s=UNIT_STEP_S, sensors=UNIT_SENSORS, seed=seed + 1
    )


def write_unit(folder: Path) -> list[Path]:
    """Write the files of the unit with standing errors into `folder`, which must exist; return their paths."""
    paths = []
    healthy = (own_unit.healthy_day(run) for run in range(1, own_unit.HEALTHY_RUNS + 1))
    for place, day in enumerate((*healthy, *own_unit.LATER)):
        lines = [
            f"# A unit of the reference actuator with standing errors: {day.title}. Simulated, not measured on a machine.",
            "# Made by the truth plant (python -m benchmarks.truth.recordings): Heun's method at 10 us, a contact that yields.",
            "# Command: chirp 2 mm, 0.1 to 4 Hz, 10 s, held for 1 ms.",
            "# Sensors: 2 um rms on both positions, 30 mA on the current, 10 mV on the voltage; days differ by scatter and temperature.",
            ",".join(STORY_DECIMALS),
        ]
        path = folder / f"{day.name}.csv"
        path.write_text(_text(lines, unit_record(day, SEED + 100 + 10 * place)), encoding="utf-8", newline="\n")
        paths.append(path)
    return paths


def write(folder: Path) -> list[Path]:
    """Write the files of the cases into `folder`, which must exist; return their paths."""
    paths = []
    for shipped in SHIPPED:
        path = folder / f"{shipped.name}.csv"
        path.write_text(as_text(shipped, record(shipped)), encoding="utf-8", newline="\n")
        paths.append(path)
    return paths


def main() -> int:
    """Entry point; 0 when all files are written."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, metavar="OUTDIR")
    folder: Path = parser.parse_args().folder
    if not folder.is_dir():
        print(f"{folder}: not a folder: make it first", file=sys.stderr)
        return 1
    for name in ("story", "unit"):
        (folder / name).mkdir(exist_ok=True)
    for path in [*write(folder), *write_story(folder / "story"), *write_unit(folder / "unit")]:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
