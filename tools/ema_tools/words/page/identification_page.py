"""The page of one identification: the verdict and the two sizes on the first screen, and all that stands behind them in sections."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Sequence
from html import escape

from ema_tools.data.actuator import Row, row_of
from ema_tools.words.advice import advice_for_reason
from ema_tools.words.command_line import line_of
from ema_tools.words.page import figures, names, rest, signals, workbench
from ema_tools.words.page import text as words
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.gauges import gauges, value_words
from ema_tools.words.page.identification_screen import SHORT, first_screen_of, objective, shift_words, sizes_of
from ema_tools.words.page.results import ShownIdentification
from ema_tools.words.page.sheet import Chapter, document, kept, origin, table
from ema_tools.words.page.tables import beside_paper
from ema_tools.words.page.uplot import ABSENT, library
from ema_tools.words.sentences.identification import determined_words, new_sentence, table_sentence, values_sentence

_MODELS = {"before": "healthy values", "after": "identified values"}
_UM = 1000.0  # um in a mm [physics]
_ALIKE = 0.1  # correlation of neighbouring rows of a residual: below it they are noise to each other [judgement]
_KEYS = {
    "estimate": '<li><span class="key dot"></span>estimate, 95 %</li>',
    "healthy": '<li><span class="key diamond full"></span>healthy</li>',
    "best": '<li><span class="key after"></span>best so far</li>',
    "candidate": '<li><span class="key dot candidate"></span>candidate</li>',
}


def render(result: ShownIdentification, command: str) -> str:
    """The page as text. `command` made it and stands in its provenance."""
    found = signals.traces(result.curves, result.found.curves)
    titles = {key: _MODELS.get(key, key) for key in found.curves.models} if found is not None else {}
    chapters = [
        Chapter("signals", "Signals", signals.section(found, titles, "" if library().there else ABSENT)),
        Chapter("objections", "What objects", _objections(result)),
        Chapter("sizes", "How sure", _sizes(result)),
        Chapter("rest", "Is the rest noise?", _rest(result, found, titles)),
        Chapter("values", "Values", _values(result)),
        Chapter("workbench", "Workbench", workbench.markup(result.workbench) if result.workbench is not None else ""),
        Chapter("paper", "Beside the paper", _paper(result)),
        Chapter("search", "Search", _search(result)),
        Chapter("next", "What next", _next(result)),
        Chapter("provenance", "Provenance", _provenance(result, command)),
    ]
    data = signals.packed_signals(found, titles, {}) if found is not None else {}
    return document(result.title, first_screen_of(result), gauges(result), chapters, data, result.workbench is not None)


def _objections(result: ShownIdentification) -> str:
    """Why the answer stands or does not: reasons with what to do, the effect behind it, and what was held against it."""
    found = result.found
    parts = []
    for reason in result.reasons:
        advice = _code(advice_for_reason(reason))
        parts.append(f"<li>{_reason(reason)}.{f' {advice}' if advice else ''}</li>")
    said = {
        "fault": "Nothing: a shift exceeds its threshold with the stated confidence.",
        "healthy": "Nothing: every shift stays below the threshold at which it is called a fault.",
    }.get(result.verdict, "The search finds values that fit best, and they do not stand:" if parts else "No reason was given.")
    # what a verdict says besides, as of today's temperature and of few healthy records
    besides = f"<p>{kept(found.sentence)}</p>" if found.sentence and result.verdict != "undecided" else ""
    html = [f"<p>{said}</p>", besides, f'<ul class="told">{"".join(parts)}</ul>' if parts else ""]
    html.append(_effect(result))
    guard = found.guard
    if guard is not None and guard.signals:
        shown = names.listed([names.signal(name).lower().replace(",", "") for name in guard.signals])
        html.append(f"<p>The answer was held against {escape(shown)}{f': {escape(guard.skipped)}' if guard.skipped else ''}.</p>")
    elif guard is None:
        html.append("<p>No other signal was asked: this is what the onboard module says alone.</p>")
    if found.table is not None:
        html.append(f"<p>{escape(table_sentence(found.table))}</p>")
    return "".join(html)


def _reason(text: str) -> str:
    """A reason as a sentence, with the command in it set as code."""
    shown = kept(text[:1].upper() + text[1:])
    return re.sub(r"ema (?:add|next|diagnose) .+?(?= (?:puts|finds|looks|draws)\b)", lambda found: f"<code>{found[0]}</code>", shown)


def _effect(result: ShownIdentification) -> str:
    """The effect that is missing, or does as well: its values, what looks like it, and what tells it from others."""
    effect = result.found.missing_effect
    if effect is None or effect.name is None:
        return ""
    sizes = "; ".join(sizes_of(result))
    beside = "; ".join(_faults_beside(result))
    alike = names.listed([names.within(name) for name in effect.alike if name != effect.name]) or "nothing of the library"
    against = f"beside {effect.against_healthy_records} healthy records" if effect.against_healthy_records else "without healthy records"
    row = (
        f'<tr><th scope="row">{names.titled(effect.name)}</th><td class="words">{kept(sizes)}</td>'
        f'<td class="words">{kept(beside)}</td><td class="words">{escape(alike)}</td></tr>'
    )
    caption = f"What stands behind it, {against}; size ± half of its 95 % interval."
    shown = table("effect", caption, ("Effect", "<Size", "<CSJ and BLK beside it", "<Looks alike"), [row])
    line = line_of(result.provenance.get("command", ""))
    others = [name for name in effect.alike if name != effect.name]
    if not others:
        return shown
    between = shlex.join(["ema", "next", line.actuator if line is not None else "ACTUATOR.toml", "--between", effect.name, others[0]])
    return f"{shown}<p><code>{escape(between)}</code> says which command tells them apart.</p>"


def _faults_beside(result: ShownIdentification) -> list[str]:
    effect, guard = result.found.missing_effect, result.found.guard
    told = []
    for name, value in effect.beside_it.items() if effect is not None else ():
        key = name.partition(".")[2]
        shift = guard.shift_percent.get(key) if guard is not None else None
        shown = f" ({words.shift(shift)})" if shift is not None else ""
        told.append(f"{SHORT.get(key, key)} {words.number(value, 4)} {names.unit_of(name)}{shown}")
    return told


def _sizes(result: ShownIdentification) -> str:
    """Everything that is known of CSJ and BLK, and how the error rises away from them."""
    parts = [f"<p>{kept(said)}</p>" for said in result.undetermined.values()]
    rows = [_row(result, name) for name in result.faults]
    rows += [
        f'<tr><th scope="row">{escape(names.FAULT_TITLES[name.partition("_")[0]])}</th><td colspan="5" class="words">not identified: {escape(why)}</td></tr>'
        for name, why in result.left_out.items()
    ]
    caption = "The interval counts everything that moves the estimate; ± one standard deviation of what one cause alone does, in % of the healthy value."
    heads = ("Value", "Shift, 95 %", "<In its unit", "By noise alone", "By what a day changes", "All signals")
    parts.append(table("CSJ and BLK", caption, heads, rows))
    baseline = result.found.baseline
    if baseline is not None:
        told = []
        for name, value in baseline.values.items():
            low, high = baseline.interval95.get(name, (None, None))
            ends = f" ({words.interval(low, high)})" if low is not None and high is not None else ""
            told.append(f"{SHORT.get(name.partition('.')[2], name)} {words.number(value, 4)} {names.unit_of(name)}{ends}")
        many = "s" if baseline.records > 1 else ""
        parts.append(f"<p>Healthy values from {baseline.records} healthy record{many}: {kept('; '.join(told))}.</p>")
        if baseline.without:
            parts.append(f"<p>{kept(new_sentence(baseline.without))}</p>")
    parts.append(_seeds(result))
    parts.append(_shape(result))
    return "".join(parts)


def _row(result: ShownIdentification, name: str) -> str:
    one, entry, guard = result.faults[name], result.found.estimates[name], result.found.guard
    shift, ends = shift_words(one)
    noise = "–" if entry.std is None or not math.isfinite(entry.std) else f"± {words.number(100.0 * entry.std / abs(one.healthy), 2)} %"
    day = guard.open_std_percent.get(name) if guard is not None else None
    every = guard.shift_percent.get(name) if guard is not None else None
    cells = (
        f"<td>{kept(f'{shift} ({ends})' if ends else shift)}{', not determined by this record' if not ends or name in result.undetermined else ''}</td>",
        f'<td class="words">{kept(value_words(name, one))}{", at a bound of the search" if one.at_bound else ""}</td>',
        f"<td>{kept(noise)}</td>",
        f"<td>{kept('–' if day is None else f'± {words.number(day, 2)} %')}</td>",
        f"<td>{kept('–' if every is None else words.shift(every))}</td>",
    )
    return f'<tr><th scope="row">{escape(names.FAULT_TITLES[name.partition("_")[0]])}</th>{"".join(cells)}</tr>'


def _seeds(result: ShownIdentification) -> str:
    """How much the answer hangs on the seed of the search."""
    told = []
    for name, one in result.faults.items():
        others = [value for other in result.found.seeds if (value := getattr(other, name)) is not None]
        if others:
            values = [one.estimate, *others]
            told.append(
                f"{SHORT[name]} by {words.number(100.0 * (max(values) - min(values)) / abs(one.healthy), 2)} % over {len(values)} seeds"
            )
    return f"<p>Its seed moves the answer little: {kept(', '.join(told))} of the healthy value.</p>" if told else ""


def _figure(identity: str, title: str, keys: Sequence[str], figure: figures.Figure, caption: str) -> str:
    legend = f'<ul class="legend">{"".join(keys)}</ul>' if keys else ""
    return (
        f'<figure><div class="figure-head"><h3>{title}</h3>{legend}</div>{figure_svg(figure, identity)}'
        f"<figcaption>{caption}</figcaption></figure>"
    )


def _shape(result: ShownIdentification) -> str:
    """The objective round the answer."""
    drawn = []
    if result.profiles:
        limit = '<li><span class="key noise"></span>limit of noise</li>'
        caption = (
            "The other values follow along the valley. A value under the dashed line would explain this record as well; "
            "the bar counts what differs from day to day, too."
        )
        keys = (_KEYS["estimate"], _KEYS["healthy"], limit)
        drawn.append(_figure("profiles", "The error along each parameter", keys, figures.profiles(result), caption))
    if result.map is not None:
        caption = "Logarithmic; dark is small. Candidates beyond the map are not drawn."
        keys = (_KEYS["candidate"], _KEYS["best"], _KEYS["healthy"])
        drawn.append(_figure("map", "The error over both, and the way of the search", keys, figures.surface(result), caption))
    return f'<div class="pair">{"".join(drawn)}</div>' if drawn else ""


def _rest(result: ShownIdentification, found: signals.Traces | None, titles: dict[str, str]) -> str:
    """What the identified values leave of every signal."""
    rms, alike = result.found.residual_rms_mm, result.found.residual_correlation
    parts = []
    if rms is not None:
        said = f"{words.number(_UM * rms)} µm rms of the rod position are left"
        if alike is not None:
            kind = "as of noise, which knows nothing of the row before" if abs(alike) < _ALIKE else "so that something lasts in it"
            said += f"; neighbouring rows are alike by {words.number(alike, 2)}, {kind}"
        parts.append(f"<p>{'Yes' if result.adequate else 'No'}: {kept(said)}.</p>")
    parts.append(rest.spectra(found, titles, {}))
    return "".join(parts)


def _values(result: ShownIdentification) -> str:
    """Several values that were searched at once."""
    several, search = result.found.values, result.found.values_search
    if not several or search is None:
        return ""
    rows = []
    for name, one in several.items():
        row: Row = row_of(name)
        low, high = one.interval95 or (None, None)
        ends = words.interval(low, high) if low is not None and high is not None else "–"
        shown = f"<code>{escape(name)}</code>" + (f" and <code>{escape(one.companion)}</code>" if one.companion else "")
        rows.append(
            f'<tr><th scope="row">{shown}</th><td>{kept(f"{words.number(one.before, 4)} {row.unit}")}</td><td>{kept(f"{words.number(one.estimate, 4)} {row.unit}")}</td>'
            f'<td>{escape(ends)}</td><td class="words">{escape(determined_words(one))}</td></tr>'
        )
    said = values_sentence(several, search)
    return f"<p>{kept(said)}</p>" + table(
        "values", "Searched at once, by every signal.", ("Value", "Before", "Estimate", "95 %", "<Determined"), rows
    )


def _paper(result: ShownIdentification) -> str:
    if result.case is None:
        return ""
    made = "<p>The record was made by an independent model of this actuator in double precision; the module saw the record alone.</p>"
    return f"{made}{beside_paper([result])}"


def _search(result: ShownIdentification) -> str:
    """How the answer was found."""
    found = result.found
    time = f" in {words.duration(result.wall_s)} on one core" if result.wall_s is not None else ""
    steps = f", {words.number(float(found.model_steps))} model steps" if found.model_steps is not None else ""
    taken = f"; {found.accepted} candidates were taken, {found.accepted_uphill} of them worse" if found.accepted is not None else ""
    ended = f"; ended by {found.outcome}" if found.outcome else ""
    parts = [
        f"<p>{kept(f'{result.evaluations} model runs{time}{steps}{taken}{ended}. Position error, squared and integrated: {objective(result)}')}.</p>"
    ]
    parts += [f'<p class="unsure">{escape(warning[:1].upper() + warning[1:])}.</p>' for warning in found.warnings or ()]
    if result.search is not None:
        caption = "A candidate that could no longer be accepted was given up early; its dot is the error that had come together by then."
        keys = (_KEYS["candidate"], _KEYS["best"])
        parts.append(f'<div class="pair">{_figure("runs", "Run by run", keys, figures.search(result), caption)}</div>')
    return "".join(parts)


def _next(result: ShownIdentification) -> str:
    """The commands from here on, with the files that were given."""
    line = line_of(result.provenance.get("command", ""))
    actuator, record = (line.actuator, line.records[0]) if line is not None and line.records else ("mine.toml", "today.csv")
    commands = (
        ("ema calibrate mine.toml healthy*.csv -o calibrated.toml", "the unit's own model, from its healthy runs"),
        (f"ema identify calibrated.toml {shlex.quote(record)} --json today.json", "CSJ and BLK beside those runs"),
        (f"ema diagnose {shlex.quote(actuator)} {shlex.quote(record)}", "what is missing, and where"),
        ("ema report today.json -o today.html", "this page; of several results the unit over its dates"),
        ("ema export calibrated.toml -o ema_actuator_data.h", "what the firmware compiles in"),
    )
    items = "".join(f"<li><code>{escape(command)}</code>: {escape(why)}</li>" for command, why in commands)
    return f'<p>The first screen has the next command. To ask the same of another unit or on another day:</p><ul class="told">{items}</ul>'


def _provenance(result: ShownIdentification, command: str) -> str:
    said = result.found.sentence if result.verdict == "undecided" else ""
    return (f'<p class="full">{kept(said)}</p>' if said else "") + origin(command, result.provenance)


def _code(text: str) -> str:
    """Escaped text with `words` in backquotes set as code."""
    return re.sub(r"`([^`]*)`", r"<code>\1</code>", escape(text))
