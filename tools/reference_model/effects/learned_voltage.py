"""A voltage that was learned against one axis: gain * table(axis)."""

from typing import Any

from ema_tools.base.compiled import compiled
from reference_model.point import Point
from reference_model.table import value

_NODES = (
    0.399558,
    0.398799,
    0.396744,
    0.39121,
    0.37655,
    0.339313,
    0.25406,
    0.097967,
    -0.097967,
    -0.25406,
    -0.339313,
    -0.37655,
    -0.39121,
    -0.396744,
    -0.398799,
    -0.399558,
)
EXAMPLE = {"gain": 1.0, "axis": 4.0, "first": -3.0, "last": 3.0, **{f"node_{k:02d}": node for k, node in enumerate(_NODES)}}


@compiled
def voltage_change_V(effect: Any, point: Point) -> float:
    """Change of the motor voltage."""
    return value(effect, point)
