"""Ctrl-C: one line and exit code 130, whatever it meets. While modules are loaded an exception would be a traceback, or vanish in a module that is half loaded."""

from __future__ import annotations

import os
import signal
from types import FrameType


class Interrupted(BaseException):
    """Ctrl-C while a command works: no KeyboardInterrupt, for which the command line's library writes an empty line."""


def _end(_signal: int, _frame: FrameType | None) -> None:
    os.write(2, b"ema: interrupted\n")
    os._exit(130)


def _raise(_signal: int, _frame: FrameType | None) -> None:
    raise Interrupted


def _listens() -> bool:
    return signal.getsignal(signal.SIGINT) is not signal.SIG_IGN  # as in the background of a script


def end_at_once() -> None:
    """Before the work: nothing is half written, so that the process may just end."""
    if _listens():
        signal.signal(signal.SIGINT, _end)


def tidy_up() -> None:
    """During the work: an exception, so that what is half written is removed."""
    if _listens():
        signal.signal(signal.SIGINT, _raise)


def too_late() -> None:
    """After the work: the process ends by itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
