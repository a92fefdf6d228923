"""How a machine differs from run to run, learned from its baseline records: each parameter that may vary by itself, temperature that moves several, and what is left, which is noise.

The variance of each has a scaled inverse chi-square prior about its usual one, and is re-estimated with its values on the runs (A. P. Dempster, N. M. Laird, D. B. Rubin, "Maximum likelihood
from incomplete data via the EM algorithm", J. Royal Statistical Society B 39, 1977): few records move it little, and what they do not show stays as usual. How far all of them go at once, over what
is usual, is one number that the records tell together.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear
from scipy.special import softmax

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import Evidence, directions_of
from ema_tools.fit.nuisance import Spread
from ema_tools.fit.whitening import Whitener, least_noise, noise_between
from ema_tools.select.strategies.strategy import LEAST_LIMIT

_CREDIBLE_DAY = 3.0  # standard deviations of the temperature that are taken for one [chance]
_THERMOMETER = "current_A"  # with the voltage it tells the winding's resistance
_FARTHEST_DAY = 8.0  # usual standard deviations that a day takes a healthy machine: wear goes farther [judgement]
_WILD_DAYS = 4.0  # times the usual: no days vary farther in everything at once [judgement]
_PRIORS = tuple(2.0**k for k in range(24))  # weights of the prior that are tried, until the days are such [effort]
_ROUNDS = 6  # of re-estimation [effort]
# Times the usual that everything may vary at once: from a bench where nothing moves to the wildest days [effort]
_SCALES = tuple(2.0**k for k in range(-6, 4))
_ROUNDS_OF_SCALE = 12  # of re-estimation of each, at every scale [effort]
_NOISE_ROUNDS = 3  # of its estimate beside what moves [effort]


def freed(evidence: Evidence) -> Evidence:
    """Evidence beside baseline records with everything free that varies between them, by as much as they show of it."""
    if _THERMOMETER not in evidence.channels:
        # nothing tells the temperature, nor most of the rest, and all of it together may look like wear
        return evidence
    known, count = evidence.actuator, len(evidence.repeats)
    vary = _varying(known)
    apart = _apart(evidence)
    _, directions = directions_of(known, evidence.record, evidence.channels, evidence.start_mm, vary)
    least = least_noise(evidence.target)
    # records of one morning are of one temperature: that they are alike says nothing of another day's
    bend = _place_of(vary) + 1
    scales = _scales(directions, apart, least, bend)
    directions = directions * scales[:, None, None]
    vary = tuple(replace(one, std=one.std * float(scale)) for one, scale in zip(vary, scales, strict=True))
    directions, widths, values, shares, doubts = _learned(directions, apart, least, vary, known.scatter)
    left = apart - np.einsum("kr,kcn->rcn", values, directions)
    power = noise_between(left, least)
    widen = 1.0 + 1.0 / count
    told = _Told.of(directions, evidence.target - np.mean(evidence.repeats, axis=0), np.sqrt(widen * np.mean(power, axis=1)))
    widths, warmth = _on_this_day(told, widths, doubts, bend - 1, min(1.0, float(scales[-1])))
    # what is not known of a degree lies in each value itself, by as much as today is warmer
    widths = np.hypot(widths, doubts * warmth) * np.sqrt(widen)
    shown = tuple(replace(_as_warm(one, vary, shares), std=one.std * float(width)) for one, width in zip(vary, widths, strict=True))
    # the temperature moves values by so much that what they do bends
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
    return directions_of(actuator, record, channels, start_mm, _varying(actuator))[1]


def _varying(actuator: Actuator) -> tuple[Spread, ...]:
    return (*spreads.from_run_to_run(actuator), *spreads.besides(actuator))


def without_days(signals: Reals, directions: Reals, noise: Reals) -> Reals:
    """Signals [channels, rows] without what `directions` [k, channels, rows] explain of them at their best, each with a prior of one and no farther than days go, alone and together; `noise`: of a
    row, [channels]."""
    columns = (directions / noise[:, None]).reshape(len(directions), -1)
    products, seen = columns @ columns.T, columns @ (signals / noise[:, None]).ravel()
    farthest = _WILD_DAYS * math.sqrt(len(columns))
    best = np.zeros(len(columns))
    for prior in _PRIORS:
        root = np.linalg.cholesky(products + prior * np.eye(len(columns)))
        best = lsq_linear(root.T, np.linalg.solve(root, seen), (-_FARTHEST_DAY, _FARTHEST_DAY), method="bvls").x
        if float(np.linalg.norm(best)) <= farthest:
            break
    return np.asarray(signals - np.tensordot(best, directions, 1))


def varying_as(evidence: Evidence, other: Evidence) -> Evidence:
    """Evidence of a record alone about the same machine, with all free that varies in `other`."""
    if not other.varies:
        return evidence
    _, directions = directions_of(evidence.actuator, evidence.record, evidence.channels, evidence.start_mm, other.varies)
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


def _learned(
    directions: Reals, apart: Reals, least: Reals, vary: Sequence[Spread], stated: Collection[str]
) -> tuple[Reals, Reals, Reals, Reals, Reals]:
    """The directions [k, channels, rows] with what a degree does to this machine, standard deviations over the usual ones [k], the values on each run [k, runs], by how much one standard
    deviation of the temperature moves each, in its own, and the doubt of that for a day of one learned deviation, [k] each; what is `stated` stays as it is. `least`: noise of a row at least,
    [channels]."""
    count, runs = len(directions), len(apart)
    widths, values = np.ones(count), np.zeros((count, runs))
    fixed = np.array([one.title in stated for one in vary], dtype=bool)
    found, shares, doubts = directions, np.zeros(count), np.zeros(count)
    left = apart
    for _ in range(_ROUNDS if count else 0):
        values, doubt = _Told.of(found, apart, _rms(left, least)).values(widths)
        widths = np.where(fixed, 1.0, np.sqrt(spreads.variances_shown(np.ones(count), values, np.diag(doubt))))
        left = apart - np.einsum("kr,kcn->rcn", values, found)
        shares, doubts = _with_temperature(vary, values, widths, shares, fixed)
        found = _warmed(directions, vary, shares)
    return found, widths, values, shares, doubts


def _scales(directions: Reals, apart: Reals, least: Reals, first: int) -> Reals:
    """By how much all that varies besides does so at once, over what is usual, [k]; the `first` ones do as they do.

    On a quiet bench two dozen values stand still together, on ordinary days they all move: no one of them alone tells, all together do. The mean of the squared scale over its likelihood
    given what the runs are `apart`, [runs, channels, rows], every value on every run integrated out.
    """
    told = _Told.of(directions, apart, _noise_beside(directions, apart, least))
    by_itself = np.arange(len(directions)) < first
    weights = softmax([_likelihood_of(told, np.where(by_itself, 1.0, scale)) for scale in _SCALES])
    return np.where(by_itself, 1.0, math.sqrt(float(weights @ np.square(_SCALES))))


def _likelihood_of(told: _Told, usual: Reals) -> float:
    """Log likelihood of what the runs tell where these widths are usual [k] and each has its own about it, at the best of those: one that goes farther by itself says little of all."""
    variances = usual**2
    for _ in range(_ROUNDS_OF_SCALE):
        values, doubt = told.values(np.sqrt(variances))
        variances = spreads.variances_shown(usual**2, values, np.diag(doubt))
    ratios = usual**2 / variances
    return told.log_likelihood(np.sqrt(variances)) + 0.5 * spreads.USUAL_WEIGHT * float(np.sum(np.log(ratios) - ratios))


def _noise_beside(directions: Reals, apart: Reals, least: Reals) -> Reals:
    """What is left of the runs where everything may move freely, rms [channels]."""
    level = _rms(apart, least)
    for _ in range(_NOISE_ROUNDS):
        columns = (directions / level[:, None]).reshape(len(directions), -1)
        values, *_ = np.linalg.lstsq(columns.T, (apart / level[:, None]).reshape(len(apart), -1).T, rcond=None)
        level = _rms(apart - np.einsum("kr,kcn->rcn", values, directions), least)
    return level


def _rms(left: Reals, least: Reals) -> Reals:
    """Noise of a row in what is left of the runs, [channels], where their mean has taken a part."""
    runs = len(left)
    return np.asarray(np.maximum(np.sqrt(np.mean(left**2, axis=(0, 2)) * runs / (runs - 1)), least))


@dataclass(frozen=True)
class _Told:
    """What differences of signals, one or several, tell of values along directions: products of these among themselves [k, k], and with the signals [k, draws], in the noise."""

    products: Reals
    seen: Reals

    @staticmethod
    def of(directions: Reals, signals: Reals, level: Reals) -> _Told:
        """Of directions [k, channels, rows] and signals [draws, channels, rows], or one of them; `level`: noise of a row, [channels]."""
        columns = (directions / level[:, None]).reshape(len(directions), -1)
        return _Told(columns @ columns.T, columns @ (signals / level[:, None]).reshape(-1, columns.shape[1]).T)

    def values(self, widths: Reals) -> tuple[Reals, Reals]:
        """Their best where the values have these standard deviations [k], [k, draws], and the covariance of each, [k, k]."""
        doubt = widths[:, None] * np.linalg.inv(self._whole(widths)) * widths
        return doubt @ self.seen, doubt

    def log_likelihood(self, widths: Reals) -> float:
        """Of the signals, every value of every draw integrated out, but for what is the same for all widths."""
        whole, shown = self._whole(widths), widths[:, None] * self.seen
        # the runs' differences from their mean tell as much as one less
        draws = max(self.seen.shape[1] - 1, 1)
        return 0.5 * float(np.sum(shown * np.linalg.solve(whole, shown)) - draws * np.linalg.slogdet(whole)[1])

    def _whole(self, widths: Reals) -> Reals:
        return np.asarray(np.eye(len(widths)) + widths[:, None] * self.products * widths)


def _on_this_day(told: _Told, widths: Reals, doubts: Reals, place: int, narrow: float) -> tuple[Reals, float]:
    """The widths [k], that of the temperature as `narrow` as the others' unless today's signals need it by as much as an effect is needed, and in its learned standard deviations how far off it
    is and may be."""
    learned, open_ = widths[place], np.hypot(widths, _FARTHEST_DAY * doubts)
    as_then = np.where(np.arange(len(widths)) == place, narrow, 1.0)
    if 2.0 * (told.log_likelihood(open_) - told.log_likelihood(as_then * open_)) < LEAST_LIMIT:
        widths, open_ = as_then * widths, as_then * open_
    values, doubt = told.values(open_)
    today = float(values[place, 0])
    # farther than days go it is no temperature
    credible = today if abs(today) < _CREDIBLE_DAY * open_[place] else 0.0
    return widths, math.hypot(credible, math.sqrt(doubt[place, place])) / float(learned)


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
