"""Learned tables: gain * value against one axis, straight lines between 16 nodes.

Equations: docs/DESIGN.md, "Learned tables".
"""

from __future__ import annotations

import math
from typing import Any

from ema_tools.base.compiled import compiled
from ema_tools.library.definitions import TableAxis
from reference_model.elementary import TWO_PI
from reference_model.point import Point

_SPANS = 15
# Plain numbers, which compiled code takes.
_SPEED, _POSITION, _LEAD, _TURN = (float(axis) for axis in (TableAxis.SPEED, TableAxis.POSITION, TableAxis.LEAD, TableAxis.TURN))


@compiled
def _axis(effect: Any, point: Point) -> tuple[float, float]:
    """Where the point is on the axis of the table, and the period of the axis, 0 when it has none."""
    if effect.axis == _SPEED:
        return point.speed_rad_s, 0.0
    if effect.axis == _POSITION:
        return point.motor_mm, 0.0
    if effect.axis == _LEAD:
        return point.motor_mm, point.data.lead_mm
    if effect.axis == _TURN:
        return point.angle_rad, TWO_PI
    return point.current_A, 0.0


@compiled
def value(effect: Any, point: Point) -> float:
    """The table's value at `point`, in the unit of its nodes; outside `first` .. `last` the edge value, on a periodic axis the line that closes the round."""
    nodes = (
        effect.node_00, effect.node_01, effect.node_02, effect.node_03, effect.node_04, effect.node_05, effect.node_06, effect.node_07,
        effect.node_08, effect.node_09, effect.node_10, effect.node_11, effect.node_12, effect.node_13, effect.node_14, effect.node_15,
    )  # fmt: skip
    at, period = _axis(effect, point)
    if period > 0.0:
        at -= period * math.floor((at - effect.first) / period)
        closing = effect.first + period
        if at > effect.last:
            return effect.gain * (nodes[_SPANS] * (closing - at) + nodes[0] * (at - effect.last)) / (closing - effect.last)
    if at <= effect.first:
        return effect.gain * nodes[0]
    if at >= effect.last:
        return effect.gain * nodes[_SPANS]
    spans = _SPANS * (at - effect.first) / (effect.last - effect.first)
    left = min(int(spans), _SPANS - 1)
    share = spans - left
    return effect.gain * ((1.0 - share) * nodes[left] + share * nodes[left + 1])
