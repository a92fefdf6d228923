"""Every effect of the library as candidates: the shapes in which it may appear, each at a size that matches the evidence.

Play, delay and stiction are not differentiable at zero, so a signature is a difference of finite size. The size is found, not given: it is scaled until the
signature explains as much of the residual as it can.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ema_tools.definitions import Effect, load_definitions
from ema_tools.diagnosis.evidence import Evidence
from ema_tools.errors import InputError
from ema_tools.parallel import each

Reals = NDArray[np.float64]

# Changes of the two fault parameters compete with the effects, so that a fault is not named as an effect.
FAULTS: Mapping[str, str] = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}

_QUARTER = (0.0, 1.5707963, 3.1415926, -1.5707963)
# Values of shape parameters that are tried, by field; where a field has none it keeps its nominal value.
_SHAPES: Mapping[str, Mapping[str, Sequence[float]]] = {
    "stribeck_friction": {"speed_rad_s": (2.0, 6.0, 20.0, 50.0), "shape": (1.0, 2.0)},
    "cogging_torque": {"periods": (4.0, 6.0, 8.0, 9.0, 12.0, 18.0, 20.0, 24.0, 30.0, 36.0), "phase_rad": _QUARTER},
    "torque_ripple": {"periods": (2.0, 4.0, 6.0, 8.0, 12.0, 24.0), "phase_rad": _QUARTER},
    "pitch_ripple": {"phase_rad": _QUARTER},
    "transmission_compliance": {"mass_kg": (2.0, 6.0, 20.0)},
    "inverter_dead_time": {"width_A": (0.05, 0.3)},
}
_JAM_PLACES = 25
_JAM_WIDTHS = (0.12, 0.4)
# First size tried, as a share of an effect's range; then it is scaled by what the residual asks for.
_FIRST_SHARE = 0.002
_SCALINGS = 4
# Where the scatter of the healthy machine explains a small change, only a large one shows, and not in proportion: further first sizes for effects of one shape.
_LADDER = (1.0, 8.0, 30.0, 100.0)
# A limit acts only below what the signal reaches: shares of the largest current that are tried.
_LIMIT_SHARES = (0.98, 0.9, 0.75, 0.5)


@dataclass(frozen=True)
class Candidate:
    """One effect in one shape: names of its values, the size first, and where the size may lie."""

    effect: str
    size: str
    shape: Mapping[str, float]
    lower: float
    upper: float
    zero: float

    def changes(self, size: float) -> dict[str, float]:
        """The model's changed values at a size."""
        return {self.size: size, **self.shape}


@dataclass(frozen=True)
class Signature:
    """A candidate at the size that explains most: its vector [n] and by how much it lowers the cost of the residual."""

    candidate: Candidate
    size: float
    vector: Reals
    score: float

    def start(self) -> dict[str, float]:
        """Where a refit of the effect begins."""
        return self.candidate.changes(self.size)


def _shapes_of(effect: Effect, evidence: Evidence) -> list[dict[str, float]]:
    grid: dict[str, Sequence[float]] = dict(_SHAPES.get(effect.name, {}))
    if effect.name == "jam_spot":
        position = evidence.record.position_mm
        low, high = float(position.min()), float(position.max())
        grid = {"place_mm": tuple(np.linspace(low, high, _JAM_PLACES)), "width_mm": _JAM_WIDTHS}
    names = [f"effects.{effect.name}.{field}" for field in grid]
    return [dict(zip(names, values, strict=True)) for values in itertools.product(*grid.values())]


def candidates(evidence: Evidence, without: Sequence[str] = ()) -> list[Candidate]:
    """Every effect that the actuator does not hold yet, in every shape that is tried; and the fault parameters."""
    found = []
    for name, value in FAULTS.items():
        nominal = evidence.actuator[value]
        if name not in without and nominal > 0.0:
            found.append(Candidate(name, value, {}, 0.05 * nominal, 20.0 * nominal, nominal))
    for effect in load_definitions().effects:
        if effect.name not in without and effect.name not in evidence.actuator.active_effects:
            size = effect.size
            for shape in _shapes_of(effect, evidence):
                found.append(Candidate(effect.name, f"effects.{size.name}", shape, size.lower, size.upper, size.nominal))
    return found


def _first_sizes(candidate: Candidate, evidence: Evidence) -> list[float]:
    """Where the scaling begins: one per sign, or a ladder for a limit."""
    if candidate.effect == "current_limit":
        peak = float(np.max(np.abs(evidence.base[evidence.channels.index("current_A")]))) if "current_A" in evidence.channels else 8.0
        return [share * peak for share in _LIMIT_SHARES]
    up, down = candidate.upper - candidate.zero, candidate.zero - candidate.lower
    ladder = (1.0,) if len(_SHAPES.get(candidate.effect, {})) > 1 or candidate.effect == "jam_spot" else _LADDER
    return [candidate.zero + _FIRST_SHARE * rung * reach for reach in (up, -down) if reach != 0.0 for rung in ladder]


def _score(vector: Reals, residual: Reals) -> tuple[float, float]:
    """How far the size should be scaled, and the cost that it then takes off."""
    length = float(vector @ vector)
    if not length > 0.0:
        return 0.0, 0.0
    share = float(vector @ residual) / length
    kept = float(np.clip(share, 0.0, 2.0))
    return share, 2.0 * kept * float(vector @ residual) - kept * kept * length


def _matched(candidate: Candidate, first: float, evidence: Evidence, held: Mapping[str, float], held_vector: Reals, residual: Reals) -> Signature | None:
    best: Signature | None = None
    size = first
    for attempt in range(1 if candidate.effect == "current_limit" else _SCALINGS):
        try:
            vector = evidence.signature({**held, **candidate.changes(size)}) - held_vector
        except InputError:
            break
        share, score = _score(vector, residual)
        if best is None or score > best.score:
            best = Signature(candidate, size, vector, score)
        if share <= 0.0 or abs(share - 1.0) < 0.2:
            break
        reach = (1e-3, 1e3) if attempt == 0 else (0.1, 8.0)
        wanted = candidate.zero + (size - candidate.zero) * float(np.clip(share, *reach))
        wanted = float(np.clip(wanted, candidate.lower, candidate.upper))
        if wanted == size:
            break
        size = wanted
    return best


def signatures(evidence: Evidence, residual: Reals, held: Mapping[str, float], held_vector: Reals, without: Sequence[str] = ()) -> list[Signature]:
    """The best-matched signature of every candidate beside what is held already, strongest first; both cores at work."""
    tasks = [(candidate, first) for candidate in candidates(evidence, without) for first in _first_sizes(candidate, evidence)]
    found = each(lambda task: _matched(task[0], task[1], evidence, held, held_vector, residual), tasks)
    return sorted((signature for signature in found if signature is not None), key=lambda signature: -signature.score)
