"""A unit's own model from its healthy runs: what is more than base values in it.

Two or more runs of one command show what a machine always has: effects that its data sheet does not know, and how far its readings differ from run to run. The effects are put into the model
where they are worth their cost; the thresholds of the verdict follow the scatter of what the onboard search reads of these very runs. With both, the flight code counts against the unit
and not against its data sheet.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record, simulated
from ema_tools.fit.detection import FALSE_ALARM, ShiftTest, beyond, false_alarms, rate_text, unseen_by_search
from ema_tools.fit.interval import scatter_of
from ema_tools.fit.nuisance import share_from_run_to_run
from ema_tools.fit.shared_noise import shared_noise
from ema_tools.fit.temperature import Foretold, HealthyFriction
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import Identification, SearchSettings, library
from ema_tools.select.baseline import gather
from ema_tools.select.healthy_groups import state_doubt
from ema_tools.select.known_machine import Compared, live, repeats_of
from ema_tools.tasks.calibrate import Calibration, FittedParameter, channel_errors
from ema_tools.tasks.healthy_runs import DRY, clipped, friction_of, least_shift, scatter_read, thermometers
from ema_tools.tasks.onboard_search import (
    APART_DEGC,
    COMMAND_SPEED,
    DAY_SCATTER,
    DAY_VALUES,
    LAW,
    MIN_SHIFTS,
    PER_DEGC,
    PER_DEGC_STD,
    POSITION_NOISE,
    SCATTERS,
    SHARED_NOISE,
    STRUCTURE,
    UNSEEN,
    WINDING_SHARE,
    check_bounds,
    check_kept,
    identified_of,
    run,
)

_TIMED_RUNS = 5  # of which the shortest counts [effort]
_DAY_BUDGET = 800.0  # model runs of a search for four values, which takes about 300 [effort]
_DETERMINED = 0.1  # of a value: a larger standard error, and it is better left where it is [judgement]
_BUDGET = "search.evaluation_budget"


@dataclass(frozen=True)
class OwnMachine:
    """The unit's model.

    `standing`: effects that it always has, with how many times a model step costs with each what it costs without any; `scatter_percent`: of the readings from run to run, standard deviations
    by name; `least_percent`: the shifts that are called a fault, `exceeded`: by what share of the ground tests of a healthy unit, `found_percent`: from which shift on the onboard module calls
    a fault one with POWER; `unseen_percent`: how far a reading may be off for what the rod position does not show under this command, where that is more than a threshold; `doubt`: why two
    records may not both be healthy, in words.
    """

    actuator: Actuator
    standing: Mapping[str, float]
    scatter_percent: Mapping[str, float]
    least_percent: Mapping[str, float]
    exceeded: Mapping[str, float]
    found_percent: Mapping[str, float]
    unseen_percent: Mapping[str, float]
    records: int
    doubt: str = ""

    @property
    def per_degC_percent(self) -> float | None:
        """What a degree more makes of dry friction; None where the rod position does not tell the day's temperature."""
        return self.actuator[PER_DEGC] if self.actuator[APART_DEGC] > 0.0 else None

    @property
    def per_degC_std_percent(self) -> float | None:
        """The standard error of that."""
        return None if self.per_degC_percent is None else self.actuator[PER_DEGC_STD]


def repeated(records: Sequence[Record]) -> tuple[Record, ...]:
    """The records of that command which most of them run; none where no two run the same."""
    return max((repeats_of(one, records) for one in records), key=len, default=())


def own_machine(
    actuator: Actuator, records: Sequence[Record], report: Report | None = None, false_alarm: float | None = None
) -> OwnMachine | None:
    """The unit's model from healthy runs of one command, beginning at a calibrated `actuator`; None where no two of the records run the same command.

    `false_alarm`: the rate that its thresholds are to have; unless told they are those that the actuator states, larger where a healthy unit would exceed them.
    Raises InputError as `gather` does, and where the search cannot begin at what was found.
    """
    repeats = repeated(records)
    if not repeats or not identified_of(actuator):
        return None
    signals = live(*repeats)
    evidence = gather(actuator, repeats[0], repeats, signals, report)
    doubt = state_doubt(evidence, repeats)
    found = evidence.actuator if set(evidence.actuator.active_effects) - set(actuator.active_effects) else actuator
    check_kept(actuator, found, repeats[0].file)
    # what an earlier calibration knew of the days is learned anew
    read = _readings(_with_noise(found.changed({name: row_of(name).nominal for name in LAW}, actuator.about), repeats), repeats)
    found, runs = read.machine, len(repeats)
    known = Compared(evidence, repeats, signals)
    spread = _spread(read, thermometers(known, [one.base({}) for one in known.known_repeats]))
    least, unseen = _thresholds(read, spread, false_alarm)
    exceeded = {
        name: spread.foretold[name].beyond(0.01 * one)
        if name in spread.foretold
        else false_alarms(one / (100.0 * spread.scatter[name]), runs, 1)
        for name, one in least.items()
    }
    # less than a threshold makes no sound unit a faulty one
    most = max(unseen[name] / one for name, one in least.items())
    hidden = most if most > 1.0 else 0.0
    apart = {name: 100.0 * _apart(found, name, spread.scatter[name], spread.noise[name], runs) for name in read.names}
    sure, missed = found["verdict.confidence_std"], ShiftTest(runs=runs).missed()
    certain = {name: 100.0 * (sure * spread.noise[name] + missed * spread.scatter[name]) for name in read.names}
    new = sorted(set(found.active_effects) - set(actuator.active_effects))
    return OwnMachine(
        found.changed(
            {
                COMMAND_SPEED: float(np.mean([np.mean(np.abs(np.diff(one.command_mm))) / one.period_s for one in repeats])),
                UNSEEN: 100.0 * hidden,
                **{MIN_SHIFTS[name]: one for name, one in least.items()},
                **{SCATTERS[name]: one for name, one in apart.items()},
                **spread.law,
            },
            remarks={MIN_SHIFTS[name]: _remark(MIN_SHIFTS[name], exceeded[name], runs) for name in read.names},
        ),
        {name: _cost(found, name, repeats[0]) for name in new},
        {name: 100.0 * one for name, one in spread.scatter.items()},
        least,
        exceeded,
        {name: max(one, sure * apart[name]) + one * hidden + certain[name] for name, one in least.items()},
        unseen if hidden else {},
        runs,
        doubt,
    )


@dataclass(frozen=True)
class _Readings:
    """What the onboard search reads of each healthy run. `machine`: the model with the means of it; `own_scatter`: what is usual or stated of each value, one standard deviation in its unit."""

    machine: Actuator
    repeats: tuple[Record, ...]
    answers: list[Identification]
    own_scatter: Mapping[str, float]

    @property
    def names(self) -> tuple[str, ...]:
        """The values that are identified."""
        return identified_of(self.machine)

    @property
    def today(self) -> list[dict[str, float]]:
        """The values of the day of each run, by name."""
        return [{one.name: one.estimate for one in answer.day} for answer in self.answers]


@dataclass(frozen=True)
class _Spread:
    """How far the readings of a sound unit lie apart: `scatter` and the `noise` in it, shares by name; `foretold`: what dry friction should be on any day; `law`: what the module states of that."""

    scatter: Mapping[str, float]
    noise: Mapping[str, float]
    foretold: Mapping[str, Foretold]
    law: Mapping[str, float]


def _with_noise(found: Actuator, repeats: Sequence[Record]) -> Actuator:
    """With as much noise in the rod position as the runs show."""
    left = np.array([one.position_mm - simulated(found, one).position_mm for one in repeats])
    noisy = found.changed({POSITION_NOISE: max(found[POSITION_NOISE], float(np.max(np.sqrt(np.mean(left**2, axis=1)))))})
    check_bounds(noisy)
    return noisy


def _readings(found: Actuator, repeats: tuple[Record, ...]) -> _Readings:
    """Reads the runs as the onboard search does, and puts what it reads in the mean into the model."""
    names = identified_of(found)
    usual = scatter_of(found, repeats[0], names, {"position_mm": 1.0})
    machine, answers = _searched(found, repeats)
    by_run = [{one.name: one.estimate for one in (*answer.identified, *answer.day)} for answer in answers]
    read_so = [simulated(machine.changed(values), run_).position_mm for values, run_ in zip(by_run, repeats, strict=True)]
    rest = np.array([one.position_mm for one in repeats]) - np.array(read_so)
    shared_mm = shared_noise(rest - rest.mean(axis=0)) * math.sqrt(len(rest) / (len(rest) - 1.0))
    machine = machine.changed({SHARED_NOISE: max(machine[SHARED_NOISE], shared_mm)})
    # what the onboard search reads wrongly of a unit, it reads wrongly of its healthy runs as well
    machine = machine.changed({name: float(np.mean([values[name] for values in by_run])) for name in by_run[0]})
    own_scatter = {name: share_from_run_to_run(machine, name) * machine[name] for name in names} if answers[0].day else usual
    return _Readings(machine, repeats, answers, own_scatter)


def _spread(read: _Readings, warmth: Sequence[Mapping[str, float]]) -> _Spread:
    """How far the readings lie apart. `warmth`: values of the day of each run as all its signals say. Raises InputError where a value is not determined."""
    scatter: dict[str, float] = {}
    noises: dict[str, float] = {}
    foretold: dict[str, Foretold] = {}
    law: dict[str, float] = {}
    for place, name in enumerate(read.names):
        estimates = [answer.identified[place].estimate for answer in read.answers]
        noise = float(np.mean([answer.identified[place].std for answer in read.answers]))
        if not math.isfinite(noise):
            raise InputError(
                f"{read.repeats[0].file}: {name}: the onboard search does not determine it on these runs: record a longer or faster command"
            )
        healthy = read.machine[name]
        noises[name] = noise / healthy
        stated_or_usual = math.hypot(read.own_scatter.get(name, 0.0), noise)
        scatter[name] = scatter_read(read.machine, name, estimates, read.today, stated_or_usual) / healthy
        if name == DRY:
            # the module reads winding and grease by itself where they are searched; else nobody tells it what the day is like
            friction = friction_of(read.machine, estimates, noise, read.today)
            is_told = friction is not None and abs(100.0 * friction.law.per_degC) <= row_of(PER_DEGC).upper
            if not is_told:
                friction = friction_of(read.machine, estimates, noise, warmth)
            if friction is not None:
                foretold[name] = friction.any_told_day() if is_told else friction.any_day()
                scatter[name] = foretold[name].std / ShiftTest(runs=len(read.repeats)).spread()
                law = _law(friction, noises[name]) if is_told else {}
    return _Spread(scatter, noises, foretold, law)


def _thresholds(read: _Readings, spread: _Spread, false_alarm: float | None) -> tuple[dict[str, float], dict[str, float]]:
    """The shifts that are called a fault, and how far a reading may be off for what the rod position does not show, in %, by name."""
    found, first = read.machine, read.repeats[0]
    least = {
        name: least_shift(found[MIN_SHIFTS[name]], 100.0 * spread.scatter[name], len(read.repeats), false_alarm) for name in read.names
    }
    for name, one in spread.foretold.items():
        wanted = 100.0 * one.within(beyond(FALSE_ALARM if false_alarm is None else false_alarm))
        least[name] = clipped(found[MIN_SHIFTS[name]], wanted) if false_alarm is None else wanted
    shown_mm = math.hypot(found[STRUCTURE] * found[POSITION_NOISE], found[SHARED_NOISE])
    unseen = dict(zip(read.names, unseen_by_search(found, first, read.names, shown_mm, found[DAY_VALUES] != 0.0).tolist(), strict=True))
    if false_alarm is None:
        # what is not shown makes no sound unit a faulty one
        least = {name: max(one, clipped(found[MIN_SHIFTS[name]], unseen[name])) for name, one in least.items()}
    return least, unseen


def _apart(found: Actuator, name: str, scatter: float, noise: float, runs: int) -> float:
    """How far a sound unit is read off its model beside the sensor noise, of which the session counts its own: standard deviation of a share, by the `scatter` of readings."""
    is_known = name in found.scatter or share_from_run_to_run(found, name) == 0.0
    # runs that lie nearer together than the noise allows do so by chance
    return math.sqrt((ShiftTest(runs=runs).spread(is_known) * max(scatter, noise)) ** 2 - noise**2)


def _law(friction: HealthyFriction, noise: float) -> dict[str, float]:
    """What the module states of friction's scatter, on any day and beside what it makes of the day's temperature; by name. `noise`: relative, which the session counts itself."""

    def beside_noise(std: float) -> float:
        return 100.0 * math.sqrt(max(std**2 - noise**2, 0.0))

    law = friction.law
    return {
        SCATTERS[DRY]: beside_noise(friction.any_day().std),
        DAY_SCATTER: beside_noise(law.std),
        PER_DEGC: 100.0 * law.per_degC,
        PER_DEGC_STD: 100.0 * law.per_degC_std,
        WINDING_SHARE: law.winding_share,
        APART_DEGC: min(law.apart_degC, row_of(APART_DEGC).upper),
    }


def _remark(name: str, exceeded: float, runs: int) -> str:
    """What stands behind a threshold in the unit's file."""
    row = row_of(name)
    return f"{row.text}; by its {runs} healthy runs a healthy unit exceeds it in {rate_text(exceeded)} of ground tests [{row.unit}]"


def _searched(found: Actuator, repeats: Sequence[Record]) -> tuple[Actuator, list[Identification]]:
    """What the onboard search reads of each run; with grease and winding beside CSJ and BLK where all the runs determine them."""
    day = found.changed({DAY_VALUES: 1.0, _BUDGET: max(found[_BUDGET], _DAY_BUDGET)})
    machine, answers = found, []
    for machine in (day, found.changed({DAY_VALUES: 0.0})):
        answers = each(partial(_read, machine), repeats)
        stds = [one.std / machine[one.name] for answer in answers for one in (*answer.identified, *answer.day)]
        if all(math.isfinite(std) and std < _DETERMINED for std in stds):
            break
    return machine, answers


def _read(machine: Actuator, record: Record) -> Identification:
    return run(machine, record, SearchSettings(), 32)


def _cost(actuator: Actuator, effect: str, record: Record) -> float:
    """How many times as long the model's runs take on this machine with the effect alone as with none."""
    bare = actuator.changed({f"effects.{size}": zero for _, size, zero in load_definitions().sizes})
    own = {f"effects.{value.name}": actuator[value.name] for value in load_definitions().effect(effect).parameters}

    def took(machine: Actuator) -> float:
        values, options = machine.arrays()
        begun = []
        for _ in range(_TIMED_RUNS):
            start = time.perf_counter()
            library(32).simulate(values, options, record.command_mm, float(record.command_mm[0]))
            begun.append(time.perf_counter() - start)
        return min(begun)

    return took(bare.changed(own)) / took(bare)


def of_own_machine(found: Calibration, own: OwnMachine, records: Sequence[Record]) -> Calibration:
    """The calibration with the unit's model in the place of the base values alone."""

    def of_unit(one: FittedParameter) -> FittedParameter:
        after = own.actuator[one.name]
        if one.name not in own.scatter_percent:
            return replace(one, after=after)
        std = 0.01 * own.scatter_percent[one.name] * after / math.sqrt(own.records)
        return replace(one, after=after, std=std, source="search")

    parameters = tuple(map(of_unit, found.parameters))
    return replace(found, actuator=own.actuator, parameters=parameters, errors_after=channel_errors(own.actuator, records))
