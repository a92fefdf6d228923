"""Records of the truth plant for quick tests, none of which compiles the plant: one file each in `records`, whose hashes stand in its `manifest.json`.

In `tools`, `PYTHONPATH=.:..:tests ../build/venv/bin/python -m stored_records` writes them anew.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.data.records import Record

FOLDER = Path(__file__).resolve().parent / "records"
MANIFEST = FOLDER / "manifest.json"
HOT = {"winding_heating.rise_degC": 40.0}


def _worn_in_eight() -> dict[str, Reals]:
    """Worn and out of tune in eight values, without noise: every column of a Recording."""
    from benchmarks.searches import problems
    from benchmarks.truth.plant import simulate_truth
    from reference_model.commands import chirp, times_s

    return asdict(simulate_truth(problems.TRUTH[8], chirp(times_s(problems.ROWS))))


def _day(changes: dict[str, float], command: str, seed: int) -> dict[str, Reals]:
    """A day of the second unit, which has Coulomb friction, with changes: what its sensors show."""
    from benchmarks.hidden.machines import machine, measured

    run = measured(machine(2), changes, command, seed)
    return {name: getattr(run, name) for name in ("command_mm", "position_mm", "motor_position_mm", "current_A", "voltage_V")}


MADE: dict[str, Callable[[], dict[str, Reals]]] = {
    "worn_in_eight": _worn_in_eight,
    **{f"healthy_{seed}": partial(_day, {}, "chirp", seed) for seed in range(700, 706)},
    "hot_801": partial(_day, HOT, "chirp", 801),
    "worn_780": partial(_day, {"screw.csj_Nm": 0.2}, "chirp", 780),
    "hot_802": partial(_day, HOT, "multisine", 802),
}


def columns_of(name: str) -> dict[str, Reals]:
    """The columns of one of MADE, as its file has them."""
    with np.load(FOLDER / f"{name}.npz") as file:
        return dict(file)


def worn_in_eight() -> Recording:
    return Recording(**columns_of("worn_in_eight"))


def day(name: str) -> Record:
    """A day of the unit, at 1 kHz."""
    return Record(1e-3, **columns_of(name), file=f"{name}.csv")


def digests() -> dict[str, str]:
    """SHA-256 of every file."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(FOLDER.glob("*.npz"))}


def _write() -> None:
    FOLDER.mkdir(exist_ok=True)
    for name, make in MADE.items():
        np.savez_compressed(FOLDER / f"{name}.npz", **make())
    MANIFEST.write_text(json.dumps(digests(), indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _write()
