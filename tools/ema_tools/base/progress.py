"""How long work tells how far it is."""

from __future__ import annotations

from collections.abc import Callable

# The share done, 0 to 1, and what is at work.
Report = Callable[[float, str], None]


def untold(_share: float, _text: str) -> None:
    """A report to nobody."""
