"""Effects of the library in another form than the library's: the physics that a row of the list stands for, by another author's equation.

As in `effects`, `v` is the record of all values by name, and a form at its zero contributes nothing. `DEFAULTS` lists every value; the first of each form is its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from benchmarks.truth.kept import kept_compiled

# Relative change of a copper winding's resistance per degC, IEC 60028.
COPPER_PER_DEGC = 0.00393
# Speed below which the seal of a rod behind an elastic stop creeps, mm/s: rounds its dry friction.
_CREEP_MM_S = 1.0

DEFAULTS: Mapping[str, Mapping[str, float]] = {
    "lugre": {"stretch_rad": 0.0, "static_rise": 0.1, "stribeck_rad_s": 1.0, "damping_ratio": 0.5},
    "dahl": {"stretch_rad": 0.0, "exponent": 1.0},
    "stribeck_gauss": {"rise": 0.0, "speed_rad_s": 10.0},
    "stribeck_hess_soom": {"rise": 0.0, "speed_rad_s": 10.0},
    "stribeck_tustin": {"rise": 0.0, "speed_rad_s": 10.0, "viscous_share": 1.0},
    "dead_time_tanh": {"drop_V": 0.0, "width_A": 0.1},
    "dead_time_sign": {"drop_V": 0.0},
    "winding_and_housing": {"degC_per_W": 0.0, "time_s": 5.0, "housing_share": 0.4, "housing_time_s": 40.0},
    "friction_fade": {"share": 0.0, "time_s": 3.0},
    "elastic_stop": {"compliance_mm_per_N": 0.0, "mass_kg": 5.0, "damping_ratio": 0.2, "seal_share": 0.02},
}


@kept_compiled
def lugre(v: Any) -> float:
    """Deflection of the bristles at which the contact slides, rad; 0 is none. C. Canudas de Wit et al., IEEE Trans. Autom. Control 40 (1995)."""
    return v["lugre.stretch_rad"]


@kept_compiled
def lugre_level(v: Any, w: float) -> float:
    """Friction of steady sliding at speed `w` over its level at high speed, the Stribeck curve of LuGre's own paper."""
    return 1.0 + v["lugre.static_rise"] * math.exp(-((w / v["lugre.stribeck_rad_s"]) ** 2))


@kept_compiled
def dahl(v: Any) -> float:
    """Stretch of the contact at its first slope, rad; 0 is none. P. R. Dahl, AIAA J. 14 (1976)."""
    return v["dahl.stretch_rad"]


@kept_compiled
def dahl_after(v: Any, z: float, turn: float) -> float:
    """Share of the level (-1 .. 1) that the contact carries after a turn in one direction, rad: dz/dtheta = (1 - z sgn w)^exponent / stretch, integrated in closed form."""
    if turn == 0.0:
        return z
    side = math.copysign(1.0, turn)
    left = 1.0 - side * z
    length = abs(turn) / v["dahl.stretch_rad"]
    power = 1.0 - v["dahl.exponent"]
    if left <= 0.0:
        return side
    if power == 0.0:
        left *= math.exp(-length)
    else:
        left = max(left**power - power * length, 0.0) ** (1.0 / power)
    return side * (1.0 - left)


@kept_compiled
def stribeck(v: Any, w: float) -> float:
    """Share of the level of dry friction by which it exceeds the level at high speed: Gauss, Hess and Soom (J. Tribology 112, 1990), or Tustin."""
    more = 0.0
    if v["stribeck_gauss.rise"] != 0.0:
        z = w / v["stribeck_gauss.speed_rad_s"]
        more += v["stribeck_gauss.rise"] * math.exp(-z * z)
    if v["stribeck_hess_soom.rise"] != 0.0:
        z = w / v["stribeck_hess_soom.speed_rad_s"]
        more += v["stribeck_hess_soom.rise"] / (1.0 + z * z)
    if v["stribeck_tustin.rise"] != 0.0:
        more += v["stribeck_tustin.rise"] * math.exp(-abs(w) / v["stribeck_tustin.speed_rad_s"])
    return more


@kept_compiled
def film_share(v: Any, w: float) -> float:
    """Viscous friction over that of a full film: with Tustin's form the film builds up as the contact's share fades."""
    if v["stribeck_tustin.rise"] == 0.0:
        return 1.0
    return 1.0 - v["stribeck_tustin.viscous_share"] * math.exp(-abs(w) / v["stribeck_tustin.speed_rad_s"])


@kept_compiled
def dead_time_tanh(v: Any, i: float) -> float:
    """Change of the motor voltage, V."""
    drop = v["dead_time_tanh.drop_V"]
    if drop == 0.0:
        return 0.0
    return -drop * math.tanh(i / v["dead_time_tanh.width_A"])


@kept_compiled
def dead_time_sign(v: Any, i: float, free_V: float) -> float:
    """Change of the motor voltage, V, with a hard edge: against the current, and without current as much of `free_V`, what would drive it, as the drop can hold."""
    drop = v["dead_time_sign.drop_V"]
    if drop == 0.0:
        return 0.0
    if i != 0.0:
        return -math.copysign(drop, i)
    return -min(max(free_V, -drop), drop)


@kept_compiled
def stopped_at_zero(v: Any, before_A: float, after_A: float) -> float:
    """The current after a step: behind a hard edge it does not pass zero inside one."""
    if v["dead_time_sign.drop_V"] != 0.0 and before_A * after_A < 0.0:
        return 0.0
    return after_A


@kept_compiled
def hot_over_cold(v: Any, warmer_degC: float, housing_degC: float) -> float:
    """Winding resistance over its value at the start: the winding over its housing, and that over the air."""
    if v["winding_and_housing.degC_per_W"] == 0.0:
        return 1.0
    return 1.0 + COPPER_PER_DEGC * (warmer_degC + housing_degC)


@kept_compiled
def warmer_after(v: Any, warmer_degC: float, loss_W: float, dt: float) -> float:
    """Winding temperature over its housing's after `dt` of a steady loss."""
    resistance = v["winding_and_housing.degC_per_W"] * (1.0 - v["winding_and_housing.housing_share"])
    if resistance == 0.0:
        return 0.0
    last = resistance * loss_W
    return last + (warmer_degC - last) * math.exp(-dt / v["winding_and_housing.time_s"])


@kept_compiled
def housing_after(v: Any, housing_degC: float, loss_W: float, dt: float) -> float:
    """The housing's over the air's."""
    resistance = v["winding_and_housing.degC_per_W"] * v["winding_and_housing.housing_share"]
    if resistance == 0.0:
        return 0.0
    last = resistance * loss_W
    return last + (housing_degC - last) * math.exp(-dt / v["winding_and_housing.housing_time_s"])


@kept_compiled
def friction_fade(v: Any, time_s: float) -> float:
    """Dry friction over its level at the start: the film builds up while the screw runs in; the drag of the grease stays."""
    share = v["friction_fade.share"]
    if share == 0.0:
        return 1.0
    return 1.0 - share * (1.0 - math.exp(-time_s / v["friction_fade.time_s"]))


@kept_compiled
def stop_mass_kg(v: Any) -> float:
    """Mass of the rod between elastic stops; 0 when the stops are rigid. It is part of the total inertia."""
    if v["elastic_stop.compliance_mm_per_N"] == 0.0:
        return 0.0
    return v["elastic_stop.mass_kg"]


@kept_compiled
def stop_force_N(v: Any, gap_mm: float, gap_mm_s: float) -> float:
    """Force on the rod when the motor is ahead of it by `gap_mm`: none inside the play, a damped spring that only pushes at either end."""
    compliance = v["elastic_stop.compliance_mm_per_N"]
    half = 0.5 * v["screw.blk_mm"]
    if compliance == 0.0 or abs(gap_mm) <= half:
        return 0.0
    side = math.copysign(1.0, gap_mm)
    stiffness = 1.0 / compliance
    damping = 2.0 * v["elastic_stop.damping_ratio"] * math.sqrt(1e-3 * stiffness * v["elastic_stop.mass_kg"])
    return side * max(stiffness * (abs(gap_mm) - half) + side * damping * gap_mm_s, 0.0)


@kept_compiled
def seal_Nm(v: Any) -> float:
    """Part of the shaft's dry friction that sits at the rod's seal, expressed at the shaft, when the stops are elastic."""
    if v["elastic_stop.compliance_mm_per_N"] == 0.0:
        return 0.0
    return v["elastic_stop.seal_share"] * v["screw.csj_Nm"]


@kept_compiled
def seal_N(v: Any, speed_mm_s: float) -> float:
    """Friction of the rod's seal against its motion, N."""
    if v["elastic_stop.compliance_mm_per_N"] == 0.0:
        return 0.0
    n = 1e-3 * v["screw.lead_mm"] / (2.0 * math.pi * v["gearbox.ratio"])
    return seal_Nm(v) / n * math.tanh(speed_mm_s / _CREEP_MM_S)
