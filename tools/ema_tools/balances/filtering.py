"""The zero-phase filter through which every channel of a balance passes, and the decimation behind it.

A Butterworth filter of fourth order, as if forward and backward, before differences are taken; edges are dropped, and the result is decimated to the filter's band.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.balance import Balance
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.base.filters import butterworth, chebyshev, filtered, filtered_every, quick_length, shares_of

EDGE_S = 0.05  # time at both ends whose rows carry the filters' edges: 50 rows at 1 kHz, several periods of the highest cutoff [precision]
_BLUNT = 1.001  # slower than the rate at which the usual cutoff is its largest, but for rounding [precision]
_EDGE_ROWS_MIN = 10  # and at least one period of the usual cutoff, for slow records [precision]
_ORDER = 4  # of the filter; run both ways it falls by the eighth power [judgement]
_RATE_OVER_CUTOFF = 10  # rows per period of the cutoff: differences of rows are then derivatives to within 7 % at the cutoff [precision]
_DECIMATOR = (8, 0.05)  # order and ripple in dB of the filter before rows are left out: 1 % of ripple, nothing folds back [precision]
_WHOLE_BAND = 0.9  # of half the sample rate: a cutoff beyond takes nothing away [precision]
_DECIMATOR_SHARE = 0.8  # of the new half sample rate, where that filter begins to fall [precision]
_MEMORY = 100.0  # half periods of the cutoff after which either filter has forgotten a row, to 1e-7 [precision]
_CUTOFF_MAX_HZ = 100.0  # far above what moves an actuator's rod, below most sensor noise [judgement]


@functools.lru_cache(maxsize=32)
def _smoothing(rows: int, share: float) -> Reals:
    """Gains of the smoothing with a cutoff as share of half the sample rate, [rows - 1]."""
    return butterworth(shares_of(quick_length(rows, _MEMORY / share)), _ORDER, share)


@functools.lru_cache(maxsize=32)
def _decimation(rows: int, every: int) -> Reals:
    """Gains in front of a decimation, [rows - 1]."""
    return chebyshev(shares_of(quick_length(rows, _MEMORY * every / _DECIMATOR_SHARE, every)), *_DECIMATOR, _DECIMATOR_SHARE / every)


def smoothed(values: Reals, share: float, axis: int = -1) -> Reals:
    """Values along `axis` below a cutoff, as share of half their rate."""
    return filtered(values, _smoothing(values.shape[axis], share), axis)


def thinned(values: Reals, every: int, axis: int = -1) -> Reals:
    """Every n-th of the values along `axis`, what would fold back taken out before."""
    if every == 1:
        return values
    gains = _decimation(values.shape[axis], every)
    if gains.size % every:
        low = np.moveaxis(filtered(values, gains, axis), axis, 0)[::every]
        return np.ascontiguousarray(np.moveaxis(low, 0, axis))
    return np.ascontiguousarray(filtered_every(values, gains, every, axis))


@dataclass(frozen=True)
class Smoother:
    """The zero-phase filter of all channels and the decimation behind it."""

    period_s: float
    cutoff_hz: float

    @staticmethod
    def of(period_s: float) -> Smoother:
        """The usual one: a tenth of the sample rate, at most 100 Hz."""
        return Smoother(period_s, min(_CUTOFF_MAX_HZ, 1.0 / (_RATE_OVER_CUTOFF * period_s)))

    @property
    def blunts(self) -> bool:
        """Whether the records are so slow that the filter takes the edges of a reversal away, which what is compared with it must then lose as well."""
        return self.period_s > _BLUNT * 1.0 / (_RATE_OVER_CUTOFF * _CUTOFF_MAX_HZ)

    def as_seen(self, values: Reals) -> Reals:
        """A torque that was worked out row by row, as the filtered drive shows it, [rows] or [rows, k]."""
        return smoothed(values, self._share, 0) if self.blunts and values.any() else values

    @property
    def every(self) -> int:
        """Rows per decimated sample: its rate is the filter's cutoff."""
        return max(1, round(1.0 / (self.cutoff_hz * self.period_s)))

    @property
    def edge_rows(self) -> int:
        """Rows dropped at each end."""
        return max(_EDGE_ROWS_MIN, round(EDGE_S / self.period_s))

    @property
    def least_rows(self) -> int:
        """Rows of the shortest record that is worth filtering: half of it is left."""
        return 4 * self.edge_rows

    def smooth(self, values: Reals) -> Reals:
        """Without what lies above the cutoff, [rows]."""
        return smoothed(values, self._share)

    @property
    def _share(self) -> float:
        """The cutoff as share of half the sample rate."""
        return 2.0 * self.cutoff_hz * self.period_s

    def inner(self, values: NDArray[Any]) -> NDArray[Any]:
        """Without the edges, [rows - 2 edge_rows]."""
        return values[self.edge_rows : -self.edge_rows]

    def decimated(self, values: Reals) -> Reals:
        """Edges dropped, then low-passed below the new rate and every n-th row kept, [samples] or [samples, k] of [rows, k]. Raises MissingSignal for fewer than the least rows."""
        if len(values) < self.least_rows:
            raise MissingSignal(f"{len(values)} rows are too few for any filter, {self.least_rows} are needed")
        return thinned(self.inner(values), self.every, 0)

    def kept(self, values: NDArray[Any]) -> NDArray[Any]:
        """The rows at which `decimated` has its samples, without filtering, [samples]."""
        return self.inner(values)[:: self.every]


def coarse(balance: Balance, smoother: Smoother) -> Balance:
    """The balance at the mechanical one's rate, through the same filter: noise beyond it says nothing about an effect."""
    step = float(balance.time_s[1] - balance.time_s[0])
    every = round(smoother.period_s * smoother.every / step)
    if every <= 1 or balance.time_s.size < 4 * every:
        return balance
    share = 2.0 * smoother.cutoff_hz * step

    def kept(values: Reals) -> Reals:
        return thinned(smoothed(values, share) if share < _WHOLE_BAND else values, every)

    return replace(balance, time_s=balance.time_s[::every], measured=kept(balance.measured), residual=kept(balance.residual))


@functools.cache
def gain_of_noise(smoother: Smoother, derivatives: int) -> float:
    """What smoothing and differences make of white noise of unit standard deviation: the norm of their impulse response."""
    impulse = np.zeros(2 * round(10.0 / (smoother.cutoff_hz * smoother.period_s)) + 1)
    impulse[impulse.size // 2] = 1.0
    response = smoother.smooth(impulse)
    for _ in range(derivatives):
        response = np.gradient(response, smoother.period_s)
    if derivatives == 2 and smoother.every > 1:
        response = filtered(response, _decimation(response.size, smoother.every))
    return float(np.linalg.norm(response))
