"""Machines of another build than the truth plant's: motor and rod are two masses with a spring between them that has a gap, both rub by a bristle law with a Stribeck bump, the winding warms
while it works, the supply gives way under load, the teeth pull.

Nothing here is shared with the flight code or with the truth plant but the data sheet that units are drawn round: the backlash is a gap in a force law instead of a kinematic band, friction a
state of its own, and time runs in fixed steps of 5 us with no event located.

Sources: friction by C. Canudas de Wit et al., "A new model for control of systems with friction", IEEE Trans. Automatic Control 40(3), 1995; gap in the spring by M. Nordin and P.-O. Gutman,
"Controlling mechanical systems with backlash - a survey", Automatica 38, 2002.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import signal

from ema_tools.base.arrays import Reals
from ema_tools.base.compiled import compiled
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator

STEP_S = 5e-6
PERIOD_S = 1e-3
_COPPER_PER_DEGC = 0.0039
_GREASE_PER_DEGC = 0.025
_DRY_PER_DEGC = 0.004


@dataclass(frozen=True)
class Unit:
    """One machine: `sheet` values by their names in an actuator file; what no sheet says as `own`, in the order of `_OWN`; the sensors' errors."""

    sheet: Mapping[str, float]
    own: Mapping[str, float]
    noise_mm: float
    corner_hz: float
    count_mm: float


def unit(number: int, noise: str) -> Unit:
    """The unit of that number. `noise`: "" white, "coloured" with a corner at 30 Hz, "counts_20um"."""
    random = np.random.default_rng([104_729, number])
    base = reference_actuator()

    def near(name: str, share: float) -> float:
        return float(base[name] * (1.0 + random.uniform(-share, share)))

    magnets = 1.0 + float(random.uniform(-0.03, 0.03))
    sheet = {
        "screw.csj_Nm": near("screw.csj_Nm", 0.08),
        "screw.blk_mm": near("screw.blk_mm", 0.1),
        "screw.viscous_Nm_s_per_rad": near("screw.viscous_Nm_s_per_rad", 0.2),
        "screw.inertia_kgm2": near("screw.inertia_kgm2", 0.05),
        "motor.resistance_ohm": near("motor.resistance_ohm", 0.05),
        "motor.inductance_H": near("motor.inductance_H", 0.1),
        "motor.torque_constant_Nm_per_A": base["motor.torque_constant_Nm_per_A"] * magnets,
        "motor.back_emf_V_s_per_rad": base["motor.back_emf_V_s_per_rad"] * magnets,
        "drive.supply_V": near("drive.supply_V", 0.01),
        "control.kp_per_m": base["control.kp_per_m"],
        "control.ki_per_m_s": base["control.ki_per_m_s"],
    }
    own = {
        "bristle_rad": float(random.uniform(2e-4, 1.5e-3)),
        "bump": float(random.uniform(0.0, 0.03)),
        "bump_speed_rad_s": float(random.uniform(3.0, 15.0)),
        "rod_kg": float(random.uniform(0.3, 1.0)),
        "rod_share": float(random.uniform(0.005, 0.02)),
        "stiffness_N_per_m": float(random.uniform(2e7, 8e7)),
        "teeth_Nm": float(random.uniform(0.0, 0.0006)),
        "teeth_phase_rad": float(random.uniform(-np.pi, np.pi)),
        "pitch_share": float(random.uniform(0.0, 0.006)),
        "pitch_phase_rad": float(random.uniform(-np.pi, np.pi)),
        "source_ohm": float(random.uniform(0.0, 0.01)),
        "warming_degC_per_J": float(random.uniform(0.0, 0.01)),
        "dead_V": float(random.uniform(0.0, 0.02)),
        "rod_gain": float(2e-4 * random.standard_normal()),
        "rod_offset_mm": float(0.002 * random.standard_normal()),
        "current_gain": float(0.003 * random.standard_normal()),
        "current_offset_A": float(0.02 * random.standard_normal()),
    }
    return Unit(sheet, own, 0.002, 30.0 if noise == "coloured" else 0.0, 0.02 if noise == "counts_20um" else 5e-4)


_OWN = (
    "bristle_rad",
    "bump",
    "bump_speed_rad_s",
    "rod_kg",
    "rod_share",
    "stiffness_N_per_m",
    "teeth_Nm",
    "teeth_phase_rad",
    "pitch_share",
    "pitch_phase_rad",
    "source_ohm",
    "warming_degC_per_J",
    "dead_V",
)
_SHEET = (
    "screw.csj_Nm",
    "screw.blk_mm",
    "screw.viscous_Nm_s_per_rad",
    "screw.inertia_kgm2",
    "motor.resistance_ohm",
    "motor.inductance_H",
    "motor.torque_constant_Nm_per_A",
    "motor.back_emf_V_s_per_rad",
    "drive.supply_V",
    "control.kp_per_m",
    "control.ki_per_m_s",
)


@compiled
def _run(
    sheet: np.ndarray, own: np.ndarray, fixed: np.ndarray, command_mm: np.ndarray, late_row: int, jitter_mm: np.ndarray, rows: np.ndarray
) -> None:
    """Fills `rows` [4, n]: rod and motor position (mm), current (A), voltage asked (V), each as it is when the row begins; the voltage from then on.

    `fixed`: anti-windup 1/s, gear ratio, lead mm, steps in a row, step s, rise of friction at rest from row `late_row` on, share of it that comes late.
    """
    csj, blk_mm, viscous, inertia, ohm, henry, gain, emf, supply, kp, ki = sheet
    bristle, bump, bump_speed, rod_kg, rod_share, stiffness, teeth, teeth_phase, pitch, pitch_phase, source, warming, dead = own
    windup, ratio, lead_mm, parts, step_s, late_rise, late_speed = fixed
    m_per_rad = 1e-3 * lead_mm / (2.0 * math.pi * ratio)
    gap_m = 0.5e-3 * blk_mm
    # damping ratios of a bristle and of a steel contact
    sigma_shaft = csj / bristle
    damped_shaft = 0.5 * math.sqrt(sigma_shaft * inertia)
    rod_N = rod_share * csj / m_per_rad
    bristle_m = 2e-6
    sigma_rod = rod_N / bristle_m
    damped_rod = 0.5 * math.sqrt(sigma_rod * rod_kg)
    damping = 0.3 * math.sqrt(stiffness * rod_kg)
    angle = speed = current = stretch = rod_m = rod_speed = rod_stretch = warm = 0.0
    integral = 0.0
    for row in range(command_mm.size):
        rows[0, row] = 1e3 * rod_m
        rows[1, row] = 1e3 * m_per_rad * angle
        rows[2, row] = current
        error_m = 1e-3 * (command_mm[row] - rows[1, row] - jitter_mm[row])
        raw = kp * error_m + integral
        out = min(max(raw, -1.0), 1.0)
        integral += 1e-3 * (ki * error_m + windup * (out - raw))
        asked = out * supply
        rows[3, row] = asked
        rise = late_rise if row >= late_row else 0.0
        for _ in range(int(parts)):
            volts = asked - dead * math.tanh(current / 0.2) - source * current
            hot = ohm * (1.0 + 0.0039 * warm)
            warm += step_s * warming * hot * current * current
            # the shaft's bristles
            size = abs(speed)
            level = csj * (1.0 + bump * math.exp(-size / bump_speed) + rise * math.exp(-((size / late_speed) ** 2)))
            level *= 1.0 + pitch * math.sin(angle / ratio + pitch_phase)
            # the bristles' own step is implicit: they settle within less than a step at full speed
            before = stretch
            stretch = (stretch + step_s * speed) / (1.0 + step_s * sigma_shaft * size / level)
            bent = (stretch - before) / step_s
            rub = sigma_shaft * stretch + damped_shaft * math.exp(-((size / 5.0) ** 2)) * bent + viscous * speed
            # the contact behind the gap
            apart = m_per_rad * angle - rod_m
            force = 0.0
            if apart > gap_m:
                force = max(stiffness * (apart - gap_m) + damping * (m_per_rad * speed - rod_speed), 0.0)
            elif apart < -gap_m:
                force = min(stiffness * (apart + gap_m) + damping * (m_per_rad * speed - rod_speed), 0.0)
            rod_size = abs(rod_speed)
            before = rod_stretch
            rod_stretch = (rod_stretch + step_s * rod_speed) / (1.0 + step_s * sigma_rod * rod_size / rod_N)
            rod_bent = (rod_stretch - before) / step_s
            rod_rub = sigma_rod * rod_stretch + damped_rod * math.exp(-((rod_size / 1e-3) ** 2)) * rod_bent
            pull = teeth * math.sin(24.0 * angle + teeth_phase)
            current += step_s * (volts - hot * current - emf * speed) / henry
            speed += step_s * (gain * current - rub - pull - m_per_rad * force) / inertia
            angle += step_s * speed
            rod_speed += step_s * (force - rod_rub) / rod_kg
            rod_m += step_s * rod_speed


def _noise(random: np.random.Generator, count: int, corner_hz: float) -> Reals:
    white = random.standard_normal(count)
    if corner_hz <= 0.0:
        return np.asarray(white)
    keeps = math.exp(-2.0 * math.pi * corner_hz * PERIOD_S)
    return np.asarray(signal.lfilter([math.sqrt(1.0 - keeps * keeps)], [1.0, -keeps], white))


def measured(one: Unit, changes: Mapping[str, float], command_mm: Reals, seed: int, scatter: float = 1.0) -> Recording:
    """A day's record: friction, grease and winding scatter as the truth plant's days do, by `seed`, with `scatter` times the usual; `changes` replace values of the sheet, `dead_V` of the
    bridge, and `late_rise` with `late_row` put a Stribeck bump there from a row on."""
    random = np.random.default_rng([15_485_863, seed])
    sheet = {**one.sheet, **{name: value for name, value in changes.items() if name in one.sheet}}
    degC = 2.0 * scatter * float(random.uniform(-1.0, 1.0)) if scatter > 1.0 else 0.0
    normal = random.standard_normal
    sheet["screw.csj_Nm"] *= (1.0 + 0.004 * scatter * float(normal())) * math.exp(-_DRY_PER_DEGC * degC)
    sheet["screw.viscous_Nm_s_per_rad"] *= (1.0 + 0.01 * scatter * float(normal())) * math.exp(-_GREASE_PER_DEGC * degC)
    sheet["motor.resistance_ohm"] *= (1.0 + 0.003 * scatter * float(normal())) * (1.0 + _COPPER_PER_DEGC * degC)
    own = dict(one.own)
    own["dead_V"] += changes.get("dead_V", 0.0)
    base = reference_actuator()
    parts = round(PERIOD_S / STEP_S)
    fixed = np.array(
        [
            base["control.anti_windup_per_s"],
            base["gearbox.ratio"],
            base["screw.lead_mm"],
            parts,
            PERIOD_S / parts,
            changes.get("late_rise", 0.0),
            8.0,
        ]
    )
    rows = np.empty((4, command_mm.size))
    jitter = 2e-4 * random.standard_normal(command_mm.size)
    _run(
        np.array([sheet[name] for name in _SHEET]),
        np.array([own[name] for name in _OWN]),
        fixed,
        np.ascontiguousarray(command_mm, dtype=float),
        int(changes.get("late_row", 0)),
        jitter,
        rows,
    )
    rod, motor, current, voltage = rows
    count = rod.size

    def counted(seen: Reals, step: float) -> Reals:
        return np.asarray(step * np.round(seen / step))

    return Recording(
        time_s=PERIOD_S * np.arange(count),
        command_mm=np.asarray(command_mm, dtype=float).copy(),
        position_mm=counted(
            rod * (1.0 + own["rod_gain"]) + own["rod_offset_mm"] + one.noise_mm * _noise(random, count, one.corner_hz), one.count_mm
        ),
        motor_position_mm=counted(motor + one.noise_mm * _noise(random, count, one.corner_hz), one.count_mm),
        current_A=counted(current * (1.0 + own["current_gain"]) + own["current_offset_A"] + 0.03 * normal(count), 0.01),
        voltage_V=counted(voltage + 0.01 * normal(count), 0.01),
        speed_mm_s=np.gradient(rod, PERIOD_S),
    )
