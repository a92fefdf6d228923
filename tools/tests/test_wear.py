"""Drift and remaining life of a value over days, on days that share no law with what is fitted to them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ema_tools.fit.wear import change, life


def test_units_that_do_not_change_are_rarely_said_to() -> None:
    """Heavy-tailed scatter, a tenth more than it is said to be: of 600 units at a rate of 2 % no more than 3.2 %, which 600 at exactly 2 % exceed once in fifty."""
    found = 0
    for seed in range(600):
        random = np.random.default_rng(seed)
        count = int(random.integers(4, 60))
        days = np.cumsum(random.exponential(7.0, count))
        found += change(days, 1.1 * random.standard_t(5, count) / math.sqrt(5.0 / 3.0), np.ones(count), 0.02).changed
    assert found <= 19


@pytest.mark.parametrize(("shape", "tolerance"), [("step", 1), ("ramp", 4)])
def test_a_change_is_found_with_its_day(shape: str, tolerance: int) -> None:
    days = np.arange(40.0)
    values = (days >= 25) * 6.0 if shape == "step" else np.maximum(days - 25.0, 0.0)
    found = change(days, values + np.random.default_rng(1).normal(0.0, 1.0, 40), np.ones(40))
    assert found.changed
    assert abs(found.since - 25.0) <= tolerance
    assert found.since95[0] <= 25.0 <= found.since95[1]
    assert abs(found.by - values[-1]) < 2.0


def test_few_days_tell_nothing() -> None:
    assert not change(np.arange(3.0), np.array([0.0, 0.0, 90.0]), np.ones(3)).changed
    assert not change(np.zeros(8), np.arange(8.0), np.ones(8)).changed


def test_even_wear_is_foretold() -> None:
    days = np.arange(0.0, 300.0, 5.0)
    values = 0.1 * days + np.random.default_rng(2).normal(0.0, 0.5, days.size)
    found = life(days, values, np.full(days.size, 0.5), 50.0)
    left = 500.0 - days[-1]
    assert found.low < left < found.high
    assert abs(found.median / left - 1.0) < 0.15
    assert abs(found.now - 0.1 * days[-1]) < 1.0
    assert found.reached > 0.7


def test_what_stands_at_its_limit_has_no_life_left() -> None:
    days = np.arange(0.0, 300.0, 5.0)
    found = life(days, 0.2 * days, np.full(days.size, 0.5), 50.0)
    assert found.low == found.median == 0.0


def test_the_same_days_give_the_same_answer_and_many_are_joined() -> None:
    random = np.random.default_rng(3)
    days = np.arange(0.0, 400.0, 0.5)
    values = 0.08 * days + random.normal(0.0, 0.5, days.size)
    assert life(days, values, np.full(days.size, 0.5), 50.0) == life(days, values, np.full(days.size, 0.5), 50.0)
    assert (
        life(days, values, np.full(days.size, 0.5), 50.0).low < 50.0 / 0.08 - 400.0 < life(days, values, np.full(days.size, 0.5), 50.0).high
    )
