"""Which causes a record shows, and how surely: priors, evidence and decision, on sets whose costs are given; and the noise that a residual shows."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy import integrate, optimize, signal

from benchmarks.days import simulator
from benchmarks.hidden.sealed import diagnosed, record_of
from ema_tools.base.arrays import Reals
from ema_tools.base.compiled import HAS_NUMBA
from ema_tools.data.actuator import reference_actuator
from ema_tools.fit.whitening import incoherent_power, lines_of
from ema_tools.infer.posterior import FittedSet, Given, Nuisance, Posterior, Scale, posterior
from ema_tools.infer.priors import log_odds, value_prior

NOISE = 40_000.0  # of as many independent numbers
BY_DATA_SHEET = Given(reference_actuator(), NOISE, 0.0, 0.1 * NOISE, 2.0, 5.0, False)
BESIDE_HEALTHY = Given(reference_actuator(), NOISE, 570.0, 5.0, 2.0, 5.0, True)
RISE, DIRECTED = "effects.stribeck_friction.rise", "effects.directional_stribeck.rise"
SIZES = {"stribeck_friction": RISE, "directional_stribeck": DIRECTED, "cogging_torque": "effects.cogging_torque.amplitude_Nm"}


def fitted(beyond: float, *causes: str) -> FittedSet:
    """A set that leaves so much cost beyond the noise, each size known to a hundredth of itself."""
    nuisance = Nuisance(NOISE + beyond, np.zeros(0), np.zeros((0, 0)), np.zeros(0), ())
    sizes = {SIZES[cause]: 0.01 if cause == "cogging_torque" else 0.4 for cause in causes}
    return FittedSet(frozenset(causes), sizes, np.diag([1e4 / size**2 for size in sizes.values()]), nuisance)


def weighed(empty: float, sets: Sequence[FittedSet]) -> Posterior:
    return posterior(BY_DATA_SHEET, fitted(empty), sets)


def test_a_cause_that_explains_a_large_residual_is_accepted() -> None:
    found = weighed(50_000.0, [fitted(300.0, "stribeck_friction"), fitted(40_000.0, "cogging_torque")])
    assert found.accepted == ("stribeck_friction",)
    assert found.probability["stribeck_friction"] > 0.99 and found.probability["cogging_torque"] < 0.01 and found.unnamed < 0.01


def test_nothing_is_accepted_where_noise_is_all_that_is_left() -> None:
    found = weighed(0.0, [fitted(-12.0, "stribeck_friction"), fitted(-3.0, "cogging_torque")])
    assert found.accepted == () and found.unnamed < 0.02


def test_a_little_more_than_noise_is_the_model_and_no_cause() -> None:
    # a tenth more than noise in squares: a model by its data sheet is trusted no further
    found = weighed(4_000.0, [fitted(3_800.0, "stribeck_friction")])
    assert found.accepted == () and found.unnamed < 0.1


def test_what_no_set_explains_is_unnamed() -> None:
    found = weighed(4e6, [fitted(3.9e6, "stribeck_friction"), fitted(3.8e6, "cogging_torque")])
    assert found.accepted == () and found.unnamed > 0.99


def test_of_two_that_explain_alike_the_first_is_accepted_in_the_name_of_both() -> None:
    found = weighed(50_000.0, [fitted(300.0, "stribeck_friction"), fitted(310.0, "directional_stribeck")])
    shares = [found.probability[name] for name in ("stribeck_friction", "directional_stribeck")]
    assert found.accepted == ("stribeck_friction",) and min(shares) > 0.2 and sum(shares) == pytest.approx(1.0, abs=0.01)


def test_both_of_a_pair_are_accepted_and_a_needless_third_is_not() -> None:
    pair = fitted(300.0, "stribeck_friction", "cogging_torque")
    alone = [fitted(20_000.0, "stribeck_friction"), fitted(25_000.0, "cogging_torque")]
    assert set(weighed(50_000.0, [*alone, pair]).accepted) == {"stribeck_friction", "cogging_torque"}
    needless = fitted(19_950.0, "stribeck_friction", "cogging_torque")
    assert weighed(50_000.0, [fitted(20_000.0, "stribeck_friction"), needless]).probability["cogging_torque"] < 0.2


def test_a_slight_further_cause_is_the_form_of_a_large_one() -> None:
    def accepted(beyond: float) -> set[str]:
        first, both = fitted(beyond, "stribeck_friction"), fitted(0.0, "stribeck_friction", "cogging_torque")
        return set(posterior(BESIDE_HEALTHY, fitted(50_000.0), [first, both]).accepted)

    # of what the first explains, in squares, two thousandths lie within the error of its form and a tenth does not
    assert accepted(100.0) == {"stribeck_friction"} and accepted(5_000.0) == {"stribeck_friction", "cogging_torque"}


def test_beside_baseline_records_chance_is_no_discrepancy() -> None:
    def probability(gain: float, level: float) -> float:
        return posterior(BESIDE_HEALTHY, fitted(level), [fitted(level - gain, "cogging_torque")]).probability["cogging_torque"]

    # what an effect takes off counts the same where the noise of the whole record is a little more or less
    for level in (-300.0, 0.0, 400.0):
        assert probability(12.0, level) < 0.2 and probability(60.0, level) > 0.9


def test_probabilities_do_not_depend_on_the_order_of_the_sets() -> None:
    sets = [fitted(300.0, "stribeck_friction"), fitted(305.0, "directional_stribeck"), fitted(9_000.0, "cogging_torque")]
    one, other = weighed(20_000.0, sets), weighed(20_000.0, sets[::-1])
    assert one.probability == pytest.approx(other.probability) and one.accepted == other.accepted


def test_nuisance_parameters_are_best_where_data_and_priors_together_cost_least() -> None:
    random = np.random.default_rng(3)
    root = random.normal(size=(4, 3))
    curvature = root.T @ root + np.eye(3)
    best, least, square = np.array([2.0, -1.0, 4.0]), 100.0, 30.0
    rates, axes = np.linalg.eigh(curvature)
    nuisance = Nuisance(least, axes.T @ best, axes, rates, ())

    def cost(values: Reals) -> float:
        data = least + float((values - best) @ curvature @ (values - best)) - float(values @ values)
        return data / square + float(values @ values)

    data, own = nuisance.costs(square)
    assert data / square + own == pytest.approx(optimize.minimize(cost, np.zeros(3), tol=1e-12).fun, rel=1e-9)
    assert sum(nuisance.costs(1.0)) == pytest.approx(least)


def test_a_distance_from_the_data_sheet_costs_less_where_its_scale_is_not_known() -> None:
    far = np.array([9.0])
    own = Nuisance(0.0, far, np.eye(1), np.array([1e6]), (Scale([0], 4.0, 1.0),)).costs(1.0)[1]
    assert own < 0.25 * float(far @ far)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        (RISE, 0.0, 20.0),
        ("effects.coulomb_asymmetry.asymmetry", -5.0, 5.0),
        ("effects.cogging_torque.phase_rad", -math.pi, math.pi),
        ("screw.csj_Nm", -2.0, 2.0),
    ],
)
def test_priors_are_densities(name: str, low: float, high: float) -> None:
    actuator = reference_actuator()
    whole = integrate.quad(lambda value: math.exp(value_prior(actuator, name, value, 2.0, 5.0).log_density), low, high, limit=200)[0]
    assert whole == pytest.approx(1.0, abs=1e-3)


def test_what_nearly_every_machine_has_is_more_probable_beforehand() -> None:
    own, pair = (log_odds(causes, False) for causes in (("cogging_torque",), ("cogging_torque", "jam_spot")))
    assert log_odds(("presliding",), False) > log_odds(("csj",), False) > own > pair
    # what it has is in its baseline records
    assert log_odds(("presliding",), True) == own and log_odds((), True) == 0.0


def test_noise_is_what_goes_along_with_no_other_signal() -> None:
    random = np.random.default_rng(5)
    rows, keeps, slow = 10_000, 0.95, 0.98
    shares, levels = np.array([1.0, -2.0, 0.5]), np.array([1.0, 0.1, 0.2])
    noise = levels[:, None] * random.normal(size=(3, rows))
    noise[0] = signal.lfilter([math.sqrt(1.0 - keeps**2)], [1.0, -keeps], noise[0])
    # what a model lacks, slow and much larger than the noise, is in all signals
    missing = 5.0 * signal.lfilter([1.0 - slow], [1.0, -slow], random.normal(size=rows))
    found = incoherent_power(noise + np.outer(shares, missing))
    turn = np.exp(-1j * np.linspace(0.0, np.pi, lines_of(rows)))
    own = np.outer(levels**2, np.ones(turn.size))
    own[0] = (1.0 - keeps**2) / np.abs(1.0 - keeps * turn) ** 2
    common = 25.0 * (1.0 - slow) ** 2 / np.abs(1.0 - slow * turn) ** 2
    assert found.shape == own.shape
    for place in range(3):
        # the others tell what is common only as well as their own noise lets them
        others = [other for other in range(3) if other != place]
        doubt = 1.0 / (1.0 / common + np.sum(shares[others, None] ** 2 / own[others], axis=0))
        expected = own[place] + shares[place] ** 2 * doubt
        # the lowest band has about sixty independent values: three standard deviations of their mean
        for first in (40, 80, 160, 320, 640, 1280, 2500):
            band = slice(first, 2 * first)
            assert np.mean(found[place, band]) == pytest.approx(float(np.mean(expected[band])), rel=0.4)


def test_two_signals_that_are_the_same_have_no_noise() -> None:
    once = np.random.default_rng(6).normal(size=4_000)
    assert np.all(incoherent_power(np.array([once, once])) < 1e-3)


@pytest.mark.slow
@pytest.mark.skipif(not HAS_NUMBA, reason="the simulator takes minutes a record without Numba")
def test_a_machine_with_another_contact_and_lasting_noise_is_told_as_what_it_is_without_baseline_records() -> None:
    found = diagnosed(reference_actuator(), record_of(simulator.record(3, (3, 0), {}), 0))
    accepted = [one for one in found["effects"] if one["accepted"]]
    assert found["verdict"] == "missing" and [one["name"] for one in accepted] == ["presliding"]
    assert accepted[0]["probability"] > 0.9 and found["unnamed"] < 0.1
    assert "probability over 99 %" in found["sentence"] or "probability 9" in found["sentence"]
    assert "no defect" in found["sentence"]
