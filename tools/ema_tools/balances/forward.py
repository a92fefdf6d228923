"""The forward solution of a machine whose controller is not known: the motion that the model makes under the measured drive.

Solved over short windows, each begun with the motion as it was measured there: over a whole record any error of the friction would add up to another place. Friction is taken by Moreau's
time stepping (J. J. Moreau, 1988): the speed at a step's end without dry friction, less at most what friction can take away, so that sticking needs no threshold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.balances.effects import acts, adjusted, transmission_of
from ema_tools.balances.mechanical import best_placed, known_torque_Nm, mechanical_model, quiet_smoother
from ema_tools.balances.motion import motion_of
from ema_tools.base.arrays import Integers, Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.plant.native import library

WINDOW_S = 0.5  # of a window: friction off by a tenth then moves the speed of a usual axis by a tenth [judgement]
_ROWS_MIN, _ROWS_MAX = 20, 1000  # of a window [effort]
_STEP_S = 2e-3  # of the solution; a shorter step of the record is taken as it is [precision]
_SWING = 0.3  # of a stretched contact: a step is at most this share of its period over 2 pi [precision]
_PROBE_RAD = 1e-4  # a turn that is short beside how far contacts stretch [precision]
_STEPS_MAX = 200  # in a row of the record; a stiffer contact is not solved [effort]


@dataclass(frozen=True)
class _Windows:
    """Where windows begin, [windows], and the rows of each; of the whole record the measured motion, drive, contact, known torque against extension and
    relative change of friction by temperature, [rows]."""

    begin: Integers
    rows: int
    drive_A: Reals
    against_Nm: Reals
    speed: Reals
    angle: Reals
    motor_mm: Reals
    contact: Reals
    eased: Reals


def forward_percent(actuator: Actuator, records: Sequence[AnyRecord]) -> float:
    """Error of the motor's speed in % of its rms, over all records; NaN where it cannot be solved: without the motion, behind a soft transmission, or with a contact that is too stiff."""
    squares = total = 0.0
    for record in records:
        try:
            found = _squares(actuator, record)
        except (MissingSignal, InputError):
            return math.nan
        if found is None:
            return math.nan
        squares, total = squares + found[0], total + found[1]
    return 100.0 * math.sqrt(squares / total) if total > 0.0 else math.nan


def _squares(actuator: Actuator, record: AnyRecord) -> tuple[float, float] | None:
    """Squares of the error and of the speed over all windows of one record; None where it cannot be solved."""
    if transmission_of(actuator):
        return None
    smoother = quiet_smoother(actuator, record)
    record = best_placed(actuator, record, smoother)
    motion = motion_of(actuator, record, smoother)
    model = mechanical_model(actuator, record, smoother, motion)
    values = adjusted(actuator)
    first, last = smoother.edge_rows, record.rows - smoother.edge_rows
    rows = min(max(math.ceil(WINDOW_S / record.period_s), _ROWS_MIN), _ROWS_MAX, last - first - 1)
    if rows < 2 or not values["screw.inertia_kgm2"] > 0.0:
        return None
    known = known_torque_Nm(actuator, record, smoother)
    begin = np.arange(first, last - rows, rows, dtype=np.int32)
    seen = _Windows(begin, rows, motion.current_A, known, motion.speed_rad_s, motion.angle_rad, motion.motor_mm, model.contact, model.eased)
    return _solved(actuator, seen, record.period_s)


def _solved(actuator: Actuator, seen: _Windows, period_s: float) -> tuple[float, float] | None:
    """All windows at once."""
    values, arrays = adjusted(actuator), actuator.arrays()
    inertia, viscous = values["screw.inertia_kgm2"], values["screw.viscous_Nm_s_per_rad"]
    static, ratio, asymmetry = values["screw.csj_Nm"], values["screw.dynamic_ratio"], values["screw.friction_asymmetry"]
    constant, limit, efficiency = values["motor.torque_constant_Nm_per_A"], values["motor.torque_limit_Nm"], values["gearbox.efficiency"]
    stretches = acts(actuator, "PRESLIDING")
    steps = max(1, math.ceil(period_s / _STEP_S))
    if stretches:
        swing = math.sqrt(inertia / max(static * ratio * _slope_per_rad(actuator), 1e-12))
        steps = max(steps, math.ceil(period_s / (_SWING * swing)))
        if steps > _STEPS_MAX:
            return None
    step = period_s / steps
    begin = seen.begin
    speed, angle = seen.speed[begin].copy(), seen.angle[begin].copy()
    offset_mm = seen.motor_mm[begin] - _per_rad(actuator) * angle
    contact = seen.contact[begin].copy()
    active = {site: acts(actuator, site) for site in ("MOTOR", "TORQUE", "LOAD", "FRICTION")}

    none = np.zeros(begin.size)

    def at(site: str, current: Reals, moving: Reals, level: Reals = none, side: Reals = none) -> Reals:
        if not active[site]:
            return np.zeros_like(current)
        points = np.stack([current, moving, angle, _per_rad(actuator) * angle + offset_mm, np.zeros_like(current), level, side])
        return np.asarray(library().site(*arrays, site, points))

    squares = total = 0.0
    damping = 1.0 + step * viscous / inertia
    for row in range(seen.rows):
        measured = seen.speed[begin + row]
        squares, total = squares + float(np.sum((speed - measured) ** 2)), total + float(np.sum(measured**2))
        for part in range(steps):
            share = (part + 0.5) / steps
            current = (1.0 - share) * seen.drive_A[begin + row] + share * seen.drive_A[begin + row + 1]
            known = (1.0 - share) * seen.against_Nm[begin + row] + share * seen.against_Nm[begin + row + 1]
            drive = constant * (1.0 + at("MOTOR", current, speed)) * current
            if limit > 0.0:
                drive = np.clip(drive, -limit, limit)
            passed = at("LOAD", current, speed) + values["screw.load_torque_Nm"]
            eased = seen.eased[begin + row]
            net = drive + at("TORQUE", current, speed) - passed - known - eased * viscous * speed
            free = (speed + step / inertia * net) / damping
            side = np.sign(contact) if stretches else np.where(speed != 0.0, np.sign(speed), np.sign(free))
            level = static * np.where((speed != 0.0) | stretches, ratio, 1.0) * (1.0 + asymmetry * side)
            level = level * (1.0 + eased) + at("FRICTION", current, speed, level, side)
            level = level + np.where(passed * side > 0.0, 1.0 / efficiency - 1.0, 1.0 - efficiency) * np.abs(passed)
            most = step / inertia * np.maximum(level, 0.0) / damping
            if stretches:
                speed = free - most * contact
                angle = angle + step * speed
                contact = library().contact_after(*arrays, contact, step * speed)
            else:
                speed = np.where(np.abs(free) <= most, 0.0, free - np.sign(free) * most)
                angle = angle + step * speed
    return (squares, total) if math.isfinite(squares) else None


def _slope_per_rad(actuator: Actuator) -> float:
    """How fast a contact that carries half of the friction takes up more of it, or less, per turn."""
    half = library().contact_after(*actuator.arrays(), np.full(2, 0.5), np.array([-_PROBE_RAD, _PROBE_RAD]))
    return float(half[1] - half[0]) / (2.0 * _PROBE_RAD)


def _per_rad(actuator: Actuator) -> float:
    return float(actuator.values["screw.lead_mm"] / (2.0 * math.pi * actuator.values["gearbox.ratio"]))
