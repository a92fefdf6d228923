"""What `ema diagnose` says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ema_tools.data.actuator import Actuator, row_of
from ema_tools.library.display_names import all_coded, coded, value_words, within
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of, separable, separating
from ema_tools.results.parts import MUCH_LEFT, ErrorsEntry
from ema_tools.select.outcome import Named
from ema_tools.tasks.diagnose import Answer
from ema_tools.words.sentences import unexplained, validity
from ema_tools.words.sentences.few_records import few_records
from ema_tools.words.sentences.identification import TITLES as FAULT_TITLES
from ema_tools.words.sentences.sensors import sensor_next, sensor_sentence
from ema_tools.words.sentences.sizes import significant, size_text

AT_FLOOR = 1.05  # times the floor: an error no larger leaves chance alone, of which no share is told [judgement]
NOT_ACCEPTED = " (not accepted)"  # behind a model of the ladder that is not recommended
_HARDLY_MORE = 1.1  # times the noise: less is told with more digits, which round to one [layout]
_NEARLY_SURE = 0.99  # no prior is known so well that more digits would mean anything [layout]
LEAVES = 0.05  # of the excess, which no law of a library leaves that has the machine's own form [judgement]


def sentence(found: Answer) -> str:
    """The answer in a sentence or two."""
    if not found.gate.answerable:
        return validity.sentence(found.gate)
    return f"{_said(found)}{few_records(len(found.evidence.repeats), found.evidence.actuator)}"


def _said(found: Answer) -> str:
    first = f"{found.record.file}: "
    fall = f"weighted error {found.errors.before:.3g} before, {found.errors.after:.3g} after, floor {found.errors.floor:.3g}"
    before = f"weighted error {found.errors.before:.3g}, floor {found.errors.floor:.3g}"
    faults = "; ".join(_fault_words(one, found.known) for one in found.faults)
    if found.verdict == "adequate":
        versus = "this machine's repeatability" if found.evidence.relative else "what sensors and a data sheet leave open"
        none = "no effect of the library explains more" if _leaves_much(found) else "no effect is missing"
        text = f"nothing exceeds {versus}: {none}" if not faults else f"{none}; {faults}"
        apart = _unit_words(found)
        return f"{first}{f'no effect is missing, but {apart}' if apart else text} ({fall}{_left(found)})."
    if found.verdict == "unknown":
        if found.doubt:
            return f"{first}nothing can be concluded, since the healthy records differ by themselves: {found.doubt}."
        if found.sensor is not None:
            apart = _unit_words(found)
            return f"{first}{sensor_sentence(found.sensor)}{f'; beside it {apart}' if apart else ''} ({before})."
        if found.contradicted_by_healthy:
            would = all_coded(found.refuted, " and ")
            return (
                f"{first}{would} would explain it, but nothing is missing on the record held out, as on a run of the healthy machine, and its error rises: "
                f"nothing is recommended ({_attempt(found)})."
            )
        if found.refuted:
            last = unexplained.sentence(found.left[0]) if found.left else ""
            told = f"{first}something is there, and {all_coded(found.refuted, ' and ')} would explain it, but not the record held out, whose error rises"
            return f"{told}: no effect is recommended ({_attempt(found)}). {last}".strip()
        fit = found.diagnosis.fit
        text = unexplained_by(fit.effects if fit is not None else (), found.errors.after, found.errors.floor)
        return f"{first}{text}. {unexplained.sentence(found.left[0]) if found.left else ''}".strip()
    rivals = {names[0]: names[1:] for names in found.rivals}
    shares = {one.name: one.probability for one in found.diagnosis.named}
    named = " and ".join(_or_rivals(one, rivals.get(one.name, ()), shares) for one in found.effects)
    apart = "".join(f"; {separation(names)}" for names in found.rivals)
    faults = f"; beside it {faults}" if faults else ""
    shifted = _unit_words(found)
    faults += f"; {shifted}" if shifted else ""
    are = "is" if len(found.refuted) == 1 else "are"
    refuted = (
        f"; {all_coded(found.refuted, ' and ')} would lower the error further but raise that of the record held out, and {are} not recommended"
        if found.refuted
        else ""
    )
    return f"{first}missing is {named}{faults}{refuted} ({fall}{_left(found)}){apart}.{_usual(found)}"


def _usual(found: Answer) -> str:
    """What nearly every machine has of the accepted effects, where no baseline records show that this machine had it before."""
    if found.evidence.relative:
        return ""
    return "".join(f" {within(one.name).capitalize()}: {usual}." for one in found.effects if (usual := record_of(one.name).usual))


def _probability(share: float | None) -> str:
    """A probability with as many digits as its priors support; empty where none is stated."""
    if share is None:
        return ""
    return f"probability {'over 99 %' if share > _NEARLY_SURE else f'{100.0 * share:.0f} %'}"


def _or_rivals(one: Named, rivals: Sequence[str], shares: Mapping[str, float | None]) -> str:
    if one.probability is None:
        return " or ".join([_words(one), *map(coded, rivals)]) + (" (equally well)" if rivals else "")
    return " or ".join([_words(one), *(coded(name, _probability(shares.get(name))) for name in rivals)])


def separation(names: Sequence[str]) -> str:
    """What separates an effect from its rivals, which follow it."""
    if separable(names):
        return f"this experiment separates them: ema next ACTUATOR --between {' '.join(names)}"
    ways = separating(names)
    return "no command separates them" + (f"; this would: {ways[0].do}: {ways[0].because}" if ways else "")


def unexplained_by(effects: Sequence[str], error: float, noise: float) -> str:
    """That no effect explains a record, with the best candidate and the residual that it leaves."""
    ratio = error / noise
    times = f"{significant(ratio, 2 if ratio >= _HARDLY_MORE else 4)} times the noise"
    if not effects:
        return f"No effect of the library explains it: none lowers the error, which is {times}"
    return f"No effect of the library explains it: the best candidate, {' and '.join(map(within, effects))}, leaves {times}"


def _attempt(found: Answer) -> str:
    """The errors of an attempt that is not recommended: no fall, since it does not hold."""
    errors = found.errors
    held = (
        f"; with it the error of the record held out rises from {errors.holdout_before:.3g} to {errors.holdout_after:.3g}"
        if errors.holdout_before is not None and errors.holdout_after is not None
        else ""
    )
    return f"weighted error {errors.before:.3g}, floor {errors.floor:.3g}{held}"


def _left(found: Answer) -> str:
    """What another form of its own leaves of what was found."""
    left, errors = found.diagnosis.unexplained, found.errors
    if found.diagnosis.fit is None:
        return ""
    share = f"; {100.0 * left:.0f} % of the excess stays unexplained" if left > LEAVES and errors.after > AT_FLOOR * errors.floor else ""
    much = (
        f"; {significant(errors.after / errors.floor, 2)} times the floor is left, so that more is missing" if _leaves_much(found) else ""
    )
    held, floor = errors.holdout_after, errors.holdout_floor or errors.floor
    if held is None or held <= MUCH_LEFT * floor:
        return share + much
    return f"{share}{much}; of the record held out {significant(held / floor, 2)} times its floor is left: more is missing, or this stands in for it"


def _leaves_much(found: Answer) -> bool:
    errors = found.errors
    return ErrorsEntry(errors.before, errors.after, errors.floor).leaves_much


def _unit_words(found: Answer) -> str:
    """CSJ and BLK where they lie farther from the data sheet than units do."""
    shifts = [f"{FAULT_TITLES[name]} by {100.0 * shift:+.0f} %" for name, shift in found.unit_shift.items()]
    if not shifts or _leaves_much(found):
        # what is missing besides would make such values, too
        return ""
    return f"the record shows {' and '.join(shifts)} off the data sheet, more than units are: wear, unless it was always so, which healthy records would tell"


def record_next(found: Answer) -> str:
    """The record to make or the part to check next; empty where a command is next."""
    if found.verdict != "unknown":
        return ""
    if found.doubt:
        return "Next: record a third run of the healthy machine, and diagnose again with all of them."
    if found.sensor is not None:
        return f"Next: {sensor_next(found.sensor)}."
    if found.contradicted_by_healthy:
        return f"Next: give --holdout a run of the machine as it is in {found.record.file}, best of another command; if it is one, one of the two is of another machine or another day."
    if found.learned is not None:
        return ""
    return "Next: look at the pictures (--report), and write the effect yourself where you know its physics (docs/YOUR_OWN_EFFECT.md)."


def hidden(found: Answer) -> str:
    """What this kind of evidence cannot show."""
    if found.evidence.relative:
        return ""
    names = ", ".join(sorted({_value_words(one.title) for one in found.evidence.spread}))
    usual = "the slight ripple, cogging, bend of the friction's law, drop and delay that every machine has"
    return f"Without healthy repeats nothing can be named that a unit's usual distance from its data sheet explains as well ({names}), nor {usual}."


def _value_words(name: str) -> str:
    row = row_of(name)
    return FAULT_TITLES[name] if name in FAULT_TITLES else value_words(row.text, row.field)


def _words(one: Named) -> str:
    size = next(iter(one.values))
    texts = [f"{row_of(size).field} {size_text(size, one.values[size], one.std.get(size))}", _probability(one.probability)]
    return coded(one.name, "; ".join(filter(None, texts)))


def _fault_words(one: Named, known: Actuator) -> str:
    name = FAULTS[one.name]
    value, healthy = one.values[name], known[name]
    return f"{one.name.upper()} changed by {100.0 * (value / healthy - 1.0):+.1f} % to {size_text(name, value, one.std.get(name))}"
