"""The error of a diagnosis after each step, over the noise level; and the candidates, each with the error that it leaves alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ema_tools.words.page import names
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.first_screen import candidates, faults, rung_words, rungs
from ema_tools.words.page.text import number
from ema_tools.words.plots.style import AFTER, BEFORE, NOISE, OTHER, figure, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FEW_DECADES = 200.0  # from end to end of an axis: up to there 2 and 5 are written beside powers of ten [layout]
_CANDIDATES_MAX = 14  # that are drawn, the best first [layout]


def ladder_picture(result: Diagnosed) -> Figure | None:
    """None where nothing was fitted."""
    found = rungs(result)
    if not found:
        return None
    known = {one.name for one in result.suspects} | set(faults(result)) | {result.added}
    titles = [name if place == 0 else f"+ {rung_words(name, known)}" for place, (name, _, _) in enumerate(found)]
    made = figure(f"{result.name}: the error after each step", 1.5 + 0.42 * len(found))
    axes = made.subplots()
    here = np.array([one for _, one, _ in found])
    places = np.arange(len(found))
    axes.plot(here, places, "o", color=AFTER, markersize=8, label="this record")
    held = [(place, one) for place, (_, _, one) in enumerate(found) if one is not None]
    if held:
        said = "parts held out in turn" if result.by_forces else "validation record, to which nothing was fitted"
        axes.plot(
            [one for _, one in held],
            [place for place, _ in held],
            "D",
            markerfacecolor="none",
            markeredgecolor=BEFORE,
            markeredgewidth=1.8,
            markersize=8,
            label=said,
        )
    for place, value in zip(places, here, strict=True):
        axes.annotate(
            number(float(value)),
            (value, place),
            xytext=(0, 8),
            textcoords="offset points",
            ha="center",
            fontsize=8.5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        )
    unit = "% of the drive's force" if result.by_forces else "times the sensor noise"
    _rows(axes, titles, here, [one for _, one in held], result.errors.get("floor"))
    titled(axes, "", f"Error, {unit}, logarithmic; all values refitted together")
    made.legend(loc="outside lower left", ncols=3)
    return made


def candidates_picture(result: Diagnosed) -> Figure | None:
    """None where no effect was tried."""
    tried = [one for one in candidates(result) if one.entry.accepted or one.entry.score > 0.0]
    by_error = sorted((one for one in tried if one.left is not None), key=lambda one: one.left or 0.0)[:_CANDIDATES_MAX]
    if by_error:
        values, title = (
            np.array([one.left for one in by_error], dtype=np.float64),
            "the error that each effect leaves when it alone is added",
        )
        entries, limits, floor = [one.entry for one in by_error], [], result.errors.get("floor")
        unit = "% of the drive's force" if result.by_forces else "times the sensor noise"
        x_title = f"Error left, {unit}, logarithmic"
    else:
        best = sorted(tried, key=lambda one: -one.entry.score)[:_CANDIDATES_MAX]
        entries = [one.entry for one in best]
        if not entries:
            return None
        values, title = np.maximum([one.score for one in entries], 1e-3), "what each effect takes off, beside what it must"
        limits, floor = [one.limit for one in entries], None
        x_title = "Score, logarithmic: what the effect takes off" + (", squared % of the drive's force" if result.by_forces else "")
    made = figure(f"{result.name}: {title}", 1.5 + 0.36 * len(entries))
    axes = made.subplots()
    for kind, colour, marker, said in ((True, AFTER, "o", "named"), (False, OTHER, "s", "not named")):
        chosen = [place for place, one in enumerate(entries) if one.accepted is kind]
        if chosen:
            axes.plot(values[chosen], chosen, marker, color=colour, markersize=8, label=said)
    if any(limit > 0.0 for limit in limits):
        axes.plot(
            np.maximum(limits, 1e-3), np.arange(len(limits)), "|", color=NOISE, markersize=13, markeredgewidth=2.2, label="must exceed"
        )
    _rows(axes, [names.display(one.name) for one in entries], values, [limit for limit in limits if limit > 0.0], floor)
    titled(axes, "", x_title)
    made.legend(loc="outside lower left", ncols=4)
    return made


def _rows(axes: Axes, titles: list[str], values: np.ndarray, more: list[float], floor: float | None) -> None:
    """Named rows over a logarithmic axis, the first on top, and the noise level through all of them."""
    every = np.array([*values, *more, *([floor] if floor else [])])
    axes.set_xscale("log")
    low, high = 0.7 * float(np.min(every)), 1.5 * float(np.max(every))
    axes.set_xlim(low, high)
    axes.hlines(np.arange(len(titles)), low, values, color="#dfe3e7", linewidth=4, zorder=1)
    axes.set_yticks(range(len(titles)), titles)
    axes.set_ylim(len(titles) - 0.4, -0.75)
    axes.grid(axis="y", visible=False)
    axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axes.xaxis.set_minor_formatter(lambda value, _: f"{value:g}" if high < _FEW_DECADES * low and f"{value:.0e}"[0] in "25" else "")
    if floor:
        axes.axvline(floor, color=NOISE, linestyle=(0, (5, 3)), linewidth=1.6, label=f"noise level {number(floor)}")
