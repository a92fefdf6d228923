"""The pages of a fleet: all units, the most urgent first, and one page for each; files that open from disk and ask nothing of any network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path

from ema_tools.library.display_names import coded
from ema_tools.results.fleet import FleetResult, FleetUnitEntry
from ema_tools.results.store import FleetRow
from ema_tools.words.page import text as words
from ema_tools.words.page.names import listed
from ema_tools.words.page.sheet import kept, table
from ema_tools.words.page.trend import SHORT, drawing, legend

_WORDS = ' class="words"'
CARDS_MAX = 200  # units that are drawn on the fleet's page; all are in its table [layout]
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"


def fleet_page(found: FleetResult, pages: Mapping[str, str], command: str) -> str:
    """All units. `pages`: where each one's own page is, from this one."""
    units = found.units
    cards = "".join(_card(one, pages[one.unit]) for one in units[:CARDS_MAX])
    rest = (
        f'<p class="note">Drawn are the {CARDS_MAX} most urgent of {len(units)} units; the table has all.</p>'
        if len(units) > CARDS_MAX
        else ""
    )
    rows = [_unit_row(one, pages[one.unit]) for one in units]
    heads = ("Unit", "CSJ", "BLK", "<Drifts", "<Reaches a limit", "<Last verdict", "Records", "Not judged")
    stated = " and ".join(f"{SHORT[name]} +{percent:g} %" for name, percent in found.limits_percent.items())
    notes = (
        f"Sorted by urgency: the lower end of the remaining life, then how near the last reading is to its limit ({stated} of the healthy value). A unit drifts where a step or a ramp from some day "
        f"on stands out more than in all but {100.0 * found.false_alarm:g} % of units that do not change; the shaded band is the 95 % interval of each reading, intervals of remaining life are 90 %. "
        "CSJ is the static dry friction of the mechanism, BLK the backlash at the rod."
    )
    return _document(
        "Fleet",
        found.sentence,
        f'<section id="units"><h2>Units</h2><p class="note">{escape(notes)}</p>{rest}{legend(cards, "all units")}<div class="cards">{cards}</div></section>'
        f'<section id="table"><h2>All units</h2>{table("all units", "By the last reading of each; – where none counts, or nothing is reached.", heads, rows)}</section>'
        f'<section id="made"><h2>Provenance</h2><p><code>{escape(command)}</code></p></section>',
    )


def unit_page(one: FleetUnitEntry, records: Sequence[FleetRow], back: str, command: str) -> str:
    """One unit: its trends and every record."""
    figures = "".join(
        f"<figure>{drawing(name, trend)}<figcaption>{escape(trend.sentence)}</figcaption></figure>" for name, trend in one.trends.items()
    )
    heads = ("Date", "<Record", "<Kind", "<Verdict", "CSJ", "95 %", "BLK", "95 %", "<Why")
    return _document(
        one.unit,
        one.sentence,
        f'<p><a href="{escape(back)}">All units</a></p><section id="trends"><h2>Trends</h2>{legend(figures, one.unit)}<div class="cards wide">{figures}</div></section>'
        f'<section id="records"><h2>Records</h2>{table("records", "Every recording of the unit, in the order of time.", heads, list(map(_record_row, records)))}</section>'
        f'<section id="made"><h2>Provenance</h2><p><code>{escape(command)}</code></p></section>',
    )


def _card(one: FleetUnitEntry, page: str) -> str:
    drawn = "".join(drawing(name, trend) for name, trend in one.trends.items())
    return f'<figure class="{_tone(one)}"><h3><a href="{escape(page)}">{escape(one.unit)}</a></h3>{drawn}<figcaption>{escape(_own_words(one))}</figcaption></figure>'


def _own_words(one: FleetUnitEntry) -> str:
    """Its sentence under its name, which need not stand there twice."""
    said = one.sentence.removeprefix(f"{one.unit}: ")
    return said[:1].upper() + said[1:] if said != one.sentence else said


def _tone(one: FleetUnitEntry) -> str:
    if one.soonest is not None:
        return "bad"
    return "unsure" if any(trend.changed for trend in one.trends.values()) else "good"


def _unit_row(one: FleetUnitEntry, page: str) -> str:
    drifts = [f"{SHORT[name]} {words.shift(trend.by_percent)}" for name, trend in one.trends.items() if trend.changed]
    cells = (
        *(words.shift(one.trends[name].shift_percent[-1]) if name in one.trends else "–" for name in SHORT),
        listed(drifts) if drifts else "no",
        one.soonest or "–",
        one.verdict or "–",
        str(one.records),
        str(one.not_judged),
    )
    return f'<tr><th scope="row"><a href="{escape(page)}">{escape(one.unit)}</a></th>{_cells(cells, (2, 3, 4))}</tr>'


def _record_row(row: FleetRow) -> str:
    def value(name: str) -> tuple[str, str]:
        shift, low, high = row.reading(name)
        if shift is None:
            return "–", "–"
        counted = "" if row.counts(name) else " (not counted)"
        return words.shift(shift) + counted, words.interval(low, high) if low is not None and high is not None else "–"

    why = row.reason if row.status == "bad" else row.reasons + (f"; missing: {coded(row.effect)}" if row.effect else "")
    cells = (Path(row.file).name, row.kind, "not judged" if row.status == "bad" else row.verdict or "–", *value("csj"), *value("blk"))
    return f'<tr><th scope="row">{row.date.date().isoformat()}</th>{_cells(cells, (0, 1, 2))}<td class="words">{escape(why)}</td></tr>'


def _cells(cells: Sequence[str], of_words: Sequence[int]) -> str:
    """Cells of a row; those of words stand left."""
    return "".join(f"<td{_WORDS if place in of_words else ''}>{escape(cell)}</td>" for place, cell in enumerate(cells))


def _together(text: str) -> str:
    """Escaped text in which an interval stays on one line."""
    return kept(text).replace(" … ", "\u00a0…\u00a0")


def _document(title: str, sentence: str, body: str) -> str:
    assets = resources.files("ema_tools.words.page") / "assets"
    style = "\n".join((assets / name).read_text(encoding="utf-8") for name in ("sheet.css", "charts.css", "fleet.css"))
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
<header><h1>{_together(sentence)}</h1></header>
{body}
</main>
</body>
</html>
"""
