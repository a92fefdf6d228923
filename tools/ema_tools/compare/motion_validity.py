"""Can a record of a machine whose controller is not known answer: its motion, its drive, and whether they go together."""

from __future__ import annotations

import numpy as np

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import mechanical_model
from ema_tools.base.errors import MissingSignal
from ema_tools.compare.validity import RecordRemark, RecordValidity
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import DRIVES, MOTIONS, VOLTAGES, MotionRecord, motion_signal

_MOVING = 1e-9  # of its largest value: a motion that spans less does not change at all [precision]
_A_TENTH = 0.1  # of the time, and of the largest speed, that a record moves to either side before its signs are doubted [judgement]
_AGAINST = (
    -0.5
)  # correlation of the drive with the way it moves: friction alone makes it positive, a load of its own size makes it none [judgement]


def judge_motion(actuator: Actuator, record: MotionRecord) -> RecordValidity:
    """Judges a record by itself; nothing is simulated."""
    present = {name: record.channel(name) is not None for name in (*MOTIONS, *DRIVES, *VOLTAGES)}
    least = Smoother.of(record.period_s).least_rows
    if record.rows < least:
        text = f"{record.file} has {record.rows} rows, too few for any filter"
        return RecordValidity(present, (RecordRemark("coverage", "blocks", text, f"record {least} rows or more"),), {})
    remarks = []
    motion = motion_signal(record)
    if not np.max(np.abs(motion)) > 0.0 or (np.ptp(motion) <= _MOVING * float(np.max(np.abs(motion))) and "speed" not in _name(record)):
        remarks.append(RecordRemark("coverage", "blocks", f"{_name(record)} does not change", "record while the machine moves"))
        return RecordValidity(present, tuple(remarks), {})
    try:
        model = mechanical_model(actuator, record)
    except MissingSignal as error:
        remarks.append(RecordRemark("signals", "blocks", str(error), "record it, or state it in the actuator"))
        return RecordValidity(present, tuple(remarks), {})
    drive, speed = model.smoother.inner(model.drive_Nm), model.smoother.inner(model.columns[:, 1])
    if not np.any(drive):
        remarks.append(
            RecordRemark("signals", "blocks", "the drive is zero throughout", "look which column holds the torque, force or current")
        )
    low, high = np.quantile(speed, (_A_TENTH, 1.0 - _A_TENTH))
    if low < 0.0 < high and min(-low, high) > _A_TENTH * float(np.max(np.abs(speed))) and np.ptp(drive) > 0.0:
        alike = float(np.corrcoef(drive, speed)[0, 1])
        if alike < _AGAINST:
            text = f"the drive goes against the motion (correlation {alike:.2f})"
            remarks.append(
                RecordRemark("signs", "weakens", text, "look whether the sign of the drive or of the motion is turned in the map")
            )
    fastest = float(np.max(np.abs(speed)))
    return RecordValidity(present, tuple(remarks), {"speed_max_rad_s": fastest, "moving_share": float(np.mean(~model.resting))})


def _name(record: MotionRecord) -> str:
    return next(name for name in MOTIONS if name in record.present)
