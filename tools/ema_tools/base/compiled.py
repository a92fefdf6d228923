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


def compiled(function: Function) -> Function:
    """`function`, compiled when Numba is there."""
    return numba.njit(function) if HAS_NUMBA else function


def kept(package: Path, *decided_by: str) -> Callable[[Function], Function]:
    """Like `compiled`, and kept for the next process beside the sources of `package`; `decided_by`: what else the compiled code depends on."""
    if not HAS_NUMBA:
        return compiled
    # Numba looks at the file of a function alone: another folder as soon as any source changes
    sources = (path.read_bytes() for path in sorted(package.rglob("*.py")))
    digest = hashlib.sha256(b"\0".join((*sources, *(text.encode() for text in decided_by)))).hexdigest()
    folder = str(package / "__pycache__" / f"numba-{digest[:16]}")

    def keep(function: Function) -> Function:
        before = numba.config.CACHE_DIR
        numba.config.CACHE_DIR = folder
        try:
            made: Function = numba.njit(cache=True)(function)
        finally:
            numba.config.CACHE_DIR = before
        return made

    return keep
