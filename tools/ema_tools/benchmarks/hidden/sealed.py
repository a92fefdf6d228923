"""The only contact with the code under test. It gets the data sheet's actuator and records without a hint of what is hidden, and hands back what was said."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.recording import Recording
from ema_tools.benchmarks.hidden.machines import STEP_S
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence, settled
from ema_tools.select import baseline as gathering
from ema_tools.select.search import diagnose

_fitted: dict[str, Actuator] = {}


@contextmanager
def remembering() -> Iterator[None]:
    """Inside, the fit to a machine's healthy repeats is made once and not once a trial: the same repeats have the same fit, and most trials are of one machine."""
    fit = gathering.healthy_model

    def remembered(
        actuator: Actuator,
        record: Record,
        mean: Reals,
        power: Reals,
        channels: tuple[str, ...],
        report: Callable[[float, str], None] | None = None,
    ) -> Actuator:
        key = hashlib.sha256(mean.tobytes() + power.tobytes() + record.command_mm.tobytes() + repr(channels).encode()).hexdigest()
        if key not in _fitted:
            _fitted[key] = fit(actuator, record, mean, power, channels, report)
        return _fitted[key]

    gathering.healthy_model = remembered
    try:
        yield
    finally:
        gathering.healthy_model = fit


@dataclass(frozen=True)
class Said:
    """One name of the answer, best first: its class (itself first), values and standard errors where it was fitted."""

    name: str
    alike: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    score: float
    accepted: bool


@dataclass(frozen=True)
class Answer:
    """What the search said. `known`: values of the healthy machine's model, from which the fitted values are changes; costs are sums of squared whitened residuals.

    `run_s`, `cpu_s`: time on the clock and of all cores together.
    """

    verdict: str
    said: tuple[Said, ...]
    fitted: Mapping[str, float]
    known: Actuator
    cost_before: float
    cost_after: float
    cost_floor: float
    unexplained: float
    limit: float
    run_s: float
    cpu_s: float

    @property
    def accepted(self) -> tuple[str, ...]:
        """The names to be added, in the order in which they were found."""
        return tuple(one.name for one in self.said if one.accepted)

    @property
    def first(self) -> str:
        """The first name, accepted or not; the verdict where there is none."""
        return self.said[0].name if self.said else self.verdict


def record_of(run: Recording, number: int) -> Record:
    """A run as the code under test may see it; the file's name says nothing."""
    return Record(STEP_S, run.command_mm, run.position_mm, run.motor_position_mm, run.current_A, run.voltage_V, file=f"record_{number}.csv")


def _evidence(run: Recording, healthy: Sequence[Recording], channels: Sequence[str] | None) -> Evidence:
    repeats = [record_of(other, number) for number, other in enumerate(healthy, start=1)]
    return gathering.gather(reference_actuator(), record_of(run, 0), repeats, channels)


def answered(run: Recording, healthy: Sequence[Recording], channels: Sequence[str] | None = None) -> Answer:
    """The search on one run against healthy repeats (none: against the data sheet), in `channels` or all signals."""
    begun, work = time.perf_counter(), time.process_time()
    evidence = _evidence(run, healthy, channels)
    found = diagnose(evidence)
    run_s, cpu_s = time.perf_counter() - begun, time.process_time() - work
    said = tuple(Said(one.name, tuple(one.alike), dict(one.values), dict(one.std), one.score, one.accepted) for one in found.named)
    fitted = dict(found.fit.values) if found.fit is not None else {}
    costs = (found.cost_before, found.cost_after, found.cost_floor)
    return Answer(found.verdict, said, fitted, evidence.actuator, *costs, found.unexplained, found.limit, run_s, cpu_s)


def error_left(answer: Answer, run: Recording, healthy: Sequence[Recording], channels: Sequence[str] | None = None) -> tuple[float, float]:
    """Weighted rms error of a run of another command over the floor of its healthy repeats: without what was found, and with it.

    As the answer's own record held out: the healthy machine and what was found are those of the first command; nothing is fitted to this run but what scatters.
    """
    record, *repeats = (record_of(one, number) for number, one in enumerate((run, *healthy)))
    names = tuple(channels) if channels else gathering.common_channels([record, *repeats])
    evidence = gathering.against_known(answer.known, record, repeats, names)
    before = settled(evidence, {})
    floor = evidence.expected_cost()
    after = settled(evidence, answer.fitted) if answer.fitted else before
    return float(np.sqrt(before.cost / floor)), float(np.sqrt(after.cost / floor))
