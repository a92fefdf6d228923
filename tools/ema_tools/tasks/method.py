"""The way in which a record is diagnosed: what `ema diagnose` calls, and what its benchmark counts."""

from __future__ import annotations

from collections.abc import Sequence

from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.tasks.diagnose import Answer, answer
from ema_tools.tasks.diagnose_by_laps import LapsAnswer, answer_by_laps, applies


def by_laps(actuator: Actuator, record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None) -> bool:
    """Whether the laps of the record itself are what it is diagnosed by.

    Their mechanical balance shows neither winding nor supply, and less than all signals together: it serves a drive of current whose current is not measured.
    """
    alone = not healthy and holdout is None
    return alone and actuator["drive.mode"] == 1.0 and record.current_A is None and applies(actuator, record)


def diagnosed(
    actuator: Actuator, record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None, report: Report | None = None
) -> Answer | LapsAnswer:
    """The diagnosis of a record by the method that serves it. Raises InputError as the methods do."""
    if by_laps(actuator, record, healthy, holdout):
        return answer_by_laps(actuator, record, report)
    return answer(actuator, record, healthy, holdout, report)
