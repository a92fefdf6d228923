"""Vectors of parts that are called on their own: the control law, the commands, the random numbers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from reference_model import pid
from reference_model.actuator import build, filled
from reference_model.random import Pcg32
from reference_model.vectors.cases import REFERENCE_CHIRP, Command
from reference_model.vectors.records import samples

STEP_S = 1e-3
PID_SEED = 2024
PID_RUNS = 120
GRID_MM = 2.0**-10  # inputs on this grid are exact in float32


@dataclass(frozen=True)
class PidCase:
    """A control law driven by random steps; `values` as in `section.field`."""

    name: str
    shows: str
    values: dict[str, float]


PID_CASES: tuple[PidCase, ...] = (
    PidCase("error", "derivative of the error", {"control.kd_s_per_m": 1.5}),
    PidCase(
        "speed",
        "derivative of the averaged measured position",
        {"control.kd_s_per_m": 1.5, "control.derivative": 1, "control.average_speed": 1},
    ),
    PidCase(
        "anti_windup",
        "output saturated again and again",
        {"control.kp_per_m": 500.0, "control.ki_per_m_s": 8_000.0, "control.output_limit": 0.5},
    ),
    PidCase(
        "cascade",
        "position loop over speed loop, both saturated at times",
        {
            "control.structure": 1,
            "control.position_gain_per_s": 40.0,
            "control.speed_gain_s_per_m": 6.0,
            "control.speed_integral_per_m": 150.0,
            "control.speed_limit_m_s": 0.03,
            "control.average_speed": 1,
        },
    ),
)
PID_TOLERANCE = {"f64": 1e-13, "f32": 2e-5}
PID_WHY = (
    "float64: a few roundings of numbers near one; float32: the difference of two positions of a few mm, 2.4e-7 mm each,"
    " times the derivative gain over 1 ms"
)


def pid_rows(case: PidCase) -> np.ndarray:
    """Command mm, feedback mm and output of every run, [runs, 3]; the inputs are exact in float32."""
    control = build(filled(case.values)).control
    random = Pcg32(PID_SEED, sum(map(ord, case.name)))
    state = pid.at_rest()
    rows = np.empty((PID_RUNS, 3))
    command = feedback = 0.0
    for run in range(PID_RUNS):
        if run % 15 == 0:
            command = ((random.u32() >> 20) - 2048) * GRID_MM
        feedback += np.floor(0.08 * (command - feedback) / GRID_MM + ((random.u32() >> 27) - 15.5) / 4.0) * GRID_MM
        state = pid.run(control, STEP_S, 1e-3 * command, 1e-3 * feedback, state)
        rows[run] = command, feedback, state.output
    return rows


@dataclass(frozen=True)
class CommandCase:
    """A command read at every `every`-th step; `tolerance64` and `tolerance32` are shares of the amplitude."""

    name: str
    command: Command
    every: int
    tolerance64: float
    tolerance32: float
    why: str


_SWEEP = (
    "float64: the rate of the phase is held to 2^-64 turns per step squared, 1e-11 rad after 10^4 steps; float32: rounding of"
    " the frequencies to 6e-8, 8e-6 rad after 20 turns, and of the sine"
)
_LINES = "float64: rounding of nine sines; float32: rounding of the frequency, of the phases and of the sum of nine lines"
_RAMP = "float64: the place in the period is held to 2^-32; float32: rounding of frequency and share to 6e-8, two periods long"
COMMAND_CASES: tuple[CommandCase, ...] = (
    CommandCase("chirp", REFERENCE_CHIRP, 97, 5e-11, 2e-5, _SWEEP),
    CommandCase("chirp_held", Command("CHIRP", 1.5, 2.0, 20.0, 0.5), 13, 5e-11, 2e-5, _SWEEP),
    CommandCase("multisine", Command("MULTISINE", 2.0, 0.4, count=9), 41, 1e-12, 2e-5, _LINES),
    CommandCase("triangle", Command("TRIANGLE", 3.0, 1.25), 17, 1e-8, 5e-6, _RAMP),
    CommandCase("trapezoid", Command("TRAPEZOID", 3.0, 1.25, share=0.4), 17, 1e-8, 5e-6, _RAMP),
    CommandCase("step", Command("STEP", -2.5, time_s=0.25), 5, 0.0, 0.0, "the value is exact in float32"),
)
COMMAND_ROWS = 120


def command_rows(command: Command, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Step numbers and values in mm, [COMMAND_ROWS] each."""
    steps = np.arange(COMMAND_ROWS) * every
    return steps, samples(command, int(steps[-1]) + 1, STEP_S)[steps]


RANDOM_CASES: tuple[tuple[int, int], ...] = ((42, 54), (1, 0), (0, 0), (0xFFFF_FFFF_FFFF_FFFF, 0x7FFF_FFFF_FFFF_FFFF))
RANDOM_DRAWS = 32
NORMAL_TOLERANCE = {"f64": 0.0, "f32": 4e-6}
NORMAL_WHY = "sums of twelve 24-bit fractions: exact in float64, in float32 each addition rounds to 2.4e-7 or 4.8e-7"


def random_draws(seed: int, stream: int) -> list[int]:
    """The first numbers of 32 bits."""
    random = Pcg32(seed, stream)
    return [random.u32() for _ in range(RANDOM_DRAWS)]


def uniform_draws(seed: int, stream: int) -> list[float]:
    """The first uniforms in (0, 1): the upper 23 bits, plus a half, over 2^23. Exact in both precisions."""
    random = Pcg32(seed, stream)
    return [float(Fraction(2 * (random.u32() >> 9) + 1, 2**24)) for _ in range(RANDOM_DRAWS)]


def normal_draws(seed: int, stream: int) -> list[float]:
    """The first normals: the sum of twelve uniforms minus six. Float32 rounds the sum."""
    random = Pcg32(seed, stream)
    return [float(sum(Fraction(2 * (random.u32() >> 9) + 1, 2**24) for _ in range(12)) - 6) for _ in range(RANDOM_DRAWS)]
