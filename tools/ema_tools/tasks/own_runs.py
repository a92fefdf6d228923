"""The healthy runs that a calibrated unit's file names, beside which a record of today is judged where no others are given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, same_samples
from ema_tools.data.records import Record, read_record
from ema_tools.select.baseline import same_command
from ema_tools.select.known_machine import repeats_of


def own_runs(actuator: Actuator, record: Record) -> tuple[Record, ...]:
    """The unit's healthy runs of the record's command, but for the record itself; none where fewer than two are left, which cannot tell how the unit repeats.

    What has gone from its place since is passed over: the file holds what was learned from it. Raises InputError for one that cannot be read.
    """
    return repeats_of(record, _there(actuator, record))


def _there(actuator: Actuator, record: Record) -> list[Record]:
    found = [read_record(path, actuator) for path in actuator.healthy if Path(path).is_file()]
    return [one for one in found if not same_samples(one, record)]


def own_runs_beside(actuator: Actuator, records: Sequence[AnyRecord]) -> tuple[Record, ...]:
    """The healthy runs beside which `records` are diagnosed where none are given: those of the unit's file for one record of a known controller, else none. Raises InputError as `own_runs`."""
    if len(records) != 1 or not isinstance(records[0], Record):
        return ()
    return own_runs(actuator, records[0])


def why_not_used(actuator: Actuator, record: Record) -> str:
    """Why the unit's healthy runs do not stand beside a record of another command, and what to do; empty where that is not the reason."""
    there = _there(actuator, record)
    if not there or any(same_command(record, one) for one in there):
        return ""
    return (
        f"{record.file}: it runs another command than the {len(there)} healthy runs on which {actuator.file} was calibrated, so they are not used: "
        "run the ground test, or give healthy runs of this command with --healthy"
    )
