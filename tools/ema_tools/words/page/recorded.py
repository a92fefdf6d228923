"""The curves of a result as arrays, measured and simulated, for every part of the page."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.results import parts

Series: TypeAlias = Reals

CHANNELS = ("position_mm", "speed_mm_s", "current_A", "voltage_V")

# Rows on each side over which the slope of the position is taken where the speed is not recorded.
SLOPE_ROWS = 4


@dataclass(frozen=True)
class Curves:
    """Measured and simulated channels of one record, each an array of `rows` in the unit of its name.

    `models` holds `before` and `after` (identify) or `model` (compare).
    """

    start_s: float
    period_s: float
    measured: dict[str, Series]
    models: dict[str, dict[str, Series]]
    derived: frozenset[str] = frozenset()

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.measured["position_mm"])

    def channels(self) -> tuple[str, ...]:
        """Channels that the record and every model have, in the order of the page."""
        return tuple(name for name in CHANNELS if name in self.measured and all(name in model for model in self.models.values()))

    def rms(self, channel: str, model: str) -> float:
        """Rms of measured minus `model`, in the channel's unit."""
        error = self.measured[channel] - self.models[model][channel]
        return float(np.sqrt(np.mean(error * error)))


def fault(source: str, path: str, problem: str) -> InputError:
    """The error of a result's field."""
    return InputError(f"{source}: field {path} {problem}: write the result again with --json")


def curves_of(found: parts.CurvesEntry, source: str) -> Curves:
    """Curves as arrays, the speed derived where it is not recorded. Raises InputError for curves of unlike lengths."""
    if not found.period_s > 0.0:
        raise fault(source, "curves.period_s", "is not positive")
    rows = len(found.measured.position_mm)
    tables: dict[str, dict[str, Series]] = {}
    for key in ("measured", "model", "before", "after"):
        channels: parts.Channels | None = getattr(found, key)
        if channels is None:
            continue
        there = {name: values for name in CHANNELS if (values := getattr(channels, name)) is not None}
        for name, values in there.items():
            if len(values) != rows or not rows:
                raise fault(source, f"curves.{key}.{name}", f"has {len(values)} rows where measured.position_mm has {rows}")
        tables[key] = {name: np.asarray(values, dtype=np.float64) for name, values in there.items()}
    derived: frozenset[str] = frozenset()
    if "speed_mm_s" not in tables["measured"] and rows > 2 * SLOPE_ROWS:
        derived = frozenset(("speed_mm_s",))
        # The same filter for every curve, so that their difference is not the filter's.
        for table in tables.values():
            table["speed_mm_s"] = slope(table["position_mm"], found.period_s)
    measured = tables.pop("measured")
    return Curves(found.start_s, found.period_s, measured, tables, derived)


def slope(values: Series, period_s: float) -> Series:
    """Slope of the least-squares line through each row and its SLOPE_ROWS neighbours on both sides (fewer at the ends)."""
    offsets = np.arange(-SLOPE_ROWS, SLOPE_ROWS + 1, dtype=np.float64)
    weights = offsets / (period_s * float(np.sum(offsets * offsets)))
    inner = np.convolve(values, weights[::-1], mode="valid")
    ends = np.gradient(values, period_s)
    return np.concatenate((ends[:SLOPE_ROWS], inner, ends[-SLOPE_ROWS:]))
