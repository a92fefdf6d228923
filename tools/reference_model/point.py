"""Where the plant is: what an effect may look at."""

from __future__ import annotations

from typing import NamedTuple


class Data(NamedTuple):
    """Numbers of the actuator that an effect may need, PARAMETER effects applied."""

    torque_constant_Nm_per_A: float
    viscous_Nm_s_per_rad: float
    lead_mm: float
    supply_V: float


class Point(NamedTuple):
    """State of motor and shaft; `motor_mm` is the angle expressed at the rod, `voltage_V` the drive's.

    `direction`: of dry friction, -1 or 1, where its level is asked for. `winding`, `grease`: relative changes, by temperature, of the resistance and of dry and viscous friction.
    """

    current_A: float
    speed_rad_s: float
    angle_rad: float
    motor_mm: float
    voltage_V: float
    data: Data
    direction: float
    winding: float
    grease: float
