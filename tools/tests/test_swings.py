"""Swings of a residual at any number of periods per turn."""

from __future__ import annotations

import numpy as np
import pytest

from ema_tools.select.swings import swings


def way(turns: float, seed: int, rows: int = 20_000) -> np.ndarray:
    """A shaft to and fro over so many turns, as angle, rad, from anywhere."""
    time = np.arange(rows) / rows
    return np.random.default_rng(seed).uniform(-50.0, 50.0) + np.pi * turns * np.sin(2.0 * np.pi * 5.0 * time + seed)


@pytest.mark.parametrize("periods", [0.137, 1.0 / 3.0, 2.5, 17.61])
def test_one_swing_is_found_among_noise_and_a_spring(periods: float) -> None:
    """Each record has its own phase; the longest way tells numbers of periods apart to a hundredth of a turn's share, and a peak is placed ten times better."""
    random = np.random.default_rng(1)
    angles = [way(turns, seed) for turns, seed in ((60.0, 1), (45.0, 2), (30.0, 3))]
    residuals = [
        0.02 * angle + np.sin(periods * angle + random.uniform(0.0, 6.0)) + random.normal(0.0, 2.0, angle.size) for angle in angles
    ]
    assert swings(residuals, angles, 40.0)[0] == pytest.approx(periods, abs=0.1 / 60.0)


def test_whole_numbers_are_left_to_those_who_try_them() -> None:
    angle = way(60.0, 1)
    found = swings([np.sin(4.0 * angle) + 0.3 * np.sin(7.4 * angle)], [angle], 40.0)
    assert found[0] == pytest.approx(7.4, abs=2e-3) and all(abs(one - 4.0) > 0.1 / 60.0 for one in found)


def test_a_way_that_is_too_short_shows_none() -> None:
    angle = way(1.5, 1)
    assert swings([np.sin(0.8 * angle)], [angle], 1.0) == ()
    assert swings([np.zeros(0)], [np.zeros(0)], 40.0) == ()
