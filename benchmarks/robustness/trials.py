"""One setting: its record, the lowest point by another search, the onboard session from several starts, and what is warned of beforehand and said afterwards."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.optimum import Objective, Optimum, Parameter, optimum
from benchmarks.robustness.design import EFFECTS, FAULTS, Setting
from benchmarks.truth.plant import simulate_truth
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.records import read_record
from ema_tools.plant.native import CHANNELS, REASONS, Progress, SearchSettings, library
from ema_tools.tasks.onboard_search import search_warnings
from reference_model.commands import chirp, times_s

IDENTIFIED = ("screw.csj_Nm", "screw.blk_mm")
# What counts as at the lowest point: no farther than this of the healthy values, or by cost no more above it than one standard error of this sensor adds.
CLOSE = 1e-3
NOISE_MM = 0.005
_CELLS = 16
_ROWS = 10_000
_RECORDINGS = Path(__file__).resolve().parents[2] / "recordings"
# What the session says afterwards of a search that ended elsewhere.
_SAID = tuple(REASONS[bit] for bit in (2, 4, 8))


@lru_cache(maxsize=32)
def _truth(effect: str, fault: str) -> tuple[Reals, Reals]:
    """Command and rod position [rows] of the truth plant; without an effect the shipped recordings are that."""
    if effect == "none":
        record = read_record(_RECORDINGS / ("healthy.csv" if fault == "healthy" else f"case_{fault.lower()}.csv"))
        return record.command_mm, record.recorded("position_mm")
    csj, blk = FAULTS[fault]
    made = simulate_truth({"screw.csj_Nm": csj, "screw.blk_mm": blk, **EFFECTS[effect]}, chirp(times_s(_ROWS)))
    return made.command_mm, made.position_mm


@lru_cache(maxsize=8)
def _problem(effect: str, fault: str, noise_mm: float, number: int, upper: tuple[float, float]) -> tuple[Objective, Optimum]:
    """The record with its noise, and the lowest point inside the bounds."""
    command, position = _truth(effect, fault)
    noise = noise_mm * np.random.default_rng(number).standard_normal(position.size)
    channels = np.full((position.size, len(CHANNELS)), np.nan)
    channels[:, 0] = position + noise
    actuator = reference_actuator()
    parameters = (
        Parameter("CSJ", ("screw.csj_Nm",), actuator["search.csj_lower_Nm"], upper[0], actuator["screw.csj_Nm"], actuator["screw.csj_Nm"]),
        Parameter("BLK", ("screw.blk_mm",), actuator["search.blk_lower_mm"], upper[1], actuator["screw.blk_mm"], actuator["screw.blk_mm"]),
    )
    objective = Objective(actuator, parameters, command, channels)
    return objective, optimum(objective, [objective.healthy], _CELLS)


def actuator_of(setting: Setting) -> Actuator:
    """The actuator with these settings, whose sensor is known to be as noisy as it is."""
    return reference_actuator().changed({**setting.changes, "verdict.position_noise_mm": max(NOISE_MM, setting.noise_mm)})


def warnings_of(setting: Setting) -> list[str]:
    """What the module warns of beforehand, which hangs on the settings alone; its start is the healthy one, as onboard."""
    return list(search_warnings(actuator_of(setting)))


def _keeping(best: list[float]) -> Progress:
    """Keeps the best cost after every model run."""
    return lambda _run, _cost, yet, _tried: best.append(yet)


def perform(setting: Setting) -> dict[str, Any]:
    """The row of one setting."""
    upper = (setting.csj_upper_Nm, setting.blk_upper_mm)
    objective, lowest = _problem(setting.effect, setting.fault, setting.noise_mm, setting.number, upper)
    values, options = actuator_of(setting).arrays()
    period_s = reference_actuator()["timing.step_s"]
    level = max(NOISE_MM, setting.noise_mm) ** 2 * period_s + lowest.rounding
    rng = np.random.default_rng([setting.seed, setting.number])
    first = tuple(objective.inside(np.array(setting.start)))
    search = SearchSettings(IDENTIFIED, tuple(objective.lower), upper, (5.0, 10.0), start=first)
    searches = []
    for place in range(setting.searches):
        start = first if place == 0 else tuple(objective.inside(rng.random(2)))
        best: list[float] = []
        answer = library(32).identify(
            values,
            options,
            objective.command_mm,
            objective.channels,
            replace(search, start=start, seed=setting.seed + place),
            _keeping(best),
        )
        off = (np.array([one.estimate for one in answer.identified]) - lowest.theta) / objective.scale
        above = answer.objective_after - lowest.cost
        there = np.flatnonzero(np.array(best) - lowest.cost <= level)
        searches.append(
            {
                "reached": bool(np.all(np.abs(off) <= CLOSE) or above <= level),
                "off_percent": (100.0 * off).tolist(),
                "above": above,
                "evaluations": answer.evaluations,
                "runs": int(there[0]) + 1 if there.size else None,
                "outcome": answer.outcome,
                "verdict": answer.verdict,
                "said": any(text in answer.reasons for text in _SAID),
            }
        )
    return {
        "key": setting.key,
        **vars(setting),
        "optimum": lowest.theta.tolist(),
        "cost": lowest.cost,
        "rounding": lowest.rounding,
        "at_bound": lowest.at_bound(objective),
        "found": searches,
    }
