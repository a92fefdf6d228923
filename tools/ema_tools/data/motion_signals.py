"""What a recording says of the motor shaft and the rod, whichever signals it has: recorded, converted by lead and ratio, integrated or differentiated, and which of these."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.motion_records import DRIVES, MOTIONS, MotionRecord

Origin = Literal["recorded", "converted", "integrated", "differentiated"]


@dataclass(frozen=True)
class Train:
    """What lies between motor shaft and rod: rod travel per motor angle in mm/rad, None for a bare motor; `loose` where the rod does not follow the motor at once (play, an elastic part)."""

    mm_per_rad: float | None = None
    loose: bool = False


@dataclass(frozen=True)
class Signal:
    """Values [rows], what was made of which column."""

    values: Reals
    origin: Origin
    column: str


def integrated(values: Reals, period_s: float) -> Reals:
    """The integral by the trapezoidal rule, zero at the first row, [rows]."""
    return np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1])) * period_s))


def _columns(train: Train, angle: bool) -> tuple[tuple[str, float], ...]:
    """Columns of the motor's angle or of its speed, the nearest first, with the factor to rad or rad/s."""
    scale = 1.0 / train.mm_per_rad if train.mm_per_rad else None
    motor = ("motor_angle_rad", 1.0) if angle else ("motor_speed_rad_s", 1.0)
    at_rod: list[tuple[str, float]] = []
    if scale is not None:
        if angle:
            at_rod.append(("motor_position_mm", scale))
        if not train.loose:
            at_rod.append(("position_mm" if angle else "speed_mm_s", scale))
    return (motor, *at_rod)


def _first(record: MotionRecord, columns: tuple[tuple[str, float], ...]) -> Signal | None:
    for name, factor in columns:
        values = record.channel(name)
        if values is not None:
            return (
                Signal(values, "recorded", name)
                if factor == 1.0 and name.startswith("motor_")
                else Signal(factor * values, "converted", name)
            )
    return None


def motor_angle(record: MotionRecord, train: Train) -> Signal:
    """Angle of the motor shaft in rad, [rows]; from a speed by integration, then `start_rad` at the first row. Raises MissingSignal."""
    found = _first(record, _columns(train, angle=True))
    if found is not None:
        return found
    speed = _first(record, _columns(train, angle=False))
    if speed is not None:
        return Signal(record.start_rad + integrated(speed.values, record.period_s), "integrated", speed.column)
    raise MissingSignal(_why_not(record, train))


def motor_speed(record: MotionRecord, train: Train) -> Signal:
    """Speed of the motor shaft in rad/s, [rows]; from an angle by central differences. Raises MissingSignal."""
    found = _first(record, _columns(train, angle=False))
    if found is not None:
        return found
    angle = _first(record, _columns(train, angle=True))
    if angle is not None:
        return Signal(np.gradient(angle.values, record.period_s), "differentiated", angle.column)
    raise MissingSignal(_why_not(record, train))


def rod_position(record: MotionRecord, train: Train) -> Signal:
    """Position of the rod in mm, [rows]; the motor's where the rod follows it at once. Raises MissingSignal."""
    if record.position_mm is not None:
        return Signal(record.position_mm, "recorded", "position_mm")
    if record.speed_mm_s is not None:
        return Signal(integrated(record.speed_mm_s, record.period_s), "integrated", "speed_mm_s")
    if train.mm_per_rad and not train.loose:
        angle = motor_angle(record, train)
        return Signal(train.mm_per_rad * angle.values, "converted" if angle.origin == "recorded" else angle.origin, angle.column)
    raise MissingSignal(_why_no_rod(record, train))


def rod_speed(record: MotionRecord, train: Train) -> Signal:
    """Speed of the rod in mm/s, [rows]; the motor's where the rod follows it at once. Raises MissingSignal."""
    if record.speed_mm_s is not None:
        return Signal(record.speed_mm_s, "recorded", "speed_mm_s")
    if record.position_mm is not None:
        return Signal(np.gradient(record.position_mm, record.period_s), "differentiated", "position_mm")
    if train.mm_per_rad and not train.loose:
        speed = motor_speed(record, train)
        return Signal(train.mm_per_rad * speed.values, "converted" if speed.origin == "recorded" else speed.origin, speed.column)
    raise MissingSignal(_why_no_rod(record, train))


def drive_torque(record: MotionRecord, train: Train, torque_constant_Nm_per_A: float | None) -> Signal:
    """Torque of the drive at the motor shaft in Nm, [rows]: the torque itself, the force at the rod, or the current with the torque constant, in this order. Raises MissingSignal."""
    if record.torque_Nm is not None:
        return Signal(record.torque_Nm, "recorded", "torque_Nm")
    if record.force_N is not None and train.mm_per_rad:
        return Signal(1e-3 * train.mm_per_rad * record.force_N, "converted", "force_N")
    if record.current_A is not None and torque_constant_Nm_per_A is not None:
        return Signal(torque_constant_Nm_per_A * record.current_A, "converted", "current_A")
    if record.current_A is not None:
        raise MissingSignal("current_A is recorded, but the motor's torque_constant_Nm_per_A is not known")
    if record.force_N is not None:
        raise MissingSignal("force_N is recorded, but the screw's lead_mm and the gearbox's ratio are not known")
    raise MissingSignal(f"none of {', '.join(DRIVES)} is recorded")


def disturbance_torque(record: MotionRecord, train: Train) -> Reals:
    """Known torque against the motion at the motor shaft in Nm, [rows]; zero where none is recorded. Raises MissingSignal."""
    total = np.zeros(record.rows)
    if record.disturbance_Nm is not None:
        total = total + record.disturbance_Nm
    if record.disturbance_N is not None:
        if not train.mm_per_rad:
            raise MissingSignal("disturbance_N is recorded, but the screw's lead_mm and the gearbox's ratio are not known")
        total = total + 1e-3 * train.mm_per_rad * record.disturbance_N
    return total


def origins(record: MotionRecord, train: Train, torque_constant_Nm_per_A: float | None) -> dict[str, tuple[Origin, str]]:
    """Of which column motor angle, motor speed, rod position, rod speed and drive torque are made and how; what cannot be had is left out."""
    ways: dict[str, Callable[[], Signal]] = {
        "motor_angle_rad": lambda: motor_angle(record, train),
        "motor_speed_rad_s": lambda: motor_speed(record, train),
        "position_mm": lambda: rod_position(record, train),
        "speed_mm_s": lambda: rod_speed(record, train),
        "torque_Nm": lambda: drive_torque(record, train, torque_constant_Nm_per_A),
    }
    found: dict[str, tuple[Origin, str]] = {}
    for name, way in ways.items():
        try:
            signal = way()
        except MissingSignal:
            continue
        found[name] = (signal.origin, signal.column)
    return found


def _why_not(record: MotionRecord, train: Train) -> str:
    there = [name for name in MOTIONS if name in record.present]
    if not there:
        return f"none of {', '.join(MOTIONS)} is recorded"
    if not train.mm_per_rad:
        return f"{there[0]} is recorded, but the screw's lead_mm and the gearbox's ratio are not known"
    return f"{there[0]} is recorded, but the rod does not follow the motor at once"


def _why_no_rod(record: MotionRecord, train: Train) -> str:
    if train.loose:
        return "neither position_mm nor speed_mm_s is recorded, and the rod does not follow the motor at once"
    return "neither position_mm nor speed_mm_s is recorded, and the screw's lead_mm and the gearbox's ratio are not known"
