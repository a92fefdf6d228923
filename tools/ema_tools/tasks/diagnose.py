"""What `ema diagnose` answers, in the order in which a user asks: can this record answer, where does the model fail, what is missing, does the error fall, what is left, what next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import beside
from ema_tools.base.progress import Report, untold
from ema_tools.compare import unexplained as unknowns
from ema_tools.compare.localisation import Where, where
from ema_tools.compare.validity import RecordRemark, RecordValidity, judge
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import same_samples
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, settled
from ema_tools.fit.nuisance import FROM_DATA_SHEET, TEMPERATURE, moved
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.select.baseline import gather, same_command
from ema_tools.select.healthy_groups import state_doubt
from ema_tools.select.healthy_records import check_against_all, check_apart, check_size
from ema_tools.select.holdout import ErrorFall, Rung, fitted_machine, refuted, shows_nothing, walk
from ema_tools.select.outcome import Diagnosis, Named
from ema_tools.select.search import diagnose
from ema_tools.select.sensors import Suspect, likelier_sensor, odd_signal, suspect, without_voltage
from ema_tools.select.strategies.strategy import LEAST_LIMIT
from ema_tools.select.terminals import drop_V
from ema_tools.select.whole_search import diagnosed
from ema_tools.tasks.learned_tables import helpful_tables, today_worn

_FAR_DAY = 2.0  # standard deviations of the temperature between baseline records: farther, and it is said [chance]
_FAR_FROM_SHEET = 2.0  # of the spread of units: farther, and it is said [chance]


@dataclass(frozen=True)
class Answer:
    """Everything that was found. `actuator`: the machine as known, with the effects of `diagnosis` when they are recommended; `learned`: a table for what the library
    does not hold; `refuted`: effects that fit the record but not the one held out;
    `sensor`: the one that what is unknown looks like; `doubt`: why two healthy records may not both be, in words."""

    record: Record
    gate: RecordValidity
    where: Where
    evidence: Evidence
    diagnosis: Diagnosis
    errors: ErrorFall
    steps: tuple[Rung, ...]
    known: Actuator
    actuator: Actuator
    left: tuple[unknowns.Unknown, ...]
    learned: unknowns.LearnedTable | None
    refuted: tuple[str, ...] = ()
    sensor: Suspect | None = None
    doubt: str = ""

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

    @property
    def rivals(self) -> tuple[tuple[str, ...], ...]:
        """Each accepted effect that has rivals, followed by them: effects or faults that explain the record as well."""
        found = [(one.name, *one.alike[1:]) for one in self.effects]
        return tuple(names for names in found if len(names) > 1)

    @property
    def unit_shift(self) -> dict[str, float]:
        """Without repeats, how far CSJ and BLK lie from the data sheet, relative, by name: those that lie farther than units do. Wear, or a unit that was always so."""
        if self.evidence.relative:
            return {}
        sheet = self.evidence.actuator
        shifts = {name: self.known[name] / sheet[name] - 1.0 for name in FAULTS.values() if sheet[name] > 0.0}
        return {name: shift for name, shift in shifts.items() if abs(shift) > _FAR_FROM_SHEET * FROM_DATA_SHEET[(name,)]}

    @property
    def contradicted_by_healthy(self) -> bool:
        """Whether the record held out refutes what was found since nothing is missing on it at all."""
        return bool(self.refuted) and not self.effects and shows_nothing(self.steps, self.errors)

    @property
    def recommended(self) -> bool:
        """Whether `actuator` is better than the one that was given."""
        return self.verdict == "missing"

    @property
    def machine(self) -> Actuator:
        """What `--fitted` writes: `actuator` with CSJ and BLK of the healthy machine, as its repeats show them or, without repeats, as they were given."""
        return self.actuator.keeping(self.evidence.actuator, FAULTS.values())

    @property
    def fits(self) -> bool:
        """Whether anything was fitted to the record."""
        return self.diagnosis.fit is not None

    @property
    def fitted(self) -> Actuator:
        """The machine with everything that was fitted to the record, recommended or not."""
        return self.known.changed(self.diagnosis.fit.values if self.diagnosis.fit is not None else {})

    @property
    def on_its_day(self) -> Actuator:
        """The same with what scatters from run to run, grease and winding among it, as the record shows it: what the error after everything was fitted is counted with."""
        fit = self.diagnosis.fit
        deviations = fit.deviations() if fit is not None else settled(self.evidence, {}).deviations
        day = moved(self.evidence.actuator, self.evidence.spread, deviations)
        return self.known.changed({**day, **(fit.values if fit is not None else {})})


def healthy_of(record: Record, healthy: Sequence[Record]) -> list[Record]:
    """Those of the healthy records that run the record's command."""
    return [other for other in healthy if same_command(record, other)]


def check_records(record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None) -> None:
    """Raises InputError, naming the file, for records that confirm themselves, for a run that is given twice, for healthy records of a command that nothing else has, and for repeats
    whose signals do not fit the record's."""
    if holdout is not None and same_samples(record, holdout):
        raise InputError(
            f"{holdout.file}: held out is the record itself, which confirms anything: give --holdout another run, best of another command"
        )
    check_apart(record, healthy)
    check_against_all(record, healthy_of(record, healthy))
    for other in healthy:
        if holdout is not None and same_samples(other, holdout):
            raise InputError(
                f"{holdout.file}: held out is one of the healthy records, which shows no effect: give --holdout another run of the machine as it is in {record.file}"
            )
        if same_command(record, other):
            check_size(record, other)
        elif holdout is None or not same_command(holdout, other):
            rows = "" if other.rows == record.rows else f" ({other.rows} rows, {record.file} has {record.rows})"
            raise InputError(
                f"{other.file}: command_mm: neither the command of {record.file} nor that of a record held out{rows}: give healthy records of the same command"
            )


def answerable(actuator: Actuator, record: Record, healthy: Sequence[Record]) -> RecordValidity:
    """Whether the record can answer. Raises InputError with its first remark that blocks."""
    gate = judge(actuator, record, healthy)
    if not gate.answerable:
        remark = next(one for one in gate.remarks if one.severity == "blocks")
        raise InputError(remark.of(record.file, *(one.file for one in healthy)))
    return gate


def _without_voltage(record: Record) -> Record:
    return replace(record, voltage_V=None)


def _terminals(lost_V: float) -> RecordRemark:
    return RecordRemark(
        "voltage",
        "weakens",
        f"the recorded voltage is {lost_V:.2g} V less than the controller asks for, with the sign of the current: it is that at the motor's terminals, and is left out",
        "record what the controller asks for as voltage_V",
    )


def _of_the_day(evidence: Evidence, found: Diagnosis) -> tuple[RecordRemark, ...]:
    """What is said of a day that is much warmer or colder than those of the baseline records."""
    place = next((place for place, one in enumerate(evidence.spread) if one.cause == TEMPERATURE), None)
    if place is None:
        return ()
    deviations = found.fit.deviations() if found.fit is not None else settled(evidence, {}).best_deviations()
    times = float(deviations[place])
    if abs(times) < _FAR_DAY:
        return ()
    degC = times * evidence.spread[place].std
    how = f"about {abs(degC):.0f} degC {'warmer' if degC > 0.0 else 'colder'}"
    text = f"winding, grease and magnets together are as on a day {how} than the baseline records, and are taken for that: a change of all three by as much would not be told from it"
    return (RecordRemark("temperature", "weakens", text, "record healthy runs at today's temperature"),)


def _of_the_supply(evidence: Evidence) -> tuple[RecordRemark, ...]:
    """What is said where the recorded voltage was asked of another supply than the machine had."""
    if not evidence.supplied:
        return ()
    how = f"{100.0 * abs(evidence.supplied):.1f} % {'more' if evidence.supplied > 0.0 else 'less'}"
    text = f"the recorded voltage is asked of a supply that gives {how} than on the days of the baseline records, and is taken for what was given"
    return (RecordRemark("asked voltage", "weakens", text, "measure the supply, and record it"),)


_AS_ASKED = RecordRemark(
    "asked voltage",
    "weakens",
    "the recorded voltage contradicts what the other signals agree on, and is left out: it may be measured at the motor, or asked of a supply that gives less",
    "call its column terminal_voltage_V where it is measured at the motor, else take it out",
)


def _without_contradiction(evidence: Evidence) -> tuple[Evidence, Diagnosis] | None:
    """What the other signals say where the recorded voltage keeps all of them from saying anything; None where that is no more."""
    others = without_voltage(evidence)
    if others is None:
        return None
    found = diagnose(others)
    return (others, found) if found.verdict == "missing" and found.fit is not None and len(found.fit.effects) == 1 else None


def answer(
    actuator: Actuator, record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None, report: Report | None = None
) -> Answer:
    """Diagnoses a record. `healthy` records of the record's command are its repeats, those of the hold-out's command are the hold-out's.

    Raises InputError for a record that cannot answer, for healthy records that belong to neither, and for some of two states.
    """
    tell = report or untold
    same = healthy_of(record, healthy)
    check_records(record, healthy, holdout)
    gate = answerable(actuator, record, same)
    lost_V = drop_V(actuator, same) if same else 0.0
    if lost_V:
        # the other signals say what it would, and it would say what the model does not mean
        record, same = _without_voltage(record), [_without_voltage(one) for one in same]
        holdout, healthy = (_without_voltage(holdout) if holdout is not None else None), [_without_voltage(one) for one in healthy]
        gate = replace(gate, remarks=(_terminals(lost_V), *gate.remarks))
    tell(0.02, "the healthy machine")
    evidence = gather(actuator, record, same, report=lambda share, text: tell(0.02 + 0.23 * share, f"healthy machine, {text}"))
    healthy_machine = fitted_machine(evidence, None)
    with (
        beside(lambda: state_doubt(evidence, same)) as doubted,
        beside(lambda: where(healthy_machine, record, same, evidence.whiten, evidence.channels)) as located,
    ):
        evidence, found = diagnosed(evidence, lambda share, text: tell(0.25 + 0.6 * share, text))
    remarks = (*_of_the_day(evidence, found), *_of_the_supply(evidence))
    record, gate = evidence.record, replace(gate, remarks=(*remarks, *gate.remarks))
    doubt = doubted.result()
    if doubt:
        gate = replace(
            gate, remarks=(RecordRemark("repeats", "weakens", doubt, "record a third run of the healthy machine"), *gate.remarks)
        )
        # what changed and what repeats no better cannot be told apart
        found = found.refuted([one.name for one in found.named])
    sensor = suspect(evidence) if found.verdict == "unknown" else None
    if found.verdict == "unknown" and sensor is None:
        tell(0.85, "what one signal alone says")
        sensor = odd_signal(evidence)
        as_asked = _without_contradiction(evidence) if sensor is None else None
        if as_asked is not None:
            evidence, found = as_asked
            gate = replace(gate, remarks=(_AS_ASKED, *gate.remarks))
    if found.verdict == "missing":
        # an effect that a sensor's error stands in for as well is the likelier: it is the one of the library
        sensor = likelier_sensor(evidence, found.cost_after - max(LEAST_LIMIT, found.doubt))
        found = found.refuted([one.name for one in found.named]) if sensor is not None else found
    tell(0.86, "where the model fails")
    places = located.result()
    best = found.fit
    known = fitted_machine(evidence, best)
    tell(0.9, "the record held out")
    errors, steps = walk(found, evidence, holdout, healthy_of(holdout, healthy) if holdout is not None else ())
    wrong = refuted(steps) if found.verdict == "missing" else ()
    found = found.refuted(wrong) if wrong else found
    put_in: Mapping[str, float] = best.values if best is not None and found.verdict == "missing" else {}
    improved = known.changed({name: value for name, value in put_in.items() if effect_of(name) not in wrong})
    left: tuple[unknowns.Unknown, ...] = ()
    table = None
    if found.verdict == "unknown" and not (wrong and shows_nothing(steps, errors)):
        tell(0.95, "what is unknown")
        # attempts that are not accepted would be seen in what they leave: a voltage that is not missing, say
        worn = today_worn(settled(evidence, {}))
        left = unknowns.left_over(known.changed(worn.values), record, places)
        # a sensor's error is not flown
        table = next(helpful_tables(worn, record, places), None) if sensor is None else None
    tell(1.0, "done")
    return Answer(record, gate, places, evidence, found, errors, steps, known, improved, left, table, wrong, sensor, doubt)
