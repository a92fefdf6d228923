"""What is hidden and how large: for every effect the size called medium, and how its shape differs from machine to machine.

Medium is the lower end of the effect's typical size in the literature on such actuators; where that range begins at zero a sensible value is taken and said. Large is
three times it, small a third, edge a tenth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from benchmarks.hidden.machines import Machine, exact, seed_of
from ema_tools.data.actuator import reference_actuator

SEVERITIES: Mapping[str, float] = {"edge": 0.1, "small": 1.0 / 3.0, "medium": 1.0, "large": 3.0}
Shape = Callable[[np.random.Generator], Mapping[str, float]]


def _fixed(**values: float) -> Shape:
    return lambda random: values


def _phase(random: np.random.Generator) -> float:
    return float(random.uniform(-np.pi, np.pi))


def _log(random: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


@dataclass(frozen=True)
class Hidden:
    """One row: the value that is its size, what medium means, whether either sign occurs, the other values drawn per machine."""

    size: str
    medium: float
    signed: bool = False
    shape: Shape = field(default=_fixed())


LIBRARY: Mapping[str, Hidden] = {
    "stribeck_friction": Hidden("rise", 0.1, shape=lambda r: {"speed_rad_s": _log(r, 3.0, 30.0), "shape": float(r.uniform(1.0, 2.5))}),
    "directional_stribeck": Hidden(
        "rise",
        0.1,
        shape=lambda r: {
            "asymmetry": float(r.choice([-1.0, 1.0]) * r.uniform(0.4, 1.0)),
            "speed_rad_s": _log(r, 3.0, 30.0),
            "shape": float(r.uniform(1.0, 2.5)),
        },
    ),
    "load_dependent_stribeck": Hidden(
        "ratio", 0.05, shape=lambda r: {"speed_rad_s": _log(r, 3.0, 30.0), "shape": float(r.uniform(1.0, 2.5))}
    ),
    # 1 to 40 % within a record
    "grease_warming": Hidden("fall", 0.05, shape=lambda r: {"time_s": _log(r, 1.0, 10.0)}),
    "presliding": Hidden("stretch_rad", 0.02),
    # the lower end of a typical gap on a machine whose chirp reaches 2 mm
    "elastic_backlash": Hidden("gap_mm", 0.03, shape=lambda r: {"contact_mm": _log(r, 0.02, 0.1)}),
    "coulomb_asymmetry": Hidden("asymmetry", 0.01, True),
    # typical 0 to 0.1 Nm: a twentieth of its upper end
    "constant_load": Hidden("torque_Nm", 0.005, True),
    "viscous_asymmetry": Hidden("asymmetry", 0.05, True),
    "load_dependent_friction": Hidden("ratio", 0.02),
    "pitch_ripple": Hidden("ratio", 0.03, shape=lambda r: {"phase_rad": _phase(r)}),
    # 1 % of the stall torque of 1.48 Nm; periods of usual pairs of slots and poles
    "cogging_torque": Hidden(
        "amplitude_Nm", 0.0148, shape=lambda r: {"periods": float(r.choice([12, 18, 24, 36, 60, 72])), "phase_rad": _phase(r)}
    ),
    "torque_ripple": Hidden("ratio", 0.02, shape=lambda r: {"periods": float(r.choice([6, 12, 18, 24, 30])), "phase_rad": _phase(r)}),
    # 100 Hz, the stiff end of 20 .. 100 Hz
    "transmission_compliance": Hidden(
        "period_s", 0.01, shape=lambda r: {"mass_kg": _log(r, 2.0, 20.0), "damping_ratio": float(r.uniform(0.03, 0.1))}
    ),
    # typical 0 to 39 % of resistance: 12 %
    "winding_heating": Hidden("rise_degC", 30.0),
    # about 30 degC at the end of the chirp, which loses 5 to 8 W in the winding
    "winding_warming": Hidden("rise_degC_per_W", 6.0, shape=lambda r: {"time_s": _log(r, 2.0, 10.0)}),
    # typical 0 to 10 %
    "magnet_weakening": Hidden("loss", 0.02),
    "inverter_dead_time": Hidden("drop_V", 0.1, shape=lambda r: {"width_A": _log(r, 0.05, 0.5)}),
    "supply_sag": Hidden("sag", 0.02),
    "source_resistance": Hidden("resistance_ohm", 0.05),
    # a limit is felt only below the peak of the healthy current: medium takes 5 % off that
    "current_limit": Hidden("limit_A", 0.05),
    "sensor_gain": Hidden("error", 0.001, True),
    # typical to 0.1 mm: a tenth of that
    "sensor_offset": Hidden("offset_mm", 0.01, True),
    "feedback_delay": Hidden("delay_s", 2e-4),
    "actuation_delay": Hidden("delay_s", 1e-4),
    "spring_load": Hidden("stiffness_Nm_per_mm", 0.004),
    "viscous_rise": Hidden("rise", 0.5),
    "concave_viscous": Hidden("drag_Nm_per_sqrt_rad_s", 0.001),
    "quadratic_viscous": Hidden("drag_Nm_s2_per_rad2", 1e-7),
    "jam_spot": Hidden("amplitude_Nm", 0.02, shape=lambda r: {"place_mm": float(r.uniform(-1.0, 1.0)), "width_mm": _log(r, 0.1, 1.0)}),
    "inertia_change": Hidden("change", 0.05),
    "gain_drift": Hidden("drift", 0.02, True),
}
# The two fault parameters compete with the effects: relative changes.
FAULTS: Mapping[str, tuple[str, float]] = {"csj": ("screw.csj_Nm", 0.05), "blk": ("screw.blk_mm", 0.25)}
OUTSIDE: Mapping[str, Hidden] = {
    "broken_ball": Hidden("friction_Nm", 0.02, shape=lambda r: {"per_turn": float(r.uniform(2.3, 5.7)), "phase_rad": _phase(r)}),
    "encoder_eccentricity": Hidden("error_rad", 0.02, shape=lambda r: {"phase_rad": _phase(r)}),
    "lead_error": Hidden("amplitude_mm", 0.005, shape=lambda r: {"phase_rad": _phase(r)}),
    "bus_hum": Hidden("ratio", 0.03, shape=lambda r: {"frequency_hz": float(r.choice([50.0, 100.0])), "phase_rad": _phase(r)}),
    "speed_hump": Hidden(
        "drag_Nm", 0.01, shape=lambda r: {"speed_rad_s": float(r.uniform(50.0, 110.0)), "width_rad_s": float(r.uniform(8.0, 20.0))}
    ),
    "command_dead_band": Hidden("width_mm", 0.01),
    "magnetic_lag": Hidden("lag_A", 0.1, shape=lambda r: {"swing_A": float(r.uniform(0.5, 1.5))}),
    "integrator_leak": Hidden("rate_per_s", 1.0),
}


@dataclass(frozen=True)
class Form(Hidden):
    """An effect of the library in another form than the library's. Naming any of `counts_as` is right; naming one of `beside` as well is not wrong."""

    counts_as: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()


# Sizes as those of the effects that they stand for; `dead_time_tanh` is the form of every other dead time here, with an edge of any width.
FORMS: Mapping[str, Form] = {
    # the rise towards rest is LuGre's own Stribeck curve, a true part of what is hidden
    "lugre": Form(
        "stretch_rad",
        0.02,
        shape=lambda r: {
            "static_rise": float(r.uniform(0.02, 0.1)),
            "stribeck_rad_s": _log(r, 0.5, 3.0),
            "damping_ratio": float(r.uniform(0.2, 0.7)),
        },
        counts_as=("presliding",),
        beside=("stribeck_friction",),
    ),
    "dahl": Form("stretch_rad", 0.02, shape=lambda r: {"exponent": float(r.choice([0.5, 1.5, 2.0]))}, counts_as=("presliding",)),
    # the library has it at the exponent 2
    "stribeck_gauss": Form("rise", 0.1, shape=lambda r: {"speed_rad_s": _log(r, 3.0, 30.0)}, counts_as=("stribeck_friction",)),
    "stribeck_hess_soom": Form("rise", 0.1, shape=lambda r: {"speed_rad_s": _log(r, 3.0, 30.0)}, counts_as=("stribeck_friction",)),
    "stribeck_tustin": Form("rise", 0.1, shape=lambda r: {"speed_rad_s": _log(r, 3.0, 30.0)}, counts_as=("stribeck_friction",)),
    "dead_time_tanh": Form("drop_V", 0.1, shape=lambda r: {"width_A": _log(r, 0.02, 1.0)}, counts_as=("inverter_dead_time",)),
    "dead_time_sign": Form("drop_V", 0.1, counts_as=("inverter_dead_time",)),
    # about 30 degC at the end of the chirp, which loses 5 to 8 W in the winding
    "winding_and_housing": Form(
        "degC_per_W",
        6.0,
        shape=lambda r: {"time_s": _log(r, 1.0, 4.0), "housing_share": float(r.uniform(0.2, 0.5)), "housing_time_s": _log(r, 10.0, 40.0)},
        counts_as=("winding_warming",),
    ),
    # the film builds up, the drag of the grease stays
    "friction_fade": Form("share", 0.1, shape=lambda r: {"time_s": float(r.uniform(2.0, 5.0))}, counts_as=("grease_warming",)),
    # with the seal's 14 N a quarter more play, as the fault parameter's medium
    "elastic_stop": Form(
        "compliance_mm_per_N",
        3e-4,
        shape=lambda r: {"mass_kg": _log(r, 2.0, 5.0), "damping_ratio": float(r.uniform(0.1, 0.3))},
        counts_as=("blk", "transmission_compliance"),
    ),
}
# Effects that no record of one machine tells apart.
INSEPARABLE: tuple[frozenset[str], ...] = (frozenset({"constant_load", "coulomb_asymmetry"}),)


def same_class(one: str, other: str) -> bool:
    """Whether two names are one, or of one declared class."""
    return one == other or any({one, other} <= kind for kind in INSEPARABLE)


def stands_for(said: str, hidden: str) -> bool:
    """Whether a name says what is hidden: it is it or of its class, or what its form counts as."""
    return same_class(said, hidden) or (hidden in FORMS and any(same_class(said, name) for name in FORMS[hidden].counts_as))


@dataclass(frozen=True)
class Change:
    """A hidden effect on one machine: the values to simulate with, and by how much the value `size` of the model truly changes."""

    values: Mapping[str, float]
    size: str
    true: float


def _peak_A(unit: Machine, command: str) -> float:
    return float(np.abs(exact(unit, {}, command)[2]).max())


def change(unit: Machine, effect: str, factor: float, command: str) -> Change:
    """An effect of any table on a machine at `factor` of its medium size; its shape hangs on machine and effect alone."""
    if effect in FAULTS:
        name, medium = FAULTS[effect]
        healthy = unit.values.get(name, reference_actuator()[name])
        return Change({name: healthy * (1.0 + factor * medium)}, name, healthy * factor * medium)
    random = np.random.default_rng(seed_of("shape", unit.number, effect))
    row = next(table[effect] for table in (LIBRARY, OUTSIDE, FORMS) if effect in table)
    shape = {f"{effect}.{name}": value for name, value in row.shape(random).items()}
    sign = -1.0 if row.signed and random.random() < 0.5 else 1.0
    size, value = f"{effect}.{row.size}", sign * factor * row.medium
    if effect == "current_limit":
        value = _peak_A(unit, command) * max(1.0 - row.medium * factor, 0.3)
    standing = unit.values.get(size, 0.0)
    phase = f"{effect}.phase_rad"
    if effect in LIBRARY and standing != 0.0 and phase not in shape:
        return Change({size: standing + value}, f"effects.{size}", value)
    if effect in LIBRARY and standing != 0.0:
        # what stands there already and what comes on top add up as vectors
        total = standing * np.exp(1j * unit.values[phase]) + value * np.exp(1j * shape[phase])
        return Change({**shape, size: float(abs(total)), phase: float(np.angle(total))}, f"effects.{size}", value)
    yields = unit.presliding_rad if effect == "presliding" and unit.friction == "lugre" else 0.0
    return Change({**shape, size: value}, f"effects.{size}", value - yields)
