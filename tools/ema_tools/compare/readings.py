"""Whether the error of one sensor's reading explains what the balances leave: a zero, a scale, a delay, or a wave once or twice per motor turn.

A balance is accused by what it leaves, but its measured signals may be at fault. An error of a reading shows in every balance that reads this signal, in proportions that the equations give; a change
of the machine shows in the balance of its own block. Each candidate is one column over all balances, fitted to the residuals in units of their noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ema_tools.balances.all import all_balances
from ema_tools.balances.balance import Balance
from ema_tools.balances.filtering import Smoother, coarse
from ema_tools.base.arrays import Reals
from ema_tools.base.noise import white_noise
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record

Kind = Literal["zero", "scale", "delay", "wave"]
LEAST_SHARE = 0.9  # so much of the excess must be one sensor's for it to be suspected: physics shows in more than one signal [judgement]
# The controller reads what its own sensors say, right or wrong, so that its balance tells nothing of them.
_BALANCES = ("mechanical", "electrical", "kinematic")
_KINDS: Mapping[str, tuple[Kind, ...]] = {
    "position_mm": ("zero", "scale", "delay", "wave"),
    "motor_position_mm": ("scale", "delay", "wave"),
    "current_A": ("zero", "scale", "delay"),
}
_ROUNDS = 2  # of columns for each error, the last as large as the error itself [effort]
_WAVES = (1, 2)  # periods per motor turn: a disc that is off its axis, and one that is oval [physics]


@dataclass(frozen=True)
class ReadingError:
    """The error of one reading: `size` in the signal's unit for a zero and the amplitude of a wave, relative for a scale, s for a delay; `periods` per motor turn of a wave; `share` of the excess of
    mechanical, electrical and kinematic balance that it explains; `balances`: those in which it shows."""

    channel: str
    kind: Kind
    size: float
    periods: int
    share: float
    balances: tuple[str, ...]


def _shapes(record: Record, angle_rad: Reals, channel: str) -> list[tuple[Kind, int, tuple[Reals, ...]]]:
    """Errors of one reading per unit of their size, [rows] each."""
    signal = record.recorded(channel)
    found: list[tuple[Kind, int, tuple[Reals, ...]]] = []
    for kind in _KINDS[channel]:
        if kind == "wave":
            if np.ptp(angle_rad) >= 2.0 * math.pi:
                found += [(kind, periods, (np.sin(periods * angle_rad), np.cos(periods * angle_rad))) for periods in _WAVES]
        else:
            shape = {"zero": np.ones_like(signal), "scale": signal, "delay": -np.gradient(signal, record.period_s)}[kind]
            found.append((kind, 0, (shape,)))
    return found


def reading_error(
    actuator: Actuator, record: Record, residuals: Mapping[str, Balance], noise: Mapping[str, float], smoother: Smoother
) -> ReadingError | None:
    """The error of one reading that explains at least nine tenths of what balances leave above noise; None where there is none.

    `residuals`: by balance what is judged [samples]; `noise`: by balance the rms that its residual has with nothing wrong, in its unit.
    """
    judged = {name: residuals[name].residual / noise[name] for name in _BALANCES if name in residuals and noise[name] > 0.0}
    if not judged:
        return None
    left = np.concatenate(list(judged.values()))
    excess = float(left @ left) - left.size
    if not excess > 0.0:
        return None
    angle_rad = (
        smoother.smooth(record.position_mm if record.motor_position_mm is None else record.motor_position_mm) / actuator.lead_mm_per_rad
    )
    plain = _stacked(all_balances(actuator, record, smoother), judged, noise, smoother)
    best, most = None, LEAST_SHARE
    for channel in (name for name in _KINDS if name in record.present):
        signal = record.recorded(channel)
        for kind, periods, shapes in _shapes(record, angle_rad, channel):
            # as large as noise first, so that a play turns about where it did; then as large as found, since friction at a reversal is not linear in time
            steps = [white_noise(signal) / max(float(np.sqrt(np.mean(shape**2))), 1e-12) or 1e-6 for shape in shapes]
            for _ in range(_ROUNDS):
                columns = []
                for shape, step in zip(shapes, steps, strict=True):
                    changed = record.with_columns({channel: signal + step * shape})
                    columns.append((_stacked(all_balances(actuator, changed, smoother), judged, noise, smoother) - plain) / step)
                tall = np.column_stack(columns)
                sizes, *_ = np.linalg.lstsq(tall, left, rcond=None)
                steps = [-float(size) or step for size, step in zip(sizes, steps, strict=True)]
            explained = tall @ sizes
            share = float(left @ explained) / excess
            if share < most:
                continue
            ends = np.cumsum([one.size for one in judged.values()])[:-1]
            parts = dict(zip(judged, np.split(explained, ends), strict=True))
            seen = tuple(name for name, part in parts.items() if float(part @ part) > part.size)
            if any(np.linalg.norm(judged[name] - parts[name]) >= np.linalg.norm(judged[name]) for name in seen):
                # a balance that weighs the signal contradicts it
                continue
            size = float(np.linalg.norm(sizes)) if kind == "wave" else float(sizes[0])
            best, most = ReadingError(channel, kind, size, periods, min(share, 1.0), seen), share
    return best


def reading_against_model(
    actuator: Actuator, record: Record, found: Mapping[str, Balance | str], floors: Mapping[str, float], smoother: Smoother
) -> ReadingError | None:
    """The same of balances against the model on fine samples; `floors`: by balance the rms that noise and method leave there, in its unit."""
    residuals, noise = {}, {}
    for name, one in found.items():
        if isinstance(one, Balance) and one.rms > 0.0:
            residuals[name] = coarse(one, smoother)
            noise[name] = floors[name] * residuals[name].rms / one.rms
    return reading_error(actuator, record, residuals, noise, smoother)


def _stacked(found: Mapping[str, Balance | str], judged: Mapping[str, Reals], noise: Mapping[str, float], smoother: Smoother) -> Reals:
    """Residuals of the balances that are judged, in units of their noise, one after the other."""
    parts = []
    for name in judged:
        one = found[name]
        assert isinstance(one, Balance)
        parts.append(coarse(one, smoother).residual / noise[name])
    return np.concatenate(parts)
