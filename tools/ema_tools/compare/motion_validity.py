"""Can a record of a machine whose controller is not known answer: its motion, its drive, and whether they go together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import optimize

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import Mechanical, mechanical_model, quiet_smoother
from ema_tools.balances.motion import Motion, motion_of
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.compare.odd_rows import odd_rows, swings_unseen
from ema_tools.compare.validity import RecordRemark, RecordValidity
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import DRIVES, MOTIONS, VOLTAGES, MotionRecord, motion_signal
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import effect_of

_MOVING = 1e-9  # of its largest value: a motion that spans less does not change at all [precision]
_A_TENTH = 0.1  # of the time, and of the largest speed, that a record moves to either side before its signs are doubted [judgement]
_AGAINST = (
    -0.5
)  # correlation of the drive with the way it moves: friction alone makes it positive, a load of its own size makes it none [judgement]

# A drive of the wrong sign fits inertia and friction of less than none to more than half of itself, and each is a part of it that noise is not [judgement]
_TURNED_LEAVES, _TURNED_PART = 0.5, 0.05
_ONE_WAY = 0.98  # of the time in motion, that all go the same way [judgement]
_LAG_STEP_S = 0.005  # lags are tried so far apart .. [precision]
_LAG_MAX_S = 0.1  # .. up to here, slower than the transport of any drive's messages .. [physics]
_LAG_ROWS_MAX = 20_000  # rows looked at: 100 s tell clocks apart [effort]
_STRETCHES_RAD = (0.003, 0.01, 0.03, 0.1)  # turns of the motor over which contacts yield [physics]
_LAG_STEPS_MIN = 10  # .. or for so many steps of a slow record [judgement]
_LAG_DOUBTFUL_S = 0.015  # a drive that is later: what filters drives as it is recorded takes less [judgement]
# It must leave less than this share of the error: once per turn, what repeats finds itself again elsewhere; and of more than half of the longest,
# which no transport takes, less than that [judgement]
_LAG_GAIN, _LAG_GAIN_LONG = 0.75, 0.5
_NOTHING_PERCENT = 90.0  # of a drive, that inertia, drag, friction and any load leave where they have nothing to do with it [judgement]


def judge_motion(actuator: Actuator, record: MotionRecord) -> RecordValidity:
    """Judges a record by itself; nothing is simulated."""
    present = {name: record.channel(name) is not None for name in (*MOTIONS, *DRIVES, *VOLTAGES)}
    least = Smoother.of(record.period_s).least_rows
    if record.rows < least:
        text = f"{record.file} has {record.rows} rows, {record.rows * record.period_s:.3g} s, too few for any filter"
        wanted = f"record {least} rows or more, {least * record.period_s:.3g} s, and look whether the unit of its time is right"
        return RecordValidity(present, (RecordRemark("coverage", "blocks", text, wanted),), {})
    remarks = []
    motion = motion_signal(record)
    if not np.max(np.abs(motion)) > 0.0 or (np.ptp(motion) <= _MOVING * float(np.max(np.abs(motion))) and "speed" not in _name(record)):
        remarks.append(RecordRemark("coverage", "blocks", f"{_name(record)} does not change", "record while the machine moves"))
        return RecordValidity(present, tuple(remarks), {})
    try:
        smoother = quiet_smoother(actuator, record)
        smoothed = motion_of(actuator, record, smoother)
        model = mechanical_model(actuator, record, smoother, smoothed)
    except MissingSignal as error:
        remarks.append(RecordRemark("signals", "blocks", str(error), "record it, or state it in the actuator"))
        return RecordValidity(present, tuple(remarks), {})
    drive, speed = model.smoother.inner(model.drive_Nm), model.smoother.inner(model.columns[:, 1])
    if not np.any(drive):
        remarks.append(
            RecordRemark("signals", "blocks", "the drive is zero throughout", "look which column holds the torque, force or current")
        )
    else:
        remarks += [*turned(model), *odd_rows(record), *swings_unseen(record, model, smoothed)]
    low, high = np.quantile(speed, (_A_TENTH, 1.0 - _A_TENTH))
    if low < 0.0 < high and min(-low, high) > _A_TENTH * float(np.max(np.abs(speed))) and np.ptp(drive) > 0.0:
        alike = float(np.corrcoef(drive, speed)[0, 1])
        if alike < _AGAINST:
            text = f"the drive goes against the motion (correlation {alike:.2f})"
            remarks.append(
                RecordRemark("signs", "weakens", text, "look whether the sign of the drive or of the motion is turned in the map")
            )
        remarks += _late(actuator, record, model, smoothed)
    fastest = float(np.max(np.abs(speed)))
    moves = model.smoother.inner(~model.still)
    forward = float(np.mean(speed[moves] > 0.0)) if moves.any() else 0.5
    return RecordValidity(
        present, tuple(remarks), {"speed_max_rad_s": fastest, "moving_share": float(np.mean(~model.resting)), "forward_share": forward}
    )


def turned(model: Mechanical) -> list[RecordRemark]:
    """A drive with the other sign than the motion's: beside it inertia and dry friction would both be less than none, which no load makes of a machine."""
    target = model.smoother.inner(model.drive_Nm - model.load_Nm - model.added_Nm)
    moves = model.smoother.inner(~model.resting)
    columns, target = model.smoother.inner(model.columns)[moves], target[moves]
    if target.size <= columns.shape[1]:
        return []
    found = np.linalg.lstsq(columns, target, rcond=None)[0]
    whole = float(np.linalg.norm(target)) or 1.0
    parts = np.linalg.norm(columns * found, axis=0) / whole
    left = float(np.linalg.norm(target - columns @ found)) / whole
    inertia, friction = 0, 2
    if left > _TURNED_LEAVES or max(found[inertia], found[friction]) >= 0.0 or min(parts[inertia], parts[friction]) < _TURNED_PART:
        return []
    text = "the drive has the other sign than the motion: inertia and friction would both be less than none"
    return [
        RecordRemark("signs", "blocks", text, "turn the sign of one of the two in the map (sign = -1 at its column), and import it again")
    ]


def one_way(gates: Sequence[RecordValidity]) -> RecordRemark | None:
    """What to say of records that all move the same way; None of any others."""
    shares = [gate.coverage.get("forward_share", 0.5) for gate in gates]
    if min(shares) > _ONE_WAY or max(shares) < 1.0 - _ONE_WAY:
        text = "the machine moves one way only, where friction, a load and what differs by direction are one"
        return RecordRemark("coverage", "weakens", text, "record the other way too")
    return None


def _late(actuator: Actuator, record: MotionRecord, model: Mechanical, motion: Motion) -> list[RecordRemark]:
    """Whether the drive was recorded by another clock than the motion: whether inertia and friction fit it far better with the motion some time earlier or later.

    A contact that yields before it slides is late as well, by an angle and not by a time: it is free on either side.
    """
    every = max(1, round(_LAG_STEP_S / record.period_s))
    step_s = every * record.period_s
    kept = slice(0, _LAG_ROWS_MAX)
    target = model.smoother.inner(model.drive_Nm - model.load_Nm - model.added_Nm)[::every][kept]
    moves = model.smoother.inner(~model.resting)[::every][kept]
    columns = [model.smoother.inner(one)[::every][kept] for one in _yielding(actuator, record, model, motion)]
    most = min(max(_LAG_STEPS_MIN, round(_LAG_MAX_S / step_s)), target.size // 10)
    errors = {}
    for steps in range(-most, most + 1):
        here, there = slice(max(0, -steps), target.size - max(0, steps)), slice(max(0, steps), target.size - max(0, -steps))
        errors[steps] = min(_left_percent(one[here][moves[here]], target[there][moves[here]]) for one in columns)
    best = min(errors, key=lambda steps: (errors[steps], abs(steps)))
    if errors[best] > _NOTHING_PERCENT:
        text = f"inertia, drag, friction and any load leave {errors[best]:.3g} % of the drive, as if it were another machine's or noise"
        return [RecordRemark("signals", "weakens", text, "look which column of the file holds the drive, and in which unit")]
    gain = _LAG_GAIN_LONG if 2 * abs(best) > most else _LAG_GAIN
    if abs(best) * step_s < max(_LAG_DOUBTFUL_S, 2.0 * record.period_s) or errors[best] > gain * errors[0]:
        return []
    text = (
        f"the drive is about {1e3 * abs(best) * step_s:.0f} ms {'behind' if best > 0 else 'ahead of'} the motion: so shifted, "
        f"inertia and friction leave {errors[best]:.3g} % of it instead of {errors[0]:.3g} %"
    )
    later = "the drive" if best > 0 else "the motion"
    wanted = (
        f'record both by one clock, or import again with delay = "{1e3 * abs(best) * step_s:.0f} ms" in the map, at the column of {later}'
    )
    return [RecordRemark("clock", "weakens", text, wanted)]


def _yielding(actuator: Actuator, record: MotionRecord, model: Mechanical, motion: Motion) -> list[Reals]:
    """The columns of the base parameters as the actuator has them, and with contacts that yield, [rows, 4] each."""
    size = next((effect.size for effect in load_definitions().physical if effect.site == "PRESLIDING"), None)
    if size is None or effect_of(size.name) in actuator.active_effects:
        return [model.columns]
    soft = (actuator.changed({size.name: stretch}) for stretch in _STRETCHES_RAD)
    return [model.columns, *(mechanical_model(one, record, model.smoother, motion).columns for one in soft)]


def _left_percent(columns: Reals, drive: Reals) -> float:
    """What inertia, drag and friction, none of them negative, and any load leave of the drive, %."""
    both = np.column_stack([columns, -columns[:, 3]])
    sizes = np.linalg.norm(both, axis=0)
    # products serve, and are few
    root = np.asarray(np.linalg.qr(np.column_stack([both / np.where(sizes > 0.0, sizes, 1.0), drive]), mode="r"))
    return 100.0 * float(optimize.nnls(root[:, :-1], root[:, -1])[1]) / (float(np.linalg.norm(drive)) or 1.0)


def _name(record: MotionRecord) -> str:
    return next(name for name in MOTIONS if name in record.present)
