"""What dry friction of a healthy machine should be today: how much it scatters from run to run, and what temperature does to it, by healthy runs and by today's winding and grease.

Winding and grease are thermometers that are there anyway: copper by its constant, grease by the usual fall of its viscosity. What a degree does to friction differs from screw to screw in size and
in sign, so the healthy runs have to show it; what they do not show stays open. How many times the usual a machine scatters is as unknown beforehand, and three runs hardly tell it: every factor
counts by how well friction and the two thermometers' disagreement of all runs fit it, so that an interval of few runs is as wide as it has to be (a Bayesian mixture; A. Gelman et al., Bayesian Data
Analysis, 3rd ed., 2013, ch. 3 and 5).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import optimize, special

from ema_tools.base.arrays import Reals

COPPER_PER_DEGC = 0.00393  # IEC 60028 [physics]
GREASE_PER_DEGC = 0.028  # a grease loses half of its viscosity in about 25 degC near room temperature [physics]
FRICTION_PER_DEGC = 0.005  # of dry friction, one standard deviation about none: greases and seals differ in sign as well [physics]
_FACTOR_SPREAD = 1.2  # of the logarithm of how many times the usual a machine scatters: four times it is no surprise [judgement]
_FACTORS = np.exp(np.linspace(math.log(0.3), math.log(15.0), 40))  # that are tried [precision]
_AGREE = 3.0  # standard deviations by which winding and grease may disagree of a temperature: farther apart, one of them is changed by something else [chance]
_NORMAL_95 = 1.96


@dataclass(frozen=True)
class Foretold:
    """Dry friction of today's healthy machine over the mean of its healthy runs, less 1: a mixture of normal distributions, one for each factor of the scatter.

    `weights`, `means`, `stds`: of the mixture, [factors]; `by_temperature`: how uncertain what the temperature does to it is, one standard deviation.
    """

    weights: Reals
    means: Reals
    stds: Reals
    by_temperature: float

    @cached_property
    def shift(self) -> float:
        """What is to be expected."""
        return float(self.weights @ self.means)

    def within(self, share: float) -> float:
        """How far above what is to be expected a healthy machine lies with a chance of no more than 1 - `share`."""

        def above(far: float) -> float:
            return float(self.weights @ special.ndtr((self.shift + far - self.means) / self.stds)) - share

        most = 20.0 * float(np.max(self.stds))
        return float(optimize.brentq(above, 0.0, most)) if above(0.0) < 0.0 < above(most) else 0.0

    @cached_property
    def std(self) -> float:
        """The standard deviation whose normal 95 % interval is as wide as this one's."""
        return self.within(special.ndtr(_NORMAL_95)) / _NORMAL_95


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
        runs = self.friction.size
        warmth, disagree = self._temperature(self.winding, self.grease)
        warmth, disagree = warmth - np.mean(warmth), disagree - np.mean(disagree)
        warmer, apart = (float(one) for one in self._temperature(winding, grease))
        off = self.friction - np.mean(self.friction)
        factors = _FACTORS**2
        own = factors * self.usual[0] ** 2 + self.noise**2
        # what a degree does to friction, for each factor: the mean and the variance that the runs leave
        slope_variance = 1.0 / (FRICTION_PER_DEGC**-2.0 + float(warmth @ warmth) / own)
        slope = slope_variance * float(warmth @ off) / own
        fits = -0.5 * (runs - 1) * np.log(own) - 0.5 * (float(off @ off) / own - slope**2 / slope_variance) + 0.5 * np.log(slope_variance)
        fits += -0.5 * (runs - 1) * np.log(factors) - 0.5 * float(disagree @ disagree) / factors
        fits -= 0.5 * (np.log(_FACTORS) / _FACTOR_SPREAD) ** 2
        weights = np.exp(fits - np.max(fits))
        weights /= np.sum(weights)
        widened = 1.0 + 1.0 / runs
        if abs(apart) > _AGREE * math.sqrt(float(weights @ factors) * widened):
            warmer = 0.0
        read = factors * widened * self._reading_variance
        by_slope = warmer**2 * slope_variance + (slope**2 * read if warmer else 0.0)
        return Foretold(
            weights, slope * warmer, np.sqrt(own * widened + by_slope), math.sqrt(float(weights @ (warmer**2 * slope_variance)))
        )

    @property
    def _thermometers(self) -> tuple[float, float]:
        """Variances of what winding and grease say of the temperature, degC^2, where they scatter as usual."""
        return (self.usual[1] / COPPER_PER_DEGC) ** 2, (self.usual[2] / GREASE_PER_DEGC) ** 2

    @property
    def _reading_variance(self) -> float:
        by_winding, by_grease = self._thermometers
        return 1.0 / (1.0 / by_winding + 1.0 / by_grease)

    def _temperature(self, winding: Reals | float, grease: Reals | float) -> tuple[Reals, Reals]:
        """By how much it is warmer than the mean, in degC, and how far the two disagree of it, in usual standard deviations."""
        by_winding = np.asarray(winding) / COPPER_PER_DEGC
        by_grease = -np.log1p(np.maximum(np.asarray(grease), -0.99)) / GREASE_PER_DEGC
        first, second = self._thermometers
        warmer = (by_winding / first + by_grease / second) * self._reading_variance
        return warmer, (by_winding - by_grease) / math.sqrt(first + second)


def of_runs(
    friction: Sequence[float], winding: Sequence[float], grease: Sequence[float], usual: tuple[float, float, float], noise: float
) -> HealthyFriction:
    """The same of readings in their own units, all above zero; `usual` and `noise` relative."""

    def shares(values: Sequence[float]) -> Reals:
        return np.asarray(values, dtype=np.float64) / float(np.mean(values)) - 1.0

    return HealthyFriction(shares(friction), shares(winding), shares(grease), usual, noise)
