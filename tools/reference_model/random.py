"""PCG32, variant XSH-RR 64/32, in whole numbers of Python.

Source: M. E. O'Neill, PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random Number
Generation, HMC-CS-2014-0905 (2014); start values and check values as in its demonstration program (seed 42, stream 54).
"""

from __future__ import annotations

_MULTIPLIER = 6364136223846793005
_MASK = (1 << 64) - 1


class Pcg32:
    """Random numbers of one seed on one stream."""

    def __init__(self, seed: int, stream: int) -> None:
        self.increment = ((stream << 1) | 1) & _MASK
        self.state = 0
        self._advance()
        self.state = (self.state + seed) & _MASK
        self._advance()

    def _advance(self) -> None:
        self.state = (self.state * _MULTIPLIER + self.increment) & _MASK

    def u32(self) -> int:
        """The next 32 random bits."""
        old = self.state
        self._advance()
        shifted = (((old >> 18) ^ old) >> 27) & 0xFFFFFFFF
        turn = old >> 59
        return ((shifted >> turn) | (shifted << ((-turn) & 31))) & 0xFFFFFFFF
