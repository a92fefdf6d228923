"""A voltage as the drive: the current that it makes in a winding whose data the actuator states."""

from __future__ import annotations

from ema_tools.base.errors import MissingSignal
from ema_tools.base.lag import lagged
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import DRIVES, MotionRecord
from ema_tools.data.motion_signals import Train, motor_speed

_WINDING = ("motor.resistance_ohm", "motor.back_emf_V_s_per_rad", "motor.torque_constant_Nm_per_A")


def with_current(record: MotionRecord, actuator: Actuator) -> MotionRecord:
    """The record with `current_A` as its voltage makes it, L di/dt = u - R i - ke w, where no drive is recorded and the actuator states the winding; else as it is."""
    voltage = record.motor_voltage_V
    if voltage is None or any(record.channel(name) is not None for name in DRIVES) or not all(map(actuator.has, _WINDING)):
        return record
    known = actuator.has("screw.lead_mm") and actuator.has("gearbox.ratio")
    try:
        speed = motor_speed(record, Train(actuator.lead_mm_per_rad if known else None, actuator.values["screw.blk_mm"] != 0.0)).values
    except MissingSignal:
        return record
    resistance_ohm = actuator["motor.resistance_ohm"]
    settled = (voltage - actuator["motor.back_emf_V_s_per_rad"] * speed) / resistance_ohm
    inductance_H = actuator["motor.inductance_H"] if actuator.has("motor.inductance_H") else 0.0
    return record.with_columns({"current_A": lagged(settled, record.period_s, inductance_H / resistance_ohm)})
