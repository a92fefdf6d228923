"""Many runs at once: the shared libraries `ema_lanes32` and `ema_lanes64` of `port/lanes`, which work on several actuators side by side, and `ema_lanes32_few` with half as many lanes.

Of each there may be a second build for processors with AVX2, which is taken where the processor has it; the bits are the same in all of them, and those of runs
one after the other.
"""

from __future__ import annotations

import functools
import math
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import POINTER, c_double, c_int32, c_int64, c_void_p
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.arrays import Integers, Reals
from ema_tools.base.errors import LibraryError
from ema_tools.library.definitions import load_definitions, named_library, open_library

SIGNALS = 5  # that a run shows: those of the C module's rows [layout]
_LINE_BYTES = 64  # of memory that moves together: a vector that lies across two of them is written in two turns [layout]
_KEPT_BYTES = 64_000_000  # what is larger goes back to the system [effort]


@dataclass(frozen=True)
class Runs:
    """What runs made: `out` [runs, 5, rows] in the library's own precision, of each its `status` and its count of steps with more events than are located, [runs].

    `spans` of the motion went through the lanes, `left` of them through the model's own functions.
    """

    out: NDArray[np.floating[Any]]
    status: NDArray[np.int32]
    unlocated_event_steps: NDArray[np.int32]
    spans: int = field(default=0)
    left: int = field(default=0)


class _KeptMemory:
    """Memory of calls that have ended, for those to come: the system clears what is new first, which takes as long as half of the runs that are written there."""

    def __init__(self) -> None:
        self._free: deque[NDArray[np.uint8]] = deque(maxlen=8)

    @contextmanager
    def lent(self, shape: tuple[int, ...], dtype: type[np.floating[Any]]) -> Iterator[NDArray[Any]]:
        """An array of anything, for the time of the context. From several threads at once."""
        size = math.prod(shape) * np.dtype(dtype).itemsize
        try:
            block = self._free.pop()
        except IndexError:
            block = np.empty(0, dtype=np.uint8)
        if block.size < size + _LINE_BYTES:
            block = np.empty(size + _LINE_BYTES, dtype=np.uint8)
        first = -block.ctypes.data % _LINE_BYTES
        try:
            yield block[first : first + size].view(dtype).reshape(shape)
        finally:
            if block.size <= _KEPT_BYTES:
                self._free.append(block)


class Lanes:
    """One build of one precision. Safe to use from several threads: what calls share is memory that one of them has at a time."""

    def __init__(self, name: str, bits: int) -> None:
        """Load the library called `name`. Raises LibraryError when it cannot be loaded, or was built from other lists."""
        self.path = named_library(name)
        self._lib: Any = open_library(self.path)
        self._memory = _KeptMemory()
        self._real = np.float32 if bits == 32 else np.float64
        real, whole = POINTER(c_double), POINTER(c_int32)
        try:
            self._lib.ema_lanes_simulate.argtypes = [
                real, whole, c_int32, real, c_int32, c_double, c_void_p, whole, whole, POINTER(c_int64),
            ]  # fmt: skip
            built = (self._lib.ema_lanes_bits(), self._lib.ema_lanes_value_count())
            self.count = int(self._lib.ema_lanes_count())
            self.avx2 = bool(self._lib.ema_lanes_avx2())
        except AttributeError as error:
            raise LibraryError(f"{self.path.name}: {error}: build the project again") from None
        if built != (bits, len(load_definitions().reals) + len(load_definitions().effect_values)):
            raise LibraryError(f"{self.path.name}: built for {built[0]} bits and {built[1]} values: build the project again")

    @contextmanager
    def simulated(self, values: Reals, options: Integers, command_mm: Reals, start_mm: float) -> Iterator[Runs]:
        """The runs of actuators `values` [runs, values] with the same options under `command_mm` [rows]; what they show is there for the time of the context alone."""
        runs, rows = len(values), command_mm.size
        status, unlocated = np.zeros(runs, dtype=np.int32), np.zeros(runs, dtype=np.int32)
        left = np.zeros(2, dtype=np.int64)
        whole = POINTER(c_int32)
        with self._memory.lent((runs, SIGNALS, rows), self._real) as out:
            self._lib.ema_lanes_simulate(
                values.ctypes.data_as(POINTER(c_double)),
                options.ctypes.data_as(whole),
                runs,
                command_mm.ctypes.data_as(POINTER(c_double)),
                rows,
                float(start_mm),
                out.ctypes.data_as(c_void_p),
                unlocated.ctypes.data_as(whole),
                status.ctypes.data_as(whole),
                left.ctypes.data_as(POINTER(c_int64)),
            )
            yield Runs(out, status, unlocated, int(left[0]), int(left[1]))


@functools.cache
def _built(name: str, bits: int) -> Lanes | None:
    """The build that fits this processor, loaded once; None where the project was built without."""
    if not named_library(name).is_file():
        return None
    plain = Lanes(name, bits)
    wide = f"{name}_avx2"
    return Lanes(wide, bits) if plain.avx2 and named_library(wide).is_file() else plain


def lanes(bits: int, runs: int) -> Lanes | None:
    """The build for so many runs; None where the project was built without. Raises LibraryError when it is of another build."""
    few = _built("ema_lanes32_few", bits) if bits == 32 else None
    return few if few is not None and runs <= few.count else _built(f"ema_lanes{bits}", bits)
