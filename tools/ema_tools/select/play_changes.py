"""What motor and rod position together say of the play between them, today's records against healthy ones, whoever controls the machine.

The balance of forces hardly sees a play: the motor moves the same masses with and without it, but for moments. Two encoders see it directly: the rod stands half of it to one side of the motor or to
the other. Which side, friction decides (the side that the motor comes from, the play of the module), or a load that outweighs it: then it changes where the load does and not where the motion
turns.

A rod that is read a little later than the motor is behind it by as much as the speed is large: nearly as with a play that turns with the motion. Where only the motor's speed is recorded, its
integral is the motor's position but for a drift besides, and for the lag of the filter that drives report a speed through. All of that is fitted beside the play, and what of the play it does not
take up tells the width.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ema_tools.balances.effects import transmission_of
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.motion import train_of
from ema_tools.base.arrays import Reals
from ema_tools.base.interval import WIDTH_95
from ema_tools.base.orthonormal import orthonormal
from ema_tools.compare.validity import RecordRemark
from ema_tools.data.actuator import STARTS, Actuator, row_of
from ema_tools.data.motion_records import AnyRecord
from ema_tools.data.motion_signals import integrated
from ema_tools.plant.native import library
from ema_tools.select.base_values import BaseValue
from ema_tools.select.healthy_balance import HealthyByBalance
from ema_tools.select.value_changes import Change

PLAY = "screw.blk_mm"
_LEAST = 0.05  # scatter of a play from record to record, relative, at least: contacts seat otherwise each day [judgement]
_OF_LEFT = 0.3  # ... and as a share of what the play leaves of the rod's position, rms: a width in that is not seen well [judgement]
_FORM = 0.07  # of a play, that contacts which yield and a rod with a mass take off what is seen, one standard deviation [judgement]
_LEAST_TIMES = 3.0  # such standard deviations are a change [chance]
_EXPLAINED = 0.999  # of the rod's square about its mean, that the motor must explain: else other things lie between the two, or one is of another axis [judgement]
_CLEARLY = 0.95  # of what is left where friction decides the side: the best of hundreds of loads leaves as little by chance [chance]
_LAG_TRUSTED = 0.02  # of a lag between two encoders, to which its slope over the smoothed speed is trusted [judgement]
_LAG_LEAST_S = 5e-5  # doubt of a lag at least [judgement]
_LAG_TOLD = 3.0  # standard deviations from which on a lag is told [chance]
_WIDEST = 0.25  # of the motor's way: a play as wide as that is not seen as one [judgement]
_WIDTHS = 24  # widths looked at before the best is refined [effort]
_NARROWEST = 1e-4  # of the widest, the first of them [precision]
_SHARES = np.linspace(0.0, 1.2, 25)  # friction of the rod, as a share of the largest load, that are tried [effort]
_INERTIAS = np.array([0.0, 0.1, 0.2, 0.4, 0.8, 1.6])  # force of the rod's mass, as a share of the largest load, that are tried [effort]
_OWN = 0.05  # of the square of the play's side, that the drift and the lag of an integrated speed must leave: else they look like a play [judgement]
_AS_LIKELY = 1.5  # times what the best fit leaves: so may well be what leaves no more, since a lag blurs each turn [judgement]
_CHOSEN = 2.0  # times what the fit of one side tells, for that side was chosen among hundreds by the same drift [judgement]
_SETTLES_S = 0.05  # by then the rod has passed the play, and a speed filtered by 10 ms shows the turn [judgement]
_ROWS = 0.3  # of the rows that move, that must be left by that [judgement]
_SAME = 1e-9  # of the same: so little is none [precision]
_NEARBY = 0.3  # of a frequency: what is left is as strong so near to it [judgement]
_NEARBY_LINES = 6  # ... and at least so many lines of a spectrum, more than a fit takes away [judgement]
_MOVES = 0.02  # of the greatest speed: slower than that, the rod's friction has no direction [judgement]


@dataclass(frozen=True)
class SeenPlay:
    """The play that one record shows, and what it leaves of the rod's position, rms; `drift_mm`: how far drift and lag of a motor position that was integrated may put the play off, one standard
    deviation, 0 of a recorded one. All in mm. `lag_s`, `lag_std_s`: by how much the rod is read later than the motor, where both positions are recorded, and one standard deviation, which is
    infinite where the motion does not tell a lag from a play: the width is then right if there is none, and its change from record to record is right whatever the lag."""

    width_mm: float
    left_mm: float
    drift_mm: float = 0.0
    lag_s: float = 0.0
    lag_std_s: float = 0.0

    @property
    def lags(self) -> bool:
        """Whether one of the two is surely read later than the other."""
        return abs(self.lag_s) > _LAG_TOLD * self.lag_std_s > 0.0

    @property
    def doubt_mm(self) -> float:
        """What it leaves, or as much as would make the width as doubtful as drift and lag do."""
        return max(self.left_mm, self.drift_mm / _OF_LEFT)


@dataclass(frozen=True)
class _Motor:
    """The motor at the rod: mm, its smoothed speed mm/s, [rows], and what the position may be off by beside a constant, [rows, k]: what a lag makes, last, and of an integrated speed its drift."""

    mm: Reals
    speed_mm_s: Reals
    errors: Reals
    integrated: bool


@dataclass(frozen=True)
class _Fit:
    """A width that was fitted in mm, and on the `rows` that move [all rows]: the side at which the rod stands, less what all other columns make of it, what is left of the rod, mm, and the share of
    the side's square that the other columns do not make. `whole`: the side at all rows."""

    width_mm: float
    side: Reals
    left: Reals
    own: float
    rows: NDArray[np.bool_]
    whole: Reals

    @property
    def left_mm(self) -> float:
        """What is left, rms."""
        return math.sqrt(float(np.mean(self.left**2)))


def play_seen(actuator: Actuator, record: AnyRecord) -> SeenPlay | None:
    """Play between motor and rod by the rod's position and the motor's, or the motor's speed; None where one of them is not recorded, or the rod does not follow the motor, or drift and lag of an
    integrated speed look like a play in this motion."""
    smoother = Smoother.of(record.period_s)
    rod = record.position_mm
    if rod is None or transmission_of(actuator) or record.rows < smoother.least_rows:
        return None
    motor = _motor(actuator, record, smoother)
    about = float(np.var(rod))
    if motor is None or not float(np.ptp(motor.mm)) > 0.0 or not about > 0.0:
        return None
    # at rest the rod may stay anywhere in the play
    moves = np.abs(motor.speed_mm_s) > _MOVES * float(np.max(np.abs(motor.speed_mm_s)))
    turned = np.where(moves, np.sign(motor.speed_mm_s), 0.0)
    if np.count_nonzero(_counted(motor, turned, _held(turned), record.period_s)) <= _ROWS * np.count_nonzero(turned):
        return None
    found, sure = _best(actuator, record, motor, rod, turned, smoother)
    if not sure and not motor.integrated:
        # with one lag, that of both encoders, in every record
        found, _ = _best(actuator, record, replace(motor, errors=motor.errors[:, :0]), rod, turned, smoother)
    if not found.left_mm**2 <= (1.0 - _EXPLAINED) * about or (motor.integrated and not sure):
        return None
    if not motor.integrated:
        return SeenPlay(found.width_mm, found.left_mm, 0.0, *(_lag(motor, rod, found, smoother) if sure else (0.0, math.inf)))
    return SeenPlay(found.width_mm, found.left_mm, _CHOSEN * _std_by_left(found))


def _best(actuator: Actuator, record: AnyRecord, motor: _Motor, rod: Reals, turned: Reals, smoother: Smoother) -> tuple[_Fit, bool]:
    """The fit that leaves least, and whether nothing but a play makes it: a play behind friction that drift and lag take up wholly leaves as little whatever else decides the side."""
    by_friction = _by_motion(actuator, motor, rod, turned, smoother)
    by_load = min(_by_load(record, smoother, motor, rod, turned), key=lambda one: one.left_mm, default=by_friction)
    found = by_load if by_load.left_mm < _CLEARLY * by_friction.left_mm else by_friction
    likely = (found, by_friction) if by_friction.left_mm < _AS_LIKELY * found.left_mm else (found,)
    return found, min(one.own for one in likely) >= _OWN


def _of_lag(position_mm: Reals, smoother: Smoother) -> Reals:
    """What a short lag of a position makes of it, [rows, 2]: its speed, last, and its acceleration."""
    speed = np.gradient(smoother.smooth(position_mm), smoother.period_s)
    return np.column_stack([np.gradient(speed, smoother.period_s), speed])


def _by_motion(actuator: Actuator, motor: _Motor, rod: Reals, turned: Reals, smoother: Smoother) -> _Fit:
    """The width of a play behind which friction holds the rod, that fits best."""
    moves = _counted(motor, turned, _held(turned), smoother.period_s)
    widest = min(_WIDEST * float(np.ptp(motor.mm)), row_of(PLAY).upper)

    def behind(width: float) -> Reals:
        return np.asarray(library().play(*actuator.changed({PLAY: width}).arrays(), motor.mm, float(motor.mm[0])))

    def apart(values: Reals, errors: Reals) -> Reals:
        about = values - np.mean(values)
        return about - errors @ (errors.T @ about)

    def beside(modelled: Reals) -> Reals:
        """An orthonormal basis of what a position may be off by where the rod does what is `modelled`: it stands while the motor passes the play, and that is read late."""
        columns = motor.errors if motor.integrated or not motor.errors.size else _of_lag(modelled, smoother)
        return orthonormal(columns[moves] - np.mean(columns[moves], axis=0))[0]

    def rest(width: float) -> Reals:
        modelled = behind(width)
        errors = beside(modelled)
        moved, seen = apart(modelled[moves], errors), apart(rod[moves], errors)
        gain = float(moved @ seen) / float(moved @ moved) if np.any(moved) else 0.0
        return seen - gain * moved

    def left(width: float) -> float:
        return float(np.mean(rest(width) ** 2))

    widths = [0.0, *np.geomspace(_NARROWEST * widest, widest, _WIDTHS).tolist()]
    squares = [left(width) for width in widths]
    best = int(np.argmin(squares))
    ends = widths[max(best - 1, 0)], widths[min(best + 1, len(widths) - 1)]
    found = minimize_scalar(left, bounds=ends, method="bounded", options={"xatol": _NARROWEST * widest})
    width = float(found.x) if found.fun < squares[best] else widths[best]
    side = (motor.mm - behind(width)) / (0.5 * width) if width > 0.0 else turned
    errors = beside(behind(width))
    own = apart(side[moves], errors)
    moved = apart(motor.mm[moves], errors)
    own = own - moved * (float(moved @ own) / float(moved @ moved))
    return _Fit(width, own, rest(width), float(own @ own) / float(side[moves] @ side[moves]), moves, side)


def _by_load(record: AnyRecord, smoother: Smoother, motor: _Motor, rod: Reals, turned: Reals) -> Iterator[_Fit]:
    """Widths of a play in which a load pushes the rod to a side, of which the rod's friction is a share: the recorded load, else one that grows along the way, as a spring's. `turned`: direction of
    the motor, 0 at rest, [rows]."""
    ahead = motor.mm - rod
    # an integral drifts away from where the spring is at rest
    way = rod if motor.integrated else motor.mm
    along = smoother.smooth(way - np.mean(way))
    measured = getattr(record, "disturbance_N", None)
    gains = np.gradient(motor.speed_mm_s, record.period_s)
    for load in (along, smoother.smooth(measured)) if measured is not None else (along,):
        columns = np.column_stack([np.ones_like(motor.mm), motor.mm, motor.errors, *([load] if load is not along else [])])
        largest = float(np.max(np.abs(load)))
        inertias = _INERTIAS * largest / (float(np.max(np.abs(gains))) or 1.0)
        for force in (load + inertia * gains for inertia in inertias):
            for share in _SHARES * largest:
                side = _held(np.sign(force + share * turned))
                rows = _counted(motor, turned, side, record.period_s)
                if np.count_nonzero(rows) <= _ROWS * np.count_nonzero(turned):
                    continue
                basis, _ = orthonormal(columns[rows])
                here, seen = side[rows], ahead[rows]
                own, seen = here - basis @ (basis.T @ here), seen - basis @ (basis.T @ seen)
                square = float(own @ own)
                half = float(own @ seen) / square if square > _SAME * here.size else 0.0
                yield _Fit(2.0 * abs(half), own, seen - half * own, square / here.size, rows, np.sign(half) * side)


def _counted(motor: _Motor, turned: Reals, side: Reals, period_s: float) -> NDArray[np.bool_]:
    """Rows that are fitted: where the motor moves, and for some time no side was changed, [rows]. On its way through the play the rod is anywhere, and a filtered speed does not show how the motor
    turned round; an integral would make a lag of either. Of a recorded position all rows that move serve where sides change faster than that."""
    moves: NDArray[np.bool_] = turned != 0.0
    places = np.arange(side.size)
    changed = np.concatenate(([False], side[1:] != side[:-1]))
    since = places - np.maximum.accumulate(np.where(changed, places, -side.size))
    settled: NDArray[np.bool_] = moves & (since >= _SETTLES_S / period_s)
    return settled if motor.integrated or np.count_nonzero(settled) > _ROWS * np.count_nonzero(moves) else moves


def _lag(motor: _Motor, rod: Reals, fit: _Fit, smoother: Smoother) -> tuple[float, float]:
    """By how much the rod is read later than the motor, s, beside a play of this width, and one standard deviation."""
    behind = motor.mm - 0.5 * fit.width_mm * fit.whole
    columns = np.column_stack([_of_lag(behind, smoother)[:, ::-1], behind, np.ones_like(behind)])[fit.rows]
    found, *_ = np.linalg.lstsq(columns, rod[fit.rows], rcond=None)
    by_noise = fit.left_mm * math.sqrt(float(np.linalg.inv(columns.T @ columns)[0, 0]))
    lag_s = -float(found[0])
    return lag_s, math.hypot(by_noise, _LAG_TRUSTED * lag_s, _LAG_LEAST_S)


def _std_by_left(fit: _Fit) -> float:
    """How far a width may be off by what is left, one standard deviation in mm: by how much of it, as strong at nearby frequencies, the side takes for its own. What drifts is left in waves as slow
    as the motion, of which few fit into a record."""
    length = 2 * fit.side.size
    side, left = np.abs(np.fft.rfft(fit.side, length)) ** 2, np.abs(np.fft.rfft(fit.left, length)) ** 2
    places = np.arange(left.size)
    reach = np.maximum(_NEARBY_LINES, np.round(_NEARBY * places).astype(int))
    first, last = np.maximum(places - reach, 0), np.minimum(places + reach + 1, left.size)
    total = np.concatenate(([0.0], np.cumsum(left)))
    nearby = (total[last] - total[first]) / (last - first)
    return 2.0 * math.sqrt(2.0 * float(side @ nearby) / length / fit.side.size) / float(fit.side @ fit.side)


def _held(side: Reals) -> Reals:
    """The side of each row, that of the row before where there is none, [rows]."""
    last = np.maximum.accumulate(np.where(side != 0.0, np.arange(side.size), 0))
    return np.asarray(side[last])


def plays_seen(actuator: Actuator, records: Sequence[AnyRecord]) -> tuple[SeenPlay, ...]:
    """The play of each record that tells it."""
    return tuple(one for one in (play_seen(actuator, record) for record in records) if one)


def play_changes(machine: HealthyByBalance, before: Sequence[SeenPlay], after: Sequence[SeenPlay]) -> tuple[Change, ...]:
    """The play, where two healthy records or more (`before`) and one of today (`after`) tell it; nothing where they do not."""
    if len(before) < 2 or not after:
        return ()
    (healthy, shown), (today, _) = _told(before), _told(after)
    limit = max(machine.times * shown, _LEAST_TIMES * _least(healthy, before)) * math.sqrt(1.0 + 1.0 / len(before))
    limit = max(limit, _LEAST_TIMES * math.hypot(_by_drift(before), _by_drift(after)))
    change = today - healthy
    std = math.hypot(_std_of_mean(before), _std_of_mean(after), _FORM * change)
    return (Change(PLAY, healthy, today, std, limit, abs(change) > limit),)


def play_value(given: Actuator, seen: Sequence[SeenPlay]) -> tuple[BaseValue, ...]:
    """The play as records show it that tell it from a lag, beside what the actuator's file states; nothing where none does."""
    seen = [one for one in seen if math.isfinite(one.lag_std_s)]
    if not seen:
        return ()
    width, _ = _told(seen)
    by_import = not given[PLAY] > 0.0 or given.remark(PLAY) in STARTS
    return (BaseValue(PLAY, given[PLAY], by_import, width, math.hypot(_std_of_mean(seen), _FORM * width), "", False, math.nan, math.nan),)


def lag_remarks(seen: Sequence[SeenPlay]) -> tuple[RecordRemark, ...]:
    """What is said of two encoders of which one is surely read later than the other."""
    sure = [one for one in seen if one.lags]
    if not sure:
        return ()
    weights = np.array([one.lag_std_s**-2 for one in sure])
    lag_ms = 1e3 * float(np.average([one.lag_s for one in sure], weights=weights))
    half_ms = WIDTH_95 * 1e3 * max(one.lag_std_s for one in sure)
    which = "rod is read {0} ms after the motor" if lag_ms > 0.0 else "motor is read {0} ms after the rod"
    told = which.format(f"{abs(lag_ms):.2f} [{max(abs(lag_ms) - half_ms, 0.0):.2f} .. {abs(lag_ms) + half_ms:.2f}]")
    return (
        RecordRemark(
            "lag", "weakens", f"the {told}, which is no play (BLK) and is taken off", "read both encoders at the same instant", sensor=True
        ),
    )


def _told(seen: Sequence[SeenPlay]) -> tuple[float, float]:
    """Mean width, and how the records differ; those of which it leaves less count for more."""
    widths, weights = np.array([one.width_mm for one in seen]), np.array([one.doubt_mm**-2 if one.doubt_mm > 0.0 else 1.0 for one in seen])
    mean = float(np.average(widths, weights=weights))
    spread = float(np.average((widths - mean) ** 2, weights=weights))
    return mean, math.sqrt(spread * len(seen) / (len(seen) - 1)) if len(seen) > 1 else 0.0


def _least(width: float, seen: Sequence[SeenPlay]) -> float:
    """By how much records differ at least."""
    return max(_LEAST * width, _OF_LEFT * min(one.doubt_mm for one in seen))


def _std_of_mean(seen: Sequence[SeenPlay]) -> float:
    """How far the mean of these may be off: as they differ, and no less than records do."""
    width, shown = _told(seen)
    return max(max(shown, _least(width, seen)) / math.sqrt(len(seen)), _by_drift(seen))


def _by_drift(seen: Sequence[SeenPlay]) -> float:
    """How far drift and lag may put the mean of these off, one standard deviation; 0 where one of them has neither."""
    return 1.0 / math.sqrt(sum(one.drift_mm**-2 for one in seen)) if all(one.drift_mm > 0.0 for one in seen) else 0.0


def _motor(actuator: Actuator, record: AnyRecord, smoother: Smoother) -> _Motor | None:
    """The motor at the rod as an encoder recorded it, else the integral of its speed, which drifts by as much as a play is wide; None without either. The rod's speed is none of the motor."""
    lead = train_of(actuator).mm_per_rad
    angle, speed = getattr(record, "motor_angle_rad", None), getattr(record, "motor_speed_rad_s", None)
    place = record.motor_position_mm
    if place is None and angle is not None and lead is not None:
        place = np.asarray(lead * angle)
    if place is not None:
        lag = _of_lag(place, smoother)
        return _Motor(place, lag[:, -1], lag, False)
    if speed is None or lead is None:
        return None
    moved = np.asarray(lead * speed)
    smooth = smoother.smooth(moved)
    time = np.linspace(-1.0, 1.0, record.rows)
    # an error of the speed makes a straight line, one that warms away a parabola; what a drive filters its speed by takes of the integral what the speed is, and what its rate is
    errors = np.column_stack([time, time**2, np.gradient(smooth, record.period_s), moved])
    return _Motor(integrated(moved, record.period_s), smooth, errors, True)
