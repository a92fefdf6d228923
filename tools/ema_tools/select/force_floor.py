"""What no model of a machine can be better than, estimated from records that do not repeat themselves.

Two parts, both of what a fit leaves of the torque: the noise that neighbouring samples do not share; and how far records, or stretches of the one record, are from each other where the
machine does the same, which is to move as fast, in the same direction, gaining speed or losing it. The second takes for chance whatever depends on something else, such as the place: the
estimate is rather too high than too low. So it is at most what a mean over speed, or place, of the other records leaves: what that foretells is no chance, whatever it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.select.balance_bench import Bench, Fitted

_SPEEDS = 8  # ranges of speed, with as many samples in each [judgement]
_STRETCHES = 8  # of one record, that stand for records [judgement]
_SAMPLES = 5  # of a record in a range, fewer say nothing of its mean there [judgement]
_COVERED = 0.5  # share of the samples that must be where two records or more can be compared [judgement]
# Second differences of noise that is white up to 0.8 of the samples' highest frequency, where the decimation ends, over its variance [precision]
_SECOND_DIFFERENCES = 3.75
_CELLS = 40  # of as many samples each, over speed or place, whose means foretell those of another record [judgement]
_MEDIAN_OF_SQUARE = 0.455  # of a normal variable of unit variance [chance]


@dataclass(frozen=True)
class EstimatedFloor:
    """Relative error in % below which no model will come. `compared`: whether records could be compared with each other; else it is of noise alone, and rather too low.

    `foretold`: share of the squared residual that means over speed or place foretell of one record from the others, which is missing model whatever the floor.
    """

    percent: float = math.nan
    compared: bool = False
    foretold: float = 0.0


def estimated_floor(bench: Bench, fit: Fitted) -> EstimatedFloor:
    """The estimate by what a fit leaves, at most what it leaves."""
    rows = bench.fitted
    left, drive = (float(np.mean(values[rows] ** 2)) for values in (fit.residual, fit.samples.drive))
    if not drive > 0.0:
        return EstimatedFloor()
    between = _between(bench, fit)
    compared = math.isfinite(between)
    foretold = _foretold(bench, fit)
    square = min(_noise(bench, fit) + (between if compared else 0.0), (1.0 - foretold) * left)
    return EstimatedFloor(100.0 * math.sqrt(square / drive), compared, foretold)


def _noise(bench: Bench, fit: Fitted) -> float:
    """Variance of what neighbouring samples do not share; by the median, since an edge of the motion is no noise."""
    found, count = 0.0, 0
    for number in np.unique(bench.of_record):
        here = bench.of_record == number
        left, use = fit.residual[here], bench.fitted[here]
        second = (left[:-2] - 2.0 * left[1:-1] + left[2:])[use[:-2] & use[1:-1] & use[2:]]
        if second.size:
            found += second.size * float(np.median(second**2)) / _MEDIAN_OF_SQUARE / _SECOND_DIFFERENCES
            count += second.size
    return found / count if count else 0.0


def _between(bench: Bench, fit: Fitted) -> float:
    """Variance of the means of records, or stretches, in one and the same motion; NaN where too little of them is the same."""
    states = fit.samples.setting.states
    rows = bench.fitted
    speed = bench.kept(states.speed_rad_s)[rows]
    gains = (bench.kept(np.gradient(np.abs(states.speed_rad_s)))[rows] > 0.0).astype(int)
    edges = np.quantile(np.abs(speed), np.arange(1, _SPEEDS) / _SPEEDS)
    cell = (np.searchsorted(edges, np.abs(speed)) * 2 + (speed > 0.0)) * 2 + gains
    unit, left = _units(bench)[rows], fit.residual[rows]
    squares, covered = 0.0, 0
    for number in np.unique(cell):
        here = cell == number
        means = [
            float(np.mean(left[here & (unit == one)])) for one in np.unique(unit[here]) if int(np.sum(here & (unit == one))) >= _SAMPLES
        ]
        if len(means) > 1:
            size = int(here.sum())
            squares, covered = squares + size * float(np.var(means, ddof=1)), covered + size
    return squares / covered if covered > _COVERED * left.size else math.nan


def _foretold(bench: Bench, fit: Fitted) -> float:
    """Share of the squared residual that means over the speed, or over the place, foretell of records, or stretches, from the others."""
    states, rows = fit.samples.setting.states, bench.fitted
    unit, left = _units(bench)[rows], fit.residual[rows]
    total = float(np.sum(left**2))
    best = 0.0
    for axis in (states.speed_rad_s, states.screw_mm) if fit.samples.setting.placed else (states.speed_rad_s,):
        seen = bench.kept(axis)[rows]
        cell = np.searchsorted(np.quantile(seen, np.arange(1, _CELLS) / _CELLS), seen)
        sums, counts = np.bincount(cell, left, _CELLS), np.bincount(cell, minlength=_CELLS).astype(float)
        after = 0.0
        for one in np.unique(unit):
            here = unit == one
            others = counts - np.bincount(cell[here], minlength=_CELLS)
            means = np.where(others > 0.0, (sums - np.bincount(cell[here], left[here], _CELLS)) / np.maximum(others, 1.0), 0.0)
            after += float(np.sum((left[here] - means[cell[here]]) ** 2))
        best = max(best, 1.0 - after / total if total > 0.0 else 0.0)
    return best


def _units(bench: Bench) -> NDArray[np.int64]:
    """The record of every sample, or its stretch of the one record, [samples]."""
    records = bench.of_record
    if np.unique(records[bench.fitted]).size > 1:
        return records
    return np.asarray(np.arange(records.size) * _STRETCHES // records.size)
