"""Numbers and sentences of the page and of the demo, in one place so that both say the same."""

from __future__ import annotations

import math

from ema_tools.words.sentences.sizes import ends_text

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


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


def interval(low: float, high: float) -> str:
    """An interval with two digits of its width, e.g. `0.297 … 0.303`."""
    return ends_text(low, high).replace("-", "−").replace("..", "…")


def signed(value: float, digits: int = 2) -> str:
    """`value` with its sign and `digits` significant digits."""
    text = number(abs(value), digits)
    return ("−" if value < 0.0 else "+") + text if text != "0" else text
