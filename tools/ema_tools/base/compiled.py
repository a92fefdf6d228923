"""Compilation of the inner loops: Numba where it is installed, plain Python where it is not. Same results either way.

Numba keeps IEEE arithmetic in the order written (no fast-math, no contraction), and the models compiled by it call no
library's sine or exponential, so results have the same bits with and without it and on every machine.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Function = TypeVar("Function", bound=Callable[..., object])

try:
    import numba
except ImportError:  # a model then runs some hundred times slower
    HAS_NUMBA = False
else:
    HAS_NUMBA = not numba.config.DISABLE_JIT


def _kept_of_these_sources() -> str:
    """The folder of what has been compiled for the truth plant; another one as soon as any of its sources changes, since Numba looks at the file of a function alone."""
    package = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for path in sorted((package / "truth").rglob("*.py")):
        digest.update(path.read_bytes())
    return str(package / "__pycache__" / f"numba-{digest.hexdigest()[:16]}")


if HAS_NUMBA:
    numba.config.CACHE_DIR = _kept_of_these_sources()


def compiled(function: Function) -> Function:
    """`function`, compiled when Numba is there."""
    return numba.njit(function) if HAS_NUMBA else function


def kept_compiled(function: Function) -> Function:
    """The same for the truth plant, whose functions are handed no other function: what is compiled is kept for the next process."""
    return numba.njit(cache=True)(function) if HAS_NUMBA else function
