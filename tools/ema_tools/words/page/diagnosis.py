"""The part of the page for a result of `ema diagnose` or `ema add`, in the order in which a reader asks: can the record answer, where does the model fail, what is missing, did the error fall,
what is still unknown."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import row_of
from ema_tools.words.page import base_values, diagnosis_figures, figures, names
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed, Picture, ShownSuspect, Value
from ema_tools.words.page.gathered import Gathered, draw_curves
from ema_tools.words.page.sheet import kept, table
from ema_tools.words.page.tables import CHANNEL_TITLES

_BIN_PICTURES_MAX = 6
_UNKNOWN_PICTURES_MAX = 6
_SEVERITY = {"blocks": "blocks", "weakens": "weakens", "fine": "in order"}
_PICTURE_TITLES = {
    "torque without inertia": "Torque against speed",
    "torque over a turn": "Torque over one turn of the motor, less base values",
    "play loop": "Rod minus motor position",
    "torque loop": "Torque at reversals",
    "mechanical order": "Orders of the torque",
    "kinematic order": "Orders of the rod position",
}
_OTHER = {"model": "model", "healthy": "healthy repeats"}


def section(page: Gathered, result: Diagnosed, identity: str) -> None:
    """Everything about one diagnosis, below its answers."""
    if result.sentence:
        page.add(f"<p>{kept(result.sentence)}</p>")
    _gate(page, result)
    _where(page, result, identity)
    _which(page, result, identity)
    _fell(page, result, identity)
    _unknown(page, result, identity)
    if result.next_experiment:
        page.add(f"<h3>What to measure next</h3><p>{kept(result.next_experiment)}</p>")


def _gate(page: Gathered, result: Diagnosed) -> None:
    if not result.gate_sentence and not result.remarks:
        return
    page.add("<h3>Can this record answer?</h3>", f"<p>{escape(result.gate_sentence)}</p>")
    rows = [
        f'<tr><th scope="row">{escape(one.topic)}</th><td class="words"><span class="verdict {one.severity}">{_SEVERITY[one.severity]}</span></td>'
        f'<td class="words">{escape(one.text)}</td><td class="words">{escape(one.next or "")}</td></tr>'
        for one in result.remarks
    ]
    if rows:
        page.add(
            table(
                "what was looked at in the record",
                "What was looked at before anything was concluded.",
                ("Looked at", "<State", "<Found", "<What to do"),
                rows,
            )
        )


def _where(page: Gathered, result: Diagnosed, identity: str) -> None:
    if not result.where_sentence and not result.blocks:
        if result.pictures:
            page.add("<h3>What does the machine look like?</h3>")
            _pictures(page, result, identity)
        return
    against = "the mean of the healthy repeats" if result.relative else "the model"
    page.add("<h3>Where does the model fail?</h3>", f"<p>{kept(result.where_sentence)}</p>")
    rows = []
    for block in result.blocks:
        head = f'<tr><th scope="row">{escape(names.block(block.name))}</th>'
        if block.rms is None:
            rows.append(f'{head}<td colspan="4" class="words">{escape(block.reason or "")}</td></tr>')
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
        term = told if block.telling else "within its noise level"
        rows.append(
            f'{head}<td>{words.number(block.rms)} {escape(block.unit)}</td><td>{floor}</td><td>{words.number(block.share_percent, 2)} %</td><td class="words">{term}</td></tr>'
        )
    if rows:
        beneath = "repeats" if result.relative else "noise and method"
        caption = f"Equation residual: measured signals against one group of blocks; the excess is the record minus {against}. The noise level is what {beneath} leave."
        page.add(table("excess of the balances", caption, ("Equation", "Excess, rms", "Noise level", "Share", "<Described as"), rows))
    rows = [
        f'<tr><th scope="row">{escape(CHANNEL_TITLES.get(one.name, one.name))}</th><td>{words.number(one.rms)} {escape(one.unit)}</td>'
        f"<td>{'–' if one.floor_rms is None else f'{words.number(one.floor_rms)} {escape(one.unit)}'}</td><td>{words.number(one.share_percent, 2)} %</td></tr>"
        for one in result.signals
        if one.rms is not None
    ]
    if rows:
        page.add(
            table(
                "residual of the signals",
                f"Closed loop: record minus {against}, signal by signal; shares of the weighted square.",
                ("Signal", "Residual, rms", "Noise level", "Share"),
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


def _pictures(page: Gathered, result: Diagnosed, identity: str) -> None:
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
            f'<p class="note">What is left over of the {escape(names.block(worst.name).lower())} over every state, the most uneven first: mean and band of one standard deviation.'
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


def _picture(page: Gathered, identity: str, shown: Picture, title: str, zooms: str = "") -> None:
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


def _which(page: Gathered, result: Diagnosed, identity: str) -> None:
    """What was tried, best first; what these records cannot show below it, by reason; the scores where they are held against limits."""
    if not result.suspects:
        return
    page.add("<h3>Which effect is missing?</h3>")
    tried = [one for one in result.suspects if one.accepted or one.score > 0.0 or one.values]
    limited = any(one.limit > 0.0 for one in result.suspects)
    rows = []
    for one in tried:
        alike = names.listed([names.within(name) for name in one.alike if name != one.name]) or "–"
        values = "<br>".join(_shown(value).removeprefix(f"{escape(one.name)}.") for value in one.values) or "–"
        state = (
            '<span class="verdict fine">accepted</span>'
            if one.accepted
            else escape(one.reason) or '<span class="whole">not accepted</span>'
        )
        score = f"<td>{words.number(one.score)}</td><td>{words.number(one.limit)}</td>" if limited else ""
        rows.append(
            f'<tr><th scope="row">{names.titled(one.name)}</th>{score}<td class="words">{state}</td><td class="words">{values}</td><td class="words">{escape(alike)}</td></tr>'
        )
    caption = "Size with its 95 % interval. What looks alike cannot be told apart on " + (
        "these records." if result.records > 1 else "this record."
    )
    if limited:
        caption += " An effect counts when its score exceeds the limit, which healthy repeats set."
    if any(not one.accepted and one.score > one.limit > 0.0 for one in result.suspects):
        caption += " What is not accepted shows what it would take off alone: beside the accepted ones, which explain the record better, it adds too little."
    heads = ("Effect", *(("Score", "Limit") if limited else ()), "<Named", "<Size", "<Looks alike")
    if rows:
        page.add(table("effects", caption, heads, rows))
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


def _not_shown(page: Gathered, suspects: Sequence[ShownSuspect]) -> None:
    """Effects of which nothing was fitted, one line a reason."""
    reasons: dict[str, list[str]] = {}
    for one in suspects:
        reasons.setdefault(one.reason, []).append(names.within(one.name))
    if reasons:
        lines = "".join(f"<li>{escape(', '.join(shown))}{f': {escape(why)}' if why else ''}</li>" for why, shown in reasons.items())
        page.add(f'<p class="note">Not tried here:</p><ul class="note">{lines}</ul>')


def _changed(page: Gathered, result: Diagnosed) -> None:
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
            f'<tr><th scope="row">{escape(one.title)} <small>{escape(one.name)}</small></th><td class="words">{escape(entry.unit)}</td><td>{words.number(entry.healthy, 4)}</td>'
            f'<td>{words.number(entry.today, 4)}</td><td>{spread}</td><td>{words.number(entry.limit, 2)}</td><td class="words">{state}</td></tr>'
        )
    caption = "Values of the healthy machine beside today's; a change must exceed what healthy records differ by."
    heads = ("Value", "<Unit", "Healthy", "Today", "Change, 95 %", "Must exceed", "<State")
    page.add("<h3>What has changed?</h3>", table("values of the healthy machine", caption, heads, rows))


def _fell(page: Gathered, result: Diagnosed, identity: str) -> None:
    """The steps, and the curves before and after them."""
    if result.steps and "before" in result.errors:
        page.add("<h3>Does the error fall?</h3>")
        held = any(step.read[1] is not None for step in result.steps)
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
            here, apart = step.read
            holdout = "–" if apart is None else words.number(apart)
            name = escape(step.added or " + ".join(step.effects))
            rows.append(
                f'<tr><th scope="row">+ {name}</th><td>{words.number(here)}</td><td>{holdout}</td><td class="words">{values}</td><td class="words">{state}{why}</td></tr>'
            )
        page.add(
            table(
                "steps",
                f"{'Force error in %' if result.by_forces else 'Weighted rms error'} after each addition, all values refitted together.",
                (
                    "Step",
                    "Parts fitted" if result.by_forces else "This record",
                    "Held out" if result.by_forces else "Validation record",
                    "<Values",
                    "<Advice",
                ),
                rows,
            )
        )
        page.add(
            '<figure><div class="figure-head"><h3>From the first model to the noise level</h3><ul class="legend"><li><span class="key dot"></span>left on this record</li>'
        )
        page.add(
            '<li><span class="key join"></span>taken off</li>'
            + ('<li><span class="key before"></span>validation record</li>' if held else "")
        )
        page.add('<li><span class="key dashed"></span>noise level</li></ul></div>' if "floor" in result.errors else "</ul></div>")
        page.add(page.figure(f"{identity}-waterfall", diagnosis_figures.waterfall(result)), "</figure>")
    if result.forward_sentence:
        page.add(f"<p>{escape(result.forward_sentence)}</p>")
    _changed(page, result)
    if result.base:
        page.add(
            "<h3>Base values</h3>",
            table("base values", base_values.CAPTION, base_values.HEADS, base_values.rows(result.base, result.units)),
        )
        page.add(*base_values.notes(result.base, result.units))
    if result.curves is not None:
        held_in = names.listed([names.within(one) for one in (result.steps[-1].effects if result.steps else filter(None, [result.added]))])
        titles = {"before": "Before: the first model", "after": f"After: with {held_in}" if held_in else "After: the new model"}
        draw_curves(page, result.curves, identity, {key: titles[key] for key in result.curves.models}, result.title)


def _unknown(page: Gathered, result: Diagnosed, identity: str) -> None:
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
