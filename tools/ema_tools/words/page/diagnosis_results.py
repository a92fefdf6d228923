"""What the page shows of a result of `ema diagnose` or `ema add`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.library.display_names import value_called
from ema_tools.results.addition import Addition
from ema_tools.results.codec import Series
from ema_tools.results.diagnosis import BaseEntry, ChangeEntry, DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.localisation import BinPicture, BinsEntry, BlockEntry, Localisation, Pictures, Points, SignalErrorEntry
from ema_tools.results.parts import EffectEntry, Place
from ema_tools.results.unexplained import Unexplained
from ema_tools.results.validity import Remark, Validity
from ema_tools.results.workbench import BenchEntry
from ema_tools.words.page.recorded import Curves, curves_of
from ema_tools.words.sentences.balance import forward_sentence, lag_sentence
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits

_ERRORS = ("before", "after", "floor", "holdout_before", "holdout_after")


@dataclass(frozen=True)
class Value:
    """One fitted value with its standard error, where there is one."""

    name: str
    value: float
    std: float | None
    at_bound: bool


@dataclass(frozen=True)
class ShownSuspect:
    """One effect of the ranking: what looks alike (itself included), its score and the limit that it must exceed."""

    name: str
    alike: tuple[str, ...]
    values: tuple[Value, ...]
    score: float
    limit: float
    accepted: bool
    reason: str


@dataclass(frozen=True)
class Line:
    """A drawn curve: points, and a band of one standard deviation where there is one."""

    x: Reals
    y: Reals
    low: Reals | None = None
    high: Reals | None = None


@dataclass(frozen=True)
class Picture:
    """A quantity over an axis: title, units, its lines by role; of bins the share of the square and of the time, both %."""

    source: str
    by: str
    unit: str
    axis_unit: str
    lines: dict[str, Line]
    share: Reals | None = None
    time: Reals | None = None
    explained_percent: float | None = None
    friction: bool = False


@dataclass(frozen=True)
class ShownSignal:
    """One addition: the effects that the model then holds, the error on both records, and of the last one the values; `recommended` is None where nothing is said about it; `loads`: what makes
    it of the first model, None where it is not known."""

    effects: tuple[str, ...]
    added: str
    training: float
    holdout: float | None
    values: tuple[Value, ...] = ()
    recommended: bool | None = None
    reason: str = ""
    loads: dict[str, float] | None = None
    told: tuple[float, float | None] | None = None

    @property
    def read(self) -> tuple[float, float | None]:
        """The errors on both records that the ladder shows: what scatters no farther than is credible, where that is known."""
        return self.told if self.told is not None else (self.training, self.holdout)


@dataclass(frozen=True)
class ShownChange:
    """One value of the healthy machine beside today's."""

    name: str
    entry: ChangeEntry

    @property
    def title(self) -> str:
        """What it is, in a few words."""
        return self.entry.called or value_called(self.name)


@dataclass(frozen=True)
class ShownBase:
    """One base value as fitted, beside what is stated."""

    name: str
    entry: BaseEntry


@dataclass(frozen=True)
class Diagnosed:
    """A result of `ema diagnose` or, with `added`, of `ema add`. `errors` by their names, those that are known; what the result does not hold is empty. `found`: the result itself."""

    name: str
    added: str
    verdict: str
    sentence: str
    suspects: tuple[ShownSuspect, ...]
    errors: dict[str, float]
    next_experiment: str
    gate_sentence: str
    remarks: tuple[Remark, ...]
    where_sentence: str
    relative: bool
    blocks: tuple[BlockEntry, ...]
    signals: tuple[SignalErrorEntry, ...]
    places: tuple[Place, ...]
    pictures: tuple[Picture, ...]
    unknown_sentence: str
    unknown_pictures: tuple[Picture, ...]
    learned_sentence: str
    steps: tuple[ShownSignal, ...]
    curves: Curves | None
    forward_sentence: str = ""
    changes: tuple[ShownChange, ...] = ()
    base: tuple[ShownBase, ...] = ()
    units: MachineUnits = TURNING
    records: int = 1
    by_forces: bool = False
    provenance: dict[str, str] = field(default_factory=dict)
    workbench: BenchEntry | None = None
    found: DiagnosisResult | DiagnosisByBalanceResult | Addition = field(kw_only=True, repr=False)

    def found_bins(self) -> tuple[BinPicture, ...]:
        """Residuals of the balances over the axes."""
        return () if isinstance(self.found, Addition) else self.found.where.pictures.bins

    @property
    def title(self) -> str:
        """What the page calls it."""
        return f"{self.added} added, on {self.name}" if self.added else f"Diagnosis of {self.name}"


def diagnosed(found: DiagnosisResult | DiagnosisByBalanceResult | Addition, source: str, stem: str) -> Diagnosed:
    """What the page shows of a diagnosis or an addition. Raises InputError for curves of unlike lengths."""
    added = found.effect if isinstance(found, Addition) else ""
    gate, where, next_experiment, verdict = Validity(), Localisation(), "", "missing"
    entries: tuple[EffectEntry, ...] = ()
    unknown: Unexplained | None = None
    if not isinstance(found, Addition):
        gate, where, unknown, entries = found.gate, found.where, found.unknown, found.effects
        next_experiment, verdict = found.next_experiment, found.verdict
    suspects = tuple(map(_suspect, entries))
    count = 1 if isinstance(found, DiagnosisResult) else max(1, len(found.records or ()))
    others = f" and {count - 1} more record{'s' if count > 2 else ''}" if count > 1 else ""
    return Diagnosed(
        name=f"{found.name or stem}{others}",
        added=added,
        verdict=verdict,
        sentence=found.sentence,
        suspects=suspects,
        errors={key: value for key in _ERRORS if (value := getattr(found.error, key)) is not None},
        next_experiment=next_experiment,
        gate_sentence=gate.sentence,
        remarks=gate.remarks,
        where_sentence=where.sentence,
        relative=where.relative_to_healthy,
        blocks=where.blocks,
        signals=tuple(one for one in where.channels if one.rms is not None),
        places=tuple(place for place in where.places if place.time_share is not None),
        pictures=tuple(_pictures(where.pictures)),
        unknown_sentence=unknown.sentence if unknown is not None else "",
        unknown_pictures=tuple(_unknown_pictures(unknown)) if unknown is not None else (),
        learned_sentence=unknown.learned.sentence if unknown is not None and unknown.learned is not None else "",
        steps=_steps(found, suspects),
        curves=None if found.curves is None else curves_of(found.curves, source),
        forward_sentence="" if isinstance(found, DiagnosisResult) else _of_forward(found),
        changes=tuple(ShownChange(*one) for one in found.changes.items()) if isinstance(found, DiagnosisByBalanceResult) else (),
        base=tuple(ShownBase(*one) for one in (found.base or {}).items()) if isinstance(found, DiagnosisByBalanceResult) else (),
        units=_units(found),
        records=count,
        by_forces=not isinstance(found, DiagnosisResult) and found.method == "balance",
        provenance=found.provenance,
        found=found,
        workbench=found.workbench,
    )


def _units(found: DiagnosisResult | DiagnosisByBalanceResult | Addition) -> MachineUnits:
    """How the numbers of the machine are told."""
    return MachineUnits(m_per_rad=found.rod_m_per_rad) if isinstance(found, DiagnosisByBalanceResult) else TURNING


def _of_forward(found: DiagnosisByBalanceResult | Addition) -> str:
    """What is said of the forward solution, and of a drive that records late."""
    lag_s = found.drive_lag_s
    told = [lag_sentence(lag_s)] if lag_s else []
    return " ".join([*told, *([forward_sentence(found.forward, _units(found))] if found.forward is not None else [])])


def _suspect(one: EffectEntry) -> ShownSuspect:
    return ShownSuspect(one.name, one.alike or (one.name,), _own_values(one), one.score, one.limit, one.accepted, one.reason or "")


def _own_values(one: EffectEntry) -> tuple[Value, ...]:
    """Values of one effect or fault under their full names."""
    bound = one.at_bound or ()
    return tuple(Value(_full_name(one.name, name), value, one.std.get(name), name in bound) for name, value in one.parameters.items())


def _full_name(effect: str, field_name: str) -> str:
    """The name in the actuator's file of a value that is stated by its last word."""
    return f"screw.{field_name}" if field_name.startswith(f"{effect}_") else f"effects.{effect}.{field_name}"


def _steps(found: DiagnosisResult | DiagnosisByBalanceResult | Addition, suspects: tuple[ShownSuspect, ...]) -> tuple[ShownSignal, ...]:
    """The steps of a diagnosis; for one without, and for an addition, the one step from before to after."""
    steps = [
        ShownSignal(one.effects, one.added, one.error_training, one.error_holdout, loads=one.values, told=one.told)
        for one in found.steps or ()
    ]
    # the model as it was given is the first model, which the page shows anyhow
    given = bool(steps) and not steps[0].effects and steps[0].training == found.error.before
    if given:
        del steps[0]
    after = found.error.after
    names = (found.effect,) if isinstance(found, Addition) else tuple(one.name for one in suspects if one.accepted)
    if not steps and not given and after is not None and names:
        steps.append(ShownSignal(names, " + ".join(names), after, found.error.holdout_after, (), True))
    if not steps or not steps[-1].effects:
        return tuple(steps)
    # what was fitted is stated once, for the last model
    last = replace(steps[-1], values=_last_values(found))
    if isinstance(found, Addition):
        last = replace(last, recommended=found.recommended, reason=found.reason or "")
    return (*steps[:-1], last)


def _last_values(found: DiagnosisResult | DiagnosisByBalanceResult | Addition) -> tuple[Value, ...]:
    """Values of the last model: those that were added, or those of every accepted effect and of the faults that changed beside them."""
    if isinstance(found, Addition):
        return tuple(Value(name, one.value, one.std, one.at_bound) for name, one in found.parameters.items())
    return tuple(value for one in (*found.effects, *found.faults.values()) if one.accepted for value in _own_values(one))


def _array(values: Series) -> Reals:
    return np.asarray(values, dtype=np.float64)


def _binned(one: BinsEntry) -> Line:
    return Line(_array(one.center), _array(one.mean), _array(one.low), _array(one.high))


def _points(one: Points) -> Line:
    return Line(_array(one.x), _array(one.y))


def _pictures(found: Pictures) -> Iterator[Picture]:
    """Bins by balance and axis, torque against speed, orders, hysteresis."""
    for one in found.bins:
        lines = {"excess": _binned(one)}
        share, time = _array(one.share_percent), _array(one.time_percent)
        yield Picture(one.source, one.by, one.unit, one.axis_unit, lines, share, time, friction=one.friction)
    torque = found.torque_speed
    if torque is not None:
        lines = {"points": _points(torque.points)}
        if torque.expected is not None:
            lines[torque.other] = _binned(torque.expected)
        if torque.measured is not None:
            lines["measured"] = _binned(torque.measured)
        yield Picture("torque without inertia", "speed", torque.unit, torque.axis_unit, lines)
    if found.turn is not None:
        lines = {"model": _binned(found.turn.model), "measured": _binned(found.turn.measured)}
        yield Picture("torque over a turn", "motor angle", found.turn.unit, found.turn.axis_unit, lines)
    for name, orders in found.orders.items():
        for peaks, axis in ((orders.turns, "periods per motor turn"), (orders.leads, "periods per screw lead")):
            if peaks.order:
                lines = {"order": Line(_array(peaks.order), _array(peaks.amplitude))}
                if peaks.chance:
                    lines["chance"] = Line(_array(peaks.order), _array(peaks.chance))
                yield Picture(f"{name} order", axis, orders.unit, "", lines)
    for name, loop in (("play", found.hysteresis.play), ("torque", found.hysteresis.torque)):
        if loop is not None:
            sides = {"healthy": loop.healthy, "model": loop.model, "measured": loop.measured}
            lines = {key: _points(side) for key, side in sides.items() if side is not None}
            yield Picture(f"{name} loop", "position", loop.unit, loop.axis_unit, lines)


def _unknown_pictures(found: Unexplained) -> Iterator[Picture]:
    for first in found.balances[:1]:
        for one in first.pictures:
            lines = {"excess": _binned(one)}
            share = _array(one.share_percent)
            yield Picture(
                first.what, one.by, one.unit, one.axis_unit, lines, share, explained_percent=one.explained_percent, friction=one.friction
            )
