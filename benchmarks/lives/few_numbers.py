"""Even wear, wear that feeds on itself and wear that stalls, as what a few numbers of 0 .. 1 come to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.lives.histories import FADES, FED, GREASES, LENGTHS, LIMIT, ONSETS, POWERS, STALLS
from benchmarks.lives.posterior import between
from ema_tools.base.arrays import Reals

_ROUNDS = 2  # in which grease and end are made to agree [precision]
_BEYOND = 1e-6  # least of what a power with a pole is taken of [layout]
_NEAR_ONE = 1e-4  # powers nearer to 1 are taken as so near [layout]


@dataclass(frozen=True)
class FewNumbers:
    """What points of the unit cube [draws, numbers] come to: onset, length, further numbers of the kind, grease."""

    kind: str
    stalls: int
    greased: bool

    @property
    def numbers(self) -> int:
        """So many there are of it."""
        return 2 + (self.kind == "feeding") + 2 * self.stalls + 2 * self.greased

    def grease(self, cube: Reals, days: Reals) -> Reals:
        """What running in takes away by `days` [1 or draws, days], [draws, days]."""
        if not self.greased:
            return np.zeros((cube.shape[0], days.shape[1]))
        return between(GREASES, cube[:, -2:-1]) * -np.expm1(-days / between(FADES, cube[:, -1:]))

    def stalled(self, cube: Reals) -> tuple[Reals, Reals]:
        """Begin and end of the stalls in days since the onset, in order and apart, [draws, stalls]."""
        length = between(LENGTHS, cube[:, 1])
        begin, lasts = (length[:, None] * between(STALLS, cube[:, 2 + k : 2 + 2 * self.stalls : 2]) for k in (0, 1))
        end = begin + lasts
        order = np.argsort(begin, axis=1)
        begin, end = np.take_along_axis(begin, order, 1), np.take_along_axis(end, order, 1)
        if self.stalls == 2:
            begin[:, 1] = np.maximum(begin[:, 1], end[:, 0])
            end[:, 1] = np.maximum(end[:, 1], begin[:, 1])
        return begin, end

    def wear(self, cube: Reals, days: Reals) -> Reals:
        """In %, [draws, days]."""
        gone = np.maximum(days[None, :] - between(ONSETS, cube[:, :1]), 0.0)
        length = between(LENGTHS, cube[:, 1:2])
        if self.kind == "feeding":
            wear = _fed(gone / length, between(POWERS, cube[:, 2:3]))
        else:
            own = gone
            if self.stalls:
                begin, end = self.stalled(cube)
                own = gone - sum(np.clip(gone - begin[:, k : k + 1], 0.0, (end - begin)[:, k : k + 1]) for k in range(self.stalls))
            wear = LIMIT * own / length
        return wear - self.grease(cube, days[None, :])

    def end(self, cube: Reals, now: float) -> Reals:
        """Day on which the limit is reached, [draws]; the grease as it is then."""
        length = between(LENGTHS, cube[:, 1])
        onset = between(ONSETS, cube[:, 0])
        end = np.full(cube.shape[0], now)
        for _ in range(_ROUNDS):
            wear = LIMIT + self.grease(cube, end[:, None])[:, 0]
            if self.kind == "feeding":
                own = length * _fed_after(wear, between(POWERS, cube[:, 2]))
            else:
                own = length * wear / LIMIT
                if self.stalls:
                    begin, stop = self.stalled(cube)
                    for k in range(self.stalls):
                        own = np.where(begin[:, k] < own, own + stop[:, k] - begin[:, k], own)
            end = onset + own
        return end


def _fed(gone: Reals, power: Reals) -> Reals:
    """Wear of d wear = C (1 + wear / FED)^power that is at the limit after 1, in closed form."""
    rest = _not_one(power)
    inner = 1.0 + gone * ((1.0 + LIMIT / FED) ** rest - 1.0)
    return FED * (np.maximum(inner, _BEYOND) ** (1.0 / rest) - 1.0)


def _fed_after(wear: Reals, power: Reals) -> Reals:
    """The time after which it is `wear`."""
    rest = _not_one(power)
    return ((1.0 + wear / FED) ** rest - 1.0) / ((1.0 + LIMIT / FED) ** rest - 1.0)


def _not_one(power: Reals) -> Reals:
    rest = 1.0 - power
    return np.where(np.abs(rest) < _NEAR_ONE, _NEAR_ONE, rest)
