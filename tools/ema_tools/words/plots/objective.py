"""The objective of a search: its map over CSJ and BLK with the way of the search, its profiles, and its fall run by run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ema_tools.words.page.figures import profile_ends
from ema_tools.words.page.results import FAULTS, ShownIdentification
from ema_tools.words.page.text import interval, number
from ema_tools.words.plots.style import AFTER, BEFORE, HEALTHY, NOISE, OTHER, figure, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LEAST = 1e-12  # mm2 s that a logarithm is taken of: a record without noise can be met exactly [layout]
_TITLES = {"csj_Nm": ("CSJ, static dry friction", "Nm"), "blk_mm": ("BLK, backlash at the rod", "mm")}
_ERROR = "Integrated squared error, mm² s"


def objective_picture(result: ShownIdentification) -> Figure | None:
    """Map and profiles; None where the result holds neither."""
    count = (result.map is not None) + len(result.profiles)
    if not count:
        return None
    made = figure(f"{result.title}: the error over CSJ and BLK", 4.2 if count > 1 else 4.6)
    ratios = [1.35] * (result.map is not None) + [1.0] * len(result.profiles)
    grid = list(made.subplots(1, count, squeeze=False, gridspec_kw={"width_ratios": ratios})[0])
    if result.map is not None:
        _map(grid.pop(0), result)
    for place, (axes, name) in enumerate(zip(grid, result.profiles, strict=True)):
        _profile(axes, result, name)
        axes.set_ylabel("" if place else _ERROR)
    handles: dict[str, object] = {}
    for axes in made.axes:
        handles |= dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    made.legend(list(handles.values()), list(handles), loc="outside lower left", ncols=6)
    return made


def _map(axes: Axes, result: ShownIdentification) -> None:
    found = result.map
    assert found is not None
    levels = np.log10(np.maximum(found.objective, _LEAST))
    shown = axes.contourf(found.csj, found.blk, levels, 14, cmap="cividis")
    axes.contour(found.csj, found.blk, levels, 14, colors="white", linewidths=0.4, alpha=0.6)
    ends = ((found.csj[0], found.csj[-1]), (found.blk[0], found.blk[-1]))
    inside = (
        (found.path_csj >= ends[0][0]) & (found.path_csj <= ends[0][1]) & (found.path_blk >= ends[1][0]) & (found.path_blk <= ends[1][1])
    )
    axes.plot(found.path_csj[inside], found.path_blk[inside], ".", color="#ffffff", markersize=3, alpha=0.75)
    if found.path_cost.size:
        better = found.path_cost <= np.minimum.accumulate(found.path_cost)
        axes.plot(found.path_csj[better], found.path_blk[better], "-", color="#ffffff", linewidth=1.3)
    for values, marker, colour, said in (
        ([result.faults[name].healthy for name in FAULTS], "D", BEFORE, "healthy"),
        ([result.faults[name].estimate for name in FAULTS], "o", AFTER, "found"),
    ):
        axes.plot(*values, marker, color=colour, markeredgecolor="white", markersize=9, linestyle="none", label=said)
    axes.set_xlim(*ends[0])
    axes.set_ylim(*ends[1])
    axes.grid(visible=False)
    titled(axes, "White: the way of the search", "CSJ, Nm", "BLK, mm")
    bar = axes.figure.colorbar(shown, ax=axes, pad=0.02)
    ticks = list(range(int(np.ceil(levels.min())), int(np.floor(levels.max())) + 1))
    if ticks:
        bar.set_ticks(ticks, labels=[f"$10^{{{tick}}}$" for tick in ticks])
    bar.set_label("mm² s")


def _profile(axes: Axes, result: ShownIdentification, name: str) -> None:
    one, fault = result.profiles[name], result.faults[name]
    title, unit = _TITLES[name]
    least = max(float(np.min(one.objective)), _LEAST)
    axes.semilogy(one.value, np.maximum(one.objective, _LEAST), "-", color=AFTER, linewidth=1.6, marker=".")
    axes.axhline(max(one.limit, _LEAST), color=NOISE, linestyle=(0, (5, 3)), linewidth=1.4, label="below, noise alone would do")
    axes.plot(fault.healthy, max(float(np.interp(fault.healthy, one.value, one.objective)), _LEAST), "D", color=BEFORE, markersize=9)
    axes.plot(fault.estimate, least, "o", color=AFTER, markersize=9)
    if fault.interval is not None:
        axes.hlines(least, *fault.interval, color=AFTER, linewidth=3)
    spread = "" if fault.interval is None else f"\n95 %: {interval(*fault.interval)}"
    titled(axes, f"{number(fault.estimate, 4)} {unit}{spread}", f"{title}, {unit}")
    axes.title.set_fontsize(9)
    axes.set_xlim(*profile_ends(one.value, fault))
    axes.locator_params(axis="x", nbins=4)


def search_picture(result: ShownIdentification) -> Figure | None:
    """The error of every model run, and the best so far; None where the search is not in the result."""
    if result.search is None:
        return None
    cost = np.maximum(result.search.cost, _LEAST)
    runs = np.arange(1, cost.size + 1)
    made = figure(f"{result.title}: the search", 3.6)
    axes = made.subplots()
    axes.semilogy(runs, cost, "o", color=OTHER, markersize=4, alpha=0.55, label="candidate")
    axes.step(runs, np.minimum.accumulate(cost), where="post", color=AFTER, linewidth=2.2, label="best so far")
    axes.axhline(max(result.before_mm2s, _LEAST), color=HEALTHY, linestyle=(0, (1, 2)), linewidth=1.4, label="healthy values")
    titled(axes, "", "Model run", _ERROR)
    made.legend(loc="outside lower left", ncols=3)
    return made
