"""The only contact with the code under test. It gets the data sheet's actuator and records without a hint of what is hidden, as a user gives them to `ema diagnose`, and the result that
the user gets is read: nothing inside is asked."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from benchmarks.hidden.machines import STEP_S
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.records import Record
from ema_tools.results.codec import to_json
from ema_tools.select import baseline as gathering
from ema_tools.tasks import method
from ema_tools.words.answers.method import diagnosis

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


def diagnosed(actuator: Actuator, record: Record, healthy: Sequence[Record] = (), holdout: Record | None = None) -> dict[str, Any]:
    """What `ema diagnose ACTUATOR RECORD --healthy ... --holdout ... --json` writes, by the way that the command takes. Raises InputError for what it refuses."""
    return to_json(diagnosis(method.diagnosed(actuator, [record], healthy, holdout), {}))


@dataclass(frozen=True)
class Said:
    """One name of the result: its class (itself first), values and standard errors by field where it was fitted, and its probability where one is stated."""

    name: str
    alike: tuple[str, ...]
    values: Mapping[str, float]
    std: Mapping[str, float]
    score: float
    accepted: bool
    probability: float | None = None


@dataclass(frozen=True)
class SealedAnswer:
    """What the result says. `said`: the effects to be added, then the faults, then the others, each as listed; `standing`: values of the effects in the healthy machine's model.

    `error`: weighted errors `before` anything is added, `after` and `floor`, those of the record held out in `held_out` over its floor; `sensor`: the channel that is suspected;
    `refused`: why there is no result. `run_s`, `cpu_s`: time on the clock and of all cores together.
    """

    verdict: str
    said: tuple[Said, ...]
    standing: Mapping[str, Mapping[str, float]]
    error: Mapping[str, float]
    held_out: Mapping[str, float] | None
    unexplained: float
    sensor: str | None
    refused: str | None
    run_s: float
    cpu_s: float

    @property
    def accepted(self) -> tuple[str, ...]:
        """The names that are put forward, effects before faults."""
        return tuple(one.name for one in self.said if one.accepted)

    @property
    def first(self) -> str:
        """The first name, accepted or not; the verdict where there is none."""
        return self.said[0].name if self.said else self.verdict


def record_of(run: Recording, number: int, channels: Sequence[str] | None = None) -> Record:
    """A run as the code under test may see it, in `channels` or all signals; the file's name says nothing."""
    seen = {
        name: getattr(run, name)
        for name in ("position_mm", "motor_position_mm", "current_A", "voltage_V")
        if channels is None or name in channels
    }
    return Record(STEP_S, run.command_mm, file=f"record_{number}.csv", **seen)


def _said(one: Mapping[str, Any]) -> Said:
    alike = (*one["class"], *one.get("looks_like_fault", ()))
    ordered = (one["name"], *(name for name in alike if name != one["name"]))
    return Said(
        one["name"], ordered, dict(one["parameters"]), dict(one["std"]), float(one["score"]), bool(one["accepted"]), one.get("probability")
    )


def read(result: Mapping[str, Any], run_s: float = 0.0, cpu_s: float = 0.0) -> SealedAnswer:
    """The answer in a result of `diagnosed`."""
    effects = [_said(one) for one in result["effects"]]
    faults = [_said(one) for one in result["faults"].values()]
    said = [one for one in effects if one.accepted] + faults + [one for one in effects if not one.accepted]
    error, held_out = result["error"], None
    # what scatters from run to run is no effect: the fall is counted from where it has moved
    before = result["steps"][1]
    if error.get("holdout_floor"):
        floor = error["holdout_floor"]
        held_out = {"before": before["error_holdout"] / floor, "after": error["holdout_after"] / floor}
    errors = {"before": before["error_training"], "after": error["after"], "floor": error["floor"]}
    sensor = result.get("sensor")
    return SealedAnswer(
        result["verdict"],
        tuple(said),
        result.get("standing", {}),
        errors,
        held_out,
        float(result.get("unexplained", 0.0)),
        sensor["channel"] if sensor else None,
        None,
        run_s,
        cpu_s,
    )


def answered(
    run: Recording,
    healthy: Sequence[Recording],
    channels: Sequence[str] | None = None,
    other: Recording | None = None,
    others: Sequence[Recording] = (),
) -> SealedAnswer:
    """The diagnosis of one run against healthy repeats (none: against the data sheet), in `channels` or all signals; `other` is held out, with healthy repeats `others` of its command."""
    records = [record_of(one, number, channels) for number, one in enumerate((run, *healthy, *others))]
    holdout = record_of(other, len(records), channels) if other is not None else None
    begun, work = time.perf_counter(), time.process_time()
    try:
        result = diagnosed(reference_actuator(), records[0], records[1:], holdout)
    except InputError as error:
        return SealedAnswer("refused", (), {}, {}, None, 0.0, None, str(error), time.perf_counter() - begun, time.process_time() - work)
    return read(result, time.perf_counter() - begun, time.process_time() - work)
