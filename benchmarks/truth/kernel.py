"""The loop of the truth plant: Heun's method in small steps, Coulomb friction by bisection or LuGre friction.

`v` is the record of all values by name. State `s`: current A, motor speed rad/s, motor angle rad, rod mm, rod speed mm/s
(the last two only behind a soft transmission or between elastic stops), bristle deflection rad (LuGre) or share of the level (Dahl), output of the play mm, time s,
magnetic lag -1 .. 1, winding temperature over its start degC, that of the winding over its housing and of the housing, of the form with two masses.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from benchmarks.truth import effects, forms, outside
from benchmarks.truth.kept import kept_compiled

COULOMB = 0
LUGRE = 1
DAHL = 2
PLAY = 3
_STATES = 12
_HALVINGS = 48


@kept_compiled
def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@kept_compiled
def mm_per_rad(v: Any) -> float:
    """Rod travel per motor angle."""
    return v["screw.lead_mm"] / (2.0 * math.pi * v["gearbox.ratio"])


@kept_compiled
def _level_Nm(v: Any, i: float, w: float, theta: float, time_s: float, direction: float, resting: bool) -> float:
    """Level of dry friction against motion in `direction`, or against its start."""
    x = mm_per_rad(v) * theta
    level = v["screw.csj_Nm"] * (1.0 if resting else v["screw.dynamic_ratio"]) * effects.grease_warming(v, time_s)
    level = effects.friction_Nm(v, level, i, w, theta, x, direction) * forms.friction_fade(v, time_s) + outside.broken_ball(v, theta)
    eta = v["gearbox.efficiency"]
    load = effects.load_Nm(v, x)
    lost = 1.0 - eta if load * direction <= 0.0 else 1.0 / eta - 1.0
    return level + lost * abs(load) - forms.seal_Nm(v)


@kept_compiled
def _resistance_ohm(v: Any, s: np.ndarray) -> float:
    """Winding resistance as warm as it is now."""
    return effects.resistance_ohm(v) * effects.winding_warming(v, s[9]) * forms.hot_over_cold(v, s[10], s[11])


@kept_compiled
def _rod_mass_kg(v: Any) -> float:
    """Mass that moves by itself, behind a soft transmission or between elastic stops; 0 is none."""
    return effects.rod_mass_kg(v) + forms.stop_mass_kg(v)


@kept_compiled
def _shaft_inertia_kgm2(v: Any) -> float:
    """Inertia of what turns with the shaft: the total without the mass that moves by itself."""
    return effects.inertia_kgm2(v) - _rod_mass_kg(v) * (1e-3 * mm_per_rad(v)) ** 2


@kept_compiled
def _rod_force_N(v: Any, s: np.ndarray, y_mm: float, y_mm_s: float) -> float:
    """Force on that mass; `y_mm`: output of the play."""
    soft = effects.transmission_compliance(v, y_mm - s[3], y_mm_s - s[4])
    n = mm_per_rad(v)
    return soft + forms.stop_force_N(v, n * s[2] - s[3], n * s[1] - s[4])


@kept_compiled
def _pull_Nm(v: Any, i: float, theta: float, force_N: float, lag: float) -> float:
    """Torque that drives the shaft, without any friction."""
    torque = effects.torque_constant_Nm_per_A(v) * effects.torque_ripple(v, theta) * (i - outside.magnetic_lag(v, lag))
    if v["motor.torque_limit_Nm"] > 0.0:
        torque = _clip(torque, v["motor.torque_limit_Nm"])
    n = mm_per_rad(v)
    return torque + effects.shaft_torque_Nm(v, theta) - effects.load_Nm(v, n * theta) - 1e-3 * n * force_N


@kept_compiled
def _back_V(v: Any, w: float, theta: float) -> float:
    """Back-EMF."""
    return effects.back_emf_V_s_per_rad(v) * effects.torque_ripple(v, theta) * w


@kept_compiled
def _static_current(v: Any, volt: float, w: float, theta: float, guess: float, r: float) -> float:
    """Current of a winding of resistance `r` without inductance, by Newton's method with a difference quotient."""
    i = guess
    for _ in range(30):
        error = volt + effects.lost_voltage_V(v, volt, i) - _back_V(v, w, theta) - r * i
        slope = (effects.lost_voltage_V(v, volt, i + 1e-6) - effects.lost_voltage_V(v, volt, i)) / 1e-6 - r
        i -= error / slope
        if abs(error) < 1e-13:
            break
    return i


@kept_compiled
def _bounded(v: Any, i: float) -> float:
    limit = effects.limit_A(v)
    return _clip(i, limit) if limit > 0.0 else i


@kept_compiled
def _slopes(v: Any, s: np.ndarray, law: int, held: float, moving: int, push: int, out: np.ndarray) -> None:
    """Rates of the state. `held`: voltage (law 0) or current reference (law 1); `moving`: direction of sliding, 0 at rest;
    `push`: whether the motor moves the output of the play; s[6] holds that output while it does not."""
    i = s[0]
    w = s[1]
    theta = s[2]
    n = mm_per_rad(v)
    if law == 0 and v["motor.inductance_H"] > 0.0:
        volt = held * outside.bus_hum(v, s[7]) + effects.lost_voltage_V(v, held, i)
        back = _back_V(v, w, theta)
        volt += forms.dead_time_sign(v, i, volt - back)
        out[0] = (volt - _resistance_ohm(v, s) * i - back) / v["motor.inductance_H"]
    elif law == 1 and v["drive.current_loop_s"] > 0.0:
        out[0] = (held - i) / v["drive.current_loop_s"]
    else:
        out[0] = 0.0
    y = s[6]
    half = 0.5 * v["screw.blk_mm"]
    y = min(max(y, n * theta - half), n * theta + half)
    force = _rod_force_N(v, s, y, n * w if push != 0 else 0.0)
    mass = _rod_mass_kg(v)
    inertia = _shaft_inertia_kgm2(v)
    out[3] = s[4]
    out[4] = 1e3 * (force - forms.seal_N(v, s[4])) / mass if mass > 0.0 else 0.0
    out[1] = 0.0
    out[2] = 0.0
    if moving != 0:
        friction = moving * _level_Nm(v, i, w, theta, s[7], float(moving), False)
        out[1] = (_pull_Nm(v, i, theta, force, s[8]) - effects.drag_Nm(v, w, s[7]) - outside.speed_hump(v, w) - friction) / inertia
        out[2] = w


@kept_compiled
def _heun(v: Any, s: np.ndarray, law: int, held: float, moving: int, push: int, dt: float, k: np.ndarray, out: np.ndarray) -> None:
    """State after `dt`; `k` [2, n] is scratch."""
    _slopes(v, s, law, held, moving, push, k[0])
    for j in range(5):
        out[j] = s[j] + dt * k[0, j]
    out[0] = _current_after(v, law, held, out[0], out[1], out[2], s)
    for j in range(5, _STATES):
        out[j] = s[j]
    _slopes(v, out, law, held, moving, push, k[1])
    for j in range(5):
        out[j] = s[j] + 0.5 * dt * (k[0, j] + k[1, j])
    out[0] = _current_after(v, law, held, out[0], out[1], out[2], s)


@kept_compiled
def _current_after(v: Any, law: int, held: float, i: float, w: float, theta: float, before: np.ndarray) -> float:
    """The current inside the drive's limits, and where it follows at once, its value; `before`: the state that it comes from."""
    if law == 0 and v["motor.inductance_H"] == 0.0:
        i = _static_current(v, held, w, theta, i, _resistance_ohm(v, before))
    elif law == 1 and v["drive.current_loop_s"] == 0.0:
        i = held
    elif law == 0:
        i = forms.stopped_at_zero(v, before[0], i)
    return _bounded(v, i)


@kept_compiled
def _breaks_away(v: Any, s: np.ndarray) -> int:
    """Direction in which a shaft at rest starts, or 0."""
    n = mm_per_rad(v)
    force = _rod_force_N(v, s, s[6], 0.0)
    pull = _pull_Nm(v, s[0], s[2], force, s[8])
    start = 1 if pull > 0.0 else -1
    if abs(pull) <= _level_Nm(v, s[0], 0.0, s[2], s[7], float(start), True):
        return 0
    if start * n * s[2] >= v["screw.travel_mm"] * (1.0 - 1e-15):
        return 0
    return start


@kept_compiled
def _follow(v: Any, s: np.ndarray) -> None:
    """Move the output of the play with the motor."""
    x = mm_per_rad(v) * s[2]
    half = 0.5 * v["screw.blk_mm"]
    s[6] = min(max(s[6], x - half), x + half)


@kept_compiled
def _pushes(v: Any, s: np.ndarray, moving: int) -> int:
    """1 while the motor, sliding in that direction, moves the output of the play."""
    gap = mm_per_rad(v) * s[2] - s[6]
    return 1 if moving != 0 and gap * moving >= 0.5 * v["screw.blk_mm"] * (1.0 - 1e-12) else 0


@kept_compiled
def _left_branch(v: Any, s: np.ndarray, moving: int) -> bool:
    """Whether the shaft has turned back, passed an end of travel, or broken away from rest."""
    if moving == 0:
        return _breaks_away(v, s) != 0
    return s[1] * moving < 0.0 or mm_per_rad(v) * s[2] * moving > v["screw.travel_mm"]


@kept_compiled
def _coulomb(v: Any, s: np.ndarray, law: int, held: float, moving: int, dt: float, k: np.ndarray, trial: np.ndarray) -> int:
    """One integration step with Coulomb friction; reversals and break-away are found by halving the step."""
    left = dt
    if moving == 0:
        moving = _breaks_away(v, s)
    for _ in range(20):
        push = _pushes(v, s, moving)
        _heun(v, s, law, held, moving, push, left, k, trial)
        if not _left_branch(v, trial, moving):
            s[:] = trial
            _follow(v, s)
            return moving
        part = left
        width = left
        for _ in range(_HALVINGS):
            width *= 0.5
            nearer = part - width
            _heun(v, s, law, held, moving, push, nearer, k, trial)
            if _left_branch(v, trial, moving):
                part = nearer
        _heun(v, s, law, held, moving, push, part, k, trial)
        s[:] = trial
        _follow(v, s)
        left -= part
        s[1] = 0.0
        if moving != 0:
            reach = v["screw.travel_mm"] / mm_per_rad(v)
            s[2] = _clip(s[2], reach)
        moving = _breaks_away(v, s)
        if left <= 0.0:
            return moving
    return moving


@kept_compiled
def _lugre(v: Any, s: np.ndarray, law: int, held: float, presliding_rad: float, dt: float, k: np.ndarray, trial: np.ndarray) -> int:
    """One integration step with LuGre friction: bristles implicit, the rest by Heun's method without friction."""
    w = s[1]
    direction = 1 if w > 0.0 else -1
    inertia = _shaft_inertia_kgm2(v)
    steady = _level_Nm(v, s[0], w, s[2], s[7], float(direction), False)
    resting = _level_Nm(v, s[0], 0.0, s[2], s[7], float(direction), True)
    g = steady + (resting - steady) * math.exp(-((w / 0.02) ** 2))
    stiffness = resting / presliding_rad
    damping = 2.0 * math.sqrt(stiffness * inertia) * math.exp(-((w / 0.5) ** 2))
    if forms.lugre(v) > 0.0:
        g = steady * forms.lugre_level(v, w)
        stiffness = steady / forms.lugre(v)
        damping = 2.0 * v["lugre.damping_ratio"] * math.sqrt(stiffness * inertia)
    before = s[5]
    push = _pushes(v, s, direction)
    _slopes(v, s, law, held, direction, push, k[0])
    free = k[0, 1] + direction * steady / inertia
    bristle = (before + dt * w) / (1.0 + dt * abs(w) * stiffness / g)
    rate = (bristle - before) / dt
    speed = w + dt * (free - (stiffness * bristle + damping * rate) / inertia)
    middle = 0.5 * (w + speed)
    trial[:] = s
    trial[0] = s[0] + dt * k[0, 0]
    trial[1] = middle
    _slopes(v, trial, law, held, direction, push, k[1])
    s[0] = _current_after(v, law, held, s[0] + 0.5 * dt * (k[0, 0] + k[1, 0]), speed, s[2], s)
    s[3] += 0.5 * dt * (k[0, 3] + k[1, 3])
    s[4] += 0.5 * dt * (k[0, 4] + k[1, 4])
    s[1] = speed
    s[2] += dt * middle
    s[5] = bristle
    reach = v["screw.travel_mm"] / mm_per_rad(v)
    if abs(s[2]) > reach:
        s[2] = _clip(s[2], reach)
        s[1] = 0.0
    _follow(v, s)
    return direction if s[1] != 0.0 else 0


@kept_compiled
def _carried(v: Any, friction: int, contact: float) -> float:
    """Share of dry friction that a contact carries."""
    return effects.elastic_backlash_carried(v, contact) if friction == PLAY else contact


@kept_compiled
def _contact_after(v: Any, friction: int, contact: float, turn: float) -> float:
    """The contact after a turn in one direction."""
    if friction == PLAY:
        return effects.elastic_backlash_after(v, contact, mm_per_rad(v) * turn)
    return forms.dahl_after(v, contact, turn)


@kept_compiled
def _by_contact(v: Any, s: np.ndarray, law: int, held: float, friction: int, dt: float, k: np.ndarray, trial: np.ndarray) -> int:
    """One integration step with a contact in closed form over the angle, Dahl's or one behind a play, the rest by Heun's method."""
    direction = 1 if s[1] > 0.0 else -1
    push = _pushes(v, s, direction)
    inertia = _shaft_inertia_kgm2(v)
    trial[:] = s
    for stage in range(2):
        _slopes(v, trial, law, held, direction, push, k[stage])
        level = _level_Nm(v, trial[0], trial[1], trial[2], trial[7], float(direction), False)
        # the slopes hold friction of full sliding: what the contact does not carry yet is given back
        k[stage, 1] += level * (direction - _carried(v, friction, trial[5])) / inertia
        if stage == 0:
            for j in range(5):
                trial[j] = s[j] + dt * k[0, j]
            trial[0] = _current_after(v, law, held, trial[0], trial[1], trial[2], s)
            trial[5] = _contact_after(v, friction, s[5], trial[2] - s[2])
    for j in range(5):
        trial[j] = s[j] + 0.5 * dt * (k[0, j] + k[1, j])
    s[0] = _current_after(v, law, held, trial[0], trial[1], trial[2], s)
    s[5] = _contact_after(v, friction, s[5], trial[2] - s[2])
    for j in range(1, 5):
        s[j] = trial[j]
    reach = v["screw.travel_mm"] / mm_per_rad(v)
    if abs(s[2]) > reach:
        s[2] = _clip(s[2], reach)
        s[1] = 0.0
    _follow(v, s)
    return direction if s[1] != 0.0 else 0


@kept_compiled
def _control(v: Any, error: float, feedback: float, c: np.ndarray, period: float) -> float:
    """Control law; `c`: integrator, last error, last feedback, last measure, whether it has run. Metres."""
    first = c[4] == 0.0
    error = outside.command_dead_band(v, error)
    mean = feedback if first or v["control.average_speed"] == 0.0 else 0.5 * (feedback + c[2])
    speed = 0.0 if first else (mean - c[3]) / period
    de = 0.0 if first else (error - c[1]) / period
    if v["control.structure"] == 1.0:
        asked = v["control.position_gain_per_s"] * effects.gain_drift(v) * error
        if v["control.speed_limit_m_s"] > 0.0:
            asked = _clip(asked, v["control.speed_limit_m_s"])
        raw = v["control.speed_gain_s_per_m"] * (asked - speed) + c[0]
        charge = v["control.speed_integral_per_m"] * (asked - speed)
    else:
        d = de if v["control.derivative"] == 0.0 else -speed
        raw = v["control.kp_per_m"] * effects.gain_drift(v) * error + v["control.kd_s_per_m"] * d + c[0]
        charge = v["control.ki_per_m_s"] * error
    u = _clip(raw, v["control.output_limit"])
    c[0] += period * (charge - v["control.anti_windup_per_s"] * (raw - u) - outside.integrator_leak(v, c[0]))
    c[1] = error
    c[2] = feedback
    c[3] = mean
    c[4] = 1.0
    return u


@kept_compiled
def _seen(v: Any, readings: np.ndarray, step: int) -> float:
    """Feedback in mm: aged by a parabola through three readings, then rounded."""
    age = effects.feedback_age_s(v) / v["timing.step_s"]
    q = int(age)
    f = age - q
    a = readings[max(step - q, 0)]
    if f > 0.0:
        b = readings[max(step - q - 1, 0)]
        c = readings[max(step - q - 2, 0)]
        # Newton's form: the value f steps before the newest of three
        a = a + f * (b - a) + 0.5 * f * (f - 1.0) * (c - 2.0 * b + a)
    r = v["encoder.resolution_mm"]
    return r * math.floor(a / r + 0.5) if r > 0.0 else a


@kept_compiled
def _applied(v: Any, u: float, s: np.ndarray) -> tuple[int, float, float]:
    """What the drive makes of the output `u`: law, voltage or current that it holds, voltage that it records."""
    supply = effects.supply_V(v)
    if v["drive.mode"] == 0.0:
        return 0, u * supply, u * supply
    law = 1
    held = u * v["drive.current_scale_A"]
    back = effects.back_emf_V_s_per_rad(v) * s[1]
    if v["drive.current_loop_s"] > 0.0:
        rise = (held - s[0]) / v["drive.current_loop_s"]
        shown = _resistance_ohm(v, s) * s[0] + v["motor.inductance_H"] * rise + back
        if abs(shown) > supply:
            law = 0
            held = _clip(shown, supply)
            shown = held
    else:
        shown = _resistance_ohm(v, s) * _bounded(v, held) + back
    if v["drive.command_scale_V"] > 0.0:
        shown = u * v["drive.command_scale_V"]
    return law, held, shown


@kept_compiled
def _terminal_V(v: Any, s: np.ndarray, law: int, held: float, moving: int, k: np.ndarray) -> float:
    """What the winding itself sees: the sum of its own three voltages."""
    _slopes(v, s, law, held, moving, 0, k)
    limit = effects.limit_A(v)
    rise = 0.0 if limit > 0.0 and abs(s[0]) >= limit and k[0] * s[0] > 0.0 else k[0]
    return _resistance_ohm(v, s) * s[0] + v["motor.inductance_H"] * rise + _back_V(v, s[1], s[2])


@kept_compiled
def run(
    v: Any,
    command_mm: np.ndarray,
    start_mm: float,
    law_of_friction: int,
    presliding_rad: float,
    parts: int,
    noise_mm: np.ndarray,
    at_terminals: bool,
    rows: np.ndarray,
) -> None:
    """Simulate every step of `command_mm` [n] with `parts` integration steps each.

    `noise_mm` [n] is added to the feedback sensor's reading; `rows` [5, n]: rod mm, motor mm, current A, voltage V, rod
    speed mm/s at the start of each step. The voltage is the one asked for, or `at_terminals` the motor's own.
    """
    s = np.zeros(_STATES)
    trial = np.zeros(_STATES)
    k = np.zeros((2, _STATES))
    c = np.zeros(5)
    readings = np.empty(command_mm.size)
    outputs = np.zeros(command_mm.size)
    n = mm_per_rad(v)
    h = v["timing.step_s"]
    every = int(v["control.every_steps"])
    s[2] = start_mm / n
    s[3] = start_mm
    s[6] = start_mm
    moving = 0
    u = 0.0
    age = effects.output_age_s(v) / h
    soft = _rod_mass_kg(v) > 0.0
    for step in range(command_mm.size):
        x = n * s[2]
        rod = s[3] if soft else s[6]
        reading = effects.rod_reading_mm(v, rod + outside.lead_error(v, rod))
        shown_x = x + n * outside.encoder_eccentricity(v, s[2])
        readings[step] = (reading if v["encoder.side"] == 1.0 else shown_x) + noise_mm[step]
        if step % every == 0:
            seen = 1e-3 * _seen(v, readings, step)
            u = _control(v, 1e-3 * command_mm[step] - seen, seen, c, every * h)
        outputs[step] = u
        _, _, shown = _applied(v, u, s)
        rows[0, step] = reading
        rows[1, step] = shown_x
        rows[3, step] = shown
        rows[4, step] = s[4] if soft else (n * s[1] if _pushes(v, s, moving) else 0.0)
        # the motor sees the output of `age` steps ago, which changes once inside the step
        begin = 0.0
        change = age - math.floor(age)
        for end in (change, 1.0):
            if end > begin:
                source = step + int(math.floor(0.5 * (begin + end) - age))
                law, held, _ = _applied(v, outputs[source] if source >= 0 else 0.0, s)
                s[0] = _current_after(v, law, held, s[0], s[1], s[2], s)
                if begin == 0.0:
                    rows[2, step] = s[0]
                    if at_terminals:
                        rows[3, step] = _terminal_V(v, s, law, held, moving, k[0])
                pieces = int(math.ceil((end - begin) * parts - 1e-9))
                for _ in range(pieces):
                    dt = (end - begin) * h / pieces
                    before = s[0]
                    if law_of_friction == COULOMB:
                        moving = _coulomb(v, s, law, held, moving, dt, k, trial)
                    elif law_of_friction in (DAHL, PLAY):
                        moving = _by_contact(v, s, law, held, law_of_friction, dt, k, trial)
                    else:
                        moving = _lugre(v, s, law, held, presliding_rad, dt, k, trial)
                    s[7] += dt
                    s[8] = outside.lag_after(v, s[8], s[0] - before)
                    loss_W = _resistance_ohm(v, s) * before * before
                    s[9] += dt * effects.winding_rate_degC_per_s(v, s[9], loss_W)
                    s[10] = forms.warmer_after(v, s[10], loss_W, dt)
                    s[11] = forms.housing_after(v, s[11], loss_W, dt)
                begin = end
