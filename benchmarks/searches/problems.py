"""What is searched: two values and eight, on records of the truth plant, exact, noisy, and with an effect that the model lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.stats import qmc

from benchmarks.optimum import POSITION_ALONE, Objective, Optimum, Parameter, optimum
from benchmarks.truth.plant import simulate_truth
from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.native import CHANNELS
from reference_model.commands import chirp, times_s

ROWS = 10_000
PERIOD_S = 0.001
# rms, in the order of CHANNELS; eight values need all four signals, each weighted by its noise.
NOISE = (0.005, 0.005, 0.03, 0.03)
WEIGHTED = tuple((NOISE[0] / one) ** 2 for one in NOISE)
_TURN = ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad")
TWO = (
    Parameter("CSJ", ("screw.csj_Nm",), 0.01, 1.5, 0.138, 0.138),
    Parameter("BLK", ("screw.blk_mm",), 0.0, 0.1, 0.033, 0.033),
)
EIGHT = (
    TWO[0],
    Parameter("dynamic over static friction", ("screw.dynamic_ratio",), 0.5, 1.0, 1.0, 1.0),
    Parameter("viscous friction", ("screw.viscous_Nm_s_per_rad",), 3e-5, 3e-4, 1e-4, 1e-4),
    TWO[1],
    Parameter("resistance", ("motor.resistance_ohm",), 0.7, 1.4, 0.99, 0.99),
    Parameter("torque constant", _TURN, 0.045, 0.075, 0.0612, 0.0612),
    Parameter("gain", ("control.kp_per_m",), 280.0, 520.0, 400.0, 400.0),
    # none when healthy: its shifts are counted in CSJ's
    Parameter("load", ("screw.load_torque_Nm",), -0.1, 0.1, 0.0, 0.138),
)
TRUTH: Mapping[int, Mapping[str, float]] = {
    2: {"screw.csj_Nm": 0.2, "screw.blk_mm": 0.05},
    8: {
        "screw.csj_Nm": 0.2,
        "screw.dynamic_ratio": 0.9,
        "screw.viscous_Nm_s_per_rad": 1.3e-4,
        "screw.blk_mm": 0.05,
        "motor.resistance_ohm": 1.1,
        _TURN[0]: 0.0612 * 0.96,
        _TURN[1]: 0.0612 * 0.96,
        "control.kp_per_m": 420.0,
        "screw.load_torque_Nm": 0.01,
    },
}
HIDDEN: Mapping[str, float] = {"stribeck_friction.rise": 0.2, "stribeck_friction.speed_rad_s": 10.0}
KINDS = ("exact", "noise", "hidden")
# Most model runs of one search: of two values the paper's shortest, of eight what is allowed onboard.
CAP = {2: 1500, 8: 2500}
_SEED = 11
_MULTI = 12


@dataclass(frozen=True)
class Problem:
    """One objective, its lowest point, and the cost up to which a point is as good as the sensor's noise can tell."""

    name: str
    objective: Objective
    lowest: Optimum
    level: float
    recording: Recording

    @property
    def dimension(self) -> int:
        """Number of values."""
        return len(self.objective.parameters)


@lru_cache(maxsize=8)
def _recording(values: int, hidden: bool) -> Recording:
    return simulate_truth({**TRUTH[values], **(HIDDEN if hidden else {})}, chirp(times_s(ROWS)))


def noisy(recording: Recording, seed: int) -> Recording:
    """With white noise of NOISE on every signal."""
    rng = np.random.default_rng(seed)
    shown = {name: getattr(recording, name) + std * rng.standard_normal(ROWS) for name, std in zip(CHANNELS, NOISE, strict=True)}
    return replace(recording, **shown)


def objective_of(recording: Recording, values: int, weight: tuple[float, float, float, float] | None = None) -> Objective:
    """Of `values` two or eight; two by the rod position alone, eight by all signals, unless told."""
    channels = np.column_stack([getattr(recording, name) for name in CHANNELS])
    four = (WEIGHTED[0], WEIGHTED[1], WEIGHTED[2], WEIGHTED[3])
    usual = POSITION_ALONE if values == 2 else four
    return Objective(reference_actuator(), TWO if values == 2 else EIGHT, recording.command_mm, channels, weight or usual)


def truth_of(values: int) -> Reals:
    """The true values, [p]."""
    return np.array([TRUTH[values][one.names[0]] for one in (TWO if values == 2 else EIGHT)])


@lru_cache(maxsize=8)
def problem(values: int, kind: str) -> Problem:
    """One of KINDS with two or eight values."""
    made = _recording(values, kind == "hidden")
    recording = made if kind == "exact" else noisy(made, _SEED)
    objective = objective_of(recording, values)
    spread = [objective.inside(unit) for unit in starts(values, _MULTI)]
    lowest = optimum(objective, [objective.healthy, truth_of(values), *(spread if values == 8 else [])], 16 if values == 2 else 0)
    return Problem(f"{values} {kind}", objective, lowest, NOISE[0] ** 2 * PERIOD_S + lowest.rounding, recording)


def starts(values: int, count: int) -> Reals:
    """Starts that fill the unit box, [count, p]."""
    rows = qmc.Sobol(values, seed=3).random_base2(int(np.ceil(np.log2(max(2, count)))))
    return np.asarray(0.02 + 0.96 * rows[:count])


def identifiable(objective: Objective, theta: Reals) -> tuple[Reals, Reals, Reals]:
    """Standard errors in % of the scales [p] under NOISE, singular values of the sensitivities over the noise [p], and the direction [p] that is determined least."""
    _, sizes, rows = np.linalg.svd(objective.jacobian(theta) / (NOISE[0] * np.sqrt(PERIOD_S)), full_matrices=False)
    covariance = (rows.T / np.maximum(sizes, 1e-12) ** 2) @ rows
    return 100.0 * np.sqrt(np.diag(covariance)), sizes, rows[-1]
