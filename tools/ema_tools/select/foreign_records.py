"""Whether one of several records is another machine's: the model that explains the others explains little of it."""

from __future__ import annotations

from collections.abc import Sequence

from ema_tools.compare.validity import RecordRemark
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.select.balance_bench import INERTIA, compared_percent
from ema_tools.select.value_changes import CONSTANT, Change

FOREIGN = "records"  # topic of what does not belong together
_LEAVES_PERCENT = 50.0  # of its drive, that the model leaves of a record which is another machine's .. [judgement]
_BEYOND = 5.0  # .. and so many times what it leaves of the one that it explains best [judgement]
_OTHER_CONSTANT = (
    2.0  # times the healthy machine's torque per current, or this share of it: magnets lose less before the motor fails [judgement]
)
_OTHER_INERTIA = 2.0  # times the healthy machine's, or this share of it: no wear does that [judgement]


def foreign_records(fitted: Actuator, records: Sequence[AnyRecord]) -> list[RecordRemark]:
    """What is said of each record of which a model, fitted to some of them, leaves most while it explains others."""
    if len(records) < 2:
        return []
    left = [compared_percent(fitted, (record,)) for record in records]
    least = min(left)
    return [
        RecordRemark(
            FOREIGN,
            "weakens",
            f"the model that leaves {least:.3g} % of another record leaves {one:.3g} % of {record.file}: it may be another machine's, of another load, or in other units",
            "look at its file and its map, and leave it out where it is none of this machine",
        )
        for record, one in zip(records, left, strict=True)
        if one > max(_LEAVES_PERCENT, _BEYOND * least)
    ]


def another_machine(changes: Sequence[Change]) -> list[RecordRemark]:
    """What is said where the inertia, or the torque per current, is another one than the healthy machine's."""
    for name, words, most in ((INERTIA, "inertia", _OTHER_INERTIA), (CONSTANT, "torque per current", _OTHER_CONSTANT)):
        found = next((one for one in changes if one.name == name and one.counts and one.healthy > 0.0), None)
        times = found.today / found.healthy if found is not None else 1.0
        if not 1.0 / most < times < most:
            text = f"the {words} is {times:.3g} times that of the healthy records, which no wear makes of it: as if these were records of another machine, or their drive in another unit"
            return [RecordRemark(FOREIGN, "weakens", text, "look whether all records are of one machine, with the same load, and one map")]
    return []
