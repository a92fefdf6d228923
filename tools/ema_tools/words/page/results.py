"""Reads result files: what the page takes from the JSON of `ema identify` and `ema compare`, checked field by field; those of `ema diagnose` are read next door."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_json
from ema_tools.data.cases import CASES, PaperCase
from ema_tools.words.page.reader import Reader, Series

if TYPE_CHECKING:
    from ema_tools.words.page.diagnosis_results import Diagnosed

FAULTS = ("csj_Nm", "blk_mm")
CHANNELS = ("position_mm", "speed_mm_s", "current_A", "voltage_V")
BALANCES = ("mechanical", "electrical", "kinematic", "controller")

# Rows on each side over which the slope of the position is taken where the speed is not recorded.
SLOPE_ROWS = 4


@dataclass(frozen=True)
class Curves:
    """Measured and simulated channels of one record, each an array of `rows` in the unit of its name.

    `models` holds `before` and `after` (identify) or `model` (compare).
    """

    start_s: float
    period_s: float
    measured: dict[str, Series]
    models: dict[str, dict[str, Series]]
    derived: frozenset[str] = frozenset()

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.measured["position_mm"])

    def channels(self) -> tuple[str, ...]:
        """Channels that the record and every model have, in the order of the page."""
        return tuple(name for name in CHANNELS if name in self.measured and all(name in model for model in self.models.values()))

    def rms(self, channel: str, model: str) -> float:
        """Rms of measured minus `model`, in the channel's unit."""
        error = self.measured[channel] - self.models[model][channel]
        return float(np.sqrt(np.mean(error * error)))


@dataclass(frozen=True)
class Estimate:
    """One identified parameter, in its own unit; shift in % of the healthy value. `std` is NaN when the record does not determine it."""

    estimate: float
    std: float
    shift_percent: float
    healthy: float

    @property
    def std_percent(self) -> float:
        """Standard error in % of the healthy value."""
        return 100.0 * self.std / self.healthy


@dataclass(frozen=True)
class Search:
    """Cost of every model run of a search, in the order they were made; mm2 s. A run given up early holds what had come together."""

    cost: Series
    best: Series


@dataclass(frozen=True)
class Identified:
    """A result of `ema identify`. `faults` by FAULTS holds what was identified, `left_out` why another was not; `case` is set where the truth is known,
    `noise` names the sensor noise in the record."""

    name: str
    faults: dict[str, Estimate]
    before_mm2s: float
    after_mm2s: float
    evaluations: int
    verdict: str
    adequate: bool
    reasons: tuple[str, ...]
    wall_s: float | None
    case: PaperCase | None
    noise: str
    search: Search | None
    curves: Curves | None
    provenance: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """What the page calls it."""
        if self.case is None:
            return self.name
        return f"Case {self.case.letter}: {self.case.title}{', ' + self.noise if self.noise else ''}"

    @property
    def paper(self) -> PaperCase | None:
        """What the paper prints for this record; it prints nothing for one with noise."""
        return None if self.noise else self.case

    @property
    def label(self) -> str:
        """The same for a row of a table."""
        return self.name if self.case is None else f"{self.case.letter}{', noise' if self.noise else ''}"


@dataclass(frozen=True)
class Place:
    """A part of the record: its share of a residual's square and of the time, both in %."""

    name: str
    share_percent: float
    time_percent: float

    @property
    def surprise(self) -> float:
        """How much more of the residual than of the time lies here."""
        if not self.share_percent > self.time_percent > 0.0:
            return 0.0
        return self.share_percent * math.log(self.share_percent / self.time_percent)


@dataclass(frozen=True)
class Compared:
    """A result of `ema compare`: channels as (rms in the channel's unit, % of the measured), balances alike or why there is none."""

    name: str
    sentence: str
    channels: dict[str, tuple[float, float | None]]
    balances: dict[str, tuple[float, float] | str]
    where: tuple[Place, ...]
    curves: Curves | None
    provenance: dict[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """What the page calls it."""
        return f"Model against {self.name}"


Result = Union["Identified", "Compared", "Diagnosed"]


def read_result(path: Path) -> Result:
    """The result in the file at `path`.

    Raises InputError when the file cannot be read, is no JSON, or lacks a field.
    """
    data = read_json(path)
    return parse_result(data, str(path), path.stem)


def parse_result(data: dict[str, Any], source: str, stem: str) -> Result:
    """The result in `data`; `source` names it in errors, `stem` on the page when it has no name of its own."""
    from ema_tools.words.page.diagnosis_results import diagnosed

    reader = Reader(data, source)
    if data.get("command") in ("diagnose", "add") or ("error" in data and "balances" not in data):
        return diagnosed(reader, stem)
    if any(name in data for name in FAULTS):
        return _identified(reader, stem)
    if "balances" in data:
        return _compared(reader, stem)
    raise InputError(
        f"{source}: holds none of `csj_Nm`, `blk_mm` and `balances`, nor a diagnosis: give the --json result of `ema identify`, `ema compare`, `ema diagnose` or `ema add`"
    )


def _identified(reader: Reader, stem: str) -> Identified:
    faults: dict[str, Estimate] = {}
    left_out: dict[str, str] = {}
    for name in (name for name in FAULTS if name in reader.data):
        part = reader.table(name)
        if part.data.get("estimate") is None and part.data.get("reason") is not None:
            left_out[name] = part.text("reason", "")
            continue
        estimate, shift = part.number("estimate"), part.number("shift_percent")
        if shift <= -100.0:
            raise part.fail("shift_percent", "is not above -100")
        healthy = part.number("healthy") if "healthy" in part.data else estimate / (1.0 + shift / 100.0)
        undetermined = "std" in part.data and part.data["std"] is None
        faults[name] = Estimate(estimate, math.nan if undetermined else part.number("std"), shift, healthy)
    if not faults:
        raise Reader({}, reader.source, f"{next(iter(left_out))}.").fail(
            "estimate", "is null for every parameter, which leaves nothing to show"
        )
    letter = reader.text("case", "")
    if letter and len(faults) < len(FAULTS):
        raise reader.fail(next(name for name in FAULTS if name not in faults), "is missing, which a case needs")
    cases = {case.letter: case for case in CASES}
    if letter and letter not in cases:
        raise reader.fail("case", f"names no case ({letter!r}; known: {', '.join(cases)})")
    return Identified(
        name=reader.text("name", stem),
        faults=faults,
        before_mm2s=reader.number("objective_before_mm2s"),
        after_mm2s=reader.number("objective_after_mm2s"),
        evaluations=int(reader.number("evaluations")),
        verdict=reader.text("verdict", "undecided"),
        adequate=bool(reader.data.get("adequate", False)),
        reasons=reader.texts("reasons"),
        wall_s=reader.number("wall_s") if "wall_s" in reader.data else None,
        case=cases.get(letter),
        noise=reader.text("noise", ""),
        search=_search(reader.table("search")) if "search" in reader.data else None,
        curves=curves_of(reader.table("curves"), ("before", "after")) if "curves" in reader.data else None,
        provenance=provenance_of(reader),
        left_out=left_out,
    )


def _compared(reader: Reader, stem: str) -> Compared:
    channels: dict[str, tuple[float, float | None]] = {}
    table = reader.table("channels")
    for name in table.data:
        part = table.table(name)
        silent = part.data.get("relative_percent") is None
        channels[name] = (part.number("rmse"), None if silent else part.number("relative_percent"))
    balances: dict[str, tuple[float, float] | str] = {}
    table = reader.table("balances")
    for name in table.data:
        part = table.table(name)
        if part.data.get("relative_percent") is None:
            balances[name] = part.text("reason", "not available")
        else:
            balances[name] = (part.number("rms"), part.number("relative_percent"))
    where = reader.data.get("where", [])
    if not isinstance(where, list):
        raise reader.fail("where", "is not a list")
    places: list[Place] = []
    for index, entry in enumerate(where):
        part = Reader(entry if isinstance(entry, dict) else {}, reader.source, f"where[{index}].")
        if part.data.get("time_share") is not None:
            places.append(Place(part.text("name", "unnamed"), part.number("share_percent"), 100.0 * part.number("time_share")))
    return Compared(
        name=reader.text("name", stem),
        sentence=reader.text("sentence", ""),
        channels=channels,
        balances=balances,
        where=tuple(sorted((place for place in places if place.surprise > 0.0), key=lambda place: -place.surprise)),
        curves=curves_of(reader.table("curves"), ("model",)) if "curves" in reader.data else None,
        provenance=provenance_of(reader),
    )


def _search(reader: Reader) -> Search:
    cost = reader.series("cost_mm2s")
    return Search(cost, np.minimum.accumulate(cost))


def curves_of(reader: Reader, models: tuple[str, ...]) -> Curves:
    period_s = reader.number("period_s")
    if period_s <= 0.0:
        raise reader.fail("period_s", "is not positive")
    tables: dict[str, dict[str, Series]] = {}
    rows = reader.table("measured").series("position_mm").size
    for key in ("measured", *models):
        part = reader.table(key)
        tables[key] = {name: part.series(name) for name in CHANNELS if name in part.data}
        for name, values in tables[key].items():
            if values.size != rows:
                raise part.fail(name, f"has {values.size} rows where measured.position_mm has {rows}")
        if "position_mm" not in tables[key]:
            raise part.fail("position_mm", "is missing")
    derived: frozenset[str] = frozenset()
    if "speed_mm_s" not in tables["measured"] and rows > 2 * SLOPE_ROWS:
        derived = frozenset(("speed_mm_s",))
        # The same filter for every curve, so that their difference is not the filter's.
        for table in tables.values():
            table["speed_mm_s"] = slope(table["position_mm"], period_s)
    measured = tables.pop("measured")
    return Curves(reader.number("start_s") if "start_s" in reader.data else 0.0, period_s, measured, tables, derived)


def slope(values: Series, period_s: float) -> Series:
    """Slope of the least-squares line through each row and its SLOPE_ROWS neighbours on both sides (fewer at the ends)."""
    offsets = np.arange(-SLOPE_ROWS, SLOPE_ROWS + 1, dtype=np.float64)
    weights = offsets / (period_s * float(np.sum(offsets * offsets)))
    inner = np.convolve(values, weights[::-1], mode="valid")
    ends = np.gradient(values, period_s)
    return np.concatenate((ends[:SLOPE_ROWS], inner, ends[-SLOPE_ROWS:]))


def provenance_of(reader: Reader) -> dict[str, str]:
    table = reader.data.get("provenance", {})
    if not isinstance(table, dict):
        raise reader.fail("provenance", "is not an object")
    return {str(key): str(value) for key, value in table.items()}
