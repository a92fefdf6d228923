"""Hidden effects on the truth plant: how often the search names the right one, with five healthy repeats.

Run `python -m ema_tools.benchmarks.naming [--severity 1] [--seed 1] [EFFECT ...]`. The machine is the truth plant, which shares no code with the module; it differs from the data sheet
in inertia, resistance, grease and friction, scatters from run to run (friction 0.4 %, grease 1 %, winding 0.3 %) and is seen through 2 um and 30 mA of noise.
The search sees records alone. Severity 1 is the lower end of an effect's typical size.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from ema_tools.actuator import reference_actuator
from ema_tools.diagnosis.evidence import gather
from ema_tools.diagnosis.search import Diagnosis, diagnose
from ema_tools.native import library
from ema_tools.records import Record
from ema_tools.truth.plant import Sensors, scattered, simulate_truth

REPEATS = 5
ROWS = 10_000
STEP_S = 1e-3
SENSORS = Sensors(position_noise_mm=0.002, motor_position_noise_mm=0.002, current_noise_A=0.03)
SCATTER: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}
# What the data sheet does not say.
MACHINE: Mapping[str, float] = {"screw.csj_Nm": 0.141, "screw.viscous_Nm_s_per_rad": 1.1e-4, "screw.inertia_kgm2": 6.1e-5, "motor.resistance_ohm": 1.0, "pitch_ripple.ratio": 0.005}

# Lower end of each effect's typical size; the first value is its size.
MEDIUM: Mapping[str, Mapping[str, float]] = {
    "stribeck_friction": {"rise": 0.1, "speed_rad_s": 5.0},
    "presliding": {"stretch_rad": 0.02},
    "coulomb_asymmetry": {"asymmetry": 0.01},
    "constant_load": {"torque_Nm": 0.005},
    "viscous_asymmetry": {"asymmetry": 0.05},
    "load_dependent_friction": {"ratio": 0.02},
    "cogging_torque": {"amplitude_Nm": 0.0148, "periods": 12.0, "phase_rad": 0.7},
    "torque_ripple": {"ratio": 0.02, "periods": 6.0, "phase_rad": 0.5},
    "transmission_compliance": {"period_s": 0.02, "mass_kg": 2.0},
    "winding_heating": {"rise_degC": 30.0},
    "magnet_weakening": {"loss": 0.02},
    "inverter_dead_time": {"drop_V": 0.1},
    "supply_sag": {"sag": 0.02},
    "source_resistance": {"resistance_ohm": 0.05},
    "current_limit": {"limit_A": 7.0},
    "sensor_gain": {"error": 0.001},
    "sensor_offset": {"offset_mm": 0.01},
    "feedback_delay": {"delay_s": 2e-4},
    "actuation_delay": {"delay_s": 1e-4},
    "spring_load": {"stiffness_Nm_per_mm": 0.004},
    "viscous_rise": {"rise": 0.5},
    "concave_viscous": {"drag_Nm_per_sqrt_rad_s": 0.001},
    "quadratic_viscous": {"drag_Nm_s2_per_rad2": 1e-7},
    "jam_spot": {"amplitude_Nm": 0.02, "place_mm": 0.5, "width_mm": 0.1},
    "inertia_change": {"change": 0.05},
    "gain_drift": {"drift": 0.02},
}
# Effects that no record of one machine tells apart: naming one names the class.
CLASSES: Sequence[frozenset[str]] = (frozenset({"constant_load", "coulomb_asymmetry"}),)


@dataclass(frozen=True)
class Trial:
    """One hidden effect and what the search made of it; `run_s` its time."""

    hidden: str
    diagnosis: Diagnosis
    run_s: float

    @property
    def named(self) -> str:
        """The first effect named, or the verdict."""
        fit = self.diagnosis.fit
        return fit.effects[0] if fit is not None and self.diagnosis.verdict == "missing" else self.diagnosis.verdict

    @property
    def right(self) -> bool:
        """Whether the name or its class is right; for a healthy record, whether nothing is accused."""
        if self.hidden == "healthy":
            return self.named == "adequate"
        return self.named == self.hidden or any({self.named, self.hidden} <= kind for kind in CLASSES)


def measured(changes: Mapping[str, float], seed: int) -> Record:
    """One run of the machine with `changes`, as its sensors show it; scatter and noise by `seed`."""
    command = library(64).command("chirp", {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0}, STEP_S, ROWS)
    day = scattered(MACHINE, SCATTER, seed)
    run = simulate_truth({**day, **changes}, command, sensors=SENSORS, seed=seed + 1_000_000)
    return Record(STEP_S, run.command_mm, run.position_mm, run.motor_position_mm, run.current_A, run.voltage_V, file=f"run {seed}")


def trial(hidden: str, severity: float, seed: int) -> Trial:
    """Hides one effect, `healthy` for none, and searches for it."""
    sizes = dict(MEDIUM.get(hidden, {}))
    if sizes:
        size = next(iter(sizes))
        # a limit is the worse the lower it is
        sizes[size] = sizes[size] / severity if hidden == "current_limit" else sizes[size] * severity
    healthy = [measured({}, 100 * seed + k) for k in range(REPEATS)]
    record = measured({f"{hidden}.{field}": value for field, value in sizes.items()}, 100 * seed + 50)
    begun = time.perf_counter()
    found = diagnose(gather(reference_actuator(), record, healthy))
    return Trial(hidden, found, time.perf_counter() - begun)


def show(trials: Sequence[Trial]) -> None:
    """Prints a row per trial and the rate."""
    table = Table(title="hidden effect and what the search says")
    for heading in ("hidden", "named", "alike", "cost before", "after", "floor", "time, s"):
        table.add_column(heading, justify="left" if heading in ("hidden", "named", "alike") else "right")
    for one in trials:
        found = one.diagnosis
        name = " + ".join(found.fit.effects) if found.fit else found.verdict
        mark = "" if one.right else "  (wrong)"
        table.add_row(one.hidden, name + mark, ", ".join(found.alike), f"{found.cost_before:.0f}", f"{found.cost_after:.0f}", f"{found.cost_floor:.0f}", f"{one.run_s:.1f}")
    Console(width=140).print(table)
    Console().print(f"{sum(one.right for one in trials)} of {len(trials)} right; median {np.median([one.run_s for one in trials]):.1f} s")


def main() -> None:
    """Runs the trials asked for."""
    parser = argparse.ArgumentParser(description="Hidden effects on the truth plant")
    parser.add_argument("effects", nargs="*", help="effects to hide; all and a healthy record without any")
    parser.add_argument("--severity", type=float, default=1.0, help="times the medium size")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    unknown = [name for name in asked.effects if name not in MEDIUM and name != "healthy"]
    if unknown:
        parser.error(f"{unknown[0]}: no such effect: use one of healthy, {', '.join(MEDIUM)}")
    show([trial(name, asked.severity, asked.seed) for name in asked.effects or ["healthy", *MEDIUM]])


if __name__ == "__main__":
    main()
