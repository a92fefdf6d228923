"""The trials: every rival from every start on every problem, what the data determine at all, the session itself, and the baseline without a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.optimum import POSITION_ALONE
from benchmarks.searches import baseline
from benchmarks.searches.problems import KINDS, NOISE, WEIGHTED, Problem, identifiable, objective_of, problem, starts, truth_of
from benchmarks.searches.rivals import FEWER_STARTS, RIVALS, search
from ema_tools.data.actuator import reference_actuator
from ema_tools.plant.native import SearchSettings, library

_IDENTIFIED = ("screw.csj_Nm", "screw.blk_mm")
_SESSION, _DATA, _BASELINE = "session", "data", "baseline"
# Exact records say nothing more of eight values than noisy ones.
KINDS_OF: Mapping[int, Sequence[str]] = {2: KINDS, 8: KINDS[1:]}


@dataclass(frozen=True)
class Trial:
    """One search of a rival, or of "session", "data", "baseline", on a problem; `start` its number of `starts`."""

    values: int
    kind: str
    rival: str
    start: int
    starts: int

    @property
    def key(self) -> str:
        """By which an interrupted run is taken up again."""
        return f"{self.values}|{self.kind}|{self.rival}|{self.start}|{self.starts}"

    @property
    def group(self) -> str:
        """Of one problem."""
        return f"{self.values}_{self.kind}"


def trials(two: int, eight: int, kinds: Sequence[str] = KINDS, rivals: Sequence[str] = tuple(RIVALS)) -> list[Trial]:
    """Every rival from that many starts of two and of eight values, and what belongs to each problem."""
    found = []
    for values, count in ((2, two), (8, eight)):
        for kind in KINDS_OF[values] if count else ():
            if kind not in kinds:
                continue
            found += [Trial(values, kind, other, 0, count) for other in (_DATA, _BASELINE)]
            for start in range(count):
                found += [Trial(values, kind, name, start, count) for name in rivals if start < FEWER_STARTS.get(name, count)]
                found += [Trial(values, kind, _SESSION, start, count)] if values == 2 else []
    return found


def perform(trial: Trial) -> dict[str, Any]:
    """The row of one trial."""
    given = problem(trial.values, trial.kind)
    other: Mapping[str, Callable[[Problem, Trial], dict[str, Any]]] = {_SESSION: _session, _DATA: _data, _BASELINE: _baseline}
    work = other.get(trial.rival, _rival)
    return {"key": trial.key, **vars(trial), **work(given, trial)}


def _start(trial: Trial) -> np.ndarray:
    return np.asarray(starts(trial.values, trial.starts)[trial.start])


def _rival(given: Problem, trial: Trial) -> dict[str, Any]:
    found = search(given, trial.rival, _start(trial), trial.start + 1)
    theta = found.theta if found.theta is not None else np.full(given.dimension, np.nan)
    return {
        "runs": found.runs,
        "when": {name: list(one) for name, one in found.when.items()},
        "above": found.cost - given.lowest.cost,
        "off_percent": (100.0 * (theta - given.lowest.theta) / given.objective.scale).tolist(),
    }


def _session(given: Problem, trial: Trial) -> dict[str, Any]:
    """The session itself: it gives hopeless runs up early, and ends by itself."""
    actuator, objective = reference_actuator(), given.objective
    values, options = actuator.arrays()
    channels = objective.channels.copy()
    channels[:, 1:] = np.nan
    best: list[float] = []
    settings = SearchSettings(
        identified=_IDENTIFIED,
        lower=tuple(objective.lower),
        upper=tuple(objective.upper),
        min_shift_percent=(5.0, 10.0),
        start=tuple(objective.inside(_start(trial))),
        seed=trial.start + 1,
    )
    answer = library(32).identify(
        values, options, objective.command_mm, channels, settings, lambda _run, _cost, yet, _tried: best.append(yet)
    )
    there = np.flatnonzero(np.array(best) <= given.lowest.cost + given.level)
    off = (np.array([one.estimate for one in answer.identified]) - given.lowest.theta) / objective.scale
    return {
        "runs": answer.evaluations,
        "runs_noise": int(there[0]) + 1 if there.size else None,
        "full_runs": answer.model_steps / objective.command_mm.size,
        "above": answer.objective_after - given.lowest.cost,
        "off_percent": (100.0 * off).tolist(),
        "verdict": answer.verdict,
    }


def _data(given: Problem, trial: Trial) -> dict[str, Any]:
    """What the record determines: by the rod position alone and by all signals."""
    found = {}
    four = (WEIGHTED[0], WEIGHTED[1], WEIGHTED[2], WEIGHTED[3])
    for name, weight in (("position", POSITION_ALONE), ("all", four)):
        std, sizes, least = identifiable(objective_of(given.recording, trial.values, weight), given.lowest.theta)
        found[name] = {"std_percent": std.tolist(), "singular": sizes.tolist(), "least": least.tolist()}
    return {
        "titles": [one.title for one in given.objective.parameters],
        "lowest": given.lowest.theta.tolist(),
        "truth": truth_of(trial.values).tolist(),
        "scale": given.objective.scale.tolist(),
        "cost": given.lowest.cost,
        "rounding": given.lowest.rounding,
        "level": given.level,
        "noise": list(NOISE),
        "determined": found,
    }


def _baseline(given: Problem, trial: Trial) -> dict[str, Any]:
    found, seconds = baseline.estimates(given.recording)
    objective = given.objective
    names = [one.names[0] for one in objective.parameters]
    off = {
        one.title: 100.0 * (found[name] - true) / one.scale
        for one, name, true in zip(objective.parameters, names, truth_of(trial.values), strict=True)
        if name in found
    }
    return {"seconds": seconds, "off_percent": off}
