"""Which machine, what is hidden in it, how its days vary and how many baseline records there are; and what the answer is judged by."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.days.simulator import EFFECTS, OUTSIDE, record
from benchmarks.hidden.sealed import SealedAnswer, answered

SIZES = {"medium": 1.0, "large": 2.5}
FAULTS = {"dry_Nm": (1.2, "csj"), "play_mm": (1.6, "blk")}  # factor at medium size, name of the fault
KINDS = ("healthy", "effect", "pair", "fault", "outside")
HEALTHY = 40
_PAIRS = 12
# Every machine has a contact that yields. Without baseline records nobody has said so, and it may be named.
STANDING = frozenset({"presliding", "elastic_backlash"})


@dataclass(frozen=True)
class Trial:
    """One diagnosis. `hidden`: values of the simulator that are changed; `days`: how far days vary, 1 as usual."""

    kind: str
    number: int
    hidden: tuple[str, ...]
    size: str
    baseline: int
    days: float

    @property
    def key(self) -> str:
        """By which an interrupted run is taken up again."""
        return f"{self.kind} {self.number} {'+'.join(self.hidden)} {self.size} {self.baseline} {self.days:g}"

    @property
    def group(self) -> str:
        """File of its row."""
        return f"{self.kind}_{self.number}_{'_'.join(self.hidden)}_{self.size}"

    @property
    def names(self) -> tuple[frozenset[str], ...]:
        """For each hidden value the names that are right."""
        return tuple(frozenset((FAULTS[one][1],) if one in FAULTS else EFFECTS[one][1]) for one in self.hidden if one not in OUTSIDE)

    def changes(self) -> dict[str, float]:
        """For `simulator.record`."""
        factor = SIZES[self.size or "medium"]
        found = {}
        for one in self.hidden:
            if one in FAULTS:
                found[one] = 1.0 + factor * (FAULTS[one][0] - 1.0)
            else:
                found[one] = factor * (EFFECTS[one][0] if one in EFFECTS else OUTSIDE[one])
        return found


def trials(kinds: Sequence[str], baseline: int, days: float, first: int = 1) -> list[Trial]:
    """All trials of these kinds, no two on one machine, their numbers from `first` on."""
    pairs = np.random.default_rng(7_919).permutation(list(itertools.combinations(EFFECTS, 2))).tolist()[:_PAIRS]
    hidden: dict[str, list[tuple[tuple[str, ...], str]]] = {
        "healthy": [((), "")] * HEALTHY,
        "effect": [((one,), size) for one in EFFECTS for size in SIZES],
        "pair": [(tuple(pair), "large") for pair in pairs],
        "fault": [((one,), size) for one in FAULTS for size in SIZES],
        "outside": [((one,), size) for one in OUTSIDE for size in SIZES],
    }
    numbers: Iterator[int] = itertools.count(first)
    found = [Trial(kind, next(numbers), some, size, baseline, days) for kind in KINDS for some, size in hidden[kind]]
    return [one for one in found if one.kind in kinds]


def judged(trial: Trial, answer: SealedAnswer) -> str:
    """right, part, wrong, accused, refused, unnamed or unknown."""
    if answer.refused is not None:
        return "refused"
    standing = frozenset[str]() if trial.baseline else STANDING - frozenset().union(*trial.names)
    named = [frozenset(one.alike) for one in answer.said if one.accepted and one.name not in standing]
    if not trial.names:
        if named:
            return "wrong" if trial.hidden else "accused"
        # a machine that nothing ails should be adequate, one that something unknown ails unknown
        if trial.hidden:
            return "right" if answer.verdict == "unknown" else "adequate"
        return "unknown" if answer.verdict == "unknown" else "right"
    found = [any(some & right for some in named) for right in trial.names]
    if all(found) and all(any(some & right for right in trial.names) for some in named):
        return "right"
    if named and not any(found):
        return "wrong"
    return "part" if any(found) else "unnamed"


def _is_there(trial: Trial, alike: Sequence[str]) -> bool:
    """Whether a name or a look-alike of it is hidden, or stands in every machine where nobody has said so."""
    return any(set(alike) & right for right in (*trial.names, *([] if trial.baseline else [STANDING])))


def perform(trial: Trial) -> dict[str, Any]:
    """The row of one trial."""
    today = record(trial.number, (trial.number, 0), trial.changes(), trial.days)
    healthy = [record(trial.number, (trial.number, day), {}, trial.days) for day in range(1, trial.baseline + 1)]
    answer = answered(today, healthy)
    return {
        "key": trial.key,
        **asdict(trial),
        "verdict": answer.verdict,
        "accepted": list(answer.accepted),
        "first": answer.first,
        "refused": answer.refused,
        "error": dict(answer.error),
        "judged": judged(trial, answer),
        "probabilities": [[one.probability, _is_there(trial, one.alike)] for one in answer.said if one.probability],
        "run_s": answer.run_s,
    }
