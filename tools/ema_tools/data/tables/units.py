"""Units of foreign files, by Pint: an angle is a dimension of its own, so that a speed in turns is never taken for a frequency; encoder counts and shares of a nominal value are units too."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError

# Units by the suffix of a name, as Pint writes them.
SUFFIXES: Mapping[str, str] = {
    "mm_s": "mm/s",
    "rad_s": "rad/s",
    "mm": "mm",
    "rad": "rad",
    "Nm": "Nm",
    "C": "degC",
    "s": "s",
    "A": "A",
    "N": "N",
    "V": "V",
}
# What files write, as Pint reads it. Whole units only, whatever case they have.
_SPELLINGS: Mapping[str, str] = {
    "1/min": "rpm",
    "min-1": "rpm",
    "min^-1": "rpm",
    "min⁻¹": "rpm",
    "r/min": "rpm",
    "rev/min": "rpm",
    "u/min": "rpm",
    "upm": "rpm",
    "rads": "rad/s",
    "radps": "rad/s",
    "degps": "deg/s",
    "mmps": "mm/s",
    "rpm": "rpm",
    "rps": "rev/s",
    "°c": "degC",
    "degc": "degC",
    "deg c": "degC",
    "ºc": "degC",
    "°f": "degF",
    "ºf": "degF",
    "degf": "degF",
    "deg f": "degF",
    "sec": "s",
    "secs": "s",
    "seconds": "s",
    "msec": "ms",
    "usec": "us",
    "arms": "A",
    "a rms": "A",
    "a_rms": "A",
    "aeff": "A",
    "amp": "A",
    "amps": "A",
    "volts": "V",
    "ohm": "ohm",
    "ohms": "ohm",
    "nm": "Nm",
    "n.m": "Nm",
    "n-m": "Nm",
    "n·m": "Nm",
    "n*m": "Nm",
    "ncm": "Ncm",
    "n.cm": "Ncm",
    "nmm": "N mm",
    "oz-in": "ozin",
    "oz in": "ozin",
    "in-lb": "lbf in",
    "lb-in": "lbf in",
    "lbf-in": "lbf in",
    "in-lbf": "lbf in",
    "ft-lb": "lbf ft",
    "lb-ft": "lbf ft",
    "lbs": "lbf",
    "gcm2": "g cm^2",
    "gcm²": "g cm^2",
    "kgm2": "kg m^2",
    "kgm²": "kg m^2",
    "kg-m2": "kg m^2",
}
# No record holds a charge or a capacity.
_TEMPERATURES: Mapping[str, str] = {"C": "degC", "F": "degF"}
# Among these spellings some mean another thing in their own case: nanometres and tonnes.
_CASE_MATTERS = frozenset({"nm", "nmm"})
SHARES: Mapping[str, float] = {
    "%": 0.01,
    "percent": 0.01,
    "pct": 0.01,
    "prozent": 0.01,
    "‰": 0.001,
    "permille": 0.001,
    "0.1 %": 0.001,
    "0.1%": 0.001,
    "1/1000": 0.001,
}
RMS = frozenset({"arms", "a rms", "a_rms", "aeff"})
COUNTS = ("counts", "count", "cnt", "cts", "inc", "incs", "increments", "ink", "inkr", "inkremente", "qc", "pulses", "ticks")
# What may be recorded as an angle or a speed of rotation behind the gear, which the lead makes a way of; the motor's own have columns for it.
_BEHIND_GEAR: Mapping[str, str] = {"position_mm": "rad", "command_mm": "rad", "speed_mm_s": "rad_s"}
# Nominal values that a share may be of, by the suffix of the column's name.
NOMINAL: Mapping[str, str] = {
    "Nm": "nominal_torque",
    "A": "nominal_current",
    "N": "nominal_force",
    "rad_s": "nominal_speed",
    "V": "nominal_voltage",
}
KINDS: Mapping[str, str] = {
    "mm": "a length",
    "mm_s": "a speed along a line",
    "rad": "an angle",
    "rad_s": "a speed of rotation",
    "Nm": "a torque",
    "N": "a force",
    "A": "a current",
    "V": "a voltage",
    "s": "a time",
    "C": "a temperature",
}
EXAMPLES: Mapping[str, str] = {
    "mm": '"mm", "m", "um", "inch"',
    "mm_s": '"mm/s", "m/s", "inch/s", "mm/min"',
    "rad": '"rad", "deg", "turn", "counts"',
    "rad_s": '"rad/s", "rpm", "deg/s", "turn/s", "counts/s"',
    "Nm": '"Nm", "mNm", "Ncm", "ozin", "lbf in", "%" of [machine] nominal_torque',
    "N": '"N", "kN", "lbf", "kip", "%" of [machine] nominal_force',
    "A": '"A", "mA", "%" of [machine] nominal_current',
    "V": '"V", "mV", "%" of [machine] nominal_voltage',
    "s": '"s", "ms", "us", "min", "datetime" for dates or times of day',
    "C": '"degC", "degF", "K"',
}


def suffix_of(name: str) -> str:
    """The suffix of a column's name that states its unit."""
    return next(suffix for suffix in sorted(SUFFIXES, key=len, reverse=True) if name.endswith("_" + suffix))


def plain_unit(text: str) -> str:
    """A unit as Pint reads it, from what files write: brackets off, other spellings replaced."""
    bare = text.strip().strip("[](){}").strip()
    key = bare.lower()
    if bare in _TEMPERATURES:
        return _TEMPERATURES[bare]
    if bare != key and key in _CASE_MATTERS and not bare.startswith("N"):
        return bare
    if key in _SPELLINGS and not (key in _CASE_MATTERS and not bare.startswith("N")):
        return _SPELLINGS[key]
    for name in COUNTS:
        bare = re.sub(rf"(?<![\w]){name}(?![\w])", "encoder_count", bare, flags=re.IGNORECASE)
    # German, Dutch and Swedish for degree: the 400 of a turn are written gon
    bare = re.sub(r"(?<!\w)grade?(?!\w)", "deg", bare, flags=re.IGNORECASE)
    return bare.replace("U/min", "rpm").replace("²", "^2").replace("³", "^3").replace("·", "*").replace("µ", "u").replace("μ", "u")


@cache
def _registry(counts_per_turn: float) -> Any:
    """Pint's units with those of machines, for an encoder of so many counts per turn (0 where not known)."""
    import pint

    logging.getLogger("pint").setLevel(logging.ERROR)  # it tells of every name that is given a new meaning
    # Empty at first: a registry works out dimensions when it is made, and would keep that an angle has none.
    registry = pint.UnitRegistry(None, autoconvert_offset_to_baseunit=True, on_redefinition="ignore")
    registry.load_definitions(str(resources.files("pint") / "default_en.txt"))
    for meaning in (
        "radian = [angle] = rad",
        "rev = turn",
        "newton_metre = newton * meter = Nm",
        "newton_centimetre = newton * centimeter = Ncm",
        "ounce_force_inch = ounce_force * inch = ozin",
        f"encoder_count = turn / {counts_per_turn or 1.0!r}",
    ):
        registry.define(meaning)
    return registry


@dataclass(frozen=True)
class Units:
    """Pint with what one machine defines: its encoder's counts per turn, its travel per turn of the screw (0 where not known) and its nominal values in their SI unit, by name."""

    counts_per_turn: float = 0.0
    nominal: Mapping[str, float] = field(default_factory=dict)
    lead_mm: float = 0.0

    @property
    def _registry(self) -> Any:
        return _registry(self.counts_per_turn)

    def _parsed(self, text: str) -> Any:
        """A unit, which may have a factor before it, as a quantity; None for what is none."""
        try:
            found = self._registry.parse_expression(plain_unit(text))
        except Exception:  # Pint raises what its tokeniser, its parser and its arithmetic raise
            return None
        return found if hasattr(found, "units") else None

    def is_unit(self, text: str) -> bool:
        """Whether a text is a unit of anything that a record holds."""
        key = text.strip().strip("[](){}").strip().lower()
        return bool(key) and (key in SHARES or any(self.fits(text, suffix) for suffix in SUFFIXES))

    def fits(self, text: str, suffix: str) -> bool:
        """Whether a unit is of the dimension that a suffix states; a share is of no dimension."""
        found = self._parsed(text) if text.strip() else None
        return found is not None and found.dimensionality == self._registry.parse_units(SUFFIXES[suffix]).dimensionality

    def suffix(self, text: str) -> str:
        """The suffix of the dimension that a unit has; empty when no record holds such a thing."""
        return next((suffix for suffix in SUFFIXES if self.fits(text, suffix)), "")

    def converted(self, values: Reals, text: str, name: str, where: str) -> Reals:
        """`values` [rows] in the unit `text` as the column `name` wants them. Raises InputError that begins with `where` and says what to write."""
        suffix = suffix_of(name)
        share = SHARES.get(text.strip().lower())
        if share is not None:
            entry = NOMINAL.get(suffix)
            if entry is None:
                raise InputError(
                    f'{where}unit = "{text}": {name} is {KINDS[suffix]}, of which no share is known: use one of {EXAMPLES[suffix]}'
                )
            if entry not in self.nominal:
                raise InputError(
                    f'{where}unit = "{text}": a share of what is not stated: write {entry} = "..." with its unit in [machine], from the drive\'s or motor\'s data'
                )
            return values * (share * self.nominal[entry])
        found = self._parsed(text)
        if found is None:
            raise InputError(f'{where}unit = "{text}": no unit that is known: use one of {EXAMPLES[suffix]}')
        turning = _BEHIND_GEAR.get(name)
        if turning is not None and self.fits(text, turning):
            if not self.lead_mm:
                raise InputError(
                    f'{where}unit = "{text}": is the unit of {KINDS[turning]}: behind a gear it is {name} by the lead: write ratio and lead in [machine],'
                    ' lead = "360 mm" where nothing moves along a line, which makes a millimetre of every degree; of the motor it is a column of its own'
                )
            per_turn = float(self._parsed(text).to(SUFFIXES[turning]).magnitude) / (2.0 * math.pi)
            return np.asarray(values * (per_turn * self.lead_mm))
        if not self.fits(text, suffix):
            other = self.suffix(text)
            is_one = f"is the unit of {KINDS[other]}" if other else "is the unit of another thing"
            raise InputError(
                f'{where}unit = "{text}": {is_one}, {name} is {KINDS[suffix]}: use one of {EXAMPLES[suffix]}, or name the column by what it is'
            )
        if "encoder_count" in str(found.units) and not self.counts_per_turn:
            raise InputError(
                f'{where}unit = "{text}": how many counts make a turn is not stated: write counts_per_turn = 4096 (four times the lines of the encoder) in [machine]'
            )
        if suffix == "C":
            return np.asarray(self._registry.Quantity(values, found.units).to("degC").magnitude, dtype=np.float64)
        return np.asarray(values * found.to(SUFFIXES[suffix]).magnitude, dtype=np.float64)

    def _number(self, text: str, unit: str) -> float | None:
        """A number with its unit in `unit`; None where it is none, or of another dimension."""
        matched = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(\S.*?)\s*", text)
        found = self._parsed(matched[2]) if matched else None
        wanted = self._registry.parse_units(unit)
        if matched is None or found is None or found.dimensionality != wanted.dimensionality:
            return None
        return float(matched[1]) * float(found.to(wanted).magnitude)

    def number_fits(self, text: str, unit: str) -> bool:
        """Whether a text is a number with a unit of the dimension of `unit`."""
        return self._number(text, unit) is not None

    def value(self, text: str, unit: str, where: str, examples: str) -> float:
        """A number with its unit, such as "9.84 mNm", in `unit`. Raises InputError that begins with `where` and gives the examples, in quotes."""
        found = self._number(text, unit)
        if found is None:
            raise InputError(f'{where} = "{text}": not a number with a unit that fits: write for example {examples}')
        return found
