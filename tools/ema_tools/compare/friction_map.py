"""The steady-state friction map: what the drive brings up in runs at constant speed, both directions, from any records; inertia and known disturbances taken off.

A run is steady where its speed, averaged over a short window, hardly changes from window to window. Slow ramps count as many short runs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import known_torque_Nm, mechanical_model, quiet_smoother
from ema_tools.balances.motion import Motion, at_points, motion_of
from ema_tools.base import leastsquares
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.interval import interval95
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.library.definitions import load_definitions
from ema_tools.library.registry import record_of

WINDOW_S = 0.2  # over which a speed is averaged, and which a run lasts at least [judgement]
_WINDOW_ROWS = 8  # and so many rows of a slow record [judgement]
_EVEN = 0.1  # share by which the averaged speed may change from one window to the next, and two runs differ and be of one speed [judgement]
_ONE_RUN = (
    0.25  # by which it may leave the speed at which a run began: a slow ramp is many runs, a run that swings a little is one [judgement]
)
_PAIRS_MIN = 4  # speeds that were run both ways, from which on where friction is least is more than the end of a range [judgement]
_ALL = 0.95  # share of a record that keeps one speed, from which on all of it does [judgement]
_ROUGH = 0.5  # share of it by which the speed may swing inside a window, as it does where a machine hardly keeps moving [judgement]
_RESTS = 0.01  # of the largest speed of all records: slower is no motion [judgement]


@dataclass(frozen=True)
class SteadyRun:
    """One run: its record, mean speed rad/s, torque of all its samples Nm, [samples], and how long it lasts."""

    file: str
    speed_rad_s: float
    torque_Nm: Reals
    seconds: float


@dataclass(frozen=True)
class MapPoint:
    """Runs of one speed in one direction: mean torque, the standard deviation of its samples, the 95 % interval of the mean, and the model's torque there. Nm at the motor shaft."""

    speed_rad_s: float
    torque_Nm: float
    swing_Nm: float
    interval: tuple[float | None, float | None]
    model_Nm: float
    runs: int
    seconds: float
    files: tuple[str, ...]


@dataclass(frozen=True)
class SpeedPair:
    """One speed in both directions: half the difference of their torques is friction, half the sum a load."""

    speed_rad_s: float
    friction_Nm: float
    load_Nm: float


@dataclass(frozen=True)
class FrictionMap:
    """The map: points by speed, both directions of one speed, what the records hold of steady runs; `left_out`: records without any, and why."""

    records: tuple[AnyRecord, ...]
    points: tuple[MapPoint, ...]
    pairs: tuple[SpeedPair, ...]
    runs: int
    left_out: dict[str, str]


@dataclass(frozen=True)
class MeasuredBump:
    """Friction of runs at constant speed, both directions: by how much that of the slowest exceeds the least."""

    slowest_rad_s: float
    above_percent: float
    least_at_rad_s: float


def measured_bump(actuator: Actuator, records: Sequence[AnyRecord]) -> MeasuredBump | None:
    """None where the records hold too few speeds run both ways, or friction is least at the slowest."""
    try:
        pairs = friction_map(actuator, records).pairs
    except InputError:
        return None
    least = min(pairs, key=lambda one: one.friction_Nm, default=None)
    if least is None or len(pairs) < _PAIRS_MIN or least is pairs[0] or not least.friction_Nm > 0.0:
        return None
    return MeasuredBump(pairs[0].speed_rad_s, 100.0 * (pairs[0].friction_Nm / least.friction_Nm - 1.0), least.speed_rad_s)


def friction_map(actuator: Actuator, records: Sequence[AnyRecord]) -> FrictionMap:
    """The map of records. Raises InputError where none of them holds a run at constant speed."""
    runs: list[SteadyRun] = []
    left_out: dict[str, str] = {}
    motions: list[tuple[AnyRecord, Motion, Reals, slice]] = []
    for record in records:
        try:
            smoother = quiet_smoother(actuator, record)
            if record.rows < smoother.least_rows:
                left_out[record.file] = f"{record.rows} rows are too few for any filter, {smoother.least_rows} are needed"
                continue
            motion = motion_of(actuator, record, smoother)
            model = mechanical_model(actuator, record, smoother, motion)
        except MissingSignal as error:
            left_out[record.file] = str(error)
            continue
        inertia = adjusted(actuator)["screw.inertia_kgm2"]
        torque = model.drive_Nm - inertia * motion.acceleration_rad_s2 - known_torque_Nm(actuator, record, smoother)
        motions.append((record, motion, torque, slice(smoother.edge_rows, record.rows - smoother.edge_rows)))
    fastest = max((float(np.max(np.abs(motion.speed_rad_s[inner]), initial=0.0)) for _, motion, _, inner in motions), default=0.0)
    for record, motion, torque, inner in motions:
        here = _steady_runs(record, motion.speed_rad_s[inner], torque[inner], _RESTS * fastest)
        if not here:
            left_out[record.file] = "no speed is kept"
        runs += here
    if not runs:
        why = "; ".join(f"{file}: {reason}" for file, reason in list(left_out.items())[:1])
        raise InputError(
            f"map: no run at constant speed ({why}): record runs of {WINDOW_S:g} s or longer at one speed each, both directions"
        )
    points = tuple(_point(actuator, group) for group in _grouped(runs))
    return FrictionMap(tuple(records), points, _pairs(points), len(runs), left_out)


def _steady_runs(record: AnyRecord, speed: Reals, torque: Reals, slowest: float) -> list[SteadyRun]:
    """Stretches of one record in which the speed is kept."""
    window = max(math.ceil(WINDOW_S / record.period_s), _WINDOW_ROWS)
    if speed.size < 2 * window:
        window = speed.size // 2
    if window < 2:
        return []
    sums = np.concatenate(([0.0], np.cumsum(speed)))
    squares = np.concatenate(([0.0], np.cumsum(speed**2)))
    mean = (sums[window:] - sums[:-window]) / window
    swing = np.sqrt(np.maximum((squares[window:] - squares[:-window]) / window - mean**2, 0.0))
    # the window before and behind each place
    before, behind = mean[:-window], mean[window:]
    middle = 0.5 * (before + behind)
    even = (np.abs(behind - before) <= _EVEN * np.abs(middle)) & (np.abs(middle) > max(slowest, 0.0))
    even &= np.maximum(swing[:-window], swing[window:]) <= _ROUGH * np.abs(middle)
    if even.size == 0 and float(np.std(speed)) <= _EVEN * abs(float(np.mean(speed))):
        even, middle, window = np.ones(1, dtype=bool), np.array([float(np.mean(speed))]), speed.size // 2
    kept = float(np.median(middle)) if middle.size else 0.0
    if abs(kept) > slowest and float(np.mean(np.abs(middle - kept) <= _ONE_RUN * abs(kept))) >= _ALL:
        # a record of one speed is one run, however roughly the machine keeps it
        return [SteadyRun(record.file, float(np.mean(speed)), torque, speed.size * record.period_s)]
    edges = np.flatnonzero(np.diff(np.concatenate(([0], even.astype(np.int8), [0]))))
    found = []
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        begin = first
        while begin < last:
            off = np.flatnonzero(np.abs(middle[begin:last] - middle[begin]) > _ONE_RUN * abs(middle[begin]))
            end = begin + int(off[0]) if off.size else last
            # a place stands for the windows to both sides of it
            rows = slice(begin, min(end - 1 + 2 * window, speed.size)) if end - begin > 1 or last - first == 1 else slice(begin, begin)
            if rows.stop - rows.start >= window:
                found.append(SteadyRun(record.file, float(np.mean(speed[rows])), torque[rows], (rows.stop - rows.start) * record.period_s))
            begin = end
    return found


def _grouped(runs: Sequence[SteadyRun]) -> list[list[SteadyRun]]:
    """Runs of one speed in one direction, by speed."""
    groups: list[list[SteadyRun]] = []
    for side in (-1.0, 1.0):
        ordered = sorted((run for run in runs if run.speed_rad_s * side > 0.0), key=lambda run: abs(run.speed_rad_s))
        here: list[list[SteadyRun]] = []
        for run in ordered:
            if here and abs(run.speed_rad_s) <= (1.0 + _EVEN) * abs(here[-1][0].speed_rad_s):
                here[-1].append(run)
            else:
                here.append([run])
        groups += here
    return sorted(groups, key=lambda group: group[0].speed_rad_s)


def _point(actuator: Actuator, group: Sequence[SteadyRun]) -> MapPoint:
    torque = np.concatenate([run.torque_Nm for run in group])
    weights = np.array([run.seconds for run in group])
    speed = float(np.average([run.speed_rad_s for run in group], weights=weights))
    mean = float(np.mean(torque))
    # neighbouring samples are alike, and so are those of one run
    within = sum(float(leastsquares.long_run((run.torque_Nm - mean)[:, None])[0, 0]) for run in group)
    between = float(sum((np.sum(run.torque_Nm - mean)) ** 2 for run in group)) * len(group) / max(len(group) - 1, 1)
    std = math.sqrt(max(within, between if len(group) > 1 else 0.0)) / torque.size
    files = tuple(dict.fromkeys(run.file for run in group))
    model = float(model_torque_Nm(actuator, np.array([speed]))[0])
    return MapPoint(speed, mean, float(np.std(torque)), interval95(mean, std), model, len(group), float(np.sum(weights)), files)


def _pairs(points: Sequence[MapPoint]) -> tuple[SpeedPair, ...]:
    """Speeds that were run both ways."""
    found = []
    back = [point for point in points if point.speed_rad_s < 0.0]
    for forward in (point for point in points if point.speed_rad_s > 0.0):
        near = [point for point in back if abs(-point.speed_rad_s - forward.speed_rad_s) <= _EVEN * forward.speed_rad_s]
        if near:
            other = min(near, key=lambda point: abs(-point.speed_rad_s - forward.speed_rad_s))
            found.append(
                SpeedPair(forward.speed_rad_s, 0.5 * (forward.torque_Nm - other.torque_Nm), 0.5 * (forward.torque_Nm + other.torque_Nm))
            )
    return tuple(found)


def model_torque_Nm(actuator: Actuator, speed_rad_s: Reals) -> Reals:
    """What the model asks of the drive at constant speeds, waves along the way left out, [speeds]."""
    waves = {size: zero for name, size, zero in load_definitions().sizes if record_of(name).periodic is not None}
    even = actuator.changed({size: zero for size, zero in waves.items() if actuator.values[size] != zero})
    values, nothing = adjusted(even), np.zeros_like(speed_rad_s)
    motion = Motion(nothing, speed_rad_s, nothing, nothing, nothing)
    side = np.sign(speed_rad_s)
    load = at_points(even, motion, "LOAD") + values["screw.load_torque_Nm"]
    total = load - at_points(even, motion, "TORQUE") + values["screw.viscous_Nm_s_per_rad"] * speed_rad_s
    for one in (-1.0, 1.0):
        level = values["screw.dynamic_ratio"] * values["screw.csj_Nm"] * (1.0 + one * values["screw.friction_asymmetry"])
        drag = level + at_points(even, motion, "FRICTION", level_Nm=level, rows=side == one, side=one)
        passing = np.where(load * one > 0.0, 1.0 / values["gearbox.efficiency"] - 1.0, 1.0 - values["gearbox.efficiency"]) * np.abs(load)
        total = total + np.where(side == one, one * (drag + passing), 0.0)
    return np.asarray(total)
