"""The settings: what is varied and how far, two designs by Sobol's sequence, and the shipped settings with one of them moved at a time.

*Sensible* is said beforehand, from what each setting means, not from what came of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import qmc

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.cases import CASES, HEALTHY_BLK_MM, HEALTHY_CSJ_NM

Design = Literal["sensible", "any", "one"]
# Truth of the record: CSJ, BLK, and the effect that the searched model lacks.
FAULTS: Mapping[str, tuple[float, float]] = {
    "healthy": (HEALTHY_CSJ_NM, HEALTHY_BLK_MM),
    **{case.letter: (case.csj_Nm, case.blk_mm) for case in CASES},
}
EFFECTS: Mapping[str, Mapping[str, float]] = {
    "none": {},
    "stribeck": {"stribeck_friction.rise": 0.2, "stribeck_friction.speed_rad_s": 10.0},
    "winding": {"motor.resistance_ohm": 0.99 * 1.3},
    "supply": {"drive.supply_V": 24.0 * 0.9},
    "gain": {"control.kp_per_m": 400.0 * 1.1},
}
RUNS_GOAL = 600
# Of Sobol's sequence. The limits of the warnings were chosen on those of seeds 5 (256 settings) and 2025 (512), which are not drawn again.
_SCRAMBLE: Mapping[str, int] = {"sensible": 2024, "any": 2026}
_NOISELESS = 0.2  # share of the records


@dataclass(frozen=True)
class Factor:
    """A setting that is varied, by equal ratios between two ends where `logarithmic`; `why` its sensible ends are these."""

    title: str
    sensible: tuple[float, float]
    all: tuple[float, float]
    why: str

    def at(self, share: float, ends: tuple[float, float]) -> float:
        """The value at a share of the way."""
        return float(ends[0] * (ends[1] / ends[0]) ** share)


# The names of the actuator's [search] table; bounds in the units of their values.
FACTORS: Mapping[str, Factor] = {
    "initial_temperature_mm2s": Factor(
        "initial temperature, mm² s",
        (1e-3, 1.0),
        (1e-12, 1e4),
        "what the smallest fault adds to the objective (5 % of CSJ: 1e-3), to what a large one does (the paper's case A: 0.66)",
    ),
    "hotter": Factor(
        "1 - cooling",
        (0.05, 0.25),
        (0.001, 0.7),
        "slow enough for 50 model runs from hot to cold, fast enough for 600",
    ),
    "function_tolerance_mm2s": Factor(
        "function tolerance, mm² s",
        (1e-14, 2.5e-10),
        (1e-16, 1e-2),
        "from where nothing is left to gain, to a hundredth of what one standard error at 5 µm of noise adds (2.5e-8)",
    ),
    "reanneal_interval": Factor("reannealing interval", (20.0, 500.0), (1.0, 2000.0), "once or some ten times in a search"),
    "evaluation_budget": Factor("evaluations", (600.0, 600.0), (20.0, 2000.0), "the goal's"),
    "csj_upper_Nm": Factor("upper bound of CSJ, Nm", (0.5, 3.0), (0.35, 10.0), "a third to twice the motor's peak torque; the paper: 1.5"),
    "blk_upper_mm": Factor(
        "upper bound of BLK, mm", (0.08, 0.5), (0.07, 5.0), "twice the healthy play, to a tenth of the lead; the paper: 0.1"
    ),
    "noise_mm": Factor("sensor noise, mm", (1e-4, 0.02), (1e-4, 0.02), "none in a fifth of the records"),
}
# One of the shipped settings moved at a time.
MOVED: Mapping[str, Sequence[float]] = {
    "shipped": (0.0,),
    "cooling": (0.7, 0.75, 0.8, 0.9, 0.93, 0.95),
    "initial_temperature_mm2s": (1e-4, 1e-3, 1.0, 10.0),
    "reanneal_interval": (10, 30, 200),
    "function_tolerance_mm2s": (1e-15, 1e-11, 1e-9),
    "evaluation_budget": (200, 600),
}
_DIMENSIONS = len(FACTORS) + 6  # and start, effect, fault, seed, whether there is noise


@dataclass(frozen=True)
class Setting:
    """One setting of the annealer on one record. `moved`: in design "one", which of the shipped settings, and to what."""

    design: Design
    number: int
    moved: str
    cooling: float
    initial_temperature_mm2s: float
    function_tolerance_mm2s: float
    reanneal_interval: int
    evaluation_budget: int
    csj_upper_Nm: float
    blk_upper_mm: float
    noise_mm: float
    effect: str
    fault: str
    start: tuple[float, float]  # of the first search, in the unit box
    seed: int
    searches: int

    @property
    def key(self) -> str:
        """By which an interrupted run is taken up again."""
        return f"{self.design}|{self.number}|{self.moved}|{self.effect}|{self.fault}|{self.searches}"

    @property
    def group(self) -> str:
        """Of the same record and bounds, or of some thirty others."""
        return f"one_{self.number}" if self.design == "one" else f"{self.design}_{self.number // 32}"

    @property
    def changes(self) -> dict[str, float]:
        """What the actuator's file would have."""
        names = ("cooling", "initial_temperature_mm2s", "function_tolerance_mm2s", "reanneal_interval", "evaluation_budget")
        bounds = ("csj_upper_Nm", "blk_upper_mm")
        return {f"search.{name}": getattr(self, name) for name in (*names, *bounds)}


def drawn(design: Literal["sensible", "any"], count: int, searches: int, effects: Sequence[str] = tuple(EFFECTS)) -> list[Setting]:
    """`count` settings of a design, each searched from that many starts with as many seeds."""
    rows = qmc.Sobol(_DIMENSIONS, seed=_SCRAMBLE[design]).random_base2(math.ceil(math.log2(max(2, count))))[:count]
    return [_setting(design, number, row, searches, effects) for number, row in enumerate(rows)]


def _setting(design: Literal["sensible", "any"], number: int, row: np.ndarray, searches: int, effects: Sequence[str]) -> Setting:
    given = {
        name: factor.at(float(share), factor.sensible if design == "sensible" else factor.all)
        for (name, factor), share in zip(FACTORS.items(), row, strict=False)
    }
    start_csj, start_blk, effect, fault, seed, noisy = (float(share) for share in row[len(FACTORS) :])
    return Setting(
        design=design,
        number=number,
        moved="",
        cooling=1.0 - given["hotter"],
        initial_temperature_mm2s=given["initial_temperature_mm2s"],
        function_tolerance_mm2s=given["function_tolerance_mm2s"],
        reanneal_interval=round(given["reanneal_interval"]),
        evaluation_budget=round(given["evaluation_budget"]),
        csj_upper_Nm=given["csj_upper_Nm"],
        blk_upper_mm=given["blk_upper_mm"],
        noise_mm=0.0 if noisy < _NOISELESS else given["noise_mm"],
        effect=effects[int(effect * len(effects))],
        fault=tuple(FAULTS)[int(fault * len(FAULTS))],
        start=(start_csj, start_blk),
        seed=1 + int(seed * 1_000_000),
        searches=searches,
    )


def one_at_a_time(count: int, searches: int, effects: Sequence[str] = tuple(EFFECTS)) -> list[Setting]:
    """The shipped settings on `count` records, and the same records with one setting moved at a time."""
    actuator = reference_actuator()
    found = []
    for record in drawn("sensible", count, searches, effects):
        shipped = {name.partition(".")[2]: actuator[name] for name in record.changes}
        for name, values in MOVED.items():
            for value in values:
                change = {} if name == "shipped" else {name: value}
                moved = "shipped" if name == "shipped" else f"{name} = {value:g}"
                found.append(Setting(**{**vars(record), **shipped, **change, "design": "one", "moved": moved}))
    return found
