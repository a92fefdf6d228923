"""Four balances, each from measured signals and one group of blocks, so that its residual accuses that group.

mechanical: kt i - (J dw/dt + D w + F sgn w + load); electrical: u - (R i + L di/dt + ke w); kinematic: rod position - play of the motor
position; controller: applied command - control law of command and feedback. What the actuator's enabled effects add is part of the model side.

Every channel of the first two passes the same zero-phase Butterworth filter of fourth order before differences are taken, edges are dropped, and
the result is decimated to the filter's band; samples near zero speed are masked where the sign of the speed matters. On the record of a real ball-screw
axis this reproduces the published force error: A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, 2019.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ema_tools.actuator import Actuator
from ema_tools.definitions import load_definitions
from ema_tools.errors import MissingSignal
from ema_tools.native import Reals
from ema_tools.records import Record

BALANCES = ("mechanical", "electrical", "kinematic", "controller")
# Rows at both ends that carry the filters' edges: 50 at 1 kHz.
EDGE_S = 0.05
# Samples below this share of the largest speed are masked: their direction of friction is not known.
SLOW_SHARE = 0.01
_ORDER = 4
_RATE_OVER_CUTOFF = 10
_CUTOFF_MAX_HZ = 100.0


@dataclass(frozen=True)
class Smoother:
    """The zero-phase filter of all channels and the decimation behind it."""

    period_s: float
    cutoff_hz: float

    @staticmethod
    def of(period_s: float) -> Smoother:
        """The usual one: a tenth of the sample rate, at most 100 Hz."""
        return Smoother(period_s, min(_CUTOFF_MAX_HZ, 1.0 / (_RATE_OVER_CUTOFF * period_s)))

    @property
    def every(self) -> int:
        """Rows per decimated sample: its rate is the filter's cutoff."""
        return max(1, round(1.0 / (self.cutoff_hz * self.period_s)))

    @property
    def edge_rows(self) -> int:
        """Rows dropped at each end."""
        return max(1, round(EDGE_S / self.period_s))

    def smooth(self, values: Reals) -> Reals:
        """Filtered forward and backward, [rows]."""
        sections = signal.butter(_ORDER, 2.0 * self.cutoff_hz * self.period_s, output="sos")
        return np.asarray(signal.sosfiltfilt(sections, values))

    def decimated(self, values: Reals) -> Reals:
        """Edges dropped, then low-passed below the new rate and every n-th row kept, [samples]."""
        inner = values[self.edge_rows - 1 : values.size - self.edge_rows + 1]
        if self.every == 1:
            return inner
        sections = signal.cheby1(8, 0.05, 0.8 / self.every, output="sos")
        return np.asarray(signal.sosfiltfilt(sections, inner))[self._first(inner.size) :: self.every]

    def _first(self, rows: int) -> int:
        return self.every - (self.every * math.ceil(rows / self.every) - rows) - 1

    def kept(self, values: NDArray[Any]) -> NDArray[Any]:
        """The rows at which `decimated` has its samples, without filtering, [samples]."""
        inner = values[self.edge_rows - 1 : values.size - self.edge_rows + 1]
        return inner[self._first(inner.size) :: self.every]


@dataclass(frozen=True)
class Motion:
    """Motor signals on every row: current A, speed rad/s, acceleration rad/s2, angle rad, all smoothed; and the unsmoothed motor position mm."""

    current_A: Reals
    speed_rad_s: Reals
    acceleration_rad_s2: Reals
    angle_rad: Reals
    motor_mm: Reals


@dataclass(frozen=True)
class Balance:
    """One balance on its samples: measured side, residual (both [samples], in `unit`), time, and which samples count."""

    name: str
    unit: str
    time_s: Reals
    measured: Reals
    residual: Reals
    used: NDArray[np.bool_]

    @property
    def rms(self) -> float:
        """Root mean square of the residual over the used samples."""
        return float(np.sqrt(np.mean(self.residual[self.used] ** 2)))

    @property
    def relative_percent(self) -> float:
        """100 * norm of the residual / norm of the measured side, over the used samples; NaN when nothing was measured."""
        size = float(np.linalg.norm(self.measured[self.used]))
        return 100.0 * float(np.linalg.norm(self.residual[self.used])) / size if size > 0.0 else math.nan

    @property
    def masked_percent(self) -> float:
        """Share of the samples near zero speed that do not count."""
        return 100.0 * float(1.0 - np.mean(self.used))


def adjusted(actuator: Actuator) -> dict[str, float]:
    """The values with the enabled PARAMETER effects in them, by name."""
    from ema_tools.reference.actuator import build
    from ema_tools.reference.effects import module_of

    values = dict(actuator.values)
    for effect in load_definitions().effects:
        if effect.site == "PARAMETER" and effect.name in actuator.active_effects:
            values.update(module_of(effect.name).change_values(getattr(build(values).effects, effect.name), values))
    return values


def _function_sum(actuator: Actuator, site: str, call: Callable[[Any, Any], float]) -> float:
    from ema_tools.reference.actuator import build
    from ema_tools.reference.effects import module_of

    effects = build(actuator.values).effects
    active = (effect.name for effect in load_definitions().effects if effect.site == site and effect.name in actuator.active_effects)
    return sum(call(module_of(name), getattr(effects, name)) for name in active)


def _at_points(actuator: Actuator, motion: Motion, site: str, call: Callable[[Any, Any, Any], float]) -> Reals:
    """Sum over the active effects of a site, on every row; zeros at no cost when there are none."""
    rows = motion.speed_rad_s.size
    sites = {effect.name: effect.site for effect in load_definitions().effects}
    if not any(sites[name] == site for name in actuator.active_effects):
        return np.zeros(rows)
    from ema_tools.reference.point import Point

    columns = (motion.current_A, motion.speed_rad_s, motion.angle_rad, motion.motor_mm)
    points = (Point(float(i), float(w), float(a), float(x), 0.0) for i, w, a, x in zip(*columns, strict=True))
    return np.array([_function_sum(actuator, site, lambda module, effect, point=point: call(module, effect, point)) for point in points])


def drive_current(actuator: Actuator, record: Record) -> Reals:
    """The motor current, [rows]: as recorded, or from the command of an ideal current drive.

    Raises MissingSignal.
    """
    if record.current_A is not None:
        return record.current_A
    ideal = actuator["drive.mode"] == 1.0 and actuator["drive.current_loop_s"] == 0.0 and actuator["drive.command_scale_V"] > 0.0
    if ideal and record.voltage_V is not None:
        return record.voltage_V * (actuator["drive.current_scale_A"] / actuator["drive.command_scale_V"])
    raise MissingSignal("current_A is not recorded")


def motor_position(actuator: Actuator, record: Record) -> Reals:
    """The motor position at the rod in mm, [rows]; the rod's own where nothing lies between them. Raises MissingSignal."""
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    if actuator["screw.blk_mm"] == 0.0 and not _transmission(actuator):
        return (record.position_mm - actuator["encoder.rod_offset_mm"]) / (1.0 + actuator["encoder.rod_gain_error"])
    raise MissingSignal("motor_position_mm is not recorded, and the rod follows the motor with play")


def _transmission(actuator: Actuator) -> str:
    for effect in load_definitions().effects:
        if effect.site == "TRANSMISSION" and effect.name in actuator.active_effects:
            return effect.name
    return ""


def motion_of(actuator: Actuator, record: Record, smoother: Smoother) -> Motion:
    """Smoothed motor signals. Raises MissingSignal."""
    motor_mm = motor_position(actuator, record)
    angle = smoother.smooth(motor_mm) / actuator.lead_mm_per_rad
    speed = np.gradient(angle, record.period_s)
    return Motion(smoother.smooth(drive_current(actuator, record)), speed, np.gradient(speed, record.period_s), angle, motor_mm)


def friction_level_Nm(actuator: Actuator, motion: Motion) -> Reals:
    """What is added to the level of sliding friction by effects, on every row."""
    level = actuator["screw.dynamic_ratio"] * actuator["screw.csj_Nm"]
    return _at_points(actuator, motion, "FRICTION", lambda module, effect, point: module.level_change_Nm(effect, level, point))


@dataclass(frozen=True)
class Mechanical:
    """The mechanical balance as a linear model on decimated samples: drive = known + columns @ parameters.

    columns: acceleration (inertia), speed (viscous), direction (level of sliding friction), one (load against extension).
    """

    drive_Nm: Reals
    known_Nm: Reals
    columns: Reals
    time_s: Reals
    used: NDArray[np.bool_]


MECHANICAL_PARAMETERS = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", "screw.load_torque_Nm")
ELECTRICAL_PARAMETERS = ("motor.resistance_ohm", "motor.inductance_H", "motor.back_emf_V_s_per_rad")


def mechanical_model(actuator: Actuator, record: Record, smoother: Smoother) -> Mechanical:
    """Drive torque, what the effects add, and the columns of the base parameters. Raises MissingSignal."""
    transmission = _transmission(actuator)
    if transmission:
        raise MissingSignal(f"{transmission} moves the rod on its own, which no recorded signal shows")
    values = adjusted(actuator)
    motion = motion_of(actuator, record, smoother)
    drive = values["motor.torque_constant_Nm_per_A"] * motion.current_A
    if values["motor.torque_limit_Nm"] > 0.0:
        drive = np.clip(drive, -values["motor.torque_limit_Nm"], values["motor.torque_limit_Nm"])
    direction = np.sign(motion.speed_rad_s)
    load = _at_points(actuator, motion, "LOAD", lambda module, effect, point: module.load_Nm(effect, point))
    passed = load + values["screw.load_torque_Nm"]
    efficiency = values["gearbox.efficiency"]
    loss = np.where(passed * direction > 0.0, 1.0 / efficiency - 1.0, 1.0 - efficiency) * np.abs(passed)
    torque = _at_points(actuator, motion, "TORQUE", lambda module, effect, point: module.torque_Nm(effect, point))
    known = load - torque + (loss + friction_level_Nm(actuator, motion)) * direction
    columns = (motion.acceleration_rad_s2, motion.speed_rad_s, direction, np.ones_like(direction))
    slow = SLOW_SHARE * float(np.max(np.abs(smoother.kept(motion.speed_rad_s)), initial=0.0))
    speed = smoother.decimated(motion.speed_rad_s)
    return Mechanical(
        drive_Nm=smoother.decimated(drive),
        known_Nm=smoother.decimated(known),
        columns=np.column_stack([smoother.decimated(column) for column in columns]),
        time_s=smoother.kept(record.time_s),
        used=(np.abs(speed) >= slow) & (slow > 0.0),
    )


def mechanical(actuator: Actuator, record: Record, smoother: Smoother) -> Balance:
    """Drive torque minus what the mechanics need, Nm at the motor shaft. Raises MissingSignal."""
    model = mechanical_model(actuator, record, smoother)
    values = adjusted(actuator)
    sliding = values["screw.dynamic_ratio"] * values["screw.csj_Nm"]
    parameters = (values["screw.inertia_kgm2"], values["screw.viscous_Nm_s_per_rad"], sliding, values["screw.load_torque_Nm"])
    residual = model.drive_Nm - model.known_Nm - model.columns @ np.array(parameters)
    if not model.used.any():
        raise MissingSignal("the motor does not move")
    return Balance("mechanical", "Nm", model.time_s, model.drive_Nm, residual, model.used)


@dataclass(frozen=True)
class Electrical:
    """The electrical balance as a linear model at the middles of the rows' intervals: voltage + known = columns @ (R, L, ke)."""

    voltage_V: Reals
    known_V: Reals
    columns: Reals
    time_s: Reals


def electrical_model(actuator: Actuator, record: Record, smoother: Smoother) -> Electrical:
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
    known = _at_points(actuator, middle, "VOLTAGE", lambda module, effect, point: module.voltage_change_V(effect, point))

    def kept(values: Reals) -> Reals:
        return smoother.decimated(smoother.smooth(values))

    return Electrical(
        voltage_V=kept(record.voltage_V[:-1]),
        known_V=kept(known),
        columns=np.column_stack([kept(current), kept(rate), kept(speed)]),
        time_s=smoother.kept(record.time_s[:-1] + 0.5 * period),
    )


def electrical(actuator: Actuator, record: Record, smoother: Smoother) -> Balance:
    """Motor voltage minus what winding and back-EMF need, V. Raises MissingSignal."""
    model = electrical_model(actuator, record, smoother)
    values = adjusted(actuator)
    residual = model.voltage_V + model.known_V - model.columns @ np.array([values[name] for name in ELECTRICAL_PARAMETERS])
    return Balance("electrical", "V", model.time_s, model.voltage_V, residual, np.ones(residual.size, dtype=bool))


def played(motor_mm: Reals, width_mm: float, start_mm: float) -> Reals:
    """Output of a play of full width `width_mm` that follows `motor_mm` [rows], from `start_mm`."""
    half = 0.5 * width_mm
    out = np.empty_like(motor_mm)
    position = start_mm
    for row, motor in enumerate(motor_mm.tolist()):
        position = min(max(position, motor - half), motor + half)
        out[row] = position
    return out


def kinematic(actuator: Actuator, record: Record, smoother: Smoother) -> Balance:
    """Rod position minus the motor position behind the play, mm. Raises MissingSignal."""
    if record.motor_position_mm is None:
        raise MissingSignal("motor_position_mm is not recorded")
    transmission = _transmission(actuator)
    if transmission:
        raise MissingSignal(f"{transmission} moves the rod on its own; compare position_mm instead")
    values = adjusted(actuator)
    gain, offset = 1.0 + values["encoder.rod_gain_error"], values["encoder.rod_offset_mm"]
    rod = played(record.motor_position_mm, values["screw.blk_mm"], (record.start_mm - offset) / gain)
    inner = slice(smoother.edge_rows, -smoother.edge_rows)
    residual = (record.position_mm - (gain * rod + offset))[inner]
    return Balance("kinematic", "mm", record.time_s[inner], record.position_mm[inner], residual, np.ones(residual.size, dtype=bool))


def feedback_of(actuator: Actuator, record: Record) -> Reals:
    """The position that the loop is closed on, as recorded, mm [rows]. Raises MissingSignal."""
    if actuator["encoder.side"] == 1.0:
        return record.position_mm
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    raise MissingSignal("motor_position_mm is not recorded, and the loop is closed on the motor encoder")


def controller_output(values: Mapping[str, float], command_mm: Reals, feedback_mm: Reals) -> Reals:
    """Normalised output of the control law for measured command and feedback, both [rows], one row per record period.

    Raises MissingSignal when the control law runs between the rows.
    """
    from ema_tools.reference import encoder, pid
    from ema_tools.reference.actuator import build

    part = build(values)
    row_steps = part.timing.record_every_steps
    if part.control.every_steps % row_steps:
        raise MissingSignal("the control law runs between the recorded rows")
    if row_steps > 1 and part.encoder.delay_s > 0.0:
        raise MissingSignal("the feedback's delay needs a row at every model step")
    every_rows = part.control.every_steps // row_steps
    period_s = part.control.every_steps * part.timing.step_s
    history = np.ascontiguousarray(feedback_mm)
    state = pid.at_rest()
    out = np.empty(history.size)
    for row, command in enumerate(command_mm.tolist()):
        if row % every_rows == 0:
            seen = encoder.feedback_mm(part.encoder, part.timing.step_s, history, row)
            state = pid.run(part.control, period_s, 1e-3 * command, 1e-3 * seen, state)
        out[row] = state.output
    return out


def controller(actuator: Actuator, record: Record, smoother: Smoother) -> Balance:
    """Applied command minus the control law of measured command and feedback, in V. Raises MissingSignal."""
    if record.voltage_V is None:
        raise MissingSignal("voltage_V is not recorded")
    values = adjusted(actuator)
    if actuator["drive.mode"] == 1.0:
        scale = values["drive.command_scale_V"]
        if not scale > 0.0:
            raise MissingSignal("the drive's command is not recorded, only the motor's voltage")
    else:
        scale = values["drive.supply_V"]
    output = controller_output(values, record.command_mm, feedback_of(actuator, record))
    inner = slice(smoother.edge_rows, -smoother.edge_rows)
    residual = (record.voltage_V - scale * output)[inner]
    return Balance("controller", "V", record.time_s[inner], record.voltage_V[inner], residual, np.ones(residual.size, dtype=bool))


def all_balances(actuator: Actuator, record: Record, smoother: Smoother | None = None) -> dict[str, Balance | str]:
    """Every balance by name: a `Balance`, or in one sentence why it cannot be had."""
    use = smoother or Smoother.of(record.period_s)
    found: dict[str, Balance | str] = {}
    for name, make in zip(BALANCES, (mechanical, electrical, kinematic, controller), strict=True):
        try:
            found[name] = make(actuator, record, use)
        except MissingSignal as missing:
            found[name] = str(missing)
    return found
