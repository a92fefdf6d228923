"""How exactly the onboard module finds CSJ and BLK: cases A, B, C from its own records, from the truth plant's, and under sensor noise.

Three trials, each with the float32 build as onboard:

- own: records that the C model itself made, noise-free; many seeds, each from the healthy values and from the four corners of the bounds;
- truth: the shipped records of the independent truth plant, noise-free; many seeds from the healthy values;
- noise: the same with white noise on the rod position; the rms error beside the Cramer-Rao bound that the model's sensitivities give.

Errors are in % of the healthy value.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.data.cases import CASES, PaperCase
from ema_tools.data.records import Record, read_record
from ema_tools.plant.native import CHANNELS, SearchSettings, library

IDENTIFIED = ("screw.csj_Nm", "screw.blk_mm")
NOISE_MM = 0.005
EVALUATION_BUDGET = 400

# What the trials must reach.
OWN_LIMIT_PERCENT = (0.01, 0.01)
TRUTH_LIMIT_PERCENT = (0.05, 0.5)
NOISE_LIMIT_RATIO = 1.2

# Two-sided 95 % of a normal error.
_WIDTH_95 = 1.96
# Central difference: small against the fault, large against rounding in float64.
_DIFFERENCE_SHARE = 1e-4

Done = Callable[[int], None]


@dataclass(frozen=True)
class SearchTrial:
    """One case of one trial. `errors_percent` and `std_percent` are [searches, 2]: CSJ, BLK in % of the healthy value."""

    letter: str
    errors_percent: Reals
    std_percent: Reals
    evaluations: Reals

    def worst_percent(self) -> Reals:
        """Largest error of CSJ and BLK, [2]."""
        return np.asarray(np.max(np.abs(self.errors_percent), axis=0))

    def rms_percent(self) -> Reals:
        """Rms error of CSJ and BLK, [2]."""
        return np.asarray(np.sqrt(np.mean(self.errors_percent**2, axis=0)))

    def covered(self) -> Reals:
        """Share of searches whose stated 95 % interval holds the truth, [2]."""
        return np.asarray(np.mean(np.abs(self.errors_percent) <= _WIDTH_95 * self.std_percent, axis=0))


@dataclass(frozen=True)
class _Job:
    case: PaperCase
    command_mm: Reals
    channels: Reals
    search: SearchSettings


def _healthy(actuator: Actuator) -> Reals:
    return np.array([actuator[name] for name in IDENTIFIED])


def faulty(actuator: Actuator, case: PaperCase) -> Actuator:
    """The actuator with the faults of `case`."""
    return actuator.changed({"screw.csj_Nm": case.csj_Nm, "screw.blk_mm": case.blk_mm})


def _run(actuator: Actuator, jobs: list[_Job], done: Done | None) -> list[SearchTrial]:
    """Every job on all cores; one trial per case, in the order of the cases."""
    values, options = actuator.arrays()
    healthy = _healthy(actuator)

    def identify(job: _Job) -> tuple[str, Reals, Reals, int]:
        found = library(32).identify(values, options, job.command_mm, job.channels, job.search)
        truth = np.array([job.case.csj_Nm, job.case.blk_mm])
        estimate = np.array([part.estimate for part in found.identified])
        std = np.array([part.std for part in found.identified])
        return job.case.letter, 100.0 * (estimate - truth) / healthy, 100.0 * std / healthy, found.evaluations

    outcomes = each(identify, jobs, done)
    trials = []
    for letter in dict.fromkeys(job.case.letter for job in jobs):
        own = [outcome for outcome in outcomes if outcome[0] == letter]
        trials.append(
            SearchTrial(letter, np.array([o[1] for o in own]), np.array([o[2] for o in own]), np.array([float(o[3]) for o in own]))
        )
    return trials


def own(actuator: Actuator, chirp_mm: Reals, seeds: int, done: Done | None = None) -> list[SearchTrial]:
    """Records of the C model itself, float32: `seeds` x (healthy start + four corners of the bounds) per case; `chirp_mm` [rows]."""
    corners = product(
        (actuator["search.csj_lower_Nm"], actuator["search.csj_upper_Nm"]),
        (actuator["search.blk_lower_mm"], actuator["search.blk_upper_mm"]),
    )
    starts: list[tuple[float, ...] | None] = [None, *corners]
    jobs = []
    for case in CASES:
        made = library(32).simulate(*faulty(actuator, case).arrays(), chirp_mm)
        channels = np.column_stack([getattr(made, name) for name in CHANNELS])
        for seed, start in product(range(1, seeds + 1), starts):
            jobs.append(_Job(case, chirp_mm, channels, SearchSettings(seed=seed, start=start, evaluation_budget=EVALUATION_BUDGET)))
    return _run(actuator, jobs, done)


def truth_records(folder: Path) -> dict[str, Record]:
    """The shipped records of the truth plant by the letter of their case."""
    return {case.letter: read_record(folder / f"case_{case.letter.lower()}.csv") for case in CASES}


def truth(actuator: Actuator, records: dict[str, Record], seeds: int, done: Done | None = None) -> list[SearchTrial]:
    """Noise-free records of the truth plant: `seeds` searches per case from the healthy values."""
    jobs = []
    for case in CASES:
        record = records[case.letter]
        for seed in range(1, seeds + 1):
            jobs.append(_Job(case, record.command_mm, record.table(), SearchSettings(seed=seed, evaluation_budget=EVALUATION_BUDGET)))
    return _run(actuator, jobs, done)


def noise(actuator: Actuator, records: dict[str, Record], seeds: int, done: Done | None = None) -> list[SearchTrial]:
    """The truth plant's records with white noise of NOISE_MM on the rod position, another in each of `seeds` searches per case."""
    jobs = []
    for case in CASES:
        for seed in range(1, seeds + 1):
            record = records[case.letter].with_noise({"position_mm": NOISE_MM}, seed)
            jobs.append(_Job(case, record.command_mm, record.table(), SearchSettings(seed=seed, evaluation_budget=EVALUATION_BUDGET)))
    return _run(actuator, jobs, done)


def cramer_rao_percent(actuator: Actuator, case: PaperCase, command_mm: Reals, share: float = _DIFFERENCE_SHARE) -> Reals:
    """Smallest standard error of CSJ and BLK that any unbiased estimate can have under NOISE_MM, [2], % of the healthy value.

    From the sensitivities of the rod position at the truth, central differences of `share` of the value with the float64 build.
    """
    at_truth = faulty(actuator, case)
    columns = []
    for name in IDENTIFIED:
        step = share * at_truth[name]
        up, down = (
            library(64).simulate(*at_truth.changed({name: at_truth[name] + sign * step}).arrays(), command_mm).position_mm
            for sign in (1.0, -1.0)
        )
        columns.append((up - down) / (2.0 * step))
    sensitivity = np.column_stack(columns)
    covariance = NOISE_MM**2 * np.linalg.inv(sensitivity.T @ sensitivity)
    return 100.0 * np.sqrt(np.diag(covariance)) / _healthy(actuator)
