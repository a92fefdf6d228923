"""What the page shows of a result: its numbers as arrays, in the order of the page; that of a diagnosis is next door."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_json
from ema_tools.base.interval import interval95
from ema_tools.data.cases import CASES, PaperCase
from ema_tools.results import codec
from ema_tools.results import reading as results
from ema_tools.results.addition import Addition
from ema_tools.results.comparison import ComparisonResult
from ema_tools.results.diagnosis import DiagnosisByBalanceResult, DiagnosisResult
from ema_tools.results.friction_map import MapResult
from ema_tools.results.identification import KEYS, IdentificationResult, ProfileEntry, ShapeEntry
from ema_tools.results.identification import EstimateEntry as ResultEstimate
from ema_tools.results.parts import Place
from ema_tools.results.reading import result_of
from ema_tools.results.workbench import BenchEntry
from ema_tools.words.page.diagnosis_results import Diagnosed, diagnosed
from ema_tools.words.page.recorded import Curves, Series, curves_of, fault
from ema_tools.words.sentences.sizes import MUCH_HIDDEN

FAULTS = KEYS
BALANCES = ("mechanical", "electrical", "kinematic", "controller")


@dataclass(frozen=True)
class ShownEstimate:
    """One identified parameter, in its own unit; shift in % of the healthy value. `interval`: the 95 % interval, None when the record does not determine it; `threshold_percent`: the shift
    that is called a fault, None in older files."""

    estimate: float
    interval: tuple[float, float] | None
    shift_percent: float
    healthy: float
    threshold_percent: float | None = None
    at_bound: bool = False

    @property
    def beyond(self) -> bool:
        """Whether the shift is called a fault; any is where the file states no threshold."""
        return self.threshold_percent is None or self.shift_percent > self.threshold_percent

    @property
    def surely_beyond(self) -> bool:
        """Whether the whole interval is."""
        return self.beyond and (self.threshold_percent is None or self.shift_percent - self.reach_percent[0] > self.threshold_percent)

    @property
    def most_percent(self) -> float:
        """The end of the interval above the shift, in % of the healthy value."""
        return self.shift_percent + self.reach_percent[1]

    @property
    def may_be_beyond(self) -> bool:
        """Whether some of the interval is."""
        return self.beyond or (self.threshold_percent is not None and self.most_percent > self.threshold_percent)

    @property
    def hides_much(self) -> bool:
        """Whether the interval reaches so far beyond what is called a fault that a healthy answer has to say so."""
        return self.threshold_percent is not None and self.most_percent > MUCH_HIDDEN * self.threshold_percent

    @property
    def reach_percent(self) -> tuple[float, float]:
        """How far the interval reaches below and above the estimate, in % of the healthy value; zero, which draws nothing, where there is none."""
        if self.interval is None:
            return 0.0, 0.0
        below, above = self.estimate - self.interval[0], self.interval[1] - self.estimate
        return 100.0 * below / abs(self.healthy), 100.0 * above / abs(self.healthy)


@dataclass(frozen=True)
class ShownSearch:
    """Cost of every model run of a search, in the order they were made; mm2 s. A run given up early holds what had come together."""

    cost: Series
    best: Series


@dataclass(frozen=True)
class ShownProfile:
    """The objective along one parameter, in its own unit; `limit`: below it a value lies inside the 95 % region by what the residual is."""

    value: Series
    objective: Series
    limit: float


@dataclass(frozen=True)
class ShownMap:
    """The objective over CSJ and BLK, [blk, csj], and where the search was, run by run."""

    csj: Series
    blk: Series
    objective: Series
    path_csj: Series
    path_blk: Series
    path_cost: Series


@dataclass(frozen=True)
class ShownIdentification:
    """A result of `ema identify`, `found` itself. `faults` by FAULTS holds what was identified, `left_out` why another was not; `case` is set where the truth is known,
    `noise` names the sensor noise in the record, `undetermined` says what the record does not determine."""

    name: str
    found: IdentificationResult
    faults: dict[str, ShownEstimate]
    before_mm2s: float
    after_mm2s: float
    evaluations: int
    verdict: str
    adequate: bool
    reasons: tuple[str, ...]
    wall_s: float | None
    case: PaperCase | None
    noise: str
    search: ShownSearch | None
    curves: Curves | None
    provenance: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)
    profiles: dict[str, ShownProfile] = field(default_factory=dict)
    map: ShownMap | None = None
    undetermined: dict[str, str] = field(default_factory=dict)
    workbench: BenchEntry | None = None

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
class ShownComparison:
    """A result of `ema compare`, `found` itself: channels as (rms in the channel's unit, % of the measured), balances alike or why there is none."""

    name: str
    sentence: str
    found: ComparisonResult
    channels: dict[str, tuple[float, float | None]]
    balances: dict[str, tuple[float, float] | str]
    where: tuple[Place, ...]
    curves: Curves | None
    provenance: dict[str, str] = field(default_factory=dict)
    workbench: BenchEntry | None = None

    @property
    def title(self) -> str:
        """What the page calls it."""
        return f"Model against {self.name}"


@dataclass(frozen=True)
class Mapped:
    """A result of `ema map`."""

    name: str
    sentence: str
    found: MapResult
    provenance: dict[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """What the page calls it."""
        others = len(self.found.records) - 1
        return f"Friction against speed, {self.name}{f' and {others} more' if others else ''}"


Result = ShownIdentification | ShownComparison | Diagnosed | Mapped


def read_result(path: Path) -> Result:
    """What the page shows of the file at `path`. Raises InputError when the file cannot be read, or is not as its type says."""
    return parse_result(read_json(path), str(path), path.stem)


def parse_result(data: Mapping[str, Any], source: str, stem: str) -> Result:
    """What the page shows of a JSON object; `source` names it in errors, `stem` on the page when it has no name of its own. Raises InputError."""
    return shown(result_of(data, source), source, stem)


def shown(found: results.Result, source: str, stem: str) -> Result:
    """What the page shows of a result. Raises InputError for a result that has no page, and for numbers that do not belong together."""
    if isinstance(found, DiagnosisResult | DiagnosisByBalanceResult | Addition):
        return diagnosed(found, source, stem)
    if isinstance(found, IdentificationResult):
        return identified(found, source, stem)
    if isinstance(found, ComparisonResult):
        return compared(found, source, stem)
    if isinstance(found, MapResult):
        return mapped(found, source)
    raise InputError(
        f"{source}: the result of `ema {found.command}` has no page: give the --json result of `ema identify`, `ema compare`, `ema diagnose`, `ema add` or `ema map`"
    )


def mapped(found: MapResult, source: str) -> Mapped:
    """Of `ema map`. Raises InputError for a map without points."""
    if not found.points:
        raise fault(source, "points", "is empty, which leaves nothing to show")
    return Mapped(found.name, found.sentence, found, found.provenance)


def identified(found: IdentificationResult, source: str, stem: str) -> ShownIdentification:
    """Of `ema identify`. Raises InputError for what cannot be shown."""
    left_out = {name: one.reason for name, one in found.left_out.items()}
    if not found.estimates:
        raise fault(source, f"{next(iter(left_out), FAULTS[0])}.estimate", "is null for every parameter, which leaves nothing to show")
    letter = found.case or ""
    if letter and len(found.estimates) < len(FAULTS):
        raise fault(source, next(name for name in FAULTS if name not in found.estimates), "is missing, which a case needs")
    cases = {case.letter: case for case in CASES}
    if letter and letter not in cases:
        raise fault(source, "case", f"names no case ({letter!r}; known: {', '.join(cases)})")
    return ShownIdentification(
        name=found.name or stem,
        found=found,
        faults={name: _estimate(one, source, name) for name, one in found.estimates.items()},
        before_mm2s=found.objective_before_mm2s,
        after_mm2s=found.objective_after_mm2s,
        evaluations=found.evaluations,
        verdict=found.verdict,
        adequate=found.adequate,
        reasons=found.reasons,
        wall_s=found.wall_s,
        case=cases.get(letter),
        noise=found.noise or "",
        search=_search(found.search.cost_mm2s, source) if found.search is not None else None,
        curves=curves_of(found.curves, source) if found.curves is not None else None,
        provenance=found.provenance,
        left_out=left_out,
        profiles=_profiles(found.shape, source) if found.shape is not None else {},
        map=_map(found.shape, source) if found.shape is not None and found.shape.map is not None else None,
        undetermined=found.undetermined,
        workbench=found.workbench,
    )


def _estimate(one: ResultEstimate, source: str, name: str) -> ShownEstimate:
    # a play of zero is one; without its healthy value there would be none to divide by
    if one.shift_percent < -100.0 or (one.shift_percent == -100.0 and one.healthy is None):
        raise fault(source, f"{name}.shift_percent", "is not above -100")
    healthy = one.healthy if one.healthy is not None else one.estimate / (1.0 + one.shift_percent / 100.0)
    low, high = one.interval95
    if (low is None or high is None) and one.std is not None:
        # an older file states a standard error alone
        low, high = interval95(one.estimate, one.std)
    ends = (low, high) if low is not None and high is not None else None
    return ShownEstimate(one.estimate, ends, one.shift_percent, healthy, one.threshold_percent, one.at_bound)


def _profiles(shape: ShapeEntry, source: str) -> dict[str, ShownProfile]:
    found = {}
    for name in FAULTS:
        one: ProfileEntry | None = getattr(shape, name)
        if one is not None:
            if not 0 < len(one.value) == len(one.objective_mm2s):
                raise fault(source, f"shape.{name}.objective_mm2s", f"has {len(one.objective_mm2s)} numbers for {len(one.value)} values")
            found[name] = ShownProfile(np.asarray(one.value), np.asarray(one.objective_mm2s), one.limit_mm2s)
    return found


def _map(shape: ShapeEntry, source: str) -> ShownMap:
    assert shape.map is not None
    rows, across = len(shape.map.objective_mm2s), len(shape.map.csj_Nm)
    if rows != len(shape.map.blk_mm) or any(len(row) != across for row in shape.map.objective_mm2s) or not rows or not across:
        raise fault(source, "shape.map.objective_mm2s", "is not a number for each BLK and CSJ")
    path = [np.asarray(shape.path.get(name, ()), dtype=np.float64) for name in FAULTS]
    cost = np.asarray(shape.path_cost_mm2s, dtype=np.float64)
    if any(one.size != cost.size for one in path):
        raise fault(source, "shape.path", "has not one value for each cost")
    return ShownMap(
        np.asarray(shape.map.csj_Nm), np.asarray(shape.map.blk_mm), np.asarray(shape.map.objective_mm2s), path[0], path[1], cost
    )


def compared(found: ComparisonResult, source: str, stem: str) -> ShownComparison:
    """Of `ema compare`."""
    balances: dict[str, tuple[float, float] | str] = {
        name: (one.rms, one.relative_percent) if one.rms is not None and one.relative_percent is not None else one.reason or "not available"
        for name, one in found.balances.items()
    }
    return ShownComparison(
        name=found.name or stem,
        sentence=found.sentence,
        found=found,
        channels={name: (one.rmse, one.relative_percent) for name, one in found.channels.items()},
        balances=balances,
        where=tuple(sorted((place for place in found.where if place.surprise > 0.0), key=lambda place: -place.surprise)),
        curves=curves_of(found.curves, source) if found.curves is not None else None,
        provenance=found.provenance,
        workbench=found.workbench,
    )


def _search(costs: codec.Series, source: str) -> ShownSearch:
    if not costs:
        raise fault(source, "search.cost_mm2s", "is not a list of numbers")
    cost = np.asarray(costs, dtype=np.float64)
    return ShownSearch(cost, np.minimum.accumulate(cost))
