"""The part of the page for a result of `ema diagnose` or `ema add`, in the order in which a reader asks: can the record answer, where does the model fail, what is missing, did the error fall,
what is still unknown."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Sequence
from html import escape
from typing import Protocol

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import row_of
from ema_tools.words.page import base_values, diagnosis_figures, figures
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed, Picture, ShownSuspect, Value
from ema_tools.words.page.recorded import Curves
from ema_tools.words.page.tables import CHANNEL_TITLES

DrawCurves = Callable[[Curves, str, dict[str, str]], None]

_BIN_PICTURES_MAX = 6
_UNKNOWN_PICTURES_MAX = 6
_LEFT = ' class="left"'
_SEVERITY = {"blocks": "blocks", "weakens": "weakens", "fine": "in order"}
_VERDICT = {"adequate": "nothing missing", "missing": "effect missing", "unknown": "unknown effect"}
_PICTURE_TITLES = {
    "torque without inertia": "Torque against speed",
    "torque over a turn": "Torque over one turn of the motor, less base values",
    "play loop": "Rod minus motor position",
    "torque loop": "Torque at reversals",
    "mechanical order": "Orders of the torque",
    "kinematic order": "Orders of the rod position",
}
_OTHER = {"model": "model", "healthy": "healthy repeats"}


class Sheet(Protocol):
    """What collects the page."""

    def add(self, *html: str) -> None:
        """Appends HTML."""

    def figure(self, identity: str, figure: figures.Figure) -> str:
        """Registers a figure; the element that it is drawn into."""


def headline(result: Diagnosed) -> str:
    """The answer for the page's title."""
    if result.added:
        return f"{result.added} added: {'force error, %,' if result.by_forces else 'weighted error'} {_fall(result)} on {result.name}"
    if result.verdict == "adequate":
        return f"{result.name}: nothing exceeds what the machine repeats"
    if result.verdict == "unknown":
        return f"{result.name}: something is there that the library does not hold"
    accepted = [one.name for one in result.suspects if one.accepted]
    return f"{result.name}: {' and '.join(accepted) or 'an effect'} missing in the model"


def tile(result: Diagnosed) -> str:
    """The result in a few words, for the overview."""
    verdict = result.verdict if not result.added else "fine"
    shown = "added" if result.added else _VERDICT[result.verdict]
    accepted = ", ".join(one.name for one in result.suspects if one.accepted) or result.added or "no effect named"
    return (
        f'<span class="head"><span>{escape(result.name)}</span><span class="verdict {verdict}">{shown}</span></span>'
        f'<span class="big">{escape(accepted)}</span><span class="small">weighted error {escape(_fall(result))}</span>'
    )


def _fall(result: Diagnosed) -> str:
    before, after = result.errors.get("before"), result.errors.get("after")
    if before is None:
        return "not known"
    return f"{words.number(before)} → {words.number(after)}" if after is not None else words.number(before)


def section(page: Sheet, result: Diagnosed, identity: str, draw: DrawCurves) -> None:
    """Everything about one diagnosis."""
    page.add(f'<h2 id="{identity}-title">{escape(result.title)}</h2>')
    # the sentence of the first result stands in the head of the page
    sentence = "" if identity == "result-1" else escape(result.sentence)
    verdict = "" if result.added else f'<span class="verdict {result.verdict}">{_VERDICT[result.verdict].capitalize()}.</span> '
    if verdict or sentence:
        page.add(f"<p>{verdict}{sentence}</p>")
    _gate(page, result)
    _where(page, result, identity)
    _which(page, result, identity)
    _fell(page, result, identity, draw)
    _unknown(page, result, identity)
    if result.next_experiment:
        page.add(f"<h3>What to measure next</h3><p>{escape(result.next_experiment)}</p>")


def _table(label: str, caption: str, heads: str, rows: list[str]) -> str:
    """A table whose rows stand as blocks where the page is narrow, each cell with the head of its column beside it."""
    titles = [re.sub(r"<[^>]*>", " ", head) for head in re.findall(r"<th[^>]*>(.*?)</th>", heads)]

    def titled(row: str) -> str:
        left = itertools.chain(titles, itertools.repeat(""))
        return re.sub(r"<(td|th)\b", lambda cell: f'{cell[0]} data-head="{next(left)}"', row)

    return (
        f'<div class="scroll" role="region" aria-label="Table: {label}" tabindex="0"><table class="stacks"><caption>{caption}</caption><thead><tr>{heads}</tr></thead><tbody>'
        + "".join(map(titled, rows))
        + "</tbody></table></div>"
    )


def _heads(*names: str, left: int = 1, texts: tuple[int, ...] = ()) -> str:
    """Heads of columns, the first `left` of them and those at `texts` aligned left."""
    classes = [_LEFT if place < left or place in texts else "" for place in range(len(names))]
    return "".join(f'<th{kind} scope="col">{name}</th>' for kind, name in zip(classes, names, strict=True))


def _gate(page: Sheet, result: Diagnosed) -> None:
    if not result.gate_sentence and not result.remarks:
        return
    page.add("<h3>Can this record answer?</h3>", f"<p>{escape(result.gate_sentence)}</p>")
    rows = [
        f'<tr><th scope="row">{escape(one.topic)}</th><td class="left"><span class="verdict {one.severity}">{_SEVERITY[one.severity]}</span></td>'
        f'<td class="reason">{escape(one.text)}</td><td class="reason">{escape(one.next or "")}</td></tr>'
        for one in result.remarks
    ]
    if rows:
        page.add(
            _table(
                "what was looked at in the record",
                "What was looked at before anything was concluded.",
                _heads("Looked at", "", "Found", "What to do", left=4),
                rows,
            )
        )


def _where(page: Sheet, result: Diagnosed, identity: str) -> None:
    if not result.where_sentence and not result.blocks:
        if result.pictures:
            page.add("<h3>What does the machine look like?</h3>")
            _pictures(page, result, identity)
        return
    against = "the mean of the healthy repeats" if result.relative else "the model"
    page.add("<h3>Where does the model fail?</h3>", f"<p>{escape(result.where_sentence)}</p>")
    rows = []
    for block in result.blocks:
        head = f'<tr><th scope="row">{escape(block.name)}</th>'
        if block.rms is None:
            rows.append(f'{head}<td colspan="4" class="reason">{escape(block.reason or "")}</td></tr>')
            continue
        floor = "–" if block.floor_rms is None else f"{words.number(block.floor_rms)} {escape(block.unit)}"
        told = next(
            (
                f"{escape(one.words)} ({words.number(one.explained_percent, 2)} %)"
                for one in block.terms[:1]
                if one.explained_percent >= 25.0
            ),
            "no simple term",
        )
        term = told if block.telling else "nothing beyond the floor"
        rows.append(
            f'{head}<td>{words.number(block.rms)} {escape(block.unit)}</td><td>{floor}</td><td>{words.number(block.share_percent, 2)} %</td><td class="reason">{term}</td></tr>'
        )
    if rows:
        beneath = "repeats" if result.relative else "noise and method"
        caption = f"Each balance uses measured signals and one group of blocks; the excess is the record minus {against}. The floor is what {beneath} leave."
        page.add(
            _table("excess of the balances", caption, _heads("Balance", "Excess, rms", "Floor", "Share", "Described as", texts=(4,)), rows)
        )
    rows = [
        f'<tr><th scope="row">{escape(CHANNEL_TITLES.get(one.name, one.name))}</th><td>{words.number(one.rms)} {escape(one.unit)}</td>'
        f"<td>{'–' if one.floor_rms is None else f'{words.number(one.floor_rms)} {escape(one.unit)}'}</td><td>{words.number(one.share_percent, 2)} %</td></tr>"
        for one in result.signals
        if one.rms is not None
    ]
    if rows:
        page.add(
            _table(
                "residual of the signals",
                f"Closed loop: record minus {against}, signal by signal; shares of the weighted square.",
                _heads("Signal", "Residual, rms", "Floor", "Share"),
                rows,
            )
        )
    telling = sorted((place for place in result.places if place.surprise > 0.0), key=lambda place: -place.surprise)
    if telling:
        page.add(
            '<figure><div class="figure-head"><h3>Places</h3><ul class="legend"><li><span class="key dot before"></span>share of the squared excess</li>'
        )
        page.add(
            '<li><span class="key ring"></span>share of the time</li></ul></div>',
            page.figure(f"{identity}-places", figures.shares(telling)),
        )
        page.add(
            "<figcaption>Parts of the record that hold more of the excess than of the time, the most telling first.</figcaption></figure>"
        )
    _pictures(page, result, identity)


def _pictures(page: Sheet, result: Diagnosed, identity: str) -> None:
    """The fixed pictures, then the worst balance over the axes along which it is least even."""
    fixed = [one for one in result.pictures if one.share is None]
    if fixed:
        page.add('<div class="pair">')
        for place, one in enumerate(fixed):
            _picture(page, f"{identity}-picture-{place}", one, _PICTURE_TITLES.get(one.source, one.source))
        page.add("</div>")
    worst = max((block for block in result.blocks if block.telling), key=lambda block: block.share_percent, default=None)
    bins = [one for one in result.pictures if one.share is not None and worst is not None and one.source == worst.name]
    bins.sort(key=_unevenness, reverse=True)
    if worst is not None and bins:
        page.add(
            f'<p class="note">The excess of the {escape(worst.name)} balance over every state, the most uneven first: mean and band of one standard deviation.'
            " A point of the time axis zooms the curves.</p>"
        )
        page.add('<div class="thirds">')
        for place, one in enumerate(bins[:_BIN_PICTURES_MAX]):
            _picture(page, f"{identity}-bins-{place}", one, _over(one), identity)
        page.add("</div>")


def _unevenness(shown: Picture) -> float:
    """How differently the excess and the time are spread over the bins, by relative entropy."""
    if shown.share is None or shown.time is None:
        return 0.0
    there = (shown.share > 0.0) & (shown.time > 0.0)
    return float(np.sum(shown.share[there] * np.log(shown.share[there] / shown.time[there])))


def _over(shown: Picture) -> str:
    """Title of a picture over an axis; friction is counted against the motion."""
    return f"Over {shown.by}{', against the motion' if shown.friction else ''}"


def _picture(page: Sheet, identity: str, shown: Picture, title: str, zooms: str = "") -> None:
    drawn = diagnosis_figures.picture(shown)
    if zooms and shown.by == "time":
        x = shown.lines["excess"].x
        drawn |= {"zooms": zooms, "half": 0.5 * float(x[-1] - x[0]) / max(1, x.size - 1)}
    legend = ""
    if "chance" in shown.lines:
        legend = '<ul class="legend"><li><span class="key dashed"></span>what noise makes</li></ul>'
    if "measured" in shown.lines:
        others = "".join(f'<li><span class="key after"></span>{_OTHER[name]}</li>' for name in shown.lines if name in _OTHER)
        legend = f'<ul class="legend"><li><span class="key before"></span>measured</li>{others}</ul>'
    page.add(f'<figure><div class="figure-head"><h3>{escape(title)}</h3>{legend}</div>', page.figure(identity, drawn), "</figure>")


def _shown(value: Value) -> str:
    """A value with its interval and unit."""
    try:
        row = row_of(value.name)
        unit, name = row.unit, value.name.removeprefix("effects.")
    except InputError:
        unit, name = "", value.name
    low, high = interval_of(value.value, value.std)
    spread = f" [95 %: {words.interval(low, high)}]" if low is not None and high is not None else ""
    bound = " (at its bound)" if value.at_bound else ""
    return f"{escape(name)} = {words.number(value.value, 4)}{' ' + escape(unit) if unit else ''}{spread}{bound}"


def _which(page: Sheet, result: Diagnosed, identity: str) -> None:
    """What was tried, best first; what these records cannot show below it, by reason; the scores where they are held against limits."""
    if not result.suspects:
        return
    page.add("<h3>Which effect is missing?</h3>")
    tried = [one for one in result.suspects if one.accepted or one.score > 0.0 or one.values]
    limited = any(one.limit > 0.0 for one in result.suspects)
    rows = []
    for one in tried:
        alike = ", ".join(name for name in one.alike if name != one.name) or "–"
        values = "<br>".join(_shown(value).removeprefix(f"{escape(one.name)}.") for value in one.values) or "–"
        state = (
            '<span class="verdict fine">accepted</span>'
            if one.accepted
            else escape(one.reason) or '<span class="whole">not accepted</span>'
        )
        score = f"<td>{words.number(one.score)}</td><td>{words.number(one.limit)}</td>" if limited else ""
        rows.append(
            f'<tr><th scope="row">{escape(one.name)}</th>{score}<td class="reason">{state}</td><td class="left sizes">{values}</td><td class="reason">{escape(alike)}</td></tr>'
        )
    caption = "Size with its 95 % interval. What looks alike cannot be told apart on " + (
        "these records." if result.records > 1 else "this record."
    )
    if limited:
        caption += " An effect counts when its score exceeds the limit, which healthy repeats set."
    if any(not one.accepted and one.score > one.limit > 0.0 for one in result.suspects):
        caption += " What is not accepted shows what it would take off alone: beside the accepted ones, which explain the record better, it adds too little."
    heads = ("Effect", *(("Score", "Limit") if limited else ()), "", "Size", "Looks alike")
    texts = tuple(range(3, 6)) if limited else tuple(range(1, 4))
    if rows:
        page.add(_table("effects", caption, _heads(*heads, texts=texts), rows))
    _not_shown(page, [one for one in result.suspects if one not in tried])
    if not limited:
        return
    page.add(
        '<figure><div class="figure-head"><h3>Scores</h3><ul class="legend"><li><span class="key dot"></span>accepted</li><li><span class="key dot candidate"></span>not accepted</li>'
    )
    page.add(
        '<li><span class="key dashed"></span>limit</li></ul></div>',
        page.figure(f"{identity}-ranking", diagnosis_figures.ranking(result)),
        "</figure>",
    )


def _not_shown(page: Sheet, suspects: Sequence[ShownSuspect]) -> None:
    """Effects of which nothing was fitted, one line a reason."""
    reasons: dict[str, list[str]] = {}
    for one in suspects:
        reasons.setdefault(one.reason, []).append(one.name)
    if reasons:
        lines = "".join(f"<li>{escape(', '.join(names))}{f': {escape(why)}' if why else ''}</li>" for why, names in reasons.items())
        page.add(f'<p class="note">Not tried here:</p><ul class="note">{lines}</ul>')


def _changed(page: Sheet, result: Diagnosed) -> None:
    """Values of the healthy machine beside those of today."""
    if not result.changes:
        return
    rows = []
    for one in result.changes:
        entry = one.entry
        low, high = entry.interval95
        spread = words.interval(low, high) if low is not None and high is not None else "–"
        state = '<span class="verdict missing">changed</span>' if entry.counts else ""
        rows.append(
            f'<tr><th scope="row">{escape(one.name)}</th><td class="left">{escape(entry.unit)}</td><td>{words.number(entry.healthy, 4)}</td>'
            f'<td>{words.number(entry.today, 4)}</td><td>{spread}</td><td>{words.number(entry.limit, 2)}</td><td class="left">{state}</td></tr>'
        )
    caption = "Values of the healthy machine beside today's; a change must exceed what healthy records differ by."
    heads = _heads("Value", "Unit", "Healthy", "Today", "Change, 95 %", "Must exceed", "", left=2, texts=(6,))
    page.add("<h3>What has changed?</h3>", _table("values of the healthy machine", caption, heads, rows))


def _fell(page: Sheet, result: Diagnosed, identity: str, draw: DrawCurves) -> None:
    """The steps, and the curves before and after them."""
    if result.steps and "before" in result.errors:
        page.add("<h3>Does the error fall?</h3>")
        held = any(step.holdout is not None for step in result.steps)
        first = result.errors.get("holdout_before")
        rows = [
            f'<tr><th scope="row">first model</th><td>{words.number(result.errors["before"])}</td><td>{"–" if first is None else words.number(first)}</td><td></td><td></td></tr>'
        ]
        for step in result.steps:
            values = "<br>".join(map(_shown, step.values)) or "–"
            state = (
                ""
                if step.recommended is None
                else '<span class="verdict fine">recommended</span>'
                if step.recommended
                else '<span class="verdict blocks">not recommended</span>'
            )
            why = (": " if state else "") + escape(step.reason) if step.reason else ""
            holdout = "–" if step.holdout is None else words.number(step.holdout)
            name = escape(step.added or " + ".join(step.effects))
            rows.append(
                f'<tr><th scope="row">+ {name}</th><td>{words.number(step.training)}</td><td>{holdout}</td><td class="left sizes">{values}</td><td class="reason">{state}{why}</td></tr>'
            )
        page.add(
            _table(
                "steps",
                f"{'Force error in %' if result.by_forces else 'Weighted rms error'} after each addition, all values refitted together.",
                _heads(
                    "Step",
                    "Parts fitted" if result.by_forces else "This record",
                    "Held out" if result.by_forces else "Held-out record",
                    "Values",
                    "",
                    texts=(3,),
                ),
                rows,
            )
        )
        page.add(
            '<figure><div class="figure-head"><h3>From the first model to the floor</h3><ul class="legend"><li><span class="key dot"></span>left on this record</li>'
        )
        page.add(
            '<li><span class="key join"></span>taken off</li>'
            + ('<li><span class="key before"></span>held-out record</li>' if held else "")
        )
        page.add('<li><span class="key dashed"></span>floor</li></ul></div>' if "floor" in result.errors else "</ul></div>")
        page.add(page.figure(f"{identity}-waterfall", diagnosis_figures.waterfall(result)), "</figure>")
    if result.forward_sentence:
        page.add(f"<p>{escape(result.forward_sentence)}</p>")
    _changed(page, result)
    if result.base:
        heads = _heads(*base_values.HEADS)
        page.add("<h3>Base values</h3>", _table("base values", base_values.CAPTION, heads, base_values.rows(result.base, result.units)))
        page.add(*base_values.notes(result.base, result.units))
    if result.curves is not None:
        names = " and ".join(result.steps[-1].effects) if result.steps else result.added
        titles = {"before": "Before: the first model", "after": f"After: with {names}" if names else "After: the new model"}
        draw(result.curves, identity, {key: titles[key] for key in result.curves.models})


def _unknown(page: Sheet, result: Diagnosed, identity: str) -> None:
    if result.verdict != "unknown" or not (result.unknown_sentence or result.unknown_pictures):
        return
    page.add(
        "<h3>What is it that the library does not hold?</h3>",
        f"<p>{escape(result.unknown_sentence[:1].upper() + result.unknown_sentence[1:])}.</p>",
    )
    if result.unknown_pictures:
        page.add('<div class="thirds">')
        for place, one in enumerate(result.unknown_pictures[:_UNKNOWN_PICTURES_MAX]):
            _picture(page, f"{identity}-unknown-{place}", one, f"{_over(one)}: {words.number(one.explained_percent or 0.0, 2)} % foretold")
        page.add("</div>")
    if result.learned_sentence:
        page.add(f"<p>It can be flown without a name: {escape(result.learned_sentence)}.</p>")
