"""How a machine differs from run to run, learned from its baseline records: each parameter that may vary by itself, temperature that moves several, and what is left, which is noise.

The variance of each has a scaled inverse chi-square prior about its usual one, and is re-estimated with its values on the runs (A. P. Dempster, N. M. Laird, D. B. Rubin, "Maximum likelihood
from incomplete data via the EM algorithm", J. Royal Statistical Society B 39, 1977): few records move it little, and what they do not show stays as usual.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import Evidence, simulate_channels, slope_step
from ema_tools.fit.nuisance import Spread
from ema_tools.fit.whitening import Whitener, least_noise, smoothed, spectrum

USUAL_WEIGHT = 4.0  # the usual variance counts as much as this many records that had shown it [judgement]
_ROUNDS = 6  # of re-estimation [effort]


def freed(evidence: Evidence) -> Evidence:
    """Evidence beside baseline records with everything free that varies between them, by as much as they show of it."""
    known, count = evidence.actuator, len(evidence.repeats)
    vary = (*spreads.from_run_to_run(known), *spreads.besides(known))
    apart = _apart(evidence)
    directions = _directions(known, evidence.record, evidence.channels, evidence.start_mm, vary)
    least = least_noise(evidence.target)
    directions, widths, values, shares = _learned(directions, apart, least, vary, known.scatter)
    left = apart - np.einsum("kr,kcn->rcn", values, directions)
    power = smoothed(np.mean(np.abs(spectrum(left)) ** 2, axis=0) * count / (count - 1)) + least[:, None] ** 2
    widen = 1.0 + 1.0 / count
    widths *= np.sqrt(widen)
    shown = tuple(replace(_as_warm(one, vary, shares), std=one.std * float(width)) for one, width in zip(vary, widths, strict=True))
    # the temperature moves values by so much that what they do bends
    bend = _place_of(vary) + 1
    return replace(
        evidence,
        spread=shown[:bend],
        whiten=Whitener.of(widen * power, evidence.record.rows),
        noise=power,
        additive=directions[bend:] * widths[bend:, None, None],
        varies=shown[bend:],
        of_known=evidence,
    )


def days_of(actuator: Actuator, record: Record, channels: tuple[str, ...], start_mm: float) -> Reals:
    """What one usual standard deviation of everything that varies makes of the signals of a machine, [varies, channels, rows]."""
    return _directions(actuator, record, channels, start_mm, (*spreads.from_run_to_run(actuator), *spreads.besides(actuator)))


def without_days(signals: Reals, directions: Reals, noise: Reals) -> Reals:
    """Signals [channels, rows] without what `directions` [k, channels, rows] explain of them at their best, each with a prior of one; `noise`: of a row, [channels]."""
    columns = (directions / noise[:, None]).reshape(len(directions), -1)
    best = np.linalg.solve(columns @ columns.T + np.eye(len(columns)), columns @ (signals / noise[:, None]).ravel())
    return np.asarray(signals - np.tensordot(best, directions, 1))


def varying_as(evidence: Evidence, other: Evidence) -> Evidence:
    """Evidence of a record alone about the same machine, with all free that varies in `other`."""
    directions = _directions(evidence.actuator, evidence.record, evidence.channels, evidence.start_mm, other.varies)
    additive = np.concatenate([directions, evidence.additive])
    return replace(evidence, spread=other.spread, additive=additive, varies=other.varies, of_known=evidence)


def _apart(evidence: Evidence) -> Reals:
    """What the baseline records differ from their mean by, [runs, channels, rows]."""
    runs = np.array(evidence.repeats)
    return np.asarray((runs - runs.mean(axis=0)) * _of_others(len(runs)))


def _of_others(count: int) -> float:
    """Of a run against the mean of the others, as evidence has its repeats, to the same against the mean of all."""
    shrink = np.sqrt((1.0 + 1.0 / count) / (1.0 + 1.0 / (count - 1)))
    return float((count - 1) / count / shrink)


def _directions(known: Actuator, record: Record, channels: tuple[str, ...], start_mm: float, vary: Sequence[Spread]) -> Reals:
    """What one standard deviation of each makes of the signals, [vary, channels, rows]."""
    here = simulate_channels(known, record, channels, start_mm)

    def moved(one: Spread) -> Reals:
        step = slope_step(one)
        return (simulate_channels(known.changed(one.changes(known, step)), record, channels, start_mm) - here) / step

    return np.array(each(moved, vary)).reshape(len(vary), *here.shape)


def _learned(
    directions: Reals, apart: Reals, least: Reals, vary: Sequence[Spread], stated: Collection[str]
) -> tuple[Reals, Reals, Reals, Reals]:
    """The directions [k, channels, rows] with what a degree does to this machine, standard deviations over the usual ones [k], the values on each run [k, runs], and by how much one standard
    deviation of the temperature moves each, in its own, [k]; what is `stated` stays as it is. `least`: noise of a row at least, [channels]."""
    count, runs = len(directions), len(apart)
    widths, values = np.ones(count), np.zeros((count, runs))
    fixed = np.array([one.title in stated for one in vary], dtype=bool)
    found, shares, doubts = directions, np.zeros(count), np.zeros(count)
    left = apart
    for _ in range(_ROUNDS if count else 0):
        level = np.maximum(np.sqrt(np.mean(left**2, axis=(0, 2)) * runs / (runs - 1)), least)[:, None]
        columns = (found / level).reshape(count, -1)
        doubt = np.linalg.inv(columns @ columns.T + np.diag(widths**-2.0))
        values = doubt @ (columns @ (apart / level).reshape(runs, -1).T)
        shown = np.sum(values**2, axis=1) + (runs - 1) * np.diag(doubt)
        widths = np.where(fixed, 1.0, np.sqrt((USUAL_WEIGHT + shown) / (USUAL_WEIGHT + runs - 1)))
        left = apart - np.einsum("kr,kcn->rcn", values, found)
        shares, doubts = _with_temperature(vary, values, widths, shares, fixed)
        found = _warmed(directions, vary, shares)
    # what is not known of a degree lies in each value itself
    return found, np.where(fixed, widths, np.hypot(widths, doubts)), values, shares


def _place_of(vary: Sequence[Spread]) -> int:
    return [one.cause for one in vary].index(spreads.TEMPERATURE)


def _with_temperature(vary: Sequence[Spread], values: Reals, widths: Reals, before: Reals, fixed: Reals) -> tuple[Reals, Reals]:
    """By how much one standard deviation of the temperature moves each value beyond the usual, in the value's own, and the doubt of that, [k] each: a line through the runs, whose slope has a
    prior of what machines differ by."""
    shares, doubts = np.zeros(len(vary)), np.zeros(len(vary))
    place = _place_of(vary)
    warm, reach = values[place], vary[place].std
    for k, one in enumerate(vary):
        differs = spreads.PER_DEGC_DIFFERS.get(one.title, 0.0) * reach / one.std
        if differs > 0.0 and not fixed[k]:
            precision = float(warm @ warm) / widths[k] ** 2 + differs**-2.0
            shares[k] = float((values[k] + before[k] * warm) @ warm) / widths[k] ** 2 / precision
            doubts[k] = widths[place] / math.sqrt(precision)
    return shares, doubts


def _as_warm(one: Spread, vary: Sequence[Spread], shares: Reals) -> Spread:
    """The temperature with what a degree does to this machine; any other as it is."""
    if one.cause != spreads.TEMPERATURE:
        return one
    moves = dict(zip(one.names, one.shares, strict=True))
    for other, share in zip(vary, shares, strict=True):
        moves |= {name: moves.get(name, 0.0) + float(share) * other.std / one.std for name in other.names if share}
    return replace(one, names=tuple(moves), shares=tuple(moves.values()))


def _warmed(directions: Reals, vary: Sequence[Spread], shares: Reals) -> Reals:
    """The directions with that of the temperature moved by so much of each other."""
    found = directions.copy()
    found[_place_of(vary)] += np.tensordot(shares, directions, 1)
    return found
