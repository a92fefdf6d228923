"""What is said of base values that contradict what the actuator's file states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ema_tools.data.actuator import row_of, shown
from ema_tools.data.motion_records import DRIVES, MOTIONS, AnyRecord
from ema_tools.results.diagnosis import BaseEntry
from ema_tools.select.balance_bench import INERTIA
from ema_tools.select.balance_setting import LEVEL
from ema_tools.select.base_values import BaseValue
from ema_tools.words.sentences.machine_units import TURNING, MachineUnits
from ema_tools.words.sentences.sizes import ends_text

# What each column's scale hangs on, the rod's on more than the motor's.
_HANGS_ON: Mapping[str, tuple[str, ...]] = {
    "motor_angle_rad": ("counts per turn or the unit of motor_angle_rad",),
    "motor_speed_rad_s": ("the unit of motor_speed_rad_s, or its counts per turn",),
    "motor_position_mm": ("lead and ratio", "the counts per turn of motor_position_mm"),
    "position_mm": ("lead and ratio", "the unit of position_mm"),
    "speed_mm_s": ("lead and ratio", "the unit of speed_mm_s"),
    "torque_Nm": ("the unit or nominal value of torque_Nm",),
    "current_A": ("the torque constant", "the unit of current_A"),
    "force_N": ("lead and ratio", "the unit or nominal value of force_N"),
}
_TITLES = {INERTIA: "inertia", LEVEL: "dry friction"}  # of what turns; along a line by its units
_SAME = 1.25  # factors within this of each other are one [judgement]


def contradiction(values: Sequence[BaseValue], record: AnyRecord, units: MachineUnits = TURNING) -> str:
    """Where fitted values contradict stated ones, and what to check; empty where none does."""
    odd = [one for one in values if one.contradicts]
    if not odd:
        return ""
    told = " and ".join(f"the {_title(one, units)} fitted is {_times(one)}" for one in odd)
    motion, drive = ([text for name in _first(record, names) for text in _HANGS_ON[name]] for names in (MOTIONS, DRIVES))
    itself = " and ".join(shown(row_of(one.name)) for one in odd)
    one_scale = len(odd) > 1 and max(one.times for one in odd) < _SAME * min(one.times for one in odd)
    if one_scale or odd[0].name == INERTIA:
        why = "one factor on both is one of the drive's scale: " if one_scale else ""
        return f"{told}: {why}check {', '.join(dict.fromkeys(drive if one_scale else [*motion, *drive]))}, or {itself} itself"
    return f"{told}: friction has changed, or {itself} is of another machine"


def _title(one: BaseValue, units: MachineUnits) -> str:
    return _TITLES[one.name] if units.m_per_rad is None else units.title(one.name)


def _times(one: BaseValue) -> str:
    low, high = one.interval95
    doubt = f" (95 %: {ends_text(low / one.stated, high / one.stated)})" if low is not None and high is not None else ""
    return f"{one.times:.3g} times the stated one{doubt}"


def _first(record: AnyRecord, names: Sequence[str]) -> tuple[str, ...]:
    """The column that a balance takes, the motor's own before the rod's."""
    there = [name for name in names if name in record.present]
    return tuple(sorted(there, key=lambda name: ("motor_" not in name) and name in MOTIONS)[:1])


def note(name: str, one: BaseEntry, units: MachineUnits = TURNING) -> str:
    """What must be known of a base value beside its number: that it was not fitted, or that the records hardly show it; else empty."""
    stated, unit = units.told(one.stated, one.unit)
    if one.kept:
        whose = "as stated" if one.stated_from == "file" else "a start by the import, which nobody stated"
        return f"{units.title(name)} stays {stated:.4g} {unit}, {whose}: {one.kept}."
    if one.hardly_seen and one.error_as_stated_percent is not None:
        return f"{units.title(name)}: these records hardly show it, as stated the error is {one.error_as_stated_percent:.3g} %: take the stated value."
    return ""
