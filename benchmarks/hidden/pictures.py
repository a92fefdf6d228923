"""Two pictures for the document as SVG text: the detection curve and the confusion matrix."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

COLOURS = ("#1f5fa8", "#c2571a", "#2f8f57", "#8a4fa3", "#777777")
_TEXT = "#333333"


def svg(width: float, height: float, parts: Sequence[str]) -> str:
    """A picture of `parts` on white."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" font-family="sans-serif" font-size="11" fill="{_TEXT}">'
    return "\n".join([head, f'<rect width="{width:g}" height="{height:g}" fill="white"/>', *parts, "</svg>", ""])


def label(x: float, y: float, text: str, anchor: str = "middle", more: str = "") -> str:
    """A text at a place."""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{escape(text)}</text>'


def curves(title: str, places: Sequence[str], lines: Mapping[str, Sequence[float | None]]) -> str:
    """Percent against severity: one line per name of `lines`, a value per place, None where there is none."""
    left, top, width, height = 50.0, 30.0, 420.0, 220.0

    def at(place: int, percent: float) -> tuple[float, float]:
        return left + width * place / max(len(places) - 1, 1), top + height * (1.0 - percent / 100.0)

    parts = [label(left, 18.0, title, "start", ' font-weight="bold"')]
    for percent in range(0, 101, 20):
        _, y = at(0, percent)
        parts += [
            f'<line x1="{left}" x2="{left + width}" y1="{y:.1f}" y2="{y:.1f}" stroke="#dddddd"/>',
            label(left - 6.0, y + 4.0, f"{percent}", "end"),
        ]
    parts += [label(at(place, 0.0)[0], top + height + 18.0, name) for place, name in enumerate(places)]
    for order, (name, values) in enumerate(lines.items()):
        colour = COLOURS[order % len(COLOURS)]
        points = [at(place, value) for place, value in enumerate(values) if value is not None]
        parts.append(
            f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" fill="none" stroke="{colour}" stroke-width="2"/>'
        )
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in points]
        row = top + height + 40.0 + 16.0 * order
        parts += [
            f'<line x1="{left}" x2="{left + 24.0}" y1="{row - 4.0}" y2="{row - 4.0}" stroke="{colour}" stroke-width="2"/>',
            label(left + 30.0, row, name, "start"),
        ]
    return svg(left + width + 30.0, top + height + 50.0 + 16.0 * len(lines), parts)


def matrix(title: str, counts: Mapping[str, Mapping[str, int]]) -> str:
    """Hidden names down, said names across; a cell's shade is its share of the row, its number the count."""
    rows = list(counts)
    columns = [*rows, *sorted({said for row in counts.values() for said in row} - set(rows))]
    cell, left, top = 20.0, 165.0, 175.0
    parts = [label(8.0, 18.0, title, "start", ' font-weight="bold"')]
    for place, name in enumerate(columns):
        x = left + cell * (place + 0.65)
        parts.append(label(x, top - 6.0, name, "start", f' transform="rotate(-60 {x:.1f} {top - 6.0:.1f})"'))
    for down, hidden in enumerate(rows):
        y = top + cell * down
        parts.append(label(left - 6.0, y + 14.0, hidden, "end"))
        total = max(sum(counts[hidden].values()), 1)
        for across, said in enumerate(columns):
            count = counts[hidden].get(said, 0)
            colour = COLOURS[0] if hidden == said else COLOURS[1]
            fill = f'fill="{colour}" fill-opacity="{count / total:.2f}"' if count else 'fill="white"'
            x = left + cell * across
            parts.append(f'<rect x="{x:g}" y="{y:g}" width="{cell:g}" height="{cell:g}" {fill} stroke="#e4e4e4"/>')
            if count:
                parts.append(label(x + cell / 2.0, y + 14.0, str(count)))
    return svg(left + cell * len(columns) + 70.0, top + cell * len(rows) + 12.0, parts)
