"""The section of the signals: every channel of the record, measured and simulated, with its residual, packed for the page's script."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.results import parts
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.curves import kept_rows, packed
from ema_tools.words.page.recorded import Curves, Series

# Rows of a record that the page keeps: 24 000 of five channels and two models are less than a megabyte.
ROWS_MAX = 24_000
_FIT = '<label class="fit"><input type="checkbox" data-fit> scale to view</label>'


@dataclass(frozen=True)
class Traces:
    """The channels of a record: those of `Curves`, and the motor's position; in the order of the page."""

    curves: Curves
    names: tuple[str, ...]

    def residual(self, name: str, model: str) -> Series:
        """Measured minus simulated, in the channel's unit, [rows]."""
        return np.asarray(self.curves.measured[name] - self.curves.models[model][name])


def traces(curves: Curves | None, found: parts.CurvesEntry | None) -> Traces | None:
    """What there is to draw; None without curves. `found`: the result's own, which has the motor's position besides."""
    if curves is None or found is None or not curves.models:
        return None
    motor: dict[str, Series] = {}
    for key in ("measured", *curves.models):
        channels: parts.Channels | None = getattr(found, key)
        values = channels.motor_position_mm if channels is not None else None
        if values is not None and len(values) == curves.rows:
            motor[key] = np.asarray(values, dtype=np.float64)
    if len(motor) == 1 + len(curves.models):
        models = {key: {**model, "motor_position_mm": motor[key]} for key, model in curves.models.items()}
        curves = replace(curves, measured={**curves.measured, "motor_position_mm": motor["measured"]}, models=models)
    there = tuple(name for name in names.SIGNALS if name in curves.measured and all(name in model for model in curves.models.values()))
    return Traces(curves, there)


def packed_signals(found: Traces, titles: Mapping[str, str], bins: Mapping[str, Reals]) -> dict[str, Any]:
    """What the page's script draws: times in s, channels as measured and residuals, and for every axis of a heat map the bin of each row. `titles`: what each model is called."""
    curves = found.curves
    keep = kept_rows(curves, found.names, ROWS_MAX)
    channels = []
    for name in found.names:
        title, unit, residual_unit, scale = names.SIGNALS[name]
        channels.append(
            {
                "name": name,
                "title": title,
                "unit": unit,
                "residual_unit": residual_unit,
                "residual_scale": scale,
                "measured": packed(curves.measured[name][keep]),
                "residual": {key: packed(found.residual(name, key)[keep] * scale) for key in curves.models},
            }
        )
    times: dict[str, Any] = {"start_s": curves.start_s, "period_s": curves.period_s, "rows": curves.rows}
    if keep.size < curves.rows:
        times["kept"] = base64.b64encode(keep.astype("<u4").tobytes()).decode("ascii")
    return {
        "time": times,
        "models": dict(titles),
        "channels": channels,
        "bins": {by: base64.b64encode(rows[keep].astype(np.uint8).tobytes()).decode("ascii") for by, rows in bins.items()},
    }


def section(found: Traces | None, titles: Mapping[str, str], absent: str) -> str:
    """Markup of the section; `titles`: what each model is called, `absent`: why nothing can be drawn, empty where it can."""
    if found is None:
        return '<p class="note">The result holds no curves: the record is longer than the page shows, or its controller is not known, so that nothing is simulated.</p>'
    curves = found.curves
    toggles = '<label><input type="checkbox" data-series="measured" checked><span class="key measured"></span>measured</label>'
    for key, title in titles.items():
        toggles += f'<label><input type="checkbox" data-series="{key}" checked><span class="key {key}"></span>{escape(title)}</label>'
    buttons = "".join(
        f'<button type="button" data-zoom="{how}">{text}</button>'
        for how, text in (("whole", "Whole record"), ("in", "Zoom in"), ("out", "Zoom out"), ("earlier", "← Earlier"), ("later", "Later →"))
    )
    shown: list[str] = [
        f'<div class="bar"><fieldset class="toggles"><legend class="spoken">Curves shown</legend>{toggles}</fieldset>',
        f'<div class="zoom" role="group" aria-label="Zoom of all plots">{buttons}{_FIT}</div></div>',
    ]
    if absent:
        shown.append(f'<p class="absent">{escape(absent)}</p>')
    shown.append(
        '<div class="plots" id="plots" tabindex="0" role="group" aria-label="Signals over time. Arrow keys move the crosshair, plus and minus zoom, Home shows the whole record.">'
    )
    shown += [_channel(found, name, titles, bool(absent)) for name in found.names]
    shown.append("</div>")
    derived = " Rod speed is the slope of the rod position over 9 rows, the same for every curve." if "speed_mm_s" in curves.derived else ""
    shown.append(
        '<p class="note">Under each signal its residual: measured minus simulated. Drag across a plot to zoom, all follow; double click, '
        f'<kbd>Home</kbd> or “Whole record” shows all again.{derived} <span id="reading" aria-live="polite" class="spoken"></span></p>'
    )
    return "".join(shown)


def _channel(found: Traces, name: str, titles: Mapping[str, str], bare: bool) -> str:
    """One channel: head with what the crosshair reads, plots, and in a table what stays of it without a script."""
    title, unit, residual_unit, scale = names.SIGNALS[name]
    rms = {key: float(np.sqrt(np.mean(found.residual(name, key) ** 2))) * scale for key in titles}
    told = " · ".join(f'<b class="{key}" data-rms="{key}">{words.number(value)}</b>' for key, value in rms.items())
    label = f"{title}, measured and simulated, over time. Residual rms: " + "; ".join(
        f"{titles[key]} {words.number(value)} {residual_unit}" for key, value in rms.items()
    )
    plots = (
        ""
        if bare
        else f'<div class="plot main" role="img" aria-label="{escape(label)}"></div><div class="plot residual" role="img" aria-label="Residual of the {escape(title.lower())} over time"></div>'
    )
    return (
        f'<div class="channel" data-channel="{name}"><div class="channel-head"><h3>{escape(title)}, {unit}</h3>'
        f'<span class="rms">residual rms <span data-where>of the record</span> {told} {residual_unit}</span></div><div class="values" data-values></div>{plots}</div>'
    )
