"""The whole model: control instants at the model step, the plant between them at a hundredth of it, events located.

The plant is integrated by the classical Runge-Kutta method of fourth order. When a state has left its mode (reversal,
break-away, end of travel, contact of the play, limit of current or torque), the instant is found by bisection down to the
resolution of a float64, the mode is decided again there, and integration goes on from there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ema_tools.base.compiled import compiled, kept
from ema_tools.base.recording import Recording
from ema_tools.library.definitions import defaults, project_definitions
from reference_model import drive, encoder, gearbox, pid, plant, sites
from reference_model.actuator import build, filled, is_active
from reference_model.effects import module_of
from reference_model.point import Data, Point

__all__ = ["Recording", "defaults", "simulate"]

_EVENTS_MAX = 200  # in one integration step; more means that the equations chatter
_LARGEST_RATE_STEP = 0.2  # fastest rate times integration step, for an error of a step below 3e-6 of that part


@compiled
def _runge_kutta(
    moving: plant.Plant,
    supply: drive.Supply,
    mode: plant.Mode,
    state: np.ndarray,
    span_s: float,
    slopes: np.ndarray,
    out: np.ndarray,
) -> None:
    """State after `span_s` in an unchanged mode, written to `out`; `slopes` [4, n] is scratch."""
    out[:] = state
    for stage in range(4):
        plant.rates(moving, supply, mode, out, slopes[stage])
        reach = span_s if stage == 2 else 0.5 * span_s
        if stage < 3:
            for index in range(state.size):
                out[index] = state[index] + reach * slopes[stage, index]
    for index in range(state.size):
        middle = slopes[1, index] + slopes[2, index]
        out[index] = state[index] + span_s / 6.0 * (slopes[0, index] + 2.0 * middle + slopes[3, index])


@compiled
def _move(
    moving: plant.Plant,
    supply: drive.Supply,
    mode: plant.Mode,
    state: np.ndarray,
    span_s: float,
    slopes: np.ndarray,
    trial: np.ndarray,
) -> tuple[plant.Mode, bool]:
    """Move `state` by one integration step with its events located; False when they do not end."""
    left = span_s
    events = 0
    before = 0.0
    after = 0.0
    span = left
    # One call of the integrator serves the whole step and the bisection, whose bounds are `before` and `after`.
    while True:
        _runge_kutta(moving, supply, mode, state, span, slopes, trial)
        passed = plant.has_passed(moving, supply, mode, trial)
        if after == 0.0 and not passed:
            state[:] = trial
            return mode, True
        if passed:
            after = span
        else:
            before = span
        middle = 0.5 * (before + after)
        if middle > before and middle < after and after - before > 1e-18:
            span = middle
            continue
        if not passed:
            span = after
            before = after
            continue
        state[:] = trial
        mode = plant.settled(moving, supply, mode, state)
        left -= after
        events += 1
        if left <= 0.0:
            return mode, True
        if events == _EVENTS_MAX:
            return mode, False
        before = 0.0
        after = 0.0
        span = left


# The whole loop is kept, with all that it calls: the sites' functions are handed others, which Numba cannot keep one by one.
@kept(Path(__file__).parent, repr(project_definitions()))
def _run(moving: plant.Plant, command_mm: np.ndarray, start_mm: float, oversample: int, rows: np.ndarray) -> int:
    """Simulate every step of `command_mm` [n]; fill `rows` [5, m]; return the number of steps that went well."""
    part = moving.part
    step_s = part.timing.step_s
    period_s = part.control.every_steps * step_s
    state = np.zeros(sites.FIRST_MEMORY + sites.EFFECT_MEMORY)
    slopes = np.zeros((4, state.size))
    trial = np.zeros(state.size)
    state[plant.ANGLE] = start_mm / moving.lead_mm_per_rad
    sites.rest_transmission(part.effects, state, start_mm)
    mode = plant.Mode(0, 0, 0, start_mm, 0, 0, False)
    control = pid.at_rest()
    history = np.empty(command_mm.size)
    outputs = np.empty(command_mm.size)
    age = part.drive.output_delay_s / step_s
    whole = int(math.floor(age))
    late = age - whole

    for step in range(command_mm.size):
        motor_mm = moving.lead_mm_per_rad * state[plant.ANGLE]
        point = Point(state[plant.CURRENT], state[plant.SPEED], state[plant.ANGLE], motor_mm, 0.0, moving.data, 0.0, 0.0, 0.0)
        play_mm, play_mm_s = plant.play_output(moving, mode, point)
        rod_mm, rod_mm_s = sites.rod_behind_play(part.effects, state, play_mm, play_mm_s)
        at_rod = Point(point.current_A, point.speed_rad_s, point.angle_rad, rod_mm, 0.0, moving.data, 0.0, 0.0, 0.0)
        sensor_mm = encoder.rod_sensor_mm(part.encoder, rod_mm) + sites.extra_reading_mm(part.effects, at_rod)
        history[step] = sensor_mm if part.encoder.side == 1 else motor_mm
        if step % part.control.every_steps == 0:
            feedback = encoder.feedback_mm(part.encoder, step_s, history, step)
            control = pid.run(part.control, period_s, 1e-3 * command_mm[step], 1e-3 * feedback, control)
        outputs[step] = control.output
        asked = drive.supply(part.drive, part.motor, control.output, state[plant.CURRENT], state[plant.SPEED])
        # what the motor sees: for the share `late` of the step an older output, then the next one
        for newer in range(2):
            share = 1.0 - late if newer == 1 else late
            if share > 0.0:
                seen = drive.delayed(outputs, step - whole - 1 + newer)
                supply = drive.supply(part.drive, part.motor, seen, state[plant.CURRENT], state[plant.SPEED])
                mode = plant.settled(moving, supply, mode, state)
                if step % part.timing.record_every_steps == 0 and (newer == 0 or late == 0.0):
                    row = step // part.timing.record_every_steps
                    rows[0, row] = sensor_mm
                    rows[1, row] = motor_mm
                    rows[2, row] = state[plant.CURRENT]
                    rows[3, row] = asked.recorded_V
                    rows[4, row] = rod_mm_s
                pieces = int(math.ceil(share * oversample))
                for _ in range(pieces):
                    mode, went_well = _move(moving, supply, mode, state, share * step_s / pieces, slopes, trial)
                    if not went_well:
                        return step
        if not math.isfinite(state[plant.CURRENT] + state[plant.ANGLE]):
            return step
    return command_mm.size


def _fastest_rate_per_s(moving: plant.Plant, lead_m_per_rad: float) -> float:
    """Largest rate of change of the linear plant, for the choice of the integration step."""
    part = moving.part
    fastest = part.screw.viscous_Nm_s_per_rad / moving.inertia_kgm2
    if part.motor.inductance_H > 0.0:
        coupling = part.motor.torque_constant_Nm_per_A * part.motor.back_emf_V_s_per_rad
        fastest += part.motor.resistance_ohm / part.motor.inductance_H
        fastest += math.sqrt(coupling / (part.motor.inductance_H * moving.inertia_kgm2))
    if part.drive.mode == 1 and part.drive.current_loop_s > 0.0:
        fastest = max(fastest, 1.0 / part.drive.current_loop_s)
    level_per_inertia = part.screw.csj_Nm / moving.inertia_kgm2
    top_speed = part.drive.supply_V / max(part.motor.back_emf_V_s_per_rad, 1e-6)
    fastest = max(fastest, sites.contact_rate_per_s(part.effects, level_per_inertia, top_speed, moving.lead_mm_per_rad))
    return max(fastest, sites.transmission_rate_per_s(part.effects, moving.inertia_kgm2, lead_m_per_rad))


def prepared(values: Mapping[str, float]) -> plant.Plant:
    """The plant of `values` (missing ones nominal), PARAMETER effects applied.

    Raises KeyError and ValueError as `reference_model.actuator.filled`; ValueError when a transmission effect takes
    the whole inertia.
    """
    complete = filled(values)
    whole = build(complete)
    for effect in project_definitions().effects:
        if effect.site == "PARAMETER" and is_active(effect.name, complete):
            complete.update(module_of(effect.name).change_values(getattr(whole.effects, effect.name), complete))
    whole = build(complete)
    lead = gearbox.lead_mm_per_rad(whole.gearbox, whole.screw)
    inertia = sites.shaft_inertia_kgm2(whole.effects, whole.screw.inertia_kgm2, 1e-3 * lead)
    if not inertia > 0.0:
        raise ValueError(f"screw.inertia_kgm2 = {whole.screw.inertia_kgm2:g}: a mass of the transmission takes all of it: lower the mass")
    data = Data(whole.motor.torque_constant_Nm_per_A, whole.screw.viscous_Nm_s_per_rad, whole.screw.lead_mm, whole.drive.supply_V)
    return plant.Plant(whole, lead, inertia, data)


def simulate(values: Mapping[str, float], command_mm: np.ndarray, start_mm: float = 0.0, oversample: int = 100) -> Recording:
    """Simulate an actuator.

    `values`: numbers by `section.field` and `effect.field`; missing ones are nominal. `command_mm` [steps]: one command per
    model step, held over it. `start_mm`: where rod and motor rest at first. `oversample`: integration steps per model step;
    more are taken when the plant is faster than that.
    Raises KeyError for an unknown name, ValueError for a value out of range, ArithmeticError when the simulation does not
    stay finite or its events do not end.
    """
    moving = prepared(values)
    steps = np.ascontiguousarray(command_mm, dtype=float)
    every = moving.part.timing.record_every_steps
    rate = _fastest_rate_per_s(moving, 1e-3 * moving.lead_mm_per_rad)
    oversample = max(oversample, math.ceil(moving.part.timing.step_s * rate / _LARGEST_RATE_STEP))
    rows = np.empty((5, -(-steps.size // every)))
    done = _run(moving, steps, float(start_mm), int(oversample), rows)
    if done < steps.size:
        raise ArithmeticError(f"step {done}: the simulation left the finite numbers or its events do not end: check gains and inertia")
    time_s = np.arange(rows.shape[1]) * (every * moving.part.timing.step_s)
    return Recording(time_s, steps[::every].copy(), *rows)
