"""Compilation that is kept for the next process: the truth plant's functions are handed no other function, so that Numba can."""

from __future__ import annotations

from pathlib import Path

from ema_tools.base.compiled import kept

kept_compiled = kept(Path(__file__).parent)
