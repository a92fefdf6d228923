"""Figures of the page as plain Plotly dictionaries. A trace names its role in `meta`; the page gives the role its colour."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from ema_tools.base.interval import WIDTH_95
from ema_tools.results.parts import Place
from ema_tools.words.page.results import FAULTS, ShownIdentification
from ema_tools.words.page.text import number, shift

LABELS = {"csj_Nm": "CSJ", "blk_mm": "BLK"}

_PLACES_MAX = 10

# Smaller errors are drawn here: they say nothing, and zero has no logarithm.
SMALLEST_ERROR_PERCENT = 1e-4

Figure = dict[str, Any]


def scalars(result: ShownIdentification) -> Figure:
    """Diagnostic scalars: estimated against actual shift in % of the healthy value, one row per fault parameter."""
    names = [LABELS[name] for name in result.faults]
    estimates = [result.faults[name].shift_percent for name in result.faults]
    spread = [_spread(result, name) for name in result.faults]
    stems: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": [value for estimate in estimates for value in (0.0, estimate, None)],
        "y": [value for name in names for value in (name, name, None)],
        "meta": {"role": "after"},
        "line": {"width": 2},
        "hoverinfo": "skip",
    }
    traces = [stems]
    values = [estimate + sign * width for estimate, width in zip(estimates, spread, strict=True) for sign in (-1.0, 1.0)]
    if result.case is not None:
        actual = [result.case.shift_percent(name) for name in result.faults]
        values += actual
        traces.append(_marker(actual, names, "Actual", "measured", "circle-open", 17, 2.5))
    if result.paper is not None:
        paper = [result.paper.paper_shift_percent(name) for name in result.faults]
        values += paper
        traces.append(_marker(paper, names, "Found in the paper", "paper", "diamond-open", 10, 1.5))
    estimated = _marker(estimates, names, "Estimated here", "after", "circle", 8, 0)
    estimated["error_x"] = {"type": "data", "array": spread, "thickness": 1.5, "width": 4}
    traces.append(estimated)
    low, high = min(0.0, *values), max(0.0, *values)
    margin = 0.1 * (high - low or 1.0)
    layout = {
        "xaxis": {"title": {"text": "Shift, % of the healthy value"}, "range": [low - margin, high + margin], "zeroline": True},
        "yaxis": {"categoryorder": "array", "categoryarray": names[::-1], "range": [-0.5, len(names) - 0.25], "showgrid": False},
        "margin": {"l": 46, "r": 14, "t": 8, "b": 44},
        "annotations": [_reading(result, name, place) for place, name in enumerate(reversed(result.faults))],
    }
    return {"data": traces, "layout": layout, "height": 260, "label": _scalars_label(result)}


def _spread(result: ShownIdentification, name: str) -> float:
    """Half the width of the 95 % interval in %; zero, which draws none, where the record does not determine the value."""
    std_percent = result.faults[name].std_percent
    return 0.0 if math.isnan(std_percent) else WIDTH_95 * std_percent


def _reading(result: ShownIdentification, name: str, place: int) -> Figure:
    """The numbers of one row, above it at the left."""
    spread = _spread(result, name)
    text = f"<b>{shift(result.faults[name].shift_percent, 0 if spread >= 10.0 else 1 if spread >= 1.0 else 2)}</b>"
    if spread >= 0.005:
        text += f" ± {number(spread, 2)}"
    if result.case is not None:
        text += f"   actual {shift(result.case.shift_percent(name), 2)}".removesuffix(" %")
    if result.paper is not None:
        text += f"   paper {shift(result.paper.paper_shift_percent(name), 2)}".removesuffix(" %")
    return {
        "text": text,
        "x": 0.0,
        "xref": "paper",
        "xanchor": "left",
        "xshift": 4,
        "y": place + 0.3,
        "yref": "y",
        "yanchor": "bottom",
        "showarrow": False,
    }


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


def _scalars_label(result: ShownIdentification) -> str:
    parts = []
    for name in result.faults:
        text = f"{LABELS[name]} estimated {shift(result.faults[name].shift_percent, 2)}"
        if result.case is not None:
            text += f", actual {shift(result.case.shift_percent(name), 2)}"
        if result.paper is not None:
            text += f", paper {shift(result.paper.paper_shift_percent(name), 2)}"
        parts.append(text)
    return "Shift of the fault parameters. " + "; ".join(parts)


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
