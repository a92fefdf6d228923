"""The axes of a figure: where a value stands, which ticks are written, and how much room names need."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from ema_tools.words.page.charts import ticks
from ema_tools.words.page.figure_text import CHARACTER, LINE, folded, lines_of

WIDTH = 460.0  # of a figure, in its own units; it is as wide as its place [layout]
HEIGHT_SHARE = 0.85  # of the height that a figure states, which is in points of a wide screen [layout]
_ROOM = 0.05  # of an axis beyond its values, where it states no range [layout]
_NAMES_MOST = 0.44  # of the width for the names of rows [layout]
_POWERS_PLAIN = 3  # powers of ten up to here are written out [layout]
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class FigureAxis:
    """From a value, or a name, to a place between `start` and `stop`; `low` and `high` are the ends, of a logarithmic axis as logarithms."""

    start: float
    stop: float
    low: float
    high: float
    log: bool
    names: tuple[str, ...]
    title: str

    def at(self, value: Any) -> float:
        """Place of a value; a name's is the middle of its row."""
        number = float(self.names.index(value)) if isinstance(value, str) else float(value)
        if self.log:
            number = math.log10(max(number, 1e-300))
        return self.spot(number)

    def spot(self, number: float) -> float:
        """Place of a number as the ends are stated: of a logarithmic axis of a logarithm."""
        return self.start + (self.stop - self.start) * (number - self.low) / (self.high - self.low)

    @property
    def step(self) -> float:
        """Width of one unit."""
        return abs((self.stop - self.start) / (self.high - self.low))

    def marks(self, count: int) -> list[tuple[float, str]]:
        """Values and what is written there."""
        if self.names:
            return [(float(place), name) for place, name in enumerate(self.names)]
        if not self.log:
            return [(value, f"{value:.6g}".replace("-", "−")) for value in ticks(self.low, self.high, count)]
        powers = range(math.ceil(self.low - 1e-9), math.floor(self.high + 1e-9) + 1)
        if len(powers) < 3:
            values = [lead * 10.0**power for power in range(math.floor(self.low), math.ceil(self.high) + 1) for lead in (1, 2, 5)]
            return [(value, f"{value:.3g}") for value in values if self.low - 1e-9 <= math.log10(value) <= self.high + 1e-9]
        step = max(1, math.ceil(len(powers) / count))
        return [(10.0**power, _power(power)) for power in powers if power % step == 0]


def _power(power: int) -> str:
    return f"{10.0**power:g}" if abs(power) <= _POWERS_PLAIN else "10" + str(power).translate(_SUPERSCRIPT)


@dataclass(frozen=True)
class Frame:
    """All axes of a figure, and its edges."""

    x: dict[str, FigureAxis]
    y: FigureAxis
    left: float
    right: float
    top: float
    bottom: float
    identity: str

    def x_of(self, trace: dict[str, Any]) -> FigureAxis:
        """The x axis of a trace."""
        return self.x[trace.get("xaxis", "x")]

    def clip(self, trace: dict[str, Any]) -> str:
        """Keeps a trace inside its axes, unless it says otherwise."""
        return "" if trace.get("cliponaxis") is False else f' clip-path="url(#{self.identity}-{trace.get("xaxis", "x")})"'

    def markup(self) -> list[str]:
        """Grid, ticks, titles, and what clips."""
        clips, parts = [], []
        for name, axis in self.x.items():
            box = f'x="{axis.start - 3.0:.1f}" y="{self.top - 3.0:.1f}" width="{axis.stop - axis.start + 6.0:.1f}" height="{self.bottom - self.top + 6.0:.1f}"'
            clips.append(f'<clipPath id="{self.identity}-{name}"><rect {box}/></clipPath>')
            parts += self._x_marks(axis)
            for value, text in self.y.marks(6):
                y = self.y.at(value)
                zero = " zero" if not self.y.log and value == 0.0 and not self.y.names else ""
                if not self.y.names:
                    parts.append(f'<line class="grid{zero}" x1="{axis.start:.1f}" x2="{axis.stop:.1f}" y1="{y:.1f}" y2="{y:.1f}"/>')
                if name == "x":
                    parts.append(lines_of(text, self.left - 6.0, y + 3.5, "end", centred=True))
        if self.y.title:
            middle = 0.5 * (self.top + self.bottom)
            parts.append(f'<text transform="translate(11 {middle:.1f}) rotate(-90)" text-anchor="middle">{self.y.title}</text>')
        return [f"<defs>{''.join(clips)}</defs>", *parts]

    def _x_marks(self, axis: FigureAxis) -> list[str]:
        room = axis.stop - axis.start
        marks = axis.marks(max(3, int(room // 50)))
        parts = []
        for value, text in marks:
            x = axis.at(value)
            if not axis.names:
                zero = " zero" if not axis.log and value == 0.0 else ""
                parts.append(f'<line class="grid{zero}" x1="{x:.1f}" x2="{x:.1f}" y1="{self.top:.1f}" y2="{self.bottom:.1f}"/>')
            parts.append(lines_of(folded(text, axis.step) if axis.names else text, x, self.bottom + 14.0, "middle"))
        if axis.title:
            parts.append(
                f'<text x="{0.5 * (axis.start + axis.stop):.1f}" y="{self.bottom + 31.0:.1f}" text-anchor="middle">{axis.title}</text>'
            )
        return parts


def frame_of(figure: dict[str, Any], identity: str) -> Frame:
    """The axes of a figure in its own units."""
    layout, data = figure["layout"], figure["data"]
    names = _names(layout.get("yaxis", {}), [value for trace in data for value in trace["y"]])
    longest = max((len(re.sub(r"<[^>]+>", "", row)) for name in names for row in name.split("<br>")), default=0)
    y_title = _title(layout.get("yaxis", {}))
    left = min(CHARACTER * longest + 10.0, _NAMES_MOST * WIDTH) if names else 48.0 + (16.0 if y_title else 0.0)
    x_names = _names(layout.get("xaxis", {}), [value for trace in data for value in trace["x"]])
    lines = max((folded(name, (WIDTH - 12.0 - left) / len(x_names)).count("<br>") for name in x_names), default=0)
    height = HEIGHT_SHARE * figure["height"]
    top, bottom = 8.0, height - (22.0 + LINE * lines if x_names else 38.0)
    right = WIDTH - 12.0
    y = _axis(layout.get("yaxis", {}), bottom, top, [_ends(trace, "y") for trace in data], names, y_title)
    axes = {}
    for key in sorted({trace.get("xaxis", "x") for trace in data}):
        settings = layout.get("xaxis" + key[1:], {})
        first, last = settings.get("domain", (0.0, 1.0))
        own = [_ends(trace, "x") for trace in data if trace.get("xaxis", "x") == key]
        axes[key] = _axis(settings, left + first * (right - left), left + last * (right - left), own, x_names, _title(settings))
    return Frame(axes, y, left, right, top, bottom, f"{identity}-clip")


def _title(settings: dict[str, Any]) -> str:
    """Markup of an axis' title; what stands low stays low."""
    text = escape(settings.get("title", {}).get("text", ""))
    return re.sub(r"&lt;sub&gt;(.*?)&lt;/sub&gt;", '<tspan dy="3" font-size="8">\\1</tspan><tspan dy="-3">\u200b</tspan>', text)


def _names(settings: dict[str, Any], values: Sequence[Any]) -> tuple[str, ...]:
    return tuple(settings.get("categoryarray", ())) or tuple(dict.fromkeys(value for value in values if isinstance(value, str)))


def _ends(trace: dict[str, Any], axis: str) -> list[float]:
    """Numbers of a trace along an axis, with its bars of error and where its bars end."""
    values = [float(value) for value in trace[axis] if value is not None and not isinstance(value, str)]
    if axis == "x" and trace.get("error_x", {}).get("array"):
        values += [x + one for x, one in zip(trace["x"], trace["error_x"]["array"], strict=True)]
        values += [x - one for x, one in zip(trace["x"], trace["error_x"]["arrayminus"], strict=True)]
    if axis == "y" and trace["type"] == "bar":
        values = [0.0, *values, *(one + other for one, other in zip(values, trace.get("base", ()), strict=False))]
    return values


def _axis(
    settings: dict[str, Any], start: float, stop: float, values: Sequence[Sequence[float]], names: tuple[str, ...], title: str
) -> FigureAxis:
    log = settings.get("type") == "log"
    if "range" in settings:
        low, high = settings["range"]
    elif names:
        low, high = -0.5, len(names) - 0.5
    else:
        numbers = [math.log10(value) if log else value for one in values for value in one if value > 0.0 or not log]
        low, high = min(numbers, default=0.0), max(numbers, default=1.0)
        room = _ROOM * (high - low) or 0.5
        zero = settings.get("rangemode") == "tozero"
        low, high = (0.0 if zero else low - room), high + room
    return FigureAxis(start, stop, float(low), float(high), log, names, title)
