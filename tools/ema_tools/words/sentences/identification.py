"""What `ema identify` says."""

from __future__ import annotations

import numpy as np

from ema_tools.data.actuator import row_of
from ema_tools.plant.native import IdentifiedValue
from ema_tools.results.identification import TableFinding
from ema_tools.select.beside_fault import Guarded
from ema_tools.tasks.identify import NOT_ADEQUATE, Identified
from ema_tools.words.sentences.sizes import size_text

TITLES = {"screw.csj_Nm": "CSJ", "screw.blk_mm": "BLK"}


def missing_words(guarded: Guarded) -> str:
    """The missing effect in words, for a list of reasons."""
    if guarded.unusable:
        return f"nothing can be told from this record: {guarded.skipped}"
    if guarded.verdict == "unknown":
        return "something is missing from the model that no effect of the library explains: ema diagnose draws it"
    size = next(iter(guarded.values))
    missing = "is not in the model at this size" if guarded.there else "is missing from the model"
    alike = f", which looks like {', '.join(guarded.effects[1:])} on this record" if guarded.effects[1:] else ""
    return (
        f"{guarded.effects[0]} ({row_of(size).field} {size_text(size, guarded.values[size], guarded.std.get(size))}) {missing}{alike}: "
        f"ema add ACTUATOR {guarded.effects[0]} --fit REC {'--healthy REC ...' if guarded.against else '--known'} -o NEW.toml puts it in"
    )


def reasons(found: Identified) -> tuple[str, ...]:
    """Why it is undecided: the module's reasons, and the missing effect behind the first of them."""
    own = found.answer.reasons
    if not found.objects or found.guarded is None:
        return tuple(own)
    if found.guarded.unusable:
        # of a record that cannot answer, a residual says nothing about the model
        return (missing_words(found.guarded), *(reason for reason in own if reason != NOT_ADEQUATE))
    place = own.index(NOT_ADEQUATE) + 1 if NOT_ADEQUATE in own else 0
    return (*own[:place], missing_words(found.guarded), *own[place:])


def sentence(found: Identified) -> str:
    """The answer in one sentence."""
    answer = found.answer
    shifts = ", ".join(_shift(estimate, found.healthy[estimate.name]) for estimate in answer.identified)
    unit = "" if found.weighted else " mm2 s"
    how = (
        f"in {answer.evaluations} model runs, error {answer.objective_before:.3g}{unit} before and {answer.objective_after:.3g}{unit} after"
    )
    if found.verdict == "healthy":
        return f"Healthy: {shifts}; found {how}."
    if found.verdict == "fault":
        return f"Fault: {shifts}; found {how}."
    return f"Undecided, because {'; '.join(reasons(found))}: the search reads {shifts}, {how}."


def _shift(estimate: IdentifiedValue, healthy: float) -> str:
    doubt = 100.0 * estimate.std / abs(healthy) if healthy else float("inf")
    title = TITLES.get(estimate.name, estimate.name)
    return f"{title} {estimate.shift_percent:+.{_decimals(doubt)}f} %"


def _decimals(doubt_percent: float) -> int:
    """Decimals of a shift in % that its standard error allows, at least one and at most three."""
    if np.isnan(doubt_percent):
        return 1
    if not doubt_percent > 0.0:
        return 3
    return int(min(3, max(1, np.ceil(-np.log10(2.0 * doubt_percent)))))


def table_sentence(found: TableFinding) -> str:
    """What a table of signatures says, in one sentence."""
    said = {
        "adequate": "nothing is missing",
        "missing": f"missing is {found.effect}, size {found.size:.3g}",
        "unknown": "something is missing that no effect of the table explains",
        "none": "the record runs another command, so nothing can be said",
    }[found.kind]
    others = ", ".join(name for name in found.alike if name != found.effect) if found.kind == "missing" else ""
    return f"Table of signatures: {said}{f' (looks like {others})' if others else ''}."
