"""The page: one self-contained HTML file for one or several results."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from functools import partial
from html import escape
from importlib import resources
from typing import Any

from ema_tools.results.over_dates import UnitOverDates
from ema_tools.words.page import diagnosis, diagnosis_page, figures, friction_map, identification_page, over_dates, workbench
from ema_tools.words.page import text as words
from ema_tools.words.page.curves import pack
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.gauges import gauges
from ema_tools.words.page.recorded import Curves
from ema_tools.words.page.results import Mapped, Result, ShownComparison, ShownIdentification
from ema_tools.words.page.tables import beside_paper, compared_tables
from ema_tools.words.page.uplot import ABSENT, library

_NAMES = {"csj_Nm": ("CSJ", "static dry friction", "Nm"), "blk_mm": ("BLK", "backlash at the rod", "mm")}


# The browser itself sees to it that the page asks nothing of any network.
_POLICY = f"default-src 'none'; {workbench.POLICY}; style-src 'unsafe-inline'; img-src data:"


class Page:
    """Collects the page's parts: HTML, and what its script draws."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self.curves: list[dict[str, Any]] = []
        self.lines: list[dict[str, Any]] = []

    def add(self, *html: str) -> None:
        self.parts.extend(html)

    def figure(self, identity: str, figure: figures.Figure) -> str:
        """The figure as it stands in the page."""
        return figure_svg(figure, identity)


def render(results: list[Result], command: str, units: Sequence[UnitOverDates] = ()) -> str:
    """The page as text. `command` made it and stands in its provenance; `units`: results of one unit over dates. One diagnosis, addition or identification has a page of its own."""
    if len(results) == 1 and isinstance(results[0], Diagnosed):
        return diagnosis_page.render(results[0], command)
    if len(results) == 1 and isinstance(results[0], ShownIdentification):
        return identification_page.render(results[0], command)
    page = Page()
    identified = [result for result in results if isinstance(result, ShownIdentification)]
    compared = [result for result in results if isinstance(result, ShownComparison)]
    page.add('<a class="skip" href="#main">Skip to the results</a>', '<header><div class="wrap">')
    _head(page, results)
    page.add("</div></header>", '<main id="main">')
    if units:
        page.add(
            '<section id="dates" aria-labelledby="dates-title"><div class="wrap"><h2 id="dates-title">Over dates</h2>',
            over_dates.section(units),
            "</div></section>",
        )
    for index, result in enumerate(results, start=1):
        page.add(f'<section id="result-{index}" aria-labelledby="result-{index}-title"><div class="wrap">')
        if isinstance(result, ShownIdentification):
            identified_section(page, result, f"result-{index}")
        elif isinstance(result, Diagnosed):
            diagnosis.section(page, result, f"result-{index}", partial(_curves, page))
        elif isinstance(result, Mapped):
            friction_map.section(page, result, f"result-{index}")
        else:
            _compared(page, result, f"result-{index}")
        page.add("</div></section>")
    # one workbench a page, of the first result that brings what it needs
    bench = next((result.workbench for result in results if not isinstance(result, Mapped) and result.workbench is not None), None)
    if bench is not None:
        page.add(workbench.section(bench))
    with_case = [result for result in identified if result.case is not None]
    if with_case:
        paper_section(page, with_case)
    _next(page, identified, compared, [result for result in results if isinstance(result, Diagnosed)])
    origin_section(page, results, command)
    page.add("</main>")
    return document(_short_title(results[0]), page)


def sentence(result: ShownIdentification) -> str:
    """The verdict in one sentence, e.g. for the page's title and the terminal."""
    shifts = " and ".join(f"{_NAMES[name][0]} {words.shift(result.faults[name].shift_percent)}" for name in result.faults)
    subject = "this recorded chirp of the reference actuator" if result.case is not None else f"the record {result.name}"
    if result.verdict == "fault":
        return f"{subject[0].upper()}{subject[1:]} carries {shifts}."
    if result.verdict == "healthy":
        return f"{subject[0].upper()}{subject[1:]} is of a healthy actuator: {shifts}."
    return f"No verdict on {subject}: the search reads {shifts}."


def finding(result: ShownIdentification) -> str:
    """How it was found and what became of the error, in one sentence."""
    time = f" in {words.duration(result.wall_s)}" if result.wall_s is not None else ""
    return (
        f"Found by the onboard module with {result.evaluations} model runs{time}; "
        f"position error {_error(result)} "
        f"({words.reduction(result.before_mm2s, result.after_mm2s)})."
    )


def _error(result: ShownIdentification) -> str:
    """Objective before and after."""
    return f"{words.number(result.before_mm2s)} → {words.number(result.after_mm2s)} mm² s"


def verdict(result: ShownIdentification) -> str:
    """What the module concludes, in one sentence."""
    if result.verdict == "fault":
        return "a shift exceeds its threshold with the stated confidence."
    if result.verdict == "healthy":
        if len(result.faults) == 1:
            return "the shift stays below the threshold at which it is called a fault."
        return "both shifts stay below the thresholds at which a shift is called a fault."
    return f"{'; '.join(result.reasons)}." if result.reasons else "no reason was given."


def _title(result: Result) -> str:
    if isinstance(result, Diagnosed):
        return diagnosis.headline(result)
    if isinstance(result, Mapped):
        return result.title
    return sentence(result) if isinstance(result, ShownIdentification) else _worst(result)


def _worst(result: ShownComparison) -> str:
    """The title of a comparison: the balance that the model misses most, else the rod position."""
    known = {name: value[1] for name, value in result.balances.items() if isinstance(value, tuple)}
    if known:
        name = max(known, key=lambda key: known[key])
        return f"{result.title}: {name} balance off by {words.number(known[name])} %"
    share = result.channels.get("position_mm", (0.0, None))[1]
    return f"{result.title}: rod position off by {words.number(share)} %" if share is not None else result.title


def _short_title(result: Result) -> str:
    if not isinstance(result, ShownIdentification):
        return result.title
    return (
        ", ".join(f"{_NAMES[name][0]} {words.shift(result.faults[name].shift_percent)}" for name in result.faults) + f": {result.verdict}"
    )


def _head(page: Page, results: list[Result]) -> None:
    first = results[0]
    page.add('<p class="eyebrow">Electromechanical actuator: what its record says</p>', f"<h1>{_text(_title(first))}</h1>")
    if isinstance(first, ShownIdentification):
        made = (
            " The record was made by an independent model of this actuator in double precision; the module saw the record alone."
            if first.case
            else ""
        )
        doubt = f"Because {verdict(first)} " if first.verdict == "undecided" else ""
        page.add(f'<p class="lead">{_text(doubt + finding(first) + made)}</p>')
    elif first.sentence:
        page.add(f'<p class="lead">{_text(first.sentence)}</p>')
    if len(results) < 2:
        return
    page.add('<nav aria-label="Results"><ul class="tiles">')
    for index, result in enumerate(results, start=1):
        page.add(f'<li><a href="#result-{index}">{_tile(result)}</a></li>')
    page.add("</ul></nav>")


def _tile(result: Result) -> str:
    if isinstance(result, Diagnosed):
        return diagnosis.tile(result)
    if isinstance(result, Mapped):
        return friction_map.tile(result)
    if isinstance(result, ShownComparison):
        share = result.channels.get("position_mm", (0.0, None))[1]
        small = f"rod position {words.number(share)} % off" if share is not None else "rod position does not move"
        return f'<span class="head"><span>{escape(result.name)}</span></span><span class="big">Model against record</span><span class="small">{small}</span>'
    shifts = "<br>".join(f"{_NAMES[name][0]}\u00a0{words.shift(result.faults[name].shift_percent)}" for name in result.faults)
    return (
        f'<span class="head"><span>{escape(result.title)}</span><span class="verdict {result.verdict}">{result.verdict}</span></span>'
        f'<span class="big">{shifts}</span>'
        f'<span class="small">{_text(_error(result))}<br>{result.evaluations} model runs</span>'
    )


def identified_section(page: Page, result: ShownIdentification, identity: str) -> None:
    """Everything about one identification."""
    page.add(f'<h2 id="{identity}-title">{escape(result.title)}</h2>')
    page.add(f'<p><span class="verdict {result.verdict}">{result.verdict.capitalize()}:</span> {escape(verdict(result))}</p>')
    page.add(gauges(result), '<dl class="facts">')
    for name in result.faults:
        short, long, unit = _NAMES[name]
        fault = result.faults[name]
        actual = f"true {getattr(result.case, name):g}, " if result.case is not None else ""
        spread = "" if fault.interval is None else f"95 %: {words.interval(*fault.interval)} {unit}, "
        doubt = "not determined by this record, " if fault.interval is None or name in result.undetermined else ""
        page.add(
            f"<div><dt>{short}, {long}</dt><dd>{words.number(fault.estimate, 5)} {unit}"
            f"<small>{spread}{doubt}{actual}healthy {fault.healthy:.4g} {unit}</small></dd></div>"
        )
    for name, reason in result.left_out.items():
        page.add(f"<div><dt>{_NAMES[name][0]}, {_NAMES[name][1]}</dt><dd>–<small>not identified: {escape(reason)}</small></dd></div>")
    page.add(
        f"<div><dt>Position error E<sub>int</sub></dt><dd>{_text(_error(result))}"
        f"<small>{words.reduction(result.before_mm2s, result.after_mm2s)}</small></dd></div>"
    )
    time = f"<small>{words.duration(result.wall_s)} on one core</small>" if result.wall_s is not None else ""
    page.add(f"<div><dt>Model runs</dt><dd>{result.evaluations}{time}</dd></div></dl>")
    for undetermined in result.undetermined.values():
        page.add(f"<p>{escape(undetermined)}</p>")
    if result.curves is not None:
        _curves(page, result.curves, identity, {"before": "Before: healthy values", "after": "After: identified values"})
    page.add('<div class="pair">')
    if result.search is not None:
        page.add('<figure><div class="figure-head"><h3>The search</h3><ul class="legend">')
        page.add('<li><span class="key dot candidate"></span>candidate</li><li><span class="key after"></span>best so far</li></ul></div>')
        page.add(page.figure(f"{identity}-search", figures.search(result)))
        page.add(
            "<figcaption>A candidate that could no longer be accepted was given up early; its dot is the error that had come together by then.</figcaption></figure>"
        )
    page.add("</div>")
    _shape(page, result, identity)


def _shape(page: Page, result: ShownIdentification, identity: str) -> None:
    """The objective round the answer."""
    if not result.profiles:
        return
    page.add('<div class="pair">')
    page.add(
        '<figure><div class="figure-head"><h3>The error along each parameter</h3><ul class="legend"><li><span class="key after"></span>profile</li>'
    )
    page.add('<li><span class="key dot"></span>estimate, 95 %</li><li><span class="key diamond full before"></span>healthy</li>')
    page.add(
        '<li><span class="key dashed"></span>limit of noise</li></ul></div>', page.figure(f"{identity}-profiles", figures.profiles(result))
    )
    page.add(
        "<figcaption>The other values follow along the valley. A value under the dashed line would explain this record as well; "
        "the bar counts what differs from day to day, too.</figcaption></figure>"
    )
    if result.map is not None:
        page.add('<figure><div class="figure-head"><h3>The error over both, and the way of the search</h3><ul class="legend">')
        page.add('<li><span class="key dot soft"></span>candidate</li><li><span class="key after"></span>best so far</li>')
        page.add(
            '<li><span class="key diamond full before"></span>healthy</li></ul></div>',
            page.figure(f"{identity}-map", figures.surface(result)),
        )
        page.add("<figcaption>Logarithmic; dark is small. Candidates beyond the map are not drawn.</figcaption></figure>")
    page.add("</div>")


def _curves(page: Page, curves: Curves, identity: str, models: dict[str, str]) -> None:
    packed = pack(curves)
    for channel in packed["channels"]:
        channel["rms_text"] = {key: f"{words.number(value)} {channel['residual_unit']}" for key, value in channel.pop("rms").items()}
    page.curves.append({"id": identity, **packed})
    page.add('<div class="bar"><ul class="legend"><li><span class="key measured"></span>measured</li>')
    for key, title in models.items():
        page.add(f'<li><span class="key {_role(key)}"></span>simulated{"" if key == "model" else ", " + escape(title.split(": ")[1])}</li>')
    page.add('</ul><div class="zoom" role="group" aria-label="Zoom of the curves">')
    for how, text in (("whole", "Whole record"), ("in", "Zoom in"), ("out", "Zoom out"), ("earlier", "← Earlier"), ("later", "Later →")):
        page.add(f'<button type="button" data-zoom="{how}" data-zoom-of="{identity}">{text}</button>')
    page.add(f'</div></div><div class="{"pair" if len(models) > 1 else "single"}">')
    titles = ", ".join(channel["title"].lower() for channel in packed["channels"])
    absent = "" if library().there else f'<p class="absent">{escape(ABSENT)}</p>'
    for key, title in models.items():
        label = f"{title}. Measured and simulated {titles} against time, each with its residual. " + "; ".join(
            f"{channel['title']} residual rms {channel['rms_text'][key]}" for channel in packed["channels"]
        )
        page.add(f'<figure><div class="figure-head"><h3>{escape(title)}</h3></div>{absent}')
        page.add(
            f'<div class="curves" data-curves="{identity}" data-model="{key}" role="group" aria-label="{escape(label)}"></div></figure>'
        )
    page.add("</div>")
    scale, follow = (", on the same scale before and after", "; all follow") if len(models) > 1 else ("", "")
    derived = " Speed is the slope of the position over 9 rows, the same for every curve." if curves.derived else ""
    page.add(f'<p class="note">Under each signal: measured minus simulated{scale}. Drag across a plot to zoom{follow}.{derived}</p>')


def _role(model: str) -> str:
    return "before" if model == "before" else "after"


def paper_section(page: Page, results: list[ShownIdentification]) -> None:
    """The cases beside what the paper prints for them."""
    page.add('<section id="paper" aria-labelledby="paper-title"><div class="wrap"><h2 id="paper-title">Beside the paper</h2>')
    page.add(
        "<p>Dalla Vedova, Lauria, Maggiore and Pace search the same two parameters with simulated annealing. They print no electrical data, gear ratio, gains or "
        "sweep, so the reference actuator here is an estimate that agrees with all they do print.</p>"
    )
    page.add(beside_paper(results))
    page.add(
        '<figure><div class="figure-head"><h3>Error of the estimates</h3><ul class="legend"><li><span class="key dot"></span>here</li>'
    )
    page.add('<li><span class="key diamond full"></span>paper</li></ul></div>', page.figure("paper-accuracy", figures.accuracy(results)))
    page.add(
        "<figcaption>Logarithmic: each step is ten times; an error below 0.0001 % is drawn at 0.0001 %. "
        "The records were made by an independent model in double precision.</figcaption></figure></div></section>"
    )


def _compared(page: Page, result: ShownComparison, identity: str) -> None:
    page.add(f'<h2 id="{identity}-title">{escape(result.title)}</h2>')
    if result.sentence and identity != "result-1":
        page.add(f"<p>{_text(result.sentence)}</p>")
    if result.curves is not None:
        _curves(page, result.curves, identity, {"model": "Measured and simulated"})
    page.add(compared_tables(result))
    if result.where:
        page.add(
            '<figure><div class="figure-head"><h3>Where the error sits</h3><ul class="legend"><li><span class="key dot before"></span>share of the squared error</li>'
        )
        page.add(
            '<li><span class="key ring"></span>share of the time</li></ul></div>',
            page.figure(f"{identity}-where", figures.shares(result.where)),
        )
        page.add(
            "<figcaption>Parts of the record that hold more of a residual than of the time, the most telling first.</figcaption></figure>"
        )


def _next(page: Page, identified: list[ShownIdentification], compared: list[ShownComparison], diagnosed: Sequence[Diagnosed]) -> None:
    page.add('<section id="next" aria-labelledby="next-title"><div class="wrap"><h2 id="next-title">What to do next</h2>')
    for result in identified:
        for reason in result.reasons:
            if words.advice(reason):
                page.add(f"<p>{escape(result.title)}: {_code(words.advice(reason))}</p>")
    if diagnosed and all(result.by_forces for result in diagnosed) and not identified:
        page.add(
            "<p>The effects go into the model, which is then held against a record to which nothing was fitted:</p>",
            "<pre><code>ema diagnose mine.toml records/ --fitted found.toml\n"
            "ema compare found.toml another_record.csv\n"
            "ema map mine.toml records/    # friction against speed</code></pre></div></section>",
        )
        return
    if diagnosed:
        page.add(
            "<p>An effect that is recommended goes into the model, and from there into the firmware:</p>",
            "<pre><code>ema add mine.toml EFFECT --fit today.csv --holdout other.csv -o better.toml\n"
            "ema diagnose better.toml today.csv --healthy repeat1.csv --healthy repeat2.csv    # again, to the floor</code></pre>",
        )
    if compared:
        page.add("<p>Where one block holds most of the error, fit its parameters on a healthy record: <code>ema calibrate</code>.</p>")
    page.add(
        "<p>To ask the same of your own actuator, record a chirp of the healthy one and a chirp of today, write its data into a copy of "
        "<code>actuators/reference.toml</code>, then:</p>",
        "<pre><code>ema calibrate mine.toml healthy.csv -o calibrated.toml\n"
        "ema identify calibrated.toml today.csv --json today.json\n"
        "ema report today.json -o today.html\n"
        "ema export calibrated.toml -o ema_actuator_data.h    # what the firmware compiles in</code></pre></div></section>",
    )


def _code(text: str) -> str:
    """Escaped text with `words` in backquotes set as code."""
    pieces = escape(text).split("`")
    return "".join(f"<code>{piece}</code>" if index % 2 else piece for index, piece in enumerate(pieces))


def origin_section(page: Page, results: Sequence[Result], command: str) -> None:
    """What made the page and its results."""
    page.add(
        '<section id="origin" aria-labelledby="origin-title"><div class="wrap"><h2 id="origin-title">Where this comes from</h2><dl class="origin">'
    )
    page.add(f"<dt>page</dt><dd><code>{escape(command)}</code></dd>")
    shared = _shared([result.provenance for result in results])
    for key, value in shared.items():
        page.add(f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>")
    for result in results:
        own = {key: value for key, value in result.provenance.items() if key not in shared}
        if own:
            page.add(
                f"<dt>{escape(result.title)}</dt><dd>{'<br>'.join(f'{escape(key)}: {escape(value)}' for key, value in own.items())}</dd>"
            )
    page.add("</dl></div></section>")


def _text(text: str) -> str:
    """Escaped text in which a number stays on one line with its unit."""
    return escape(re.sub(r"(?<=\d) (?=%|mm|Nm|µm|s\b)|(?<=mm²) (?=s\b)", "\u00a0", text))


def _shared(tables: Iterable[dict[str, str]]) -> dict[str, str]:
    """Entries that all tables have alike."""
    first, *others = tables
    return {key: value for key, value in first.items() if all(other.get(key) == value for other in others)}


def document(title: str, page: Page) -> str:
    """The whole file."""
    assets = resources.files("ema_tools.words.page") / "assets"
    style = "\n".join((assets / name).read_text(encoding="utf-8") for name in ("page.css", "gauges.css", "charts.css", "curves.css"))
    names = ["curves.js", *(["lines.js"] if page.lines else [])]
    script = "\n".join((assets / name).read_text(encoding="utf-8") for name in names)
    loaded = library()
    draws = f"<script>{loaded.script}</script>" if loaded.there else ""
    # `<` would let a text in the data end the script element.
    data = json.dumps({"curves": page.curves, "lines": page.lines}, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    body = "\n".join(page.parts)
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{_POLICY}">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
{loaded.style}
{style}</style>
</head>
<body>
{body}
<noscript><div class="wrap"><p>The curves need JavaScript; the sentences and tables do not.</p></div></noscript>
<script id="page-data" type="application/json">{data}</script>
{draws}
<script>
{script}</script>
</body>
</html>
"""
