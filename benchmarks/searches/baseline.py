"""What needs no search: recursive least squares on the balances of a recorded run, sample by sample, as the paper's baseline.

    torque:    kt i = J dw/dt + D w + C sgn w + T          at the motor shaft, while it turns
    circuit:   u - ke w = R i
    kinematic: rod - motor = play / 2 * sgn w + c          where the motor has gone farther one way than the play

It runs the model not once. It reads the motor's position, current and voltage, which the search by the rod position alone does without, and needs the constants kt, ke and the lead.
"""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np
from scipy.signal import savgol_filter

from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator

# The differentiating filter: a parabola over 41 rows, 24 periods of the fastest command in its way.
_WINDOW, _ORDER = 41, 2
# The shaft turns above this share of its largest speed.
_TURNS = 0.05
_DOUBT = 1e6


def recursive(columns: Reals, target: Reals) -> Reals:
    """Least squares of `target` [n] on `columns` [n, p], one row after the other, [p]."""
    size = np.sqrt(np.mean(columns**2, axis=0))
    estimate, covariance = np.zeros(columns.shape[1]), _DOUBT * np.eye(columns.shape[1])
    for row, seen in zip(columns / size, target, strict=True):
        spread = covariance @ row
        gain = spread / (1.0 + row @ spread)
        estimate = estimate + gain * (seen - row @ estimate)
        covariance = covariance - np.outer(gain, spread)
    return np.asarray(estimate / size)


def estimates(recording: Recording) -> tuple[Mapping[str, float], float]:
    """CSJ, viscous friction, load, BLK and resistance by name, and the seconds that it took."""
    begun = time.thread_time()
    actuator = reference_actuator()
    period = float(recording.time_s[1] - recording.time_s[0])
    per_mm = 2.0 * np.pi * actuator["gearbox.ratio"] / actuator["screw.lead_mm"]
    angle = per_mm * recording.motor_position_mm
    speed = savgol_filter(angle, _WINDOW, _ORDER, deriv=1, delta=period)
    acceleration = savgol_filter(angle, _WINDOW, _ORDER, deriv=2, delta=period)
    current = savgol_filter(recording.current_A, _WINDOW, _ORDER)
    voltage = savgol_filter(recording.voltage_V, _WINDOW, _ORDER)
    turns = np.abs(speed) > _TURNS * np.max(np.abs(speed))
    way = np.sign(speed[turns])
    torque = recursive(
        np.column_stack([acceleration[turns], speed[turns], way, np.ones(way.size)]),
        actuator["motor.torque_constant_Nm_per_A"] * current[turns],
    )
    circuit = recursive(current[turns][:, None], voltage[turns] - actuator["motor.back_emf_V_s_per_rad"] * speed[turns])
    taken_up = _taken_up(recording.motor_position_mm, turns)
    apart = (recording.position_mm - recording.motor_position_mm)[taken_up]
    play = recursive(np.column_stack([-np.sign(speed[taken_up]), np.ones(apart.size)]), apart)
    found = {
        "screw.csj_Nm": float(torque[2]),
        "screw.viscous_Nm_s_per_rad": float(torque[1]),
        "screw.load_torque_Nm": float(torque[3]),
        "screw.blk_mm": float(2.0 * play[0]),
        "motor.resistance_ohm": float(circuit[0]),
    }
    return found, time.thread_time() - begun


def _taken_up(motor_mm: Reals, turns: np.ndarray) -> np.ndarray:
    """Rows in which the motor has gone one way farther than any play of the search, [n] of bool."""
    most = reference_actuator()["search.blk_upper_mm"]
    away = np.zeros(motor_mm.size)
    for row in range(1, motor_mm.size):
        step = motor_mm[row] - motor_mm[row - 1]
        # the farthest point of this way goes along; against it the distance grows
        away[row] = step if away[row - 1] * step < 0.0 and abs(step) > 0.0 and turns[row] else away[row - 1] + step
    return np.asarray(turns & (np.abs(away) > most))
