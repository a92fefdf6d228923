"""The module's own trend and time to a limit, as firmware has it, through the same libraries as `ema_tools.plant.native`."""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int32
from dataclasses import dataclass
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.library.definitions import library_function, library_path, open_library

LAWS = 2104  # of one forecast, as EMA_FORECAST_LAWS [layout]


class _Outlook(ctypes.Structure):
    _fields_ = [
        ("odds_log", c_double),
        ("now_percent", c_double),
        ("now_std_percent", c_double),
        ("by_percent", c_double),
        ("rate_percent_per_day", c_double),
        ("rate_std_percent_per_day", c_double),
        ("low_days", c_double),
        ("median_days", c_double),
        ("high_days", c_double),
        ("reached_ratio", c_double),
        ("ahead_days", c_double),
        ("drifts", c_int32),
        ("towards", c_int32),
    ]


@dataclass(frozen=True)
class OnboardOutlook:
    """What the module says after a reading; times from it in days, infinite where open."""

    odds_log: float
    now_percent: float
    now_std_percent: float
    by_percent: float
    rate_percent_per_day: float
    rate_std_percent_per_day: float
    low_days: float
    median_days: float
    high_days: float
    reached_ratio: float
    ahead_days: float
    drifts: bool
    towards: bool


@functools.cache
def _library(bits: int) -> Any:
    library = open_library(library_path(bits))
    library_function(library, "ema_desk_trend")
    real, whole = POINTER(c_double), POINTER(c_int32)
    library.ema_desk_trend.argtypes = [
        real, real, real, c_int32, c_double, c_double, whole, c_int32, c_int32, c_int32, POINTER(_Outlook), whole,
    ]  # fmt: skip
    library.ema_desk_trend.restype = c_int32
    library.ema_desk_trend_text.argtypes = [c_int32]
    library.ema_desk_trend_text.restype = c_char_p
    return library


def onboard_outlooks(
    days: Reals,
    values: Reals,
    stds: Reals,
    limit: float,
    looks: Sequence[int],
    false_alarm: float = 0.01,
    bits: int = 32,
    slice_laws: int = LAWS,
    saving: bool = False,
) -> list[OnboardOutlook]:
    """What firmware says of readings in %, after so many of them as each of `looks` in rising order says; `saving`: put into bytes and restored after each. Raises InputError naming the reading."""
    library = _library(bits)
    columns = [np.ascontiguousarray(one, dtype=np.float64) for one in (days, values, stds)]
    if len({one.shape for one in columns}) != 1 or columns[0].ndim != 1:
        raise ValueError("days, values and stds: give one number per reading")
    raw, bad = (_Outlook * max(1, len(looks)))(), c_int32(-1)
    real = POINTER(c_double)
    status = library.ema_desk_trend(
        *(one.ctypes.data_as(real) for one in columns),
        columns[0].size,
        limit,
        false_alarm,
        (c_int32 * max(1, len(looks)))(*looks),
        len(looks),
        slice_laws,
        int(saving),
        raw,
        byref(bad),
    )
    if status:
        raise InputError(f"reading {bad.value + 1}: {library.ema_desk_trend_text(status).decode()}")
    return [_outlook(raw[place]) for place in range(len(looks))]


def _outlook(raw: _Outlook) -> OnboardOutlook:
    told = {one[0]: getattr(raw, one[0]) for one in _Outlook._fields_}
    for name in ("low_days", "median_days", "high_days"):
        told[name] = math.inf if told[name] < 0.0 else told[name]
    return OnboardOutlook(**{**told, "drifts": bool(told["drifts"]), "towards": bool(told["towards"])})
