"""What is said of a sensor whose own error the unknown looks like."""

from __future__ import annotations

from ema_tools.compare.comparison import TITLES, UNITS
from ema_tools.compare.readings import ReadingError
from ema_tools.library.display_names import listed
from ema_tools.select.sensors import CLOCK, VOLTAGE, Suspect
from ema_tools.words.sentences.sizes import significant

# What may be behind a signal that alone reads otherwise.
_BEHIND = {
    "position_mm": "the rod's sensor, its mounting, or what lies between motor and rod",
    "motor_position_mm": "the motor's encoder",
    "current_A": "the current sensor",
    "voltage_V": "how the voltage is recorded",
}

# What a voltage may be that contradicts the other signals.
_ASKED = "; or voltage_V is measured at the motor, where what the controller asks for is meant"

# How often a wave comes, by its periods per motor turn.
_TIMES = {1: "once", 2: "twice"}


def reading_words(found: ReadingError) -> str:
    """What a signal does, as in `reads 2 ms late`."""
    if found.kind == "wave":
        return f"has an error that repeats {_TIMES[found.periods]} per motor turn ({significant(found.size, 2)} {UNITS[found.channel]})"
    if found.kind == "scale":
        return f"reads {1.0 + found.size:.4g} times the signal"
    if found.kind == "delay":
        return f"reads {1e3 * abs(found.size):.2g} ms {'late' if found.size > 0.0 else 'early'}"
    return f"reads {abs(found.size):.2g} {UNITS[found.channel]} too {'high' if found.size > 0.0 else 'low'}"


def is_outside_mechanics(found: ReadingError) -> bool:
    """Whether the error of a reading can be none of the machine: it shows in several balances, as one block of the machine does not."""
    return len(found.balances) > 1


def reading_sentence(found: ReadingError) -> str:
    """The pattern of a reading's error first, then what it says of the blocks; without a stop at its end."""
    text = f"The {TITLES[found.channel]} {reading_words(found)}, which explains {100.0 * found.share:.0f} % of the excess"
    if is_outside_mechanics(found):
        return f"{text}: the error shows alike in the {listed(list(found.balances))} balances, which weigh this signal, so its sensor is at fault and not the machine"
    return f"{text}: {_BEHIND[found.channel]} may be at fault"


def sensor_sentence(found: Suspect) -> str:
    """What the sensor reads that the unknown looks like."""
    if found.channel == CLOCK:
        return (
            f"what is there looks like rows that are not evenly spaced in time: every row is early or late by {1e3 * found.late_s:.2g} ms rms, the same in all signals "
            f"({100.0 * found.share:.0f} % of the excess)"
        )
    if not found.has_form:
        return (
            f"what is there shows in the {TITLES[found.channel]} ({found.channel}) alone: without it the other signals are as they should be, "
            f"so it is {_BEHIND[found.channel]}"
        )
    parts = []
    if found.factor != 1.0:
        parts.append(f"{found.factor:.3g} times the signal")
    if found.offset != 0.0:
        parts.append(f"{found.offset:+.3g} {UNITS[found.channel]} beside it")
    if found.late_s != 0.0:
        parts.append(f"{1e3 * abs(found.late_s):.2g} ms {'late' if found.late_s > 0.0 else 'early'}")
    return (
        f"what is there looks like the sensor of the {TITLES[found.channel]} ({found.channel}), not like the machine: it reads {' and '.join(parts)} "
        f"({100.0 * found.share:.0f} % of the excess), which no value of the machine explains{_ASKED if found.channel == VOLTAGE else ''}"
    )


def sensor_next(found: Suspect) -> str:
    """What to do about it."""
    if found.channel == CLOCK:
        return "record with a clock of the drive's own, or with the times at which the rows were really taken"
    how = "scale, zero, delay" if found.has_form else "does it stick, saturate, slip or jump?"
    return f"check the sensor of the {TITLES[found.channel]} ({how}) and record again"
