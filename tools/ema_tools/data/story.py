"""What the machine of recordings/story was made with. Only the truth plant reads this, and the demo for the last line that it prints.

One unit that differs from its data sheet by a few percent; recorded five times when it was healthy, and today under two commands: CSJ and BLK have grown, and something acts that the
actuator file does not hold.
"""

from __future__ import annotations

from collections.abc import Mapping

# Values by name where the unit differs from the data sheet.
UNIT: Mapping[str, float] = {
    "screw.csj_Nm": 0.143,
    "screw.viscous_Nm_s_per_rad": 1.08e-4,
    "screw.inertia_kgm2": 5.85e-5,
    "screw.blk_mm": 0.0345,
    "motor.resistance_ohm": 1.015,
    "motor.inductance_H": 7.8e-4,
    "motor.torque_constant_Nm_per_A": 0.0605,
    "motor.back_emf_V_s_per_rad": 0.0605,
    "drive.supply_V": 24.1,
    "pitch_ripple.ratio": 0.003,
    "pitch_ripple.phase_rad": 0.8,
}
# From run to run, relative standard deviation: dry friction, grease, winding.
SCATTER: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}
# Growth of the fault parameters until today, % of the unit's healthy values.
CSJ_SHIFT_PERCENT = 40.0
BLK_SHIFT_PERCENT = 100.0
# What acts besides: stiction, the screw's friction being larger at low speed than at high.
EFFECT = "stribeck_friction"
EFFECT_VALUES: Mapping[str, float] = {"stribeck_friction.rise": 0.3}

HEALTHY_RUNS = 5
TODAY = "today"
HELD_OUT = "today_multisine"


def healthy_name(run: int) -> str:
    """Name of the healthy recording number `run`, from 1."""
    return f"healthy_{run}"


def today() -> dict[str, float]:
    """Values by name of the machine as it is today, without the scatter of the day."""
    worn = {
        "screw.csj_Nm": UNIT["screw.csj_Nm"] * (1.0 + 0.01 * CSJ_SHIFT_PERCENT),
        "screw.blk_mm": UNIT["screw.blk_mm"] * (1.0 + 0.01 * BLK_SHIFT_PERCENT),
    }
    return {**UNIT, **worn, **EFFECT_VALUES}
