"""Where the model fails as a heat map: each equation's residual against the states of the machine, in multiples of its noise level.

Of every axis the bins of the localisation: a cell is the residual's rms in that part of the record over the equation's noise level. Against frequency stand the signals, whose spectra
the page takes from the curves; their noise is what the top of the spectrum holds, where nothing of the machine is left.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.results.localisation import BinPicture
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.first_screen import telling
from ema_tools.words.page.recorded import slope
from ema_tools.words.page.signals import Traces

# Axes of the map, in the order of the page.
AXES = ("time", "speed", "position", "current", "time since reversal")
LEAST = 2.0  # multiples of the noise level at which colour begins: below, a bin of few samples may be chance
_LEVELS = 6  # colours of the style sheet
_TOP_LEAST = 10.0  # the scale reaches at least so far, or what is slight would be as dark as what is gross
_BANDS = 24  # of the frequency axis
_TOP_SHARE = 0.75  # of half the sample rate: above it sensors make noise alone
_RESTING_SHARE = 0.01  # below this share of the largest speed the rod rests, as the localisation has it


@dataclass(frozen=True)
class Cells:
    """One equation, or signal, over an axis: multiples of the noise level, NaN where the record has nothing; `above`: whether it stands above the noise as a whole."""

    name: str
    multiples: Reals
    above: bool


@dataclass(frozen=True)
class Map:
    """One axis: name, unit, edges of the bins [bins + 1], and its rows. `lights`: whether a cell has moments in the record."""

    by: str
    unit: str
    edges: Reals
    rows: tuple[Cells, ...]
    lights: bool = True


def levels(drawn: list[Map]) -> tuple[float, ...]:
    """Lower ends of the colours, in multiples of the noise level: closer at the low end, the last near the largest of the equations."""
    tops = [float(np.nanmax(row.multiples)) for one in drawn if one.lights for row in one.rows if row.above]
    top = max([*tops, _TOP_LEAST])
    roots = np.linspace(math.sqrt(LEAST), math.sqrt(0.9 * top), _LEVELS)
    return tuple(float(f"{value:.2g}") for value in roots**2)


def maps(result: Diagnosed, found: Traces | None) -> list[Map]:
    """Every axis that the result has."""
    drawn = [one for by in AXES if (one := _axis(result, by)) is not None]
    spectrum = _frequency(result, found)
    return drawn[:1] + ([spectrum] if spectrum is not None else []) + drawn[1:]


def _grid(one: BinPicture) -> tuple[float, float, int]:
    """Lower end, width and number of the bins, of which empty ones are left out."""
    center = np.asarray(one.center)
    width = float(np.min(np.diff(center))) if center.size > 1 else 1.0
    return float(center[0]) - 0.5 * width, width, round(float(center[-1] - center[0]) / width) + 1 if center.size > 1 else 1


def _axis(result: Diagnosed, by: str) -> Map | None:
    blocks = {one.name: one for one in result.blocks}
    there = [one for one in result.found_bins() if one.by == by and one.source in blocks]
    if not there:
        return None
    low, width, count = _grid(there[0])
    rows = []
    for one in there:
        block = blocks[one.source]
        if block.rms is None or not block.floor_rms:
            continue
        place = np.clip(np.round((np.asarray(one.center) - low) / width - 0.5).astype(int), 0, count - 1)
        share, time = np.asarray(one.share_percent), np.asarray(one.time_percent)
        multiples = np.full(count, math.nan)
        multiples[place] = block.rms / block.floor_rms * np.sqrt(share / np.maximum(time, 1e-9))
        rows.append(Cells(one.source, multiples, block.telling))
    return Map(by, there[0].axis_unit, low + width * np.arange(count + 1, dtype=np.float64), tuple(rows)) if rows else None


def _frequency(result: Diagnosed, found: Traces | None) -> Map | None:
    """The signals' residuals against frequency, in logarithmic bands."""
    if found is None:
        return None
    rate = 1.0 / found.curves.period_s
    rows = found.curves.rows
    frequency = np.fft.rfftfreq(rows, found.curves.period_s)
    low = max(2.0 / (rows * found.curves.period_s), 0.1)
    if not rate / 2.0 > 10.0 * low:
        return None
    edges = np.geomspace(low, rate / 2.0, _BANDS + 1)
    band = np.digitize(frequency, edges) - 1
    floors = {one.name: one.floor_rms for one in result.signals}
    key = next(iter(found.curves.models))
    drawn = []
    for name in found.names:
        if name in found.curves.derived:
            continue
        residual = found.residual(name, key)
        power = np.abs(np.fft.rfft(residual - np.mean(residual))) ** 2
        noise = float(np.mean(power[frequency > _TOP_SHARE * rate / 2.0]))
        count = np.bincount(band[band >= 0], minlength=_BANDS)[:_BANDS]
        total = np.bincount(band[band >= 0], power[band >= 0], minlength=_BANDS)[:_BANDS]
        with np.errstate(invalid="ignore", divide="ignore"):
            multiples = np.where((count > 0) & (noise > 0.0), np.sqrt(total / count / noise), math.nan)
        floor = floors.get(name)
        rms = float(np.sqrt(np.mean(residual**2)))
        above = bool(telling(result)) and (floor is None or rms > LEAST * floor)
        drawn.append(Cells(name, multiples, above))
    return Map("frequency", "Hz", np.asarray(edges, dtype=np.float64), tuple(drawn), lights=False) if drawn else None


def bins_of_rows(result: Diagnosed, found: Traces) -> dict[str, Reals]:
    """For every axis the bin in which each row of the record lies, [rows]: what lights up when a cell is chosen."""
    curves = found.curves
    motor = curves.measured.get("motor_position_mm", curves.measured["position_mm"])
    speed = slope(motor, curves.period_s) if curves.rows > 9 else np.zeros_like(motor)
    moving = np.sign(speed) * (np.abs(speed) > _RESTING_SHARE * float(np.max(np.abs(speed), initial=0.0)))
    turned = np.concatenate(([True], (moving[1:] != moving[:-1]) & (moving[1:] != 0.0)))
    rows = np.arange(curves.rows)
    since = (rows - np.maximum.accumulate(np.where(turned, rows, 0))) * curves.period_s
    values = {
        "time": curves.start_s + rows * curves.period_s,
        "position": motor,
        "speed": speed,
        "current": curves.measured.get("current_A"),
        "time since reversal": since,
    }
    placed = {}
    for by in AXES:
        one = next((one for one in result.found_bins() if one.by == by), None)
        mine = values[by]
        if one is None or mine is None:
            continue
        low, width, count = _grid(one)
        if by == "speed":
            # the axis is the motor's, in rad/s; the curves have it at the rod
            reach = float(np.max(mine) - np.min(mine))
            mine = low + (mine - float(np.min(mine))) * (count * width / reach) if reach > 0.0 else mine
        placed[by] = np.clip(np.floor((mine - low) / width), 0, count - 1)
    return placed


def section(result: Diagnosed, drawn: list[Map]) -> str:
    """The maps, each a table whose cells are buttons."""
    if not drawn:
        return ""
    scale = levels(drawn)
    keys = "".join(f'<span class="h{place + 1}">{level:g}</span>' for place, level in enumerate(scale))
    blocks = [one.name for one in result.blocks if one.reason is None]
    order = list(dict.fromkeys([*(one.name for one in telling(result)), *blocks]))
    between = " between baseline runs" if result.relative else ""
    note = (
        f"Residual of each equation, in multiples of its noise level{between}. "
        "Choose a cell: its moments light up in the signals; zoom the signals: their cells stay lit."
    )
    legend = (
        f'<p class="levels" aria-label="Colours: from this many times the noise level on">× noise <span class="h0">less</span>{keys}</p>'
    )
    parts = [
        f'<div class="bar"><p class="note">{note}</p>{legend}</div>',
        '<p id="cell" class="reading" aria-live="polite">&nbsp;</p><div class="maps">',
        *(_table(one, order, scale) for one in drawn),
        "</div>",
    ]
    return "".join(parts)


def _table(one: Map, order: list[str], scale: tuple[float, ...]) -> str:
    rows = sorted(one.rows, key=lambda row: order.index(row.name) if row.name in order else len(order))
    title = f"Over {one.by}" if one.lights else "Signals over frequency"
    body, first = [], True
    for row in rows:
        name = names.block(row.name) if one.lights else names.signal(row.name)
        cells = []
        for place, value in enumerate(row.multiples):
            if not math.isfinite(value):
                cells.append("<td></td>")
                continue
            level = sum(value >= limit for limit in scale) if row.above else 0
            ends = f"{words.number(float(one.edges[place]), 3)} … {words.number(float(one.edges[place + 1]), 3)} {_unit(one.unit)}"
            told = escape(f"{name}, {one.by} {ends}: {words.number(float(value), 2)} × noise")
            if one.lights:
                cells.append(
                    f'<td><button type="button" class="cell h{level}" tabindex="{0 if first else -1}" data-by="{one.by}" data-bin="{place}" aria-pressed="false" aria-label="{told}"></button></td>'
                )
                first = False
            else:
                cells.append(
                    f'<td><span class="cell h{level}" title="{told}"><span class="spoken">{words.number(float(value), 2)}</span></span></td>'
                )
        state = "" if row.above else ' <small class="within">in the noise</small>'
        body.append(f'<tr><th scope="row">{escape(name)}{state}</th>{"".join(cells)}</tr>')
    count = one.edges.size - 1
    ticks = _ticks(one)
    return (
        f'<table class="heat"><caption>{escape(title)}, {_unit(one.unit)}</caption><tbody>{"".join(body)}</tbody>'
        f'<tfoot aria-hidden="true"><tr><td></td><td colspan="{count}"><div class="scale">{ticks}</div></td></tr></tfoot></table>'
    )


def _ticks(one: Map) -> str:
    """Numbers under a map: ends and a few between."""
    count = one.edges.size - 1
    shown = [0, count // 4, count // 2, 3 * count // 4, count]
    decimals = max(0, 1 - math.floor(math.log10(float(one.edges[-1] - one.edges[0]))))

    def text(value: float) -> str:
        told = f"{value:.{decimals}f}" if one.lights else words.number(value, 2)
        return (told.lstrip("-") if float(told) == 0.0 else told).replace("-", "−")

    return "".join(f'<span style="left:{100.0 * place / count:.1f}%">{text(float(one.edges[place]))}</span>' for place in shown)


def _unit(unit: str) -> str:
    return unit.replace("um", "µm").replace("s2", "s²")
