"""By how much a drive records late, found where inertia and friction fit the records best; and whether it, or an effect in its place, is what the records show."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.lag import lagged, remembered
from ema_tools.base.progress import Report, untold
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.select.balance_bench import Bench, FoldErrors, solved
from ema_tools.select.fixes import NONE, Fixes

_LONGEST_S = 0.015  # what filters a drive as it is recorded takes less, else it was another clock [judgement]
_TRIED = (0.03, 0.06, 0.12, 0.25, 0.5, 1.0)  # of the longest, to either side, between which the best is then sought [effort]
_NEAR = 0.02  # of the best of them, to which it is sought [precision]
# Share of the longest whose memory of a rest is left out at first; how near to the one found it must be; and how often [effort]
_FIRST, _TWICE, _ROUNDS = 0.12, 2.0, 3
_INSIDE = 0.95  # of the longest: a lag on its end is another clock, or no lag [precision]
_MOST = 0.5  # of the parts in which the error must fall [judgement]
_FALLS = 0.05  # share of the squared error that a lag must take off: it stands for nothing else then [judgement]
_SAME = 0.05  # lags that differ by less, relative, are one [judgement]
_GUESS_S = 1e-3  # of what filters drives as they are recorded [judgement]
_AGAIN = 2  # times that a lag is sought beside the effects that were found with it [effort]
_AS_GOOD = 0.05  # answers whose squared errors differ by less, relative, are as good as each other [judgement]


class Lagging(Protocol):
    """What a search or a refit by the balance comes to: its model, the errors of the actuator as it was given, and those of the model."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def actuator(self) -> Actuator: ...
    @property
    def given(self) -> FoldErrors: ...
    @property
    def errors(self) -> FoldErrors: ...


Answer = TypeVar("Answer", bound=Lagging)


@dataclass(frozen=True)
class _Recorded:
    """One record before any lag: drive, what is known beside it and the columns of the base values, [rows] and [rows, 5], and where it rests."""

    period_s: float
    drive: Reals
    asked: Reals
    resting: NDArray[np.bool_]


def drive_lag_s(actuator: Actuator, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord] = (), fixes: Fixes = NONE) -> float:
    """Time constant of the drive's record, negative where the motion is late; zero where the records do not show one.

    Of several records all are held to have the same one. What the user held out is not looked at. Raises MissingSignal, InputError.
    """
    bench = Bench(actuator.with_drive_lag(0.0), records, holdout, fixes)
    pieces = bench.start.setting.pieces
    rows = [
        _Recorded(
            piece.record.period_s,
            piece.model.drive_Nm,
            np.column_stack([piece.model.load_Nm + piece.model.added_Nm, piece.model.columns]),
            piece.model.still,
        )
        for piece in pieces
    ]
    found_s, seen_s = 0.0, _FIRST * _LONGEST_S
    for _ in range(_ROUNDS):
        # the same samples under every lag that is tried: where one remembers a rest, no friction is known
        known = [~remembered(one.resting, one.period_s, seen_s) for one in rows]
        fitted = bench.fitted & np.concatenate([smoother.kept(one) for one, smoother in zip(known, bench.smoothers, strict=True)])
        if not fitted.any():
            return 0.0
        found_s = _best_s(bench, rows, fitted)
        if abs(found_s) <= seen_s <= _TWICE * abs(found_s) or not found_s:
            break
        seen_s = max(abs(found_s), _FIRST * _LONGEST_S)
    return found_s


def _best_s(bench: Bench, rows: Sequence[_Recorded], fitted: NDArray[np.bool_]) -> float:
    """The lag that leaves least of some samples; zero where none leaves clearly less."""

    def squares(lag_s: float) -> Reals:
        """Squared error of each part, over what is to be explained, [folds]."""
        target, base = [], []
        for one, smoother in zip(rows, bench.smoothers, strict=True):
            drive = smoother.decimated(lagged(one.drive, one.period_s, -lag_s))
            asked = smoother.decimated(lagged(one.asked, one.period_s, lag_s))
            target.append(drive - asked[:, 0])
            base.append(asked[:, 1:])
        wanted, columns = np.concatenate(target)[fitted], np.concatenate(base)[fitted]
        left = wanted - columns @ solved(columns, wanted)
        return np.bincount(bench.fold[fitted], weights=left**2, minlength=bench.division.folds) / (float(np.sum(wanted**2)) or 1.0)

    def square(lag_s: float) -> float:
        return float(np.sum(squares(lag_s)))

    tried = sorted([0.0, *(sign * share * _LONGEST_S for sign in (-1.0, 1.0) for share in _TRIED)])
    place = int(np.argmin([square(lag_s) for lag_s in tried]))
    ends = tried[max(place - 1, 0)], tried[min(place + 1, len(tried) - 1)]
    near = _NEAR * max(abs(tried[place]), _TRIED[0] * _LONGEST_S)
    best_s = float(minimize_scalar(square, bounds=ends, method="bounded", options={"xatol": near}).x)
    if abs(best_s) > _INSIDE * _LONGEST_S:
        return 0.0
    without, with_it = squares(0.0), squares(best_s)
    parts = without > 0.0
    falls = float(np.sum(with_it)) < (1.0 - _FALLS) * float(np.sum(without))
    return best_s if falls and float(np.mean(with_it[parts] < without[parts])) > _MOST else 0.0


def with_lag_fitted(
    run: Callable[[Actuator, Report], Answer],
    actuator: Actuator,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord] = (),
    fixes: Fixes = NONE,
    progress: Report | None = None,
) -> Answer:
    """What `run` makes of an actuator whose drive is as late as the records show, where it does not state that and it is the better answer.

    Beside an effect that was found the lag is another one, so that it is sought again.
    """
    report = progress or untold
    if actuator.drive_lag_s is not None:
        return run(actuator, report)
    at_once = run(actuator, lambda share, text: report(0.5 * share, text))
    # a large effect hides a lag until it is in the model
    lag_s = drive_lag_s(actuator, records, holdout, fixes) or drive_lag_s(at_once.actuator, records, holdout, fixes)
    if not lag_s and _left(at_once)[1]:
        report(1.0, "done")
        return at_once
    # an effect that is refused for what a lag does to it is found with about that lag
    shown, lag_s = bool(lag_s), lag_s or _GUESS_S
    try:
        late = run(actuator.with_drive_lag(lag_s), lambda share, text: report(0.5 + 0.25 * share, text))
    except InputError:
        # an effect that is asked for may not show beside a lag that is none
        report(1.0, "done")
        return at_once
    if not shown and not _left(late)[1]:
        report(1.0, "done")
        return at_once
    for _ in range(_AGAIN):
        again_s = drive_lag_s(late.actuator, records, holdout, fixes)
        if not again_s or math.isclose(again_s, lag_s, rel_tol=_SAME):
            break
        other = run(actuator.with_drive_lag(again_s), lambda share, text: report(0.75 + 0.2 * share, text))
        if _left(other) >= _left(late):
            break
        late, lag_s = other, again_s
    report(1.0, "done")
    return replace(late, given=at_once.given) if _explains_more(_left(late), _left(at_once)) else at_once


def _left(answer: Lagging) -> tuple[float, int]:
    """Mean squared error of the parts when each is held out, and how many effects the model has."""
    return float(np.nanmean(np.square(answer.errors.each))), len(answer.actuator.active_effects)


def _explains_more(late: tuple[float, int], at_once: tuple[float, int]) -> bool:
    """Whether a drive that records late is the better answer: it leaves less, or as much with fewer effects, of which it counts as one."""
    (error, effects), (other, others) = late, at_once
    if error < (1.0 - _AS_GOOD) * other:
        return True
    return error <= (1.0 + _AS_GOOD) * other and effects + 1 < others
