"""What the machine of recordings/unit was made with. Only the truth plant reads this, and the demo for the last line that it prints.

One unit that no data sheet describes: its values differ from it by a few percent, its contact yields before it slides, its screw has a ripple, its friction differs by direction, its
sensors have gain and offset errors. Recorded three times when it was healthy, and on three days later: sound on a warm day, worn on a cold one, and with something that its model lacks.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

# Values by name where the unit differs from the data sheet.
UNIT: Mapping[str, float] = {
    "control.kp_per_m": 401.0,
    "screw.csj_Nm": 0.1325,
    "screw.viscous_Nm_s_per_rad": 1.12e-4,
    "screw.inertia_kgm2": 6.2e-5,
    "screw.blk_mm": 0.0315,
    "screw.friction_asymmetry": 0.003,
    "motor.resistance_ohm": 0.975,
    "motor.inductance_H": 8.3e-4,
    "motor.torque_constant_Nm_per_A": 0.0618,
    "motor.back_emf_V_s_per_rad": 0.0618,
    "drive.supply_V": 23.85,
    "encoder.rod_gain_error": 2.5e-4,
    "encoder.rod_offset_mm": 0.0015,
    "pitch_ripple.ratio": 0.0035,
    "pitch_ripple.phase_rad": -1.1,
}
# The shaft yields by this much before it slides: friction after LuGre.
YIELDS_RAD = 1.6e-3
# From run to run, relative standard deviation: dry friction, grease, winding.
SCATTER: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}
# Growth of the fault parameters of the worn unit, % of its healthy values.
CSJ_SHIFT_PERCENT = 20.0
BLK_SHIFT_PERCENT = 50.0
# What acts on the last day: the inverter's dead time, and how much voltage it takes off.
EFFECT = "inverter_dead_time"
EFFECT_VALUES: Mapping[str, float] = {"inverter_dead_time.drop_V": 0.3}

HEALTHY_RUNS = 3


@dataclass(frozen=True)
class Day:
    """One record: its file's name, what it shows, how much warmer than usual it was, and what is changed on the unit."""

    name: str
    title: str
    warmer_degC: float
    changes: Mapping[str, float] = field(default_factory=dict)


SOUND = Day("sound", "a later day", 3.0)
WORN = Day(
    "worn",
    "another day",
    -3.0,
    {
        "screw.csj_Nm": UNIT["screw.csj_Nm"] * (1.0 + 0.01 * CSJ_SHIFT_PERCENT),
        "screw.blk_mm": UNIT["screw.blk_mm"] * (1.0 + 0.01 * BLK_SHIFT_PERCENT),
    },
)
HIDDEN = Day("hidden", "one more day", 0.0, EFFECT_VALUES)
LATER = (SOUND, WORN, HIDDEN)


def healthy_day(run: int) -> Day:
    """The day of the healthy recording number `run`, from 1: they differ by 2 degC."""
    return Day(f"healthy_{run}", f"healthy, run {run} of {HEALTHY_RUNS}", run - 2.0)
