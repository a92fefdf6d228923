"""The baseline records that a machine's file names, with which a later record is compared, and the file that a command writes after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.data.actuator import Actuator
from ema_tools.data.any_record import read_any_record
from ema_tools.data.machine_state import FOUND, BaselineRecords, RecordFinding
from ema_tools.data.motion_records import AnyRecord, same_samples
from ema_tools.data.records import Record, read_record
from ema_tools.fit.nuisance import FROM_DATA_SHEET
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import effect_of
from ema_tools.select.baseline import same_command
from ema_tools.select.known_machine import repeats_of
from ema_tools.tasks.onboard_search import SCATTERS

# Of healthy values that a data sheet alone tells, standard deviation in % [physics]
_OF_SHEET = {SCATTERS[name]: 100.0 * FROM_DATA_SHEET[(name,)] for name in SCATTERS}


def baseline_records_of(actuator: Actuator, record: Record) -> tuple[Record, ...]:
    """The unit's healthy runs of the record's command, but for the record itself; none where fewer than two are left, which cannot tell how the unit repeats.

    What has gone from its place since is passed over: the file holds what was learned from it. Raises InputError for one that cannot be read.
    """
    return repeats_of(record, _there(actuator, record))


def _there(actuator: Actuator, record: Record) -> list[Record]:
    sums = dict(zip(actuator.healthy, actuator.baseline.sha256, strict=False)) if actuator.baseline is not None else {}
    found = [read_record(path, actuator) for path in actuator.healthy if Path(path).is_file()]
    for one in found:
        if sums.get(one.path, one.sha256) != one.sha256:
            raise InputError(
                f"{one.path}: its content is not that of the baseline record that {actuator.file} names: restore it, or give the records with --healthy"
            )
    return [one for one in found if not same_samples(one, record)]


def given_or_own(actuator: Actuator, records: Sequence[AnyRecord], given: Sequence[str]) -> list[AnyRecord]:
    """The baseline records of `records`: the `given` files, else those that the actuator's file names, for one record of a known controller. Raises InputError."""
    if given:
        return [read_any_record(path, actuator) for path in given]
    first = records[0]
    return list(baseline_records_of(actuator, first)) if len(records) == 1 and isinstance(first, Record) else []


def why_not_used(actuator: Actuator, record: Record) -> str:
    """Why the unit's healthy runs do not stand beside a record of another command, and what to do; empty where that is not the reason."""
    there = _there(actuator, record)
    if not there or any(same_command(record, one) for one in there):
        return ""
    return (
        f"{record.file}: it runs another command than the {len(there)} baseline records of {actuator.file}, so they are not used: "
        "run the ground test, or give baseline records of this command with --healthy"
    )


def carried(machine: Actuator, given: Actuator) -> Actuator:
    """`machine`, which a command made of `given`, with the findings of `given` and its baseline, as one to which this model is not fitted."""
    baseline = replace(given.baseline, before=None) if given.baseline is not None else None
    return replace(machine, baseline=baseline, findings=given.findings)


def with_state(
    machine: Actuator,
    given: Actuator,
    records: Sequence[Record],
    healthy: Actuator,
    began: Sequence[str],
    record: Record,
    today: Actuator,
    command: str,
) -> Actuator:
    """The machine that a command writes, with its baseline and one finding more.

    `given`: the actuator that the command read, `records`: the baseline records that `healthy` was fitted to, `began`: the effects that came or grew after them,
    `today`: the machine with the CSJ and BLK of `record`. Without `records` the baseline of `given` stays, and counts as one to which this model is not fitted.
    """
    earlier = given.baseline
    baseline = carried(machine, given).baseline
    if records:
        known = dict(earlier.before or ()) if earlier is not None and earlier.covers(records) else {}
        before = {**_values_of(began, healthy), **known}
        active = machine.active_effects
        baseline = BaselineRecords.of(records, {name: value for name, value in before.items() if effect_of(name) in active})
    finding = RecordFinding(record.path, record.sha256, command, tuple((name, today[name]) for name in FOUND if today.has(name)))
    others = tuple(one for one in given.findings if one.sha256 != finding.sha256)
    if records and known_by_sheet(given):
        machine = machine.changed(dict.fromkeys(SCATTERS.values(), 0.0))
    return replace(machine, baseline=baseline, findings=(*others, finding) if record.sha256 else others)


def by_sheet(machine: Actuator) -> Actuator:
    """The machine with its healthy CSJ and BLK as uncertain as a data sheet leaves them, where no healthy record has told them and the file states nothing."""
    if machine.baseline is not None or any(machine[name] > 0.0 for name in SCATTERS.values()):
        return machine
    remark = "as units differ from their data sheet: no healthy record has told the healthy value [%]"
    return replace(machine.changed(_OF_SHEET, remarks=dict.fromkeys(_OF_SHEET, remark)), findings=machine.findings)


def known_by_sheet(machine: Actuator) -> bool:
    """Whether `by_sheet` made it so."""
    return machine.baseline is None and all(machine[name] == percent for name, percent in _OF_SHEET.items())


def _values_of(effects: Sequence[str], machine: Actuator) -> dict[str, float]:
    """Values of effects in a machine, by full name: all of one that it has, the size alone of one that it lacks."""
    rows = [load_definitions().effect(effect) for effect in effects]
    wanted = [value for row in rows for value in (row.parameters if row.name in machine.active_effects else (row.size,))]
    return {f"effects.{value.name}": machine[value.name] for value in wanted}
