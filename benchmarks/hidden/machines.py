"""Machines by number: units of one data sheet, each with its own deviations, standing errors and sensors; and the same machines as the C model itself would be.

The truth plant shares no code with the module. Odd machines have LuGre friction whose contact yields a little before it slides, even ones Coulomb friction.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from benchmarks.truth import effects
from benchmarks.truth.climate import at_temperature
from benchmarks.truth.plant import Sensors, scattered, simulate_truth
from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.native import library

ROWS = 10_000
STEP_S = 1e-3
CHANNELS = ("position_mm", "motor_position_mm", "current_A", "voltage_V")
# A machine from run to run, relative standard deviation.
SCATTER: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}
# Units against the data sheet, relative standard deviation; torque and back-EMF constant are one property of the magnets.
UNITS: Mapping[tuple[str, ...], float] = {
    ("screw.csj_Nm",): 0.04,
    ("screw.viscous_Nm_s_per_rad",): 0.1,
    ("screw.inertia_kgm2",): 0.03,
    ("screw.blk_mm",): 0.05,
    ("motor.resistance_ohm",): 0.03,
    ("motor.inductance_H",): 0.05,
    ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad"): 0.015,
    ("drive.supply_V",): 0.005,
    ("control.kp_per_m",): 0.005,
}
# What every unit has a little of: standard deviations, absolute; of the ripple the middle size.
STANDING: Mapping[str, float] = {"screw.friction_asymmetry": 0.003, "encoder.rod_gain_error": 2e-4, "encoder.rod_offset_mm": 0.002}
RIPPLE = 0.004
CURRENT_GAIN, CURRENT_OFFSET_A = 0.003, 0.02
PRESLIDING_RAD = (1e-3, 3e-3)
# What the search takes for the distance of units from their data sheet: the one thing that is known here of the code under test, so that machines can defy it.
ASSUMED: Mapping[tuple[str, ...], float] = {
    ("screw.csj_Nm",): 0.1,
    ("screw.viscous_Nm_s_per_rad",): 0.2,
    ("screw.inertia_kgm2",): 0.05,
    ("screw.blk_mm",): 0.1,
    ("motor.resistance_ohm",): 0.04,
    ("motor.inductance_H",): 0.1,
    ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad"): 0.025,
    ("drive.supply_V",): 0.01,
    ("control.kp_per_m",): 0.005,
}
ASSUMED_STANDING: Mapping[str, float] = {"screw.friction_asymmetry": 0.004, "encoder.rod_gain_error": 3e-4, "encoder.rod_offset_mm": 0.003}


@dataclass(frozen=True)
class MachineSetting:
    """How machines of one kind of trial differ from the others: factor on SCATTER, days up to `temperature_degC` warmer or colder, units' deviations, sensors (fields of Sensors), values that
    stand on each, and whether the voltage is recorded at the motor. `text` says it in the document."""

    text: str = ""
    scatter: float = 1.0
    temperature_degC: float = 0.0
    units: Mapping[tuple[str, ...], float] = field(default_factory=lambda: UNITS)
    standing: Mapping[str, float] = field(default_factory=lambda: STANDING)
    ripple: float = RIPPLE
    sensors: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)
    at_terminals: bool = False


def _assumed_times(factor: float, text: str) -> MachineSetting:
    units = {names: factor * std for names, std in ASSUMED.items()}
    standing = {name: factor * std for name, std in ASSUMED_STANDING.items()}
    return MachineSetting(text, scatter=factor, units=units, standing=standing, ripple=factor * RIPPLE)


SETTINGS: Mapping[str, MachineSetting] = {
    "": MachineSetting(),
    "scatter": MachineSetting("four times the scatter, and days of +-8 degC", scatter=4.0, temperature_degC=8.0),
    "twice": _assumed_times(2.0, "units and scatter twice as wide as the search assumes"),
    "half": _assumed_times(0.5, "units and scatter half as wide as the search assumes"),
    "coloured": MachineSetting("noise of both positions with a corner at 30 Hz", sensors={"position_corner_hz": 30.0}),
    "counts_5um": MachineSetting(
        "positions in counts of 5 um", sensors={"position_resolution_mm": 0.005, "motor_position_resolution_mm": 0.005}
    ),
    "counts_20um": MachineSetting(
        "positions in counts of 20 um", sensors={"position_resolution_mm": 0.02, "motor_position_resolution_mm": 0.02}
    ),
    # every bridge and line loses a little, which the voltage asked for does not show and that of the motor does
    "terminals": MachineSetting(
        "voltage recorded at the motor, behind a bridge that drops 50 mV and 20 mohm of line",
        values={"inverter_dead_time.drop_V": 0.05, "inverter_dead_time.width_A": 0.2, "source_resistance.resistance_ohm": 0.02},
        at_terminals=True,
    ),
}


def width_of_units(parameter: str, setting: str) -> float:
    """Standard deviation by which the machines of a setting differ from their data sheet in a parameter, or, where that is more, by which the search takes them to."""
    chosen = SETTINGS[setting]
    widths = [of.get(parameter, 0.0) for of in (chosen.standing, ASSUMED_STANDING)]
    return max([*widths, *(std for of in (chosen.units, ASSUMED) for names, std in of.items() if parameter in names)])


COMMANDS: Mapping[str, tuple[str, Mapping[str, float]]] = {
    "chirp": ("chirp", {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0}),
    "fast chirp": ("chirp", {"amplitude_mm": 1.2, "start_hz": 0.2, "end_hz": 6.0, "duration_s": 10.0}),
    "slow chirp": ("chirp", {"amplitude_mm": 4.0, "start_hz": 0.05, "end_hz": 1.5, "duration_s": 10.0}),
    "multisine": ("multisine", {"amplitude_mm": 2.0, "start_hz": 0.3, "count": 8.0, "duration_s": 10.0}),
    "triangle": ("triangle", {"amplitude_mm": 2.0, "start_hz": 1.0}),
}
# The other command on which an added effect must hold.
HELD_OUT: Mapping[str, str] = {
    "chirp": "multisine",
    "fast chirp": "chirp",
    "slow chirp": "multisine",
    "multisine": "chirp",
    "triangle": "chirp",
}
# Integration steps: errors of 0.1 nm and 0.1 mA against ten times shorter ones; shorter where an effect is fast.
_STEP_S = 5e-5
_LUGRE_STEP_S = 1e-5
_FAST_STEP_S = 1e-5
_FAST = ("cogging_torque", "torque_ripple", "transmission_compliance", "elastic_stop", "dead_time_tanh", "dead_time_sign")
# Forms whose contact yields before it slides.
_YIELDING = ("presliding.stretch_rad", "elastic_backlash.gap_mm", "lugre.stretch_rad", "dahl.stretch_rad")


def seed_of(*parts: object) -> int:
    """A seed that hangs on its parts alone, the same in every process."""
    return zlib.crc32(repr(parts).encode())


@dataclass(frozen=True)
class Machine:
    """One unit: values by name where they differ from the data sheet, its friction law, sensors. `own` makes its records by the C model instead."""

    number: int
    values: Mapping[str, float]
    friction: str
    presliding_rad: float
    sensors: Sensors
    own: bool = False
    setting: str = ""

    @property
    def is_set(self) -> MachineSetting:
        """How it differs from the machines of most trials."""
        return SETTINGS[self.setting]

    @property
    def scatter(self) -> Mapping[str, float]:
        """From run to run, relative standard deviation."""
        return {name: self.is_set.scatter * std for name, std in SCATTER.items()}


@lru_cache(maxsize=64)
def machine(number: int, own: bool = False, setting: str = "") -> Machine:
    """The unit of that number in a setting of SETTINGS, the same draw in each. With `own` it is as the data sheet says, without standing errors: only scatter and noise are left."""
    chosen = SETTINGS[setting]
    random = np.random.default_rng([7_919, number])
    normal = random.standard_normal
    noise = Sensors(position_noise_mm=0.002, motor_position_noise_mm=0.002, current_noise_A=0.03, voltage_noise_V=0.01)
    if own:
        return Machine(number, {}, "coulomb", 0.0, noise, True)
    sheet = reference_actuator()
    values: dict[str, float] = {}
    for names, std in chosen.units.items():
        factor = 1.0 + std * float(np.clip(normal(), -2.0, 2.0))
        values |= {name: sheet[name] * factor for name in names}
    values |= {
        "pitch_ripple.ratio": chosen.ripple * float(random.uniform(0.3, 1.5)),
        "pitch_ripple.phase_rad": float(random.uniform(-np.pi, np.pi)),
        **{name: std * float(normal()) for name, std in chosen.standing.items()},
        **chosen.values,
    }
    sensors = Sensors(
        position_noise_mm=noise.position_noise_mm,
        motor_position_noise_mm=noise.motor_position_noise_mm,
        current_noise_A=noise.current_noise_A,
        voltage_noise_V=noise.voltage_noise_V,
        position_resolution_mm=5e-4,
        motor_position_resolution_mm=5e-4,
        current_resolution_A=0.01,
        voltage_resolution_V=0.01,
        current_gain_error=CURRENT_GAIN * float(normal()),
        current_offset_A=CURRENT_OFFSET_A * float(normal()),
        feedback_noise_mm=2e-4,
    )
    friction, presliding_rad = "lugre" if number % 2 else "coulomb", float(random.uniform(*PRESLIDING_RAD))
    return Machine(number, values, friction, presliding_rad, replace(sensors, **chosen.sensors), setting=setting)


@lru_cache(maxsize=16)
def command_mm(name: str) -> Reals:
    """Samples of a command of COMMANDS, [ROWS]."""
    kind, numbers = COMMANDS[name]
    return library(64).command(kind, dict(numbers), STEP_S, ROWS)


def _by_model(values: Mapping[str, float], command: Reals, sensors: Sensors, seed: int) -> Recording:
    names = {(f"effects.{name}" if hasattr(effects, name.partition(".")[0]) else name): value for name, value in values.items()}
    run = library(32).simulate(*reference_actuator().changed(names).arrays(), command)
    random = np.random.default_rng(seed)
    stds = (sensors.position_noise_mm, sensors.motor_position_noise_mm, sensors.current_noise_A, sensors.voltage_noise_V)
    seen = {
        channel: getattr(run, channel) + std * random.standard_normal(command.size) for channel, std in zip(CHANNELS, stds, strict=True)
    }
    return Recording(STEP_S * np.arange(command.size), command, speed_mm_s=run.speed_mm_s, **seen)


def simulated(unit: Machine, changes: Mapping[str, float], command: str, sensors: Sensors | None = None, seed: int = 0) -> Recording:
    """A run of the machine with `changes` to its values, seen through `sensors` (none: exactly)."""
    values = {**unit.values, **changes}
    if unit.own:
        return _by_model(values, command_mm(command), sensors or Sensors(), seed)
    soft = unit.friction == "lugre" or any(values.get(name, 0.0) > 0.0 for name in _YIELDING)
    fast = any(name.startswith(_FAST) for name in changes)
    step_s = _LUGRE_STEP_S if soft else _FAST_STEP_S if fast else _STEP_S
    return simulate_truth(
        values,
        command_mm(command),
        friction=unit.friction,
        presliding_rad=unit.presliding_rad,
        step_s=step_s,
        sensors=sensors,
        seed=seed,
        at_terminals=unit.is_set.at_terminals,
    )


def measured(unit: Machine, changes: Mapping[str, float], command: str, seed: int) -> Recording:
    """The same as recorded on some day: friction, grease and winding scatter, sensors err, both by `seed`. Changes are exact."""
    day = scattered(unit.values, unit.scatter, seed)
    moved = {name: day[name] for name in SCATTER}
    reach = unit.is_set.temperature_degC
    if reach > 0.0:
        moved = at_temperature(moved, reach * float(np.random.default_rng([7_907, seed]).uniform(-1.0, 1.0)))
    # a change of what scatters comes on top of its scatter
    for name in SCATTER:
        if name in changes:
            moved[name] *= changes[name] / unit.values.get(name, reference_actuator()[name])
    return simulated(unit, {**changes, **moved}, command, unit.sensors, seed + 1)


def exact(unit: Machine, changes: Mapping[str, float], command: str) -> Reals:
    """The true signals without noise and scatter, [CHANNELS, rows]; the sensors' gain and offset, being standing errors, included."""
    errors = unit.sensors
    run = simulated(unit, changes, command, Sensors(current_gain_error=errors.current_gain_error, current_offset_A=errors.current_offset_A))
    return np.array([getattr(run, channel) for channel in CHANNELS])


def scatter_directions(unit: Machine, command: str) -> list[Reals]:
    """What one standard deviation of each thing that differs from day to day makes of the true signals, [CHANNELS, rows]."""
    sheet = reference_actuator()
    nominal = {name: unit.values.get(name, sheet[name]) for name in SCATTER}
    ways = [[{name: value * (1.0 + sign * unit.scatter[name])} for sign in (1.0, -1.0)] for name, value in nominal.items()]
    if unit.is_set.temperature_degC > 0.0:
        std_degC = unit.is_set.temperature_degC / np.sqrt(3.0)
        ways.append([at_temperature(nominal, sign * std_degC) for sign in (1.0, -1.0)])
    return [np.asarray(0.5 * (exact(unit, up, command) - exact(unit, down, command))) for up, down in ways]


def unit_errors(unit: Machine, command: str) -> list[tuple[Reals, float]]:
    """How the unit may differ from its data sheet: per error, what one standard deviation makes of the true signals [CHANNELS, rows], and where the unit lies, in standard deviations.

    The contact's stretch is left aside: nobody's data sheet says it, and it is the same in every signature.
    """
    if unit.own:
        return []
    sheet = reference_actuator()

    def either_side(changes: Mapping[str, float]) -> Reals:
        up, down = (exact(unit, {name: unit.values[name] + sign * step for name, step in changes.items()}, command) for sign in (1.0, -1.0))
        return np.asarray(0.5 * (up - down))

    found = [
        (either_side({name: std * sheet[name] for name in names}), (unit.values[names[0]] / sheet[names[0]] - 1.0) / std)
        for names, std in unit.is_set.units.items()
    ]
    found += [(either_side({name: std}), unit.values[name] / std) for name, std in unit.is_set.standing.items()]
    healthy = exact(unit, {}, command)
    ripple = unit.values["pitch_ripple.ratio"] * np.exp(1j * unit.values["pitch_ripple.phase_rad"])
    for quarter in (1.0, 1j):
        moved = ripple + unit.is_set.ripple / np.sqrt(2.0) * quarter
        there = exact(unit, {"pitch_ripple.ratio": float(abs(moved)), "pitch_ripple.phase_rad": float(np.angle(moved))}, command)
        found.append((there - healthy, float(np.real(ripple * np.conj(quarter))) / (unit.is_set.ripple / np.sqrt(2.0))))
    current = CHANNELS.index("current_A")
    gain, offset = np.zeros_like(healthy), np.zeros_like(healthy)
    gain[current], offset[current] = CURRENT_GAIN * healthy[current], CURRENT_OFFSET_A
    return [*found, (gain, unit.sensors.current_gain_error / CURRENT_GAIN), (offset, unit.sensors.current_offset_A / CURRENT_OFFSET_A)]
