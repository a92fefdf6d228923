"""The document of the accuracy trials: tables beside the paper's figures, and which limits were missed."""

from __future__ import annotations

import numpy as np

from benchmarks.accuracy import (
    EVALUATION_BUDGET,
    NOISE_LIMIT_RATIO,
    NOISE_MM,
    OWN_LIMIT_PERCENT,
    TRUTH_LIMIT_PERCENT,
    SearchTrial,
)
from benchmarks.speed import Measured
from ema_tools.base.arrays import Reals
from ema_tools.data.cases import CASES, PaperCase

_FAULTS = ("csj_Nm", "blk_mm")
_NAMES = ("CSJ", "BLK")


def missed(own: list[SearchTrial], truth: list[SearchTrial], noise: list[SearchTrial], bounds: list[Reals]) -> list[str]:
    """One line per limit that was not kept."""
    problems = []
    for title, trials, limits in (("own record", own, OWN_LIMIT_PERCENT), ("truth plant's record", truth, TRUTH_LIMIT_PERCENT)):
        for trial in trials:
            for name, worst, limit in zip(_NAMES, trial.worst_percent(), limits, strict=True):
                if worst > limit:
                    problems.append(
                        f"case {trial.letter}, {title}: {name} is off by {worst:.2g} %, limit {limit:g} %: look at the search's settings"
                    )
    for trial, bound in zip(noise, bounds, strict=True):
        for name, ratio in zip(_NAMES, trial.rms_percent() / bound, strict=True):
            if ratio > NOISE_LIMIT_RATIO:
                problems.append(
                    f"case {trial.letter}, noise: {name} scatters {ratio:.2f} x the Cramer-Rao bound, limit {NOISE_LIMIT_RATIO:g}: look at the search's end"
                )
    for trial in (*own, *truth, *noise):
        if np.max(trial.evaluations) > EVALUATION_BUDGET:
            problems.append(
                f"case {trial.letter}: {np.max(trial.evaluations):.0f} model runs, limit {EVALUATION_BUDGET}: look at the budget"
            )
    return problems


def written(
    own: list[SearchTrial],
    truth: list[SearchTrial],
    noise: list[SearchTrial],
    bounds: list[Reals],
    seeds: int,
    noise_seeds: int,
    speed: Measured | None,
) -> str:
    """The document as Markdown."""
    parts = [
        _head(),
        _own(own, seeds),
        _truth(truth, seeds),
        _noise(noise, bounds, noise_seeds),
    ]
    if speed is not None:
        parts.append(_speed(speed))
    return "\n".join(parts)


def _head() -> str:
    return """# Results

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:

    build/venv/bin/python -m benchmarks --speed build/bin/ema_speed32 -o docs/RESULTS.md

All figures are of the float32 build, as onboard, on the reference actuator and its chirp (2 mm, 0.1 to 4 Hz, 10 s, 1 kHz). Errors are in % of the
healthy value (CSJ 0.138 Nm, BLK 0.033 mm). Only the rod position is used. Paper: Dalla Vedova, Lauria, Maggiore and Pace, see `docs/DESIGN.md`.
"""


def _paper_error(case: PaperCase, name: str) -> float:
    return abs(case.paper_shift_percent(name) - case.shift_percent(name))


def _own(trials: list[SearchTrial], seeds: int) -> str:
    rows = []
    for case, trial in zip(CASES, trials, strict=True):
        for place, (name, shown) in enumerate(zip(_FAULTS, _NAMES, strict=True)):
            rows.append(
                f"| {case.letter} | {shown} | {case.shift_percent(name):+.2f} | {_paper_error(case, name):.2f} | {trial.worst_percent()[place]:.1e} | "
                f"{case.paper_iterations} | {np.mean(trial.evaluations):.0f} | {np.max(trial.evaluations):.0f} |"
            )
    return f"""## Records of the C model itself, no noise

{seeds} seeds, each from the healthy values and from the four corners of the bounds: {5 * seeds} searches per case. Limit: {OWN_LIMIT_PERCENT[0]:g} % within {EVALUATION_BUDGET} model runs.

| case | fault | true shift, % | paper's error, % | worst error, % | paper's iterations | model runs, mean | most |
|---|---|---|---|---|---|---|---|
{chr(10).join(rows)}
"""


def _truth(trials: list[SearchTrial], seeds: int) -> str:
    rows = [
        f"| {trial.letter} | {trial.worst_percent()[0]:.1e} | {trial.worst_percent()[1]:.1e} | {np.mean(trial.evaluations):.0f} | {np.max(trial.evaluations):.0f} |"
        for trial in trials
    ]
    return f"""## Records of the truth plant, no noise

The shipped recordings `case_a.csv`, `case_b.csv`, `case_c.csv`: made in double precision at a hundredth of the step by equations that share no code with the
module. {seeds} seeds per case from the healthy values. Limits: CSJ {TRUTH_LIMIT_PERCENT[0]:g} %, BLK {TRUTH_LIMIT_PERCENT[1]:g} %.

| case | worst error of CSJ, % | of BLK, % | model runs, mean | most |
|---|---|---|---|---|
{chr(10).join(rows)}
"""


def _noise(trials: list[SearchTrial], bounds: list[Reals], seeds: int) -> str:
    rows = []
    for trial, bound in zip(trials, bounds, strict=True):
        for place, shown in enumerate(_NAMES):
            rms, stated = trial.rms_percent()[place], np.sqrt(np.mean(trial.std_percent[:, place] ** 2))
            rows.append(
                f"| {trial.letter} | {shown} | {rms:.3f} | {bound[place]:.3f} | {rms / bound[place]:.2f} | {stated:.3f} | {100.0 * trial.covered()[place]:.0f} |"
            )
    uncertain = 100.0 / np.sqrt(2 * seeds)
    return f"""## The same with sensor noise

White noise of {1000.0 * NOISE_MM:g} um rms on the rod position, {seeds} records per case. The Cramer-Rao bound is the smallest standard error that any unbiased estimate can
have; it follows from the model's sensitivities. Limit: {NOISE_LIMIT_RATIO:g} times the bound (with {seeds} records the ratio itself is uncertain by {uncertain:.0f} %). Last columns: the standard
error that the module states, and how often its 95 % interval held the truth.

| case | fault | rms error, % | Cramer-Rao bound, % | ratio | stated, % | held, % |
|---|---|---|---|---|---|---|
{chr(10).join(rows)}
"""


def _speed(speed: Measured) -> str:
    return f"""## Time

One core of this machine: {speed.processor}. The paper needs 40 to 75 s per case, 27 to 30 ms per model run.

```
{speed.text}
```
"""
