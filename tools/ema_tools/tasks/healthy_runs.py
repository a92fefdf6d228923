"""What healthy records of a unit say before today's is looked at: its healthy CSJ and BLK, how far they move from run to run, and which signals tell them best."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, row_of, shown
from ema_tools.data.records import Record
from ema_tools.fit.detection import FALSE_ALARM, USUAL_WEIGHT, ShiftTest, beyond
from ema_tools.fit.interval import scatter_of
from ema_tools.fit.nuisance import share_from_run_to_run
from ema_tools.fit.shared_noise import shared_noise
from ema_tools.fit.temperature import Foretold, HealthyFriction, of_runs
from ema_tools.plant.native import CHANNELS, NOT_DETERMINED, REASONS, SearchSettings
from ema_tools.select.healthy_groups import checked_states
from ema_tools.select.known_machine import Compared, KnownMachine, MachineFit
from ema_tools.select.open_state import std_by_data_sheet
from ema_tools.tasks.onboard_search import (
    DAY_VALUES,
    MIN_SHIFTS,
    POSITION_ALONE,
    POSITION_NOISE,
    SHARED_NOISE,
    check_kept,
    identified_of,
    run,
)

# Reasons that make the values read on a healthy record worthless.
_NO_BASELINE = tuple(REASONS[bit] for bit in (1, 2, 8, NOT_DETERMINED))
_AT_MOST = (
    2.0  # of the stated thresholds, beyond which none is set unless it is asked for: what scatters more is undecided between [judgement]
)
# Friction differs from day to day by the temperature as the winding does: where that scatters more than usual, so will friction, though few records may not show it [physics]
_ALSO_SHOWN = {"screw.csj_Nm": "motor.resistance_ohm"}
_BETTER = 0.5  # of the usual scatter: a reading that errs by less tells it [judgement]
DRY, _WINDING, _GREASE = "screw.csj_Nm", "motor.resistance_ohm", "screw.viscous_Nm_s_per_rad"
# Signals that tell play and friction and hardly anything else: current and voltage follow grease and winding, which differ from day to day [physics]
_WEIGHED = ("position_mm", "motor_position_mm")


@dataclass(frozen=True)
class Baseline:
    """Healthy values found on healthy records by the same search, their standard errors, and by how much the search reads one run apart from another, standard deviations, by name."""

    values: dict[str, float]
    std: dict[str, float]
    records: int
    scatter: Mapping[str, float] = field(default_factory=dict)


def baseline_of(actuator: Actuator, records: Sequence[Record], search: SearchSettings, bits: int) -> Baseline:
    """Healthy values as the same search reads them on healthy records, so that what it reads wrongly, it reads wrongly on both.

    Raises InputError when a healthy record does not determine them, or the model does not explain it.
    """
    answers = each(lambda record: run(actuator, record, search, bits), records)
    for record, answer in zip(records, answers, strict=True):
        unfit = [reason for reason in answer.reasons if reason in _NO_BASELINE]
        if unfit:
            raise InputError(f"{record.file}: cannot serve as a healthy record: {'; '.join(unfit)}: {_instead(records)}")
        for estimate in answer.identified:
            if estimate.at_bound:
                raise InputError(
                    f"{record.file}: {shown(row_of(estimate.name))}: the healthy value lies on a bound of its search: calibrate the actuator first"
                )
    values, std = {}, {}
    count = len(answers)
    names = tuple(estimate.name for estimate in answers[0].identified)
    stated = _stated(actuator, records[0], names, search) if count > 1 else {}
    for place, estimate in enumerate(answers[0].identified):
        found = np.array([answer.identified[place].estimate for answer in answers])
        own = np.array([answer.identified[place].std for answer in answers])
        scatter = float(np.std(found, ddof=1)) if count > 1 else 0.0
        values[estimate.name] = float(np.mean(found))
        noise = float(np.sqrt(np.mean(own**2)))
        apart = math.hypot(stated[estimate.name], noise) if estimate.name in stated else max(scatter, noise)
        std[estimate.name] = apart / float(np.sqrt(count))
    return Baseline(values, std, count, {name: one * math.sqrt(count) for name, one in std.items()} if count > 1 else {})


def _instead(records: Sequence[Record]) -> str:
    """What to do about healthy records that the model does not explain each by itself."""
    if len(records) == 1:
        return "one healthy run does not show what this unit always has: record two more under today's command and give all with --healthy"
    return "calibrate the actuator on it first, or leave it out of --healthy"


def _stated(actuator: Actuator, record: Record, names: Sequence[str], search: SearchSettings) -> dict[str, float]:
    """By how much the search reads runs apart, sensor noise aside, of those values whose scatter the actuator states: that is known, and a few runs do not change it."""
    if not set(names) & set(actuator.scatter):
        return {}
    read = scatter_of(actuator, record, names, dict(zip(CHANNELS, search.weight or POSITION_ALONE, strict=True)))
    return {name: std for name, std in read.items() if name in actuator.scatter}


@dataclass(frozen=True)
class HealthyRuns:
    """What two or more healthy records of today's command say. `known`: the machine as they show it, with the sensor noise that they show; `search`: the settings by which it is
    searched: weights of the signals and the least shifts that are called a fault; `doubt`: why two records may not both be healthy, in words; `friction`: how dry friction goes with
    temperature, where the runs can tell; `means`: of winding and grease, by name."""

    known: Actuator
    baseline: Baseline
    search: SearchSettings
    doubt: str = ""
    friction: HealthyFriction | None = None
    means: Mapping[str, float] = field(default_factory=dict)

    def foretold(self, today: Mapping[str, float]) -> Foretold | None:
        """Dry friction as it should be `today`, by winding and grease of that name, over that of the healthy runs."""
        if self.friction is None:
            return None
        return self.friction.today(today[_WINDING] / self.means[_WINDING] - 1.0, today[_GREASE] / self.means[_GREASE] - 1.0)


def scatter_shown(apart: Sequence[float], usual: float, means: int = 1) -> float:
    """Standard deviation from run to run, by how far runs lie from their mean and by what is `usual`, or stated where no runs are to tell; `means`: that were taken of these runs."""
    return math.sqrt((USUAL_WEIGHT * usual**2 + float(np.sum(np.square(apart)))) / (USUAL_WEIGHT + len(apart) - means))


def scatter_read(known: Actuator, name: str, read: Sequence[float], today: Sequence[Mapping[str, float]], usual: float) -> float:
    """Standard deviation from run to run of a value that was `read` on each of several runs, by those readings, by what scatters with it (its values on the same runs in `today`), and by
    what is `usual`; what the actuator states is known, and a few runs do not change it."""
    if name in known.scatter:
        return usual
    shown = [one - known[name] for one in read]
    other = _ALSO_SHOWN.get(name, "")
    share = share_from_run_to_run(known, other)
    # what the actuator states not to scatter shows nothing
    beside = [(one[other] / known[other] - 1.0) / share * usual for one in today if other in one and share > 0.0]
    return scatter_shown([*shown, *beside], usual, 2 if beside else 1)


def thermometers(beside: Compared, bases: Sequence[MachineFit]) -> list[dict[str, float]]:
    """Winding and grease as all signals say that they were on each run, whose fits against the others are `bases`, by name: those that scatter and that the signals tell."""
    known = beside.known
    names = [name for name in (_WINDING, _GREASE) if name in known.scatter and all(_told(known, base, name) for base in bases)]
    read = {name: beside.of_runs([base.values[name] for base in bases]) for name in names}
    return [{name: read[name][place] for name in names} for place in range(len(bases))]


def _told(known: KnownMachine, base: MachineFit, name: str) -> bool:
    """Whether a record tells a value better than its usual scatter does: what it does not tell is found at its healthy value, and would be taken for steady."""
    usual = share_from_run_to_run(known.actuator, name) * known.actuator[name]
    return base.std.get(name, math.inf) < _BETTER * usual


def friction_of(known: Actuator, read: Sequence[float], noise: float, today: Sequence[Mapping[str, float]]) -> HealthyFriction | None:
    """How dry friction goes with temperature, by what was `read` of it on each of several runs and by their winding and grease; None where they are not there, or what the actuator states is
    known of it already."""
    names = (DRY, _WINDING, _GREASE)
    if (
        not all(name in one for one in today for name in names[1:])
        or set(names) & set(known.scatter)
        or not all(known[name] > 0.0 for name in names)
    ):
        return None
    winding, grease = ([one[name] for one in today] for name in names[1:])
    usual = tuple(share_from_run_to_run(known, name) for name in names)
    return of_runs(read, winding, grease, (usual[0], usual[1], usual[2]), noise / known[DRY])


def least_shift(stated_percent: float, scatter_percent: float, runs: int, false_alarm: float | None = None) -> float:
    """The shift that is called a fault, in %: no less than what is stated, and than a healthy machine shows by the scatter of its `runs`.

    With a rate of false alarms that was chosen it is what the scatter makes of that, and nothing else.
    """
    if false_alarm is not None:
        return ShiftTest(false_alarm, runs=runs).threshold() * scatter_percent
    return clipped(stated_percent, ShiftTest(runs=runs).threshold() * scatter_percent)


def clipped(stated_percent: float, asked_percent: float) -> float:
    """The shift that is called a fault, in %, by what is stated and what scatter asks for: a machine that scatters more is not called healthy with what is a fault of another."""
    return float(np.clip(asked_percent, stated_percent, _AT_MOST * stated_percent))


def weights_of(beside: Compared) -> tuple[float, float, float, float]:
    """Weights of both positions by the noise that the repeats show, the rod's being 1."""
    noise = dict(zip(beside.signals, np.mean(beside.unit.noise, axis=1).tolist(), strict=True))
    found = [noise["position_mm"] / noise[name] if name in _WEIGHED and name in noise else 0.0 for name in CHANNELS]
    return found[0], found[1], found[2], found[3]


def healthy_runs(given: Actuator, beside: Compared, search: SearchSettings, bits: int) -> HealthyRuns:
    """The machine as its healthy repeats show it, and how far the same search reads each of them from the others.

    `given`: the machine as its file has it. What is called a fault is no less than what the unit does from run to run. Raises InputError where the records are not of one machine in one state.
    """
    unit = beside.unit
    here = unit.simulate({}, np.zeros(len(unit.spread)))[0]
    noise_mm = max(float(np.sqrt(np.mean((one[0] - here) ** 2))) for one in unit.repeats)
    # what differs from day to day is taken from all signals here
    known = unit.actuator.changed({POSITION_NOISE: max(unit.actuator[POSITION_NOISE], noise_mm), DAY_VALUES: 0.0})
    check_kept(given, known, beside.repeats[0].file)
    names = identified_of(known)
    weighed = replace(search, weight=search.weight or weights_of(beside))
    bases = [machine.base({}) for machine in beside.known_repeats]
    doubt = checked_states(beside, bases)
    # each is held against the others here, today's record against all
    left = np.array(
        [machine.evidence.target[0] - machine.signals(base.values)[0] for machine, base in zip(beside.known_repeats, bases, strict=True)]
    )
    shared_mm = shared_noise(left) * math.sqrt((len(left) + 1.0) * (len(left) - 1.0)) / len(left)
    known = known.changed({SHARED_NOISE: max(known[SHARED_NOISE], shared_mm)})
    days = [known.changed(beside.known.today(base)) for base in bases]
    answers = each(lambda day: run(day[0], day[1], weighed, bits), list(zip(days, beside.corrected_repeats(), strict=True)))
    count = len(answers)
    today = thermometers(beside, bases)
    std: dict[str, float] = {}
    friction: HealthyFriction | None = None
    for place, estimate in enumerate(answers[0].identified):
        name = estimate.name
        read = [answer.identified[place] for answer in answers]
        noise = float(np.mean([one.std for one in read]))
        usual = math.hypot(share_from_run_to_run(known, name) * known[name], noise if math.isfinite(noise) else 0.0)
        values = beside.of_runs([one.estimate for one in read])
        std[name] = scatter_read(known, name, values, today, usual)
        if name == DRY and math.isfinite(noise):
            friction = friction_of(known, values, noise, today)
    least = tuple(least_shift(known[MIN_SHIFTS[name]], 100.0 * std[name] / known[name], count) for name in names)
    means = {other: float(np.mean([one[other] for one in today])) for other in today[0]}
    runs = HealthyRuns(known, Baseline({}, {}, count), weighed, doubt, friction, means)
    if friction is not None:
        of_these = friction.today(0.0, 0.0)
        std[DRY] = of_these.std * known[DRY] / math.sqrt(1.0 + 1.0 / count)
        shifts = dict(zip(names, least, strict=True))
        least = tuple(
            {**shifts, DRY: clipped(known[MIN_SHIFTS[DRY]], 100.0 * of_these.within(beyond(FALSE_ALARM)))}[name] for name in names
        )
    if search.identified is None:
        weighed = replace(weighed, min_shift_percent=least)
    healthy = {name: known[name] for name in std}
    # the rod position by itself tells hardly more of a machine than its data sheet
    alone = beside.signals == ("position_mm",)
    open_std = std_by_data_sheet(beside.known_repeats[0], bases[0]) if alone else dict.fromkeys(names, 0.0)
    baseline = Baseline(healthy, {name: math.hypot(one / math.sqrt(count), open_std[name]) for name, one in std.items()}, count, std)
    return replace(runs, baseline=baseline, search=weighed)
