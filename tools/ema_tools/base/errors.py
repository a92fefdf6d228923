"""What goes wrong because of an input: one line that names the offender and says what to do next."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

Result = TypeVar("Result")


class InputError(ValueError):
    """A bad input: the message is one line with file, row and field where they exist, and the next step.

    The command line prints it and ends with exit code 1.
    """


class MissingSignal(ValueError):
    """A result cannot be had because a signal is not recorded; the message is the reason."""


class LibraryError(RuntimeError):
    """The shared library is absent or does not fit these tools; the message says what to do."""


def taken(found: Iterable[Result | InputError]) -> list[Result]:
    """Results in whose place an error may stand. Raises the first of those."""
    results = []
    for one in found:
        if isinstance(one, InputError):
            raise one
        results.append(one)
    return results
