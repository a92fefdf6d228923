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
    found = found.changed({APART_DEGC: 0.0}, actuator.about)
    left = np.array([one.position_mm - simulated(found, one).position_mm for one in repeats])
    noise_mm = max(found[POSITION_NOISE], float(np.max(np.sqrt(np.mean(left**2, axis=1)))))
    found = found.changed({POSITION_NOISE: noise_mm})
    check_bounds(found)
    names = identified_of(found)
    usual = scatter_of(found, repeats[0], names, {"position_mm": 1.0})
    found, answers = _searched(found, repeats)
    by_run = [{one.name: one.estimate for one in (*answer.identified, *answer.day)} for answer in answers]
    read_so = [simulated(found.changed(values), run_).position_mm for values, run_ in zip(by_run, repeats, strict=True)]
    rest = np.array([one.position_mm for one in repeats]) - np.array(read_so)
    shared_mm = shared_noise(rest - rest.mean(axis=0)) * math.sqrt(len(rest) / (len(rest) - 1.0))
    found = found.changed({SHARED_NOISE: max(found[SHARED_NOISE], shared_mm)})
    # what the onboard search reads wrongly of a unit, it reads wrongly of its healthy runs as well
    found = found.changed({name: float(np.mean([values[name] for values in by_run])) for name in by_run[0]})
    own_scatter = {name: share_from_run_to_run(found, name) * found[name] for name in names} if answers[0].day else usual
    today = [{one.name: one.estimate for one in answer.day} for answer in answers]
    known = Compared(evidence, repeats, signals)
    warmth = thermometers(known, [one.base({}) for one in known.known_repeats])
    foretold: dict[str, Foretold] = {}
    scatter: dict[str, float] = {}
    by_noise: dict[str, float] = {}
    law: dict[str, float] = {}
    for place, name in enumerate(names):
        read = [answer.identified[place] for answer in answers]
        noise = float(np.mean([one.std for one in read]))
        if not math.isfinite(noise):
            raise InputError(
                f"{repeats[0].file}: {name}: the onboard search does not determine it on these runs: record a longer or faster command"
            )
        by_noise[name] = noise / found[name]
        stated_or_usual = math.hypot(own_scatter.get(name, 0.0), noise)
        scatter[name] = scatter_read(found, name, [one.estimate for one in read], today, stated_or_usual) / found[name]
        if name == DRY:
            # the module reads winding and grease by itself where they are searched; else nobody tells it what the day is like
            friction = friction_of(found, [one.estimate for one in read], noise, today)
            is_told = friction is not None and abs(100.0 * friction.law.per_degC) <= row_of(PER_DEGC).upper
            if not is_told:
                friction = friction_of(found, [one.estimate for one in read], noise, warmth)
            if friction is not None:
                foretold[name] = friction.any_told_day() if is_told else friction.any_day()
                scatter[name] = foretold[name].std / ShiftTest(runs=len(repeats)).spread()
                law = _law(friction, by_noise[name]) if is_told else {}
    runs = len(repeats)
    apart = {name: 100.0 * _apart(found, name, scatter[name], by_noise[name], runs) for name in names}
    stated = {SCATTERS[name]: value for name, value in apart.items()} | law
    asked = float(np.mean([np.mean(np.abs(np.diff(one.command_mm))) / one.period_s for one in repeats]))
    least = {name: least_shift(found[MIN_SHIFTS[name]], 100.0 * scatter[name], runs, false_alarm) for name in names}
    for name, one in foretold.items():
        wanted = 100.0 * one.within(beyond(FALSE_ALARM if false_alarm is None else false_alarm))
        least[name] = clipped(found[MIN_SHIFTS[name]], wanted) if false_alarm is None else wanted
    shown_mm = math.hypot(found[STRUCTURE] * found[POSITION_NOISE], found[SHARED_NOISE])
    unseen = dict(zip(names, unseen_by_search(found, repeats[0], names, shown_mm, found[DAY_VALUES] != 0.0).tolist(), strict=True))
    if false_alarm is None:
        # what is not shown makes no sound unit a faulty one
        least = {name: max(one, clipped(found[MIN_SHIFTS[name]], unseen[name])) for name, one in least.items()}
    exceeded = {
        name: foretold[name].beyond(0.01 * least[name])
        if name in foretold
        else false_alarms(least[name] / (100.0 * scatter[name]), runs, 1)
        for name in names
    }
    test = ShiftTest(runs=runs)
    thresholds = max(unseen[name] / least[name] for name in names)
    sure = found["verdict.confidence_std"]
    certain = {name: sure * by_noise[name] + test.missed() * scatter[name] for name in names}
    new = sorted(set(found.active_effects) - set(actuator.active_effects))
    return OwnMachine(
        found.changed(
            {
                COMMAND_SPEED: asked,
                # less than a threshold makes no sound unit a faulty one
                UNSEEN: 100.0 * thresholds if thresholds > 1.0 else 0.0,
                **{MIN_SHIFTS[name]: value for name, value in least.items()},
                **stated,
            },
            remarks={MIN_SHIFTS[name]: _remark(MIN_SHIFTS[name], exceeded[name], runs) for name in names},
        ),
        {name: _cost(found, name, repeats[0]) for name in new},
        {name: 100.0 * value for name, value in scatter.items()},
        least,
        exceeded,
        {
            name: max(least[name], sure * apart[name]) + least[name] * (thresholds if thresholds > 1.0 else 0.0) + 100.0 * certain[name]
            for name in names
        },
        unseen if thresholds > 1.0 else {},
        runs,
        doubt,
    )


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
