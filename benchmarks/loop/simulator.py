"""A simulator of an actuator that shares no code and no equation form with the module, its reference or the other plants of the benchmarks.

Two masses, shaft and rod, meet through a spring and damper at either end of the play. The shaft's friction is elasto-plastic (P. Dupont et al., "Single state elastoplastic friction
models", IEEE Trans. Automatic Control 47(5), 2002); the rod's seal is Coulomb friction by implicit time stepping (J. J. Moreau, 1988). Winding and controller are written from physics and
from the meaning of the keys of an actuator file. Semi-implicit Euler, 100 kHz.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from scipy import signal

from ema_tools.base.arrays import Reals
from ema_tools.base.compiled import compiled
from ema_tools.base.recording import Recording

TICK_S = 1e-3
_STEPS_PER_TICK = 100
_ROD_KG, _SEAL_N = 0.4, 15.0
_CONTACT_N_PER_M, _CONTACT_N_S_PER_M = 3e7, 2.5e3
_BRISTLE_NM_PER_RAD, _BRISTLE_NM_S_PER_RAD = 900.0, 0.15
_ELASTIC_SHARE = 0.8  # of the bristle's largest deflection: below it nothing slides
_COPPER_PER_K = 0.00393
_BUS_S = 0.004  # time constant of the bus capacitor
# Columns of `_run`: values of a unit, then sizes of what is hidden, zero for none.
_UNIT = ("csj_Nm", "blk_mm", "inertia_kgm2", "viscous_Nm_s_per_rad", "torque_constant", "resistance_ohm", "inductance_H", "supply_V")
# Nominal values: those of actuators/reference.toml.
NOMINAL: Mapping[str, float] = dict(zip(_UNIT, (0.138, 0.033, 6e-5, 1e-4, 0.0612, 0.99, 8e-4, 24.0), strict=True))
# Relative standard deviation of units, and from run to run.
_UNITS: Mapping[str, float] = {"csj_Nm": 0.03, "blk_mm": 0.04, "inertia_kgm2": 0.02, "viscous_Nm_s_per_rad": 0.05, "torque_constant": 0.01}
_RUNS: Mapping[str, float] = {"csj_Nm": 0.004, "viscous_Nm_s_per_rad": 0.01, "resistance_ohm": 0.003}
# What can be hidden: medium size. The last two are in no library.
EFFECTS: Mapping[str, float] = {
    "stribeck_friction": 0.15,  # rise at rest, a share of CSJ
    "source_resistance": 0.08,  # ohm, behind it the bus capacitor
    "supply_sag": 0.03,  # share of the bus voltage
    "inverter_dead_time": 0.15,  # V
    "winding_heating": 30.0,  # K
    "torque_ripple": 0.03,  # share of the torque constant, six per turn with a second harmonic
    "cogging_torque": 0.0148,  # Nm, 24 per turn with a second harmonic
    "load_dependent_friction": 0.03,  # friction per torque that the screw transmits
    "current_gain": 0.03,  # error of the current sensor alone
    "actuation_delay": 2e-4,  # s
    "coulomb_asymmetry": 0.02,
    "encoder_eccentricity": 0.02,  # rad, once per motor turn, in the feedback
    "friction_lag": 0.3,  # share of CSJ that returns only some milliseconds after a reversal
}
OUTSIDE = ("current_gain", "encoder_eccentricity", "friction_lag")
_RUN_ORDER = (*_UNIT, *EFFECTS)


@compiled
def _run(command_m: Reals, values: Reals, phase: float, found: Reals) -> None:
    """Fills rod and encoder position (m), current (A), voltage asked for (V) and rod speed (m/s) at every tick, [5, ticks]."""
    csj, blk_mm, inertia, viscous, constant, resistance, inductance, bus = values[:8]
    rise, source, sag, dead, heat, ripple, cogging, loaded, _, delay, uneven, eccentric, lag = values[8:21]
    metres = 0.005 / (2.0 * math.pi * 4.0)
    half = 0.5e-3 * blk_mm
    dt = TICK_S / _STEPS_PER_TICK
    late = round(delay / dt)
    level = csj - _SEAL_N * metres
    angle, speed, bristle, current = 0.0, 0.0, 0.0, 0.0
    rod, rod_speed, integral = 0.0, 0.0, 0.0
    volts, volts_before, drawn, since = 0.0, 0.0, 0.0, 1.0
    way, torque = 1.0, 0.0
    for tick in range(command_m.size):
        # the PID of the actuator file: position loop on the motor encoder, output held over the tick
        seen = metres * (angle + eccentric * math.sin(angle + phase))
        error = command_m[tick] - seen
        wanted = 400.0 * error + integral
        duty = min(1.0, max(-1.0, wanted))
        integral += TICK_S * (400.0 * error + 50.0 * (duty - wanted))
        volts_before, volts = volts, duty
        found[0, tick], found[1, tick], found[2, tick], found[3, tick], found[4, tick] = rod, seen, current, duty * bus, rod_speed
        for step in range(_STEPS_PER_TICK):
            applied = volts if step >= late else volts_before
            drawn += dt / _BUS_S * (applied * current - drawn)
            terminal = applied * (bus * (1.0 - sag) - source * drawn) - dead * min(1.0, max(-1.0, current / 0.15))
            wave = math.sin(6.0 * angle + phase) + 0.2 * math.sin(12.0 * angle)
            gain = constant * (1.0 + ripple * wave)
            ohm = resistance * (1.0 + _COPPER_PER_K * heat)
            current += dt / inductance * (terminal - ohm * current - gain * speed)
            torque = min(1.48, max(-1.48, gain * current))
            if speed * way < 0.0:
                way, since = -way, 0.0
            since += dt
            # elasto-plastic: elastic below a share of the largest deflection, then a sine blend to sliding
            most = level * (1.0 + rise / math.cosh(speed / 10.0)) * (1.0 + uneven * (1.0 if speed > 0.0 else -1.0)) + loaded * abs(torque)
            most *= 1.0 - lag * math.exp(-since / 0.008)
            most /= _BRISTLE_NM_PER_RAD
            share = 0.0
            bent = abs(bristle) / most
            if bristle * speed > 0.0 and bent > _ELASTIC_SHARE:
                share = 1.0
                if bent < 1.0:
                    share = 0.5 - 0.5 * math.cos(math.pi * (bent - _ELASTIC_SHARE) / (1.0 - _ELASTIC_SHARE))
            # backward in the deflection, which settles within a fraction of a step at speed
            settled = (bristle + dt * speed) / (1.0 + dt * share * abs(speed) / most)
            yields = (settled - bristle) / dt
            bristle = settled
            rubs = _BRISTLE_NM_PER_RAD * bristle + _BRISTLE_NM_S_PER_RAD * yields
            # play: a spring and a damper that never pull
            gap = metres * angle - rod
            push = 0.0
            if gap > half:
                push = max(0.0, _CONTACT_N_PER_M * (gap - half) + _CONTACT_N_S_PER_M * (metres * speed - rod_speed))
            elif gap < -half:
                push = min(0.0, _CONTACT_N_PER_M * (gap + half) + _CONTACT_N_S_PER_M * (metres * speed - rod_speed))
            cogs = cogging * (math.sin(24.0 * angle + phase) + 0.2 * math.sin(48.0 * angle))
            speed += dt / inertia * (torque - viscous * speed - rubs - cogs - metres * push)
            angle += dt * speed
            free = rod_speed + dt / _ROD_KG * push
            rod_speed = math.copysign(max(0.0, abs(free) - dt / _ROD_KG * _SEAL_N), free)
            rod += dt * rod_speed


def unit_values(number: int) -> dict[str, float]:
    """The values of a unit: nominal ones with the deviations of that unit."""
    random = np.random.default_rng([31_337, number])
    return {name: value * (1.0 + _UNITS.get(name, 0.005) * float(np.clip(random.normal(), -2.0, 2.0))) for name, value in NOMINAL.items()}


def chirp_mm(ticks: int = 10_000, amplitude_mm: float = 2.0, start_hz: float = 0.1, end_hz: float = 4.0) -> Reals:
    """A linear sine sweep in mm, [ticks]."""
    time_s = TICK_S * np.arange(ticks)
    slope = (end_hz - start_hz) / (ticks * TICK_S)
    return np.asarray(amplitude_mm * np.sin(2.0 * math.pi * (start_hz * time_s + 0.5 * slope * time_s**2)))


def record(number: int, seed: Sequence[int], changes: Mapping[str, float], command_mm: Reals | None = None) -> Recording:
    """One run of unit `number`. `changes`: today's values by name of NOMINAL, and sizes by name of EFFECTS; `seed` decides run-to-run variation and noise.

    Raises KeyError for an unknown name.
    """
    unknown = set(changes) - set(_RUN_ORDER)
    if unknown:
        raise KeyError(", ".join(sorted(unknown)))
    random = np.random.default_rng(list(seed))
    values = {**dict.fromkeys(EFFECTS, 0.0), **unit_values(number), **changes}
    for name, std in _RUNS.items():
        values[name] *= 1.0 + std * float(random.normal())
    command = chirp_mm() if command_mm is None else command_mm
    found = np.zeros((5, command.size))
    _run(1e-3 * command, np.array([values[name] for name in _RUN_ORDER]), float(number), found)
    rod_mm, motor_mm, current_A, voltage_V, speed = 1e3 * found[0], 1e3 * found[1], found[2], found[3], 1e3 * found[4]
    # the rod's sensor is slow: its noise has a corner at 80 Hz
    keeps = math.exp(-2.0 * math.pi * 80.0 * TICK_S)
    coloured = signal.lfilter([math.sqrt(1.0 - keeps**2)], [1.0, -keeps], random.normal(size=command.size))

    def counts(signal_values: Reals, step: float) -> Reals:
        return np.asarray(step * np.round(signal_values / step))

    return Recording(
        time_s=TICK_S * np.arange(command.size),
        command_mm=command,
        position_mm=counts(rod_mm + 0.002 * coloured, 5e-4),
        motor_position_mm=counts(motor_mm + 0.001 * random.normal(size=command.size), 5e-4),
        current_A=counts((1.0 + values["current_gain"]) * current_A + 0.03 * random.normal(size=command.size), 0.01),
        voltage_V=counts(voltage_V + 0.01 * random.normal(size=command.size), 0.01),
        speed_mm_s=speed,
    )
