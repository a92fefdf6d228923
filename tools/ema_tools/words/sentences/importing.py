"""What an import did to a file, in words."""

from __future__ import annotations

from collections.abc import Mapping

from ema_tools.data.motion_signals import Origin
from ema_tools.data.tables.rate import RemarkKind, TableRemark

# Each with the names of the remark's numbers, `row` and `column`.
_SAID: Mapping[RemarkKind, str] = {
    "rounded": "the stamps of time are rounded: put on an even rate of {period_s:g} s",
    "repeated": "row {row} is the first of {count:g} with the time of the row before: left out",
    "filled": "{count:g} rows are missing: filled by straight lines",
    "empty": "{count:g} of {column}'s cells hold no number, the first in row {row}: filled by straight lines",
    "resampled": "time is uneven, steps of {shortest_s:.3g} to {longest_s:.3g} s: resampled to {period_s:g} s by straight lines",
    "rates": "the columns have rates of their own: all are brought to that of {column}, {period_s:g} s, by straight lines",
    "gap": "nothing is recorded for {length_s:.3g} s before row {row}: cut there",
    "restart": "time begins again in row {row}: cut there",
    "short": "from row {row} on only {count:g} rows belong together, too few for a record: left out",
    "unwrapped": "{column} starts again {count:g} times, as a counter of one turn or of so many bits does: counted on",
    "cut_row": "row {row} ends in the middle: left out",
    "footer": "below the last whole row of numbers stands {count:g} more, of text or cut off: left out",
    "rms": "{column} is recorded as an effective value: taken as it is, so a torque constant must be per effective ampere",
    "one_way": "the machine moves one way only and {column} holds it back: right for a load that is lowered; otherwise write sign = -1 in [columns.{column}]",
    "agree": "{column} and {other} agree to {percent:.2g} %",
    "apart": "{column} moves {times:.3g} times as far as {other} says: they should be one, so look at counts, unit, lead or ratio of the two",
    "travel": "{column} moves {lead_mm:.4g} mm in one turn of {other}: state lead and ratio in [machine] that make it so, lead over ratio is the travel per turn of the motor",
    "inertia": "{column} speeds up {times:.3g} times the inertia of [machine]: a load that was not counted, or counts per turn, lead, torque constant or nominal value are off by so much;"
    " ema diagnose fits it, with its interval",
    "assumed": "no unit is named in the file for {column}: taken so because {other} says so",
    "held": "{column} is {value:g} in all rows, and no other drive is recorded: doubtful, a supply's voltage is not the motor's: check from in [columns.{column}], and name the motor's voltage,"
    " its current or its duty cycle",
    "frictionless": "the records show no friction at all, neither dry nor viscous: {column} is doubtful as the drive of this motion: check from, unit and sign in [columns.{column}],"
    " and that it is the motor's actual value, of the same run as the motion",
    "setpoint": '"{other}" is what is asked for, by its name, and stands for {column}: right only where the drive follows it closely, so name the actual value'
    " in [columns.{column}], or write sure = true there",
    "others": "{other} holds {count:g} more records, of earlier imports or other files: whoever reads the folder reads them too, so delete what is not of this machine",
    "copy": "the same samples came as {column}, too: one of the two is enough, and a diagnosis refuses both together",
}
_MADE: Mapping[Origin, str] = {
    "recorded": "recorded",
    "converted": "from {column}",
    "integrated": "{column} integrated where it is needed: from zero at the first row, and it drifts with an error of the speed",
    "differentiated": "{column} differentiated where it is needed",
}


def remark_text(remark: TableRemark) -> str:
    """One remark about a file."""
    return _SAID[remark.kind].format(row=remark.row, column=remark.column, other=remark.other, **(remark.numbers or {}))


def origin_text(origin: Origin, column: str) -> str:
    """Of what a signal is made."""
    return _MADE[origin].format(column=column)
