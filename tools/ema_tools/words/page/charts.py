"""Charts that stand in the page as they are: markup that follows the page's colours, needs no script, prints, and is as wide as its place.

Tracks are rows of marks over one logarithmic axis; pictures are lines, bands and dots over two axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.words.page import text as words

_WIDTH, _HEIGHT = 420.0, 250.0
_TICKS_MAX = 7  # of a track, before whole powers of ten alone are written
_LEFT, _RIGHT, _TOP, _BOTTOM = 54.0, 10.0, 10.0, 40.0


@dataclass(frozen=True)
class Mark:
    """One mark of a track: where, which kind (class of the style sheet), what it says."""

    value: float
    kind: str
    words: str


@dataclass(frozen=True)
class Row:
    """One row of tracks: its head (markup), its marks and what stands right of them (markup)."""

    head: str
    marks: tuple[Mark, ...]
    told: str = ""
    kind: str = ""


def decades(low: float, high: float) -> tuple[float, float]:
    """The powers of ten around two positive values."""
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    return 10.0**first, 10.0 ** max(last, first + 1)


def steps(low: float, high: float) -> tuple[float, float]:
    """The nearest 1, 2 or 5 times a power of ten around two positive values."""

    def power(value: float) -> float:
        return float(10.0 ** math.floor(math.log10(value) + 1e-9))

    under, over = power(low), power(high)
    first = under * max(lead for lead in (1.0, 2.0, 5.0) if lead * under <= low * (1.0 + 1e-9))
    last = over * min(lead for lead in (1.0, 2.0, 5.0, 10.0) if lead * over >= high * (1.0 - 1e-9))
    return first, last if last > first else 10.0 * first


def tracks(label: str, head: str, told: str, rows: Sequence[Row], line: float | None = None, line_words: str = "") -> str:
    """Rows of marks over one logarithmic axis, as a table: it is read aloud as one. `line`: a value drawn through all rows."""
    values = [mark.value for row in rows for mark in row.marks if mark.value > 0.0] + ([line] if line else [])
    if not values:
        return ""
    low, high = steps(0.9 * min(values), 1.1 * max(values))

    def place(value: float) -> str:
        share = math.log(max(value, low) / low) / math.log(high / low)
        return f"{100.0 * share:.2f}%"

    shown = [
        lead * 10.0**power
        for power in range(math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9) + 1)
        for lead in (1.0, 2.0, 5.0)
    ]
    shown = [tick for tick in shown if 0.999 * low <= tick <= 1.001 * high]
    if len(shown) > _TICKS_MAX:
        shown = [tick for tick in shown if abs(math.log10(tick) - round(math.log10(tick))) < 1e-6]
    scale = "".join(f'<span style="left:{place(tick)}">{_plain(tick)}</span>' for tick in shown)
    grid = "".join(f'<i class="tick" style="left:{place(tick)}"></i>' for tick in shown)
    grid += f'<i class="noise" style="left:{place(line)}"></i>' if line else ""
    body = []
    for row in rows:
        marks = "".join(
            f'<i class="mark {mark.kind}" style="left:{place(mark.value)}" title="{escape(mark.words)}"></i>' for mark in row.marks
        )
        bar = ""
        if row.marks:
            bar = f'<i class="stem" style="width:{place(row.marks[0].value)}"></i>'
        spoken = "; ".join(mark.words for mark in row.marks)
        body.append(
            f'<tr class="{row.kind}"><th scope="row">{row.head}</th><td class="track"><div>{grid}{bar}{marks}</div><span class="spoken">{escape(spoken)}</span></td>'
            f'<td class="told">{row.told}</td></tr>'
        )
    under = f' <span class="note-line">{escape(line_words)}</span>' if line else ""
    return (
        f'<table class="tracks"><caption>{escape(label)}{under}</caption><thead><tr><th scope="col">{head}</th>'
        f'<th scope="col" class="track"><span class="spoken">On a logarithmic axis</span><div class="scale" aria-hidden="true">{scale}</div></th>'
        f'<th scope="col" class="told">{told}</th></tr></thead><tbody>{"".join(body)}</tbody></table>'
    )


def _plain(value: float) -> str:
    return f"{value:g}" if 1e-3 <= value < 1e6 else words.number(value, 1)


def ticks(low: float, high: float, count: int = 5) -> list[float]:
    """Round values between two ends, no more than about `count`."""
    raw = (high - low) / count
    power = 10.0 ** math.floor(math.log10(raw))
    step = power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= raw * (1.0 - 1e-9))
    return [float(round(step * place, 12)) for place in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


@dataclass
class Drawing:
    """A picture over two axes; lines are added, then it is drawn. `log`: which axes are logarithmic."""

    label: str
    x_title: str
    y_title: str
    x_ends: tuple[float, float]
    y_ends: tuple[float, float]
    log: tuple[bool, bool] = (False, False)
    counts: bool = False  # whether x counts something: no ticks between whole numbers
    parts: list[str] = field(default_factory=list)

    def at(self, x: Reals, y: Reals) -> tuple[Reals, Reals]:
        """Places on the picture."""
        across = self._share(x, self.x_ends, self.log[0])
        up = self._share(y, self.y_ends, self.log[1])
        return _LEFT + (_WIDTH - _LEFT - _RIGHT) * across, _HEIGHT - _BOTTOM - (_HEIGHT - _TOP - _BOTTOM) * up

    @staticmethod
    def _share(values: Reals, ends: tuple[float, float], log: bool) -> Reals:
        low, high = (math.log(ends[0]), math.log(ends[1])) if log else ends
        shown = np.log(np.maximum(values, 1e-300)) if log else values
        return np.clip((shown - low) / (high - low), -0.02, 1.02)

    def _points(self, x: Reals, y: Reals) -> str:
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(*self.at(x, y), strict=True))

    def line(self, x: Reals, y: Reals, kind: str) -> None:
        """A line; `kind` is its class."""
        self.parts.append(f'<polyline class="{kind}" points="{self._points(x, y)}"/>')

    def band(self, x: Reals, low: Reals, high: Reals, kind: str) -> None:
        """The area between two lines."""
        self.parts.append(f'<polygon class="band {kind}" points="{self._points(x, low)} {self._points(x[::-1], high[::-1])}"/>')

    def dots(self, x: Reals, y: Reals, kind: str, radius: float = 1.6) -> None:
        """Points: in one path, however many."""
        dots = "".join(f"M{a:.1f} {b:.1f}h0" for a, b in zip(*self.at(x, y), strict=True))
        self.parts.append(f'<path class="dots {kind}" stroke-width="{2.0 * radius:g}" d="{dots}"/>')

    def bars(self, x: Reals, low: Reals, high: Reals, kind: str) -> None:
        """A vertical line from low to high at each x, as of intervals."""
        lower, upper = self.at(x, low), self.at(x, high)
        bars = "".join(f"M{a:.1f} {b:.1f}V{c:.1f}" for a, b, c in zip(lower[0], lower[1], upper[1], strict=True))
        self.parts.append(f'<path class="thin {kind}" d="{bars}"/>')

    def stems(self, x: Reals, y: Reals, kind: str) -> None:
        """Lines from the lower edge."""
        lower = _HEIGHT - _BOTTOM
        stems = "".join(f"M{a:.1f} {lower:.1f}V{b:.1f}" for a, b in zip(*self.at(x, y), strict=True))
        self.parts.append(f'<path class="stems {kind}" d="{stems}"/>')

    def svg(self) -> str:
        """The picture."""
        lower, right = _HEIGHT - _BOTTOM, _WIDTH - _RIGHT
        shown = []
        for value in self._marks(self.x_ends, self.log[0], 6):
            if self.counts and value != round(value):
                continue
            x = float(self.at(np.array([value]), np.array([self.y_ends[0]]))[0][0])
            shown.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{_TOP:g}" y2="{lower:g}"/>')
            shown.append(f'<text x="{x:.1f}" y="{lower + 14.0:g}" text-anchor="middle">{_minus(value)}</text>')
        for value in self._marks(self.y_ends, self.log[1], 5):
            y = float(self.at(np.array([self.x_ends[0]]), np.array([value]))[1][0])
            shown.append(f'<line class="grid{" zero" if value == 0.0 else ""}" x1="{_LEFT:g}" x2="{right:g}" y1="{y:.1f}" y2="{y:.1f}"/>')
            shown.append(f'<text x="{_LEFT - 5.0:g}" y="{y + 3.5:.1f}" text-anchor="end">{_minus(value)}</text>')
        middle = 0.5 * (_LEFT + right)
        shown.append(f'<text x="{middle:g}" y="{_HEIGHT - 6.0:g}" text-anchor="middle">{escape(self.x_title)}</text>')
        shown.append(
            f'<text transform="translate(11 {0.5 * (_TOP + lower):g}) rotate(-90)" text-anchor="middle">{escape(self.y_title)}</text>'
        )
        return f'<svg class="chart" viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" role="img" aria-label="{escape(self.label)}">{"".join(shown + self.parts)}</svg>'

    @staticmethod
    def _marks(ends: tuple[float, float], log: bool, count: int) -> list[float]:
        if not log:
            return ticks(*ends, count)
        first, last = math.ceil(math.log10(ends[0]) - 1e-9), math.floor(math.log10(ends[1]) + 1e-9)
        step = max(1, math.ceil((last - first) / count))
        return [10.0**power for power in range(first, last + 1, step)]


def _minus(value: float) -> str:
    return _plain(value).replace("-", "−") if value else "0"


def ends(*values: Reals, room: float = 0.06, zero: bool = False) -> tuple[float, float]:
    """The ends of an axis that holds all values."""
    low, high = min(float(np.min(one)) for one in values), max(float(np.max(one)) for one in values)
    low = min(low, 0.0) if zero else low
    span = high - low or abs(high) or 1.0
    return (low if zero and low == 0.0 else low - room * span), high + room * span
