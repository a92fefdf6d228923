"""Draws a figure (see `figures`) as SVG that stands in the page as it is: it follows the page's colours by its roles, needs no script, and prints.

What a figure may hold: scatter traces (lines, markers, steps, bands, bars of error), bars and contours over linear, logarithmic and named axes, several x axes beside each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape
from typing import Any

from ema_tools.words.page.figure_axes import HEIGHT_SHARE, WIDTH, FigureAxis, Frame, frame_of
from ema_tools.words.page.figure_contour import contour

Figure = dict[str, Any]

_SMALL = 3.9  # size of markers that are dots, drawn as one path and without words of their own [layout]
_TEXT_ROOM = 15.0  # height of a bar that holds a text [layout]
_DASHES = {"dash": "6 4", "dot": "2 4"}
_FIELD = re.compile(r"%\{(x|y|z|customdata)(?::([^}]*))?\}")


def figure_svg(figure: Figure, identity: str) -> str:
    """The picture; its label is read aloud. `identity`: its own on the page."""
    frame = frame_of(figure, identity)
    parts = frame.markup()
    band: tuple[Sequence[Any], Sequence[Any]] | None = None
    for trace in figure["data"]:
        axis = frame.x_of(trace)
        if trace["type"] == "contour":
            parts.append(contour(trace, frame, axis))
        elif trace["type"] == "bar":
            parts.append(_bars(trace, frame, axis))
        else:
            if trace.get("fill") == "tonexty" and band is not None:
                points = [*_points(frame, axis, *band), *reversed(_points(frame, axis, trace["x"], trace["y"]))]
                parts.append(f'<polygon class="band r-{trace["meta"]["role"]}" points="{_joined(points)}"/>')
            parts += _scatter(trace, frame, axis)
            band = (trace["x"], trace["y"])
    zooms = f' data-zooms="{figure["zooms"]}" data-half="{figure["half"]:.6g}"' if "zooms" in figure else ""
    height = HEIGHT_SHARE * figure["height"]
    return f'<svg class="picture" id="{identity}" viewBox="0 0 {WIDTH:g} {height:g}" role="img" aria-label="{escape(figure["label"])}"{zooms}>{"".join(parts)}</svg>'


def _points(frame: Frame, axis: FigureAxis, x: Sequence[Any], y: Sequence[Any]) -> list[tuple[float, float]]:
    return [(axis.at(one), frame.y.at(other)) for one, other in zip(x, y, strict=True) if one is not None and other is not None]


def _joined(points: Sequence[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _runs(x: Sequence[Any], y: Sequence[Any]) -> list[tuple[list[Any], list[Any]]]:
    """Pieces of a line between which there is nothing."""
    runs: list[tuple[list[Any], list[Any]]] = [([], [])]
    for one, other in zip(x, y, strict=True):
        if one is None or other is None:
            runs.append(([], []))
        else:
            runs[-1][0].append(one)
            runs[-1][1].append(other)
    return [run for run in runs if run[0]]


def _scatter(trace: Figure, frame: Frame, axis: FigureAxis) -> list[str]:
    role, mode, line = trace["meta"]["role"], trace["mode"], trace.get("line", {})
    parts = []
    if "lines" in mode and line.get("width", 1.5) > 0:
        style = f'stroke-width="{0.9 * line.get("width", 1.5):g}"'
        if "dash" in line:
            style += f' stroke-dasharray="{_DASHES[line["dash"]]}"'
        for x, y in _runs(trace["x"], trace["y"]):
            points = _points(frame, axis, x, y)
            if line.get("shape") == "hv":
                points = [
                    point for place, one in enumerate(points) for point in (((one[0], points[place - 1][1]), one) if place else (one,))
                ]
            parts.append(f'<polyline class="r-{role}" {style} points="{_joined(points)}"{frame.clip(trace)}/>')
    if trace.get("error_x", {}).get("array"):
        parts.append(_errors(trace, frame, axis))
    if "markers" in mode:
        parts.append(_markers(trace, frame, axis))
    return parts


def _errors(trace: Figure, frame: Frame, axis: FigureAxis) -> str:
    found = trace["error_x"]
    bars = "".join(
        f"M{axis.at(x - below):.1f} {frame.y.at(y):.1f}H{axis.at(x + above):.1f}"
        for x, y, above, below in zip(trace["x"], trace["y"], found["array"], found["arrayminus"], strict=True)
    )
    return f'<path class="r-{trace["meta"]["role"]}" stroke-width="{found["thickness"]}" d="{bars}"/>'


def _markers(trace: Figure, frame: Frame, axis: FigureAxis) -> str:
    marker = trace.get("marker", {})
    role, size, symbol = trace["meta"]["role"], marker.get("size", 6), marker.get("symbol", "circle")
    if role == "measured" and symbol.endswith("open"):
        role = "ring"
    opacity = f' opacity="{marker["opacity"]:g}"' if "opacity" in marker else ""
    points = list(zip(trace["x"], trace["y"], strict=True))
    if size <= _SMALL:
        dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in _points(frame, axis, trace["x"], trace["y"]))
        return f'<path class="dots r-{role}" stroke-width="{size}"{opacity} d="{dots}"{frame.clip(trace)}/>'
    shapes = []
    for place, (x, y) in enumerate(points):
        if x is None or y is None:
            continue
        a, b, half = axis.at(x), frame.y.at(y), 0.45 * size
        told = _told(trace, place, x, y)
        at = f' data-x="{x:g}"' if isinstance(x, float) else ""
        shape = f'd="M{a:.1f} {b - half:.1f}l{half:.1f} {half:.1f}l{-half:.1f} {half:.1f}l{-half:.1f} {-half:.1f}z"'
        name, placed = ("path", shape) if symbol.startswith("diamond") else ("circle", f'cx="{a:.1f}" cy="{b:.1f}" r="{half:.2f}"')
        shapes.append(f"<{name} {placed}{at}><title>{escape(told)}</title></{name}>")
    kind = "open" if symbol.endswith("open") else "mark"
    return f'<g class="{kind} r-{role}"{opacity}{frame.clip(trace)}>{"".join(shapes)}</g>'


def _bars(trace: Figure, frame: Frame, axis: FigureAxis) -> str:
    base = trace.get("base") or [frame.y.low] * len(trace["x"])
    half = 0.5 * axis.step * trace.get("width", 0.65)
    shapes = []
    for place, (x, y) in enumerate(zip(trace["x"], trace["y"], strict=True)):
        middle, lower = axis.at(x), frame.y.at(max(base[place], frame.y.low))
        upper = frame.y.at(base[place] + y if trace.get("base") else y)
        told = _told(trace, place, x, y)
        shapes.append(
            f'<rect x="{middle - half:.1f}" y="{upper:.1f}" width="{max(2.0 * half, 1.0):.1f}" height="{max(lower - upper, 0.0):.1f}"><title>{escape(told)}</title></rect>'
        )
        text = trace.get("text", ())
        if place < len(text) and text[place] and lower - upper > _TEXT_ROOM:
            shapes.append(f'<text x="{middle:.1f}" y="{0.5 * (upper + lower) + 4.0:.1f}" text-anchor="middle">{escape(text[place])}</text>')
    return f'<g class="bars r-{trace["meta"]["role"]}">{"".join(shapes)}</g>'


def _told(trace: Figure, place: int, x: Any, y: Any) -> str:
    """What a mark says: its template with its numbers."""
    values = {"x": x, "y": y, "customdata": trace.get("customdata", {}) and trace["customdata"][place]}

    def value(match: re.Match[str]) -> str:
        one, form = values.get(match[1], ""), (match[2] or "").replace("~", "")
        return f"{one:{form}}" if form and isinstance(one, int | float) else str(one)

    said = _FIELD.sub(value, re.sub(r"<extra>.*?</extra>", "", str(trace.get("hovertemplate") or trace.get("name", ""))))
    return re.sub(r"<[^>]+>", " ", said)
