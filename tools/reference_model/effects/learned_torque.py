"""A torque that was learned against one axis: gain * table(axis)."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point
from reference_model.table import value

_NODES = (
    0.007788,
    0.019902,
    0.026533,
    0.025656,
    0.018421,
    0.008382,
    -0.000481,
    -0.005803,
    -0.007788,
    -0.008588,
    -0.010533,
    -0.014343,
    -0.018421,
    -0.019695,
    -0.015519,
    -0.005511,
)
EXAMPLE = {"gain": 1.0, "axis": 3.0, "first": 0.0, "last": 5.890486225480862, **{f"node_{k:02d}": node for k, node in enumerate(_NODES)}}


@compiled
def torque_Nm(effect: Any, point: Point) -> float:
    """Torque on the shaft."""
    return value(effect, point)
