"""The pages of a fleet: all units, the most urgent first, and one page for each; files that open from disk and ask nothing of any network."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path

import numpy as np

from ema_tools.base.interval import WIDTH_95
from ema_tools.results.store import FleetRow
from ema_tools.tasks.history import Trend, UnitHistory, told
from ema_tools.words.page import text as words
from ema_tools.words.page.charts import Drawing, ends
from ema_tools.words.page.names import FAULT_TITLES, listed
from ema_tools.words.sentences.fleet import SHORT, soonest, summary, trend_words, unit_words

CARDS_MAX = 200  # units that are drawn on the fleet's page; all are in its table [layout]
_AHEAD = 0.25  # of the days so far, drawn beyond the last [layout]
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def fleet_page(
    units: Sequence[UnitHistory], pages: Mapping[str, str], limits: Mapping[str, float], false_alarm: float, command: str
) -> str:
    """All units. `pages`: where each one's own page is, from this one."""
    cards = "".join(_card(one, pages[one.unit]) for one in units[:CARDS_MAX])
    rest = (
        f'<p class="note">Drawn are the {CARDS_MAX} most urgent of {len(units)} units; the table has all.</p>'
        if len(units) > CARDS_MAX
        else ""
    )
    rows = "".join(_unit_row(one, pages[one.unit]) for one in units)
    heads = ("Unit", "CSJ", "BLK", "Drifts", "Reaches a limit", "Last verdict", "Records", "Not judged")
    stated = " and ".join(f"{SHORT[name]} +{percent:g} %" for name, percent in limits.items())
    notes = (
        f"Sorted by urgency: the lower end of the remaining life, then how near the last reading is to its limit ({stated} of the healthy value). A unit drifts where the step between its days before "
        f"and after some day is larger than all but {100.0 * false_alarm:g} % of units without change show; the shaded band is the 95 % interval of each reading, intervals of remaining life are 90 %."
    )
    return _document(
        "Fleet",
        summary(units),
        f'<section id="units"><h2>Units</h2><p class="note">{escape(notes)}</p>{rest}<div class="cards">{cards}</div></section>'
        f'<section id="table"><h2>All units</h2>{_table("all units", heads, rows)}</section>'
        f'<section id="made"><h2>Provenance</h2><p><code>{escape(command)}</code></p></section>',
    )


def unit_page(one: UnitHistory, back: str, command: str) -> str:
    """One unit: its trends and every record."""
    figures = "".join(f"<figure>{drawing(trend)}<figcaption>{escape(trend_words(trend))}</figcaption></figure>" for trend in one.trends)
    rows = "".join(map(_record_row, one.rows))
    heads = ("Date", "Record", "Kind", "Verdict", "CSJ", "95 %", "BLK", "95 %", "Why")
    return _document(
        one.unit,
        unit_words(one),
        f'<p><a href="{escape(back)}">All units</a></p><section id="trends"><h2>Trends</h2><div class="cards wide">{figures}</div></section>'
        f'<section id="records"><h2>Records</h2>{_table("records", heads, rows)}</section>'
        f'<section id="made"><h2>Provenance</h2><p><code>{escape(command)}</code></p></section>',
    )


def drawing(trend: Trend) -> str:
    """Readings with their intervals over days, the limit, and what remaining life says."""
    half = WIDTH_95 * trend.std_percent
    span = max(float(trend.days[-1] - trend.days[0]), 1.0)
    high = trend.days[-1] + span * _AHEAD
    life = trend.life
    if life is not None and math.isfinite(life.low):
        high = max(high, min(trend.days[-1] + 1.05 * (life.high if math.isfinite(life.high) else life.low), trend.days[-1] + span))
    x_ends = (float(trend.days[0]) - 0.02 * span, float(high))
    shows_limit = bool(trend.change.changed and trend.change.by > 0.0) or float(np.max(trend.shift_percent)) > 0.4 * trend.limit_percent
    reach = np.array([0.0, *([trend.limit_percent] if shows_limit else [])])
    y_ends = ends(trend.shift_percent - half, trend.shift_percent + half, reach)
    drawing = Drawing(
        f"{FAULT_TITLES[trend.name]} over days: {trend_words(trend)}",
        "days since the first reading",
        f"{SHORT[trend.name]}, %",
        x_ends,
        y_ends,
    )
    if trend.days.size > 1:
        drawing.band(trend.days, trend.shift_percent - half, trend.shift_percent + half, "after")
        drawing.line(trend.days, trend.shift_percent, "after thin")
    drawing.dots(trend.days, trend.shift_percent, "after", 2.2)
    if shows_limit:
        drawing.line(np.array(x_ends), np.full(2, trend.limit_percent), "noise thin")
    if trend.change.changed:
        _upright(drawing, trend.change.since, y_ends, "back thin")
    if life is not None and math.isfinite(life.low):
        until = min(life.high, x_ends[1] - float(trend.days[-1]))
        fan = trend.days[-1] + np.array([0.0, life.low, until])
        drawing.band(
            fan, np.array([life.now, trend.limit_percent, trend.limit_percent]), np.array([life.now, life.now, trend.limit_percent]), ""
        )
    return drawing.svg()


def _upright(drawing: Drawing, day: float, y_ends: tuple[float, float], kind: str) -> None:
    drawing.line(np.array([day, day]), np.array(y_ends), kind)


def _card(one: UnitHistory, page: str) -> str:
    drawn = "".join(drawing(trend) for trend in one.trends)
    return f'<figure class="{_tone(one)}"><h3><a href="{escape(page)}">{escape(one.unit)}</a></h3>{drawn}<figcaption>{escape(unit_words(one))}</figcaption></figure>'


def _tone(one: UnitHistory) -> str:
    if math.isfinite(one.urgency[0]):
        return "bad"
    return "unsure" if any(trend.change.changed for trend in one.trends) else "good"


def _unit_row(one: UnitHistory, page: str) -> str:
    trends = {trend.name: trend for trend in one.trends}
    last = one.last
    drifts = (
        listed([f"{SHORT[name]} {words.shift(trend.change.by)}" for name, trend in trends.items() if trend.change.changed])
        if trends
        else ""
    )
    cells = (
        *(words.shift(float(trends[name].shift_percent[-1])) if name in trends else "–" for name in SHORT),
        drifts or "no",
        soonest(one) if math.isfinite(one.urgency[0]) else "–",
        (last.verdict or "–") if last is not None else "–",
        str(len(one.rows)),
        str(len(one.bad)),
    )
    return f'<tr><th scope="row"><a href="{escape(page)}">{escape(one.unit)}</a></th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}</tr>'


def _record_row(row: FleetRow) -> str:
    def value(name: str) -> tuple[str, str]:
        shift, low, high = (getattr(row, f"{name}_{what}_percent") for what in ("shift", "low", "high"))
        if shift is None:
            return "–", "–"
        counted = "" if told(row, name) else " (not counted)"
        return words.shift(shift) + counted, words.interval(low, high) if low is not None and high is not None else "–"

    why = row.reason if row.status == "bad" else row.reasons + (f"; missing: {row.effect}" if row.effect else "")
    cells = (Path(row.file).name, row.kind, "not judged" if row.status == "bad" else row.verdict or "–", *value("csj"), *value("blk"))
    return f'<tr><th scope="row">{row.date.date().isoformat()}</th>{"".join(f"<td>{escape(cell)}</td>" for cell in cells)}<td class="words">{escape(why)}</td></tr>'


def _table(label: str, heads: Sequence[str], rows: str) -> str:
    shown = "".join(f'<th scope="col">{escape(head)}</th>' for head in heads)
    return f'<div class="scroll" role="region" aria-label="Table: {label}" tabindex="0"><table class="plain"><thead><tr>{shown}</tr></thead><tbody>{rows}</tbody></table></div>'


def _document(title: str, sentence: str, body: str) -> str:
    assets = resources.files("ema_tools.words.page") / "assets"
    style = "\n".join((assets / name).read_text(encoding="utf-8") for name in ("diagnosis.css", "fleet.css"))
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(title)}: {escape(sentence)}</title>
<style>
{style}</style>
</head>
<body>
<a class="skip" href="#main">Skip to the answer</a>
<main id="main">
<header><h1>{escape(sentence)}</h1></header>
{body}
</main>
</body>
</html>
"""
