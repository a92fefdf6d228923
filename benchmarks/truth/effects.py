"""Every effect that the truth plant can hide: one small function each, and one sum per place where they act.

`v` is the record of all values by name, see `benchmarks.truth.plant`. An effect at its zero contributes nothing. To add
one: write its function under the name in `ema_effects.def` and add it to the sum of its place.
"""

from __future__ import annotations

import math
from typing import Any

from benchmarks.truth import forms
from benchmarks.truth.kept import kept_compiled


@kept_compiled
def stribeck_friction(v: Any, w: float) -> float:
    """Share of the level of dry friction by which it exceeds the level at high speed."""
    rise = v["stribeck_friction.rise"]
    if rise == 0.0:
        return 0.0
    return rise * math.exp(-((abs(w) / v["stribeck_friction.speed_rad_s"]) ** v["stribeck_friction.shape"]))


@kept_compiled
def elastic_backlash(v: Any) -> float:
    """Free way of what is behind the play, mm; 0 is none."""
    return v["elastic_backlash.gap_mm"]


@kept_compiled
def elastic_backlash_carried(v: Any, ahead_mm: float) -> float:
    """Share (-1 .. 1) of dry friction that the ends of the play carry when the shaft is ahead by so much of the middle: springs that only push."""
    half = 0.5 * v["elastic_backlash.gap_mm"]
    if ahead_mm > half:
        return (ahead_mm - half) / v["elastic_backlash.contact_mm"]
    if ahead_mm < -half:
        return (ahead_mm + half) / v["elastic_backlash.contact_mm"]
    return 0.0


@kept_compiled
def elastic_backlash_after(v: Any, ahead_mm: float, way_mm: float) -> float:
    """How far the shaft is ahead after a way in one direction: what is behind slides along once a spring carries all of the friction."""
    most = 0.5 * v["elastic_backlash.gap_mm"] + v["elastic_backlash.contact_mm"]
    return min(max(ahead_mm + way_mm, -most), most)


@kept_compiled
def cogging_torque(v: Any, theta: float) -> float:
    """Torque on the shaft, Nm."""
    amplitude = v["cogging_torque.amplitude_Nm"]
    if amplitude == 0.0:
        return 0.0
    return amplitude * math.sin(v["cogging_torque.periods"] * theta + v["cogging_torque.phase_rad"])


@kept_compiled
def constant_load(v: Any) -> float:
    """Torque against extension, Nm."""
    return v["constant_load.torque_Nm"]


@kept_compiled
def spring_load(v: Any, x_mm: float) -> float:
    """Torque against extension, Nm."""
    return v["spring_load.stiffness_Nm_per_mm"] * x_mm


@kept_compiled
def winding_heating(v: Any) -> float:
    """Resistance over the cold one."""
    return 1.0 + 0.00393 * v["winding_heating.rise_degC"]


@kept_compiled
def winding_warming(v: Any, warmer_degC: float) -> float:
    """Resistance over the one at the start."""
    if v["winding_warming.rise_degC_per_W"] == 0.0:
        return 1.0
    return 1.0 + forms.COPPER_PER_DEGC * warmer_degC


@kept_compiled
def winding_rate_degC_per_s(v: Any, warmer_degC: float, loss_W: float) -> float:
    """Rate of the winding's temperature over the start's: heat in, heat out, by the capacity that resistance and time constant make."""
    resistance = v["winding_warming.rise_degC_per_W"]
    if resistance == 0.0:
        return 0.0
    capacity = v["winding_warming.time_s"] / resistance
    return (loss_W - warmer_degC / resistance) / capacity


@kept_compiled
def grease_warming(v: Any, time_s: float) -> float:
    """Dry and viscous friction over those at the start."""
    if v["grease_warming.fall"] == 0.0:
        return 1.0
    return 1.0 + v["grease_warming.fall"] * math.expm1(-time_s / v["grease_warming.time_s"])


@kept_compiled
def directional_stribeck(v: Any, w: float, direction: float) -> float:
    """Share of the level of dry friction by which it exceeds the level at high speed."""
    rise = v["directional_stribeck.rise"] + direction * v["directional_stribeck.rise"] * v["directional_stribeck.asymmetry"]
    if rise == 0.0:
        return 0.0
    return rise / math.exp((abs(w) / v["directional_stribeck.speed_rad_s"]) ** v["directional_stribeck.shape"])


@kept_compiled
def load_dependent_stribeck(v: Any, torque_Nm: float, w: float) -> float:
    """Dry friction on top for the motor torque that passes the gears, Nm."""
    ratio = v["load_dependent_stribeck.ratio"]
    if ratio == 0.0:
        return 0.0
    return ratio * abs(torque_Nm) / math.exp((abs(w) / v["load_dependent_stribeck.speed_rad_s"]) ** v["load_dependent_stribeck.shape"])


@kept_compiled
def inverter_dead_time(v: Any, i: float) -> float:
    """Change of the motor voltage, V: the same drop and the same slope at zero current as the library's, rounded otherwise."""
    drop = v["inverter_dead_time.drop_V"]
    if drop == 0.0:
        return 0.0
    return -drop * math.tanh(i / v["inverter_dead_time.width_A"])


@kept_compiled
def feedback_delay(v: Any) -> float:
    """Added age of the feedback, s."""
    return v["feedback_delay.delay_s"]


@kept_compiled
def transmission_compliance(v: Any, gap_mm: float, gap_mm_s: float) -> float:
    """Force on the rod's mass in N for a spring compressed by `gap_mm` at `gap_mm_s`; 0 when the transmission is rigid."""
    period = v["transmission_compliance.period_s"]
    if period == 0.0:
        return 0.0
    mass = v["transmission_compliance.mass_kg"]
    pulsation = 2.0 * math.pi / period
    pull = pulsation * pulsation * gap_mm + 2.0 * v["transmission_compliance.damping_ratio"] * pulsation * gap_mm_s
    return 1e-3 * mass * pull


@kept_compiled
def rod_mass_kg(v: Any) -> float:
    """Mass behind the spring; 0 when the transmission is rigid."""
    if v["transmission_compliance.period_s"] == 0.0:
        return 0.0
    return v["transmission_compliance.mass_kg"]


@kept_compiled
def presliding(v: Any) -> float:
    """Deflection of the bristles at which the contact slides, rad; 0 when it sticks. LuGre's bristles are damped, Dahl's are not."""
    return v["presliding.stretch_rad"]


@kept_compiled
def coulomb_asymmetry(v: Any) -> float:
    """Share of the level by which dry friction is larger forward."""
    return v["coulomb_asymmetry.asymmetry"]


@kept_compiled
def viscous_asymmetry(v: Any, w: float) -> float:
    """Share of the damping by which it is larger at speed `w`."""
    return v["viscous_asymmetry.asymmetry"] * math.copysign(1.0, w)


@kept_compiled
def load_dependent_friction(v: Any, torque_Nm: float) -> float:
    """Dry friction on top for the motor torque that passes the gears, Nm."""
    return v["load_dependent_friction.ratio"] * abs(torque_Nm)


@kept_compiled
def pitch_ripple(v: Any, theta: float) -> float:
    """Share of the level of dry friction on top; one period is one turn of the screw."""
    ratio = v["pitch_ripple.ratio"]
    if ratio == 0.0:
        return 0.0
    return ratio * math.sin(theta / v["gearbox.ratio"] + v["pitch_ripple.phase_rad"])


@kept_compiled
def torque_ripple(v: Any, theta: float) -> float:
    """Torque constant and back-EMF over their mean."""
    ratio = v["torque_ripple.ratio"]
    if ratio == 0.0:
        return 1.0
    return 1.0 + ratio * math.cos(v["torque_ripple.periods"] * theta + v["torque_ripple.phase_rad"])


@kept_compiled
def magnet_weakening(v: Any) -> float:
    """Flux over the flux of sound magnets."""
    return 1.0 - v["magnet_weakening.loss"]


@kept_compiled
def supply_sag(v: Any) -> float:
    """Bus voltage over the nominal one."""
    return 1.0 - v["supply_sag.sag"]


@kept_compiled
def source_resistance(v: Any, i: float) -> float:
    """Voltage that the bus loses, V."""
    return v["source_resistance.resistance_ohm"] * abs(i)


@kept_compiled
def current_limit(v: Any) -> float:
    """Limit of the drive, A; 0 is none."""
    return v["current_limit.limit_A"]


@kept_compiled
def sensor_gain(v: Any) -> float:
    """Scale error of the rod sensor."""
    return v["sensor_gain.error"]


@kept_compiled
def sensor_offset(v: Any) -> float:
    """Zero shift of the rod sensor, mm."""
    return v["sensor_offset.offset_mm"]


@kept_compiled
def actuation_delay(v: Any) -> float:
    """Added age of the output when the motor sees it, s."""
    return v["actuation_delay.delay_s"]


@kept_compiled
def viscous_rise(v: Any) -> float:
    """Damping over the warm one."""
    return 1.0 + v["viscous_rise.rise"]


@kept_compiled
def concave_viscous(v: Any, w: float) -> float:
    """Drag on the shaft, Nm; rounded below 0.05 rad/s, where a film of grease creeps."""
    return v["concave_viscous.drag_Nm_per_sqrt_rad_s"] * w / math.sqrt(math.hypot(w, 0.05))


@kept_compiled
def quadratic_viscous(v: Any, w: float) -> float:
    """Drag on the shaft, Nm."""
    return v["quadratic_viscous.drag_Nm_s2_per_rad2"] * math.copysign(w * w, w)


@kept_compiled
def jam_spot(v: Any, x_mm: float) -> float:
    """Dry friction on top, Nm."""
    amplitude = v["jam_spot.amplitude_Nm"]
    if amplitude == 0.0:
        return 0.0
    z = (x_mm - v["jam_spot.place_mm"]) / v["jam_spot.width_mm"]
    return amplitude / math.exp(z * z)


@kept_compiled
def inertia_change(v: Any) -> float:
    """Total inertia over the nominal one."""
    return 1.0 + v["inertia_change.change"]


@kept_compiled
def gain_drift(v: Any) -> float:
    """Gain of the position loop over the nominal one."""
    return 1.0 + v["gain_drift.drift"]


@kept_compiled
def friction_Nm(v: Any, level: float, i: float, w: float, theta: float, x_mm: float, direction: float) -> float:
    """Dry friction against `direction` from the `level` without effects: dynamic while sliding, static at rest."""
    level *= 1.0 + direction * (v["screw.friction_asymmetry"] + coulomb_asymmetry(v))
    level *= 1.0 + stribeck_friction(v, w) + forms.stribeck(v, w) + pitch_ripple(v, theta) + directional_stribeck(v, w, direction)
    passed = torque_constant_Nm_per_A(v) * i
    return level + jam_spot(v, x_mm) + load_dependent_friction(v, passed) + load_dependent_stribeck(v, passed, w)


@kept_compiled
def drag_Nm(v: Any, w: float, time_s: float) -> float:
    """All torques against the motion that vanish at rest."""
    damping = v["screw.viscous_Nm_s_per_rad"] * viscous_rise(v) * forms.film_share(v, w) * grease_warming(v, time_s)
    return damping * (1.0 + viscous_asymmetry(v, w)) * w + concave_viscous(v, w) + quadratic_viscous(v, w)


@kept_compiled
def shaft_torque_Nm(v: Any, theta: float) -> float:
    """All torques on the shaft."""
    return cogging_torque(v, theta)


@kept_compiled
def load_Nm(v: Any, x_mm: float) -> float:
    """All torques against extension."""
    return v["screw.load_torque_Nm"] + constant_load(v) + spring_load(v, x_mm)


@kept_compiled
def inertia_kgm2(v: Any) -> float:
    """Total inertia."""
    return v["screw.inertia_kgm2"] * inertia_change(v)


@kept_compiled
def resistance_ohm(v: Any) -> float:
    """Winding resistance."""
    return v["motor.resistance_ohm"] * winding_heating(v)


@kept_compiled
def torque_constant_Nm_per_A(v: Any) -> float:
    """Mean torque per current."""
    return v["motor.torque_constant_Nm_per_A"] * magnet_weakening(v)


@kept_compiled
def back_emf_V_s_per_rad(v: Any) -> float:
    """Mean back-EMF per speed."""
    return v["motor.back_emf_V_s_per_rad"] * magnet_weakening(v)


@kept_compiled
def supply_V(v: Any) -> float:
    """Bus voltage without current."""
    return v["drive.supply_V"] * supply_sag(v)


@kept_compiled
def lost_voltage_V(v: Any, volt: float, i: float) -> float:
    """All changes of the motor voltage `volt`."""
    return inverter_dead_time(v, i) + forms.dead_time_tanh(v, i) - source_resistance(v, i) * (volt / supply_V(v))


@kept_compiled
def limit_A(v: Any) -> float:
    """The lowest limit of the drive; 0 is none."""
    built_in = v["drive.current_limit_A"]
    added = current_limit(v)
    if built_in > 0.0 and added > 0.0:
        return min(built_in, added)
    return max(built_in, added)


@kept_compiled
def output_age_s(v: Any) -> float:
    """Age of the output when the motor sees it."""
    return v["drive.output_delay_s"] + actuation_delay(v)


@kept_compiled
def feedback_age_s(v: Any) -> float:
    """Age of the feedback."""
    return v["encoder.delay_s"] + feedback_delay(v)


@kept_compiled
def rod_reading_mm(v: Any, rod_mm: float) -> float:
    """What the rod sensor shows."""
    gain = 1.0 + v["encoder.rod_gain_error"] + sensor_gain(v)
    return rod_mm * gain + v["encoder.rod_offset_mm"] + sensor_offset(v)
