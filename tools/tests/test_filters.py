"""The filters without phase and the correlation against scipy.signal's, which run through the rows instead of the lines."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from ema_tools.balances.filtering import Smoother
from ema_tools.base.arrays import Reals
from ema_tools.base.filters import butterworth, chebyshev, correlated, filtered, filtered_every, quick_length, shares_of

EDGE = 32  # periods of the cutoff within which it shows that the two hold a signal to go on differently beyond its ends: there a step has died away


def wander(rows: int, seed: int = 1) -> Reals:
    """A signal with a drift, a swing and noise, whose ends differ."""
    random = np.random.default_rng(seed)
    return np.cumsum(random.normal(size=rows)) * 0.01 + np.sin(0.01 * np.arange(rows)) + 0.1 * random.normal(size=rows)


@pytest.mark.parametrize("rows", [4000, 4002])
@pytest.mark.parametrize("share", [0.02, 0.2, 0.7])
def test_butterworth_is_that_run_both_ways(rows: int, share: float) -> None:
    values = wander(rows)
    expected = signal.sosfiltfilt(signal.butter(4, share, output="sos"), values)
    found = filtered(values, butterworth(shares_of(rows), 4, share))
    edge = round(EDGE / share)
    assert found[edge:-edge] == pytest.approx(expected[edge:-edge], abs=1e-6)


def test_chebyshev_is_that_run_both_ways() -> None:
    values = wander(4000)
    expected = signal.sosfiltfilt(signal.cheby1(8, 0.05, 0.16, output="sos"), values)
    found = filtered(values, chebyshev(shares_of(4000), 8, 0.05, 0.16))
    # its poles lie closer to the edge of stability, so that a step dies away five times more slowly
    edge = round(5 * EDGE / 0.16)
    assert found[edge:-edge] == pytest.approx(expected[edge:-edge], abs=1e-6)


def test_along_any_axis_and_leaves_a_straight_line() -> None:
    gains = butterworth(shares_of(300), 4, 0.1)
    both = np.stack([wander(300), np.linspace(-1.0, 2.0, 300)])
    assert np.array_equal(filtered(both.T, gains, 0).T, filtered(both, gains))
    assert filtered(both, gains)[1] == pytest.approx(both[1], abs=1e-12)


@given(st.integers(1, 200), st.integers(0, 1000))
def test_correlation(rows: int, seed: int) -> None:
    one, two = np.random.default_rng(seed).normal(size=(2, rows))
    assert correlated(one, two) == pytest.approx(np.correlate(one, two, mode="full"), abs=1e-9)


@pytest.mark.parametrize(("rows", "every"), [(9900, 10), (5000, 3), (1403, 7), (801, 2)])
def test_every_nth_row_is_that_of_all(rows: int, every: int) -> None:
    """Beside the filter of the rows as they are: what a quick length adds beyond the end is forgotten before it."""
    share = 0.8 / every
    both = np.stack([wander(rows, 3), np.linspace(-1.0, 2.0, rows)])
    length = quick_length(rows, 100.0 / share, every)
    plain = filtered(both, chebyshev(shares_of(rows), 8, 0.05, share))[:, ::every]
    quick = filtered_every(both, chebyshev(shares_of(length), 8, 0.05, share), every)
    assert length > rows and (length - 1) % every == 0
    assert quick == pytest.approx(plain, abs=1e-9)


def test_a_record_too_short_to_go_on_keeps_its_length() -> None:
    assert quick_length(300, 1250.0, 10) == 300
    assert quick_length(9900, 0.0) == 10001  # 9899 is 19 x 521


@pytest.mark.parametrize("rows", [700, 9900])
def test_decimated_is_the_filter_of_the_rows(rows: int) -> None:
    smoother = Smoother.of(1e-3)
    values = wander(rows, 5)
    inner = values[smoother.edge_rows : -smoother.edge_rows]
    expected = filtered(inner, chebyshev(shares_of(inner.size), 8, 0.05, 0.8 / smoother.every))[:: smoother.every]
    assert smoother.decimated(values) == pytest.approx(expected, abs=1e-9)
    assert smoother.kept(values).size == expected.size
