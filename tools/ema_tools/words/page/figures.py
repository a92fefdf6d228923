"""Figures of the page as plain dictionaries, laid out as Plotly has them; `figure_svg` draws them. A trace names its role in `meta`; the page gives the role its colour."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from ema_tools.results.parts import Place
from ema_tools.words.page.results import FAULTS, ShownEstimate, ShownIdentification
from ema_tools.words.page.text import number

LABELS = {"csj_Nm": "CSJ", "blk_mm": "BLK"}

_PLACES_MAX = 10

# Smaller errors are drawn here: they say nothing, and zero has no logarithm.
SMALLEST_ERROR_PERCENT = 1e-4

# An objective below it has no place on a logarithmic axis.
_LEAST_OBJECTIVE = 1e-14
# What is drawn of a profile beyond healthy value, estimate and interval: a share of their distance, and of the healthy value.
_PROFILE_ROOM, _LEAST_PROFILE_ROOM = 0.4, 0.1

Figure = dict[str, Any]


def _marker(x: list[float], y: list[str], name: str, role: str, symbol: str, size: int, line: float) -> Figure:
    return {
        "type": "scatter",
        "mode": "markers",
        "x": x,
        "y": y,
        "name": name,
        "meta": {"role": role},
        "cliponaxis": False,
        "marker": {"symbol": symbol, "size": size, "line": {"width": line}},
        "hovertemplate": f"{name}: %{{y}} %{{x:+.3f}} %<extra></extra>",
    }


def search(result: ShownIdentification) -> Figure:
    """Objective of every model run as a dot, best so far as a line, logarithmic."""
    assert result.search is not None
    runs = np.arange(1, result.search.cost.size + 1)
    # A noise-free record can be met exactly; zero has no logarithm.
    floor = float(np.min(result.search.cost[result.search.cost > 0.0], initial=1e-12))
    cost = np.maximum(result.search.cost, floor)
    best = np.maximum(result.search.best, floor)
    traces = [
        {
            "type": "scatter",
            "mode": "markers",
            "x": runs.tolist(),
            "y": _short(cost),
            "name": "Candidate",
            "meta": {"role": "candidate"},
            "marker": {"size": 5, "opacity": 0.55},
            "hovertemplate": "run %{x}: %{y:.3~e} mm² s<extra></extra>",
        },
        {
            "type": "scatter",
            "mode": "lines",
            "x": runs.tolist(),
            "y": _short(best),
            "name": "Best so far",
            "meta": {"role": "after"},
            "line": {"width": 2, "shape": "hv"},
            "hovertemplate": "best after %{x} runs: %{y:.3~e} mm² s<extra></extra>",
        },
    ]
    layout = {
        "xaxis": {"title": {"text": "Model run"}, "rangemode": "tozero"},
        "yaxis": {
            "title": {"text": "E<sub>int</sub>, mm² s"},
            "type": "log",
            "exponentformat": "power",
            "tickfont": {"size": 9},
            "dtick": _decades(cost),
        },
        "margin": {"l": 62, "r": 14, "t": 8, "b": 44},
    }
    label = f"Objective against model run: {len(runs)} candidates, best {best[-1]:.2e} mm2 s"
    return {"data": traces, "layout": layout, "height": 260, "label": label}


def profiles(result: ShownIdentification) -> Figure:
    """Objective along each parameter, logarithmic: the profile, the estimate with its 95 % interval, the healthy value, and the level up to which noise alone explains a value."""
    traces: list[Figure] = []
    count = len(result.profiles)
    layout: Figure = {
        "yaxis": {"title": {"text": "E<sub>int</sub>, mm² s"}, "type": "log", "exponentformat": "power", "tickfont": {"size": 9}}
    }
    said = []
    for place, (name, one) in enumerate(result.profiles.items(), start=1):
        fault, unit, axis = result.faults[name], name.partition("_")[2], "x" if place == 1 else f"x{place}"
        least = max(float(np.min(one.objective)), _LEAST_OBJECTIVE)
        low, high = profile_ends(one.value, fault)
        inside = (one.value >= low) & (one.value <= high)
        common = {"type": "scatter", "xaxis": axis, "yaxis": "y"}
        title = LABELS[name]
        traces += [
            {
                **common,
                "mode": "lines+markers",
                "x": _short(one.value[inside]),
                "y": _short(np.maximum(one.objective[inside], _LEAST_OBJECTIVE)),
                "name": "Profile",
                "meta": {"role": "after"},
                "line": {"width": 2},
                "marker": {"size": 4},
                "hovertemplate": f"{title} %{{x:.4~g}} {unit}: %{{y:.3~e}} mm² s<extra></extra>",
            },
            {
                **common,
                "mode": "lines",
                "x": [low, high],
                "y": _short(np.full(2, max(one.limit, _LEAST_OBJECTIVE))),
                "name": "Limit of noise",
                "meta": {"role": "undecided"},
                "line": {"width": 1.5, "dash": "dash"},
                "hovertemplate": "below, noise alone would do<extra></extra>",
            },
            {
                **common,
                "mode": "markers",
                "x": _short(np.array([fault.healthy])),
                "y": _short(np.array([max(float(np.interp(fault.healthy, one.value, one.objective)), _LEAST_OBJECTIVE)])),
                "name": "Healthy",
                "meta": {"role": "before"},
                "marker": {"symbol": "diamond", "size": 10},
                "hovertemplate": f"healthy {title} %{{x:.4~g}} {unit}<extra></extra>",
            },
            {
                **common,
                "mode": "markers",
                "x": [fault.estimate],
                "y": _short(np.array([least])),
                "name": "Estimate",
                "meta": {"role": "after"},
                "marker": {"size": 9},
                "error_x": _error_bar(fault),
                "hovertemplate": f"{title} %{{x:.4~g}} {unit}<extra></extra>",
            },
        ]
        gap = 0.09
        width = (1.0 - gap * (count - 1)) / count
        start = (place - 1) * (width + gap)
        layout[f"xaxis{place if place > 1 else ''}"] = {
            "title": {"text": f"{title}, {unit}"},
            "range": [low, high],
            "domain": [start, start + width],
            "nticks": 5,
            "anchor": "y",
        }
        said.append(
            f"{title} lowest at {number(fault.estimate, 4)} {unit}, {number(least)} mm2 s; at the healthy value {number(float(traces[-2]['y'][0]))}"
        )
    layout["margin"] = {"l": 62, "r": 14, "t": 8, "b": 44}
    return {"data": traces, "layout": layout, "height": 300, "label": "Objective along each parameter: " + "; ".join(said)}


def _error_bar(fault: ShownEstimate) -> Figure:
    if fault.interval is None:
        return {"visible": False}
    low, high = fault.interval
    return {
        "type": "data",
        "symmetric": False,
        "array": [high - fault.estimate],
        "arrayminus": [fault.estimate - low],
        "thickness": 2,
        "width": 5,
    }


def profile_ends(values: np.ndarray, fault: ShownEstimate) -> tuple[float, float]:
    """The part of a profile that is drawn: healthy value, estimate and interval with room around them, inside what was searched."""
    inner = [fault.healthy, fault.estimate, *(fault.interval or ())]
    room = max(_PROFILE_ROOM * (max(inner) - min(inner)), _LEAST_PROFILE_ROOM * abs(fault.healthy))
    low, high = min(inner) - room, max(inner) + room
    if fault.interval is None:
        return float(values[0]), float(values[-1])
    return max(low, float(values[0])), min(high, float(values[-1]))


def surface(result: ShownIdentification) -> Figure:
    """Objective over both parameters as logarithmic contours, with the search's candidates and the way of its best point."""
    assert result.map is not None
    found = result.map
    levels = np.log10(np.maximum(found.objective, _LEAST_OBJECTIVE))
    contour: Figure = {
        "type": "contour",
        "x": _short(found.csj),
        "y": _short(found.blk),
        "z": [_short(row) for row in levels],
        "meta": {"role": "candidate"},
        "ncontours": 14,
        "showscale": False,
        "line": {"width": 0.7, "smoothing": 0.8},
        "hovertemplate": "CSJ %{x:.4~g} Nm, BLK %{y:.4~g} mm: 10^%{z:.2f} mm² s<extra></extra>",
    }
    drawn = (
        (found.path_csj >= found.csj[0])
        & (found.path_csj <= found.csj[-1])
        & (found.path_blk >= found.blk[0])
        & (found.path_blk <= found.blk[-1])
    )
    better = found.path_cost <= np.minimum.accumulate(found.path_cost) if found.path_cost.size else np.zeros(0, dtype=bool)
    traces = [
        contour,
        {
            "type": "scatter",
            "mode": "markers",
            "x": _short(found.path_csj[drawn & ~better]),
            "y": _short(found.path_blk[drawn & ~better]),
            "name": "Candidate",
            "meta": {"role": "soft"},
            "marker": {"size": 3.5, "opacity": 0.6},
            "hovertemplate": "candidate: CSJ %{x:.4~g} Nm, BLK %{y:.4~g} mm<extra></extra>",
        },
        {
            "type": "scatter",
            "mode": "lines+markers",
            "x": _short(found.path_csj[better]),
            "y": _short(found.path_blk[better]),
            "name": "Best so far",
            "meta": {"role": "after"},
            "line": {"width": 1.5},
            "marker": {"size": 5},
            "hovertemplate": "best so far: CSJ %{x:.4~g} Nm, BLK %{y:.4~g} mm<extra></extra>",
        },
    ]
    healthy = [result.faults[name].healthy for name in FAULTS]
    estimate = [result.faults[name].estimate for name in FAULTS]
    for point, name, role, symbol in ((healthy, "Healthy", "before", "diamond"), (estimate, "Estimate", "after", "circle")):
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": [point[0]],
                "y": [point[1]],
                "name": name,
                "meta": {"role": role},
                "marker": {"symbol": symbol, "size": 11},
                "hovertemplate": f"{name.lower()}: CSJ %{{x:.4~g}} Nm, BLK %{{y:.4~g}} mm<extra></extra>",
            }
        )
    layout = {
        "xaxis": {"title": {"text": "CSJ, Nm"}, "range": [float(found.csj[0]), float(found.csj[-1])]},
        "yaxis": {"title": {"text": "BLK, mm"}, "range": [float(found.blk[0]), float(found.blk[-1])]},
        "margin": {"l": 62, "r": 14, "t": 8, "b": 44},
    }
    label = (
        f"Objective over CSJ and BLK with the way of the search: {found.path_cost.size} candidates, of which {int(np.sum(better))} were the best so far; "
        f"lowest at CSJ {number(estimate[0], 4)} Nm and BLK {number(estimate[1], 4)} mm"
    )
    return {"data": traces, "layout": layout, "height": 300, "label": label}


def _decades(cost: np.ndarray) -> int:
    """Decades between two ticks, so that about five stand on the axis."""
    span = float(np.log10(np.max(cost) / np.min(cost)))
    return max(1, round(span / 5.0))


def _short(values: np.ndarray) -> list[float]:
    return [float(f"{value:.5g}") for value in values]


def accuracy(results: list[ShownIdentification]) -> Figure:
    """Size of the error of every estimate, in % of the healthy value, here and in the paper, logarithmic."""
    rows, here, paper_rows, paper = [], [], [], []
    for result in results:
        assert result.case is not None
        for name in FAULTS:
            actual = result.case.shift_percent(name)
            rows.append(f"{result.label} {LABELS[name]}")
            here.append(max(abs(result.faults[name].shift_percent - actual), SMALLEST_ERROR_PERCENT))
            if result.paper is not None:
                paper_rows.append(rows[-1])
                paper.append(abs(result.paper.paper_shift_percent(name) - actual))
    joins: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": [value for row, end in zip(paper_rows, paper, strict=True) for value in (here[rows.index(row)], end, None)],
        "y": [value for row in paper_rows for value in (row, row, None)],
        "meta": {"role": "join"},
        "line": {"width": 2},
        "hoverinfo": "skip",
    }
    traces = [
        joins,
        _error(paper, paper_rows, "In the paper", "paper", "diamond"),
        _error(here, rows, "Here", "after", "circle"),
    ]
    layout = {
        "xaxis": {"title": {"text": "Error of the estimate, % of the healthy value"}, "type": "log", "dtick": 1, "exponentformat": "none"},
        "yaxis": {"categoryorder": "array", "categoryarray": rows[::-1], "showgrid": False},
        "margin": {"l": 92, "r": 14, "t": 8, "b": 44},
    }
    return {
        "data": traces,
        "layout": layout,
        "height": 60 + 30 * len(rows),
        "label": "Error of the estimates here and in the paper; the table holds the numbers",
    }


def _error(x: list[float], y: list[str], name: str, role: str, symbol: str) -> Figure:
    trace = _marker(x, y, name, role, symbol, 10, 0)
    trace["hovertemplate"] = f"{name}: %{{y}} error %{{x:.2~g}} %<extra></extra>"
    return trace


def shares(where: Sequence[Place]) -> Figure:
    """Where more of the squared error lies than of the time: both shares of the most telling parts."""
    places = where[:_PLACES_MAX]
    # Two lines, so that a phone keeps room for the figure.
    names = [escape(place.name).replace(": ", ":<br>") for place in places]
    shares = [place.share_percent for place in places]
    times = [place.time_percent for place in places]
    joins: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": [value for place in places for value in (place.time_percent, place.share_percent, None)],
        "y": [value for name in names for value in (name, name, None)],
        "meta": {"role": "join"},
        "line": {"width": 2},
        "hoverinfo": "skip",
    }
    time, error = (
        _marker(times, names, "of the time", "measured", "circle-open", 11, 2),
        _marker(shares, names, "of the squared error", "before", "circle", 10, 0),
    )
    for trace in (time, error):
        trace["hovertemplate"] = "%{y}: %{x:.1f} % " + trace["name"] + "<extra></extra>"
    layout = {
        "xaxis": {"title": {"text": "Share, %"}, "range": [0, 1.06 * max(shares)]},
        "yaxis": {"categoryorder": "array", "categoryarray": names[::-1], "showgrid": False, "automargin": True, "ticklabelstandoff": 6},
        "margin": {"l": 20, "r": 14, "t": 8, "b": 44},
    }
    label = "Parts that hold more of the squared error than of the time: " + "; ".join(
        f"{p.name} {p.share_percent:.0f} % in {p.time_percent:.0f} % of the time" for p in places
    )
    return {"data": [joins, time, error], "layout": layout, "height": 70 + 38 * len(places), "label": label}
