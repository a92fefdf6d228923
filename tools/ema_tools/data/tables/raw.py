"""What stands in a file of any maker: columns by the file's own names, before anything is said of their meaning."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ema_tools.base.arrays import Reals

Rows = NDArray[np.int64]


@dataclass(frozen=True)
class RawColumn:
    """One column: its name and unit as the file has them (empty without one), its numbers [rows], NaN where there is none.

    `number`: of the column in the file, from 1; `texts`: what stands in a cell that is neither a number nor empty, by its place from 0.
    """

    name: str
    unit: str
    values: Reals
    number: int
    texts: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Layout:
    """How a file of text was read; empty where nothing had to be found out. `header_rows` are the numbers of the rows of names and of units, `first_row` that of the first numbers."""

    kind: str
    encoding: str = ""
    delimiter: str = ""
    decimal: str = ""
    header_rows: tuple[int, ...] = ()
    first_row: int = 1


@dataclass(frozen=True)
class RawTable:
    """A file's columns of equal length. `rows` [rows]: the number of each row as an editor shows it, from 1; `constants`: single numbers beside the columns, by name.

    `uneven`: arrays of another length than most, which are no columns, and their lengths by name.
    `cut_row`: the last row, where it ends in the middle and was left out; `footer_rows`: rows of text below the numbers, left out.
    """

    file: str
    columns: tuple[RawColumn, ...]
    rows: Rows
    layout: Layout
    constants: Mapping[str, float] = field(default_factory=dict)
    cut_row: int | None = None
    footer_rows: int = 0
    uneven: Mapping[str, int] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns."""
        return tuple(column.name for column in self.columns)
