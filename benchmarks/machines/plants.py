"""Machines of many kinds under controllers of their own, which share nothing with the module, its reference or the truth plant.

One shaft with bristle friction (C. Canudas de Wit et al., "A new model for control of systems with friction", IEEE Trans. Automatic Control 40(3), 1995) whose bump falls as 1 / (1 + (w/w0)^2),
where the library has an exponential; waves with a second harmonic, where the library has pure sines. A speed loop drives it that no record tells of. Fixed steps of 20 us.
With a play there are two masses, and a damped spring at either end of the gap, where the library has friction's share alone. Friction that differs by place rises in one step along the
stroke, where the library has a table of waves. Every drive records its torque behind a filter of its own, up to two milliseconds late.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.compiled import compiled
from ema_tools.data.motion_records import MotionRecord

STEP_S = 2e-5
_BRISTLE_RAD = 5e-4  # how far the contact yields before it slides
_HARMONIC = 0.15  # of a wave, beside it
_SECOND = 1.3  # its phase, over that of the wave
_BUMP = 0.04  # of the fastest, speed at which friction's bump has halved
NOISE_SHARE = 0.02  # of the kind's friction, standard deviation of the drive's noise


@dataclass(frozen=True)
class Kind:
    """A kind of machine at its motor shaft, and what its drive records. `mm_per_rad`: of the rod, 0 for a bare motor; `stroke_rad`: as far as it may go to both sides, 0 for any."""

    inertia_kgm2: float
    friction_Nm: float
    viscous_Nm_s_per_rad: float
    fastest_rad_s: float
    stroke_rad: float
    mm_per_rad: float
    ratio: float
    constant_Nm_per_A: float
    motion: str
    drive: str
    period_s: float
    arm_Nm: float = 0.0
    periods: float = 1.0


KINDS: Mapping[str, Kind] = {
    "bare motor": Kind(6e-5, 0.02, 8e-5, 120.0, 0.0, 0.0, 1.0, 0.05, "motor_angle_rad", "torque_Nm", 1e-3, periods=6),
    "belt": Kind(8e-4, 0.25, 2e-3, 60.0, 60.0, 60.0 / (2.0 * math.pi * 3.0), 3.0, 0.3, "position_mm", "force_N", 2e-3, periods=4),
    "lead screw": Kind(2e-6, 0.003, 3e-5, 25.0, 0.0, 2.0 / (2.0 * math.pi), 1.0, 0.02, "motor_speed_rad_s", "torque_Nm", 5e-3),
    "ball screw": Kind(3e-5, 0.05, 3e-4, 100.0, 90.0, 5.0 / (2.0 * math.pi), 1.0, 0.1, "position_mm", "current_A", 1e-3, periods=2),
    "joint with an arm": Kind(
        2e-4, 0.06, 6e-4, 80.0, 120.0, 0.0, 100.0, 0.09, "motor_angle_rad", "current_A", 1e-3, arm_Nm=0.05, periods=3
    ),
    "linear motor": Kind(2e-4, 0.02, 3e-4, 80.0, 90.0, 30.0 / (2.0 * math.pi), 1.0, 0.3, "position_mm", "force_N", 5e-4, periods=2),
}
# What is hidden: its medium size as a share of what it acts on, and whether records of every kind show it.
EFFECTS: Mapping[str, float] = {
    "constant_load": 0.15,
    "coulomb_asymmetry": 0.1,
    "viscous_asymmetry": 0.25,
    "quadratic_viscous": 0.3,
    "stribeck_friction": 0.25,
    "cogging_torque": 0.1,
    "torque_ripple": 0.05,
    "spring_load": 0.2,
    "elastic_backlash": 0.02,
    "position_friction": 0.2,
}
# In which a place and a rod are needed.
_PLACED = ("spring_load", "elastic_backlash", "position_friction")
_STEP_AT, _STEP_WIDTH = 0.2, 0.15  # of the stroke, where friction that differs by place rises
BEHIND = 0.3  # share of the inertia that is behind a play
_CONTACT = 0.4  # of the gap: how far its ends yield under the friction
_DAMPED = 0.3  # of their critical damping
SCATTER: Mapping[str, float] = {"friction": 0.02, "viscous": 0.04}  # from record to record, standard deviation relative
COMMANDS = ("steady speeds", "sweeps", "start and stop", "pick and place")


def shows(kind: str, effect: str, command: str) -> bool:
    """Whether such records can show an effect: a spring needs a place and a rod, friction's bump slow motion, and a machine that stands at one speed shows no wave of another."""
    one = KINDS[kind]
    if effect in _PLACED:
        return one.motion == "position_mm" and (command != "steady speeds" or effect == "position_friction")
    return True


@dataclass(frozen=True)
class Machine:
    """One unit of a kind with what is hidden in it, by effect as a share. `changed`: what has become of its own numbers, `constant` of the motor's among them, as shares too."""

    kind: str
    number: int
    hidden: Mapping[str, float]
    changed: Mapping[str, float] = field(default_factory=dict)

    def values(self) -> dict[str, float]:
        """Its own numbers, which differ from the kind's as units do."""
        random = np.random.default_rng([7_919, list(KINDS).index(self.kind), self.number])
        one = KINDS[self.kind]
        return {
            "inertia": one.inertia_kgm2 * float(random.uniform(0.95, 1.05)),
            "friction": one.friction_Nm * float(random.uniform(0.8, 1.2)),
            "viscous": one.viscous_Nm_s_per_rad * float(random.uniform(0.7, 1.3)),
            "phase": float(random.uniform(0.0, 2.0 * math.pi)),
            "gain": float(random.uniform(0.6, 1.6)),
            "lag_s": float(random.uniform(0.0, 2e-3)),
        }


@compiled
def _run(speed_rad_s: Reals, start_rad: float, own: Reals, every: int) -> Reals:
    """Angle, speed and the drive's torque at every record's row, as it is and as it is recorded, [4, rows], under a speed asked for at every step."""
    inertia, level, viscous, kp, ki, limit, load, asym, vasym, quad, rise, bump = own[:12]
    cog, ripple, periods, phase, spring, arm, ratio, gap, placed, stroke, lag_s = own[12:]
    bristle = level / _BRISTLE_RAD
    damping = 2.0 * 0.4 * np.sqrt(bristle * inertia)
    rows = speed_rad_s.size // every
    found = np.zeros((4, rows))
    shown = 0.0
    angle, speed, z, integral = start_rad, 0.0, 0.0, 0.0
    behind, behind_speed = start_rad, 0.0
    stiffness = level / (_CONTACT * gap) if gap > 0.0 else 0.0
    damper = 2.0 * _DAMPED * np.sqrt(stiffness * BEHIND * inertia)
    for step in range(rows * every):
        error = speed_rad_s[step] - speed
        torque = kp * error + ki * integral
        if abs(torque) < limit:
            integral += STEP_S * error
        torque = min(max(torque, -limit), limit)
        shown += (torque - shown) * STEP_S / (lag_s + STEP_S)
        if step % every == 0:
            row = step // every
            found[0, row], found[1, row], found[2, row], found[3, row] = angle, speed, torque, shown
        # with a play the friction holds the second mass, which the shaft meets at the ends of it
        held = behind_speed if gap > 0.0 else speed
        side = 1.0 if held > 0.0 else -1.0
        slides = level * (1.0 + rise / (1.0 + (held / bump) ** 2)) * (1.0 + asym * side)
        if placed > 0.0:
            slides *= 1.0 + placed * np.tanh((angle / stroke - _STEP_AT) / _STEP_WIDTH)
        # implicit in the bristle, which settles within a fraction of a step at speed
        bent = (z + STEP_S * held) / (1.0 + STEP_S * abs(held) * bristle / slides)
        friction = bristle * bent + damping * (bent - z) / STEP_S
        z = bent
        if gap > 0.0:
            pressed = abs(angle - behind) - 0.5 * gap
            force = 0.0
            if pressed > 0.0:
                end = 1.0 if angle > behind else -1.0
                force = end * max(stiffness * pressed + end * damper * (speed - behind_speed), 0.0)
            speed += STEP_S * (torque - viscous * speed - force) / ((1.0 - BEHIND) * inertia)
            behind_speed += STEP_S * (force - friction) / (BEHIND * inertia)
            angle += STEP_S * speed
            behind += STEP_S * behind_speed
            continue
        wave = np.sin(periods * angle + phase) + _HARMONIC * np.sin(2.0 * periods * angle + _SECOND * phase)
        against = friction + viscous * speed + viscous * vasym * abs(speed) + quad * speed * abs(speed)
        against += load + spring * angle + arm * np.sin(angle / ratio)
        speed += STEP_S * (torque * (1.0 + ripple * wave) - cog * wave - against) / inertia
        angle += STEP_S * speed
    return found


def _moves(one: Kind, command: str, number: int, random: np.random.Generator) -> Reals:
    """The speed asked for at every step."""
    fast = one.fastest_rad_s
    if command == "steady speeds":
        speed = fast * (0.03, 0.08, 0.15, 0.3, 0.55, 1.0)[number // 2] * (1.0 if number % 2 == 0 else -1.0)
        return np.full(round(_seconds(one, abs(speed)) / STEP_S), speed)
    time_s = np.arange(round(10.0 / STEP_S)) * STEP_S
    if command == "sweeps":
        first, last = 0.2, 2.0 + 0.7 * number
        amplitude = fast * (0.5 + 0.15 * number)
        return np.asarray(amplitude * np.sin(2.0 * math.pi * (first * time_s + 0.5 * (last - first) * time_s**2 / 10.0)))
    legs, total = [], 0.0
    ramp_s = 0.15 if command == "pick and place" else 0.4
    side = 1.0
    while total < 10.0:
        top = fast * float(random.uniform(0.1, 1.0))
        hold_s = float(random.uniform(0.1, 0.6)) if one.stroke_rad == 0.0 else min(0.6, 0.8 * one.stroke_rad / top)
        up = np.linspace(0.0, 1.0, round(ramp_s / STEP_S))
        rest = np.zeros(round((0.1 if command == "pick and place" else 0.4) / STEP_S))
        there = np.concatenate([up, np.ones(round(hold_s / STEP_S)), up[::-1], rest])
        legs += [side * top * there, -side * top * there] if command == "pick and place" else [side * top * there]
        side = -side
        total += (1 + (command == "pick and place")) * there.size * STEP_S
    return np.concatenate(legs)


def _seconds(one: Kind, speed: float) -> float:
    """Long enough for some turns, short enough for the stroke."""
    wanted = min(max(8.0 * 2.0 * math.pi / speed, 2.0), 20.0)
    return wanted if one.stroke_rad == 0.0 else min(wanted, 2.0 * one.stroke_rad / speed)


def records(machine: Machine, command: str) -> list[MotionRecord]:
    """What its drive records: three records of a command, or twelve at steady speeds."""
    return [_record(machine, command, number, _own(machine)) for number in range(_count(command))]


def records_of_day(machine: Machine, command: str, day: int) -> list[MotionRecord]:
    """The same on one of several days, from 1 on: other noise, other places and times of what is moved by chance, and friction and drag that differ from record to record."""
    found = []
    for number in range(_count(command)):
        random = np.random.default_rng([15_487_469, list(KINDS).index(machine.kind), machine.number, COMMANDS.index(command), day, number])
        changed = dict(machine.changed)
        for name, scatter in SCATTER.items():
            changed[name] = (1.0 + changed.get(name, 0.0)) * (1.0 + scatter * float(random.normal())) - 1.0
        here = replace(machine, changed=changed)
        angle, speed, _, torque = _happened(here, command, number, _own(here), random)
        found.append(_measured(KINDS[machine.kind], here, angle, speed, torque, f"{command}, day {day}, {number + 1}", random))
    return found


def torques(machine: Machine, command: str) -> list[Mapping[str, Reals]]:
    """What happened in those records, without noise: angle_rad, speed_rad_s and the drive's torque_Nm of each, [rows]."""
    names = ("angle_rad", "speed_rad_s", "torque_Nm")
    return [
        dict(zip(names, _happened(machine, command, number, _own(machine), _random(machine, command, number))[:3], strict=True))
        for number in range(_count(command))
    ]


def columns_of(machine: Machine, motion: Mapping[str, Reals], effect: str) -> Reals:
    """The drive's torque per unit of an effect's share along a motion, [rows, 1], or per unit of a wave's sine and cosine parts, [rows, 2], the part that is in the machine first;
    of no effect that of the base values, [rows, 3]."""
    one, own = KINDS[machine.kind], machine.values()
    angle, speed = motion["angle_rad"], motion["speed_rad_s"]
    if not effect:
        return np.column_stack([np.gradient(speed, one.period_s), speed, np.sign(speed)])
    share = machine.hidden.get("elastic_backlash", 0.0)
    level, phase, turned = own["friction"], own["phase"], one.periods * angle
    second = _HARMONIC * np.sin(2.0 * turned + _SECOND * phase)
    waves = np.column_stack([np.sin(turned + phase) + second, np.cos(turned + phase)])
    if effect == "cogging_torque":
        return np.asarray(level * waves)
    if effect == "torque_ripple":
        return np.asarray(-motion["torque_Nm"][:, None] * waves)
    single: Mapping[str, Reals] = {
        "constant_load": np.full_like(speed, level),
        "coulomb_asymmetry": level * np.sign(speed) ** 2,
        "viscous_asymmetry": own["viscous"] * np.abs(speed),
        "quadratic_viscous": level * speed * np.abs(speed) / one.fastest_rad_s**2,
        "stribeck_friction": level * np.sign(speed) / (1.0 + (speed / (_BUMP * one.fastest_rad_s)) ** 2),
        "spring_load": level * angle / (one.stroke_rad or 1.0),
        "position_friction": level * np.sign(speed) * np.tanh((angle / (one.stroke_rad or 1.0) - _STEP_AT) / _STEP_WIDTH),
        "elastic_backlash": _relieved(angle, speed, level, share * one.stroke_rad) / (share or 1.0),
    }
    return np.asarray(single[effect][:, None])


def _relieved(angle: Reals, speed: Reals, level: float, gap: float) -> Reals:
    """Change of the friction where it is behind a play of `gap` without mass, [rows]."""
    if gap == 0.0:
        return np.zeros_like(angle)
    most = (0.5 + _CONTACT) * gap
    ahead, found = np.zeros_like(angle), 0.0
    for row, turn in enumerate(np.diff(angle, prepend=angle[0]).tolist()):
        found = min(max(found + turn, -most), most)
        ahead[row] = found
    carried = np.sign(ahead) * np.maximum(np.abs(ahead) - 0.5 * gap, 0.0) / (_CONTACT * gap)
    return np.asarray(level * (carried - np.sign(speed)))


def _count(command: str) -> int:
    return 12 if command == "steady speeds" else 3


def _own(machine: Machine) -> Reals:
    """The numbers of a machine as `_run` takes them."""
    one, values = KINDS[machine.kind], machine.values()
    hidden, level = machine.hidden, values["friction"]
    limit = 8.0 * level + 2.0 * one.arm_Nm
    today = {name: 1.0 + machine.changed.get(name, 0.0) for name in ("inertia", "friction", "viscous")}
    # a loop that a twentieth of the largest speed of error makes overcome the friction
    stiffness = values["gain"] * max(60.0 * values["inertia"], level / (0.05 * one.fastest_rad_s))
    return np.array(
        [
            today["inertia"] * values["inertia"],
            today["friction"] * level,
            today["viscous"] * values["viscous"],
            stiffness,
            15.0 * stiffness,
            limit,
            hidden.get("constant_load", 0.0) * level,
            hidden.get("coulomb_asymmetry", 0.0),
            hidden.get("viscous_asymmetry", 0.0),
            hidden.get("quadratic_viscous", 0.0) * level / one.fastest_rad_s**2,
            hidden.get("stribeck_friction", 0.0),
            _BUMP * one.fastest_rad_s,
            hidden.get("cogging_torque", 0.0) * level,
            hidden.get("torque_ripple", 0.0),
            one.periods,
            values["phase"],
            hidden.get("spring_load", 0.0) * level / (one.stroke_rad or 1.0),
            one.arm_Nm,
            one.ratio,
            hidden.get("elastic_backlash", 0.0) * one.stroke_rad,
            hidden.get("position_friction", 0.0),
            one.stroke_rad or 1.0,
            values["lag_s"],
        ]
    )


def _random(machine: Machine, command: str, number: int) -> np.random.Generator:
    return np.random.default_rng([104_729, machine.number, COMMANDS.index(command), number])


def _happened(machine: Machine, command: str, number: int, own: Reals, random: np.random.Generator) -> Reals:
    """Angle, speed and torque, as it is and as it is recorded, at every row, [4, rows]."""
    one = KINDS[machine.kind]
    asked = _moves(one, command, number, random)
    begin = -np.sign(asked[0]) * one.stroke_rad if command == "steady speeds" else float(random.uniform(-0.2, 0.2)) * one.stroke_rad
    # what was before the record, so that it begins in motion where the speed is steady
    lead_in = np.full(round(0.5 / STEP_S), asked[0]) if command == "steady speeds" else np.zeros(round(0.2 / STEP_S))
    every = round(one.period_s / STEP_S)
    return np.asarray(_run(np.concatenate([lead_in, asked]), float(begin), own, every)[:, lead_in.size // every :])


def _record(machine: Machine, command: str, number: int, own: Reals) -> MotionRecord:
    random = _random(machine, command, number)
    angle, speed, _, torque = _happened(machine, command, number, own, random)
    return _measured(KINDS[machine.kind], machine, angle, speed, torque, f"{command} {number + 1}", random)


def _measured(
    one: Kind, machine: Machine, angle: Reals, speed: Reals, torque: Reals, name: str, random: np.random.Generator
) -> MotionRecord:
    """The signals as a drive gives them: counts of an encoder, noise of a torque of a percent of the friction."""
    counts = 2.0 * math.pi / 20_000.0
    read = counts * np.round(angle / counts)
    noisy = torque + random.normal(0.0, NOISE_SHARE * one.friction_Nm, torque.size)
    columns: dict[str, Sequence[float] | Reals] = {}
    if one.motion == "motor_angle_rad":
        columns[one.motion] = read
    elif one.motion == "position_mm":
        columns[one.motion] = one.mm_per_rad * read
    else:
        columns[one.motion] = speed + random.normal(0.0, 0.002 * one.fastest_rad_s, speed.size)
    columns[one.drive] = {
        "torque_Nm": noisy,
        "current_A": noisy / (one.constant_Nm_per_A * (1.0 + machine.changed.get("constant", 0.0))),
        "force_N": noisy / (1e-3 * (one.mm_per_rad or 1.0)),
    }[one.drive]
    if one.arm_Nm:
        columns["disturbance_Nm"] = one.arm_Nm * np.sin(read / one.ratio)
    return MotionRecord(one.period_s, name).with_columns({key: np.asarray(values, dtype=np.float64) for key, values in columns.items()})
