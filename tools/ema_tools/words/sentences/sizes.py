"""Values with their errors and units."""

from __future__ import annotations

import math

from ema_tools.base.interval import interval95
from ema_tools.data.actuator import row_of
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits

MUCH_HIDDEN = 2.0  # of a threshold: an interval of a healthy answer that reaches farther beyond it is said [judgement]
_DECIMALS = 6  # of a number that is written without a power of ten [layout]
_WRITTEN = 1e6  # below which a number's places before the point are written [layout]


def significant(value: float, digits: int) -> str:
    """A number with so many significant digits, without a power of ten while it has few places before its point."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _WRITTEN else text


def ends_text(low: float | None, high: float | None) -> str:
    """An interval with two digits of its width, as in `0.297 .. 0.303`; a dash where there is none."""
    if low is None or high is None:
        return "-"
    width, largest = high - low, max(abs(low), abs(high))
    if not width > 0.0:
        return f"{low:.4g} .. {high:.4g}"
    decimals = 1 - math.floor(math.log10(width))
    if 0 <= decimals <= _DECIMALS:
        # no minus zero
        return f"{round(low, decimals) + 0.0:.{decimals}f} .. {round(high, decimals) + 0.0:.{decimals}f}"
    if decimals < 0 and largest < _WRITTEN:
        return f"{round(low, decimals) + 0.0:.0f} .. {round(high, decimals) + 0.0:.0f}"
    digits = max(2, math.floor(math.log10(largest)) + 1 + decimals)
    return f"{low:.{digits}g} .. {high:.{digits}g}"


def size_text(name: str, value: float, std: float | None, units: MachineUnits = TURNING) -> str:
    """A value with its 95 % interval and unit, as in `0.31 Nm [95 %: 0.27 .. 0.35]`."""
    value, unit = units.told(value, row_of(name).unit)
    std = units.told(std, row_of(name).unit)[0] if std is not None else None
    doubt = f" [95 %: {ends_text(*interval95(value, std))}]" if std is not None and math.isfinite(std) else ""
    return f"{value:.4g}{' ' + unit if unit else ''}{doubt}"
