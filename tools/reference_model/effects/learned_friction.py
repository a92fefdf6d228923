"""Dry friction that was learned against one axis: level + gain * table(axis)."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point
from reference_model.table import value

_NODES = (
    0.01,
    0.01,
    0.010001,
    0.010012,
    0.010095,
    0.010549,
    0.012319,
    0.017108,
    0.025819,
    0.035564,
    0.04,
    0.035564,
    0.025819,
    0.017108,
    0.012319,
    0.010549,
)
EXAMPLE = {"gain": 1.0, "axis": 1.0, "first": -1.5, "last": 1.5, **{f"node_{k:02d}": node for k, node in enumerate(_NODES)}}


@compiled
def level_change_Nm(effect: Any, level_Nm: float, point: Point) -> float:
    """Change of the level of dry friction."""
    return value(effect, point)
