"""Friction over the motor's speed: of a diagnosis the torque without inertia, of a map the runs at constant speed; beside each the model, or the healthy runs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ema_tools.results.addition import Addition
from ema_tools.results.localisation import BinsEntry
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.results import Mapped
from ema_tools.words.plots.style import AFTER, BEFORE, MEASURED, figure, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MIDDLE = (0.5, 99.5)  # percentiles of the samples that are shown [layout]
_OTHER = {"healthy": "baseline runs", "model": "model"}


def torque_picture(result: Diagnosed) -> Figure | None:
    """Torque without inertia over speed; None where the result has none."""
    found = None if isinstance(result.found, Addition) else result.found.where.pictures.torque_speed
    if found is None or not found.points.x:
        return None
    made = figure(f"{result.name}: friction over speed", 4.6)
    axes = made.subplots()
    speed, torque = np.asarray(found.points.x), np.asarray(found.points.y)
    axes.plot(speed, torque, ".", color=MEASURED, markersize=2.5, alpha=0.6, label="samples", rasterized=True)
    for entry, colour, style, said in (
        (found.expected, AFTER, (0, (5, 1.5)), _OTHER[found.other]),
        (found.measured, BEFORE, "-", "this record"),
    ):
        if entry is not None:
            _line(axes, entry, colour, style, said)
    axes.set_ylim(*np.percentile(torque, _MIDDLE) * 1.15)
    titled(
        axes, "Mean, and band of one standard deviation", f"Speed of the motor, {found.axis_unit}", f"Torque without inertia, {found.unit}"
    )
    made.legend(loc="outside lower left", ncols=3)
    return made


def _line(axes: Axes, entry: BinsEntry, colour: str, style: object, said: str) -> None:
    axes.fill_between(entry.center, entry.low, entry.high, color=colour, alpha=0.15, linewidth=0)
    axes.plot(entry.center, entry.mean, color=colour, linestyle=style, linewidth=2.0, label=said)


def map_picture(result: Mapped) -> Figure:
    """Runs at constant speed, both directions."""
    made = figure(result.title, 4.6)
    axes = made.subplots()
    for place, side in enumerate((-1.0, 1.0)):
        here = [one for one in result.found.points if one.speed_rad_s * side > 0.0]
        speed = [one.speed_rad_s for one in here]
        axes.fill_between(speed, [one.low_Nm for one in here], [one.high_Nm for one in here], color=BEFORE, alpha=0.15, linewidth=0)
        axes.plot(speed, [one.torque_Nm for one in here], "o-", color=BEFORE, markersize=5, label="measured" if place else None)
        axes.plot(
            speed, [one.model_Nm for one in here], color=AFTER, linestyle=(0, (5, 1.5)), linewidth=1.8, label="model" if place else None
        )
    titled(
        axes,
        "Runs at constant speed: mean, and band of one standard deviation",
        "Speed of the motor, rad/s",
        "Torque at the motor shaft, inertia taken off, Nm",
    )
    made.legend(loc="outside lower left", ncols=2)
    return made
