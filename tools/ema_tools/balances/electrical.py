"""The electrical balance: u - (R i + L di/dt + ke w)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_tools.balances.balance import Balance
from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.motion import Motion, at_points, between_rows, motor_position, warmth, whole_and_rest
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record

ELECTRICAL_PARAMETERS = ("motor.resistance_ohm", "motor.inductance_H", "motor.back_emf_V_s_per_rad")


@dataclass(frozen=True)
class Electrical:
    """The electrical balance as a linear model at the middles of the rows' intervals: voltage + known = columns @ (R, L, ke)."""

    voltage_V: Reals
    known_V: Reals
    columns: Reals
    time_s: Reals


def electrical_model(actuator: Actuator, record: Record) -> Electrical:
    """Voltage, what the effects add, and the columns current, its rate and speed.

    The voltage is held over a row's interval, so its sum over the interval is exact with the mean current and the differences of current and
    angle between the interval's ends. Raises MissingSignal.
    """
    if record.voltage_V is None:
        raise MissingSignal("voltage_V is not recorded")
    if actuator["drive.mode"] == 1.0:
        if actuator["drive.command_scale_V"] > 0.0:
            raise MissingSignal("voltage_V is the drive's command, not the motor's voltage")
        raise MissingSignal("the current drive changes the motor's voltage between rows")
    if record.current_A is None:
        raise MissingSignal("current_A is not recorded")
    if actuator["drive.current_limit_A"] > 0.0 and np.max(np.abs(record.current_A)) >= 0.999 * actuator["drive.current_limit_A"]:
        raise MissingSignal("the current limit is reached, where the drive takes voltage away")
    motor_rad = motor_position(actuator, record) / actuator.lead_mm_per_rad
    period = record.period_s
    current = 0.5 * (record.current_A[1:] + record.current_A[:-1])
    rate = np.diff(record.current_A) / period
    speed = np.diff(motor_rad) / period
    angle = 0.5 * (motor_rad[1:] + motor_rad[:-1])
    middle = Motion(current, speed, np.zeros_like(speed), angle, angle * actuator.lead_mm_per_rad)
    voltage = between_rows(record.voltage_V[:-1], *whole_and_rest(adjusted(actuator)["drive.output_delay_s"] / period))
    known = at_points(actuator, middle, "VOLTAGE", voltage_V=voltage)
    warm = warmth(actuator, record.current_A, "WINDING", period)
    known -= 0.5 * (warm[1:] + warm[:-1]) * adjusted(actuator)["motor.resistance_ohm"] * current
    ripple = at_points(actuator, middle, "MOTOR")
    known -= adjusted(actuator)["motor.back_emf_V_s_per_rad"] * ripple * speed

    smoother = Smoother.of(period)

    def kept(values: Reals) -> Reals:
        return smoother.decimated(smoother.smooth(values))

    return Electrical(
        voltage_V=kept(voltage),
        known_V=kept(known),
        columns=np.column_stack([kept(current), kept(rate), kept(speed)]),
        time_s=smoother.kept(record.time_s[:-1] + 0.5 * period),
    )


def electrical(actuator: Actuator, record: Record) -> Balance:
    """Motor voltage minus what winding and back-EMF need, V. Raises MissingSignal."""
    model = electrical_model(actuator, record)
    values = adjusted(actuator)
    residual = model.voltage_V + model.known_V - model.columns @ np.array([values[name] for name in ELECTRICAL_PARAMETERS])
    return Balance("electrical", "V", model.time_s, model.voltage_V, residual)
