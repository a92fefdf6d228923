"""Numbers and sentences of the page and of the demo, in one place so that both say the same."""

from __future__ import annotations

import math

from ema_tools.plant.native import REASONS
from ema_tools.words.sentences.sizes import ends_text

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# What to do about a reason for an undecided verdict, by the module's bit.
_ADVICE = {
    1: "Let the session run to its end before reading its verdict.",
    2: "Run `ema compare` on this record: it says in which block, at which frequency and speed the error sits.",
    4: "Widen the bounds in the [search] table and run again.",
    8: "Raise evaluation_budget in the [search] table and run again.",
    16: "Record more chirps: four halve the standard error.",
    32: "Record the reference chirp instead of this command.",
    64: "Calibrate the healthy values again, on a record of this very actuator.",
    128: "Use the command that the table was learned from, or learn it from records that reach as far as this one.",
    256: "Run `ema diagnose` on this record with healthy ones: it says how sure the name is, and what stands beside it.",
    512: "Run the ground test that the table was exported for, or export one for this command.",
    1024: "Run the ground test again, without a sample missed.",
}


def number(value: float, digits: int = 3) -> str:
    """`value` with `digits` significant digits; powers of ten where zeros would have to be counted."""
    if not math.isfinite(value):
        return "not finite"
    if value == 0.0:
        return "0"
    # Round first: 0.0009996 is 0.001 in three digits.
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1])
    if -3 <= exponent < 6:
        text = f"{value:.{max(digits - 1 - exponent, 0)}f}"
        return text.replace("-", "−")
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    return f"{mantissa}×10{str(int(power)).translate(_SUPERSCRIPT)}".replace("-", "−")


def shift(percent: float, digits: int = 1) -> str:
    """A shift in % with its sign, e.g. `+117.4 %`."""
    text = f"{percent:+.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", "−") + " %"


def reduction(before: float, after: float) -> str:
    """Change from `before` to `after` in %, with at most four digits after the point, e.g. `−99.9998 %`."""
    if before <= 0.0:
        return "no error to reduce"
    left = after / before
    if after == 0.0:
        return "−100 %"
    if left >= 1.0:
        return shift(100.0 * (left - 1.0))
    digits = 1 if left > 0.01 else min(4, 1 - int(f"{100.0 * left:.0e}".split("e")[1]))
    # Truncated, so that it never claims a nine too many.
    scale = 10.0**digits
    return f"−{math.floor(100.0 * (1.0 - left) * scale) / scale:.{digits}f} %"


def duration(seconds: float) -> str:
    """A time span, e.g. `0.09 s`, `75 s`."""
    return f"{number(seconds, 2)} s"


def advice(reason: str) -> str:
    """What to do about one of the module's reasons; empty when nothing is known."""
    return next((text for bit, text in _ADVICE.items() if REASONS[bit] == reason), "")


def interval(low: float, high: float) -> str:
    """An interval with two digits of its width, e.g. `0.297 … 0.303`."""
    return ends_text(low, high).replace("-", "−").replace("..", "…")


def signed(value: float, digits: int = 2) -> str:
    """`value` with its sign and `digits` significant digits."""
    text = number(abs(value), digits)
    return ("−" if value < 0.0 else "+") + text if text != "0" else text
