"""The way in which records are diagnosed: what `ema diagnose` calls, and what its benchmark counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.results.diagnosis import Method
from ema_tools.tasks.diagnose import Answer, answer
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_by_balance, has_balance, has_laps


@dataclass(frozen=True)
class Chosen:
    """A method and why, as the end of a sentence."""

    method: Method
    because: str


def chosen(
    actuator: Actuator,
    records: Sequence[Record],
    healthy: Sequence[Record] = (),
    holdout: Record | None = None,
    asked: Method | None = None,
) -> Chosen:
    """The method that was asked for, or the one that serves the records.

    The balance shows neither winding nor supply nor play, and less than all signals together: it serves where there are several records, and for a drive of current whose current is not
    measured, whose laps say what the machine repeats. Raises InputError where the method that was asked for cannot serve.
    """
    if asked == "simulation" and len(records) > 1:
        raise InputError(
            f"--method simulation: {len(records)} records: give one, with its healthy repeats by --healthy; --method balance takes several"
        )
    if asked == "balance" and healthy:
        raise InputError(
            "--healthy: the balance compares records with the model alone: leave it out, or calibrate the actuator on them first (ema calibrate)"
        )
    if asked is not None:
        return Chosen(asked, "as asked for")
    if len(records) > 1:
        if healthy:
            raise InputError(
                f"{len(records)} records with --healthy: healthy repeats are those of one record: give one, or leave --healthy out"
            )
        return Chosen("balance", "there are several records")
    alone = not healthy and holdout is None
    record = records[0]
    if alone and actuator["drive.mode"] == 1.0 and record.current_A is None and has_laps(record) and has_balance(actuator, record):
        return Chosen(
            "balance", "a drive of current whose current is not recorded shows the mechanics in what it asks for, and the laps repeat"
        )
    return Chosen("simulation", "one record of a machine whose controller is known shows more in all of its signals together")


def diagnosed(
    actuator: Actuator,
    records: Sequence[Record],
    healthy: Sequence[Record] = (),
    holdout: Record | None = None,
    report: Report | None = None,
    way: Chosen | None = None,
) -> Answer | BalanceAnswer:
    """The diagnosis of records by the method that serves them. Raises InputError as the methods do."""
    way = way or chosen(actuator, records, healthy, holdout)
    if way.method == "balance":
        return answer_by_balance(actuator, records, () if holdout is None else (holdout,), report)
    return answer(actuator, records[0], healthy, holdout, report)
