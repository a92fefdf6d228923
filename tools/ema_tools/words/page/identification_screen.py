"""The first screen of the page of an identification: one sentence, and five answers: does the model hold, where is the fault, what is missing, did the error fall, what to do next."""

from __future__ import annotations

import math

from ema_tools.words.advice import UNUSABLE, after_identification
from ema_tools.words.command_line import line_of
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.results import ShownEstimate, ShownIdentification
from ema_tools.words.page.sheet import FirstScreen, Reply, next_reply

PLAIN = {"csj_Nm": "friction (CSJ)", "blk_mm": "backlash (BLK)"}
_PLACE = {"csj_Nm": "friction", "blk_mm": "backlash"}
SHORT = {"csj_Nm": "CSJ", "blk_mm": "BLK"}
_WIDE, _NARROW = 10.0, 0.05  # %: half of an interval that leaves no decimals, and one [layout]
_UM = 1000.0  # um in a mm [physics]
# Why there is no verdict, by what objects to the module's answer.
_WHY = {
    "unknown": "something is missing from the model that the library of effects does not know",
    "signals": "the other signals say otherwise than the rod position",
    "open": "this record does not tell a fault from what differs from day to day",
    "healthy": "the healthy records may not all be of a healthy machine",
}


def first_screen_of(result: ShownIdentification) -> FirstScreen:
    """All of it."""
    return FirstScreen(
        headline(result), (_holds(result), _where(result), _missing(result), _error(result), next_reply(after_identification(result.found)))
    )


def shift_words(one: ShownEstimate) -> tuple[str, str]:
    """The shift, and its 95 % interval, with the digits that the interval leaves; no interval where the record does not determine it."""
    half = 0.5 * sum(one.reach_percent)
    if one.interval is None:
        return words.shift(one.shift_percent), ""
    digits = next(digits for digits, least in ((0, _WIDE), (1, _NARROW), (2, -math.inf)) if half >= least)
    low, high = (words.shift(one.shift_percent + sign * reach, digits) for sign, reach in zip((-1, 1), one.reach_percent, strict=True))
    return words.shift(one.shift_percent, digits), f"{low.removesuffix(' %')} … {high}"


def shifts(result: ShownIdentification, wanted: tuple[str, ...] | None = None) -> list[str]:
    """Sizes in words, as in `friction (CSJ) +22 %`."""
    return [f"{PLAIN[name]} {shift_words(one)[0]}" for name, one in result.faults.items() if wanted is None or name in wanted]


def headline(result: ShownIdentification) -> str:
    """The answer in one sentence."""
    if result.verdict == "fault":
        faulty = faults_of(result)
        others = [
            f"{PLAIN[name]} {'may be beyond' if one.may_be_beyond else 'is within'} its threshold"
            for name, one in result.faults.items()
            if name not in faulty
        ]
        return f"The machine has a fault: {'; '.join([names.listed(shifts(result, faulty)), *others])}."
    if result.verdict == "healthy":
        new = _new(result)
        if new:
            return f"Friction and backlash are healthy, but {names.listed(new)} {'is' if len(new) == 1 else 'are'} new since the healthy records: {names.listed(shifts(result))}."
        return f"The machine is healthy: {names.listed(shifts(result))}."
    return f"No verdict: {_why(result)}."


def _new(result: ShownIdentification) -> list[str]:
    """Effects of the model that the healthy records do not have."""
    return [names.within(effect) for effect in result.found.baseline.without] if result.found.baseline is not None else []


def faults_of(result: ShownIdentification) -> tuple[str, ...]:
    """Of a faulty machine, the values that make it so: those surely beyond their thresholds, else those beyond, else all."""
    sure = tuple(name for name, one in result.faults.items() if one.surely_beyond)
    return sure or tuple(name for name, one in result.faults.items() if one.beyond) or tuple(result.faults)


def _sensor(result: ShownIdentification) -> str:
    """Whose own error is suspected in place of the machine's, in words; empty where none is."""
    sensor = result.found.sensor
    return names.suspected(sensor.channel) if sensor is not None else ""


def _why(result: ShownIdentification) -> str:
    """Why it is undecided, in plain words."""
    guard, effect = result.found.guard, result.found.missing_effect
    objection = guard.objection if guard is not None else None
    if any(reason.startswith(UNUSABLE) for reason in result.reasons):
        return "nothing can be told from this record"
    if effect is not None and effect.name is not None:
        shown = names.within(effect.name)
        if objection == "rival":
            return f"{shown} explains the record as well as a fault does"
        if any(effect.name in reason and "is missing from the model" in reason for reason in result.reasons):
            return f"{shown} is missing from the model"
        return f"{shown} stands behind what the search reads"
    if _sensor(result):
        return f"it looks as if the {_sensor(result)} is at fault"
    if objection in _WHY:
        return _WHY[objection]
    return result.reasons[0].rstrip(".") if result.reasons else "no reason was given"


def _holds(result: ShownIdentification) -> Reply:
    question = "Does the model hold?"
    guard = result.found.guard
    if result.adequate and guard is not None and guard.verdict == "missing" and guard.objection is None:
        return Reply(question, "By the rod position", "the other signals say that an effect is missing", "unsure")
    if result.adequate:
        return Reply(question, "Yes", "what it leaves is no more than noise", "good")
    if result.verdict != "undecided":
        return Reply(question, "Not told", "the result does not say")
    return Reply(question, "No", "it leaves more than noise explains", "bad")


def _where(result: ShownIdentification) -> Reply:
    question = "Where is the fault?"
    limits = {name: one.threshold_percent for name, one in result.faults.items() if one.threshold_percent is not None}
    if result.verdict == "healthy":
        told = ", ".join(f"{SHORT[name]} a fault from +{limit:g} % on" for name, limit in limits.items())
        hidden = [f"{SHORT[name]} {words.shift(one.most_percent, 0)}" for name, one in result.faults.items() if one.hides_much]
        told += f"; today's may be {names.listed(hidden)}" if hidden else ""
        new = _new(result)
        if new:
            return Reply(question, f"No wear, but {names.listed(new)}", f"new since the healthy records; {told}", "bad")
        return Reply(question, "Nowhere", told, "good")
    if result.verdict == "fault":
        faulty = faults_of(result)
        place = names.listed([_PLACE[name] for name in faulty])
        told = "; ".join(f"{SHORT[name]} beyond +{limits[name]:g} %" for name in faulty if name in limits)
        return Reply(question, place[:1].upper() + place[1:], told, "bad")
    return Reply(question, "Cannot be told", f"{names.listed(shifts(result))} is what fits best, and does not stand", "unsure")


def _missing(result: ShownIdentification) -> Reply:
    question = "What is missing?"
    found = result.found
    effect, guard = found.missing_effect, found.guard
    if effect is not None and effect.name is not None:
        rival = guard is not None and guard.objection == "rival"
        more = sizes_of(result)[:1]
        if rival:
            more.append("or a fault: the record does not tell them apart")
        elif guard is not None and guard.shift_percent:
            beside = ", ".join(f"{SHORT[name]} {words.shift(shift)}" for name, shift in guard.shift_percent.items() if name in SHORT)
            more.append(f"beside it {beside}")
        shown = names.display(effect.name)
        return Reply(question, f"Perhaps {names.within(effect.name)}" if rival else shown, "; ".join(more), "unsure" if rival else "bad")
    if _sensor(result):
        return Reply(question, "Nothing in the machine", "a sensor explains it", "unsure")
    if effect is not None or (guard is not None and guard.objection == "unknown"):
        return Reply(question, "Not in the library", "no effect explains what is left", "bad")
    if found.table is not None:
        said = {"adequate": "Nothing", "missing": names.display(found.table.effect or "an effect"), "unknown": "Not in the table"}
        tone = {"adequate": "good", "none": "unsure"}.get(found.table.kind, "bad")
        return Reply(question, said.get(found.table.kind, "Cannot be told"), "by the table of signatures", tone)
    if guard is None:
        return Reply(question, "Not looked for", "the onboard module's own answer alone", "" if result.adequate else "unsure")
    if guard.verdict == "adequate":
        return Reply(
            question, "Nothing more" if _new(result) else "Nothing", guard.skipped or f"by {len(guard.signals)} signals together", "good"
        )
    return Reply(question, "Nothing is named", guard.skipped or "", "unsure")


def sizes_of(result: ShownIdentification) -> list[str]:
    """The values of the effect behind an estimate, its size first."""
    effect = result.found.missing_effect
    if effect is None or effect.name is None:
        return []
    told = []
    for field, value in effect.parameters.items():
        unit = names.unit_of(f"effects.{effect.name}.{field}")
        told.append(f"{field.rsplit('_', 1)[0] if unit else field} {names.sized(value, effect.std.get(field), unit)}")
    return told


def objective(result: ShownIdentification) -> str:
    """The objective before and after, with its unit and the change."""
    line = line_of(result.provenance.get("command", ""))
    unit = "weighted" if line is not None and "--weight" in line.options else "mm² s"
    fall = words.reduction(result.before_mm2s, result.after_mm2s)
    return f"{words.number(result.before_mm2s)} → {words.number(result.after_mm2s)} {unit} ({fall})"


def _error(result: ShownIdentification) -> Reply:
    question = "Error, before and after?"
    tone = "good" if result.adequate else ""
    curves = result.curves
    if curves is None or not {"before", "after"} <= set(curves.models):
        short, _, more = objective(result).partition(" (")
        return Reply(question, short, f"{more.rstrip(')')} of the position error", tone)
    before, after = (_UM * curves.rms("position_mm", key) for key in ("before", "after"))
    return Reply(
        question, f"{words.number(before)} → {words.number(after)} µm", f"rms of the rod position; objective {objective(result)}", tone
    )
