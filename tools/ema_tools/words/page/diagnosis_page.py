"""The page of one diagnosis, or of one addition: what was found on the first screen, and the rest in sections that a menu leads to. One file that opens from disk and asks nothing of any network."""

from __future__ import annotations

import json
import shlex
from html import escape

from ema_tools.library.registry import separating
from ema_tools.results.addition import Addition
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.parts import EXPLAINED, together
from ema_tools.words.command_line import line_of
from ema_tools.words.page import base_values, charts, heat, names, rest, where_pictures, workbench
from ema_tools.words.page import signals as signal_section
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed, ShownChange, Value
from ema_tools.words.page.first_screen import (
    TriedEffect,
    accepted,
    candidates,
    faults,
    first_screen,
    model_titles,
    next_best,
    own_form_leaves,
    rung_words,
    rungs,
    telling,
)
from ema_tools.words.page.sheet import Chapter, document, kept, origin, table
from ema_tools.words.page.uplot import ABSENT, library

_SEVERITY = {"blocks": "blocks", "weakens": "weakens", "fine": "in order"}


def render(result: Diagnosed, command: str) -> str:
    """The page as text. `command` made it and stands in its provenance."""
    found = signal_section.traces(result.curves, result.found.curves)
    drawn = heat.maps(result, found)
    bins = heat.bins_of_rows(result, found) if found is not None else {}
    titles = model_titles(result, found.curves) if found is not None else {}
    chapters = [
        Chapter("signals", "Signals", signal_section.section(found, titles, "" if library().there else ABSENT)),
        Chapter("where", "Where", _where(result, drawn)),
        Chapter("which", "Which", _which(result)),
        Chapter("ladder", "Ladder", _ladder(result)),
        Chapter("rest", "Is the rest noise?", _rest(result, found, titles)),
        Chapter("workbench", "Workbench", workbench.markup(result.workbench, _loaded(result)) if result.workbench is not None else ""),
        Chapter("records", "Records", _records(result)),
        Chapter("provenance", "Provenance", _provenance(result, command)),
    ]
    data = signal_section.packed_signals(found, titles, bins) if found is not None else {}
    return document(result.name, first_screen(result), "", chapters, data, result.workbench is not None)


def _where(result: Diagnosed, drawn: list[heat.Map]) -> str:
    parts = [f"<p>{kept(result.where_sentence)}</p>"] if result.where_sentence else []
    parts.append(heat.section(result, drawn))
    rows = []
    for one in sorted(result.blocks, key=lambda block: (-block.telling, -block.share_percent)):
        title, weighs = names.BLOCKS.get(one.name, (one.name, ""))
        head = f'<th scope="row">{escape(title)} <small>{escape(weighs)}</small></th>'
        if one.rms is None:
            rows.append(f'<tr>{head}<td colspan="4" class="words">{escape(one.reason or "")}</td></tr>')
            continue
        floor = "–" if not one.floor_rms else f"{words.number(one.floor_rms)} {escape(one.unit)}"
        times = "–" if not one.floor_rms else f"{words.number(one.rms / one.floor_rms, 2)} ×"
        term = next(
            (
                f"{one_term.words} ({words.number(one_term.explained_percent, 2)} %)"
                for one_term in one.terms[:1]
                if one_term.explained_percent >= 25.0
            ),
            "no simple term",
        )
        rows.append(
            f"<tr>{head}<td>{words.number(one.rms)} {escape(one.unit)}</td><td>{floor}</td><td>{times}</td>"
            f'<td class="words">{escape(term) if one.telling else "within its noise level"}</td></tr>'
        )
    if rows:
        caption = "Equation residual: measured signals against one group of blocks" + (
            ", less what baseline runs have." if result.relative else "."
        )
        parts.append(table("equation residuals", caption, ("Equation", "Residual, rms", "Noise level", "Times", "<Described as"), rows))
    figures = where_pictures.figures(result)
    if figures:
        parts.append(f'<div class="thirds">{"".join(figures)}</div>')
    more = where_pictures.more(result)
    if more:
        worst = telling(result)[0]
        parts.append(
            f"<details><summary>{escape(names.block(worst.name))} over every axis</summary>"
            f'<p class="note">Mean, and band of one standard deviation; the most uneven first.</p><div class="thirds">{"".join(more)}</div></details>'
        )
    return "".join(part for part in parts if part)


def _value(one: Value) -> str:
    unit = names.unit_of(one.name)
    bound = " (at its bound)" if one.at_bound else ""
    return f"<code>{escape(one.name.split('.')[-1])}</code> {escape(names.sized(one.value, one.std, unit))}{bound}"


def _which(result: Diagnosed) -> str:
    if not result.suspects:
        return ""
    tried = [one for one in candidates(result) if one.entry.accepted or one.entry.score > 0.0 or one.entry.parameters]
    values = {one.name: one.values for one in result.suspects}
    parts = []
    if result.verdict == "adequate" and not result.added:
        parts.append("<p>No effect of the library takes off more than chance does.</p>")
    known = sorted((one for one in tried if one.left is not None), key=lambda one: (not one.entry.accepted, one.left or 0.0))
    floor = result.errors.get("floor")
    if known:
        rows = [_candidate(one, values.get(one.entry.name, ())) for one in known]
        label = "Error left when this effect alone is added to the model before it, what scatters free beside it, times the sensor noise; effects that were not refitted by their first look"
        parts.append(charts.tracks(label, "Effect", "Error left, size, look-alikes", rows, floor, "dashed: noise level"))
    unknown = [one for one in tried if one.left is None]
    if unknown:
        rows_ = []
        for one in unknown:
            sizes = "<br>".join(map(_value, values.get(one.entry.name, ()))) or "–"
            state = '<b class="good">named</b>' if one.entry.accepted else escape(one.entry.reason or "not named")
            rows_.append(
                f'<tr><th scope="row">{names.titled(one.entry.name)}</th><td class="words">{state}</td><td class="words">{sizes}</td><td class="words">{_alike(one)}</td></tr>'
            )
        parts.append(table("effects", "Size ± half of its 95 % interval.", ("Effect", "<Named", "<Size", "<Looks alike"), rows_))
    parts += _separates(result)
    parts += _not_tried(result, {one.entry.name for one in tried})
    parts += _unknown(result)
    return "".join(part for part in parts if part)


def _alike(one: TriedEffect) -> str:
    others = [names.within(name) for name in one.entry.alike if name != one.entry.name]
    return escape(names.listed(others)) if others else "nothing"


def _candidate(one: TriedEffect, values: tuple[Value, ...]) -> charts.Row:
    assert one.left is not None
    named = one.entry.accepted
    said = f"error left {words.number(one.left)}"
    sizes = "; ".join(map(_value, values[:1] if not named else values)) or "<span>size not fitted</span>"
    alike = _alike(one)
    looks = f"; looks like {alike}" if alike != "nothing" else ""
    state = '<b class="good">named</b> ' if named else ""
    head = f"{state}{names.titled(one.entry.name)}"
    return charts.Row(
        head,
        (charts.Mark(one.left, "dot after" if named else "dot other", said),),
        f"<b>{words.number(one.left)}</b> {sizes}{looks}",
        "named" if named else "",
    )


def _separates(result: Diagnosed) -> list[str]:
    """What would tell the named effect from the next best, and from what looks like it."""
    named = accepted(result)
    if not named or isinstance(result.found, Addition):
        return []
    first, *others = together(named, result.found.rivals) or (named[0].name,)
    nearest = next_best(result)
    if not others and nearest is not None:
        others = [nearest[1].entry.name]
    pairs = [(first, other) for other in others]
    line = line_of(result.provenance.get("command", ""))
    actuator = shlex.quote(line.actuator) if line is not None else "ACTUATOR.toml"
    told = []
    for one, other in pairs[:3]:
        ways = separating((one, other))
        do = f"{ways[0].do}: {ways[0].because}" if ways else "a command that moves both differently"
        told.append(
            f"<li>{escape(names.display(one))} from {escape(names.within(other))}: {escape(do)}. "
            f"<code>ema next {escape(actuator)} --between {escape(one)} {escape(other)}</code> says which command shows it.</li>"
        )
    return [f'<h3>What would separate them</h3><ul class="told">{"".join(told)}</ul>'] if told else []


def _not_tried(result: Diagnosed, tried: set[str]) -> list[str]:
    """Effects of which nothing was fitted, one line a reason."""
    reasons: dict[str, list[str]] = {}
    for one in result.suspects:
        if one.name not in tried:
            reasons.setdefault(one.reason, []).append(names.within(one.name))
    if not reasons:
        return []
    lines = "".join(f"<li>{escape(', '.join(shown))}{f': {escape(why)}' if why else ''}</li>" for why, shown in reasons.items())
    return [f'<details><summary>Not tried on this record</summary><ul class="told">{lines}</ul></details>']


def _unknown(result: Diagnosed) -> list[str]:
    """What the library does not hold."""
    if result.verdict != "unknown" or not (result.unknown_sentence or result.unknown_pictures):
        return []
    said = result.unknown_sentence
    parts = [f"<h3>What is it that the library does not know?</h3><p>{escape(said[:1].upper() + said[1:])}.</p>" if said else ""]
    shown = [
        where_pictures.over(one, f"{words.number(one.explained_percent or 0.0, 2)} % of it is foretold on other passes.")
        for one in result.unknown_pictures[:6]
    ]
    if shown:
        parts.append(f'<div class="thirds">{"".join(shown)}</div>')
    if result.learned_sentence:
        parts.append(f"<p>It can be flown without a name: {escape(result.learned_sentence)}.</p>")
    return parts


def _loaded(result: Diagnosed) -> set[str]:
    """Values that the rungs of the ladder load into the workbench, by full name."""
    return {name for step in result.steps for name in step.loads or ()}


def _loading(result: Diagnosed, any_loads: bool) -> list[str]:
    """What loading a rung does, or why none can be."""
    if any_loads:
        said = "“load” puts a model into the workbench, where it is simulated anew and its values can be moved; values without a slider are set as well, and listed there."
        if result.by_forces:
            return [said, "The workbench weighs all signals, the ladder the balance of forces alone."]
        open_ = "Without baseline runs the ladder also takes off what no value states, as slight ripple, so that the workbench’s error is somewhat larger."
        return [said] if result.relative else [said, open_]
    if result.workbench is None and result.by_forces:
        return [
            "No rung can be loaded: without a known controller and its command nothing is simulated, and the balance of forces alone is drawn."
        ]
    return (
        ["No rung can be loaded: the record is too long for the page, or the file is of an older version."]
        if result.workbench is None
        else []
    )


def _ladder(result: Diagnosed) -> str:
    found = rungs(result)
    if not found:
        return ""
    unit = "% of the drive's force" if result.by_forces else "times the sensor noise"
    rows, last = [], len(found) - 1
    known = (
        {one.name for one in result.suspects}
        | {effect for step in result.steps for effect in step.effects}
        | {*names.FAULT_TITLES, result.added}
    )
    loads = [{}, *(step.loads for step in result.steps)]
    drawn = list(result.curves.models) if result.curves is not None else []
    for place, (name, here, held) in enumerate(found):
        title = name if place == 0 else f"+ {rung_words(name, known)}"
        marks = [charts.Mark(here, "dot after", f"this record {words.number(here)}")]
        if held is not None:
            marks.append(charts.Mark(held, "diamond", f"{'held out' if result.by_forces else 'validation record'} {words.number(held)}"))
        key = "before" if place == 0 else "after" if place == last else ""
        shown = f'<button type="button" data-model="{key}">{escape(title)}</button>' if key in drawn else escape(title)
        told = f"<b>{words.number(here)}</b>" + (f" / {words.number(held)}" if held is not None else "")
        changes = loads[place]
        why = workbench.why_not(result.workbench, changes, result.by_forces)
        if why:
            told += f' <small class="why">{escape(why)}</small>'
        else:
            given = escape(json.dumps(changes, separators=(",", ":")))
            told += f' <button type="button" class="load" data-load="{given}">load<span class="spoken"> {escape(title)} into the workbench</span></button>'
        rows.append(charts.Row(shown, tuple(marks), told))
    floor = result.errors.get("floor")
    other = ""
    if any(held is not None for _, _, held in found):
        other = (
            '<li><span class="key diamond"></span>'
            + ("held out, in turn" if result.by_forces else "validation record, to which nothing was fitted")
            + "</li>"
        )
    parts = [
        f'<ul class="legend"><li><span class="key dot after"></span>this record</li>{other}<li><span class="key noise"></span>noise level</li></ul>',
        charts.tracks(
            f"Error after each step, {unit}; all values refitted together.",
            "Model",
            f"This record / {'held out' if result.by_forces else 'validation'}"
            if result.errors.get("holdout_before") is not None
            else "This record",
            rows,
            floor,
            f"dashed: noise level {words.number(floor)}" if floor else "",
        ),
    ]
    notes = ["Choose the first or the last model to see it alone in the signals."] if drawn else []
    notes += _loading(result, any(not workbench.why_not(result.workbench, one, result.by_forces) for one in loads))
    parts.append(f'<p class="note">{" ".join(notes)}</p>' if notes else "")
    values = [value for step in result.steps for value in step.values]
    if values:
        items = "".join(f"<li>{_value(value)}</li>" for value in values)
        parts.append(f'<details><summary>Values of the last model</summary><ul class="told">{items}</ul></details>')
    advised = result.steps[-1] if result.steps else None
    if advised is not None and advised.recommended is not None and result.added:
        why = f": {advised.reason}" if advised.reason else ""
        parts.append(
            f'<p><b class="{"good" if advised.recommended else "bad"}">{"Recommended" if advised.recommended else "Not recommended"}</b>{escape(why)}</p>'
        )
    if result.forward_sentence:
        parts.append(f"<p>{escape(result.forward_sentence)}</p>")
    return "".join(parts)


def _rest(result: Diagnosed, found: signal_section.Traces | None, titles: dict[str, str]) -> str:
    """What the last model leaves: its size beside the noise level, and its spectra."""
    parts = [f"<p>{escape(_noise_verdict(result))}</p>"]
    share = getattr(result.found, "unexplained", None)
    told = result.verdict == "unknown" or (result.by_forces and result.verdict == "missing") or own_form_leaves(result)
    if share is not None and told:
        parts.append(f"<p>{100.0 * share:.0f} % of the excess over the noise level stays unexplained.</p>")
    parts.append(rest.spectra(found, titles, {one.name: one.floor_rms for one in result.signals}))
    return "".join(parts)


def _noise_verdict(result: Diagnosed) -> str:
    after = result.errors.get("after", result.errors.get("before"))
    floor = result.errors.get("floor")
    if after is None or floor is None or not floor > 0.0:
        return "The result states no noise level for what is left."
    unit = "% of the drive's force" if result.by_forces else "times the sensor noise"
    said = f"The last model leaves {words.number(after)} {unit}; the noise level is {words.number(floor)}"
    if result.relative:
        said += ", which baseline runs have among each other"
    if after <= EXPLAINED * floor:
        return f"Yes: {said[0].lower()}{said[1:]}."
    return f"No: {said[0].lower()}{said[1:]}: {words.number(after / floor, 2)} times as much."


def _records(result: Diagnosed) -> str:
    parts = []
    rows = []
    for name, one in faults(result).items():
        for field, value in one.parameters.items():
            ends = one.shift_interval95
            change = "–" if one.shift_percent is None else words.shift(one.shift_percent)
            if one.shift_percent is not None and ends is not None and ends[0] is not None and ends[1] is not None:
                change += f" ± {words.number(0.5 * (ends[1] - ends[0]), 2)} %"
            unit = names.unit_of(f"screw.{field}")
            rows.append(
                f'<tr><th scope="row">{escape(names.FAULT_TITLES.get(name, name))}</th><td>{escape(names.sized(value, one.std.get(field), unit))}</td><td>{change}</td></tr>'
            )
    if rows:
        parts.append(
            table(
                "faults",
                "What has changed? CSJ and BLK against the healthy machine; ± half of the 95 % interval.",
                ("Fault", "Today", "Change"),
                rows,
            )
        )
    changed = [_change_row(one) for one in result.changes]
    if changed:
        parts.append(
            table(
                "values of the healthy machine",
                "What has changed? Values of the healthy machine beside today's.",
                ("Value", "Healthy", "Today", "Must differ by", "State"),
                changed,
            )
        )
    if result.base:
        parts.append(table("base values", base_values.CAPTION, base_values.HEADS, base_values.rows(result.base, result.units)))
        parts += base_values.notes(result.base, result.units)
    if result.gate_sentence:
        parts.append(f"<p>{escape(result.gate_sentence)}</p>")
    looked = [
        f'<tr><th scope="row">{escape(one.topic)}</th><td class="words"><b class="{one.severity}">{_SEVERITY[one.severity]}</b></td><td class="words">{escape(one.text)}</td>'
        f'<td class="words">{escape(one.next or "")}</td></tr>'
        for one in result.remarks
    ]
    if looked:
        parts.append(
            table(
                "what was looked at",
                "What was looked at in the record before anything was concluded.",
                ("Looked at", "<State", "<Found", "<What to do"),
                looked,
            )
        )
    return "".join(parts)


def _change_row(one: ShownChange) -> str:
    """One value of the healthy machine beside today's."""
    entry = one.entry
    healthy, today = (f"<td>{words.number(value, 4)} {escape(entry.unit)}</td>" for value in (entry.healthy, entry.today))
    state = '<b class="bad">changed</b>' if entry.counts else "as it was"
    head = f'<th scope="row">{escape(one.title)} <small>{escape(one.name)}</small></th>'
    return f"<tr>{head}{healthy}{today}<td>{words.number(entry.limit, 2)} {escape(entry.unit)}</td><td>{state}</td></tr>"


def _provenance(result: Diagnosed, command: str) -> str:
    hidden = result.found.cannot_see if isinstance(result.found, DiagnosisResult) else None
    method = result.found.method_reason if isinstance(result.found, DiagnosisResult | DiagnosisByBalanceResult | Addition) else ""
    parts = [f'<p class="full">{kept(result.sentence)}</p>' if result.sentence else ""]
    parts.append(f"<p>{escape(hidden)}</p>" if hidden else "")
    parts.append(f"<p>By {result.found.method}: {escape(method)}.</p>" if method else "")
    parts.append(origin(command, result.provenance))
    return "".join(parts)
