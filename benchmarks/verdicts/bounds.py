"""What a unit's scatter and sensors allow at best: the Cramer-Rao bound of CSJ and BLK by the truth plant's own sensitivities, with what differs from day to day as unknowns of known spread.

Nothing of the code under test is in it: signals, scatter and temperature are the truth plant's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from benchmarks.hidden.machines import CHANNELS, Machine, exact
from benchmarks.truth.climate import DRY_PER_DEGC, at_temperature
from benchmarks.verdicts.trials import VerdictTrial
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import reference_actuator

_VALUES = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}
_STEP = 0.02  # of a value, for its slope [precision]
_UNIFORM = 1.0 / math.sqrt(12.0)  # standard deviation of what a count hides, in counts [physics]
_NORMAL_95 = 1.96


def _noise(unit: Machine) -> Reals:
    """Standard deviation of a row's noise and rounding, [CHANNELS]."""
    sensors = unit.sensors
    pairs = (
        (sensors.position_noise_mm, sensors.position_resolution_mm),
        (sensors.motor_position_noise_mm, sensors.motor_position_resolution_mm),
        (sensors.current_noise_A, sensors.current_resolution_A),
        (sensors.voltage_noise_V, sensors.voltage_resolution_V),
    )
    return np.array([math.hypot(noise, _UNIFORM * count) for noise, count in pairs])


def half_widths(trial: VerdictTrial, alone: bool) -> Mapping[str, float]:
    """Half of the narrowest 95 % interval of each fault, in % of the healthy value, of a reading held against the mean of the unit's healthy runs; by the rod position `alone`, or all
    signals."""
    unit = trial.unit
    columns, ways = _slopes(trial.number, trial.setting, trial.command)
    channels = 1 if alone else len(CHANNELS)
    weights = 1.0 / _noise(unit)[:channels, None]
    every = np.column_stack([(weights * one[:channels]).ravel() for one in (*columns, *ways)])
    known = np.diag([0.0] * len(columns) + [1.0] * len(ways))
    std = np.sqrt(np.diag(np.linalg.inv(every.T @ every + known)))[: len(columns)]
    widened = _NORMAL_95 * math.sqrt(1.0 + 1.0 / trial.healthy)
    return {name: float(100.0 * widened * one) for name, one in zip(_VALUES, std, strict=True)}


@lru_cache(maxsize=64)
def _slopes(number: int, setting: str, command: str) -> tuple[list[Reals], list[Reals]]:
    """How the true signals move with each fault, per share of its healthy value, and with one standard deviation of what scatters, [CHANNELS, rows] each.

    What scatters of a value moves the signals just as the value does: two slopes by steps of two sizes would differ by the model's events, and seem to tell one from the other.
    """
    unit, sheet = VerdictTrial("unit", number, setting, command, 1, 0).unit, reference_actuator()
    nominal = {name: unit.values.get(name, sheet[name]) for name in {*_VALUES.values(), *unit.scatter}}

    def slope(name: str) -> Reals:
        up, down = (exact(unit, {name: nominal[name] * (1.0 + sign * _STEP)}, command) for sign in (1.0, -1.0))
        return np.asarray((up - down) / (2.0 * _STEP))

    by_value = {name: slope(name) for name in nominal}
    ways = [by_value[name] * std for name, std in unit.scatter.items()]
    if unit.is_set.temperature_degC > 0.0:
        std_degC = unit.is_set.temperature_degC / math.sqrt(3.0)
        warm, cold = (at_temperature(nominal, sign * std_degC) for sign in (1.0, -1.0))
        shares = {name: (warm[name] - cold[name]) / (2.0 * nominal[name]) for name in nominal}
        ways.append(np.asarray(sum(share * by_value[name] for name, share in shares.items())))
    return [by_value[name] for name in _VALUES.values()], ways


def allowed_rms(unit: Machine, healthy: int, share: float) -> float:
    """The error of CSJ, in %, that friction's own scatter and temperature leave to a reading without a thermometer: today's, which grows with the fault's `share`, beside the mean of the
    healthy runs."""
    by_temperature = DRY_PER_DEGC * unit.is_set.temperature_degC / math.sqrt(3.0)
    variance = unit.scatter[_VALUES["csj"]] ** 2 + by_temperature**2
    return 100.0 * math.sqrt(variance * ((1.0 + share) ** 2 + 1.0 / healthy))
