"""The first screen of the diagnosis page: one sentence, and five answers: does the model hold, where does it fail, what is missing, did the error fall, what to do next."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass

from ema_tools.library.faults import FAULTS
from ema_tools.results.addition import Addition
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.localisation import BlockEntry
from ema_tools.results.parts import EXPLAINED, EffectEntry
from ema_tools.words.advice import advice_of
from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed, ShownChange
from ema_tools.words.page.recorded import Curves
from ema_tools.words.page.sheet import FirstScreen, Reply, next_reply
from ema_tools.words.sentences.balance import MOSTLY
from ema_tools.words.sentences.diagnosis import AT_FLOOR, LEAVES, NOT_ACCEPTED, unexplained_by

_TERM_PERCENT = 25.0  # a term that explains less of the excess is no description [judgement]
_MODELS = {"before": "model as given", "after": "with what was found"}
_WORSE = 1.05  # times an error, from which on it is told as worse [layout]


@dataclass(frozen=True)
class TriedEffect:
    """One effect that was tried: `left`, the error that stays when it alone is added to the model before, where that is known."""

    entry: EffectEntry
    left: float | None


def first_screen(result: Diagnosed) -> FirstScreen:
    """All of it."""
    return FirstScreen(
        _sentence(result), (_holds(result), _where(result), _missing(result), _error(result), next_reply(advice_of(result.found)))
    )


def accepted(result: Diagnosed) -> list[EffectEntry]:
    """The effects that are named."""
    return [] if isinstance(result.found, Addition) else [one for one in result.found.effects if one.accepted]


def faults(result: Diagnosed) -> dict[str, EffectEntry]:
    """Changes of CSJ and BLK, by name."""
    return {} if isinstance(result.found, Addition) else {name: one for name, one in result.found.faults.items() if one.accepted}


def telling(result: Diagnosed) -> list[BlockEntry]:
    """Balances that stand above their noise, the one with most of the excess first."""
    return sorted((one for one in result.blocks if one.telling), key=lambda one: -one.share_percent)


def candidates(result: Diagnosed) -> list[TriedEffect]:
    """Every effect of the ranking with the error that it leaves alone, best first as ranked.

    By simulation a score is what the effect takes off the cost, and the cost is the squared weighted error times the number of samples.
    """
    if isinstance(result.found, Addition):
        return []
    first = next((place for place, step in enumerate(result.steps) if step.effects), None)
    own = next((one for one in result.suspects if first is not None and one.name == result.steps[first].added), None)
    start = result.errors.get("before")
    if first:
        start = result.steps[first - 1].training
    elif first is None and result.steps:
        start = result.steps[-1].training
    samples = _samples(result)
    if own is not None and own.score > 0.0 and first is not None and start is not None and start > result.steps[first].training:
        samples = own.score / (start**2 - result.steps[first].training ** 2)

    def left(one: EffectEntry) -> float | None:
        if result.by_forces or start is None or not samples or not one.score > 0.0:
            return None
        # an effect that came later was judged beside the others: its own rung says what it leaves
        step = next((step for step in result.steps[(first or 0) + 1 :] if one.accepted and step.added == one.name), None)
        return step.training if step is not None else math.sqrt(max(0.0, start**2 - one.score / samples))

    return [TriedEffect(one, left(one)) for one in result.found.effects]


def _samples(result: Diagnosed) -> float:
    if result.curves is None:
        return 0.0
    derived = result.curves.derived
    return float(result.curves.rows * sum(1 for name in result.curves.measured if name not in derived))


def next_best(result: Diagnosed) -> tuple[TriedEffect, TriedEffect] | None:
    """The named effect that came first and the best that is not named, both with the error that they leave alone."""
    tried = [one for one in candidates(result) if one.left is not None]
    best = min((one for one in tried if one.entry.accepted), key=lambda one: -one.entry.score, default=None)
    alike = set(best.entry.alike) if best is not None else set()
    other = min(
        (one for one in tried if not one.entry.accepted and one.entry.name not in alike), key=lambda one: one.left or 0.0, default=None
    )
    return None if best is None or other is None else (best, other)


def _answerable(result: Diagnosed) -> bool:
    return isinstance(result.found, Addition) or result.found.gate.answerable


def _changes(result: Diagnosed) -> list[str]:
    """What has changed of the machine, faults first, as in `friction (CSJ) +40 %`."""
    told = []
    for name, one in faults(result).items():
        plain = {"csj": "friction (CSJ)", "blk": "backlash (BLK)"}.get(name, name)
        ends = one.shift_interval95
        half = 0.5 * (ends[1] - ends[0]) if ends is not None and ends[0] is not None and ends[1] is not None else None
        told.append(f"{plain} {names.changed(one.shift_percent, half)}" if one.shift_percent is not None else f"{plain} changed")
    return told + [_changed(one) for one in result.changes if one.entry.counts and one.name not in FAULTS.values()]


def _changed(one: ShownChange) -> str:
    """One value that is no fault."""
    if one.entry.change_percent is None:
        return f"{one.title} changed"
    low, high = one.entry.interval95
    half = 50.0 * (high - low) / abs(one.entry.healthy) if low is not None and high is not None else None
    return f"{one.title} {names.changed(one.entry.change_percent, half)}"


def _off_sheet(result: Diagnosed) -> list[str]:
    if not isinstance(result.found, DiagnosisResult):
        return []
    plain = {"csj_Nm": "friction (CSJ)", "blk_mm": "backlash (BLK)"}
    return [f"{plain.get(name, name)} {names.changed(shift)}" for name, shift in result.found.unit_shift_percent.items()]


def _sensor(result: Diagnosed) -> str:
    """The signal whose sensor is suspected."""
    found = result.found
    return found.sensor.channel if isinstance(found, DiagnosisResult) and result.verdict == "unknown" and found.sensor is not None else ""


def _suspected(result: Diagnosed) -> str:
    """Whose error is suspected, in words."""
    return names.suspected(_sensor(result))


def _sentence(result: Diagnosed) -> str:
    if result.added:
        fell = _fell(result)
        return f"{names.display(result.added)} is in the model{': the error falls ' + fell if fell else ''}."
    if not _answerable(result):
        return "This record cannot say whether the model holds."
    changed, off = _changes(result), _off_sheet(result)
    if result.verdict == "missing":
        named = [one.name for one in accepted(result)]
        first = names.listed([names.display(named[0]), *map(names.within, named[1:])]) if named else "An effect"
        rivals = () if isinstance(result.found, Addition) else result.found.rivals
        first += "".join(f" or {names.within(rival)}" for rival in rivals)
        worn = f"; {names.listed(changed)}" if changed else f"; {names.listed(off)} off the data sheet" if off else ""
        mostly = _mostly_unexplained(result)
        least = f", and {mostly}" if mostly else ""
        return f"The model does not hold{least}. {first} {'are' if len(named) > 1 else 'is'} missing{worn}."
    if result.verdict == "unknown":
        if _untellable(result):
            return f"The model leaves {_size(result, result.errors.get('before', 0.0))} of the drive, and these records do not tell whether that is chance or something missing."
        if _sensor(result):
            return f"The model does not explain this record: it looks as if the {_suspected(result)} is at fault."
        if _refuted(result):
            return "The model does not hold, but what would explain this record does not hold on the validation record: nothing is recommended."
        candidate = _candidate(result)
        return f"The model does not hold. {f'{unexplained_by(*candidate)}.' if candidate else 'No effect of the library explains it.'}"
    if changed:
        return f"No effect is missing, but the machine has changed: {names.listed(changed)}."
    if off:
        return f"The model holds with other values than the data sheet's: {names.listed(off)}."
    return "The model holds. Nothing is missing, and nothing has changed." if result.relative else "The model holds: nothing is missing."


def _candidate(result: Diagnosed) -> tuple[tuple[str, ...], float, float] | None:
    """The effects of the best candidate, the error that it leaves and the noise level; None by the balance of forces, or where no noise level is known."""
    after, floor = result.errors.get("after", result.errors.get("before")), result.errors.get("floor")
    if result.by_forces or after is None or not floor:
        return None
    return (result.steps[-1].effects if result.steps else ()), after, floor


def _untellable(result: Diagnosed) -> bool:
    """Whether these records do not tell chance from something missing."""
    return isinstance(result.found, DiagnosisByBalanceResult) and bool(result.found.untellable)


def _refuted(result: Diagnosed) -> bool:
    """Whether the error would fall on this record and rise on the validation record."""
    before, after = result.errors.get("holdout_before"), result.errors.get("holdout_after")
    fell = result.errors.get("after", math.inf) < result.errors.get("before", 0.0)
    return fell and before is not None and after is not None and after > before


def _holds(result: Diagnosed) -> Reply:
    question = "Does the model hold?"
    before, floor, after = (result.errors.get(name) for name in ("before", "floor", "after"))
    against = "" if before is None else f"error {_size(result, before)}"
    if floor is not None and before is not None:
        against += f", noise level {words.number(floor)}"
    if result.added:
        near = after is not None and floor is not None and after <= EXPLAINED * floor
        return Reply(
            question,
            "With it, yes" if near else "Better with it",
            f"noise level {words.number(floor)}" if floor is not None else "",
            "good" if near else "unsure",
        )
    if not _answerable(result):
        return Reply(question, "Cannot be told", result.gate_sentence, "unsure")
    if _untellable(result):
        return Reply(question, "Cannot be told", against, "unsure")
    if result.verdict != "adequate":
        return Reply(question, "No", against, "bad")
    if faults(result) or _changes(result):
        return Reply(question, "Yes, worn" if faults(result) else "Yes, but changed", against, "unsure")
    return Reply(question, "Yes", against, "good")


def _size(result: Diagnosed, value: float) -> str:
    """An error with its unit."""
    return f"{words.number(value)} %" if result.by_forces else f"{words.number(value)} × sensor noise"


def _where(result: Diagnosed) -> Reply:
    question = "Where does it fail?"
    if _sensor(result):
        return Reply(question, _suspected(result).capitalize(), "the signals are else as they should be", "bad")
    found, reading = telling(result), None if isinstance(result.found, Addition) else result.found.where.reading
    if reading is not None and found:
        what = f"{names.signal(reading.channel).partition(',')[0]} {reading.words}"
        title = names.suspected(reading.channel).capitalize() if reading.outside_mechanics else names.block(found[0].name)
        return Reply(question, title, what, "bad" if result.verdict != "adequate" else "unsure")
    if result.added:
        return Reply(question, "Not asked", "ema diagnose with the new model says where")
    if not found:
        if result.verdict == "adequate" and result.blocks:
            return Reply(question, "Nowhere", "no equation stands above its noise level", "good")
        if result.by_forces:
            return Reply(question, "Mechanics", "the balance of forces alone was asked", "bad")
        return Reply(question, "Not told", "no equation is accused")
    first = found[0]
    term = next((one for one in first.terms[:1] if one.explained_percent >= _TERM_PERCENT), None)
    told = f"{words.number(first.share_percent, 2)} % of what is left over"
    if term is not None:
        told += f", {term.words} ({words.number(term.explained_percent, 2)} % of it)"
    return Reply(question, names.block(first.name), told, "bad" if result.verdict != "adequate" else "unsure")


def _missing(result: Diagnosed) -> Reply:
    question = "What is missing?"
    if result.added:
        found = result.found
        assert isinstance(found, Addition)
        sizes = [names.sized(one.value, one.std, one.unit) for one in found.parameters.values()]
        return Reply(
            "What was added?", names.display(result.added), f"size {sizes[0]}" if sizes else "", "good" if found.recommended else "unsure"
        )
    named = accepted(result)
    if result.verdict == "adequate":
        worn = _changes(result)
        return Reply(
            question,
            "Nothing",
            "; ".join([f"but {names.listed(worn)}", *own_form_leaves(result)]) if worn else _unchanged(result),
            "unsure" if worn else "good",
        )
    if result.verdict == "unknown" or not named:
        nearest = _nearest(result)
        if _sensor(result):
            return Reply(question, "Nothing of the library", "; ".join([f"the {_suspected(result)} explains it", *nearest]), "unsure")
        share = result.found.unexplained if not isinstance(result.found, Addition) else None
        told = f"{100.0 * share:.0f} % of the excess stays unexplained" if share is not None else "no effect of the library explains it"
        return Reply(question, "Not in the library", "; ".join([told, *nearest]), "bad")
    first = named[0]
    told = ""
    size = next(iter(first.parameters.items()), None)
    if size is not None:
        unit = names.unit_of(f"effects.{first.name}.{size[0]}")
        told = f"{size[0].rsplit('_', 1)[0] if unit else size[0]} {names.sized(size[1], first.std.get(size[0]), unit)}"
        place = first.parameters.get("place_mm")
        told += f" at {words.number(place)} mm" if place is not None else ""
    if mostly := _mostly_unexplained(result):
        told += f"; {mostly}"
    told += "".join(f"; {part}" for part in own_form_leaves(result))
    rivals = next_best(result)
    if not isinstance(result.found, Addition) and result.found.rivals:
        told += f"; {names.listed(list(map(names.within, result.found.rivals)))} equally well"
    elif rivals is not None and rivals[0].left and rivals[1].left:
        told += (
            f"; next best, {names.within(rivals[1].entry.name)}, leaves {words.number(rivals[1].left / rivals[0].left, 2)} times its error"
        )
    return Reply(
        question, names.listed([names.display(named[0].name), *(names.within(one.name) for one in named[1:])]), told.lstrip("; "), "bad"
    )


def _mostly_unexplained(result: Diagnosed) -> str:
    """That most of what is left by a balance has no name, which is more than any name that is found; empty where it has."""
    share = result.found.unexplained if isinstance(result.found, DiagnosisByBalanceResult) else None
    return (
        f"most of what is left ({100.0 * share:.0f} %) is explained by nothing in the library"
        if share is not None and share > MOSTLY
        else ""
    )


def own_form_leaves(result: Diagnosed) -> list[str]:
    """What the machine's own form leaves of what was found by simulation, in words, where it is not next to nothing."""
    after, floor = (result.errors.get(name) for name in ("after", "floor"))
    near = after is not None and floor is not None and after <= AT_FLOOR * floor
    share = result.found.unexplained if isinstance(result.found, DiagnosisResult) and result.verdict != "unknown" and not near else None
    return [f"{100.0 * share:.0f} % of the excess stays unexplained"] if share is not None and share > LEAVES and _found(result) else []


def _found(result: Diagnosed) -> bool:
    """Whether anything was found that may leave a share."""
    return bool(accepted(result) or _changes(result))


def _nearest(result: Diagnosed) -> list[str]:
    """Where no effect is named: the one that comes nearest, how far it stays from the noise level, and how much worse the next best is."""
    tried = sorted(_left_alone(result), key=lambda one: one[1])
    if not tried:
        return ["no effect that was tried takes anything off"]
    (name, left), floor = tried[0], result.errors.get("floor")
    far = f"{words.number(left / floor, 2)} times the noise level" if floor else f"an error of {_size(result, left)}"
    alike = {other for one in result.suspects if one.name == name for other in one.alike}
    other = next(((one, error) for one, error in tried[1:] if one not in alike), None)
    worse = ""
    if other is not None and left > 0.0:
        times = other[1] / left
        worse = (
            f"; next best {names.within(other[0])}, {f'{words.number(times, 2)} times its error' if times >= _WORSE else 'hardly worse'}"
        )
    return [f"nearest is {names.within(name)}, which leaves {far}{worse}"]


def _left_alone(result: Diagnosed) -> list[tuple[str, float]]:
    """Effects that were tried with the error that each leaves alone; by the balance of forces on what was fitted."""
    if isinstance(result.found, DiagnosisByBalanceResult):
        return [(one.effect, one.training_percent) for one in result.found.forces.refused if one.training_percent is not None]
    return [(one.entry.name, one.left) for one in candidates(result) if one.left is not None]


def _unchanged(result: Diagnosed) -> str:
    """What is as it was, where nothing is missing and nothing has changed."""
    return "friction (CSJ) and backlash (BLK) are as on the healthy records" if result.relative else "no effect of the library would help"


def _fell(result: Diagnosed) -> str:
    before, after = result.errors.get("before"), result.errors.get("after")
    if before is None or after is None:
        return ""
    return f"from {words.number(before)} to {words.number(after)}"


def _error(result: Diagnosed) -> Reply:
    question = "Error, before and after?"
    before, after, held, later, floor = (
        result.errors.get(name) for name in ("before", "after", "holdout_before", "holdout_after", "floor")
    )
    if before is None:
        return Reply(question, "Not known", "nothing was fitted")
    parts = ["% of the drive's force" if result.by_forces else "times the sensor noise"]
    if result.verdict == "unknown" and after is not None:
        # no fall: what lowers the error is not accepted
        times = f", {words.number(after / floor, 2)} times the noise level" if floor else ""
        validated = (
            f", and {words.number(held)} → {words.number(later)} on the validation record" if held is not None and later is not None else ""
        )
        told = f"the best candidate, not accepted, leaves {words.number(after)}{times}{validated}"
        return Reply(question, f"{words.number(before)}, not explained", f"{parts[0]}; {told}", "bad")
    short = words.number(before) if after is None else f"{words.number(before)} → {words.number(after)}"
    if held is not None:
        fell = words.number(held) if later is None else f"{words.number(held)} → {words.number(later)}"
        parts.append(f"{'held out' if result.by_forces else 'validation record'} {fell}")
    elif not result.by_forces:
        parts.append("no validation record")
    if result.verdict == "adequate" and not faults(result) and result.relative and after is not None and not result.by_forces:
        parts.insert(1, "after: with what differs from day to day")
    near = floor is not None and (after if after is not None else before) <= EXPLAINED * floor
    return Reply(question, short, "; ".join(parts), "good" if near else "")


def rungs(result: Diagnosed) -> list[tuple[str, float, float | None]]:
    """The ladder: what came last, the error on this record, that on the validation record; the model as given first."""
    if "before" not in result.errors:
        return []
    found = [("as given", result.errors["before"], result.errors.get("holdout_before"))]
    refused = NOT_ACCEPTED if result.verdict == "unknown" else ""
    found += [(f"{step.added or ' + '.join(step.effects)}{refused if step.effects else ''}", *step.read) for step in result.steps]
    return found


def rung_words(name: str, known: Collection[str]) -> str:
    """What a rung adds: effects and faults by their display names, anything else as it is."""
    plain = name.removesuffix(NOT_ACCEPTED)
    parts = re.split(r" and | \+ ", plain)
    return (names.listed(list(map(names.within, parts))) if all(part in known for part in parts) else plain) + name[len(plain) :]


def model_titles(result: Diagnosed, curves: Curves) -> dict[str, str]:
    """What each model is called."""
    added = [result.added] if result.added else [one.name for one in result.suspects if one.accepted]
    titles = dict(_MODELS)
    if added:
        titles["after"] = "with " + names.listed([names.within(name) for name in added])
    elif result.verdict == "adequate":
        titles["after"] = "with today's values"
    elif result.verdict == "unknown":
        titles["after"] = "best candidate, not accepted"
    return {key: titles.get(key, key) for key in curves.models}
