"""Whether the recorded voltage is what the controller asks for, as the model has it, or what is left of it at the motor's terminals, behind a bridge that drops some of it.

The controller's output follows from the recorded command and feedback alone, whatever the plant does. What the recorded voltage lacks of it may be a factor, a constant, a lag, and what follows
the position; what has the sign of the current is lost in a bridge.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ema_tools.balances.controller import controller_output, feedback_of
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record

_STRETCHES = 5  # of the record, each asked for itself: what they agree on is no chance [judgement]
_SURE = 6.0  # standard errors by which they must agree: Student's distribution of five values has long tails [chance]
_LEAST = 1e-3  # of the voltage: less does not matter, since no signal is trusted beyond that [precision]
_BEND = 0.1  # of the current, over which a bridge's drop turns its sign [physics]


def drop_V(actuator: Actuator, records: Sequence[Record]) -> float:
    """What records of one command lose of the asked voltage on its way to where it was recorded, with the sign of the current; 0 where nothing is lost, or where the records do not tell."""
    try:
        lost, terms = zip(*(_lost(actuator, record) for record in records), strict=True)
    except MissingSignal:
        return 0.0
    mean, columns = np.mean(lost, axis=0), np.mean(terms, axis=0)
    parts = zip(np.array_split(mean, _STRETCHES), np.array_split(columns, _STRETCHES), strict=True)
    found = np.array([np.linalg.lstsq(one, part, rcond=None)[0][-1] for part, one in parts])
    error = float(np.std(found, ddof=1)) / np.sqrt(_STRETCHES)
    drop = float(found.mean())
    least = max(_SURE * error, _LEAST * float(np.sqrt(np.mean(columns[:, 1] ** 2))))
    return drop if drop > least and bool(np.all(found > 0.0)) else 0.0


def _lost(actuator: Actuator, record: Record) -> tuple[Reals, Reals]:
    """What is recorded less than asked, [rows], and what may explain it, [rows, terms], last the sign of the current. Raises MissingSignal."""
    if record.voltage_V is None or record.current_A is None or actuator["drive.mode"] == 1.0:
        raise MissingSignal("voltage_V or current_A is not recorded, or the drive holds the current")
    feedback = feedback_of(actuator, record)
    asked = actuator["drive.supply_V"] * controller_output(actuator, record.command_mm, feedback)
    current = record.current_A
    width = _BEND * max(float(np.sqrt(np.mean(current**2))), 1e-9)
    terms = (np.ones_like(asked), asked, np.gradient(asked), feedback, current, np.tanh(current / width))
    return asked - record.voltage_V, np.column_stack(terms)
