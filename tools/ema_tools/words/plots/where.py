"""Where the model fails: each equation's residual over the states of the machine, in multiples of its noise level; and, of a comparison, where the error sits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ema_tools.results.parts import Place
from ema_tools.words.page import heat, names
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.results import BALANCES, ShownComparison
from ema_tools.words.page.signals import traces
from ema_tools.words.page.text import number
from ema_tools.words.plots.style import AFTER, BEFORE, HEAT, INK, SOFT, figure, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PLACES_MAX = 12  # parts that are drawn, the most telling first [layout]


def where_picture(result: Diagnosed) -> Figure | None:
    """None where no equation was localised."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    drawn = heat.maps(result, traces(result.curves, result.found.curves))
    if not any(one.lights for one in drawn):
        return None
    scale = heat.levels(drawn)
    rows = (len(drawn) + 1) // 2
    made = figure(
        f"{result.name}: where the model fails, times the noise level", 1.3 + rows * (0.75 + 0.24 * max(len(one.rows) for one in drawn))
    )
    grid = made.subplots(rows, 2, squeeze=False)
    colours, norm = ListedColormap(list(HEAT)), BoundaryNorm([0.0, *scale, 10.0 * scale[-1]], len(HEAT))
    for axes in grid.flat[len(drawn) :]:
        axes.set_visible(False)
    mesh = None
    for axes, one in zip(grid.flat, drawn, strict=False):
        mesh = _map(axes, one, colours, norm)
    bar = made.colorbar(mesh, ax=grid, location="bottom", fraction=0.04, aspect=60, shrink=0.6, pad=0.03, ticks=list(scale))
    bar.ax.set_xticklabels([f"{level:g}" for level in scale])
    bar.set_label("from this many times the noise level on; white: in the noise; grey: nothing recorded", color=SOFT)
    return made


def _map(axes: Axes, one: heat.Map, colours: Any, norm: Any) -> Any:
    cells = np.array([np.where(np.isfinite(row.multiples) & (not row.above), 0.0, row.multiples) for row in one.rows])
    axes.set_facecolor("#cfd5da")
    mesh = axes.pcolormesh(
        one.edges, np.arange(len(one.rows) + 1), np.ma.masked_invalid(cells), cmap=colours, norm=norm, edgecolor="#dfe3e7", linewidth=0.4
    )
    shown = names.block if one.lights else names.signal
    axes.set_yticks(np.arange(len(one.rows)) + 0.5, [shown(row.name) for row in one.rows])
    axes.invert_yaxis()
    axes.grid(visible=False)
    if not one.lights:
        axes.set_xscale("log")
    unit = one.unit.replace("um", "µm").replace("s2", "s²")
    titled(axes, f"Over {one.by}, {unit}" if one.lights else f"Signals over frequency, {unit}")
    return mesh


def shares_picture(where: Sequence[Place], title: str) -> Figure | None:
    """Share of the squared error beside the share of the time of the most telling parts; None without any."""
    places = list(where)[:_PLACES_MAX]
    if not places:
        return None
    made = figure(title, 1.4 + 0.36 * len(places))
    axes = made.subplots()
    rows = np.arange(len(places))
    share, time = (np.array([getattr(one, f"{name}_percent") for one in places]) for name in ("share", "time"))
    axes.hlines(rows, time, share, color="#dfe3e7", linewidth=4)
    axes.plot(time, rows, "o", markerfacecolor="white", markeredgecolor=INK, markersize=8, label="share of the time")
    axes.plot(share, rows, "o", color=BEFORE, markersize=8, label="share of the squared error")
    axes.set_yticks(rows, [one.name for one in places])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlim(left=0.0)
    titled(axes, "", "Share, %")
    made.legend(loc="outside lower left", ncols=2)
    return made


def balances_picture(result: ShownComparison) -> Figure | None:
    """What each balance leaves, in % of its driving side; None where none can be drawn."""
    known = {name: value for name in BALANCES if isinstance(value := result.balances.get(name), tuple)}
    if not known:
        return None
    made = figure(f"{result.title}: what each equation leaves unexplained", 1.2 + 0.5 * len(known))
    axes = made.subplots()
    values = [value[1] for value in known.values()]
    axes.barh(range(len(known)), values, height=0.55, color=AFTER)
    for place, percent in enumerate(values):
        axes.annotate(f"{number(percent)} %", (percent, place), xytext=(5, 0), textcoords="offset points", va="center")
    axes.set_yticks(range(len(known)), [f"{names.block(name)}:\n{names.BLOCKS[name][1]}" for name in known], fontsize=8.5)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlim(0.0, 1.12 * max(values))
    titled(axes, "", "Residual, rms, % of the driving side")
    return made
