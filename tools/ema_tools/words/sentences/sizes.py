"""Values with their errors and units."""

from __future__ import annotations

import math

from ema_tools.base.interval import interval95
from ema_tools.data.actuator import row_of


def ends_text(low: float | None, high: float | None) -> str:
    """An interval with two digits of its width, as in `0.297 .. 0.303`; a dash where there is none."""
    if low is None or high is None:
        return "-"
    width, largest = high - low, max(abs(low), abs(high))
    digits = 4 if not width > 0.0 else max(2, math.ceil(math.log10(largest / width)) + 2)
    return f"{low:.{digits}g} .. {high:.{digits}g}"


def size_text(name: str, value: float, std: float | None) -> str:
    """A value with its 95 % interval and unit, as in `0.31 Nm [95 %: 0.27 .. 0.35]`."""
    unit = row_of(name).unit
    doubt = f" [95 %: {ends_text(*interval95(value, std))}]" if std is not None and math.isfinite(std) else ""
    return f"{value:.4g}{' ' + unit if unit else ''}{doubt}"
