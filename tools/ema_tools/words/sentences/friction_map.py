"""What `ema map` says."""

from __future__ import annotations

import math

import numpy as np

from ema_tools.compare.friction_map import FrictionMap


def rpm(speed_rad_s: float) -> float:
    """Turns per minute of the motor."""
    return speed_rad_s * 60.0 / (2.0 * math.pi)


def sentence(found: FrictionMap) -> str:
    """What was mapped, and what friction is like."""
    count = len(found.records) - len(found.left_out)
    speeds = [abs(one.speed_rad_s) for one in found.points]
    text = (
        f"{found.runs} run{'s' if found.runs > 1 else ''} at constant speed in {count} record{'s' if count > 1 else ''},"
        f" {min(speeds):.3g} to {max(speeds):.3g} rad/s ({rpm(min(speeds)):.3g} to {rpm(max(speeds)):.3g} rpm) of the motor"
    )
    if found.left_out:
        text += f"; {len(found.left_out)} record{'s' if len(found.left_out) > 1 else ''} without any"
    if not found.pairs:
        return f"{text}. No speed was run in both directions, so that friction and load are not told apart."
    least = min(found.pairs, key=lambda one: one.friction_Nm)
    first = found.pairs[0]
    load = float(np.mean([one.load_Nm for one in found.pairs]))
    text += f". Friction is {first.friction_Nm:.3g} Nm at the slowest speed that was run both ways, {rpm(first.speed_rad_s):.3g} rpm"
    if least is not first:
        text += f", and least at {rpm(least.speed_rad_s):.3g} rpm with {least.friction_Nm:.3g} Nm"
    return f"{text}; the load against extension is {load:.3g} Nm on the mean."
