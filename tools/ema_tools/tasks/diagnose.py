"""What `ema diagnose` answers, in the order in which a user asks: can this record answer, where does the model fail, what is missing, does the error fall, what is left, what next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report
from ema_tools.compare import unexplained as unknowns
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.validity import Gate, judge
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.plant.native import CHANNELS
from ema_tools.select.baseline import gather, same_command
from ema_tools.select.holdout import Errors, Step, fitted_machine, refuted, walk
from ema_tools.select.search import INSEPARABLE, LEAST_LIMIT, Diagnosis, Named, diagnose
from ema_tools.select.sensors import Suspect, suspect
from ema_tools.words.sentences.experiment import HINTS

_LISTED = 12
_INTERVAL = 1.96
# Signals of two runs of one command that differ more than this in size are of different units.
_SIZES = 10.0


@dataclass(frozen=True)
class Answer:
    """Everything that was found. `actuator`: the machine as known, with the effects of `diagnosis` when they are recommended; `learned`: a table for what the library
    does not hold; `refuted`: effects that fit the record but not the one held out;
    `sensor`: the one that what is unknown looks like."""

    record: Record
    gate: Gate
    where: Where
    evidence: Evidence
    diagnosis: Diagnosis
    errors: Errors
    steps: tuple[Step, ...]
    known: Actuator
    actuator: Actuator
    left: tuple[unknowns.Unknown, ...]
    learned: unknowns.Learned | None
    refuted: tuple[str, ...] = ()
    sensor: Suspect | None = None

    @property
    def verdict(self) -> str:
        """adequate, missing or unknown. A change of CSJ or BLK alone is a fault of the machine, not of the model."""
        if self.diagnosis.verdict == "missing" and not self.effects:
            return "adequate"
        return self.diagnosis.verdict

    @property
    def effects(self) -> tuple[Named, ...]:
        """The accepted effects."""
        return tuple(one for one in self.diagnosis.named if one.accepted and one.name not in FAULTS)

    @property
    def faults(self) -> tuple[Named, ...]:
        """Accepted changes of CSJ and BLK."""
        return tuple(one for one in self.diagnosis.named if one.accepted and one.name in FAULTS)

    def sentence(self) -> str:
        """The answer in a sentence or two."""
        if not self.gate.answerable:
            return self.gate.sentence
        first = f"{self.record.file}: "
        fall = f"weighted error {self.errors.before:.3g} before, {self.errors.after:.3g} after, floor {self.errors.floor:.3g}"
        faults = "; ".join(_fault_words(one, self.known) for one in self.faults)
        if self.verdict == "adequate":
            versus = "this machine's repeatability" if self.evidence.relative else "what sensors and a data sheet leave open"
            text = f"nothing exceeds {versus}: no effect is missing" if not faults else f"no effect is missing; {faults}"
            return f"{first}{text} ({fall})."
        if self.verdict == "unknown":
            if self.sensor is not None:
                return f"{first}{self.sensor.sentence} (weighted error {self.errors.before:.3g}, floor {self.errors.floor:.3g})."
            if self.refuted:
                last = self.left[0].sentence if self.left else ""
                told = f"{first}something is there, and {' and '.join(self.refuted)} would explain it, but not the record held out, whose error rises"
                return f"{told}: no effect is recommended ({fall}). {last}".strip()
            left = 100.0 * self.diagnosis.unexplained
            text = f"something is there that the library does not hold: {left:.0f} % of the excess stays unexplained"
            return f"{first}{text}. {self.left[0].sentence if self.left else ''}".strip()
        named = " and ".join(_words(one) for one in self.effects)
        others = [other for one in self.effects for other in one.alike[1:]]
        alike = f", which looks like {', '.join(others)}" if others else ""
        faults = f"; beside it {faults}" if faults else ""
        are = "is" if len(self.refuted) == 1 else "are"
        refuted = (
            f"; {' and '.join(self.refuted)} would lower the error further but raise that of the record held out, and {are} not recommended"
            if self.refuted
            else ""
        )
        return f"{first}missing is {named}{alike}{faults}{refuted} ({fall})."

    @property
    def fitted(self) -> Actuator:
        """The machine with everything that was fitted to the record, recommended or not."""
        return self.known.changed(self.diagnosis.fit.values if self.diagnosis.fit is not None else {})

    def next_step(self) -> str:
        """What to do next."""
        confused = next((one for one in self.diagnosis.named if one.accepted and len(one.alike) > 1), None)
        if self.verdict == "unknown" and self.sensor is not None:
            return f"Next: {self.sensor.next}."
        if self.verdict == "unknown":
            table = f"ema add ACTUATOR {self.learned.effect} --fit REC flies it as a learned table; " if self.learned is not None else ""
            return f"Next: {table}look at the pictures (--report), and write the effect yourself where you know its physics (docs/ADD_AN_EFFECT.md)."
        if confused is not None:
            if any(set(confused.alike) <= kind for kind in INSEPARABLE):
                hint = next(one for one in HINTS if set(confused.alike) <= one.effects)
                return f"Next: no command tells {' and '.join(confused.alike)} apart; what would: {hint.do}: {hint.because}."
            return f"Next: ema next ACTUATOR --between {' '.join(confused.alike)} says which command tells them apart."
        if self.effects and self.effects[0].name in self.known.active_effects:
            return f"Next: {self.effects[0].name} is in the actuator file already, and the healthy records were made without it; ema identify ACTUATOR REC gives CSJ and BLK."
        if self.effects:
            return f"Next: ema add ACTUATOR {self.effects[0].name} --fit REC puts it into the model; then diagnose again."
        return "Next: ema identify gives CSJ and BLK; nothing is to be added."

    def hidden(self) -> str:
        """What this kind of evidence cannot show."""
        if self.evidence.relative:
            return ""
        names = ", ".join(sorted({one.title for one in self.evidence.spread}))
        usual = "the slight ripple, cogging, bend of the friction's law, drop and delay that every machine has"
        return f"Without healthy repeats nothing can be named that a unit's usual distance from its data sheet explains as well ({names}), nor {usual}."

    def result(self) -> dict[str, Any]:
        """For JSON: the keys that programs read, and what the page draws."""
        named = [one for one in self.diagnosis.named if one.name not in FAULTS]
        return {
            "verdict": self.verdict,
            "sentence": self.sentence(),
            "mode": "against healthy repeats" if self.evidence.relative else "without healthy repeats",
            "cannot_see": self.hidden() or None,
            "effects": [_effect_result(one, self.diagnosis) for one in named[:_LISTED]],
            "faults": {one.name: _effect_result(one, self.diagnosis) for one in self.faults},
            "standing": {
                name: {value.field: self.known[value.name] for value in _effect(name).parameters} for name in self.known.active_effects
            }
            if self.evidence.relative
            else {},
            "error": self.errors.result(),
            "next_experiment": self.next_step(),
            "unexplained": self.diagnosis.unexplained,
            "steps": [
                {
                    "effects": list(step.effects),
                    "added": step.added or "as given",
                    "error_training": step.error,
                    "error_holdout": step.holdout,
                }
                for step in self.steps
            ],
            "gate": self.gate.result(),
            "where": self.where.result(),
            "unknown": unknowns.result(self.left, self.learned) if self.left else None,
            "sensor": self.sensor.result() if self.sensor is not None else None,
        }


def _effect(name: str) -> Any:
    from ema_tools.library.definitions import load_definitions

    return load_definitions().effect(name)


def _effect_result(one: Named, diagnosis: Diagnosis) -> dict[str, Any]:
    at_bound = diagnosis.fit.at_bound if diagnosis.fit is not None else ()
    return {
        "name": one.name,
        "class": [name for name in one.alike if name not in FAULTS],
        "looks_like_fault": [name for name in one.alike if name in FAULTS and name != one.name],
        "parameters": {name.split(".")[-1]: value for name, value in one.values.items()},
        "std": {name.split(".")[-1]: value for name, value in one.std.items()},
        "interval95": {
            name.split(".")[-1]: [one.values[name] - _INTERVAL * value, one.values[name] + _INTERVAL * value]
            for name, value in one.std.items()
        },
        "at_bound": [name.split(".")[-1] for name in one.values if name in at_bound],
        "score": one.score,
        "limit": one.limit,
        "accepted": one.accepted,
    }


def size_text(name: str, value: float, std: float | None) -> str:
    """A value with its standard error and unit, as in `0.31 +- 0.02 Nm`."""
    unit = row_of(name).unit
    doubt = f" +- {std:.2g}" if std is not None else ""
    return f"{value:.4g}{doubt}{' ' + unit if unit else ''}"


def _words(one: Named) -> str:
    size = next(iter(one.values))
    return f"{one.name} ({row_of(size).field} {size_text(size, one.values[size], one.std.get(size))})"


def _fault_words(one: Named, known: Actuator) -> str:
    name = FAULTS[one.name]
    value, healthy = one.values[name], known[name]
    return f"{one.name.upper()} changed by {100.0 * (value / healthy - 1.0):+.1f} % to {size_text(name, value, one.std.get(name))}"


def healthy_of(record: Record, healthy: Sequence[Record]) -> list[Record]:
    """Those of the healthy records that run the record's command."""
    return [other for other in healthy if same_command(record, other)]


def check_records(record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None) -> None:
    """Raises InputError, naming the file, for records that confirm themselves, for a run that is given twice, for healthy records of a command that nothing else has, and for repeats
    whose signals do not fit the record's."""
    if holdout is not None and _same_samples(record, holdout):
        raise InputError(
            f"{holdout.file}: held out is the record itself, which confirms anything: give --holdout another run, best of another command"
        )
    check_apart(record, healthy)
    for other in healthy:
        if holdout is not None and _same_samples(other, holdout):
            raise InputError(
                f"{holdout.file}: held out is one of the healthy records, which shows no effect: give --holdout another run of the machine as it is in {record.file}"
            )
        if same_command(record, other):
            _check_signals(record, other)
        elif holdout is None or not same_command(holdout, other):
            rows = "" if other.rows == record.rows else f" ({other.rows} rows, {record.file} has {record.rows})"
            raise InputError(
                f"{other.file}: command_mm: neither the command of {record.file} nor that of a record held out{rows}: give healthy records of the same command"
            )


def check_apart(record: Record, healthy: Sequence[Record]) -> None:
    """Raises InputError when a healthy record is the record itself or is given twice: identical samples tell nothing of how the machine repeats."""
    for place, other in enumerate(healthy):
        if _same_samples(record, other):
            raise InputError(f"{other.file}: healthy is the record itself, against which nothing has changed: leave it out of --healthy")
        for earlier in healthy[:place]:
            if _same_samples(earlier, other):
                raise InputError(
                    f"{other.file}: {'given twice' if other.file == earlier.file else f'holds the same samples as {earlier.file}'}: give every healthy run once"
                )


def _same_samples(one: Record, other: Record) -> bool:
    names = [name for name in one.present if name in other.present]
    return one.rows == other.rows and all(np.array_equal(one.recorded(name), other.recorded(name)) for name in names)


def _check_signals(record: Record, other: Record) -> None:
    """Repeats of one command have signals of one size."""
    for name in (name for name in CHANNELS if record.channel(name) is not None and other.channel(name) is not None):
        size, its = float(np.std(record.recorded(name))), float(np.std(other.recorded(name)))
        if size > 0.0 and not its > 0.0:
            raise InputError(
                f"{other.file}: {name} does not change, while that of {record.file} does: check that the sensor was connected, or leave the file out of --healthy"
            )
        if size > 0.0 and not 1.0 / _SIZES < its / size < _SIZES:
            raise InputError(f"{other.file}: {name} is {its / size:.3g} times that of {record.file}: give both in the same unit")


def answerable(actuator: Actuator, record: Record, healthy: Sequence[Record]) -> Gate:
    """The gate's judgement. Raises InputError with its first remark that blocks."""
    gate = judge(actuator, record, healthy)
    if not gate.answerable:
        remark = next(one for one in gate.remarks if one.severity == "blocks")
        named = any(remark.text.startswith(f"{one.file} ") for one in (record, *healthy))
        raise InputError(f"{remark.text if named else f'{record.file}: {remark.text}'}: {remark.next}")
    return gate


def answer(
    actuator: Actuator, record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None, report: Report | None = None
) -> Answer:
    """Diagnoses a record. `healthy` records of the record's command are its repeats, those of the hold-out's command are the hold-out's.

    Raises InputError for a record that cannot answer, and for healthy records that belong to neither.
    """
    tell = report or (lambda _share, _text: None)
    same = healthy_of(record, healthy)
    check_records(record, healthy, holdout)
    gate = answerable(actuator, record, same)
    tell(0.02, "the healthy machine")
    evidence = gather(actuator, record, same, report=lambda share, text: tell(0.02 + 0.23 * share, f"healthy machine, {text}"))
    found = diagnose(evidence, lambda share, text: tell(0.25 + 0.6 * share, text))
    sensor = suspect(evidence) if found.verdict != "adequate" else None
    if sensor is not None and found.verdict == "missing":
        # an effect that a sensor's error stands in for as well is the likelier: it is the one of the library
        sensor = sensor if sensor.cost < found.cost_after - LEAST_LIMIT else None
        found = found.refuted([one.name for one in found.named]) if sensor is not None else found
    tell(0.86, "where the model fails")
    best = found.fit
    known = fitted_machine(evidence, best)
    places = where(known if evidence.relative else fitted_machine(evidence, None), record, same, evidence.whiten, evidence.channels)
    tell(0.9, "the record held out")
    errors, steps = walk(found, evidence, holdout, healthy_of(holdout, healthy) if holdout is not None else ())
    wrong = refuted(steps) if found.verdict == "missing" else ()
    found = found.refuted(wrong) if wrong else found
    kept: Mapping[str, float] = (
        {name: value for name, value in best.values.items() if effect_of(name) not in wrong} if best is not None else {}
    )
    improved = known.changed(kept if found.verdict == "missing" else {})
    left: tuple[unknowns.Unknown, ...] = ()
    table = None
    if found.verdict == "unknown":
        tell(0.95, "what is unknown")
        left = unknowns.left_over(known.changed(kept), record, places)
        table = unknowns.learned(left[0]) if left else None
    tell(1.0, "done")
    return Answer(record, gate, places, evidence, found, errors, steps, known, improved, left, table, wrong, sensor)
