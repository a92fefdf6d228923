"""The way in which records are diagnosed: what `ema diagnose` calls, and what its benchmark counts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.any_record import lacks
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.data.records import Record
from ema_tools.results.diagnosis import Method
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.tasks.diagnose import Answer, answer
from ema_tools.tasks.diagnose_by_balance import BalanceAnswer, answer_by_balance, has_balance, has_laps


@dataclass(frozen=True)
class Chosen:
    """A method and why, as the end of a sentence."""

    method: Method
    because: str


def chosen(
    actuator: Actuator,
    records: Sequence[AnyRecord],
    healthy: Sequence[AnyRecord] = (),
    holdout: AnyRecord | None = None,
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
    lacking = next((record for record in (*records, *healthy, *filter(None, (holdout,))) if isinstance(record, MotionRecord)), None)
    if lacking is not None or actuator.absent:
        told = _not_simulated(actuator, lacking)
        if asked == "simulation":
            raise InputError(f"--method simulation: {told}: --method balance does without")
        return Chosen("balance", told if asked is None else "as asked for")
    if asked is not None:
        return Chosen(asked, "as asked for")
    if len(records) > 1:
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
    records: Sequence[AnyRecord],
    healthy: Sequence[AnyRecord] = (),
    holdout: AnyRecord | None = None,
    report: Report | None = None,
    way: Chosen | None = None,
    fixes: Fixes = NONE,
) -> Answer | BalanceAnswer:
    """The diagnosis of records by the method that serves them. Raises InputError as the methods do."""
    way = way or chosen(actuator, records, healthy, holdout)
    if way.method == "balance":
        return answer_by_balance(actuator, records, () if holdout is None else (holdout,), report, fixes, healthy)
    check_fixes(way, fixes)
    measured = [record for record in (records[0], *healthy) if isinstance(record, Record)]
    return answer(actuator, measured[0], measured[1:], holdout if isinstance(holdout, Record) else None, report)


def check_fixes(way: Chosen, fixes: Fixes) -> None:
    """Raises InputError where values are fixed for a method that knows none."""
    if way.method == "simulation" and fixes != NONE:
        raise InputError(
            "--fix: the method by simulation weighs every base value by its spread and fixes none: leave it out, or give --method balance"
        )


def chosen_for_calibration(actuator: Actuator, records: Sequence[AnyRecord], asked: Method | None = None) -> Chosen:
    """The method of a calibration: by simulation where the machine can be simulated. Raises InputError where the one that was asked for cannot serve."""
    if asked == "balance":
        return Chosen(asked, "as asked for")
    lacking = next((record for record in records if isinstance(record, MotionRecord)), None)
    if lacking is None and not actuator.absent:
        return Chosen("simulation", "the controller is known, so that all signals together are fitted" if asked is None else "as asked for")
    told = _not_simulated(actuator, lacking)
    if asked == "simulation":
        raise InputError(f"--method simulation: {told}: --method balance does without")
    return Chosen("balance", told)


def _not_simulated(actuator: Actuator, record: AnyRecord | None) -> str:
    """Why a machine cannot be simulated under a record."""
    if record is not None and lacks(record):
        return f"{record.file} holds no {' and no '.join(lacks(record))}, without which nothing is simulated"
    return f"{actuator.file or actuator.name} does not state the controller, without which nothing is simulated"
