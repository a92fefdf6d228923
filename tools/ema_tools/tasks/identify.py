"""CSJ and BLK by the onboard module's own session: what `ema identify` does."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval95
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, nearest, row_of, shown
from ema_tools.data.records import Record
from ema_tools.fit.interval import scatter_of
from ema_tools.plant.native import (
    CHANNELS,
    NOT_DETERMINED,
    REASONS,
    Identification,
    IdentifiedValue,
    Progress,
    SearchSettings,
    Table,
    library,
)
from ema_tools.select.cross_check import CrossCheck, cross_check
from ema_tools.tasks.diagnose import check_apart

# Keys of the result for the values that are identified by default.
KEYS = {"screw.csj_Nm": "csj_Nm", "screw.blk_mm": "blk_mm"}
BOUNDS = {"screw.csj_Nm": ("search.csj_lower_Nm", "search.csj_upper_Nm"), "screw.blk_mm": ("search.blk_lower_mm", "search.blk_upper_mm")}
MIN_SHIFTS = {"screw.csj_Nm": "verdict.csj_min_shift_percent", "screw.blk_mm": "verdict.blk_min_shift_percent"}
# Reasons that make the values read on a healthy record worthless.
_NO_BASELINE = tuple(REASONS[bit] for bit in (1, 2, 8, NOT_DETERMINED))
NOT_ADEQUATE = REASONS[2]
_POSITION_ALONE = (1.0, 0.0, 0.0, 0.0)  # what the search weighs unless told: the rod position is what the fault shows in [physics]


# Why an answer does not stand: something is missing from the model, known or not; an effect would do as well; other signals say other values; it hangs on what the machine is today.
Objection = Literal["missing", "unknown", "rival", "signals", "open"]


@dataclass(frozen=True)
class Baseline:
    """Healthy values found on healthy records by the same search, and their standard errors, by name."""

    values: dict[str, float]
    std: dict[str, float]
    records: int


@dataclass(frozen=True)
class Identified:
    """The answer of one record; `costs` are the objective of every model run in their order, `seeds` the answers of further seeds.

    `scatter`: how far the estimates move from run to run with what scatters on a healthy machine, standard deviations by name.
    `checked`: what all signals say of the estimates; None where it was not wanted.
    """

    actuator: Actuator
    healthy: Actuator
    answer: Identification
    baseline: Baseline | None
    costs: tuple[float, ...]
    seeds: tuple[Identification, ...]
    seed: int
    precision: int
    wall_s: float
    weighted: bool
    checked: CrossCheck | None = None
    scatter: Mapping[str, float] = field(default_factory=dict)

    def interval95(self, one: IdentifiedValue) -> tuple[float | None, float | None]:
        """Where a value lies with 95 % certainty: sensor noise, what lasts in the residual, and what moves from run to run, as healthy records show it where there are two or more."""
        seen = 0.0
        if self.baseline is not None and self.baseline.records > 1:
            seen = self.baseline.std[one.name] * math.sqrt(self.baseline.records)
        return interval95(one.estimate, one.std, one.bias if math.isfinite(one.bias) else 0.0, max(seen, self.scatter.get(one.name, 0.0)))

    @property
    def objection(self) -> Objection | None:
        """Why the module's answer does not stand, by all signals; None where it does."""
        checked = self.checked
        if checked is None:
            return None
        if checked.kind in ("unknown", "rival"):
            return checked.kind
        if checked.kind == "missing":
            return "missing" if not self.answer.adequate or any(map(self._moved, self.answer.identified)) else None
        if self.answer.verdict == "undecided":
            return None
        if any(map(self._moved, self.answer.identified)):
            return "signals"
        return None if self._stands(checked) else "open"

    def _moved(self, estimate: IdentifiedValue) -> bool:
        """Whether all signals say another shift than the module does."""
        shift = self.checked.shift.get(estimate.name) if self.checked is not None else None
        if shift is None:
            return False
        std = estimate.std / abs(self.healthy[estimate.name])
        return abs(shift - 0.01 * estimate.shift_percent) > max(self._least(estimate.name), 3.0 * (std if np.isfinite(std) else 0.0))

    def _least(self, name: str) -> float:
        return 0.01 * self.healthy[MIN_SHIFTS[name]]

    def _stands(self, checked: CrossCheck) -> bool:
        """Whether the verdict is the same for all that the machine may be today."""
        sure = self.healthy["verdict.confidence_std"]
        doubt = {name: sure * one.std / abs(self.healthy[name]) for name, one in checked.open.items()}
        if self.answer.verdict == "fault":
            return any(shift - doubt[name] > self._least(name) for name, shift in checked.shift.items())
        return all(abs(shift) + doubt[name] <= self._least(name) for name, shift in checked.shift.items())

    @property
    def objects(self) -> bool:
        """Whether the module's answer does not stand."""
        return self.objection is not None

    def least_sure(self) -> str:
        """Of CSJ and BLK, the one that is least known for what the machine may be today, by name."""
        stands = self.checked.open if self.checked is not None else {}
        return max(stands, key=lambda name: stands[name].std / self._least(name) / abs(self.healthy[name]))

    @property
    def verdict(self) -> str:
        """The module's verdict, undecided where all signals object to it."""
        return "undecided" if self.objects else self.answer.verdict

    @property
    def adequate(self) -> bool:
        """Whether the model explains the record: the rod position by the module, every signal by the cross-check."""
        return self.answer.adequate and self.objection not in ("unknown", "missing")


def weight_of(text: str | None) -> tuple[float, float, float, float] | None:
    """Weights in the order of CHANNELS from `column=weight,...`; None for the usual ones. Raises InputError that names the column."""
    if not text:
        return None
    weight = dict.fromkeys(CHANNELS, 0.0)
    for part in filter(None, text.split(",")):
        name, _, value = part.partition("=")
        if name.strip() not in weight:
            raise InputError(f"--weight {part}: unknown column{nearest(name.strip(), CHANNELS)}: columns are {', '.join(CHANNELS)}")
        try:
            weight[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--weight {part}: not a number: write for example --weight position_mm=1,current_A=0.01") from None
    numbers = list(weight.values())
    if not all(0.0 <= number < float("inf") for number in numbers) or not any(numbers):
        raise InputError(f"--weight {text}: not weights: give numbers of zero or more, one of them above zero")
    return numbers[0], numbers[1], numbers[2], numbers[3]


def identified_of(actuator: Actuator) -> tuple[str, ...]:
    """The values that are searched: those whose healthy value is not zero, since a shift is counted in % of it."""
    return tuple(name for name in KEYS if actuator[name] > 0.0)


def check_bounds(actuator: Actuator) -> None:
    """Raises InputError where a healthy value lies outside the bounds of its search."""
    for name in identified_of(actuator):
        lower, upper = BOUNDS[name]
        if not actuator[lower] < actuator[upper]:
            raise InputError(f"{actuator.file}: {lower} = {actuator[lower]:g}: not below {upper} = {actuator[upper]:g}: correct the bounds")
        if not actuator[lower] <= actuator[name] <= actuator[upper]:
            raise InputError(
                f"{actuator.file}: {name} = {actuator[name]:g}: outside the search's bounds {actuator[lower]:g} .. {actuator[upper]:g} {row_of(name).unit}: widen them"
            )


def check_record(actuator: Actuator, record: Record, search: SearchSettings) -> None:
    """Raises InputError when the search cannot begin: a healthy value or a bound that does not fit, or a weight on a signal that is not recorded."""
    for name, weight in zip(CHANNELS, search.weight or (), strict=False):
        if weight > 0.0 and record.channel(name) is None:
            raise InputError(f"{record.file}: {name}: weighted but not recorded: recorded are {', '.join(record.present)}")
    if not identified_of(actuator):
        raise InputError(
            f"{actuator.file}: screw.csj_Nm = 0: the healthy value is zero, and a shift is counted in % of it: give one, or calibrate"
        )
    check_bounds(actuator)


def check_table(table: Table, record: Record) -> None:
    """Raises InputError when the record lacks a signal that the table of signatures compares."""
    for place in table.channels:
        if record.channel(CHANNELS[place]) is None:
            raise InputError(
                f"{record.file}: {CHANNELS[place]}: the table compares it, but it is not recorded: record it, or leave --table out"
            )


def run(
    actuator: Actuator, record: Record, search: SearchSettings, bits: int, progress: Progress | None = None, table: Table | None = None
) -> Identification:
    """One search on one record, behind a `table` of signatures where one is given. Raises InputError."""
    names = identified_of(actuator)
    if search.identified is None and len(names) < len(KEYS):
        lower, upper = (tuple(actuator[BOUNDS[name][side]] for name in names) for side in (0, 1))
        search = replace(
            search, identified=names, lower=lower, upper=upper, min_shift_percent=tuple(actuator[MIN_SHIFTS[name]] for name in names)
        )
    values, options = actuator.arrays()
    return library(bits).identify(values, options, record.command_mm, record.table(), search, progress, table)


def baseline_of(actuator: Actuator, records: Sequence[Record], search: SearchSettings, bits: int) -> Baseline:
    """Healthy values as the same search reads them on healthy records, so that what it reads wrongly, it reads wrongly on both.

    Raises InputError when a healthy record does not determine them, or the model does not explain it.
    """
    answers = each(lambda record: run(actuator, record, search, bits), records)
    for record, answer in zip(records, answers, strict=True):
        unfit = [reason for reason in answer.reasons if reason in _NO_BASELINE]
        if unfit:
            raise InputError(
                f"{record.file}: cannot serve as a healthy record: {'; '.join(unfit)}: calibrate the actuator on it first, or leave it out of --healthy"
            )
        for estimate in answer.identified:
            if estimate.at_bound:
                raise InputError(
                    f"{record.file}: {shown(row_of(estimate.name))}: the healthy value lies on a bound of its search: calibrate the actuator first"
                )
    values, std = {}, {}
    count = len(answers)
    for place, estimate in enumerate(answers[0].identified):
        found = np.array([answer.identified[place].estimate for answer in answers])
        own = np.array([answer.identified[place].std for answer in answers])
        scatter = float(np.std(found, ddof=1)) if count > 1 else 0.0
        values[estimate.name] = float(np.mean(found))
        std[estimate.name] = max(scatter, float(np.sqrt(np.mean(own**2)))) / float(np.sqrt(count))
    return Baseline(values, std, count)


def identify(
    actuator: Actuator,
    record: Record,
    healthy: Sequence[Record] = (),
    search: SearchSettings | None = None,
    seeds: int = 1,
    bits: int = 32,
    progress: Progress | None = None,
    guarding: bool = True,
    table: Table | None = None,
) -> Identified:
    """Identify CSJ and BLK on `record`, against the actuator's healthy values or those of the `healthy` records.

    Unless `guarding` is off, the answer is held against all signals, and an effect that the model lacks is sought behind it. `seeds` further searches
    (seed, seed + 1, ...) run beside the first and show how much the answer depends on the seed. With a `table` of signatures the answer is the one that firmware gives
    with it, guarded by the table alone. Raises InputError.
    """
    settings = search or SearchSettings()
    check_record(actuator, record, settings)
    check_apart(record, healthy)
    if table is not None:
        check_table(table, record)
    seed = settings.seed if settings.seed is not None else int(actuator["search.seed"])
    settings = replace(settings, seed=seed)
    baseline = baseline_of(actuator, healthy, settings, bits) if healthy else None
    known = actuator.changed(baseline.values) if baseline else actuator
    check_record(known, record, settings)
    costs: list[float] = []

    def seen(evaluation: int, cost: float, best: float) -> None:
        costs.append(cost)
        if progress is not None:
            progress(evaluation, cost, best)

    begun = time.perf_counter()
    answer = run(known, record, settings, bits, seen, table)
    wall_s = time.perf_counter() - begun
    others = each(
        lambda other: run(known, record, replace(settings, seed=other), bits, None, table), [seed + place for place in range(1, seeds)]
    )
    found = known.changed(
        {
            estimate.name: min(max(estimate.estimate, row_of(estimate.name).lower), row_of(estimate.name).upper)
            for estimate in answer.identified
        }
    )
    estimates = {estimate.name: estimate.estimate for estimate in answer.identified if estimate.name in KEYS}
    wanted = guarding and table is None and bool(estimates)
    least = {name: 0.01 * known[MIN_SHIFTS[name]] for name in KEYS}
    checked = cross_check(known, record, healthy, estimates, least, not answer.adequate) if wanted else None
    weighted = settings.weight is not None
    scatter = scatter_of(found, record, identified_of(known), dict(zip(CHANNELS, settings.weight or _POSITION_ALONE, strict=True)))
    return Identified(found, known, answer, baseline, tuple(costs), tuple(others), seed, bits, wall_s, weighted, checked, scatter)
