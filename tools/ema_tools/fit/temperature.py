"""What dry friction of a healthy machine should be today: how much it scatters from run to run, and what temperature does to it, by healthy runs and by today's winding and grease.

Winding and grease are thermometers that are there anyway: copper by its constant, grease by the usual fall of its viscosity. What a degree does to friction differs from screw to screw in size and
in sign, so the healthy runs have to show it; what they do not show stays open. How many times the usual a machine scatters is as unknown beforehand, and three runs hardly tell it: every factor
counts by how well friction and the two thermometers' disagreement of all runs fit it, so that an interval of few runs is as wide as it has to be (a Bayesian mixture; A. Gelman et al., Bayesian Data
Analysis, 3rd ed., 2013, ch. 3 and 5). So does every size of what a degree does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import optimize, special

from ema_tools.base.arrays import Reals
from ema_tools.fit.nuisance import COPPER_PER_DEGC, FRICTION_PER_DEGC, GREASE_PER_DEGC

_SLOPES = FRICTION_PER_DEGC * np.linspace(-3.0, 3.0, 49)  # that are tried [precision]
_FACTOR_SPREAD = 1.5  # of the logarithm of how many times the usual a machine scatters: four times it is no surprise [judgement]
_FACTORS = np.exp(np.linspace(math.log(0.3), math.log(15.0), 40))  # that are tried [precision]
_AGREE = 3.0  # standard deviations by which winding and grease may disagree of a temperature: farther apart, one of them is changed by something else [chance]
_DAYS_SPREAD = (
    1.8  # of the logarithm of how many times as far as usual days differ in temperature: a hangar, or a field in all weathers [judgement]
)
_DAYS_DEGC = np.exp(np.linspace(math.log(0.2), math.log(20.0), 24))  # that are tried [precision]
_HARDLY = 1e-6  # of the largest weight of a mixture [precision]
_NORMAL_95 = 1.96  # standard deviations within which 95 % of a normal distribution lie [chance]


@dataclass(frozen=True)
class Foretold:
    """Dry friction of today's healthy machine over the mean of its healthy runs, less 1: a mixture of normal distributions, one for each size of what is not known.

    `weights`, `means`, `stds`: of the mixture, [parts]; `by_temperature`: how uncertain what the temperature does to it is, one standard deviation.
    """

    weights: Reals
    means: Reals
    stds: Reals
    by_temperature: float

    @cached_property
    def shift(self) -> float:
        """What is to be expected."""
        return float(self.weights @ self.means)

    def beyond(self, far: float) -> float:
        """The chance that a healthy machine lies more than that above what is to be expected."""
        return float(self.weights @ special.ndtr((self.means - self.shift - far) / self.stds))

    def within(self, share: float) -> float:
        """How far above what is to be expected a healthy machine lies with a chance of no more than 1 - `share`."""

        def missing(far: float) -> float:
            return 1.0 - share - self.beyond(far)

        return float(optimize.brentq(missing, 0.0, 20.0 * float(np.max(self.stds)))) if missing(0.0) < 0.0 else 0.0

    @cached_property
    def std(self) -> float:
        """The standard deviation whose normal 95 % interval is as wide as this one's."""
        return self.within(special.ndtr(_NORMAL_95)) / _NORMAL_95


def _weights(fits: Reals) -> Reals:
    """How much each part counts by the logarithm of how well it fits."""
    shares = np.exp(fits - np.max(fits))
    return np.asarray(shares / np.sum(shares))


def _mixture(weights: Reals, means: Reals, variances: Reals, by_temperature: float) -> Foretold:
    """Of parts in arrays of one shape; what hardly counts is left out."""
    counts = weights > _HARDLY * np.max(weights)
    kept = weights[counts]
    return Foretold(kept / np.sum(kept), means[counts], np.sqrt(np.broadcast_to(variances, weights.shape)[counts]), by_temperature)


@dataclass(frozen=True)
class FrictionLaw:
    """What a degree makes of dry friction, for a module that reads winding and grease beside it.

    `per_degC` and its standard error `per_degC_std`: of a share of it; `std`: from run to run beside that; `winding_share`: of the winding in what both tell of the temperature; `apart_degC`:
    farther apart they tell none.
    """

    per_degC: float
    per_degC_std: float
    std: float
    winding_share: float
    apart_degC: float


@dataclass(frozen=True)
class HealthyFriction:
    """What the healthy runs of a machine say of it: friction, winding and grease as read on each run, over their means, less 1, [runs].

    `usual`: by how much each of the three scatters usually, relative; `noise`: of a reading of friction.
    """

    friction: Reals
    winding: Reals
    grease: Reals
    usual: tuple[float, float, float]
    noise: float

    def __post_init__(self) -> None:
        if min(self.friction.size, self.winding.size, self.grease.size) < 2 or min(self.usual) <= 0.0:
            raise ValueError("two runs or more, and values that scatter")

    def today(self, winding: float, grease: float) -> Foretold:
        """What friction should be on a day whose winding and grease are these, over the means of the healthy runs, less 1."""
        warmer, apart = (float(one) for one in self._temperature(winding, grease))
        warmer, apart = warmer - self._mean_warmth, apart - self._mean_apart
        factor = math.sqrt(float(np.sum(_weights(self._fits) * _FACTORS[:, None] ** 2)))
        if abs(apart) > _AGREE * factor * math.sqrt(self._widened):
            # one of them is changed by something else: it may be as warm as both allow, and nothing is foretold of it
            warmer, weights = self._both_allow(winding, grease), _weights(self._fits)
            return self._foretold(weights, np.zeros_like(weights), self._own[:, None] * self._widened + (warmer * _SLOPES) ** 2, warmer)
        # how far they disagree today tells of the scatter as that of any run
        weights = _weights(self._fits - 0.5 * apart**2 / (_FACTORS[:, None] ** 2 * self._widened) - np.log(_FACTORS)[:, None])
        return self._foretold(weights, np.broadcast_to(warmer * _SLOPES, weights.shape), self._of_a_run * self._widened, warmer)

    @staticmethod
    def _foretold(weights: Reals, means: Reals, variances: Reals, warmer: float) -> Foretold:
        """Of a day `warmer` degC above the healthy runs, by what each factor and slope says, [factors, slopes] each."""
        slope = float(np.sum(weights * _SLOPES))
        uncertain = math.sqrt(float(np.sum(weights * (_SLOPES - slope) ** 2)))
        return _mixture(weights, means, variances, abs(warmer) * uncertain)

    def _both_allow(self, winding: float, grease: float) -> float:
        """The temperature of the two that lies nearer to the healthy runs', in degC over it; none where they lie on either side."""
        today, runs = self._each(winding, grease), self._each(self.winding, self.grease)
        by_winding, by_grease = (float(one - np.mean(run)) for one, run in zip(today, runs, strict=True))
        return min(by_winding, by_grease, key=abs) if by_winding * by_grease > 0.0 else 0.0

    def any_day(self) -> Foretold:
        """The same on a day of which no thermometer tells: temperature is part of the scatter, as much as the healthy runs show of it."""
        weights, variance_degC = self._by_days
        variances = (self._own[:, None, None] + _SLOPES[:, None] ** 2 * variance_degC) * self._widened
        return _mixture(weights, np.zeros_like(weights), variances, 0.0)

    def any_told_day(self) -> Foretold:
        """How far it lies from what `law` foretells, on a day of which the thermometers tell: its temperature differs from the healthy runs' as far as those show."""
        weights, variance_degC = self._by_days
        variances = self._of_a_run[:, :, None] + ((_SLOPES[:, None] - self.law.per_degC) * np.sqrt(variance_degC)) ** 2
        return _mixture(weights, np.zeros_like(weights), variances * self._widened, 0.0)

    @cached_property
    def law(self) -> FrictionLaw:
        """What firmware needs to bring a reading to the temperature of the healthy runs."""
        weights = _weights(self._fits)
        by_factor, by_slope = weights.sum(axis=1), weights.sum(axis=0)
        slope = float(by_slope @ _SLOPES)
        at_mean = _mixture(weights, np.zeros_like(weights), self._of_a_run * self._widened, 0.0)
        by_winding, by_grease = self._thermometers
        usual_degC = _AGREE * math.sqrt(float(by_factor @ _FACTORS**2) * self._widened * (by_winding + by_grease))
        return FrictionLaw(
            per_degC=slope,
            per_degC_std=math.sqrt(float(by_slope @ (_SLOPES - slope) ** 2)),
            std=at_mean.std,
            winding_share=by_grease / (by_winding + by_grease),
            apart_degC=usual_degC,
        )

    @cached_property
    def _by_days(self) -> tuple[Reals, Reals]:
        """Weights of every factor, slope and size of the days' differences, [factors, slopes, sizes], and those sizes squared, degC^2."""
        warmth = self._warmth
        variance = _FACTORS[:, None] ** 2 * self._reading_variance + _DAYS_DEGC**2
        fits = -0.5 * (warmth.size - 1) * np.log(variance) - 0.5 * float(warmth @ warmth) / variance
        fits -= 0.5 * (np.log(_DAYS_DEGC / self._usual_day_degC) / _DAYS_SPREAD) ** 2
        return _weights(self._fits[:, :, None] + fits[:, None, :]), _DAYS_DEGC**2

    @cached_property
    def _fits(self) -> Reals:
        """Logarithm of how well each factor and each slope fits the runs, beside what is known of either beforehand, [factors, slopes]."""
        off = self.friction - np.mean(self.friction)
        lasting = self.friction.size - 1
        left = np.sum((off - _SLOPES[:, None] * self._warmth) ** 2, axis=1)
        fits = -0.5 * lasting * np.log(self._of_a_run) - 0.5 * left / self._of_a_run
        by_factor = -lasting * np.log(_FACTORS) - 0.5 * float(self._apart @ self._apart) / _FACTORS**2
        by_factor -= 0.5 * (np.log(_FACTORS) / _FACTOR_SPREAD) ** 2
        return np.asarray(fits + by_factor[:, None] - 0.5 * (_SLOPES / FRICTION_PER_DEGC) ** 2)

    @property
    def _of_a_run(self) -> Reals:
        """Variance of what is read of friction on a day whose temperature winding and grease tell, each as they scatter, [factors, slopes]."""
        return np.asarray(self._own[:, None] + _SLOPES**2 * _FACTORS[:, None] ** 2 * self._reading_variance)

    @property
    def _own(self) -> Reals:
        """Variance of what is read of friction at one temperature, [factors]."""
        return np.asarray((self.usual[0] * _FACTORS) ** 2 + self.noise**2)

    @property
    def _widened(self) -> float:
        """By how much the variance of a reading is larger against the mean of the runs than about the truth."""
        return 1.0 + 1.0 / self.friction.size

    @property
    def _mean_warmth(self) -> float:
        return float(np.mean(self._temperature(self.winding, self.grease)[0]))

    @property
    def _mean_apart(self) -> float:
        return float(np.mean(self._temperature(self.winding, self.grease)[1]))

    @property
    def _warmth(self) -> Reals:
        return np.asarray(self._temperature(self.winding, self.grease)[0] - self._mean_warmth)

    @property
    def _apart(self) -> Reals:
        return np.asarray(self._temperature(self.winding, self.grease)[1] - self._mean_apart)

    @property
    def _thermometers(self) -> tuple[float, float]:
        """Variances of what winding and grease say of the temperature, degC^2, where they scatter as usual."""
        return (self.usual[1] / COPPER_PER_DEGC) ** 2, (self.usual[2] / GREASE_PER_DEGC) ** 2

    @property
    def _reading_variance(self) -> float:
        by_winding, by_grease = self._thermometers
        return 1.0 / (1.0 / by_winding + 1.0 / by_grease)

    @property
    def _usual_day_degC(self) -> float:
        """By how much days differ where temperature is all that makes the winding scatter as usual."""
        return self.usual[1] / COPPER_PER_DEGC

    @staticmethod
    def _each(winding: Reals | float, grease: Reals | float) -> tuple[Reals, Reals]:
        """What winding and grease say of the temperature, each alone, in degC."""
        return np.asarray(winding) / COPPER_PER_DEGC, np.asarray(-np.log1p(np.maximum(grease, -0.99)) / GREASE_PER_DEGC)

    def _temperature(self, winding: Reals | float, grease: Reals | float) -> tuple[Reals, Reals]:
        """By how much it is warmer than the mean, in degC, and how far the two disagree of it, in usual standard deviations."""
        by_winding, by_grease = self._each(winding, grease)
        first, second = self._thermometers
        warmer = (by_winding / first + by_grease / second) * self._reading_variance
        return warmer, (by_winding - by_grease) / math.sqrt(first + second)


def of_runs(
    friction: Sequence[float], winding: Sequence[float], grease: Sequence[float], usual: tuple[float, float, float], noise: float
) -> HealthyFriction:
    """The same of readings in their own units, all above zero; `usual` and `noise` relative."""
    return HealthyFriction(_shares(friction), _shares(winding), _shares(grease), usual, noise)


def _shares(values: Sequence[float]) -> Reals:
    return np.asarray(values, dtype=np.float64) / float(np.mean(values)) - 1.0
