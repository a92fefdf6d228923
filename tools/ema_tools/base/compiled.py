"""Compilation of the inner loops: Numba where it is installed, plain Python where it is not. Same results either way.

Numba keeps IEEE arithmetic in the order written (no fast-math, no contraction), and the models compiled by it call no
library's sine or exponential, so results have the same bits with and without it and on every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

Function = TypeVar("Function", bound=Callable[..., object])

try:
    import numba
except ImportError:  # a model then runs some hundred times slower
    HAS_NUMBA = False
else:
    HAS_NUMBA = not numba.config.DISABLE_JIT


def compiled(function: Function) -> Function:
    """`function`, compiled when Numba is there."""
    return numba.njit(function) if HAS_NUMBA else function
