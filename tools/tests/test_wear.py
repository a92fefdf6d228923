"""Drift and remaining life of a value over days, on days that share no law with what is fitted to them; and that firmware says the same."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.fit.kept import KNOTS, Knots, kept
from ema_tools.fit.laws import all_laws, known
from ema_tools.fit.wear import Outlook, outlook
from ema_tools.plant.trend import LAWS, onboard_outlooks


def said(days: Reals, values: Reals, std: float = 0.5, limit: float = 50.0) -> Outlook:
    """What is said of days with one standard error."""
    found = outlook(days, values, np.full(days.size, std), limit)
    assert found is not None
    return found


@pytest.mark.slow
def test_units_that_do_not_change_are_rarely_said_to() -> None:
    """Heavy-tailed scatter, a tenth more than it is said to be: of 300 units at a rate of 2 % no more than 12, which 300 at exactly 2 % exceed once in fifty."""
    found = 0
    for seed in range(300):
        random = np.random.default_rng(seed)
        count = int(random.integers(6, 60))
        days = np.cumsum(random.exponential(7.0, count))
        told = outlook(days, 1.1 * random.standard_t(5, count) / math.sqrt(5.0 / 3.0), np.ones(count), 50.0, 0.02)
        found += told is not None and told.drift.changed
    assert found <= 12


@pytest.mark.parametrize(("shape", "tolerance"), [("step", 1), ("ramp", 4)])
def test_a_change_is_found_with_its_day(shape: str, tolerance: int) -> None:
    days = np.arange(40.0)
    values = (days >= 25) * 6.0 if shape == "step" else np.maximum(days - 25.0, 0.0)
    found = said(days, values + np.random.default_rng(1).normal(0.0, 1.0, 40), 1.0).drift
    assert found.changed
    assert found.by > 0.0
    assert abs(found.since - 25.0) <= tolerance
    assert found.since95[0] <= 25.0 <= found.since95[1]


def test_few_days_tell_nothing() -> None:
    assert outlook(np.arange(5.0), np.array([0.0, 0.0, 0.0, 0.0, 90.0]), np.ones(5), 50.0) is None
    assert outlook(np.zeros(8), np.arange(8.0), np.ones(8), 50.0) is None


def test_even_wear_is_foretold() -> None:
    days = np.arange(0.0, 300.0, 5.0)
    found = said(days, 0.1 * days + np.random.default_rng(2).normal(0.0, 0.5, days.size))
    left = 500.0 - days[-1]
    assert found.life.low < left < found.life.high
    assert abs(found.life.median / left - 1.0) < 0.2
    assert abs(found.life.now - 0.1 * days[-1]) < 1.0
    assert abs(found.rate - 0.1) < 3.0 * found.rate_std
    assert found.life.reached > 0.7


def test_what_stands_at_its_limit_has_no_life_left() -> None:
    days = np.arange(0.0, 300.0, 5.0)
    found = said(days, 0.2 * days).life
    assert found.low == found.median == 0.0


def test_many_days_are_joined() -> None:
    random = np.random.default_rng(3)
    days = np.arange(0.0, 400.0, 0.5)
    values = 0.08 * days + random.normal(0.0, 0.5, days.size)
    knots = kept(days, values, np.full(days.size, 0.5))
    assert knots.time.size == KNOTS
    # nothing is lost on the way: the newest stand as they are, the weighed mean is that of all
    assert np.array_equal(knots.value[-6:], values[-6:])
    weight = knots.std**-2.0
    assert abs(np.average(knots.value, weights=weight) - values.mean()) < 0.3
    found = said(days, values).life
    assert found.low < 50.0 / 0.08 - 400.0 < found.high


def test_no_law_stands_twice() -> None:
    laws = all_laws()
    assert laws.onset.size == LAWS
    rows = np.column_stack([one for name, one in vars(laws).items() if name != "share"])
    assert len(np.unique(rows, axis=0)) == LAWS
    assert laws.share.sum() == pytest.approx(2.0)


def test_the_laws_know_what_all_knots_at_once_tell() -> None:
    """The process of every law by the Cholesky root of its covariance (Rasmussen and Williams, equations 2.25, 2.26 and 2.30), which shares nothing but the laws with what it is held against."""
    laws, random = all_laws(), np.random.default_rng(11)
    at = np.sort(np.concatenate([[0.0, 0.5, 1.0], random.uniform(size=17)]))  # one knot stands on edges
    knots = Knots(at, 40.0 * at**2 + random.normal(0.0, 0.5, at.size), random.uniform(0.3, 0.9, at.size))
    found = known(laws, at, knots, 50.0)
    prior = np.array([0.2, 0.4, 0.2])
    for number in range(LAWS):
        law = laws.chosen(slice(number, number + 1))
        own = law.own_time(at)
        basis = np.column_stack([np.ones(at.size), law.risen(own)[0], law.faded(at)[0]])
        walk = law.walk[0] ** 2 * np.minimum.outer(own[0], own[0])
        for passed in law.passed(at):
            walk = walk + (0.24 / law.parts[0]) ** 2 * np.minimum.outer(passed[0], passed[0])
        root = np.linalg.cholesky((basis * prior**2) @ basis.T + walk + np.diag((knots.std / 50.0) ** 2))
        white = np.linalg.solve(root, knots.value / 50.0)
        assert found.evidence[number] == pytest.approx(-0.5 * white @ white - np.sum(np.log(np.diagonal(root))), abs=1e-8)
        # level, rate, fading part and the walk at the last knot beside the knots
        beside = np.linalg.solve(root, np.column_stack([basis * prior**2, walk[:, -1]]))
        before = np.diag([*prior**2, walk[-1, -1]])
        assert found.mean[number] == pytest.approx(beside.T @ white, rel=1e-8, abs=1e-9)
        assert found.cov[number] == pytest.approx(before - beside.T @ beside, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("bits", [32, 64])
def test_firmware_says_what_the_desk_says(bits: int) -> None:
    """Float64 to the fit of Mills' ratio; float32 to its rounding over 48 knots (tests/vectors/manifest.json)."""
    tolerance = 2e-6 if bits == 64 else 5e-4
    for seed in range(8):
        random = np.random.default_rng(seed)
        days = np.cumsum(random.exponential(9.0, 75))
        std = np.full(75, 0.6)
        values = 30.0 * (days / days[-1]) ** random.uniform(0.7, 3.0) + random.normal(0.0, 0.6, 75)
        looks = (9, 30, 48, 75)
        for count, onboard in zip(looks, onboard_outlooks(days, values, std, 50.0, looks, bits=bits), strict=True):
            desk = outlook(days[:count], values[:count], std[:count], 50.0)
            assert desk is not None
            both = (
                (onboard.odds_log, desk.odds),
                (onboard.now_percent, desk.life.now),
                (onboard.now_std_percent, desk.now_std),
                (onboard.by_percent, desk.drift.by),
                (onboard.rate_percent_per_day * days[count - 1], desk.rate * days[count - 1]),
                (onboard.low_days, desk.life.low),
                (onboard.median_days, desk.life.median),
                (onboard.high_days, desk.life.high),
                (onboard.reached_ratio, desk.life.reached),
            )
            for told, reference in both:
                assert told == pytest.approx(reference, rel=tolerance, abs=tolerance)
            assert onboard.drifts == desk.drift.changed


def test_saving_and_slices_change_nothing() -> None:
    random = np.random.default_rng(5)
    days, std = np.cumsum(random.exponential(9.0, 60)), np.full(60, 0.6)
    values = 0.05 * days + random.normal(0.0, 0.6, 60)
    whole = onboard_outlooks(days, values, std, 50.0, (20, 60))
    assert onboard_outlooks(days, values, std, 50.0, (20, 60), slice_laws=7, saving=True) == whole


def test_a_reading_that_is_refused_is_named() -> None:
    days = np.arange(8.0)
    with pytest.raises(InputError, match="reading 4: value_percent is NaN"):
        onboard_outlooks(days, np.where(days == 3.0, math.nan, 0.0), np.ones(8), 50.0, (8,))
    with pytest.raises(InputError, match="reading 6: time_days lies before the last"):
        onboard_outlooks(np.where(days == 5.0, 1.0, days), days, np.ones(8), 50.0, (8,))
    with pytest.raises(InputError, match="reading 3: there are too few readings"):
        onboard_outlooks(days, days, np.ones(8), 50.0, (3,))
