"""What is left after the best known effects: drawn as an unknown torque, voltage or reading against every axis, and as a table that can be flown.

The mechanical balance gives the torque, the electrical one the voltage, the kinematic one the reading of the rod sensor. Each is laid over an axis as a table of 16 nodes, fitted on one half of the
passes between reversals and judged on the other, so that an axis that follows anything by chance wins nothing. A torque is tried as it is and as friction, which turns round with the motion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.balances.all import all_balances
from ema_tools.balances.balance import Balance
from ema_tools.balances.filtering import coarse
from ema_tools.base.arrays import Reals
from ema_tools.compare.axes import Axis, Halves, MachineState, explained, hats, machine_state_of
from ema_tools.compare.localisation import Reference, Where, binned
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import TableAxis
from ema_tools.library.registry import learned_effect, record_of
from ema_tools.results.unexplained import UnknownPicture

NODES = 16  # of a table that is learned, as the module holds them [layout]
REPEATS_SHARE = 0.2  # below this share out of sample nothing repeats [judgement]
_LEAST_SHARE = 0.05  # less of it is nothing, however small the scatter [judgement]
RICHER = 0.05  # a simpler description is kept unless a richer one explains this much more [judgement]
_CHANCE_MARGIN = 1.5  # what an axis explains must exceed the most that any axis explains of a healthy repeat by this factor [judgement]
_FINE_NODES = 64  # along some axes an unknown may be finer than the table: jam spots, teeth, slots. Four times its nodes [judgement]
_FINE_KINDS = (TableAxis.POSITION, TableAxis.LEAD, TableAxis.TURN)
_SEEN_MIN = 4 * NODES  # with fewer moving samples all are taken: four for each node [judgement]
# A smooth table: second differences of neighbours cost this much beside the data. Enough to fill nodes that were not seen [judgement]
_STIFFNESS = 1e-3

# balance -> what its residual stands for, the sign that turns it into that
KINDS: Mapping[str, tuple[str, float]] = {
    "mechanical": ("torque on the shaft", -1.0),
    "electrical": ("voltage at the motor", -1.0),
    "kinematic": ("reading of the rod sensor", 1.0),
}


@dataclass(frozen=True)
class Ranked:
    """One axis: share of the unknown's square explained out of sample, as friction or as it is, at best and by the table of 16 nodes over it; `of_excess`: of what scatter
    leaves of it, 0 where healthy repeats explain as much by chance."""

    axis: str
    unit: str
    kind: int
    friction: bool
    explained: float
    tabled: float
    first: float
    last: float
    nodes: Reals
    of_excess: float = 0.0


@dataclass(frozen=True)
class Unknown:
    """What one balance leaves: rms in its unit and that of healthy repeats, the axes best first. `merit` orders the balances."""

    balance: str
    what: str
    unit: str
    rms: float
    floor_rms: float
    merit: float
    ranked: tuple[Ranked, ...]
    pictures: tuple[UnknownPicture, ...] = field(repr=False)

    @property
    def best(self) -> Ranked | None:
        """The axis that it repeats with; None when it repeats with none."""
        return self.ranked[0] if self.ranked and self.ranked[0].of_excess >= REPEATS_SHARE else None


@dataclass(frozen=True)
class LearnedTable:
    """A table effect that stands for an unknown: `changes` for `Actuator.changed`, the range that it was seen in, and what it explained out of sample."""

    effect: str
    axis: str
    unit: str
    first: float
    last: float
    nodes: Reals
    explained: float
    changes: dict[str, float]


def left_over(actuator: Actuator, record: Record, found: Where) -> tuple[Unknown, ...]:
    """What the balances leave unexplained, the most telling first, and before others those in which the model fails.

    `actuator` holds the effects that are known by now; `found` is where the model without them failed on the same record, from which the healthy repeats are taken.
    """
    motion = machine_state_of(actuator, record, found.smoother)
    here = {
        name: coarse(one, found.smoother)
        for name, one in all_balances(actuator, record, found.smoother).items()
        if name in KINDS and isinstance(one, Balance)
    }
    unknowns = []
    for name, own in here.items():
        reference = found.references.get(name)
        if found.relative and reference is None:
            continue
        left = own if reference is None else replace(own, residual=own.residual - reference.mean)
        unknowns.append(unknown_of(left, motion, reference))
    fails = {block.name for block in found.blocks if block.telling}
    return tuple(sorted(unknowns, key=lambda one: (one.balance not in fails, -one.merit)))


def unknown_of(balance: Balance, motion: MachineState, reference: Reference | None = None) -> Unknown:
    """The unknown that a balance's residual stands for; `reference`: what healthy repeats leave of the same balance."""
    what, sign = KINDS[balance.name]
    turns, rod = balance.name == "mechanical", balance.name == "kinematic"
    at = motion.at(balance.time_s)
    # at rest friction answers whatever there is, so that nothing is seen
    seen = at.moving if turns else np.ones(balance.time_s.size, dtype=bool)
    if np.count_nonzero(seen) > _SEEN_MIN:
        at = motion.at(balance.time_s[seen])
    else:
        seen = np.ones(balance.time_s.size, dtype=bool)
    values = sign * balance.residual[seen]
    half = motion.at(balance.time_s).halves()[seen]
    ranked = _ranked(values, at, half, turns, rod)
    size, floor, chance = float(np.sqrt(np.mean(values**2))), 0.0, 0.0
    if reference is not None:
        floor = reference.floor_rms
        others = (
            _ranked(sign * one[seen], at, half, turns, rod)[0].explained * float(one[seen] @ one[seen]) for one in reference.deviations
        )
        chance = _CHANCE_MARGIN * max([0.0, *others]) / max(float(values @ values), 1e-300)
    beyond = max(1.0 - (floor / size) ** 2, ranked[0].explained, 1e-9) if size > 0.0 else 1.0
    ranked = tuple(
        replace(one, of_excess=min(1.0, max(one.explained, 0.0) / beyond) if one.explained > max(chance, _LEAST_SHARE) else 0.0)
        for one in ranked
    )
    foretold = ranked[0].explained if ranked[0].of_excess > 0.0 else 0.0
    merit = max((size / floor) ** 2 - 1.0, foretold * (size / floor) ** 2) if floor > 0.0 else foretold * _squared_share(balance)
    pictures = []
    for axis in at.axes(rod):
        drawn = binned(axis, values)
        if drawn is not None:
            best = max((one for one in ranked if one.axis == axis.name), key=lambda one: one.explained, default=None)
            friction = best is not None and best.friction
            side = binned(axis, values * -at.direction) if friction else None
            share = 100.0 * max(best.explained, 0.0) if best is not None else 0.0
            shape = vars((side or drawn).drawn())
            pictures.append(
                UnknownPicture(**shape, by=axis.name, axis_unit=axis.unit, unit=balance.unit, explained_percent=share, friction=friction)
            )
    pictures.sort(key=lambda one: -one.explained_percent)
    return Unknown(balance.name, what, balance.unit, size, floor, merit, ranked, tuple(pictures))


def _squared_share(balance: Balance) -> float:
    relative = balance.relative_percent
    return (0.01 * relative) ** 2 if math.isfinite(relative) else 0.0


def _ranked(values: Reals, at: MachineState, half: Halves, turns: bool, rod: bool) -> tuple[Ranked, ...]:
    """Every axis, best first, the constant among them; `turns`: also as friction, against the motion; `rod`: over the rod's position."""
    leads = float(np.ptp(at.motor_mm)) / at.lead_mm
    found = []
    for friction in (False, True) if turns else (False,):
        side = -at.direction if friction else np.ones_like(values)
        share = explained(values, side[:, None], half)
        flat = float(side @ values) / max(float(side @ side), 1e-300)
        found.append(Ranked("constant", "", -1, friction, share, share, 0.0, 0.0, np.full(NODES, flat)))
        for axis in at.axes(rod):
            # below a whole turn an angle says no more than the position
            if (
                not np.ptp(axis.values) > 0.0
                or (axis.name == "place in the lead" and leads < 1.0)
                or (axis.name == "motor angle" and np.ptp(at.angle_rad) < axis.period)
            ):
                continue
            first, last = (0.0, axis.period) if axis.period > 0.0 else (float(np.min(axis.values)), float(np.max(axis.values)))
            share, nodes = _table_share(values, axis, side, half, first, last, NODES)
            fine = _table_share(values, axis, side, half, first, last, _FINE_NODES)[0] if axis.kind in _FINE_KINDS else share
            found.append(Ranked(axis.name, axis.unit, axis.kind, friction, max(share, fine), share, first, last, nodes))
    return tuple(_by_merit(found))


def _table_share(values: Reals, axis: Axis, side: Reals, half: Halves, first: float, last: float, nodes: int) -> tuple[float, Reals]:
    """Share explained out of sample by a table of so many nodes, and its nodes; round a period the last is the first again."""
    columns = hats(axis.values, first, last, nodes)
    periodic = axis.period > 0.0
    if periodic:
        columns[:, 0] += columns[:, -1]
        columns = columns[:, :-1]
    columns = columns * side[:, None]
    stiff = _stiffness(columns, periodic)
    smooth = np.zeros(stiff.shape[0])

    def fitted(rows: Halves) -> Reals:
        tall = np.vstack([columns[rows], stiff])
        return np.asarray(
            np.linalg.solve(
                tall.T @ tall + 1e-9 * np.trace(tall.T @ tall) * np.eye(tall.shape[1]), tall.T @ np.concatenate([values[rows], smooth])
            )
        )

    total = float(values @ values)
    left = sum(float(np.sum((values[~rows] - columns[~rows] @ fitted(rows)) ** 2)) for rows in (half, ~half))
    table = fitted(np.ones_like(half))
    return (1.0 - left / total if total > 0.0 else 0.0), np.append(table, table[0]) if periodic else table


def _by_merit(found: list[Ranked]) -> list[Ranked]:
    """Best first; among those that explain nearly as much as the best, the constant first, then the axes that a learned effect can have."""
    order = sorted(found, key=lambda one: -one.explained)
    top = order[0].explained
    near = [one for one in order if top - one.explained < RICHER and one.explained > 0.0]
    near.sort(key=lambda one: (one.axis != "constant", one.kind < 0, -one.explained))
    return near + [one for one in order if not any(one is other for other in near)]


def _stiffness(columns: Reals, periodic: bool) -> Reals:
    """Rows [n, nodes] that make neighbours alike where data are thin."""
    nodes = columns.shape[1]
    weight = math.sqrt(_STIFFNESS * max(float(np.trace(columns.T @ columns)) / nodes, 1e-12))
    bend = np.zeros((nodes, nodes))
    for place in range(nodes):
        low, high = place - 1, place + 1
        if periodic or (low >= 0 and high < nodes):
            bend[place, low % nodes] += 1.0
            bend[place, place] -= 2.0
            bend[place, high % nodes] += 1.0
    return weight * bend


def learned(unknown: Unknown) -> LearnedTable | None:
    """The table for the best axis that a learned effect can have; None when the unknown repeats with no such axis. A constant becomes a flat table over position."""
    for one in unknown.ranked:
        name = learned_effect(unknown.balance, one.friction)
        if one.of_excess < REPEATS_SHARE:
            return None
        table = record_of(name).learned
        if table is not None and one.kind in table.axes and one.tabled > 0.5 * one.explained:
            return _table(name, one)
        if one.axis == "constant":
            along = next((other for other in unknown.ranked if other.axis == "position" and other.friction == one.friction), None)
            if along is not None:
                return _table(name, replace(along, nodes=one.nodes, tabled=one.tabled))
    return None


def _table(effect: str, one: Ranked) -> LearnedTable:
    values = {
        "gain": 1.0,
        "axis": float(one.kind),
        "first": one.first,
        "last": one.last,
        **{f"node_{place:02d}": float(node) for place, node in enumerate(one.nodes)},
    }
    return LearnedTable(
        effect,
        one.axis,
        one.unit,
        one.first,
        one.last,
        one.nodes,
        one.tabled,
        {f"effects.{effect}.{name}": value for name, value in values.items()},
    )
