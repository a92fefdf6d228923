"""The trials: units whose wear grows step by step, judged by the flight code and at the desk; and readings of the onboard search on many days of one machine, at the smallest shifts that are computed.

All records are of the truth plant, which shares no code with the module.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.hidden.machines import SCATTER, seed_of
from benchmarks.hidden.running import Job
from benchmarks.hidden.sealed import record_of
from benchmarks.truth.plant import Sensors, scattered, simulate_truth
from benchmarks.verdicts.trials import VerdictTrial, calibrated, known_by, perform
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.data.commands import make_command
from ema_tools.design.detection import Sight, sight_of
from ema_tools.design.runs import run_of
from ema_tools.fit.detection import Scatter, ShiftTest, scatter_by_search
from ema_tools.fit.nuisance import FROM_RUN_TO_RUN
from ema_tools.plant.native import SearchSettings
from ema_tools.tasks.onboard_search import MIN_SHIFTS, run

FAULTS: Mapping[str, str] = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}
# Shifts of the curves, in % of healthy; zero stands once, for both.
FLIGHT_SHIFTS: Mapping[str, Sequence[float]] = {
    "csj": (0.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 15.0),
    "blk": (4.0, 7.0, 9.0, 10.0, 11.0, 12.0, 13.0, 15.0, 20.0, 30.0),
}
DESK_SHIFTS: Mapping[str, Sequence[float]] = {"csj": (0.0, 4.0, 7.0, 12.0), "blk": (8.0, 14.0, 25.0)}
RUNS = (3, 5)
_FIRST_UNIT = 4_000
_NOISE_MM = 0.005
_CHIRP = "chirp:amplitude_mm=2,start_hz=0.1,end_hz=4,duration_s=10"
# Commands on which the computed shifts are held against readings: whether grease and winding are searched beside, and the command.
CONFIRMED: Sequence[tuple[bool, str]] = (
    (True, _CHIRP),
    (True, "chirp:amplitude_mm=2,start_hz=0.1,end_hz=5,duration_s=10"),
    (False, _CHIRP),
    (False, "triangle:amplitude_mm=2,start_hz=0.2,duration_s=10"),
)
WIDE = 4.0  # times the usual scatter
_TRUTH_STEP_S = 5e-5


@dataclass(frozen=True)
class Reading:
    """What the onboard search reads on one day of the reference machine. `worn`: the fault that has grown to the smallest shift that is found, none for a healthy day; `times`: how many times as much
    as usual the days scatter."""

    day_searched: bool
    command: str
    worn: str
    day: int
    times: float = 1.0

    @property
    def key(self) -> str:
        """A name by which an interrupted run is taken up again."""
        return "|".join(map(str, ("reading", self.day_searched, self.command, self.worn, self.day, self.times)))

    @property
    def group(self) -> str:
        """Readings of one kind."""
        return f"reading_{int(self.day_searched)}_{self.command.partition(':')[0]}_{seed_of(self.command)}_{self.worn or 'healthy'}_{self.times:g}"


@dataclass(frozen=True)
class Wear:
    """One verdict of the flight code, or of the desk, on a unit with one value shifted by `percent`."""

    kind: str
    unit: int
    healthy: int
    fault: str
    percent: float

    @property
    def trial(self) -> VerdictTrial:
        """The same as the benchmark of the verdicts has it."""
        wear = ((self.fault, self.percent / 100.0),) if self.percent else ()
        return VerdictTrial(self.kind, self.unit, "", "chirp", self.healthy, 0, wear)

    @property
    def key(self) -> str:
        """A name by which an interrupted run is taken up again."""
        return self.trial.key

    @property
    def group(self) -> str:
        """Verdicts on one unit."""
        return self.trial.group


def wears(kind: str, count: int) -> list[Wear]:
    """Every shift on each of so many units, with three or five healthy records by turns. `kind`: flight or unit."""
    shifts = FLIGHT_SHIFTS if kind == "flight" else DESK_SHIFTS
    return [
        Wear(kind, _FIRST_UNIT + place, RUNS[place // 2 % len(RUNS)], fault, percent)
        for place in range(count)
        for fault, percents in shifts.items()
        for percent in percents
    ]


def readings(days: int) -> list[Reading]:
    """So many healthy days, and as many with each fault, under each command; and healthy ones that scatter more, under the first."""
    usual = [Reading(searched, command, worn, day) for searched, command in CONFIRMED for worn in ("", *FAULTS) for day in range(days)]
    return [*usual, *(Reading(*CONFIRMED[0], "", day, WIDE) for day in range(days))]


def machine(day_searched: bool) -> Actuator:
    """The reference actuator with the sensor of the trials."""
    return reference_actuator().changed({"search.day_values": float(day_searched), "verdict.position_noise_mm": _NOISE_MM})


@lru_cache(maxsize=16)
def sight(day_searched: bool, command: str, runs: int) -> Sight:
    """What is computed of a command."""
    return sight_of(machine(day_searched), ShiftTest(runs=runs), command)


@lru_cache(maxsize=16)
def scatter(day_searched: bool, command: str) -> Scatter:
    """How the readings are computed to lie."""
    actuator = machine(day_searched)
    own = {value: 100.0 * FROM_RUN_TO_RUN.get(value, 0.0) for value in FAULTS.values()}
    return scatter_by_search(actuator, run_of(actuator, "", command).record, tuple(FAULTS.values()), _NOISE_MM, own, day_searched)


def work(job: Job) -> dict[str, Any]:
    """One trial as a row of plain values."""
    if isinstance(job, Reading):
        return _read(job)
    assert isinstance(job, Wear)
    return _judged(job)


def _read(job: Reading) -> dict[str, Any]:
    actuator = machine(job.day_searched)
    seed = seed_of("detection", job.key)
    # shifts of three runs are the larger ones; what five runs find is read off the same days, moved
    values = {FAULTS[job.worn]: actuator[FAULTS[job.worn]] * (1.0 + 0.01 * shift_of(job))} if job.worn else {}
    wide = {name: job.times * std for name, std in SCATTER.items()}
    day = scattered({**{name: actuator[name] for name in SCATTER}, **values}, wide, seed)
    command = make_command(job.command, actuator).samples_mm
    recorded = simulate_truth(day, command, step_s=_TRUTH_STEP_S, sensors=Sensors(position_noise_mm=_NOISE_MM), seed=seed + 1)
    answer = run(actuator, record_of(recorded, 0, ("position_mm",)), SearchSettings(), 32)
    found = {one.name: one.shift_percent for one in answer.identified}
    return {
        "key": job.key,
        "kind": "reading",
        "day_searched": job.day_searched,
        "command": job.command,
        "worn": job.worn,
        "times": job.times,
        "read": [found[value] for value in FAULTS.values()],
    }


def shift_of(job: Reading) -> float:
    """The shift of a worn day, %: the smallest that is computed to be found by the fewest healthy runs."""
    return sight(job.day_searched, job.command, RUNS[0]).onboard[job.worn].alone


def _judged(job: Wear) -> dict[str, Any]:
    row = perform(job.trial)
    found: dict[str, Any] = {
        "key": job.key,
        "kind": job.kind,
        "unit": job.unit,
        "healthy": job.healthy,
        "fault": job.fault,
        "percent": job.percent,
        "verdict": row["verdict"],
    }
    if job.kind == "flight":
        actuator = calibrated(known_by(job.trial))
        seen = sight_of(actuator, ShiftTest(runs=job.healthy), _CHIRP)
        found |= {
            "threshold": {name: actuator[MIN_SHIFTS[value]] for name, value in FAULTS.items()},
            "computed": dict(seen.verdict),
            "limit": {name: one.alone for name, one in seen.onboard.items()},
        }
    return found


def tested(
    read: Mapping[str, Reals], known: Scatter, runs: int, moves: Mapping[str, tuple[float, float]], draws: int
) -> dict[str, list[float]]:
    """Rates over `draws` of `runs` healthy readings and one more: false alarms and shares found of both single tests and of the test of both together.

    `read`: readings [days, 2] in %, healthy ones under "", worn ones by fault, which are moved by `moves` to the shift that the single test finds, and to the one that the test of both finds.
    """
    random = np.random.default_rng(seed_of("draws", runs))
    test = ShiftTest(runs=runs)
    limit, together = test.threshold(), test.threshold_together()
    inverse, usual = np.linalg.inv(known.whole), np.diag(known.whole)
    healthy = read[""]
    count = {name: [0, 0] for name in ("", *moves)}
    for _ in range(draws):
        places = random.permutation(len(healthy))[: runs + 1]
        known_runs, sound = healthy[places[:runs]], healthy[places[runs]]
        mean = known_runs.mean(axis=0)
        apart = known_runs - mean
        freedom = test.freedom
        shown = np.sqrt((2.0 * usual + np.sum(apart**2, axis=0)) / freedom)
        size = (2.0 * 2.0 + float(np.einsum("ij,jk,ik", apart, inverse, apart))) / (2.0 * freedom)
        for name in count:
            today = sound if not name else read[name][int(random.integers(len(read[name])))]
            first, second = (today - mean + move * _unit(name) for move in moves.get(name, (0.0, 0.0)))
            single = first / shown > limit
            count[name][0] += bool(np.any(single)) if not name else bool(single[list(FAULTS).index(name)])
            count[name][1] += bool(second @ inverse @ second / size > together**2)
    return {name: [one / draws, both / draws] for name, (one, both) in count.items()}


def _unit(name: str) -> Reals:
    return np.array([1.0 if name == fault else 0.0 for fault in FAULTS])
