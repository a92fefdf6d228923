"""Several results of `ema identify` and `ema diagnose` as readings of units over their dates, as a fleet has them.

A date stands in the name of the record, else of the result's file, else of its folder. A unit is a folder whose name has no date, where the results lie in several; results of several actuators in one
folder are of several units.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from ema_tools.data.manifest import date_in_name
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.identification import EstimateEntry, IdentificationResult
from ema_tools.results.reading import Result
from ema_tools.results.store import FleetRow
from ema_tools.tasks.history import LIMITS, UnitHistory, histories

_UNDATED = datetime(2000, 1, 1, tzinfo=UTC)  # from which undated results are counted; shown nowhere [layout]
_KEY_OF = {"csj": "csj_Nm", "blk": "blk_mm"}
# Where a date was found, by who is asked for one first.
SOURCES = ("record", "result", "folder")


@dataclass(frozen=True)
class SeveralReadings:
    """One unit: its history, whether every result has a date, the thresholds in %, the names without a date and where the dates are from (SOURCES)."""

    history: UnitHistory
    dated: bool
    thresholds: Mapping[str, float]
    undated: tuple[str, ...]
    sources: tuple[str, ...]


@dataclass(frozen=True)
class _Read:
    """One result as a row, with its date and where that is from, None without, and its thresholds."""

    row: FleetRow
    date: datetime | None
    source: str
    thresholds: Mapping[str, float]


def several_results(found: Sequence[tuple[Path, Result]]) -> list[SeveralReadings]:
    """The units that have two records or more with a reading, by name. Results of the paper's cases are days of no unit."""
    kept = [
        (path, one)
        for path, one in found
        if isinstance(one, DiagnosisResult | DiagnosisByBalanceResult) or (isinstance(one, IdentificationResult) and not one.case)
    ]
    unit_of = _units([path for path, _ in kept], [one.provenance.get("actuator", "") for _, one in kept])
    read = [_read(path, one, unit) for (path, one), unit in zip(kept, unit_of, strict=True)]
    read = [one for one in read if any(one.row.reading(name)[0] is not None for name in LIMITS)]
    by_unit = itertools.groupby(sorted(read, key=lambda one: one.row.unit), lambda one: one.row.unit)
    units = [tuple(group) for _, group in by_unit]
    return [_several(own) for own in units if len({one.row.file for one in own}) > 1]


def _units(paths: Sequence[Path], actuators: Sequence[str]) -> list[str]:
    """Each result's unit."""
    folders = ["" if date_in_name(Path(path.resolve().parent.name)) else path.resolve().parent.name for path in paths]
    several_folders, several_actuators = len({*filter(None, folders)}) > 1, len(set(actuators)) > 1
    named = [
        ", ".join(filter(None, (folder if several_folders else "", actuator if several_actuators else "")))
        for folder, actuator in zip(folders, actuators, strict=True)
    ]
    return [name or actuator or "unit" for name, actuator in zip(named, actuators, strict=True)]


def _read(path: Path, found: IdentificationResult | DiagnosisResult | DiagnosisByBalanceResult, unit: str) -> _Read:
    name = found.name or path.stem
    places: Mapping[str, Callable[[], Path]] = {
        "record": lambda: Path(name),
        "result": lambda: Path(path.stem),
        "folder": lambda: Path(path.resolve().parent.name),
    }
    date, source = next(((date, who) for who in SOURCES if (date := date_in_name(places[who]())) is not None), (None, ""))
    row = FleetRow(str(path), unit, date or _UNDATED, name, "test", found.provenance.get("actuator", ""))
    if isinstance(found, IdentificationResult):
        row = replace(row, verdict=found.verdict, adequate=found.adequate, reasons="; ".join(found.reasons))
        thresholds = {
            short: one.threshold_percent
            for short, key in _KEY_OF.items()
            if (one := found.estimates.get(key)) is not None and one.threshold_percent is not None
        }
        return _Read(replace(row, **_identified(found)), date, source, thresholds)
    # an effect that is missing is in the model of a diagnosis, beside which the faults are read
    row = replace(row, verdict=found.verdict, adequate=found.verdict != "unknown")
    return _Read(replace(row, **_diagnosed(found)), date, source, {})


def _identified(found: IdentificationResult) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for short, key in _KEY_OF.items():
        one = found.estimates.get(key)
        if one is None:
            continue
        values[f"{short}_shift_percent"] = one.shift_percent
        low, high = one.interval95
        healthy = _healthy(one)
        if low is not None and high is not None and key not in found.undetermined and healthy:
            values |= {f"{short}_low_percent": 100.0 * (low / healthy - 1.0), f"{short}_high_percent": 100.0 * (high / healthy - 1.0)}
    return values


def _healthy(one: EstimateEntry) -> float:
    """Healthy value, which older files do not state; 0 where it is not known."""
    if one.healthy is not None:
        return one.healthy
    share = 1.0 + 0.01 * one.shift_percent
    return one.estimate / share if share > 0.0 else 0.0


def _diagnosed(found: DiagnosisResult | DiagnosisByBalanceResult) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for short, one in found.faults.items():
        if short in _KEY_OF and one.shift_percent is not None:
            values[f"{short}_shift_percent"] = one.shift_percent
            low, high = one.shift_interval95 or (None, None)
            if low is not None and high is not None:
                values |= {f"{short}_low_percent": low, f"{short}_high_percent": high}
    return values


def _several(own: Sequence[_Read]) -> SeveralReadings:
    """One unit; without a date for every result the order in which they were given."""
    undated = tuple(one.row.file for one in own if one.date is None)
    rows = [one.row for one in own]
    if undated:
        rows = [replace(row, date=_UNDATED + timedelta(days=place)) for place, row in enumerate(rows)]
    thresholds = {name: value for one in own for name, value in one.thresholds.items()}
    sources = tuple(who for who in SOURCES if any(one.source == who for one in own))
    return SeveralReadings(histories(rows, LIMITS)[0], not undated, thresholds, undated, sources)
