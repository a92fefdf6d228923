"""Curves of a record packed for the page: scaled int16 in base64, one string per channel; the page itself thins them out to its width."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from ema_tools.words.page.recorded import Curves, Series

# Rows per record that the page keeps; a longer record keeps the extremes of equal pieces of it.
ROWS_MAX = 24_000

# name -> title, unit, unit of the residual, residual units in one unit
_SHOWN = {
    "position_mm": ("Rod position", "mm", "µm", 1000.0),
    "speed_mm_s": ("Rod speed", "mm/s", "mm/s", 1.0),
    "current_A": ("Motor current", "A", "A", 1.0),
    "voltage_V": ("Motor voltage", "V", "V", 1.0),
}
_SHOWN_CHANNELS_MAX = 3


def pack(curves: Curves, thin: int = ROWS_MAX) -> dict[str, Any]:
    """What the page's script needs to draw `curves`: times in s, and per channel the measured and the simulated rows."""
    names = curves.channels()[:_SHOWN_CHANNELS_MAX]
    keep = kept_rows(curves, names, thin)
    channels = []
    for name in names:
        title, unit, residual_unit, residual_scale = _SHOWN[name]
        models = {key: model[name] for key, model in curves.models.items()}
        channels.append(
            {
                "title": title,
                "unit": unit,
                "residual_unit": residual_unit,
                "residual_scale": residual_scale,
                "derived": name in curves.derived,
                "measured": packed(curves.measured[name][keep]),
                # Residuals are packed, not models: each has its own scale, so that a small one keeps its digits.
                "residual": {key: packed((curves.measured[name] - model)[keep] * residual_scale) for key, model in models.items()},
                "rms": {key: curves.rms(name, key) * residual_scale for key in models},
            }
        )
    times: dict[str, Any] = {"start_s": curves.start_s, "period_s": curves.period_s, "rows": curves.rows}
    if keep.size < curves.rows:
        times["kept"] = base64.b64encode(keep.astype("<u4").tobytes()).decode("ascii")
    return {"time": times, "channels": channels}


def packed(values: Series) -> dict[str, Any]:
    """`values` as whole multiples of `scale`: a picture is never finer than a part in 32767 of its largest value."""
    scale = float(np.max(np.abs(values))) / 32767.0 or 1.0
    return {
        "scale": float(f"{scale:.9g}"),
        "int16": base64.b64encode(np.rint(values / scale).clip(-32767, 32767).astype("<i2").tobytes()).decode("ascii"),
    }


def kept_rows(curves: Curves, names: tuple[str, ...], limit: int) -> np.ndarray:
    """Row numbers, rising: all of them, or the extremes of every channel's residual and measurement in equal pieces."""
    rows = curves.rows
    if rows <= limit:
        return np.arange(rows)
    shown = [curves.measured[name] for name in names]
    shown += [curves.measured[name] - model[name] for model in curves.models.values() for name in names]
    pieces = max(1, limit // (2 * len(shown)))
    edges = np.linspace(0, rows, pieces + 1).astype(int)[:-1]
    keep = {0, rows - 1}
    for values in shown:
        for start, stop in zip(edges, (*edges[1:], rows), strict=True):
            keep.update((start + int(np.argmin(values[start:stop])), start + int(np.argmax(values[start:stop]))))
    return np.array(sorted(keep))
