"""What voltage and current together say of the motor's winding, today's records against healthy ones: u = R i + L di/dt + ke w + offset, record by record, whoever controls the machine."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_tools.balances.filtering import Smoother
from ema_tools.balances.motion import train_of
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.data.motion_signals import motor_speed
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Change

_VALUES = ("motor.resistance_ohm", "motor.back_emf_V_s_per_rad")  # as the columns stand
# Least scatter of either from record to record, relative: a winding is some kelvin warmer or colder, and few records do not show it [judgement]
_LEAST = 0.015
_LEAST_TIMES = 3.0  # such standard deviations are a change [chance]
_EXPLAINED = 0.9  # of the voltage's square, that winding and speed must be for the record to tell them [judgement]
_CLEAR = 0.1  # standard error that a record's value may have, relative [judgement]


def winding_changes(machine: HealthyByBalance, records: Sequence[AnyRecord]) -> tuple[Change, ...]:
    """Resistance and back-EMF where enough healthy records and one of today tell them; nothing where they do not."""
    before, after = (_told(machine.actuator, group) for group in (machine.records, records))
    if len(before) < 2 or not len(after):
        return ()
    found = []
    for place, name in enumerate(_VALUES):
        healthy, today = float(np.mean(before[:, place])), float(np.mean(after[:, place]))
        if not healthy > 0.0:
            continue
        shown, least = float(np.std(before[:, place], ddof=1)), _LEAST * healthy
        # few records tell their scatter badly; what is known of windings needs no such margin
        limit = max(machine.times * shown, _LEAST_TIMES * least) * math.sqrt(1.0 + 1.0 / len(before))
        std = max(shown, least) * math.sqrt(1.0 / len(before) + 1.0 / len(after))
        found.append(Change(name, healthy, today, std, limit, abs(today - healthy) > limit))
    return tuple(found)


def _told(actuator: Actuator, records: Sequence[AnyRecord]) -> Reals:
    """R and ke of each record that tells them, [records, 2]."""
    fits = (_fitted(actuator, record) for record in records if isinstance(record, MotionRecord))
    return np.array([one for one in fits if one is not None]).reshape(-1, len(_VALUES))


def _fitted(actuator: Actuator, record: MotionRecord) -> Reals | None:
    """R and ke of a record, [2]; None where it has no voltage and current, or its motion does not tell them apart."""
    voltage = record.motor_voltage_V
    smoother = Smoother.of(record.period_s)
    if voltage is None or record.current_A is None or record.rows < smoother.least_rows:
        return None
    try:
        speed = motor_speed(record, train_of(actuator)).values
    except MissingSignal:
        return None
    current = smoother.smooth(record.current_A)
    rows = [current, smoother.smooth(speed), np.gradient(current, record.period_s), np.ones(record.rows)]
    columns, target = smoother.decimated(np.column_stack(rows)), smoother.decimated(smoother.smooth(voltage))
    scale = np.linalg.norm(columns, axis=0)
    if not np.all(scale > 0.0):
        return None
    solved, *_ = np.linalg.lstsq(columns / scale, target, rcond=None)
    left = target - columns / scale @ solved
    about = float(np.sum((target - np.mean(target)) ** 2))
    if not about > 0.0 or float(np.sum(left**2)) > (1.0 - _EXPLAINED) * about:
        return None
    covariance = np.linalg.pinv((columns / scale).T @ (columns / scale)) * float(np.mean(left**2))
    if any(math.sqrt(float(covariance[k, k])) > _CLEAR * abs(float(solved[k])) for k in range(len(_VALUES))):
        return None
    return np.asarray(solved[: len(_VALUES)] / scale[: len(_VALUES)])
