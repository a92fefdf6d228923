"""Where a chirp of the position command shows each effect of the library: block, state, frequency."""

from __future__ import annotations

from collections.abc import Mapping

SIGNATURES: Mapping[str, str] = {
    "stribeck_friction": "mechanical balance: extra friction in the moments around a reversal, strongest in the lowest third of the frequencies",
    "presliding": "mechanical balance: the first hundredths of a radian after each reversal, at all frequencies; nothing while sliding",
    "coulomb_asymmetry": "mechanical balance: a constant torque whenever the shaft moves, at all frequencies, as a constant load makes it",
    "constant_load": "mechanical balance: a constant torque at all frequencies; the integrator holds it, so the position hardly shows it",
    "viscous_asymmetry": "mechanical balance: torque that grows with the amount of speed and not with its sign; the upper two thirds of the frequencies",
    "load_dependent_friction": "mechanical balance: friction that grows with the torque of the motor, so with acceleration; the top third of the frequencies",
    "pitch_ripple": "mechanical balance: friction that repeats with every lead of the screw; the phase is another one after the screw was referenced again",
    "cogging_torque": "mechanical balance: a torque that repeats a whole number of times per motor turn, whatever the current; slow passages show it best",
    "torque_ripple": "mechanical and electrical balance: repeats with the motor's angle and grows with the current, so at accelerations",
    "transmission_compliance": "kinematic balance: rod minus motor position in step with the acceleration of the rod, growing with the square of the frequency",
    "winding_heating": "electrical balance: voltage in proportion to the current; the position shows it where currents are large, at the highest frequencies",
    "magnet_weakening": "mechanical and electrical balance at once: less torque per current and less back-EMF per speed, by the same share",
    "inverter_dead_time": "electrical balance: a voltage with the sign of the current, of equal height at all frequencies; with the position alone it looks like dry friction",
    "supply_sag": "electrical balance: a fixed share of the applied voltage; most at the highest speeds",
    "source_resistance": "electrical balance: voltage with the sign of the output that grows with output times current; only at large currents",
    "current_limit": "electrical balance and the current itself: nothing below a level, a cut at it; highest frequencies and starts",
    "sensor_gain": "kinematic balance: rod minus motor position in proportion to the position, the same at all frequencies",
    "sensor_offset": "kinematic balance: rod minus motor position shifted by a constant, the same at all frequencies",
    "feedback_delay": "controller balance: position error in proportion to speed; the top third of the frequencies, a phase that grows with frequency",
    "actuation_delay": "electrical balance: the applied voltage comes late, so the drive torque misses a share of the jerk; the top third of the frequencies, spikes at steps of the command",
    "spring_load": "mechanical balance: torque in proportion to the rod's position; the lowest frequencies, where little else acts",
    "viscous_rise": "mechanical balance: torque in proportion to speed; the upper frequencies",
    "concave_viscous": "mechanical balance: torque that grows with the root of speed; middle speeds",
    "quadratic_viscous": "mechanical balance: torque that grows with the square of speed; top speeds, the highest frequencies alone",
    "jam_spot": "mechanical balance: friction at one place of the stroke, on every pass and in both directions",
    "inertia_change": "mechanical balance: torque in proportion to acceleration; the top third of the frequencies",
    "gain_drift": "controller balance alone: output in proportion to the position error; the other balances stay clean",
    "learned_torque": "mechanical balance: whatever torque repeats against the axis of the table",
    "learned_friction": "mechanical balance: whatever change of the friction level repeats against the axis of the table",
    "learned_voltage": "electrical balance: whatever voltage repeats against the axis of the table",
    "learned_reading": "kinematic balance: whatever error of the rod sensor repeats against the axis of the table",
}
UNSTATED = "not stated: an effect of your own; ema diagnose ranks it by simulation"


def signature_of(effect: str) -> str:
    """Where a chirp shows the effect."""
    return SIGNATURES.get(effect, UNSTATED)
