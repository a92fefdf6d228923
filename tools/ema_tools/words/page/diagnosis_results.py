"""Reads the JSON of `ema diagnose` and `ema add`, whose layout `ema_tools.words.page.diagnosis` states."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from ema_tools.words.page.reader import Reader, Series
from ema_tools.words.page.results import Curves, Place, curves_of, provenance_of

VERDICTS = ("adequate", "missing", "unknown")
SEVERITIES = ("blocks", "weakens", "fine")


@dataclass(frozen=True)
class Value:
    """One fitted value with its standard error, where there is one."""

    name: str
    value: float
    std: float | None
    at_bound: bool


@dataclass(frozen=True)
class Suspect:
    """One effect of the ranking: what looks alike (itself included), its score and the limit that it must exceed."""

    name: str
    alike: tuple[str, ...]
    values: tuple[Value, ...]
    score: float
    limit: float
    accepted: bool
    reason: str


@dataclass(frozen=True)
class Step:
    """One addition: the effects that the model then holds, and the error on both records, weighted rms; `recommended` is None where nothing is said about it."""

    effects: tuple[str, ...]
    added: str
    training: float
    holdout: float | None
    values: tuple[Value, ...]
    recommended: bool | None
    reason: str


@dataclass(frozen=True)
class Remark:
    """One remark of the gate."""

    topic: str
    severity: str
    text: str
    next: str


@dataclass(frozen=True)
class BlockError:
    """One balance: rms and that of the floor, both None with a reason; share of the excess in %; what it is proportional to, with the share that this explains in %."""

    name: str
    unit: str
    rms: float | None
    floor_rms: float | None
    share_percent: float
    telling: bool
    words: str
    words_percent: float
    reason: str


@dataclass(frozen=True)
class Line:
    """A drawn curve: points, and a band of one standard deviation where there is one."""

    x: Series
    y: Series
    low: Series | None = None
    high: Series | None = None


@dataclass(frozen=True)
class Picture:
    """A quantity over an axis: title, units, its lines by role; of bins the share of the square and of the time, both %."""

    source: str
    by: str
    unit: str
    axis_unit: str
    lines: dict[str, Line]
    share: Series | None = None
    time: Series | None = None
    explained_percent: float | None = None
    friction: bool = False


@dataclass(frozen=True)
class Diagnosed:
    """A result of `ema diagnose` or, with `added`, of `ema add`. `errors` by the names of the contract; what the file does not hold is empty."""

    name: str
    added: str
    verdict: str
    sentence: str
    suspects: tuple[Suspect, ...]
    errors: dict[str, float]
    next_experiment: str
    gate_sentence: str
    remarks: tuple[Remark, ...]
    where_sentence: str
    relative: bool
    blocks: tuple[BlockError, ...]
    signals: tuple[tuple[str, str, float, float | None, float], ...]
    places: tuple[Place, ...]
    pictures: tuple[Picture, ...]
    unknown_sentence: str
    unknown_pictures: tuple[Picture, ...]
    learned_sentence: str
    steps: tuple[Step, ...]
    curves: Curves | None
    provenance: dict[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """What the page calls it."""
        return f"{self.added} added, on {self.name}" if self.added else f"Diagnosis of {self.name}"


def diagnosed(reader: Reader, stem: str) -> Diagnosed:
    """The result that a file holds. Raises InputError that names the field."""
    added = reader.text("effect", "") if reader.data.get("command") == "add" else ""
    verdict = reader.text("verdict", "missing" if added else "")
    if verdict not in VERDICTS:
        raise reader.fail("verdict", f"is none of {', '.join(VERDICTS)}")
    error = reader.table("error")
    gate, where, unknown = (_part(reader, key) for key in ("gate", "where", "unknown"))
    pictures = _part(where, "pictures")
    curves = reader.table("curves") if reader.data.get("curves") is not None else None
    suspects = tuple(_suspect(part) for part in reader.tables("effects"))
    return Diagnosed(
        name=reader.text("name", stem),
        added=added,
        verdict=verdict,
        sentence=reader.text("sentence", ""),
        suspects=suspects,
        errors={
            key: value
            for key in ("before", "after", "floor", "holdout_before", "holdout_after")
            if (value := error.optional(key)) is not None
        },
        next_experiment=_said(reader, "next_experiment"),
        gate_sentence=gate.text("sentence", ""),
        remarks=tuple(_remark(part) for part in gate.tables("remarks")),
        where_sentence=where.text("sentence", ""),
        relative=bool(where.data.get("relative_to_healthy", False)),
        blocks=tuple(_block(part) for part in where.tables("blocks")),
        signals=tuple(
            (part.text("name", ""), part.text("unit", ""), part.number("rms"), part.optional("floor_rms"), part.number("share_percent"))
            for part in where.tables("channels")
        ),
        places=tuple(
            Place(part.text("name", "unnamed"), part.number("share_percent"), 100.0 * part.number("time_share"))
            for part in where.tables("places")
            if part.data.get("time_share") is not None
        ),
        pictures=tuple(_pictures(pictures)),
        unknown_sentence=unknown.text("sentence", ""),
        unknown_pictures=tuple(_unknown_pictures(unknown)),
        learned_sentence=_part(unknown, "learned").text("sentence", ""),
        steps=_steps(reader, error, added, suspects),
        curves=None if curves is None else curves_of(curves, tuple(key for key in ("before", "after") if key in curves.data)),
        provenance=provenance_of(reader),
    )


def _part(reader: Reader, key: str) -> Reader:
    """A nested object, empty where it is absent."""
    return reader.table(key) if reader.data.get(key) is not None else Reader({}, reader.source, f"{reader.prefix}{key}.")


def _said(reader: Reader, key: str) -> str:
    """A text, or the `sentence` or `command` of an object; empty where it is absent."""
    found = reader.data.get(key)
    if isinstance(found, dict):
        part = reader.table(key)
        return part.text("sentence", part.text("command", ""))
    return "" if found is None else reader.text(key, "")


def _values(reader: Reader) -> tuple[Value, ...]:
    """Values as objects, or as numbers beside which `std` and `at_bound` stand."""
    table, std = _part(reader, "parameters"), _part(reader, "std")
    bound = reader.data.get("at_bound") or ()
    found = []
    for name, value in table.data.items():
        if isinstance(value, dict):
            part = table.table(name)
            found.append(Value(name, part.number("value"), part.optional("std"), bool(part.data.get("at_bound", False))))
        else:
            found.append(Value(name, table.number(name), std.optional(name), name in bound))
    return tuple(found)


def _suspect(part: Reader) -> Suspect:
    name = part.text("name", "unnamed")
    return Suspect(
        name,
        part.texts("class") or (name,),
        _own_values(part),
        part.number("score"),
        part.number("limit"),
        bool(part.data.get("accepted", False)),
        _said(part, "reason"),
    )


def _steps(reader: Reader, error: Reader, added: str, suspects: tuple[Suspect, ...]) -> tuple[Step, ...]:
    """The steps of a diagnosis; for one without, and for an addition, the one step from before to after."""
    steps = [
        Step(
            part.texts("effects"),
            part.text("added", ""),
            part.number("error_training"),
            part.optional("error_holdout"),
            _values(part),
            _judged(part),
            _said(part, "reason"),
        )
        for part in reader.tables("steps")
    ]
    # the model as it was given is the first model, which the page shows anyhow
    given = bool(steps) and not steps[0].effects and steps[0].training == error.optional("before")
    if given:
        del steps[0]
    after = error.optional("after")
    names = (added,) if added else tuple(one.name for one in suspects if one.accepted)
    if not steps and not given and after is not None and names:
        steps.append(Step(names, " + ".join(names), after, error.optional("holdout_after"), (), True, ""))
    if not steps or not steps[-1].effects or steps[-1].values:
        return tuple(steps)
    # what was fitted is stated once, for the last model
    last = replace(steps[-1], values=_last_values(reader, added))
    return (*steps[:-1], replace(last, recommended=_judged(reader), reason=_said(reader, "reason")) if added else last)


def _judged(part: Reader) -> bool | None:
    said = part.data.get("recommended")
    return None if said is None else bool(said)


def _last_values(reader: Reader, added: str) -> tuple[Value, ...]:
    """Values of the last model: those that were added, or those of every accepted effect and of the faults that changed beside them."""
    if added:
        return _values(reader)
    faults = _part(reader, "faults")
    parts = [part for part in (*reader.tables("effects"), *map(faults.table, faults.data)) if part.data.get("accepted")]
    return tuple(value for part in parts for value in _own_values(part))


def _own_values(part: Reader) -> tuple[Value, ...]:
    """Values of one effect or fault under their full names."""
    return tuple(replace(value, name=_full_name(part.text("name", ""), value.name)) for value in _values(part))


def _full_name(effect: str, field_name: str) -> str:
    """The name in the actuator's file of a value that is stated by its last word."""
    return (
        field_name
        if "." in field_name
        else f"screw.{field_name}"
        if field_name.startswith(f"{effect}_")
        else f"effects.{effect}.{field_name}"
    )


def _remark(part: Reader) -> Remark:
    severity = part.text("severity", "")
    if severity not in SEVERITIES:
        raise part.fail("severity", f"is none of {', '.join(SEVERITIES)}")
    return Remark(part.text("topic", ""), severity, part.text("text", ""), _said(part, "next"))


def _block(part: Reader) -> BlockError:
    term = next(part.tables("terms"), None)
    return BlockError(
        part.text("name", ""),
        part.text("unit", ""),
        part.optional("rms"),
        part.optional("floor_rms"),
        part.number("share_percent"),
        bool(part.data.get("telling", False)),
        term.text("words", "") if term else "",
        term.number("explained_percent") if term else math.nan,
        _said(part, "reason"),
    )


def _binned(part: Reader) -> Line:
    return Line(part.series("center"), part.series("mean"), part.series("low"), part.series("high"))


def _points(part: Reader) -> Line:
    return Line(part.series("x"), part.series("y"))


def _pictures(pictures: Reader) -> Iterator[Picture]:
    """Bins by balance and axis, torque against speed, orders, hysteresis."""
    for part in pictures.tables("bins"):
        heads = (part.text("source", ""), part.text("by", ""), part.text("unit", ""), part.text("axis_unit", ""))
        yield Picture(
            *heads,
            {"excess": _binned(part)},
            part.series("share_percent"),
            part.series("time_percent"),
            friction=bool(part.data.get("friction", False)),
        )
    if pictures.data.get("torque_speed") is not None:
        part = pictures.table("torque_speed")
        lines = {"points": _points(part.table("points"))}
        if part.data.get("expected") is not None:
            lines[part.text("other", "model")] = _binned(part.table("expected"))
        if part.data.get("measured") is not None:
            lines["measured"] = _binned(part.table("measured"))
        yield Picture("torque without inertia", "speed", part.text("unit", ""), part.text("axis_unit", ""), lines)
    orders = _part(pictures, "orders")
    for name in orders.data:
        part = orders.table(name)
        for key, axis in (("turns", "periods per motor turn"), ("leads", "periods per screw lead")):
            peaks = part.table(key)
            if peaks.data.get("order"):
                orders_at = peaks.series("order")
                drawn = {"order": Line(orders_at, peaks.series("amplitude"))}
                if peaks.data.get("chance"):
                    drawn["chance"] = Line(orders_at, peaks.series("chance"))
                yield Picture(f"{name} order", axis, part.text("unit", ""), "", drawn)
    loops = _part(pictures, "hysteresis")
    for name in loops.data:
        part = loops.table(name)
        lines = {key: _points(part.table(key)) for key in ("healthy", "model", "measured") if part.data.get(key) is not None}
        yield Picture(f"{name} loop", "position", part.text("unit", ""), part.text("axis_unit", ""), lines)


def _unknown_pictures(unknown: Reader) -> Iterator[Picture]:
    first: Reader | None = next(unknown.tables("balances"), None)
    if first is None:
        return
    what = first.text("what", "unknown")
    for part in first.tables("pictures"):
        share: dict[str, Any] = {
            "share": part.series("share_percent"),
            "explained_percent": part.number("explained_percent"),
            "friction": bool(part.data.get("friction", False)),
        }
        yield Picture(what, part.text("by", ""), part.text("unit", ""), part.text("axis_unit", ""), {"excess": _binned(part)}, **share)
