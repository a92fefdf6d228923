"""Whether healthy records are of one machine in one state: one that is not healthy must not be taken for scatter.

Each record is read against the others, with CSJ, BLK, grease and winding free as from day to day. Days scatter evenly; where the widest gap between records is far wider than the next,
they fall into two groups, one of which is not what the other is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.noise import white_noise
from ema_tools.base.parallel import each
from ema_tools.data.actuator import row_of
from ema_tools.data.records import Record
from ema_tools.fit.evidence import Evidence
from ema_tools.fit.whitening import counted, least_noise, spectrum
from ema_tools.select.known_machine import Compared, KnownMachine, MachineFit
from ema_tools.select.run_to_run import days_of, without_days
from ema_tools.select.two_groups import FRICTION_OF_DAYS, two_groups

# How far values of one machine may lie apart on two days, relative: beyond, one record is of another state. Grease may do anything [judgement]
_OF_DAYS = {"screw.csj_Nm": FRICTION_OF_DAYS, "screw.blk_mm": 0.2, "motor.resistance_ohm": 0.15}
_NOISE = 2.0  # times the sensors' noise may be left between two records [judgement]
_NOT_SENSED = ("voltage_V",)  # the controller's answer to noise, not a sensor of its own [physics]
_ASKED = 0.95  # of the power of the commanded speed lies below a frequency ... [judgement]
_HARMONICS = 5.0  # ... of which what a model lacks has as many multiples: above is noise, and below as much of it as there [judgement]


@dataclass(frozen=True)
class Apart:
    """Two groups of healthy records, the places of the smaller one, and what tells them apart: the name of a value, or of a signal; `by`: how far, relative or in the noise of the signal."""

    places: tuple[int, ...]
    what: str
    by: float


def two_states(beside: Compared, bases: Sequence[MachineFit]) -> Apart | None:
    """Two groups of the healthy repeats, whose fits are `bases`; None where they are one."""
    for name, usual in _OF_DAYS.items():
        if all(name in base.values for base in bases) and beside.actuator[name] > 0.0:
            values = np.array([base.values[name] for base in bases]) / beside.actuator[name]
            found = two_groups(np.abs(values[:, None] - values[None, :]), usual)
            if found is not None:
                return Apart(found[0], name, found[1])
    pairs = list(zip(beside.known_repeats, bases, strict=True))
    apart = _apart_in_signals(beside, np.array(each(lambda one: _left(*one), pairs)))
    if apart is None or not beside.unit.varies:
        return apart
    # days differ in more than what is free in a machine that is taken for known
    unit = beside.unit
    days = days_of(unit.actuator, unit.record, unit.channels, unit.start_mm)
    return _apart_in_signals(beside, np.array(each(lambda one: _left(*one, days), pairs)))


def _apart_in_signals(beside: Compared, left: Reals) -> Apart | None:
    """Two groups of what is `left` of each repeat, [repeats, signals, rows]; None where they are one."""
    for place, signal in enumerate(beside.signals):
        if signal in _NOT_SENSED:
            continue
        between = np.sqrt(np.mean((left[:, None, place] - left[None, :, place]) ** 2, axis=2) / 2.0)
        found = two_groups(between, _NOISE)
        if found is not None:
            return Apart(found[0], signal, found[1])
    return None


def checked_states(beside: Compared, bases: Sequence[MachineFit]) -> str:
    """Raises InputError where the healthy repeats are of two states. Two alone that differ in a signal may be of a machine that repeats no better: that is said, in words, and left to the verdict."""
    groups = two_states(beside, bases)
    if groups is None:
        return ""
    text = _said(beside, groups)
    if len(beside.repeats) > 2 or groups.what not in beside.signals:
        raise InputError(text)
    return f"{text}; a third healthy record would tell"


def state_doubt(evidence: Evidence, healthy: Sequence[Record]) -> str:
    """Why two healthy records, behind the evidence, may not both be healthy, in words. Raises InputError where more of them are of two states: one that is not healthy would be taken for scatter."""
    if "position_mm" not in evidence.channels or len(healthy) < 2:
        return ""
    beside = Compared(evidence, tuple(healthy), evidence.channels)
    return checked_states(beside, each(lambda machine: machine.base({}), beside.known_repeats))


def _said(beside: Compared, groups: Apart) -> str:
    few = ", ".join(beside.repeats[place].file for place in groups.places)
    rest = ", ".join(one.file for place, one in enumerate(beside.repeats) if place not in groups.places)
    if groups.what in beside.signals:
        what = (
            f"{groups.what} differs from theirs by {groups.by:.1f} times its noise, which friction, play, grease and winding do not explain"
        )
    else:
        what = f"{row_of(groups.what).field} differs from theirs by {100.0 * groups.by:.0f} %, which is no scatter of one machine"
    return (
        f"{few}: not of the same state as {rest}: {what}: leave out what is not healthy, or calibrate on one of them and diagnose the other"
    )


def _left(machine: KnownMachine, base: MachineFit, days: Reals | None = None) -> Reals:
    """What the known machine leaves of a repeat, in the noise of each signal, [signals, rows]; without what `days` [k, signals, rows] make of it."""
    target = machine.evidence.target
    # of a signal in coarse counts most differences are none: then their rms tells
    rough = [float(np.std(np.diff(signal, 4))) / math.sqrt(70.0) for signal in target]
    left = target - machine.signals(base.values)
    noise = np.maximum(
        np.maximum([white_noise(signal) for signal in target], rough), np.maximum(least_noise(target), _coloured(machine, left))
    )
    return np.asarray((left if days is None else without_days(left, days, noise)) / noise[:, None])


def _coloured(machine: KnownMachine, left: Reals) -> Reals:
    """Noise, rms, of which a sensor's filter leaves more at low frequencies, by what is `left` above those of the motion, [signals]."""
    record = machine.evidence.record
    asked = np.cumsum(np.abs(spectrum(np.gradient(record.command_mm))) ** 2)
    power = np.abs(spectrum(left)) ** 2
    first = int(_HARMONICS * np.searchsorted(asked, _ASKED * asked[-1])) + 1
    if 2 * first >= power.shape[1]:
        return np.zeros(len(left))
    below = first * np.mean(power[:, first : 2 * first], axis=1)
    return np.asarray(np.sqrt((below + np.sum(power[:, first:], axis=1)) * 2.0 / counted(left.shape[1])))
