"""The base values of a balance on a page, beside what the actuator's file states of them."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import ShownBase
from ema_tools.words.sentences.base_values import note
from ema_tools.words.sentences.machine_units import MachineUnits

CAPTION = "Base values as fitted beside what was found, and what the actuator's file states of them."
HEADS = ("Value", "Stated", "Fitted", "95 % interval", "Of the stated")


def rows(shown: Sequence[ShownBase], units: MachineUnits) -> list[str]:
    """One row of cells a value, under HEADS."""
    return [_row(one, units) for one in shown]


def notes(shown: Sequence[ShownBase], units: MachineUnits) -> list[str]:
    """What is said below: values that were not fitted, or are hardly seen."""
    return [f'<p class="note">{escape(text)}</p>' for one in shown if (text := note(one.name, one.entry, units))]


def _row(shown: ShownBase, units: MachineUnits) -> str:
    one = shown.entry
    (given, unit), (value, _) = units.told(one.stated, one.unit), units.told(one.value, one.unit)
    low, high = (None if end is None else units.told(end, one.unit)[0] for end in one.interval95)
    tail = f" {escape(unit)}" if unit else ""
    stated = f"{words.number(given, 4)}{tail}" if one.stated_from == "file" else "not stated"
    known = one.std is not None or one.at_bound
    fitted = "–" if not known else f"{words.number(value, 4)}{tail}{' (at its bound)' if one.at_bound else ''}"
    spread = words.interval(low, high) if low is not None and high is not None else "–"
    times = "–" if one.times is None else f"{words.number(one.times)} times"
    if one.contradicts:
        times = f'<b class="bad">{times}</b>'
    title = escape(units.title(shown.name))
    return f'<tr><th scope="row">{title}</th><td>{stated}</td><td>{fitted}</td><td>{spread}</td><td>{times}</td></tr>'
