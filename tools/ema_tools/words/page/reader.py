"""Fields of a result file, with errors that name file and field."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.errors import InputError

Series: TypeAlias = NDArray[np.float64]


class Reader:
    """Fields of a JSON object, with errors that name file and field."""

    def __init__(self, data: dict[str, Any], source: str, prefix: str = "") -> None:
        self.data = data
        self.source = source
        self.prefix = prefix

    def fail(self, key: str, problem: str) -> InputError:
        return InputError(f"{self.source}: field {self.prefix}{key} {problem}: write the result again with --json")

    def table(self, key: str) -> Reader:
        value = self.data.get(key)
        if not isinstance(value, dict):
            raise self.fail(key, "is missing" if value is None else "is not an object")
        return Reader(value, self.source, f"{self.prefix}{key}.")

    def number(self, key: str) -> float:
        value = self.data.get(key)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.fail(key, "is missing" if value is None else "is not a number")
        if not math.isfinite(value):
            raise self.fail(key, "is not finite")
        return float(value)

    def text(self, key: str, default: str) -> str:
        value = self.data.get(key, default)
        if not isinstance(value, str):
            raise self.fail(key, "is not a text")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        value = self.data.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            raise self.fail(key, "is not a list of texts")
        return tuple(value)

    def series(self, key: str) -> Series:
        value = self.data.get(key)
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError):
            raise self.fail(key, "is not a list of numbers") from None
        if array.ndim != 1 or array.size == 0:
            raise self.fail(key, "is not a list of numbers")
        if not np.all(np.isfinite(array)):
            raise self.fail(key, f"is not finite at row {int(np.argmin(np.isfinite(array))) + 1}")
        return array

    def optional(self, key: str) -> float | None:
        """A number, None where it is absent or null."""
        return None if self.data.get(key) is None else self.number(key)

    def tables(self, key: str) -> Iterator[Reader]:
        """The objects of a list; none where it is absent."""
        value = self.data.get(key) or []
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.fail(key, "is not a list of objects")
        for place, item in enumerate(value):
            yield Reader(item, self.source, f"{self.prefix}{key}[{place}].")
