"""Makes what the example firmware compiles in, by `ema export`: configurations, tables of signatures and a binary image.

    python3 examples/firmware/export.py --ema build/ema --output build/exported

The reference actuator has no recorded baseline, so five runs are simulated with sensor noise and run-to-run variation of static friction.
The unit of recordings/unit has recorded baseline runs. Python's standard library alone.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "actuators" / "reference.toml"
UNIT = ROOT / "recordings" / "unit"
NOISE = "position_mm=0.002,current_A=0.03"
# Static friction torque of the five baseline runs.
LEVELS_NM = (0.1375, 0.1383, 0.1377, 0.1386, 0.1379)


class ExportError(Exception):
    """A command that failed, with its message."""


def run(ema: Path, *words: object) -> None:
    """Runs one command of the tool. Raises ExportError."""
    done = subprocess.run([str(ema), *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ExportError(f"ema {words[0]} failed: {done.stderr.strip()}")


def baseline_of_the_reference(ema: Path, folder: Path) -> list[Path]:
    """Simulates the baseline runs of the reference actuator into `folder`. Raises ExportError."""

    def simulate(seed: int) -> Path:
        record = folder / f"healthy_{seed}.csv"
        options = ("--noise", NOISE, "--seed", seed, "--set", f"screw.csj_Nm={LEVELS_NM[seed - 1]}", "-o", record)
        run(ema, "simulate", REFERENCE, "--command", "chirp", *options)
        return record

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(simulate, range(1, len(LEVELS_NM) + 1)))


def export(ema: Path, work: Path, output: Path) -> None:
    """Writes the five files into `output`; the command overwrites no file, so they are made in `work`. Raises ExportError."""

    def header(actuator: Path, baseline: list[Path], prefix: str) -> Path:
        records = [word for record in baseline for word in ("--healthy", record)]
        table = work / f"{prefix}_signatures.h"
        run(ema, "export", actuator, "-o", work / f"{prefix}_actuator.h", "--signatures", table, *records)
        return table

    def unit() -> None:
        table = header(UNIT / "unit.toml", sorted(UNIT.glob("healthy_*.csv")), "ace_unit")
        run(ema, "export", REFERENCE, "--image", work / "reference.bin")
        both = ("--beside", work / "reference.bin", "--table", table)
        run(ema, "export", UNIT / "unit.toml", "--image", work / "ace_units.bin", "--name", "unit", *both)

    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(unit)
        header(REFERENCE, baseline_of_the_reference(ema, work), "ace")
        done.result()
    for made in sorted(work.glob("ace_*")):
        (output / made.name).write_bytes(made.read_bytes())


def main() -> int:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ema", type=Path, required=True, help="the tool of a build")
    parser.add_argument("--output", type=Path, required=True, help="folder for the files")
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    try:
        with tempfile.TemporaryDirectory() as work:
            export(given.ema.absolute(), Path(work), given.output)
    except (ExportError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
