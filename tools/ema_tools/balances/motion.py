"""The motor's current, speed, acceleration and angle as the equations need them, and what effects do there."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.effects import acts, adjusted, transmission_of
from ema_tools.balances.filtering import Smoother
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.base.noise import white_noise
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.data.motion_signals import Train, drive_torque, motor_angle, motor_speed
from ema_tools.data.records import Record
from ema_tools.plant.native import library


@dataclass(frozen=True)
class Motion:
    """Motor signals on every row: current A, speed rad/s, acceleration rad/s2, angle rad, all smoothed; and the unsmoothed motor position mm.

    `placed`: whether angle and position are the machine's own, and not counted from wherever the record begins.
    """

    current_A: Reals
    speed_rad_s: Reals
    acceleration_rad_s2: Reals
    angle_rad: Reals
    motor_mm: Reals
    placed: bool = True

    def begun_at(self, actuator: Actuator, start_rad: float) -> Motion:
        """The same motion, farther along by an angle of the motor."""
        return replace(self, angle_rad=self.angle_rad + start_rad, motor_mm=self.motor_mm + _scale_mm_per_rad(actuator) * start_rad)


def at_points(
    actuator: Actuator,
    motion: Motion,
    site: str,
    level_Nm: float = 0.0,
    voltage_V: Reals | None = None,
    rows: NDArray[np.bool_] | None = None,
    side: float = 1.0,
) -> Reals:
    """Sum over the active effects of a site, on every row, or on `rows` and zero elsewhere; zeros at no cost when there are none.

    `level_Nm`: of friction against a motion to `side`, -1 or 1, `voltage_V` [rows]: for effects that look at them.
    """
    total = np.zeros(motion.speed_rad_s.size)
    kept = np.ones(total.size, dtype=bool) if rows is None else rows
    if not acts(actuator, site) or not kept.any():
        return total
    voltage = np.zeros(total.size) if voltage_V is None else voltage_V
    level = np.full(total.size, level_Nm)
    points = np.stack([motion.current_A, motion.speed_rad_s, motion.angle_rad, motion.motor_mm, voltage, level, np.full(total.size, side)])
    total[kept] = library().site(*actuator.arrays(), site, points[:, kept])
    return total


def warmth(actuator: Actuator, current_A: Reals, site: str, period_s: float) -> Reals:
    """Relative change of what warms as the record runs, of the winding's resistance (WINDING) or of dry and viscous friction (GREASE), [rows]; zeros at no cost without such an effect."""
    if not acts(actuator, site):
        return np.zeros(current_A.size)
    return np.asarray(library().warmth(*actuator.arrays(), site, current_A, period_s))


def between_rows(values: Reals, rows: int, share: float) -> Reals:
    """(1 - share) of `values` [rows] `rows` earlier and `share` of one more row earlier; the first and the last value go on beyond the record."""
    place = np.arange(values.size) - rows
    last = values.size - 1
    return (1.0 - share) * values[np.clip(place, 0, last)] + share * values[np.clip(place - 1, 0, last)]


def whole_and_rest(rows: float) -> tuple[int, float]:
    """A delay in whole rows and the rest of one; what is a whole number but for rounding counts as one."""
    whole = math.floor(rows + 1e-9)
    return whole, max(rows - whole, 0.0)


def drive_current(actuator: Actuator, record: Record) -> Reals:
    """The motor current, [rows]: as recorded, or from the command of a current drive that is never short of voltage.

    What a row asks for is held until the next one: the drive has the mean of what it holds over half a row to both sides, half a row late. Published models of sampled drives leave
    that half out; an actuator may say that it is such a model. Raises MissingSignal.
    """
    values = adjusted(actuator)
    current_drive = values["drive.mode"] == 1.0
    lag_s = values["drive.current_loop_s"]
    delay = values["drive.output_delay_s"] / record.period_s
    late, rest = whole_and_rest(delay)
    whole, share = whole_and_rest(delay if actuator.command_at_row else delay + 0.5)
    stands = not current_drive or lag_s > 0.0 or actuator.command_at_row
    if record.current_A is not None:
        # the row shows what the drive holds at its instant: with a part of a row of delay, still the command before
        shown = late + (1 if rest > 0.0 else 0)
        return record.current_A if stands else between_rows(record.current_A, whole - shown, share)
    if not (current_drive and values["drive.command_scale_V"] > 0.0 and record.voltage_V is not None):
        raise MissingSignal("current_A is not recorded")
    asked = record.voltage_V * (values["drive.current_scale_A"] / values["drive.command_scale_V"])
    if lag_s == 0.0:
        return between_rows(asked, whole, share)
    # exact for a reference that is held: over a row the older command acts first
    fade, newer = math.exp(-record.period_s / lag_s), math.exp(-(1.0 - rest) * record.period_s / lag_s)
    weights = (0.0, 1.0 - newer, newer - fade)
    reference = between_rows(asked, late, 0.0)
    # half a second to load, for this one case
    from scipy import signal

    start = signal.lfiltic(weights, (1.0, -fade), [reference[0]], [reference[0], reference[0]])
    return np.asarray(signal.lfilter(weights, (1.0, -fade), reference, zi=start)[0])


def learned_reading_mm(actuator: Actuator, rod_mm: Reals) -> Reals:
    """What learned tables add to the rod sensor's reading, [rows]."""
    nothing = np.zeros_like(rod_mm)
    seen = Motion(nothing, nothing, nothing, rod_mm / actuator.lead_mm_per_rad, rod_mm)
    return at_points(actuator, seen, "READING")


def _read_right(actuator: Actuator, record: Record) -> Reals:
    """The recorded rod position without what learned tables add to it, [rows]."""
    return record.position_mm - learned_reading_mm(actuator, record.position_mm)


def motor_position(actuator: Actuator, record: Record) -> Reals:
    """The motor position at the rod in mm, [rows]; the rod's own where nothing lies between them. Raises MissingSignal."""
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    if actuator["screw.blk_mm"] == 0.0 and not transmission_of(actuator):
        return (_read_right(actuator, record) - actuator["encoder.rod_offset_mm"]) / (1.0 + actuator["encoder.rod_gain_error"])
    between = transmission_of(actuator) or "play"
    raise MissingSignal(f"motor_position_mm is not recorded, and the rod follows the motor with {between}")


def train_of(actuator: Actuator) -> Train:
    """What lies between motor shaft and rod, as far as the actuator states it."""
    known = actuator.has("screw.lead_mm") and actuator.has("gearbox.ratio")
    loose = actuator.values["screw.blk_mm"] != 0.0 or bool(transmission_of(actuator))
    return Train(actuator.lead_mm_per_rad if known else None, loose)


def _scale_mm_per_rad(actuator: Actuator) -> float:
    """Rod travel per motor angle; of a bare motor that of the values which stand for lead and ratio, so that the module's equations can be asked."""
    return actuator.values["screw.lead_mm"] / (2.0 * math.pi * actuator.values["gearbox.ratio"])


def current_of(actuator: Actuator, record: AnyRecord) -> Reals:
    """The motor current, [rows]; of a machine whose torque or force is recorded the current that makes this torque. Raises MissingSignal."""
    if isinstance(record, Record):
        return drive_current(actuator, record)
    constant = actuator["motor.torque_constant_Nm_per_A"] if actuator.has("motor.torque_constant_Nm_per_A") else None
    torque = drive_torque(record, train_of(actuator), constant)
    return torque.values / adjusted(actuator)["motor.torque_constant_Nm_per_A"]


def noise_of_motion(actuator: Actuator, record: AnyRecord) -> tuple[float, int]:
    """Standard deviation of the white noise of the signal that the motion is made of, in terms of the motor's angle: rad, 0, or rad/s, 1, by what was recorded. Raises MissingSignal."""
    if isinstance(record, Record):
        return white_noise(motor_position(actuator, record)) / actuator.lead_mm_per_rad, 0
    angle = motor_angle(record, train_of(actuator))
    if angle.origin == "integrated":
        return white_noise(motor_speed(record, train_of(actuator)).values), 1
    return white_noise(angle.values), 0


def motion_of(actuator: Actuator, record: AnyRecord, smoother: Smoother) -> Motion:
    """Smoothed motor signals. Raises MissingSignal."""
    if isinstance(record, MotionRecord):
        return _recorded_motion(actuator, record, smoother)
    motor_mm = motor_position(actuator, record)
    angle = smoother.smooth(motor_mm) / actuator.lead_mm_per_rad
    speed = np.gradient(angle, record.period_s)
    return Motion(smoother.smooth(drive_current(actuator, record)), speed, np.gradient(speed, record.period_s), angle, motor_mm)


def raw_speed(actuator: Actuator, record: AnyRecord, motion: Motion) -> Reals:
    """The motor's speed by differences of the rows, not smoothed, rad/s, [rows]."""
    return np.asarray(np.gradient(motion.motor_mm, record.period_s) / _scale_mm_per_rad(actuator))


def _recorded_motion(actuator: Actuator, record: MotionRecord, smoother: Smoother) -> Motion:
    """The same of a machine of which anything may be recorded: a recorded speed is not differentiated from its own integral."""
    train = train_of(actuator)
    angle, speed = motor_angle(record, train), motor_speed(record, train)
    smooth_angle = smoother.smooth(angle.values)
    smooth_speed = np.gradient(smooth_angle, record.period_s) if speed.origin == "differentiated" else smoother.smooth(speed.values)
    return Motion(
        smoother.smooth(current_of(actuator, record)),
        smooth_speed,
        np.gradient(smooth_speed, record.period_s),
        smooth_angle,
        _scale_mm_per_rad(actuator) * angle.values,
        angle.origin != "integrated",
    )
