"""What the page calls things: an effect by its display name with its code name beside it, signals and balances in plain words, values with the digits that their interval allows."""

from __future__ import annotations

import math
from html import escape

from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import row_of
from ema_tools.library.display_names import FAULT_TITLES as FAULT_TITLES
from ema_tools.library.display_names import display as display
from ema_tools.library.display_names import listed as listed
from ema_tools.library.display_names import within as within
from ema_tools.words.page import text as words

# The column that is suspected where the recorder's clock is.
_CLOCK = "time_s"
# block -> title, what its equation weighs
BLOCKS = {
    "mechanical": ("Mechanics", "motor torque against friction, inertia and load"),
    "electrical": ("Motor circuit", "voltage against resistance, inductance and back-EMF"),
    "kinematic": ("Transmission", "rod position against motor position"),
    "controller": ("Controller", "applied voltage against the control law"),
}
# channel -> title, unit, unit of the residual, residual units in one unit
SIGNALS = {
    "position_mm": ("Rod position", "mm", "µm", 1000.0),
    "current_A": ("Motor current", "A", "A", 1.0),
    "motor_position_mm": ("Motor position, at the rod", "mm", "µm", 1000.0),
    "voltage_V": ("Motor voltage", "V", "V", 1.0),
    "speed_mm_s": ("Rod speed", "mm/s", "mm/s", 1.0),
}


def titled(name: str) -> str:
    """Markup of the display name of an effect, its code name small behind it."""
    return f"{escape(display(name))} <code>{escape(name)}</code>"


def block(name: str) -> str:
    """Title of a balance."""
    return BLOCKS[name][0] if name in BLOCKS else display(name)


def signal(name: str) -> str:
    """Title of a channel."""
    return SIGNALS[name][0] if name in SIGNALS else name


def suspected(channel: str) -> str:
    """Whose own error is suspected where a channel is."""
    return "recorder's clock" if channel == _CLOCK else f"sensor of the {signal(channel).lower().partition(',')[0]}"


def unit_of(name: str) -> str:
    """Unit of a value by its full name; none for one of an effect that this build does not have."""
    try:
        return row_of(name).unit
    except InputError:
        return ""


def sized(value: float, std: float | None, unit: str = "") -> str:
    """A value with what its 95 % interval leaves open, as in `0.299 ± 0.004 Nm`: no finer digits than the interval has."""
    low, high = interval_of(value, std)
    tail = f" {unit}" if unit else ""
    if low is None or high is None or not high > low:
        return f"{words.number(value)}{tail}"
    half = 0.5 * (high - low)
    decimals = -math.floor(math.log10(half))
    if not 0 <= decimals <= 6:
        return f"{words.number(value)} ± {words.number(half, 1)}{tail}"
    return f"{value:.{decimals}f} ± {half:.{decimals}f}{tail}".replace("-", "−")


def changed(percent: float, half: float | None = None) -> str:
    """A change in %, rounded to what its interval's half width allows, as in `+40 %`."""
    digits = 0 if half is None or half >= 0.05 or abs(percent) >= 10.0 else 1
    return words.shift(percent, digits)
