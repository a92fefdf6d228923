"""What the truth plant offers: a simulated machine, its sensors, its scatter from run to run. Deterministic by seed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import signal

from benchmarks.truth import effects, forms, kernel, outside
from ema_tools.base.recording import Recording
from ema_tools.library.definitions import defaults, load_definitions

_FRICTION_LAWS = {"coulomb": kernel.COULOMB, "lugre": kernel.LUGRE}
# Values that no list of the library holds.
_OWN: Mapping[str, Mapping[str, float]] = {**outside.DEFAULTS, **forms.DEFAULTS}


@dataclass(frozen=True)
class Sensors:
    """Errors of what is recorded: noise (rms), resolution (0 is exact), gain error and offset per channel.

    `feedback_noise_mm` is white noise that the position loop sees; it moves the machine itself. The noise of both positions is white, or with `position_corner_hz` a first-order
    autoregression with that corner and the same rms.
    """

    position_noise_mm: float = 0.0
    motor_position_noise_mm: float = 0.0
    current_noise_A: float = 0.0
    position_resolution_mm: float = 0.0
    motor_position_resolution_mm: float = 0.0
    current_resolution_A: float = 0.0
    motor_position_gain_error: float = 0.0
    motor_position_offset_mm: float = 0.0
    current_gain_error: float = 0.0
    current_offset_A: float = 0.0
    voltage_noise_V: float = 0.0
    voltage_resolution_V: float = 0.0
    feedback_noise_mm: float = 0.0
    position_corner_hz: float = 0.0


def _values(values: Mapping[str, float]) -> np.void:
    """All values by name in one record, as the kernel reads them."""
    known = load_definitions()
    complete = {**defaults(), **{f"{name}.{field}": value for name, fields in _OWN.items() for field, value in fields.items()}}
    for name, value in values.items():
        if name.partition(".")[0] not in _OWN:
            known.find(name)
        elif name not in complete:
            raise KeyError(name)
        complete[name] = float(value)
    for effect in known.effects:
        if effect.is_learned and complete[effect.size.name] != effect.size.nominal:
            raise ValueError(f"{effect.name}: no machine has a learned table: leave its {effect.size.field} at zero")
        if complete[effect.size.name] != effect.size.nominal and not hasattr(effects, effect.name):
            raise ValueError(f"{effect.name}: the truth plant cannot hide it yet: write it in truth/effects.py")
    kind = np.dtype([(name, np.float64) for name in complete])
    return np.array([tuple(complete.values())], dtype=kind)[0]


def _drawn(rng: np.random.Generator, count: int, keeps: float) -> np.ndarray:
    """Noise of variance 1, [count], of which the share `keeps` stays from one sample to the next: 0 is white."""
    white = rng.standard_normal(count)
    if keeps == 0.0:
        return white
    fresh = math.sqrt(1.0 - keeps * keeps)
    white[:1] /= fresh  # as long ago as if it had always run
    return np.asarray(signal.lfilter([fresh], [1.0, -keeps], white))


def _seen(
    true: np.ndarray, noise: float, gain_error: float, offset: float, resolution: float, rng: np.random.Generator, keeps: float = 0.0
) -> np.ndarray:
    """A channel as a sensor shows it; noise is drawn even when it is zero, so that channels do not share numbers. `keeps`: see `_drawn`."""
    shown = true * (1.0 + gain_error) + offset + noise * _drawn(rng, true.size, keeps)
    if resolution > 0.0:
        shown = resolution * np.floor(shown / resolution + 0.5)
    return shown


def simulate_truth(
    values: Mapping[str, float],
    command_mm: np.ndarray,
    *,
    start_mm: float = 0.0,
    friction: str = "coulomb",
    presliding_rad: float = 2e-4,
    step_s: float | None = None,
    sensors: Sensors | None = None,
    seed: int = 0,
    at_terminals: bool = False,
) -> Recording:
    """Run the machine that `values` describe (missing ones nominal) and record it.

    `command_mm` [steps]: held over one model step each. `friction`: "coulomb", or "lugre" whose shaft yields by
    `presliding_rad` before it slides. `step_s`: longest integration step, 10 us (2 us for LuGre) unless told. `seed` decides
    the noise of `sensors`. The effect `presliding` makes the friction LuGre's with that effect's own stretch.
    Effects outside the library go by their names in `outside`, such as "broken_ball.friction_Nm", other forms of its effects by those in `forms`. `at_terminals`: the
    recorded voltage is the motor's own, behind dead time, source and delay, instead of the one asked for.
    Raises KeyError for an unknown name, ValueError for an unknown friction law or an effect that the plant does not have.
    """
    if friction not in _FRICTION_LAWS:
        raise ValueError(f"friction = {friction!r}: unknown: use one of {', '.join(_FRICTION_LAWS)}")
    record = _values(values)
    errors = sensors or Sensors()
    rng = np.random.Generator(np.random.PCG64(seed))
    command = np.ascontiguousarray(command_mm, dtype=float)
    law = _FRICTION_LAWS[friction]
    if effects.presliding(record) > 0.0:
        law = kernel.LUGRE
        presliding_rad = effects.presliding(record)
    if forms.lugre(record) > 0.0:
        law = kernel.LUGRE
        presliding_rad = forms.lugre(record)
    if forms.dahl(record) > 0.0:
        law = kernel.DAHL
    if effects.elastic_backlash(record) > 0.0:
        law = kernel.PLAY
    if record["dead_time_sign.drop_V"] > 0.0 and record["motor.inductance_H"] == 0.0:
        raise ValueError("dead_time_sign: a winding without inductance has no hard edge: use dead_time_tanh")
    finest = step_s or (1e-5 if law == kernel.COULOMB else 2e-6)
    parts = math.ceil(float(record["timing.step_s"]) / finest - 1e-9)
    rows = np.empty((5, command.size))
    noise = errors.feedback_noise_mm * rng.standard_normal(command.size)
    kernel.run(record, command, float(start_mm), law, presliding_rad, parts, noise, at_terminals, rows)

    every = int(record["timing.record_every_steps"])
    period_s = every * float(record["timing.step_s"])
    keeps = math.exp(-2.0 * math.pi * errors.position_corner_hz * period_s) if errors.position_corner_hz > 0.0 else 0.0
    position, motor, current, voltage, speed = (channel[::every].copy() for channel in rows)
    return Recording(
        time_s=np.arange(position.size) * period_s,
        command_mm=command[::every].copy(),
        position_mm=_seen(position, errors.position_noise_mm, 0.0, 0.0, errors.position_resolution_mm, rng, keeps),
        motor_position_mm=_seen(
            motor,
            errors.motor_position_noise_mm,
            errors.motor_position_gain_error,
            errors.motor_position_offset_mm,
            errors.motor_position_resolution_mm,
            rng,
            keeps,
        ),
        current_A=_seen(
            current, errors.current_noise_A, errors.current_gain_error, errors.current_offset_A, errors.current_resolution_A, rng
        ),
        voltage_V=_seen(voltage, errors.voltage_noise_V, 0.0, 0.0, errors.voltage_resolution_V, rng),
        speed_mm_s=speed,
    )


def scattered(values: Mapping[str, float], relative_std: Mapping[str, float], seed: int) -> dict[str, float]:
    """The same machine on another day: each value named in `relative_std` is multiplied by 1 + std * normal, kept in its range."""
    known = load_definitions()
    rng = np.random.Generator(np.random.PCG64(seed))
    changed = {**defaults(), **values}
    for name, std in sorted(relative_std.items()):
        row = known.find(name)
        changed[name] = float(min(max(changed[name] * (1.0 + std * rng.standard_normal()), row.lower), row.upper))
    return changed
