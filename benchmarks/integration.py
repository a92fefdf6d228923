"""Which way to integrate the plant: discretisation error and cost of the usual choices beside the module's.

Run `python -m benchmarks.integration`. Every method runs the same control law at 1 kHz on the healthy reference actuator and the reference
chirp, and is compared with the reference model at a hundredth of the step with located events. The textbook methods decide on sticking and sliding
at the ends of their steps, as a fixed-step model does that does not locate its events.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from ema_tools.base.compiled import compiled
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.native import library
from reference_model import simulate

Reals = NDArray[np.float64]

STEP_S = 1e-3
ROWS = 10_000
GOAL_UM = 0.2
GOAL_MA = 1.0

# reference actuator: R, L, k, J, D, CSJ, bus, rod travel per angle in mm
_R, _L, _K, _J, _D, _CSJ, _BUS = 0.99, 8e-4, 0.0612, 6e-5, 1e-4, 0.138, 24.0
_LEAD = 5.0 / (2.0 * math.pi * 4.0)
_HALF_PLAY = 0.0165


@compiled
def _slopes(current: float, speed: float, voltage: float, friction: float) -> tuple[float, float]:
    """Rates of current and speed while the shaft slides."""
    return (voltage - _R * current - _K * speed) / _L, (_K * current - _D * speed - friction) / _J


@compiled
def _step(method: int, current: float, speed: float, voltage: float, h: float) -> tuple[float, float]:
    """One integration step; speed zero on entry and torque inside the static level means that the shaft rests."""
    at_rest = speed == 0.0 and abs(_K * current) <= _CSJ
    if at_rest:
        return voltage / _R + (current - voltage / _R) * math.exp(-h * _R / _L), 0.0
    friction = math.copysign(_CSJ, speed if speed != 0.0 else current)
    if method == 0:
        d_current, d_speed = _slopes(current, speed, voltage, friction)
        new_current, new_speed = current + h * d_current, speed + h * d_speed
    elif method == 1:
        level = (voltage - _K * speed) / _R
        new_current = level + (current - level) * math.exp(-h * _R / _L)
        new_speed = speed + h * (_K * new_current - _D * speed - friction) / _J
    else:
        a1, b1 = _slopes(current, speed, voltage, friction)
        a2, b2 = _slopes(current + 0.5 * h * a1, speed + 0.5 * h * b1, voltage, friction)
        a3, b3 = _slopes(current + 0.5 * h * a2, speed + 0.5 * h * b2, voltage, friction)
        a4, b4 = _slopes(current + h * a3, speed + h * b3, voltage, friction)
        new_current = current + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        new_speed = speed + h / 6.0 * (b1 + 2.0 * b2 + 2.0 * b3 + b4)
    if speed * new_speed < 0.0:
        new_speed = 0.0  # Borello: exactly zero for one step, then decide again
    return new_current, new_speed


@compiled
def _run(method: int, substeps: int, command_mm: Reals, out: Reals) -> None:
    """Rod position [mm] and current [A] at each row into `out` [2, rows]."""
    current, speed, angle, integral, play = 0.0, 0.0, 0.0, 0.0, 0.0
    h = STEP_S / substeps
    for row in range(command_mm.size):
        error = (command_mm[row] - _LEAD * angle) * 1e-3
        raw = 400.0 * error + integral
        output = min(max(raw, -1.0), 1.0)
        integral += STEP_S * (400.0 * error + 50.0 * (output - raw))
        out[0, row], out[1, row] = play, current
        for _ in range(substeps):
            previous = speed
            current, speed = _step(method, current, speed, output * _BUS, h)
            angle += 0.5 * h * (previous + speed) if method == 2 else h * speed
            play = min(max(play, _LEAD * angle - _HALF_PLAY), _LEAD * angle + _HALF_PLAY)


def measure() -> list[tuple[str, int, float, float]]:
    """Name, integration steps per tick, rms error of the rod position [um] and of the current [mA], per method."""
    values, options = reference_actuator().arrays()
    numbers = {"amplitude_mm": 2.0, "start_hz": 0.1, "end_hz": 4.0, "duration_s": 10.0}
    command = library(64).command("chirp", numbers, STEP_S, ROWS)
    truth = simulate({}, command, oversample=100)

    def errors(position_mm: Reals, current_A: Reals) -> tuple[float, float]:
        return (
            1e3 * float(np.sqrt(np.mean((position_mm - truth.position_mm) ** 2))),
            1e3 * float(np.sqrt(np.mean((current_A - truth.current_A) ** 2))),
        )

    rows: list[tuple[str, int, float, float]] = []
    for name, method in (("explicit Euler", 0), ("exact current, Euler speed", 1), ("Runge-Kutta 4", 2)):
        for substeps in (1, 10, 100) if method < 2 else (1, 4, 20):
            out = np.empty((2, ROWS))
            _run(method, substeps, command, out)
            rows.append((name, substeps, *errors(out[0], out[1])))
    for bits in (32, 64):
        run = library(bits).simulate(values, options, command)
        rows.append((f"exact update, located events (this module, float{bits})", 1, *errors(run.position_mm, run.current_A)))
    return rows


def main() -> None:
    """Print the table."""
    table = Table(title=f"Error on the reference chirp; goal {GOAL_UM} um and {GOAL_MA} mA rms")
    for heading in ("method", "steps per ms", "rod position, um rms", "current, mA rms", "meets the goal"):
        table.add_column(heading, justify="left" if heading == "method" else "right")
    for name, substeps, position_um, current_mA in measure():
        meets = position_um <= GOAL_UM and current_mA <= GOAL_MA
        table.add_row(name, str(substeps), f"{position_um:.5f}", f"{current_mA:.4f}", "yes" if meets else "no")
    Console(width=120).print(table)


if __name__ == "__main__":
    main()
