"""Why records leave too few samples of motion for anything to be confirmed by others, and what helps: their signal's steps or noise, their rate, or that they are short."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import SLOW_SHARE
from ema_tools.balances.motion import noise_of_motion, train_of
from ema_tools.base.noise import resolution
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.data.motion_signals import motor_angle
from ema_tools.select.balance_bench import Bench
from ema_tools.select.balance_setting import Piece

SAMPLES_MIN = 60  # of motion, some for every number that is fitted in one part and confirmed in another [judgement]
_OF_NOISE = 0.5  # of a signal's noise, that its steps must be to make it [judgement]
_LOST = 0.5  # of the samples that move by the smoothed speed, fewer of which are left where steps hide motion [judgement]
_OF_STEPS = 1.0 / math.sqrt(12.0)  # standard deviation over the step, of what rounding adds [chance]
_UNITS = {"_rad": "rad", "_rad_s": "rad/s", "_mm": "mm", "_mm_s": "mm/s"}


@dataclass(frozen=True)
class _MotionColumn:
    """The recorded column that the motion is made of: its steps in its unit, 0 where none are seen, and whether rounding to these is what it is noisy by."""

    name: str
    step: float
    by_steps: bool

    @property
    def unit(self) -> str:
        """As its name says it."""
        return next(unit for end, unit in sorted(_UNITS.items(), key=lambda one: -len(one[0])) if self.name.endswith(end))

    @property
    def is_speed(self) -> bool:
        """Whether it is one."""
        return self.name.endswith("_s")

    @property
    def finer(self) -> str:
        """What to record in its place."""
        return f"{self.name} in finer steps" + ("" if self.is_speed else " or the speed")


def too_few(actuator: Actuator, bench: Bench) -> str:
    """What to answer where fewer samples of motion are left than serve; empty where enough are."""
    count = int(bench.sliding.sum())
    if count >= SAMPLES_MIN:
        return ""
    why, instead = _cause(actuator, bench, count)
    # as much of the time would be left of more such motion
    least_s = max(
        SAMPLES_MIN * max(one.every * one.period_s for one in bench.smoothers),
        sum(one.rows * one.period_s for one in bench.records) * SAMPLES_MIN / max(count, 1) if why else 0.0,
    )
    told = f"{count} samples of motion are left behind the filter, too few to confirm anything by others{why}"
    return f"{told}: record {instead}{least_s:.2g} s of motion or more, slow and fast, both ways"


def _cause(actuator: Actuator, bench: Bench, count: int) -> tuple[str, str]:
    """Why few are left, and what to record instead, where it is not that the records are short."""
    pieces = bench.start.setting.pieces
    slowest = max(pieces, key=lambda one: one.model.smoother.every * one.model.smoother.period_s)
    filtered = slowest.model.smoother
    filter_s = filtered.every * filtered.period_s
    usual = Smoother.of(filtered.period_s)
    column = max((_column_of(actuator, one.record) for one in pieces), key=lambda one: one.step)
    steps = f", because {column.name} comes in steps of {column.step:.2g} {column.unit}"
    moving = sum(int(np.count_nonzero(one.model.smoother.kept(_moves(one)))) for one in pieces)
    if filtered.cutoff_hz < usual.cutoff_hz and moving * filtered.every >= SAMPLES_MIN * usual.every:
        coarse = _column_of(actuator, slowest.record)
        if coarse.by_steps:
            steps = f", because {coarse.name} comes in steps of {coarse.step:.2g} {coarse.unit}"
            return f"{steps}, which needs a filter of {filter_s:.2g} s", f"{coarse.finer}, or "
        return f", because {coarse.name} is so noisy that it needs a filter of {filter_s:.2g} s", f"{coarse.name} with less noise, or "
    if column.step > 0.0 and moving >= SAMPLES_MIN and count < _LOST * moving:
        hidden = "" if column.is_speed else f", {column.step / filtered.period_s:.2g} {column.unit}/s from row to row"
        return f"{steps}{hidden}: slower motion looks like rest, beside which {filter_s:.2g} s are lost", f"{column.finer}, or "
    if usual.blunts and count * filtered.every >= SAMPLES_MIN:
        return f", because rows every {filtered.period_s:.2g} s need a filter of {filter_s:.2g} s", "more rows a second, or "
    return "", ""


def _moves(piece: Piece) -> NDArray[np.bool_]:
    """Rows that move by the smoothed speed, [rows]."""
    speed = np.abs(piece.motion.speed_rad_s)
    return np.asarray(speed > SLOW_SHARE * np.max(speed))


def _column_of(actuator: Actuator, record: AnyRecord) -> _MotionColumn:
    """The column of a record that the motor's motion is made of."""
    if isinstance(record, MotionRecord):
        name = motor_angle(record, train_of(actuator)).column
        scale = 1.0 if name.startswith("motor_") and not name.endswith("_mm") else train_of(actuator).mm_per_rad or 1.0
    else:
        name = "motor_position_mm" if record.motor_position_mm is not None else "position_mm"
        scale = actuator.lead_mm_per_rad
    step = resolution(record.recorded(name))
    noise, _ = noise_of_motion(actuator, record)
    return _MotionColumn(name, step, step > 0.0 and step * _OF_STEPS >= _OF_NOISE * noise * scale)
