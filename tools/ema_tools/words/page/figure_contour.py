"""A quantity over two axes in steps of shade: dark is small. Its points are stated as the ends of the axes: on a logarithmic one by their logarithms."""

from __future__ import annotations

from typing import Any

import numpy as np

from ema_tools.words.page.figure_axes import FigureAxis, Frame

_COLUMNS, _ROWS = 96, 64  # cells of the picture; neighbours of one shade are drawn as one [layout]
_FULL, _LEAST = 0.72, 0.04  # opacity of the lowest and of the highest step [layout]


def contour(trace: dict[str, Any], frame: Frame, axis: FigureAxis) -> str:
    """Markup of the steps."""
    x, y, z = (np.asarray(trace[name], dtype=np.float64) for name in ("x", "y", "z"))
    low, high, count = float(z.min()), float(z.max()), trace.get("ncontours", 12)
    across = np.linspace(axis.low, axis.high, _COLUMNS + 1)
    up = np.linspace(frame.y.low, frame.y.high, _ROWS + 1)
    middle_x, middle_y = 0.5 * (across[1:] + across[:-1]), 0.5 * (up[1:] + up[:-1])
    rows = np.array([np.interp(middle_x, x, row) for row in z])
    cells = np.array([np.interp(middle_y, y, column) for column in rows.T]).T
    steps = np.clip(((cells - low) / ((high - low) or 1.0) * count).astype(int), 0, count - 1)
    parts = []
    for place, row in enumerate(steps):
        top, bottom = frame.y.spot(up[place + 1]), frame.y.spot(up[place])
        edges = np.flatnonzero(np.diff(row)) + 1
        for start, stop in zip((0, *edges), (*edges, row.size), strict=True):
            left, right = axis.spot(across[start]), axis.spot(across[stop])
            opacity = _FULL + (_LEAST - _FULL) * row[start] / max(count - 1, 1)
            parts.append(f'<path fill-opacity="{opacity:.2f}" d="M{left:.1f} {top:.1f}H{right:.1f}V{bottom:.1f}H{left:.1f}z"/>')
    return f'<g class="steps r-{trace["meta"]["role"]}" shape-rendering="crispEdges">{"".join(parts)}</g>'
