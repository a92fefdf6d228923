"""What `ema diagnose` says by the balance of forces."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ema_tools.base.interval import interval95
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.fit.division import By
from ema_tools.fit.nuisance import COPPER_PER_DEGC
from ema_tools.library.display_names import coded, value_coded
from ema_tools.library.registry import called, record_of
from ema_tools.results.diagnosis import FloorFrom, FrictionShape
from ema_tools.results.parts import ForwardErrors
from ema_tools.select.balance_bench import LOAD
from ema_tools.select.force_judge import is_load
from ema_tools.select.force_steps import ForceStep
from ema_tools.select.healthy_balance import SURE_RECORDS, HealthyByBalance
from ema_tools.select.play_changes import PLAY
from ema_tools.select.standstill_changes import SHARE
from ema_tools.select.value_changes import Change
from ema_tools.tasks.diagnose_by_balance import MATTERS, BalanceAnswer
from ema_tools.words.sentences.addition import percent
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits, units_of
from ema_tools.words.sentences.sizes import significant

# What is fitted and held out, in the plural.
PARTS: dict[By, str] = {"lap": "laps", "block": "stretches", "record": "records"}


_TOLD = 0.1  # a smaller share of the excess that stays is not told in the first sentence [layout]
_MORE = 1.75  # times what the healthy records leave, which is told where a change was found: there may be another [judgement]
MOSTLY = 0.5  # a larger share is what the sentence begins with: the names that follow are the lesser part of the answer [judgement]
TELLING = 10.0  # times what was next to nothing: no share of it says anything [layout]
_PLAY_UNSEEN = (
    "A play (BLK) is not seen in these records: it needs the rod's position beside the motor's position or speed, in a motion that turns."
)
_FLOORS: dict[FloorFrom | None, str] = {
    "laps": "the laps repeat to {0:.2f} %",
    "healthy records": "the healthy records leave {0:.2f} %",
    "estimate": "no model of these records will come below some {1} %, by an estimate",
    "noise": "their noise is {1} %, by an estimate",
    None: "no floor is known",
}


def sentence(found: BalanceAnswer) -> str:
    """The answer in a sentence or two."""
    if found.healthy is not None:
        return _against_healthy(found, found.healthy)
    given, division = found.forces.given, found.forces.division
    parts = PARTS[division.by]
    floor = _FLOORS[found.floor_from].format(found.floor_percent, significant(found.floor_percent, 2))
    if not found.accepted:
        said = (
            "these records do not tell whether what is left is chance or something that the model lacks"
            if found.untellable
            else found.unseen
            if found.unseen and not found.exceeds
            else f"no effect of the library carries over to the {parts} held out"
            if found.verdict == "unknown"
            else f"what is left is more than chance, but less than {MATTERS:g} % of the drive, too little to ask for"
            if found.beyond_chance
            else "nothing exceeds what the laps repeat"
            if math.isfinite(found.forces.floor_percent)
            else f"no effect of the library lowers the error on the {parts} held out"
            if math.isfinite(given.holdout)
            else f"no effect of the library lowers the error, but nothing could be held out to see it: none of the {parts} has enough motion for itself, so record longer"
        )
        refitted = f", {found.last.training:.2f} % with the base values refitted" if math.isfinite(found.last.training) else ""
        return f"{found.names}: {said} (force error {given.training:.2f} %{refitted}; {floor}).{_play(found)}"
    last = found.forces.steps[-1].errors
    names = _named(found)
    verb = "are" if len(found.accepted) > 1 else "is"
    # of all rows the model as given may err less than one that is fitted to those that slide
    first = found.forces.refitted.holdout
    beside = f" ({percent(first)} with the base values refitted)" if first > last.holdout > given.holdout else ""
    return (
        f"{found.names}: {_leads(found)}missing {verb} {names}: force error {percent(given.training)} on the {parts} fitted and {percent(given.holdout)} on the {parts} held out before{beside},"
        f" {percent(last.training)} and {percent(last.holdout)} after; {floor}{_stays(found)}.{_usual(found)}{_play(found)}"
    )


def _play(found: BalanceAnswer) -> str:
    """The play that the records show and nobody stated, which moves no force and so is no effect of the balance."""
    one = next((one for one in found.base if one.name == PLAY), None)
    if one is None:
        return f" {_PLAY_UNSEEN}" if found.known[PLAY] > 0.0 else ""
    if not one.by_import:
        return ""
    low, high = interval95(one.value, one.std)
    if low is None or high is None or low <= one.stated:
        return ""
    return (
        f" Motor and rod show a play (BLK) of {significant(one.value, 3)} mm [{significant(low, 3)} .. {significant(high, 3)}], of which the model has"
        f" {significant(one.stated, 3)}: write {PLAY} = {significant(one.value, 3)} into the actuator's file."
    )


def _usual(found: BalanceAnswer) -> str:
    """That what was found is in nearly every machine, where nothing else was."""
    told = [record_of(step.effect).usual for step in found.accepted]
    return f" {'; '.join(one[:1].upper() + one[1:] for one in told)}." if all(told) else ""


def _leads(found: BalanceAnswer) -> str:
    """What stays, before the names, where they explain the lesser part."""
    left = found.unexplained
    if left is None or left <= MOSTLY:
        return ""
    return f"most of what the base values leave ({100.0 * left:.0f} %) is explained by nothing in the library; "


def _stays(found: BalanceAnswer) -> str:
    """What stays beside the names, where it is the lesser part and more than a little."""
    left = found.unexplained
    if left is None or not _TOLD < left <= MOSTLY:
        return ""
    return f"; {100.0 * left:.0f} % of what the base values left above that stays unexplained"


def _named(found: BalanceAnswer) -> str:
    """The effects, a swing with how often it comes, each with those that these records do not tell from it."""
    units = units_of(found.known, found.records)
    return ", ".join(coded(called(step.effect), _told_of(step, units)) for step in found.accepted)


def _told_of(step: ForceStep, units: MachineUnits) -> str:
    """What a name alone does not say; empty where that is nothing."""
    periods = step.values.get(f"{step.effect}.periods")
    told = [units.swing(periods)] if periods is not None else []
    local = record_of(step.effect).local
    if local is not None and local.spot:
        place, width = (step.values[f"{step.effect}.{field}"] for field in ("place_mm", local.spot))
        told.append(f"at {place:.4g} mm, {2.0 * width:.2g} mm wide")
    if record_of(step.effect).along is not None:
        told.append(
            along_text({name.partition(".")[2]: value for name, value in step.values.items() if name.startswith(f"{step.effect}.")}, units)
        )
    # a torque that is there at any motion may be read and not be
    alike = [
        *(coded(called(one)) for one in step.alike),
        *(["a zero of the drive's sensor"] if record_of(step.effect).base_value == LOAD else []),
    ]
    if alike:
        told.append(f"looks like {', '.join(alike)}")
    return "; ".join(told)


def along_text(table: Mapping[str, float], units: MachineUnits) -> str:
    """Between which ends friction differs along the stroke, by the table's values by field; `gain` is the largest change and the nodes are shares of it."""
    nodes = [value * table["gain"] for field, value in table.items() if field.startswith("node_")]
    (least, unit), (most, _) = units.told(min(nodes), "Nm"), units.told(max(nodes), "Nm")
    return f"{least:+.3g} to {most:+.3g} {unit} over {table['first']:.4g} .. {table['last']:.4g} mm"


def _against_healthy(found: BalanceAnswer, machine: HealthyByBalance) -> str:
    """What has changed against healthy records."""
    count, after = len(machine.records), found.last
    given = found.forces.given
    against = f"against {count} healthy record{'s' if count > 1 else ''}"
    then = "after" if found.accepted or found.changed else "with base values refitted to them"
    errors = f"force error {given.training:.2f} % by the healthy machine, {after.training:.2f} % {then}; the healthy records leave {found.healthy_percent:.2f} % of theirs"
    verb = "are" if len(found.accepted) > 1 else "is"
    told = [f"{_leads(found)}missing {verb} {_named(found)}{_stays(found)}"] if found.accepted else []
    told += [_changed(found, one) for one in found.changed]
    if found.as_well:
        names = " or ".join(map(coded, found.as_well))
        told.append(f"these records hardly tell it from {names} beside values that have not changed: slow motion beside fast would")
    if not told:
        told.append(_nothing_told(found, machine))
    elif not found.accepted and after.training > _MORE * found.healthy_percent:
        told.append(
            f"{percent(after.training)} stays, more than the healthy records leave: what the model lacks has grown with it, or something else has changed, which these records do not tell"
        )
    doubt = "" if machine.sure else f" How much healthy records differ is uncertain with {count}: give {SURE_RECORDS} or more."
    unseen = "" if any(one.name == PLAY for one in found.changes) else f" {_PLAY_UNSEEN}"
    return f"{found.names} {against}: {'; '.join(told)} ({errors}).{unseen}{doubt}"


def _nothing_told(found: BalanceAnswer, machine: HealthyByBalance) -> str:
    """What is said where no effect is missing and no value has surely changed."""
    nearest = next((one for one in found.changes if one.name == found.nearest), None)
    if found.untold:
        return "the healthy machine leaves more of these records than its own, and no value alone tells what has changed" + _nearest(
            found, nearest
        )
    if found.exceeds:
        return "what is left is more than of any healthy record, and no effect of the library carries over to what was held out"
    if machine.beyond(found.left_Nm):
        count = len(machine.records)
        return (
            f"no change is sure: the healthy machine leaves more of these records than of its own, but {count} healthy record{'s' if count > 1 else ''} cannot foretell this motion more closely;"
            " more of them, of the same motion, would tell" + _nearest(found, nearest)
        )
    return "nothing has changed by more than healthy records differ"


def _nearest(found: BalanceAnswer, nearest: Change | None) -> str:
    """Which value would explain most, and by how much it fell short."""
    if nearest is None or not nearest.healthy:
        return ""
    share, limit = (100.0 * part / abs(nearest.healthy) for part in (nearest.today - nearest.healthy, nearest.limit))
    title = _title(found, nearest.name)
    return f"; {title} comes nearest, {'+' if share > 0.0 else ''}{significant(share, 2)} %, and must differ by more than {significant(limit, 2)} %"


def _title(found: BalanceAnswer, name: str) -> str:
    """A value by what people call it, its own name behind it."""
    units = units_of(found.known, found.records)
    if swing := swing_called(name, found.known, units):
        return f"{swing} ({name})"
    return value_coded(name) if units.m_per_rad is None else units.title(name)


def swing_called(name: str, machine: Actuator, units: MachineUnits) -> str:
    """What the size of a wave is that comes no oftener than the motor turns: a weight that swings, whatever its effect is called; empty for any other value."""
    effect, _, field = name.partition(".")
    periodic = record_of(effect).periodic
    if periodic is None or field.endswith("phase_rad") or field == "periods" or not is_load(effect, machine[f"{effect}.periods"]):
        return ""
    often, _, cause = units.swing(machine[f"{effect}.periods"]).partition(":")
    return f"swing {'of a weight ' if cause else ''}{often.partition(',')[0]}"


def _changed(found: BalanceAnswer, one: Change) -> str:
    """One value that has changed."""
    row, units = row_of(one.name), units_of(found.known, found.records)
    (healthy, unit), (today, _) = units.told(one.healthy, row.unit), units.told(one.today, row.unit)
    percent_off = 100.0 * (today - healthy) / abs(healthy) if healthy else 0.0
    telling = 0.0 < abs(today - healthy) <= TELLING * abs(healthy)
    share = f" ({'+' if percent_off > 0.0 else ''}{significant(percent_off, 2)} %)" if telling else ""
    text = f"{_title(found, one.name)} has changed from {healthy:.4g} to {today:.4g} {unit}".rstrip() + share
    if one.name == "motor.resistance_ohm" and one.today > one.healthy > 0.0:
        text += f", as by a winding {(one.today / one.healthy - 1.0) / COPPER_PER_DEGC:.0f} K warmer"
    if one.name == SHARE and 0.0 < one.today < one.healthy:
        text += f", as by friction at standstill that is {100.0 * (one.healthy / one.today - 1.0):.0f} % higher above sliding friction"
    return text


def friction_sentence(found: FrictionShape, units: MachineUnits = TURNING) -> str:
    """Where steady friction is least, and how far above that it is at standstill: by the model, and as runs at constant speed show it."""
    text = f"Friction at standstill is {significant(found.above_minimum_percent, 2)} % above its minimum, which lies at {_speed(found.minimum_at_rad_s, units)}"
    seen = found.measured
    if seen is None:
        return f"{text}."
    return (
        f"{text}, by the model; in runs at constant speed it is {significant(seen.above_least_percent, 2)} % higher at {_speed(seen.slowest_rad_s, units)} "
        f"than at {_speed(seen.least_at_rad_s, units)}, where it is least."
    )


def _speed(rad_s: float, units: MachineUnits) -> str:
    speed, unit = units.told(rad_s, "rad/s")
    turns = f" ({rad_s * 60.0 / (2.0 * math.pi):.3g} rpm) of the motor" if units.m_per_rad is None else ""
    return f"{speed:.3g} {unit}{turns}"


def forward_sentence(found: ForwardErrors, units: MachineUnits = TURNING) -> str:
    """The forward solution beside the balance, and why it is looked at."""
    told = []
    whose = "the motor's speed" if units.m_per_rad is None else "the speed"
    if found.before is not None and found.after is not None:
        held = (
            f" (held out {found.holdout_before:.3g} % and {found.holdout_after:.3g} %)"
            if found.holdout_before is not None and found.holdout_after is not None
            else ""
        )
        told.append(
            f"Solved forward over half a second under the measured drive, {whose} is off by {found.before:.3g} % before and {found.after:.3g} % after{held}."
        )
    if found.reads_drive and found.drive_before is not None and found.drive_after is not None:
        names = " and ".join(coded(name, first=place == 0) for place, name in enumerate(found.reads_drive))
        verb = "reads" if len(found.reads_drive) == 1 else "read"
        told.append(
            f"{names} {verb} the measured drive; foretold from the motion alone, the drive is off by {found.drive_before:.3g} % before and {found.drive_after:.3g} % after."
        )
    return " ".join(told)


def held_out_sentence(what: str) -> str:
    """What the errors of the last column are of."""
    return (
        f"Held out: {what}, to which nothing of the line was fitted; it is no part of those fitted, so read down a column and not across."
    )


def lag_sentence(lag_s: float) -> str:
    """By how much the drive, or the motion, is recorded late."""
    late, other = ("drive", "motion") if lag_s > 0.0 else ("motion", "drive")
    return f"The {late} is recorded {1e3 * abs(lag_s):.2g} ms behind the {other}, as by a filter: the balance counts with it, and a model that is written states it as actuator.drive_lag_s."


def next_step(found: BalanceAnswer) -> str:
    """What to do next."""
    doubted = next((one for gate in found.gates for one in gate.remarks if one.topic == "clock" and one.severity == "weakens"), None)
    if doubted is not None and not found.accepted and found.exceeds:
        return f"Next: {doubted.next}; then diagnose again."
    if found.untellable and found.verdict == "unknown":
        return "Next: record each motion twice or more, so that what repeats is told from chance."
    if found.healthy is not None and not found.accepted and found.changed:
        return "Next: look at what has changed on the machine; ema calibrate writes a model of it as it is now."
    if found.healthy is not None and not found.exceeds and not found.accepted:
        return "Next: nothing; keep these healthy records, and add runs of other days, so that scatter from day to day is known."
    if found.accepted:
        return (
            "Next: hold the model with these effects, which --fitted NEW.toml writes, against a record of another motion with ema compare."
        )
    if found.exceeds:
        return "Next: record another motion, slow and fast and both ways, so that what is left can be told by speed, place and direction."
    return "Next: nothing that these records ask for; a record of another motion, slow and fast and both ways, would try the model further."
