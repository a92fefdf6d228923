"""The moving plant between two control instants: rates of its state, and the events that change its equations.

Equations: docs/DESIGN.md, "One model step", parts 2 to 5. The state is an array: current, motor speed, motor angle, then
the memory of the effects. `Mode` says which equations hold; `settled` finds it for a state, `has_passed` says that a state
has left it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ema_tools.base.compiled import compiled
from reference_model import drive, gearbox, motor, screw, sites
from reference_model.point import Data, Point

CURRENT = 0
SPEED = 1
ANGLE = 2


class Mode(NamedTuple):
    """Which equations hold.

    `motion`: -1, 1 sliding, 0 at rest; `limit`: -1, 1 while the drive holds the current at its limit; `side`: -1, 1 while
    the motor pushes the output of the play; `play_mm`: that output while nothing pushes it; `end`: -1, 1 at that end of
    travel; `torque_saturation` and `load_positive`: the branches of torque and efficiency in use.
    """

    motion: int
    limit: int
    side: int
    play_mm: float
    end: int
    torque_saturation: int
    load_positive: bool


class Plant(NamedTuple):
    """What is constant while the plant moves; `part` is the actuator of `reference_model.actuator`, `data` what effects see of it."""

    part: Any
    lead_mm_per_rad: float
    inertia_kgm2: float
    data: Data


@compiled
def _at_current(point: Point, current_A: float) -> Point:
    """The same with another current."""
    return Point(
        current_A,
        point.speed_rad_s,
        point.angle_rad,
        point.motor_mm,
        point.voltage_V,
        point.data,
        point.direction,
        point.winding,
        point.grease,
    )


@compiled
def _algebraic_current_A(plant: Plant, supply: drive.Supply, point: Point) -> float:
    """Current of a winding without inductance, in balance with what effects take of the voltage (which falls with it)."""
    part = plant.part
    change = sites.motor_change(part.effects, point)
    free = supply.voltage_V - motor.back_emf_V(part.motor, point.speed_rad_s, change)
    resistance = part.motor.resistance_ohm * (1.0 + point.winding)
    lower = (free + sites.voltage_change_V(part.effects, _at_current(point, 0.0))) / resistance
    upper = (free + sites.voltage_change_V(part.effects, _at_current(point, lower))) / resistance
    for _ in range(80):
        if lower == upper:
            break
        middle = 0.5 * (lower + upper)
        excess = free + sites.voltage_change_V(part.effects, _at_current(point, middle)) - resistance * middle
        if (excess > 0.0) == (lower < upper):
            lower = middle
        else:
            upper = middle
    return drive.limited(part.drive, 0.5 * (lower + upper))


@compiled
def has_current_state(plant: Plant, supply: drive.Supply) -> bool:
    """Whether the current has a rate, or follows the voltage or its reference at once."""
    if supply.law == drive.MOTOR_LAW:
        return plant.part.motor.inductance_H > 0.0
    return supply.law == drive.LOOP_LAW


@compiled
def point_of(plant: Plant, supply: drive.Supply, state: np.ndarray) -> Point:
    """The state as effects see it, with the current in balance when it has no rate."""
    angle = state[ANGLE]
    winding = sites.winding_change(plant.part.effects, state)
    grease = sites.grease_change(plant.part.effects, state)
    point = Point(state[CURRENT], state[SPEED], angle, plant.lead_mm_per_rad * angle, supply.voltage_V, plant.data, 0.0, winding, grease)
    if has_current_state(plant, supply):
        return point
    current = drive.limited(plant.part.drive, supply.reference_A)
    if supply.law == drive.MOTOR_LAW:
        current = _algebraic_current_A(plant, supply, point)
    return _at_current(point, current)


@compiled
def _current_rate(plant: Plant, supply: drive.Supply, point: Point) -> float:
    """Rate of a current that the drive does not hold at its limit."""
    if supply.law == drive.LOOP_LAW:
        return (supply.reference_A - point.current_A) / plant.part.drive.current_loop_s
    voltage = supply.voltage_V + sites.voltage_change_V(plant.part.effects, point)
    voltage -= plant.part.motor.resistance_ohm * point.winding * point.current_A
    change = sites.motor_change(plant.part.effects, point)
    return motor.current_rate_A_per_s(plant.part.motor, voltage, point.current_A, point.speed_rad_s, change)


@compiled
def _load_Nm(plant: Plant, point: Point) -> float:
    return plant.part.screw.load_torque_Nm + sites.extra_load_Nm(plant.part.effects, point)


@compiled
def play_output(plant: Plant, mode: Mode, point: Point) -> tuple[float, float]:
    """Position in mm and speed in mm/s of the play's output."""
    position = screw.play_output_mm(plant.part.screw, point.motor_mm, mode.play_mm, mode.side)
    pushed = plant.part.screw.blk_mm == 0.0 or mode.side * mode.motion > 0
    return position, plant.lead_mm_per_rad * point.speed_rad_s if pushed else 0.0


@compiled
def _active_torque_Nm(plant: Plant, mode: Mode, point: Point, state: np.ndarray, load_Nm: float) -> float:
    """Every torque on the shaft but dry friction and the viscous one of the start's temperature."""
    play_mm, play_mm_s = play_output(plant, mode, point)
    effects = plant.part.effects
    reaction = sites.transmission_reaction_Nm(effects, state, play_mm, play_mm_s, 1e-3 * plant.lead_mm_per_rad)
    torque = motor.torque_Nm(plant.part.motor, point.current_A, sites.motor_change(effects, point))
    eased = plant.part.screw.viscous_Nm_s_per_rad * point.grease * point.speed_rad_s
    return torque - load_Nm + sites.extra_torque_Nm(effects, point) - eased + reaction


@compiled
def _friction_share(plant: Plant, mode: Mode, state: np.ndarray) -> float:
    """Part of the level of dry friction that acts against extension, -1 to 1."""
    if sites.is_elastic(plant.part.effects):
        return sites.contact_share(plant.part.effects, state)
    return float(mode.motion)


@compiled
def _towards(point: Point, direction: int) -> Point:
    """The same, asked for dry friction against that direction."""
    return Point(
        point.current_A,
        point.speed_rad_s,
        point.angle_rad,
        point.motor_mm,
        point.voltage_V,
        point.data,
        float(direction),
        point.winding,
        point.grease,
    )


@compiled
def _sliding_level_Nm(plant: Plant, point: Point, load_Nm: float, share: float) -> float:
    """Level of dry friction of a contact that slides, or is stretched, as the sign of `share` says."""
    part = plant.part
    direction = -1 if share < 0.0 else 1
    level = screw.level_Nm(part.screw, part.screw.dynamic_ratio * part.screw.csj_Nm, direction)
    change = sites.friction_change_Nm(part.effects, level, _towards(point, direction))
    return level * (1.0 + point.grease) + change + gearbox.friction_Nm(part.gearbox, load_Nm, direction)


@compiled
def rates(plant: Plant, supply: drive.Supply, mode: Mode, state: np.ndarray, out: np.ndarray) -> None:
    """Rates of the state, written to `out`."""
    part = plant.part
    point = point_of(plant, supply, state)
    out[CURRENT] = 0.0
    if mode.limit == 0 and has_current_state(plant, supply):
        out[CURRENT] = _current_rate(plant, supply, point)
    out[SPEED] = 0.0
    out[ANGLE] = 0.0
    if mode.motion != 0:
        load = _load_Nm(plant, point)
        share = _friction_share(plant, mode, state)
        friction = _sliding_level_Nm(plant, point, load, share)
        active = _active_torque_Nm(plant, mode, point, state, load)
        out[SPEED] = screw.acceleration_rad_s2(part.screw, plant.inertia_kgm2, active, point.speed_rad_s, friction, share)
        out[ANGLE] = point.speed_rad_s
        sites.contact_rates(part.effects, state, point.speed_rad_s, mode.motion, plant.lead_mm_per_rad, out)
    play_mm, play_mm_s = play_output(plant, mode, point)
    sites.transmission_rates(part.effects, state, play_mm, play_mm_s, out)
    heat = part.motor.resistance_ohm * (1.0 + point.winding) * point.current_A * point.current_A
    sites.warmth_rates(part.effects, state, heat, out)


@compiled
def _departure(plant: Plant, mode: Mode, point: Point, state: np.ndarray) -> int:
    """Direction in which a resting shaft breaks away now, or 0; a stretched contact only ever rests at an end of travel."""
    part = plant.part
    load = _load_Nm(plant, point)
    active = _active_torque_Nm(plant, mode, point, state, load)
    if sites.is_elastic(part.effects):
        share = sites.contact_share(part.effects, state)
        start = 1 if active >= share * _sliding_level_Nm(plant, point, load, share) else -1
        return 0 if start == mode.end else start
    start = 1 if active > 0.0 else -1
    level = screw.level_Nm(part.screw, part.screw.csj_Nm, start)
    static = level * (1.0 + point.grease) + sites.friction_change_Nm(part.effects, level, _towards(point, start))
    return screw.leaves_rest(active, static + gearbox.friction_Nm(part.gearbox, load, start), mode.end)


@compiled
def _limit_of(plant: Plant, supply: drive.Supply, mode: Mode, point: Point) -> int:
    """Whether the drive holds the current now: -1 or 1 at that limit, else 0."""
    limit = plant.part.drive.current_limit_A
    if limit == 0.0 or not has_current_state(plant, supply) or abs(point.current_A) < limit:
        return 0
    outward = 1 if point.current_A > 0.0 else -1
    rate = _current_rate(plant, supply, point) * outward
    if rate > 0.0 or (rate == 0.0 and mode.limit == outward):
        return outward
    return 0


@compiled
def has_passed(plant: Plant, supply: drive.Supply, mode: Mode, state: np.ndarray) -> bool:
    """Whether the state lies behind an event, so that other equations hold than those of `mode`."""
    point = point_of(plant, supply, state)
    part = plant.part
    if _limit_of(plant, supply, mode, point) != mode.limit:
        return True
    change = sites.motor_change(part.effects, point)
    if motor.saturation(part.motor, point.current_A, change) != mode.torque_saturation:
        return True
    if (_load_Nm(plant, point) > 0.0) != mode.load_positive:
        return True
    if mode.motion == 0:
        return _departure(plant, mode, point, state) != 0
    if point.speed_rad_s * mode.motion < 0.0 or screw.hits_end(part.screw, point.motor_mm, mode.motion):
        return True
    return mode.side != mode.motion and screw.play_contact(part.screw, point.motor_mm, mode.play_mm, mode.motion)


@compiled
def settled(plant: Plant, supply: drive.Supply, mode: Mode, state: np.ndarray) -> Mode:
    """The mode that holds from `state` on; a reversal or an end of travel stops the shaft in `state`.

    A contact that stretches lets the shaft reverse without a stop.
    """
    part = plant.part
    point = point_of(plant, supply, state)
    state[CURRENT] = point.current_A
    limit = _limit_of(plant, supply, mode, point)
    if limit != 0:
        state[CURRENT] = limit * part.drive.current_limit_A
    play_mm, _ = play_output(plant, mode, point)
    side = mode.side
    motion = mode.motion
    end = mode.end
    if motion != 0 and screw.hits_end(part.screw, point.motor_mm, motion):
        state[ANGLE] = motion * part.screw.travel_mm / plant.lead_mm_per_rad
        state[SPEED] = 0.0
        end = motion
        motion = 0
    elif motion != 0 and state[SPEED] * motion < 0.0:
        if sites.is_elastic(part.effects):
            motion = -motion
        else:
            state[SPEED] = 0.0
            motion = 0
    point = point_of(plant, supply, state)
    if motion == 0:
        motion = _departure(plant, Mode(0, limit, side, play_mm, end, 0, False), point, state)
    if motion != 0:
        end = 0
        if side != motion:
            side = motion if screw.play_contact(part.screw, point.motor_mm, play_mm, motion) else 0
    saturation = motor.saturation(part.motor, point.current_A, sites.motor_change(part.effects, point))
    return Mode(motion, limit, side, play_mm, end, saturation, _load_Nm(plant, point) > 0.0)
