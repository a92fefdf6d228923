"""Figures of a diagnosis as plain dictionaries; roles give the colours, as in `ema_tools.words.page.figures`."""

from __future__ import annotations

from dataclasses import replace
from html import escape
from itertools import pairwise

import numpy as np

from ema_tools.words.page.diagnosis_results import Diagnosed, Line, Picture
from ema_tools.words.page.figures import Figure
from ema_tools.words.page.recorded import Series
from ema_tools.words.page.text import number

_SUSPECTS_MAX = 12
_MARGIN = {"l": 62, "r": 14, "t": 8, "b": 44}
_ROLES = {
    "measured": "before",
    "model": "after",
    "healthy": "after",
    "points": "measured",
    "excess": "before",
    "order": "before",
    "chance": "undecided",
}
_NAMES = {
    "measured": "measured",
    "model": "model",
    "healthy": "healthy repeats",
    "points": "sample",
    "excess": "mean",
    "order": "amplitude",
    "chance": "what noise makes",
}
# A scale on which the scores of weak and strong effects are both seen.
_LEAST_RATIO = 0.01


def ranking(result: Diagnosed) -> Figure:
    """Score of every effect over the limit that it must exceed, logarithmic."""
    shown = result.suspects[:_SUSPECTS_MAX]
    names = [escape(one.name) for one in shown]
    ratios = [max(one.score / one.limit, _LEAST_RATIO) if one.limit > 0.0 else _LEAST_RATIO for one in shown]
    stems: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": [value for ratio in ratios for value in (_LEAST_RATIO, float(f"{ratio:.5g}"), None)],
        "y": [value for name in names for value in (name, name, None)],
        "meta": {"role": "join"},
        "line": {"width": 3},
        "hoverinfo": "skip",
    }
    limit = {
        "type": "scatter",
        "mode": "lines",
        "x": [1.0] * len(names),
        "y": names,
        "name": "limit",
        "meta": {"role": "undecided"},
        "line": {"width": 1.5, "dash": "dash"},
        "hoverinfo": "skip",
    }
    traces = [stems, limit]
    for accepted, role, title in ((True, "after", "accepted"), (False, "candidate", "not accepted")):
        chosen = [place for place, one in enumerate(shown) if one.accepted == accepted]
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "x": _short([ratios[place] for place in chosen]),
                "y": [names[place] for place in chosen],
                "name": title,
                "meta": {"role": role},
                "marker": {"size": 11},
                "cliponaxis": False,
                "hovertemplate": f"%{{y}}: %{{x:.3~g}} times the limit, {title}<extra></extra>",
            }
        )
    layout = {
        "xaxis": {
            "title": {"text": "Score over the limit"},
            "type": "log",
            "dtick": 1,
            "range": [float(np.log10(_LEAST_RATIO)), float(np.log10(2.0 * max([*ratios, 1.0])))],
        },
        "yaxis": {"categoryorder": "array", "categoryarray": names[::-1], "showgrid": False, "automargin": True, "ticklabelstandoff": 6},
        "margin": {"l": 20, "r": 14, "t": 8, "b": 44},
    }
    label = "Score over limit: " + "; ".join(
        f"{one.name} {number(ratio)}{' accepted' if one.accepted else ''}" for one, ratio in zip(shown, ratios, strict=True)
    )
    return {"data": traces, "layout": layout, "height": 80 + 26 * len(shown), "label": label}


def waterfall(result: Diagnosed) -> Figure:
    """Weighted error from the first model to the floor: what each addition takes off, what is left, and the held-out record beside it."""
    training = [result.errors["before"], *(step.read[0] for step in result.steps)]
    steps = ["first model", *(f"+ {escape(step.added or ' + '.join(step.effects))}" for step in result.steps)]
    # The error stands under the bar: a small one has no room inside.
    names = [f"{step}<br><b>{number(value)}</b>" for step, value in zip(steps, training, strict=True)]
    left: Figure = _bar(names, training, [0.0] * len(names), "left", "after")
    falls = [max(0.0, before - after) for before, after in pairwise(training)]
    taken = _bar(names[1:], falls, training[1:], "taken off", "join")
    taken["text"] = [f"−{number(fall)}" if fall > 0.0 else "" for fall in falls]
    traces = [left, taken]
    holdout = [result.errors.get("holdout_before"), *(step.read[1] for step in result.steps)]
    if any(value is not None for value in holdout):
        traces.append(
            {
                "type": "scatter",
                "mode": "lines+markers",
                "x": names,
                "y": holdout,
                "name": "held-out record",
                "meta": {"role": "before"},
                "line": {"width": 2, "dash": "dot"},
                "marker": {"symbol": "diamond", "size": 10},
                "hovertemplate": "held out, %{x}: %{y:.3~g}<extra></extra>",
            }
        )
    floor = result.errors.get("floor")
    if floor is not None:
        line: Figure = {
            "type": "scatter",
            "mode": "lines",
            "x": names,
            "y": [floor] * len(names),
            "name": "floor",
            "meta": {"role": "undecided"},
            "line": {"width": 1.5, "dash": "dash"},
        }
        traces.append({**line, "hovertemplate": "floor of the repeats %{y:.3~g}<extra></extra>"})
    layout = {
        "xaxis": {"type": "category", "categoryorder": "array", "categoryarray": names, "showgrid": False, "automargin": True},
        "yaxis": {"title": {"text": "Force error, %" if result.by_forces else "Weighted rms error"}, "rangemode": "tozero"},
        "margin": {"l": 62, "r": 14, "t": 18, "b": 60},
        "barmode": "overlay",
        "bargap": 0.35,
    }
    parts = [f"{step} {number(value)}" for step, value in zip(steps, training, strict=True)]
    label = "Weighted error: " + ", ".join(parts) + (f"; floor {number(floor)}" if floor is not None else "")
    return {"data": traces, "layout": layout, "height": 320, "label": label}


def _bar(names: list[str], values: list[float], base: list[float], title: str, role: str) -> Figure:
    hover = f"%{{x}}: {title} %{{customdata:.3~g}}<extra></extra>"
    return {
        "type": "bar",
        "x": names,
        "y": values,
        "base": base,
        "customdata": values,
        "name": title,
        "meta": {"role": role},
        "hovertemplate": hover,
    }


def _short(values: Series | list[float]) -> list[float]:
    return [float(f"{value:.5g}") for value in values]


def _axis_title(by: str, unit: str) -> str:
    return f"{by[:1].upper()}{by[1:]}{', ' + _unit(unit) if unit else ''}"


def _unit(unit: str) -> str:
    return unit.replace("um", "µm").replace("s2", "s²")


def picture(shown: Picture) -> Figure:
    """A picture of `where` or `unknown`: bands and lines over an axis, points as points, orders as stems."""
    shown = _readable(shown)
    traces: list[Figure] = []
    loop = shown.source.endswith("loop")
    for name, line in shown.lines.items():
        role, title = _ROLES[name], _NAMES[name]
        hover = f"{title} %{{y:.3~g}} {_unit(shown.unit)} at %{{x:.4~g}} {_unit(shown.axis_unit)}<extra></extra>"
        if line.low is not None and line.high is not None:
            traces += _band(line, role)
        trace: Figure = {
            "type": "scatter",
            "x": _short(line.x),
            "y": _short(line.y),
            "name": title,
            "meta": {"role": role},
            "hovertemplate": hover,
        }
        if name == "points":
            trace |= {"mode": "markers", "marker": {"size": 3, "opacity": 0.45}}
        elif name == "order":
            trace = {**trace, "type": "bar", "width": 0.6 * float(np.min(np.diff(line.x), initial=1.0))}
        elif name == "chance":
            trace |= {"mode": "lines", "line": {"width": 1.5, "dash": "dash"}}
        elif loop:
            trace |= {"mode": "lines", "line": {"width": 2.5 if name == "measured" else 1.2}, "opacity": 0.9}
        else:
            trace |= {"mode": "lines+markers", "line": {"width": 2}, "marker": {"size": 5}}
            if shown.share is not None:
                trace["customdata"] = _short(shown.share)
                trace["hovertemplate"] = hover.replace("<extra>", "<br>%{customdata:.1f} % of the squared excess here<extra>")
        traces.append(trace)
    layout = {
        "xaxis": {"title": {"text": _axis_title(shown.by, shown.axis_unit)}},
        "yaxis": {"title": {"text": _unit(shown.unit)}, "zeroline": True, "exponentformat": "power"},
        "margin": _MARGIN,
    }
    return {"data": traces, "layout": layout, "height": 250, "label": f"{shown.source} against {shown.by}: {_reading(shown)}"}


def _readable(shown: Picture) -> Picture:
    """Small lengths in um."""
    largest = max(float(np.max(np.abs(line.y))) for line in shown.lines.values())
    if shown.unit != "mm" or largest > 0.1:
        return shown
    lines = {
        name: Line(line.x, 1e3 * line.y, *(None if edge is None else 1e3 * edge for edge in (line.low, line.high)))
        for name, line in shown.lines.items()
    }
    return replace(shown, unit="um", lines=lines)


def _band(line: Line, role: str) -> list[Figure]:
    """The band of one standard deviation."""
    assert line.low is not None and line.high is not None
    edge: Figure = {
        "type": "scatter",
        "mode": "lines",
        "x": _short(line.x),
        "meta": {"role": role},
        "line": {"width": 0},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    return [{**edge, "y": _short(line.low)}, {**edge, "y": _short(line.high), "fill": "tonexty"}]


def _reading(shown: Picture) -> str:
    """What a picture shows, for who cannot see it."""
    name = next((key for key in ("measured", "excess", "order") if key in shown.lines), next(iter(shown.lines)))
    line = shown.lines[name]
    place = int(np.argmax(np.abs(line.y)))
    return f"{_NAMES[name]} largest at {number(float(line.x[place]))} {shown.axis_unit} with {number(float(line.y[place]))} {shown.unit}"
