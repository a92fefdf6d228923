"""An error of the rod sensor that was learned against one axis: the sensor reads x + gain * table(axis)."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point
from reference_model.table import value

_NODES = (
    0.0,
    0.003827,
    0.007071,
    0.009239,
    0.01,
    0.009239,
    0.007071,
    0.003827,
    0.0,
    -0.003827,
    -0.007071,
    -0.009239,
    -0.01,
    -0.009239,
    -0.007071,
    -0.003827,
)
EXAMPLE = {
    "gain": 1.0,
    "axis": 2.0,
    "first": 0.0,
    "last": 4.6875,
    **{f"node_{k:02d}": node for k, node in enumerate(_NODES)},
    "encoder.side": 1,
}


@compiled
def reading_mm(effect: Any, point: Point) -> float:
    """What the rod sensor reads on top."""
    return value(effect, point)
