"""The recordings that ship with the project: `python -m ema_tools.truth.recordings OUTDIR` writes them byte for byte."""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, field
from pathlib import Path

from ema_tools.reference.commands import chirp, times_s
from ema_tools.reference.recording import Recording
from ema_tools.truth.plant import Sensors, simulate_truth

COLUMNS = ("time_s", "command_mm", "position_mm", "motor_position_mm", "current_A", "voltage_V")
ROWS = 10_000
SEED = 20_240_517


@dataclass(frozen=True)
class Shipped:
    """One file: the shifted fault parameters, the sensors, and what it shows."""

    name: str
    title: str
    csj_Nm: float
    blk_mm: float
    sensors: Sensors = field(default_factory=Sensors)


NOISY = Sensors(position_noise_mm=0.005, motor_position_noise_mm=0.005, current_noise_A=0.03)
SHIPPED = (
    Shipped("healthy", "healthy", 0.138, 0.033),
    Shipped("case_a", "case A: moderate seizure, low backlash", 0.3, 0.04125),
    Shipped("case_b", "case B: low seizure, high backlash", 0.1449, 0.066),
    Shipped("case_c", "case C: one percent more of each", 0.13938, 0.03333),
    Shipped("case_a_noisy", "case A with sensor noise", 0.3, 0.04125, NOISY),
)


def record(shipped: Shipped) -> Recording:
    """The record of one file, from the truth plant on the reference chirp."""
    values = {"screw.csj_Nm": shipped.csj_Nm, "screw.blk_mm": shipped.blk_mm}
    return simulate_truth(values, chirp(times_s(ROWS)), sensors=shipped.sensors, seed=SEED)


def as_text(shipped: Shipped, recording: Recording) -> str:
    """The file: a head that says what made it, the names, the rows with nine significant digits."""
    noise = "none"
    if shipped.sensors != Sensors():
        noise = (
            f"white, {shipped.sensors.position_noise_mm * 1e3:g} um rms on both positions,"
            f" {shipped.sensors.current_noise_A * 1e3:g} mA rms on the current, seed {SEED}"
        )
    lines = [
        f"# Reference actuator, {shipped.title}. Simulated, not measured on a machine.",
        "# Made by the truth plant (python -m ema_tools.truth.recordings): Heun's method at 10 us, Coulomb friction",
        "# with reversals found by bisection. Command: chirp 2 mm, 0.1 to 4 Hz, 10 s, held for 1 ms.",
        f"# True values: CSJ {shipped.csj_Nm:g} Nm, BLK {shipped.blk_mm:g} mm. Sensor noise: {noise}.",
        ",".join(COLUMNS),
    ]
    channels = [getattr(recording, column) for column in COLUMNS]
    # adding zero turns a negative zero into zero
    lines += [",".join(f"{value + 0.0:.9g}" for value in row) for row in zip(*channels, strict=True)]
    return "\n".join(lines) + "\n"


def write(folder: Path) -> list[Path]:
    """Write every file into `folder`, which must exist; return their paths."""
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
    for path in write(folder):
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
