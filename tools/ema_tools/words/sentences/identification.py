"""What `ema identify` says."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ema_tools.compare.comparison import TITLES as SIGNAL_TITLES
from ema_tools.data.actuator import row_of
from ema_tools.fit.nuisance import COPPER_PER_DEGC
from ema_tools.library.display_names import all_coded, coded, value_called
from ema_tools.plant.native import IdentifiedValue
from ema_tools.results.identification import TableFinding, ValueEntry, ValuesSearchEntry
from ema_tools.select.cross_check import LITTLE_LEFT, CrossCheck
from ema_tools.tasks.baseline_records import known_by_sheet
from ema_tools.tasks.healthy_runs import DRY
from ema_tools.tasks.identify import NOT_ADEQUATE, Identified
from ema_tools.tasks.objective_shape import Undetermined
from ema_tools.words.sentences.few_records import few_records
from ema_tools.words.sentences.sensors import sensor_next, sensor_sentence
from ema_tools.words.sentences.sizes import MUCH_HIDDEN, significant, size_text

_TELLING = ("motor_position_mm", "current_A", "voltage_V")
_UNLIKELY = 0.06  # of the winding's resistance, 15 degC: a sensor of the current that is as far off is as likely [judgement]
_NOTED = 0.005  # of friction: less is not worth a sentence [judgement]
# Between what the search reads and why it does not stand.
BECAUSE = ", which does not stand, because "
TITLES = {"screw.csj_Nm": "CSJ", "screw.blk_mm": "BLK"}


def missing_words(checked: CrossCheck) -> str:
    """The missing effect in words, for a list of reasons."""
    if checked.unusable:
        return f"nothing can be told from this record: {checked.skipped}"
    if checked.kind == "unknown" and checked.sensor is not None:
        return f"{sensor_sentence(checked.sensor)}: {sensor_next(checked.sensor)}"
    if checked.kind == "unknown":
        what = "something is missing from the model that no effect of the library explains: ema diagnose draws it"
        return what if checked.against else f"{what}; healthy records of this unit and command, with --healthy, take off what it always has"
    size = next(iter(checked.values))
    if checked.as_given and checked.against:
        return (
            f"{_effect(checked, size)} is in the model at this very size, but the healthy records are of the machine without it, beside which all signals say {_shifts(checked)}: "
            "leave --healthy out, or give healthy records of the machine with it"
        )
    missing = "is not in the model at this size" if checked.there else "is missing from the model"
    alike = f", which looks like {all_coded(checked.effects[1:])} on this record" if checked.effects[1:] else ""
    who = (
        f"the signals without the {SIGNAL_TITLES[checked.left_out]} (does it record what is applied, or what is asked for?) say"
        if checked.left_out
        else "all signals say"
    )
    return (
        f"{_effect(checked, size)} {missing}{alike}, beside which {who} {_shifts(checked)}: "
        f"ema add ACTUATOR {checked.effects[0]} --fit REC {'--healthy REC ...' if checked.against else '--known'} -o NEW.toml puts it in"
    )


def new_sentence(effects: Iterable[str]) -> str:
    """Effects of the model that the healthy records do not have: a machine without wear may have changed all the same."""
    return f"New since the healthy records: {all_coded(effects)}, counted for today's record alone."


def _effect(checked: CrossCheck, size: str) -> str:
    return coded(checked.effects[0], f"{row_of(size).field} {size_text(size, checked.values[size], checked.std.get(size))}")


def _more(checked: CrossCheck) -> str:
    """Which signals to record besides; where all are there, healthy records tell what the unit always has."""
    lacking = [SIGNAL_TITLES[name] for name in _TELLING if name not in checked.signals]
    if not lacking:
        return "more healthy records of this unit narrow what differs from day to day"
    listed = lacking[0] if len(lacking) == 1 else f"{', '.join(lacking[:-1])} and {lacking[-1]}"
    return f"record {listed} too"


def _signals(found: Iterable[str]) -> str:
    return ", ".join(SIGNAL_TITLES[name] for name in found)


def _shifts(checked: CrossCheck) -> str:
    return ", ".join(f"{TITLES[name]} {round(100.0 * shift, 1) + 0.0:+.1f} %" for name, shift in checked.shift.items())


def objection_words(found: Identified, checked: CrossCheck) -> str:
    """Why the module's answer does not stand, and what would help, for a list of reasons."""
    if found.objection == "rival":
        others = f", as do {all_coded(checked.effects[1:])}" if checked.effects[1:] else ""
        return (
            f"{_effect(checked, next(iter(checked.values)))} explains the record as well as a fault{others}: {_more(checked)}, "
            f"or ema next ACTUATOR --between csj {checked.effects[0]} finds a command that tells them apart"
        )
    if found.objection == "healthy":
        return found.doubt
    if found.objection == "signals":
        return f"the signals together ({_signals(checked.signals)}) say {_shifts(checked)}: ema diagnose ACTUATOR REC looks at all of them"
    if found.objection == "open" and found.foretold is not None and found.within_climate():
        warmth = f"CSJ by {significant(200.0 * found.foretold.by_temperature, 2)} %"
        return f"today's winding and grease are those of another temperature than on the healthy records, and with it values may differ ({warmth}): healthy records at today's temperature would tell"
    if found.objection == "open" and found.within_scatter():
        scatter = ", ".join(
            f"{TITLES[name]} by {significant(100.0 * found.healthy_std(name) / abs(found.healthy[name]), 2)} %" for name in checked.shift
        )
        if known_by_sheet(found.healthy):
            return f"no healthy record has told this unit's healthy values, and units differ from their data sheet ({scatter}): healthy records of it would tell"
        if set(checked.shift) & set(found.healthy.scatter):
            return f"this unit differs too much from run to run to tell ({scatter}), as [scatter] of its file states, and only what further runs show again is a change"
        return (
            f"healthy records of this unit differ from each other too much to tell ({scatter}): more of them, at today's temperature, would"
        )
    if found.objection == "open":
        name = found.least_sure()
        stands = checked.open[name]
        percent = 100.0 * stands.doubt(2.0, found.healthy[name])
        return (
            f"this record hardly tells {TITLES[name]} from {row_of(stands.most).field}, which differs from day to day: "
            f"{TITLES[name]} may be off by {significant(percent, 2)} % for that: {_more(checked)}, or a chirp to a higher frequency"
        )
    return missing_words(checked)


def reasons(found: Identified) -> tuple[str, ...]:
    """Why it is undecided: the module's reasons, and what all signals object behind the first of them."""
    own = () if found.sure_beside_remainder or found.sound_by_scatter else found.answer.reasons
    if not found.objects or found.checked is None:
        return tuple(own)
    words = objection_words(found, found.checked)
    if found.checked.unusable or (found.checked.kind == "unknown" and found.checked.sensor is not None):
        # of a record that cannot answer, or a sensor that reads otherwise, a residual says nothing about the model
        return (words, *(reason for reason in own if reason != NOT_ADEQUATE))
    place = own.index(NOT_ADEQUATE) + 1 if NOT_ADEQUATE in own else 0
    return (*own[:place], words, *own[place:])


def sentence(found: Identified) -> str:
    """The answer in one sentence, and another where few healthy records stand behind it."""
    few = few_records(found.baseline.records, found.healthy) if found.baseline is not None else ""
    new = f" {new_sentence(found.since)}" if found.since else ""
    return f"{_verdict(found)}{new}{_hides(found)}{_reach(found) or _left(found)}{_beside(found)}{_warmth(found)}{_magnets(found)}{_winding(found)}{few}"


def _beside(found: Identified) -> str:
    """That an effect is missing beside a fault that stands, whose sizes it may change."""
    return f" Besides, {missing_words(found.checked)}." if found.checked is not None and found.stands_beside_effect else ""


def _reach(found: Identified) -> str:
    """That the size of a fault hangs on something else that the record leaves open, where that is as much as a fault."""
    checked = found.checked
    if checked is None or found.verdict != "fault":
        return ""
    told = []
    for name, (low, high) in _ends_percent(found).items():
        stands = checked.open.get(name)
        wide = 0.01 * found.least_percent[name] * abs(found.healthy[name])
        if stands is not None and max(stands.reach.below, stands.reach.above) > wide:
            what = value_called(stands.reach.by)
            told.append(
                f" {TITLES[name]} lies anywhere from {low:+.0f} to {high:+.0f} %: this record hardly tells it from {what}, which may be another today; {_more(checked)}."
            )
    return "".join(told)


def _ends_percent(found: Identified) -> dict[str, tuple[float, float]]:
    """The 95 % interval of each shift whose interval is known, in % of the healthy value, by name."""
    ends = {}
    for one in found.answer.identified:
        low, high = found.interval95(one)
        healthy = abs(found.healthy[one.name])
        if one.name in TITLES and low is not None and high is not None and healthy > 0.0:
            below, above = (100.0 * (end - one.estimate) / healthy for end in (low, high))
            ends[one.name] = (one.shift_percent + below, one.shift_percent + above)
    return ends


def _hides(found: Identified) -> str:
    """What a healthy answer may hide, where that is much more than its threshold."""
    ends = _ends_percent(found)
    far = {name: high for name, (_, high) in ends.items() if high > MUCH_HIDDEN * found.least_percent.get(name, np.inf)}
    if found.verdict != "healthy" or _scatter(found) or not far:
        return ""
    name = max(far, key=lambda one: far[one] / found.least_percent[one])
    why = (
        "which another temperature than that of the healthy records explains: healthy records at today's temperature tell it"
        if found.mostly_climate()
        else "which lies within what is known of this unit: more healthy records narrow it"
    )
    return f" {TITLES[name]} may be as far off as {far[name]:+.0f} %, {why}."


def _left(found: Identified) -> str:
    """That a fault is not all there is, where what is left of the record is too little to change it."""
    checked = found.checked
    if checked is None or found.verdict != "fault" or checked.skipped != LITTLE_LEFT:
        return ""
    return " Beside it the model lacks something that is too little to be its cause but may move its size: ema diagnose with the same records says what."


def _magnets(found: Identified) -> str:
    """That magnets as warm as the winding are no effect, where they differ from those of the healthy records."""
    if found.magnets is None:
        return ""
    degC, percent = found.magnets.warmer_degC, 100.0 * abs(found.magnets.loss)
    how, flux = ("warmer", "weaker") if degC > 0.0 else ("colder", "stronger")
    return f" The winding is {abs(degC):.0f} degC {how} than on the healthy records, and its magnets {percent:.1f} % {flux} as temperature makes them, which is taken off."


def _winding(found: Identified) -> str:
    """What else a winding may be that reads as warm as nothing else does: a current that is read wrongly, and with it friction."""
    shifts = found.checked.shift if found.checked is not None else {}
    if found.winding is None or abs(found.winding) < _UNLIKELY or found.verdict == "undecided" or DRY not in shifts:
        return ""
    degC, percent = found.winding / COPPER_PER_DEGC, 100.0 * ((1.0 + shifts[DRY]) * (1.0 + found.winding) - 1.0)
    return (
        f" The winding reads {abs(degC):.0f} degC {'warmer' if degC > 0.0 else 'colder'} than on the healthy records, and nothing else in this record tells of a temperature: "
        f"were it as warm as there, the sensor of the current would read {1.0 / (1.0 + found.winding):.2f} times the current, and CSJ would be about {round(percent) + 0:+d} %."
    )


def _warmth(found: Identified) -> str:
    """That friction is held against what it should be at today's temperature, where that is not what the healthy records had."""
    if found.foretold is None or abs(found.foretold.shift) < _NOTED:
        return ""
    value = found.healthy["screw.csj_Nm"]
    return f" At today's temperature CSJ is held against {value:.4g} Nm, {100.0 * found.foretold.shift:+.1f} % from that of the healthy records, by what they show of temperature."


def _verdict(found: Identified) -> str:
    shifts = ", ".join(_shift(found, estimate) for estimate in found.answer.identified)
    if found.verdict == "undecided":
        return f"Undecided: the search reads {shifts}{BECAUSE}{'; '.join(reasons(found))}."
    return f"{found.verdict.capitalize()}: {shifts}.{_not_sure(found)}{_scatter(found)}"


def _not_sure(found: Identified) -> str:
    """Which of two shifts beyond their thresholds is not surely one, where the other is."""
    ends = _ends_percent(found)
    beyond = [one.name for one in found.answer.identified if one.name in ends and one.shift_percent > found.least_percent[one.name]]
    sure = [name for name in beyond if ends[name][0] > found.least_percent[name]]
    if found.verdict != "fault" or not sure:
        return ""
    return "".join(f" The fault is {TITLES[sure[0]]}; whether {TITLES[name]} is one is not sure." for name in beyond if name not in sure)


def _scatter(found: Identified) -> str:
    """Why a shift beyond its threshold is healthy."""
    shifts = found.checked.shift if found.checked is not None else {}
    if not found.sound_by_scatter or all(shift <= 0.01 * found.least_percent[name] for name, shift in shifts.items()):
        return ""
    near = max(shifts, key=lambda name: shifts[name] / found.least_percent[name])
    explained = (
        "another temperature than that of the healthy records explains" if found.mostly_climate() else "its healthy records differ by"
    )
    return f" {TITLES[near]} {100.0 * shifts[near]:+.1f} % is no more than {explained}; {100.0 * found.not_hidden(near):+.0f} % would be."


def _shift(found: Identified, estimate: IdentifiedValue) -> str:
    """The shift with no more digits than its interval has."""
    low, high = found.interval95(estimate)
    healthy = found.healthy[estimate.name]
    half = 50.0 * (high - low) / abs(healthy) if low is not None and high is not None and healthy else float("inf")
    return f"{TITLES.get(estimate.name, estimate.name)} {shift_text(estimate.shift_percent, half)}"


def shift_text(percent: float, half: float) -> str:
    """A shift in % to the digit that half of its 95 % interval changes by one or more, at least one decimal and at most three."""
    decimals = int(min(3, max(1, np.ceil(-np.log10(half))))) if 0.0 < half < np.inf else 1
    return f"{percent:+.{decimals}f} %"


def undetermined_words(one: Undetermined) -> str:
    """That the record does not determine a value, and why."""
    title, unit = TITLES.get(one.name, one.name), row_of(one.name).unit
    between = f"{one.bounds[0]:.4g} .. {one.bounds[1]:.4g} {unit}"
    if one.why == "nothing" or one.interval is None:
        return f"This record does not determine {title}: nothing in it moves with {title}."
    if one.why == "flat":
        return f"This record does not determine {title}: over all that was searched, {between}, the objective changes by no more than noise would."
    return f"This record does not determine {title}: its 95 % interval, {one.interval[0]:.3g} .. {one.interval[1]:.3g} {unit}, is wider than what was searched, {between}."


def determined_words(one: ValueEntry) -> str:
    """Whether the record determines a value, in a few words."""
    if one.determined == "together":
        return f"only together with {one.alike}"
    if one.determined == "no":
        return "not by this record"
    return "yes, but at its bound" if one.at_bound else "yes"


def values_sentence(found: Mapping[str, ValueEntry], search: ValuesSearchEntry) -> str:
    """What the search for several values at once says, in one sentence."""
    told = sum(one.determined == "yes" for one in found.values())
    how = (
        f"in {search.runs} model runs, residual {search.misfit_before:.3g} times the noise before and {search.misfit_after:.3g} times after"
    )
    left = "" if search.adequate else "; an effect is missing, which the values have partly taken up"
    count = f"{len(found)} value{'s' if len(found) > 1 else ''}"
    return f"Of {count} searched at once by {_signals(search.noise)} the record determines {told} {how}{left}."


def table_sentence(found: TableFinding) -> str:
    """What a table of signatures says, in one sentence."""
    said = {
        "adequate": "nothing is missing",
        "missing": f"missing is {coded(found.effect or '', f'size {found.size:.3g}')}",
        "unknown": "something is missing that no effect of the table explains",
        "none": "the record runs another command, so nothing can be said",
    }[found.kind]
    others = all_coded(name for name in found.alike if name != found.effect) if found.kind == "missing" else ""
    return f"Table of signatures: {said}{f' (looks like {others})' if others else ''}."
