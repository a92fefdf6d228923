"""What is said of a sensor whose own error the unknown looks like."""

from __future__ import annotations

from ema_tools.compare.comparison import TITLES, UNITS
from ema_tools.select.sensors import Suspect


def sensor_sentence(found: Suspect) -> str:
    """What the sensor reads that the unknown looks like."""
    parts = []
    if found.factor != 1.0:
        parts.append(f"{found.factor:.3g} times the signal")
    if found.offset != 0.0:
        parts.append(f"{found.offset:+.3g} {UNITS[found.channel]} beside it")
    if found.late_s != 0.0:
        parts.append(f"{1e3 * abs(found.late_s):.2g} ms {'late' if found.late_s > 0.0 else 'early'}")
    return (
        f"what is there looks like the sensor of the {TITLES[found.channel]}, not like the machine: {found.channel} reads {' and '.join(parts)} "
        f"({100.0 * found.share:.0f} % of the excess), while the other signals are as they should be"
    )


def sensor_next(found: Suspect) -> str:
    """What to do about it."""
    return f"check the sensor of the {TITLES[found.channel]} (scale, zero, delay) and record again"
