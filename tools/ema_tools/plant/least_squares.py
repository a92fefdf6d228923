"""The module's search by least squares, up to eight values at once, through the same libraries as `ema_tools.plant.native`."""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Callable
from ctypes import POINTER, c_double, c_int32, c_int64, c_void_p
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from ema_tools.base.arrays import Integers, Reals
from ema_tools.base.errors import InputError
from ema_tools.library.definitions import library_function, library_path, load_definitions, open_library
from ema_tools.plant.native import CHANNELS, OUTCOMES, library

SEARCHED_MAX = 8
# By the record: a value by itself, one that does what others do, one that does too little.
Determined = Literal["yes", "together", "no"]
_DETERMINED: tuple[Determined, ...] = ("yes", "together", "no")


class _Search(ctypes.Structure):
    _fields_ = [
        ("count", c_int32),
        ("id", c_int32 * SEARCHED_MAX),
        ("with_", c_int32 * SEARCHED_MAX),
        ("lower", c_double * SEARCHED_MAX),
        ("upper", c_double * SEARCHED_MAX),
        ("start", c_double * SEARCHED_MAX),
        ("noise", c_double * len(CHANNELS)),
        ("run_budget", c_int32),
        ("restarts", c_int32),
        ("int16_record", c_int32),
        ("slice_steps", c_int32),
    ]


class _Found(ctypes.Structure):
    _fields_ = [
        ("estimate", c_double * SEARCHED_MAX),
        ("std", c_double * SEARCHED_MAX),
        ("bias", c_double * SEARCHED_MAX),
        ("noise_std", c_double * SEARCHED_MAX),
        ("determined", c_int32 * SEARCHED_MAX),
        ("partner", c_int32 * SEARCHED_MAX),
        ("at_bound", c_int32 * SEARCHED_MAX),
        ("misfit_before", c_double),
        ("misfit_after", c_double),
        ("residual_rms_mm", c_double),
        ("residual_correlation", c_double),
        ("model_steps", c_int64),
        ("runs", c_int32),
        ("starts", c_int32),
        ("outcome", c_int32),
        ("crossed", c_int32),
        ("adequate", c_int32),
    ]


_PROGRESS = ctypes.CFUNCTYPE(c_int32, c_int32, c_double, POINTER(c_double), c_void_p)
# Model runs so far, rms of the residual over the noise at the lowest point so far, and the values there, [p].
Progress = Callable[[int, float, Reals], None]


@dataclass(frozen=True)
class Searched:
    """One value by name, its bounds and its start, in its own unit; `companion` moves in the same proportion, as the back-EMF with the torque constant."""

    name: str
    lower: float
    upper: float
    start: float
    companion: str | None = None


@dataclass(frozen=True)
class SquaresSettings:
    """What is searched: 1 to 8 values; `noise` is the rms of the sensors of CHANNELS, 0 where a signal is not compared."""

    searched: tuple[Searched, ...]
    noise: tuple[float, float, float, float]
    run_budget: int = 2500
    restarts: int = 8
    int16_record: bool = False
    slice_steps: int = 1000


@dataclass(frozen=True)
class FoundValue:
    """One value in its own unit. `std`: by the residual's own size, `bias`: for what lasts in it, `noise_std`: by the sensors' noise alone; NaN where the value is not told from
    others. `alike`: the other value that is most like it to the signals, None where there is none."""

    name: str
    estimate: float
    std: float
    bias: float
    noise_std: float
    determined: Determined
    alike: str | None
    at_bound: bool


@dataclass(frozen=True)
class SquaresFound:
    """What the search says; `misfit`: rms of the residual over the noise, at the start and at the lowest point. `crossed`: the rod was pushed both ways."""

    values: tuple[FoundValue, ...]
    misfit_before: float
    misfit_after: float
    residual_rms_mm: float
    residual_correlation: float
    model_steps: int
    runs: int
    starts: int
    outcome: str
    crossed: bool
    adequate: bool


@functools.cache
def _function(bits: int) -> Any:
    function = library_function(open_library(library_path(bits)), "ema_desk_least_squares")
    real, whole = POINTER(c_double), POINTER(c_int32)
    function.argtypes = [real, whole, real, real, c_int32, POINTER(_Search), _PROGRESS, c_void_p, POINTER(_Found), whole]
    function.restype = c_int32
    return function


def _raw(settings: SquaresSettings) -> _Search:
    if not 1 <= len(settings.searched) <= SEARCHED_MAX:
        raise InputError(f"least squares: {len(settings.searched)} values: give one to {SEARCHED_MAX}")
    ids = load_definitions().ids
    raw = _Search(
        count=len(settings.searched),
        run_budget=settings.run_budget,
        restarts=settings.restarts,
        int16_record=settings.int16_record,
        slice_steps=settings.slice_steps,
    )
    raw.noise[:] = settings.noise
    for place, one in enumerate(settings.searched):
        raw.id[place] = ids[one.name]
        raw.with_[place] = ids[one.companion or one.name]
        raw.lower[place], raw.upper[place], raw.start[place] = one.lower, one.upper, one.start
    return raw


def _error(error: float) -> float:
    return math.nan if error < 0.0 else error


def least_squares(
    values: Reals,
    options: Integers,
    command_mm: Reals,
    channels: Reals,
    settings: SquaresSettings,
    bits: int = 32,
    progress: Progress | None = None,
) -> SquaresFound:
    """Search on a record: `command_mm` [rows], `channels` [rows, 4] (CHANNELS, NaN where not recorded). Float32 and what the firmware's record holds give the firmware's bits.

    What `progress` raises ends the search and is raised here. Raises InputError when the module refuses actuator, record or settings.
    """
    command = np.ascontiguousarray(command_mm, dtype=np.float64)
    measured = np.ascontiguousarray(channels, dtype=np.float64)
    if measured.shape != (command.size, len(CHANNELS)):
        raise ValueError(f"channels: shape {measured.shape} where {(command.size, len(CHANNELS))} is needed: give one number per row")
    raised: list[BaseException] = []
    count = len(settings.searched)

    def called(runs: int, misfit: float, lowest: Any, _context: object) -> int:
        if progress is not None:
            try:
                progress(runs, misfit, np.array(lowest[:count]))
            except BaseException as error:  # an exception cannot pass through C
                raised.append(error)
                return 1
        return 0

    raw, found, bad_row = _raw(settings), _Found(), c_int32(-1)
    real = POINTER(c_double)
    status = _function(bits)(
        values.ctypes.data_as(real),
        options.ctypes.data_as(POINTER(c_int32)),
        command.ctypes.data_as(real),
        measured.ctypes.data_as(real),
        command.size,
        ctypes.byref(raw),
        _PROGRESS(called) if progress is not None else _PROGRESS(),
        None,
        ctypes.byref(found),
        ctypes.byref(bad_row),
    )
    if raised:
        raise raised[0]
    module = library(bits)
    if status != 0 and bad_row.value >= 0:
        raise InputError(f"least squares: sample {bad_row.value + 1} of the record: {module.status_text(status)}: correct the record")
    if status != 0:
        module.check(values, options)
        raise InputError(f"least squares: {module.status_text(status)}: correct the actuator, the record or the bounds")
    return SquaresFound(
        tuple(_value(settings, found, place) for place in range(count)),
        found.misfit_before,
        found.misfit_after,
        found.residual_rms_mm,
        found.residual_correlation,
        found.model_steps,
        found.runs,
        found.starts,
        OUTCOMES[found.outcome],
        bool(found.crossed),
        bool(found.adequate),
    )


def _value(settings: SquaresSettings, found: _Found, place: int) -> FoundValue:
    partner = found.partner[place]
    return FoundValue(
        settings.searched[place].name,
        found.estimate[place],
        _error(found.std[place]),
        _error(found.bias[place]),
        _error(found.noise_std[place]),
        cast(Determined, _DETERMINED[found.determined[place]]),
        None if partner == place else settings.searched[partner].name,
        bool(found.at_bound[place]),
    )
