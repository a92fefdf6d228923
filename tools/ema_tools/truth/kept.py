"""Compilation that is kept for the next process: the truth plant's functions are handed no other function, so that Numba can."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ema_tools.base.compiled import HAS_NUMBA, Function

if HAS_NUMBA:
    import numba

    # Numba looks at the file of a function alone: another folder as soon as any source of the plant changes
    _digest = hashlib.sha256(b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.rglob("*.py"))))
    numba.config.CACHE_DIR = str(Path(__file__).parent / "__pycache__" / f"numba-{_digest.hexdigest()[:16]}")


def kept_compiled(function: Function) -> Function:
    """`function`, compiled when Numba is there, and kept."""
    return numba.njit(cache=True)(function) if HAS_NUMBA else function
