"""An actuator with ordinary days: every parameter of it varies from run to run, by temperature together and by itself. Shares no code and no equation form with the module, its reference
or the other plants of the benchmarks, and nothing is tuned to it.

Dry friction is LuGre's (C. Canudas de Wit et al., "A new model for control of systems with friction", IEEE Trans. Automatic Control 40(3), 1995). Shaft and rod meet over the play by a
contact that stiffens with depth (K. H. Hunt, F. R. E. Crossley, J. Applied Mechanics 42(2), 1975). What decays (winding, bristle) is advanced by its own exponential, what swings by
leapfrog, 50 kHz. The recorded voltage is what the controller asks for of a bus as the data sheet states it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy import signal

from benchmarks.loop.simulator import chirp_mm
from ema_tools.base.arrays import Reals
from ema_tools.base.compiled import compiled
from ema_tools.base.recording import Recording

TICK_S = 1e-3
_STEPS = 50  # of a tick
_SHEET_V = 24.0
_ROD_KG = 0.55
_DEPTH_N = 6e10  # contact force over depth to the power of 1.5, N / m^1.5
_LOSS_S_PER_M = 3.0
# Values of a machine: those of actuators/reference.toml where it has them.
MACHINE: Mapping[str, float] = {
    "dry_Nm": 0.138,
    "play_mm": 0.033,
    "inertia_kgm2": 6e-5,
    "grease_Nm_s": 1e-4,
    "flux_Nm_A": 0.0612,
    "winding_ohm": 0.99,
    "inductance_H": 8e-4,
    "bus_V": 24.0,
    "gain_per_m": 400.0,
    "bristle_Nm_per_rad": 60.0,
    "uneven": 0.0,  # friction to either side
    "rod_gain": 1.0,
    "rod_zero_mm": 0.0,
    "seal_Nm": 0.008,
    "standing_stribeck": 0.02,
    "standing_ripple": 0.006,
    "standing_cogging_Nm": 0.0006,
}
# Machines differ from their data sheet by these standard deviations, relative; of what the sheet gives as none or one, absolute.
_MACHINES: Mapping[str, float] = {
    "dry_Nm": 0.04,
    "play_mm": 0.04,
    "inertia_kgm2": 0.02,
    "grease_Nm_s": 0.06,
    "flux_Nm_A": 0.01,
    "winding_ohm": 0.012,
    "inductance_H": 0.03,
    "bus_V": 0.003,
    "bristle_Nm_per_rad": 0.2,
    "standing_stribeck": 0.4,
    "standing_ripple": 0.4,
    "standing_cogging_Nm": 0.4,
}
_MACHINES_ABSOLUTE: Mapping[str, float] = {"uneven": 0.003, "rod_gain": 2e-4, "rod_zero_mm": 0.002}
# A day: kelvin about the mean, what a kelvin makes of a value (relative), and what varies beside it.
DAY_K = 8.0
PER_K: Mapping[str, float] = {
    "winding_ohm": 0.0039,
    "grease_Nm_s": -0.022,
    "flux_Nm_A": -0.0011,
    "dry_Nm": -0.0018,
    "bristle_Nm_per_rad": -0.003,
}
DAYS: Mapping[str, float] = {
    "dry_Nm": 0.01,
    "grease_Nm_s": 0.02,
    "bus_V": 0.004,
    "winding_ohm": 0.002,
    "bristle_Nm_per_rad": 0.04,
    "seal_Nm": 0.05,
    "standing_stribeck": 0.1,
    "play_mm": 0.003,
    "inertia_kgm2": 0.001,
}
# What can be hidden: medium size, and the names of the library for it.
EFFECTS: Mapping[str, tuple[float, tuple[str, ...]]] = {
    "rise_at_rest": (0.18, ("stribeck_friction", "directional_stribeck", "load_dependent_stribeck")),
    "source_ohm": (0.09, ("source_resistance",)),
    "bus_low": (0.035, ("supply_sag",)),
    "dead_V": (0.2, ("inverter_dead_time",)),
    "hot_K": (28.0, ("winding_heating",)),
    "weak_magnets": (0.05, ("magnet_weakening",)),
    "torque_waves": (0.035, ("torque_ripple",)),
    "cogs_Nm": (0.013, ("cogging_torque",)),
    "screw_loads": (0.035, ("load_dependent_friction",)),
    "side_load_Nm": (0.012, ("constant_load", "coulomb_asymmetry")),
    "heavier": (0.09, ("inertia_change",)),
    "gain_off": (0.035, ("gain_drift",)),
    "late_s": (4e-4, ("feedback_delay",)),
    "soft_contact": (0.35, ("presliding", "elastic_backlash")),
    "drag_Nm_s2": (6e-8, ("quadratic_viscous", "viscous_rise")),
    "pitch_waves": (0.03, ("pitch_ripple",)),
    "limit_A": (0.35, ("current_limit",)),
    "sticks_at_place": (0.3, ("jam_spot",)),
}
# In no library.
OUTSIDE: Mapping[str, float] = {"slow_return": 0.35, "eccentric_rad": 0.025, "current_reads": 0.04, "bus_hum": 0.02}
_ORDER = (*MACHINE, *EFFECTS, *OUTSIDE)


@compiled
def _run(command_m: Reals, values: Reals, phase: float, found: Reals) -> None:
    """Fills rod (m), encoder (m), current (A) and voltage asked for (V) at every tick, [4, ticks]."""
    dry, play_mm, inertia, grease, flux, ohm, henry, bus, gain, stiff, uneven = values[:11]
    seal, stribeck, ripple, cogging = values[13:17]
    rise, source, low, dead, hot, weak, waves, cogs, loads, side, heavier, off, late, soft, drag, pitch, limit, sticks = values[17:35]
    slow, eccentric, _, hum = values[35:39]
    metres, h = 0.005 / (2.0 * math.pi * 4.0), TICK_S / _STEPS
    half = 0.5e-3 * play_mm
    inertia *= 1.0 + heavier
    flux *= 1.0 - weak
    ohm *= 1.0 + 0.0039 * hot
    stiff *= math.exp(-3.0 * soft)
    bus *= 1.0 - low
    most_A = 1e9 if limit <= 0.0 else 24.0 / 0.99 * 0.35 * math.exp(-1.25 * limit)
    angle, speed, bent, current = 0.0, 0.0, 0.0, 0.0
    rod, rod_speed, sum_up = 0.0, 0.0, 0.0
    asked = 0.0
    since, way = 1.0, 1.0
    seen_before = 0.0
    for tick in range(command_m.size):
        seen_now = metres * (angle + eccentric * math.sin(angle + phase))
        # an encoder that is late shows a value between the last two
        share = min(1.0, late / TICK_S)
        seen = seen_now + share * (seen_before - seen_now)
        seen_before = seen_now
        error = command_m[tick] - seen
        wanted = gain * (1.0 - off) * error + sum_up
        asked = min(1.0, max(-1.0, wanted))
        sum_up += TICK_S * (gain * error + 50.0 * (asked - wanted))
        found[0, tick], found[1, tick], found[2, tick], found[3, tick] = rod, seen_now, current, asked * _SHEET_V
        for step in range(_STEPS):
            t = TICK_S * tick + h * step
            rail = bus * (1.0 + 0.002 * math.sin(628.3 * t + phase) + hum * math.sin(314.2 * t)) - source * abs(current)
            volts = asked * rail - dead * math.tanh(current / 0.1)
            twist = flux * (1.0 + waves * math.sin(6.0 * angle + phase))
            # winding: exact over the step for a speed that stays
            decay = math.exp(-h * ohm / henry)
            current = decay * current + (1.0 - decay) * (volts - twist * speed) / ohm
            current = min(most_A, max(-most_A, current))
            drive = min(1.48, max(-1.48, twist * current))
            if speed * way < 0.0:
                way, since = -way, 0.0
            since += h
            level = dry + loads * abs(drive)
            level *= 1.0 + (stribeck + rise) * math.exp(-((speed / 9.0) ** 2)) + uneven * way
            level *= 1.0 + (ripple + pitch) * math.sin(0.25 * angle + phase)
            level *= 1.0 - slow * math.exp(-since / 0.01)
            place = 1e3 * metres * angle - 0.8
            level *= 1.0 + sticks * math.exp(-((place / 0.12) ** 2))
            # bristle: exact over the step for a speed that stays
            rate = stiff * abs(speed) / level
            keeps = math.exp(-h * rate)
            before = bent
            bent = keeps * bent + (h * speed if rate * h < 1e-9 else (1.0 - keeps) / rate * speed)
            rubs = stiff * bent + 0.12 * (bent - before) / h
            depth = metres * angle - rod
            closing = metres * speed - rod_speed
            push = 0.0
            if depth > half:
                deep = depth - half
                push = max(0.0, _DEPTH_N * deep * math.sqrt(deep) * (1.0 + _LOSS_S_PER_M * closing))
            elif depth < -half:
                deep = -half - depth
                push = -max(0.0, _DEPTH_N * deep * math.sqrt(deep) * (1.0 - _LOSS_S_PER_M * closing))
            waved = cogging * math.sin(12.0 * angle + 2.0 * phase) + cogs * math.sin(12.0 * angle + phase)
            turn = drive - rubs - waved - side - drag * speed * abs(speed) - metres * push
            # grease: implicit, since it only slows down
            speed = (speed + h / inertia * turn) / (1.0 + h / inertia * grease)
            angle += h * speed
            rod_speed = rod_speed + h / _ROD_KG * (push - seal / metres * math.tanh(rod_speed / 2e-4))
            rod += h * rod_speed


def machine_values(number: int) -> dict[str, float]:
    """The values of a machine on its mean day."""
    random = np.random.default_rng([60_133, number])
    found = dict(MACHINE)
    for name, std in _MACHINES.items():
        found[name] *= 1.0 + std * float(np.clip(random.normal(), -2.0, 2.0))
    for name, std in _MACHINES_ABSOLUTE.items():
        found[name] += std * float(np.clip(random.normal(), -2.0, 2.0))
    return found


def record(number: int, seed: Sequence[int], changes: Mapping[str, float], days: float = 1.0) -> Recording:
    """One run of machine `number` on a day of its own. `changes`: factors of values by name of MACHINE, and sizes by name of EFFECTS and OUTSIDE; `days`: how far days vary, 1 as usual.

    Raises KeyError for an unknown name.
    """
    unknown = set(changes) - set(_ORDER)
    if unknown:
        raise KeyError(", ".join(sorted(unknown)))
    random = np.random.default_rng(list(seed))
    values = {**machine_values(number), **dict.fromkeys((*EFFECTS, *OUTSIDE), 0.0)}
    warmer = days * DAY_K * float(np.clip(random.normal(), -2.0, 2.0)) / 2.0
    for name, share in PER_K.items():
        values[name] *= math.exp(share * warmer)
    for name, std in DAYS.items():
        values[name] *= math.exp(days * std * float(random.normal()))
    for name, change in changes.items():
        values[name] = values[name] * change if name in MACHINE else change
    command = chirp_mm()
    found = np.zeros((4, command.size))
    _run(1e-3 * command, np.array([values[name] for name in _ORDER]), float(number), found)
    rod_mm, motor_mm, current_A, voltage_V = 1e3 * found[0], 1e3 * found[1], found[2], found[3]
    # noise of the rod's sensor lasts 20 ms
    keeps = math.exp(-TICK_S / 0.02)
    lasting = signal.lfilter([math.sqrt(1.0 - keeps**2)], [1.0, -keeps], random.normal(size=command.size))

    def counts(values_: Reals, step: float) -> Reals:
        return np.asarray(step * np.round(values_ / step))

    rod_mm = values["rod_gain"] * rod_mm + values["rod_zero_mm"]
    return Recording(
        time_s=TICK_S * np.arange(command.size),
        command_mm=command,
        position_mm=counts(rod_mm + 0.003 * lasting, 0.005),
        motor_position_mm=counts(motor_mm, 1e-3),
        current_A=counts((1.0 + values["current_reads"]) * current_A + 0.03 * random.normal(size=command.size), 0.012),
        voltage_V=counts(voltage_V + 0.02 * random.normal(size=command.size), 0.006),
        speed_mm_s=np.gradient(rod_mm, TICK_S),
    )
