"""The result of `ema map`."""

from __future__ import annotations

from ema_tools.compare.friction_map import FrictionMap
from ema_tools.results import friction_map as result
from ema_tools.results.parts import Provenance
from ema_tools.words.sentences.friction_map import sentence


def friction_map(found: FrictionMap, actuator: str, provenance: Provenance) -> result.MapResult:
    """The map as it is written."""
    points = tuple(
        result.MapPointEntry(
            one.speed_rad_s,
            one.torque_Nm,
            one.torque_Nm - one.swing_Nm,
            one.torque_Nm + one.swing_Nm,
            one.interval,
            one.model_Nm,
            one.runs,
            one.seconds,
            one.files,
        )
        for one in found.points
    )
    return result.MapResult(
        "map",
        found.records[0].file,
        actuator,
        tuple(record.file for record in found.records),
        sentence(found),
        found.runs,
        points,
        tuple(result.BothWays(one.speed_rad_s, one.friction_Nm, one.load_Nm) for one in found.pairs),
        dict(found.left_out),
        provenance,
    )
