"""Commands that an actuator can run on ground, made to its measure, and what is safe on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator
from ema_tools.plant.native import Simulation

_STROKE_SHARE = 0.8  # of the travel, which a command of the menu may use: the rest keeps it off the stops [judgement]
_SPEED_SHARE = 0.8  # of the speed at which the back-EMF eats the supply [judgement]
_OUTPUT_SHARE = 0.95  # of the controller's range: a saturated drive hides what it does [judgement]
_CURRENT_SHARE = 0.6  # of the largest current that drive and winding allow [judgement]
_CHIRP_SPEED = 0.64  # the reference chirp asks for this share of the speed at its end [measured]
_CHIRP_TORQUE = 0.3  # the same of the torque [measured]
_CHIRP_LEADS = 0.4  # its amplitude, in leads of the screw [measured]
_LONG_LEADS = 1.5  # a long stroke passes this many leads: what repeats with the lead is then seen more than once [physics]
_LONG_STROKE = 0.25  # or this share of the travel that is allowed [judgement]
_RATE_SHARE = 0.02  # of the record rate: fifty rows a period [judgement]
_DURATION_S = 10.0  # of the reference chirp [judgement]
_SMOOTH_SHARE = 0.999  # of a command's rows, which count for its speed: the jump of a step is none [judgement]


# What a user may limit.
LIMIT_NAMES = ("stroke_mm", "speed_mm_s", "current_A")


Asked = Literal["stroke_mm", "speed_mm_s", "current_A", "output"]


@dataclass(frozen=True)
class Offence:
    """What of a limit a run exceeds, in the limit's unit; `effect`: the machine has it in that run."""

    limit: Asked
    value: float
    allowed: float
    effect: str = ""


@dataclass(frozen=True)
class SafeRange:
    """Largest excursion, speed, current, and share of the controller's range, of which the simulated run must stay inside."""

    stroke_mm: float
    speed_mm_s: float
    current_A: float
    output: float

    def offence(self, run: Simulation, command_mm: Reals, actuator: Actuator, period_s: float, effect: str = "") -> Offence | None:
        """Why a command is not safe; None when it is."""
        stroke = float(max(np.max(np.abs(command_mm)), np.max(np.abs(run.position_mm)), np.max(np.abs(run.motor_position_mm))))
        # a step stands in a single row: there the motor's own speed counts
        asked = float(np.quantile(np.abs(np.diff(command_mm)), _SMOOTH_SHARE)) / period_s
        speed = max(float(np.max(np.abs(run.speed_mm_s))), asked)
        current = float(np.max(np.abs(run.current_A)))
        found = (
            Offence("stroke_mm", stroke, self.stroke_mm, effect),
            Offence("speed_mm_s", speed, self.speed_mm_s, effect),
            Offence("current_A", current, self.current_A, effect),
            Offence("output", _output_share(run, actuator), self.output, effect),
        )
        return next((one for one in found if not one.value <= one.allowed), None)


def _is_current_mode(actuator: Actuator) -> bool:
    return actuator["drive.mode"] == 1.0


def _output_share(run: Simulation, actuator: Actuator) -> float:
    """Largest share of the controller's range that a run took."""
    if _is_current_mode(actuator):
        return float(np.max(np.abs(run.current_A))) / (actuator["drive.current_scale_A"] * actuator["control.output_limit"])
    return float(np.max(np.abs(run.voltage_V))) / (actuator["drive.supply_V"] * actuator["control.output_limit"])


def _largest_current_A(actuator: Actuator) -> float:
    """What drive, winding and motor allow."""
    stall = actuator["drive.supply_V"] * actuator["control.output_limit"] / actuator["motor.resistance_ohm"]
    found = [actuator["drive.current_scale_A"] * actuator["control.output_limit"] if _is_current_mode(actuator) else stall]
    if actuator["drive.current_limit_A"] > 0.0:
        found.append(actuator["drive.current_limit_A"])
    if actuator["motor.torque_limit_Nm"] > 0.0:
        found.append(actuator["motor.torque_limit_Nm"] / actuator["motor.torque_constant_Nm_per_A"])
    return min(found)


def limits_of(actuator: Actuator, own: Mapping[str, float] | None = None) -> SafeRange:
    """What is safe on the actuator; `own` limits (stroke_mm, speed_mm_s, current_A) in place of those."""
    emf = actuator["motor.back_emf_V_s_per_rad"]
    free = actuator["drive.supply_V"] / emf * actuator.lead_mm_per_rad if emf > 0.0 else math.inf
    usual = {
        "stroke_mm": _STROKE_SHARE * actuator["screw.travel_mm"],
        "speed_mm_s": _SPEED_SHARE * free,
        "current_A": _CURRENT_SHARE * _largest_current_A(actuator),
    }
    return SafeRange(**{**usual, **(own or {})}, output=_OUTPUT_SHARE)


def _two_digits(value: float) -> float:
    return float(f"{value:.2g}")


def menu(actuator: Actuator, limits: SafeRange) -> dict[str, str]:
    """Commands as `make_command` takes them, by what they are; the first is the reference."""
    lead, period_s = actuator["screw.lead_mm"], actuator.record_period_s
    amplitude = min(_CHIRP_LEADS * lead, 0.5 * limits.stroke_mm)
    torque = _CHIRP_TORQUE * _largest_current_A(actuator) * actuator["motor.torque_constant_Nm_per_A"]
    hardest = torque / actuator["screw.inertia_kgm2"] * actuator.lead_mm_per_rad
    turn = 2.0 * math.pi
    fastest = _CHIRP_SPEED / _SPEED_SHARE * limits.speed_mm_s

    def end_hz(reach_mm: float) -> float:
        """Highest frequency of a sine of this amplitude, by speed, torque and record rate."""
        return min(fastest / (turn * reach_mm), math.sqrt(hardest / reach_mm) / turn, _RATE_SHARE / period_s)

    def chirp(reach_mm: float, to_hz: float) -> str:
        return f"chirp:amplitude_mm={_two_digits(reach_mm):g},start_hz={min(0.1, _two_digits(0.05 * to_hz)):g},end_hz={_two_digits(to_hz):g},duration_s={_DURATION_S:g}"

    def wave(kind: str, reach_mm: float, hz: float, more: str = "") -> str:
        return f"{kind}:amplitude_mm={_two_digits(reach_mm):g},start_hz={_two_digits(hz):g}{more},duration_s={_DURATION_S:g}"

    hz = end_hz(amplitude)
    long = min(max(_LONG_LEADS * lead, _LONG_STROKE * limits.stroke_mm), 0.9 * limits.stroke_mm)
    speed_hz = min(fastest, turn * end_hz(long) * long) / (4.0 * long)
    found = {
        "chirp": chirp(amplitude, hz),
        "slower chirp": chirp(amplitude, 0.25 * hz),
        "smaller and faster chirp": chirp(0.25 * amplitude, min(2.0 * hz, _RATE_SHARE / period_s)),
        "smaller chirp": chirp(0.25 * amplitude, hz),
        "larger and slower chirp": chirp(2.0 * amplitude, 0.5 * hz),
        "small-stroke chirp": chirp(0.05 * amplitude, 0.5 * hz),
        "smallest-stroke chirp": chirp(0.01 * amplitude, 0.25 * hz),
        "multisine": wave("multisine", 0.5 * amplitude, 0.05 * hz, ",count=20"),
        "slow triangle": wave("triangle", amplitude, 0.05 * hz),
        "fast triangle": wave("triangle", amplitude, 0.4 * hz),
        "trapezoid that rests at its ends": wave("trapezoid", amplitude, 0.1 * hz, ",share=0.5"),
        "slow triangle over several leads": wave(
            "triangle", long, 0.1 * speed_hz if 0.1 * speed_hz * _DURATION_S >= 1.0 else 1.0 / _DURATION_S
        ),
        "fast triangle over several leads": wave("triangle", long, 0.8 * speed_hz),
        "chirp over several leads": chirp(long, end_hz(long)),
        "step": f"step:amplitude_mm={_two_digits(0.5 * amplitude):g},time_s=0.5,duration_s={_DURATION_S:g}",
        "small step": f"step:amplitude_mm={_two_digits(0.05 * amplitude):g},time_s=0.5,duration_s={_DURATION_S:g}",
    }
    # a short travel has no several leads
    return {title: text for title, text in found.items() if long > lead or "several leads" not in title}
