"""The bounded fit: values, standard errors and bounds of a problem with a known answer, and how often it asks for the model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pytest

from ema_tools.base.arrays import Reals
from ema_tools.fit.bounded import PROMISE, FreeValue, OneSided, Slopes, Stop, TwoSided, fit

TIME = np.linspace(0.0, 1.0, 50)
STOP = Stop(50, 1e-12, 1e-12, 1e-12)
UNKNOWNS = (FreeValue("gain", 1.0, 2.0, 0.0, 10.0, 1e-6), FreeValue("rate", 1.0, 0.5, 0.1, 8.0, 1e-6))


def falling(values: Mapping[str, float]) -> Reals:
    """A gain that falls by a rate."""
    return np.asarray(values["gain"] * np.exp(-values["rate"] * TIME))


@pytest.mark.parametrize("slopes", [OneSided((1e-6,)), TwoSided(1e-4, 0.1)])
def test_values_and_standard_errors_are_those_of_the_linear_theory(slopes: Slopes) -> None:
    truth = {"gain": 3.0, "rate": 2.0}
    found = fit(UNKNOWNS, falling, slopes, STOP, falling(truth))
    assert found.values == pytest.approx(truth, rel=1e-6)
    assert found.at_bound == () and found.cost < 1e-12
    fall = np.exp(-2.0 * TIME)
    exact = np.column_stack([fall, -3.0 * TIME * fall])
    assert found.covariance == pytest.approx(np.linalg.inv(exact.T @ exact), rel=1e-3)


def test_a_value_ends_on_its_bound_and_only_a_wall_is_told() -> None:
    target = falling({"gain": 12.0, "rate": 2.0})
    assert fit(UNKNOWNS, falling, OneSided((1e-6,)), STOP, target).at_bound == ("gain",)
    open_above = (FreeValue("gain", 1.0, 2.0, 0.0, 10.0, 1e-6, (True, False)), UNKNOWNS[1])
    found = fit(open_above, falling, OneSided((1e-6,)), STOP, target)
    assert found.at_bound == () and found.values["gain"] == pytest.approx(10.0, abs=1e-5)


def test_residual_and_slopes_at_one_point_ask_for_the_model_once() -> None:
    asked: list[tuple[float, ...]] = []
    points: list[None] = []

    def counted(values: Mapping[str, float]) -> Reals:
        asked.append(tuple(values.values()))
        return falling(values)

    fit(UNKNOWNS, counted, OneSided((1e-6,)), STOP, falling({"gain": 3.0, "rate": 2.0}), told=lambda: points.append(None))
    assert len(set(asked)) == len(asked)
    assert len(asked) <= 3 * len(points)


def test_a_step_never_leaves_a_range_that_is_narrower_than_it() -> None:
    narrow = (FreeValue("gain", 3.0, 3.0, 2.99, 3.02), UNKNOWNS[1])
    gains: list[float] = []

    def watched(values: Mapping[str, float]) -> Reals:
        gains.append(values["gain"])
        return falling(values)

    found = fit(narrow, watched, OneSided((0.02,)), STOP, falling({"gain": 3.01, "rate": 2.0}))
    assert min(gains) >= 2.99 and max(gains) <= 3.02
    assert found.values["gain"] == pytest.approx(3.01, abs=1e-3)
    assert found.slopes[:, 0] == pytest.approx(3.0 * np.exp(-found.values["rate"] * TIME), rel=1e-6)


def test_a_step_grows_until_it_shows() -> None:
    def stepped(values: Mapping[str, float]) -> Reals:
        return np.asarray(np.round(falling(values), 1))

    flat = fit(UNKNOWNS, stepped, OneSided((1e-6,), 0.1), Stop(1, 1e-9, 1e-9))
    shown = fit(UNKNOWNS, stepped, OneSided((1e-6, 0.5), 0.1), Stop(1, 1e-9, 1e-9))
    assert not flat.slopes.any() and shown.slopes.any(axis=0).all()


def test_a_step_that_was_too_small_is_not_tried_again_in_the_same_fit() -> None:
    rule = OneSided((1e-9, 1e-3), 1e-6)
    gains: list[float] = []

    def vectors(points: Sequence[Reals]) -> list[Reals]:
        gains.extend(float(point[0]) for point in points)
        return [float(point[0]) * TIME for point in points]

    for here in (1.0, 2.0):
        rule(vectors, np.array([here]), here * TIME, np.array([0.0]), np.array([9.0]))
    assert gains == pytest.approx([1.0 + 1e-9, 1.001, 2.001], abs=1e-12)


def test_a_fit_ends_where_no_step_promises_anything() -> None:
    """Beside noise of unit variance the way from a tenth of a standard error on is not gone."""
    noise = np.random.default_rng(7).standard_normal(TIME.size)
    target = 50.0 * falling({"gain": 3.0, "rate": 2.0}) + noise
    asked: list[None] = []

    def counted(values: Mapping[str, float]) -> Reals:
        asked.append(None)
        return 50.0 * falling(values)

    whole = fit(UNKNOWNS, counted, OneSided((1e-6,)), Stop(50, 1e-15, 1e-15, 1e-15), target)
    all_of_it = len(asked)
    soon = fit(UNKNOWNS, counted, OneSided((1e-6,)), Stop(50, 1e-15, 1e-15, 1e-15, of_promise=PROMISE), target)
    assert len(asked) - all_of_it < all_of_it
    assert whole.cost <= soon.cost < whole.cost + PROMISE
    assert soon.cost == pytest.approx(float(soon.residual @ soon.residual)) and soon.slopes.shape == (TIME.size, 2)
    std = np.sqrt(np.diag(whole.covariance))
    assert all(abs(soon.values[one.name] - whole.values[one.name]) < 0.1 * std[k] for k, one in enumerate(UNKNOWNS))
