"""Results as tables on the terminal, the sentence first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple

from rich.console import Console
from rich.text import Text

from ema_tools.compare.comparison import TITLES, UNITS
from ema_tools.data.actuator import row_of, shown
from ema_tools.fit.detection import rate_text
from ema_tools.fit.division import PARTS, By
from ema_tools.library.display_names import listed, value_called, within
from ema_tools.library.registry import effect_called, record_of
from ema_tools.results.addition import Addition
from ema_tools.results.calibration import CalibrationResult, ForceCalibration, OwnMachineEntry, RodModel
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult, FloorFrom, ForceStepEntry
from ema_tools.results.identification import IdentificationResult, ValueEntry, ValuesSearchEntry
from ema_tools.results.parts import ForwardErrors, StepEntry
from ema_tools.select.healthy_balance import SURE_RECORDS
from ema_tools.select.outcome import Diagnosis as Searched
from ema_tools.words.sentences.balance import along_text, forward_sentence, friction_sentence, held_out_sentence, lag_sentence
from ema_tools.words.sentences.base_values import note
from ema_tools.words.sentences.diagnosis import NOT_ACCEPTED
from ema_tools.words.sentences.identification import (
    BECAUSE,
    determined_words,
    shift_text,
    table_sentence,
    values_sentence,
)
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits
from ema_tools.words.sentences.sizes import ends_text, significant, size_text
from ema_tools.words.terminal.console import number, table
from ema_tools.words.terminal.next_step import say_next

_PLACES = 8
# An error of so many times its sensor's noise is no noise.
_MANY_TIMES = 5.0
_FLOORS: dict[FloorFrom | None, str] = {
    "laps": "floor: lap to lap",
    "estimate": "floor, estimated",
    "noise": "noise, estimated",
    None: "floor: lap to lap",
}
FAULTS = {"csj_Nm": "CSJ", "blk_mm": "BLK"}
# What is held out in turn.
GROUPS: dict[By, str] = {"lap": "parts of the laps", "block": "stretches of time", "record": "parts of the records"}
# The share of the limit below which an effect is not worth a look.
_WORTH_SHOWING = 0.1


def say(console: Console, text: str) -> None:
    """A sentence, as it is."""
    console.print(Text(text))


def comparison(console: Console, found: ComparisonResult, actuator: str) -> None:
    """What `ema compare` found."""
    say(console, found.sentence)
    console.print()
    shown = table(f"{actuator} against {found.name}", "channel", "unit", "rms error", "of measured", text_columns=2)
    for name, error in found.channels.items():
        shown.add_row(TITLES[name], error.unit, number(error.rmse), f"{number(error.relative_percent, 3)} %")
    console.print(shown)
    console.print()
    shown = table("Balances", "balance", "unit", "rms residual", "of measured", "noise", "method", "remark", text_columns=2)
    shown.columns[-1].justify = "left"
    shown.columns[-1].no_wrap = False
    for name, balance in found.balances.items():
        if balance.reason:
            shown.add_row(name, "", "-", "-", "-", "-", balance.reason)
        else:
            resting = balance.resting_percent or 0.0
            rest = f"at rest {resting:.0f} % of the time" if resting >= 0.5 else ""
            shown.add_row(
                name,
                balance.unit,
                number(balance.rms),
                f"{number(balance.relative_percent)} %",
                number(balance.noise_rms, 2),
                number(balance.method_rms, 2),
                rest,
            )
    console.print(shown)
    telling = sorted((place for place in found.where if place.surprise > 0.0), key=lambda place: -place.surprise)[:_PLACES]
    if telling:
        console.print()
        shown = table("Where more of the squared residual lies than of the time", "residual", "part", "share", "time", text_columns=2)
        for place in telling:
            shown.add_row(place.source, f"{place.by} {place.part}", f"{place.share_percent:.0f} %", f"{place.time_percent:.0f} %")
        console.print(shown)


def calibration(console: Console, found: CalibrationResult) -> None:
    """What `ema calibrate` found."""
    if found.method == "balance":
        say(console, f"By the balance of forces: {found.method_reason}.")
        console.print()
    shown_table = table("Calibrated", "value", "unit", "before", "after", "95 % interval", "from", text_columns=2)
    shown_table.columns[-1].justify = "left"
    for name, value in found.parameters.items():
        source = value.source + (", at its bound" if value.at_bound else "")
        row = row_of(name)
        shown_table.add_row(shown(row), value.unit, number(value.before, 5), number(value.after, 5), ends_text(*value.interval95), source)
    console.print(shown_table)
    for names, why in found.left_out.items():
        say(console, f"{names}: {why}." if found.forces is not None else f"No balance for {names}: {why}.")
    if found.at_rod:
        console.print()
        force_models(console, "The mechanics at the rod: force = M a + Fv v + Fc sgn v + offset", found.at_rod)
    console.print()
    if found.forces is not None:
        _force_calibration(console, found.forces)
        return
    errors = table("Measured minus simulated, rms", "channel", "unit", "before", "after", text_columns=2)
    for name, before in found.error.before.items():
        errors.add_row(TITLES[name], UNITS[name], number(before), number(found.error.after[name]))
    console.print(errors)
    if found.far:
        times = ", ".join(f"{shown(row_of(name))} is {number(value, 2)} times" for name, value in found.far.items())
        say(
            console,
            f"Far from the file: {times} what it said. A wrong screw.lead_mm, gearbox.ratio or motor constant, or a record of another machine, shows itself so: "
            "check them before you use the result.",
        )
    noise = found.error.noise
    left = {
        name: error / noise[name] for name, error in found.error.after.items() if noise[name] > 0.0 and error > _MANY_TIMES * noise[name]
    }
    if left:
        times = ", ".join(f"{TITLES[name]} {number(value, 2)}" for name, value in left.items())
        say(
            console,
            f"What is left is many times the sensors' noise ({times} times): the values also make up for what the model lacks, or for a fault. "
            "Calibrate on healthy records; ema diagnose says what is missing.",
        )
    if found.own_machine is not None:
        own_machine(console, found.own_machine)


def _force_calibration(console: Console, found: ForceCalibration) -> None:
    """The errors of a calibration by the balance of forces."""
    rows = table("Force error, in % of the drive's force", "model", "all rows", f"{PARTS[found.by]} held out in turn", text_columns=1)
    rows.add_row("as given", number(found.compared.before, 3), "")
    told = [one for one in found.each_held_out_percent if one is not None]
    held = f"{number(min(told), 3)} .. {number(max(told), 3)}" if told else ""
    rows.add_row("calibrated", number(found.compared.after, 3), held)
    if found.floor_percent is not None:
        rows.add_row("floor: lap to lap", number(found.floor_percent, 3), "")
    console.print(rows)
    if found.held:
        say(console, f"Effects of the model that stayed as they were: {', '.join(found.held)}.")


def own_machine(console: Console, own: OwnMachineEntry) -> None:
    """What the unit's runs of one command show beside base values."""
    if own.doubt:
        say(console, f"Doubtful: {own.doubt}.")
    if own.standing:
        effects = ", ".join(f"{name} (a model step takes {number(cost, 2)} times as long)" for name, cost in own.standing.items())
        say(console, f"What this unit always has, by its {own.records} runs of one command: {effects}.")
    scatter = ", ".join(
        f"{FAULTS[name.partition('.')[2]]} by {number(value, 2)} %, so that a fault is {number(own.least_percent[name], 2)} % and more"
        for name, value in own.scatter_percent.items()
    )
    few = f"; uncertain with {own.records} runs: give {SURE_RECORDS} or more" if own.records < SURE_RECORDS else ""
    say(console, f"Its runs differ: {scatter}{few}.")
    if own.csj_per_degC_percent is not None:
        say(
            console,
            f"A degree warmer makes {number(own.csj_per_degC_percent, 2)} % of CSJ (standard error {number(own.csj_per_degC_std_percent, 2)} %), by winding and grease of these runs: "
            "the onboard module states CSJ as at their temperature. Healthy runs on colder and warmer days make that surer.",
        )
    for name, share in own.exceeded.items():
        say(
            console,
            f"{FAULTS[name.partition('.')[2]]}: a healthy unit exceeds that in {rate_text(share)} of ground tests; "
            f"from {number(own.found_percent[name], 2)} % on the onboard module calls 95 % of the shifts a fault.",
        )
    _unseen(console, own)


def _unseen(console: Console, own: OwnMachineEntry) -> None:
    """That the rod position under this command does not tell wear from what a machine may be today."""
    if own.unseen_percent:
        off = ", ".join(f"{FAULTS[name.partition('.')[2]]} by up to {number(value, 2)} %" for name, value in own.unseen_percent.items())
        say(
            console,
            f"Under this command the rod position alone does not tell wear from what drive and controller may be today (it moves {off}): "
            "the onboard module then stays undecided. Record the healthy runs under a faster command: ema next --detect shows which.",
        )


def _model_words(found: IdentificationResult) -> str:
    """How well the model follows: the rod by the module's own test, and all signals by the weighted error."""
    if not found.adequate:
        return "not adequate"
    return "adequate" if found.error is None or found.error.explained else "adequate for the rod, not for all signals"


def identification(console: Console, found: IdentificationResult) -> None:
    """What `ema identify` found: the verdict, why it is undecided, and the numbers behind."""
    verdict, because, _ = found.sentence.partition(BECAUSE)
    say(console, f"{verdict}." if because else verdict)
    for reason in found.reasons:
        say(console, f"  because {reason}")
    console.print()
    rows = table("", "fault", "unit", "healthy", "estimate", "95 % interval", "shift", text_columns=2)
    for name, estimate in found.estimates.items():
        title = FAULTS[name] + (" (at its bound)" if estimate.at_bound else "")
        low, high = estimate.interval95
        half = 50.0 * (high - low) / abs(estimate.healthy) if low is not None and high is not None and estimate.healthy else 0.0
        rows.add_row(
            title,
            name.partition("_")[2],
            number(estimate.healthy, 5),
            number(estimate.estimate, 5),
            ends_text(low, high),
            shift_text(estimate.shift_percent, half),
        )
    console.print(rows)
    for sentence in found.undetermined.values():
        say(console, sentence)
    say(
        console,
        f"verdict {found.verdict}; model {_model_words(found)}: residual {number(found.residual_rms_mm, 3)} mm rms"
        + ("" if found.error is None else f", weighted error {number(found.error.after)}, noise level {number(found.error.floor)}"),
    )
    say(
        console,
        f"{found.evaluations} model runs in {found.wall_s or 0.0:.2f} s, error {number(found.objective_before_mm2s, 3)} before and "
        f"{number(found.objective_after_mm2s, 3)} after, {found.precision} bit, seed {found.seed}, ended by {found.outcome}",
    )
    if found.baseline is not None:
        text = ", ".join(
            f"{FAULTS[name.partition('.')[2]]} {number(value, 5)} (95 %: {ends_text(*found.baseline.interval95[name])})"
            for name, value in found.baseline.values.items()
        )
        say(console, f"healthy values from {found.baseline.records} healthy record{'s' if found.baseline.records > 1 else ''}: {text}")
    for name, estimate in found.estimates.items() if found.seeds else ():
        others = (other.csj_Nm if name == "csj_Nm" else other.blk_mm for other in found.seeds)
        values = [estimate.estimate, *(value for value in others if value is not None)]
        spread = 100.0 * (max(values) - min(values)) / abs(estimate.healthy or 1.0)
        say(
            console,
            f"{FAULTS[name]} over {len(values)} seeds: {significant(spread, 2)} % of the healthy value between the largest and the smallest",
        )
    if found.table is not None:
        say(console, table_sentence(found.table))
    if found.values and found.values_search is not None:
        _several(console, found.values, found.values_search)


def _several(console: Console, found: Mapping[str, ValueEntry], search: ValuesSearchEntry) -> None:
    """Several values that were searched at once."""
    console.print()
    say(console, values_sentence(found, search))
    rows = table("", "value", "unit", "before", "estimate", "95 % interval", "determined", text_columns=2)
    rows.columns[-1].justify = "left"
    for name, one in found.items():
        rows.add_row(
            f"{name} and {one.companion}" if one.companion else name,
            row_of(name).unit,
            number(one.before, 5),
            number(one.estimate, 5),
            ends_text(*one.interval95) if one.interval95 is not None else "-",
            determined_words(one),
        )
    console.print(rows)


# The verdict is of the effects: values that have changed stand behind it.
_VERDICTS = {
    "adequate": "Verdict: adequate: no effect is missing.",
    "missing": "Verdict: missing.",
    "unknown": "Verdict: unknown: no effect of the library is named.",
}


def diagnosed(console: Console, found: DiagnosisResult | DiagnosisByBalanceResult, searched: Searched | None) -> None:
    """What `ema diagnose` found by its method; `searched` is there for the one by simulation."""
    if isinstance(found, DiagnosisByBalanceResult):
        balance(console, found)
    elif searched is not None:
        diagnosis(console, found, searched)


def diagnosis(console: Console, found: DiagnosisResult, searched: Searched) -> None:
    """What `ema diagnose` found, in the order in which a user asks; `searched` ranks effects and faults together."""
    say(console, _first_line(found))
    say(console, found.sentence)
    console.print()
    say(console, f"By simulation: {found.method_reason}.")
    say(console, found.gate.sentence)
    say(console, found.where.sentence)
    if found.cannot_see:
        say(console, found.cannot_see)
    console.print()
    _candidates(console, searched)
    console.print()
    steps(console, found.steps, found.error.floor, accepted=found.verdict != "unknown")
    if found.unknown is not None:
        say(console, found.unknown.sentence)
        if found.unknown.learned is not None:
            say(console, f"It can be flown without a name: {found.unknown.learned.sentence}.")
    if not say_next(console, found):
        say(console, found.next_experiment)


def _candidates(console: Console, found: Searched) -> None:
    """What was accepted, and what would take off enough to be worth a look."""
    telling = [one for one in found.named[:_PLACES] if one.accepted or one.score > _WORTH_SHOWING * one.limit]
    if not telling:
        say(console, f"No effect of the library would take off a tenth of what it must, {number(found.limit, 3)} for most.")
        return
    # a column that would be empty takes its width from the others
    alike = ("looks like",) if any(one.alike[1:] for one in telling) else ()
    rows = table("What would lower the error", "effect", *alike, "size", "takes off", "limit", "", text_columns=2 + len(alike))
    for one in telling:
        size = next(iter(one.values), None)
        shown_size = size_text(size, one.values[size], one.std.get(size)) if size is not None else ""
        others = (", ".join(one.alike[1:]),) if alike else ()
        rows.add_row(one.name, *others, shown_size, number(one.score, 4), number(one.limit, 3), "accepted" if one.accepted else "")
    console.print(rows)


def _changed(called: str, percent: float | None) -> str:
    """What has changed, for the first line."""
    share = "" if percent is None else f" by {'+' if percent > 0.0 else ''}{significant(percent, 2)} %"
    return f"the {called} has changed{share}"


def _first_line(found: DiagnosisResult | DiagnosisByBalanceResult) -> str:
    """The verdict, with what has changed of the machine."""
    if isinstance(found, DiagnosisByBalanceResult):
        changed = [_changed(one.called or value_called(name), one.change_percent) for name, one in found.changes.items() if one.counts]
        if found.untellable:
            return "Verdict: unknown: chance or something missing, these records do not tell."
    else:
        changed = [_changed(within(name), one.shift_percent) for name, one in found.faults.items() if one.accepted]
    if found.verdict == "adequate" and changed and isinstance(found, DiagnosisResult) and found.error.leaves_much:
        return f"Verdict: adequate as far as the library goes, but {listed(changed)}, and more is left than noise."
    if found.verdict == "adequate" and changed:
        return f"Verdict: adequate: no effect is missing, but {listed(changed)}."
    return _VERDICTS[found.verdict]


def balance(console: Console, found: DiagnosisByBalanceResult) -> None:
    """What `ema diagnose` found by the balance of forces."""
    say(console, _first_line(found))
    say(console, found.sentence)
    console.print()
    say(console, f"By the balance of forces: {found.method_reason}.")
    say(console, found.gate.sentence)
    say(console, found.where.sentence)
    console.print()
    forces = found.forces
    parts = PARTS[forces.laps.by]
    rows = table(
        "Force error, in % of the drive's force",
        "step",
        "looks like",
        "size in the last fit",
        f"{parts} fitted",
        f"{parts} held out",
        text_columns=3,
    )
    for title, first in (("as given", forces.error.given), ("base values refitted", forces.error.refitted)):
        rows.add_row(title, "", "", number(first.training_percent, 3), number(first.holdout_percent, 3))
    for step in forces.steps:
        rows.add_row(
            f"+ {step.added}",
            ", ".join(step.alike[1:]),
            _size_of(step, forces.steps[-1], MachineUnits(m_per_rad=found.rod_m_per_rad)),
            number(step.training_percent, 3),
            number(step.holdout_percent, 3),
        )
    if found.healthy is not None:
        rows.add_row("left of the healthy records", "", "", number(found.healthy.error_percent, 3), "")
    if found.floor_from != "healthy records":
        rows.add_row(_FLOORS[found.floor_from], "", "", number(found.error.floor, 3), "")
    console.print(rows)
    say(console, held_out_sentence(", ".join(found.holdout) or f"the last of {forces.laps.parts} {GROUPS[forces.laps.by]}"))
    say(console, "As given counts every row, those at rest too, as ema compare does; every other line those that slide.")
    _base(console, found)
    if found.unexplained is not None and found.verdict != "adequate":
        estimated = ", by that estimate" if found.floor_from in ("estimate", "noise") else ""
        say(
            console,
            f"Of what the refitted base values leave above the floor, {significant(100.0 * found.unexplained, 2)} % stays unexplained{estimated}.",
        )
    if found.drive_lag_s:
        say(console, lag_sentence(found.drive_lag_s))
    units = MachineUnits(m_per_rad=found.rod_m_per_rad)
    _forward(console, found.forward, units)
    if found.standing:
        say(console, f"What the healthy machine has anyhow: {', '.join(found.standing)}.")
    if found.changes:
        _changes(console, found)
    if found.friction is not None:
        say(console, friction_sentence(found.friction, units))
    refused = table("Refused", "effect", "why", text_columns=2)
    refused.columns[-1].no_wrap = False
    reasons: dict[str, list[str]] = {}
    for one in forces.refused:
        reasons.setdefault(one.reason, []).append(one.effect)
    # what says something of these records first, what never shows in any last
    for reason, effects in sorted(reasons.items(), key=lambda one: len(one[1])):
        refused.add_row("\n".join(effects), reason)
    console.print()
    console.print(refused)
    if not say_next(console, found):
        say(console, found.next_experiment)


def _base(console: Console, found: DiagnosisByBalanceResult) -> None:
    """Base values as fitted beside what the file states."""
    if not found.base:
        return
    console.print()
    units = MachineUnits(m_per_rad=found.rod_m_per_rad)
    title = "Base values of the healthy machine" if found.healthy is not None else "Base values beside what was found"
    rows = table(title, "value", "unit", "stated", "fitted", "95 % interval", "of the stated", text_columns=0)
    for column in rows.columns[:2]:
        column.justify = "left"
    for name, one in found.base.items():
        (given, unit), (value, _) = units.told(one.stated, one.unit), units.told(one.value, one.unit)
        low, high = (None if end is None else units.told(end, one.unit)[0] for end in one.interval95)
        stated = number(given, 4) if one.stated_from == "file" else "not stated"
        known = one.std is not None or one.at_bound
        fitted = number(value, 4) + (" (at its bound)" if one.at_bound else "") if known else "-"
        times = "" if one.times is None else f"{one.times:.3g} times"
        rows.add_row(units.title(name), unit, stated, fitted, ends_text(low, high), times)
    console.print(rows)
    for name, one in found.base.items():
        if text := note(name, one, units):
            say(console, text)
    console.print()


def _changes(console: Console, found: DiagnosisByBalanceResult) -> None:
    """Values of the healthy machine beside those of today."""
    console.print()
    rows = table("Values of the healthy machine", "value", "unit", "healthy", "today", "change, 95 %", "must exceed", "", text_columns=2)
    units = MachineUnits(m_per_rad=found.rod_m_per_rad)
    for name, one in found.changes.items():
        state = "changed" if one.counts else ""
        healthy, today, low, high, limit = (
            None if value is None else units.told(value, one.unit)[0] for value in (one.healthy, one.today, *one.interval95, one.limit)
        )
        unit = units.told(0.0, one.unit)[1]
        rows.add_row(units.title(name), unit, number(healthy, 4), number(today, 4), ends_text(low, high), number(limit, 2), state)
    console.print(rows)
    console.print()


def _forward(console: Console, found: ForwardErrors | None, units: MachineUnits = TURNING) -> None:
    """The forward solution beside the balance, where there is one."""
    sentence = forward_sentence(found, units) if found is not None else ""
    if sentence:
        say(console, sentence)


def _size_of(step: ForceStepEntry, last: ForceStepEntry, units: MachineUnits) -> str:
    """The size of a step's effect as the last fit has it, with its 95 % interval; of friction along the stroke between which ends it lies."""
    effect = effect_called(step.added)
    values = {name.partition(".")[2]: one.value for name, one in last.parameters.items() if name.startswith(f"{effect}.")}
    if record_of(effect).along is not None and values:
        return along_text(values, units)
    own = [name for name in last.parameters if name.startswith(f"{effect}.")] or [record_of(effect).base_value]
    if own[0] in last.parameters:
        size = last.parameters[own[0]]
        field = row_of(own[0]).field if units.m_per_rad is None else row_of(own[0]).field.partition("_")[0].replace("torque", "force")
        return f"{field} {size_text(own[0], size.value, size.std, units)}"
    return ""


def steps(console: Console, way: Sequence[StepEntry], floor: float | None, what: str = "Weighted error", accepted: bool = True) -> None:
    """The error after each step; `accepted`: whether the effects of the steps are."""
    held = any(step.told[1] is not None for step in way)
    rows = table(what, "model", "on the record", *(("held out",) if held else ()))
    for place, step in enumerate(way):
        title = step.added if place == 0 else f"+ {step.added}{'' if accepted or not step.effects else NOT_ACCEPTED}"
        here, apart = step.told
        rows.add_row(title, number(here, 4), *((number(apart, 4),) if held else ()))
    rows.add_row("floor", number(floor, 4), *(("",) if held else ()))
    console.print(rows)


def added(console: Console, found: Addition) -> None:
    """What `ema add` did."""
    say(console, found.sentence)
    console.print()
    if found.method == "balance":
        say(console, f"By the balance of forces: {found.method_reason}.")
        console.print()
    rows = table("Fitted", "value", "unit", "after", "95 % interval", "", text_columns=2)
    for name, value in found.parameters.items():
        bound = "at its bound" if value.at_bound else ""
        rows.add_row(shown(row_of(name)), value.unit, number(value.value, 5), ends_text(*(value.interval95 or (None, None))), bound)
    console.print(rows)
    console.print()
    steps(
        console,
        found.steps or (),
        found.error.floor,
        "Force error, in % of the drive's force" if found.method == "balance" else "Weighted error",
    )
    if found.method == "balance":
        say(console, held_out_sentence(", ".join(found.holdout or ()) or "the last part of the records"))
    if found.drive_lag_s:
        say(console, lag_sentence(found.drive_lag_s))
    _forward(console, found.forward)
    for name, why in (found.kept or {}).items():
        say(console, f"{name}: {why}.")
    if found.held:
        say(console, f"Effects of the model that stayed as they were: {', '.join(found.held)}.")
    for pair in found.correlations or ():
        first, second = pair.values
        say(console, f"{first} and {second} cannot be told apart on this record (correlation {pair.correlation:.3f}).")
    if found.name is not None:
        say_next(console, found)


def force_models(console: Console, title: str, models: Mapping[str, RodModel]) -> None:
    """Force models at a carriage, side by side."""
    rows = table(title, "", "M kg", "Fv N s/m", "Fc N", "offset N")
    for name, model in models.items():
        rows.add_row(name, *(f"{value:.4f}" if value is not None else "-" for value in astuple(model)))
    console.print(rows)
