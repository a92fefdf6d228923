"""The list of walks: which machine, what is hidden in it, how its wear differs from healthy, which files are given and which command comes first."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.hidden.catalogue import INSEPARABLE, LIBRARY, OUTSIDE, SEVERITIES, change
from benchmarks.hidden.machines import machine, measured, seed_of
from benchmarks.hidden.sealed import record_of
from benchmarks.loop import simulator
from benchmarks.machines import plants
from benchmarks.machines.trials import SIZES, actuator_of
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import reference_actuator
from ema_tools.data.motion_records import MotionRecord, write_motion_record
from ema_tools.data.records import write_record

# Shifts of CSJ and BLK as shares of the healthy value, all clearly above the smallest that is called a fault.
FAULTS: Sequence[Mapping[str, float]] = (
    {"csj": 0.12},
    {"csj": 0.4},
    {"csj": 1.2},
    {"csj": -0.3},
    {"blk": 0.3},
    {"blk": 0.6},
    {"blk": 1.2},
    {"csj": 0.3, "blk": 0.6},
    {"csj": 0.15, "blk": 1.0},
)
_BESIDE: Sequence[Mapping[str, float]] = ({"csj": 0.4}, {"blk": 0.6})  # beside an effect
_STRONG = ("medium", "large")
_OTHER_SIZES = {"medium": 1.0, "large": 2.5}
_FIRST = ("diagnose", "diagnose", "diagnose", "compare", "identify")
_BASELINE = 3
_FIRST_UNIT = 40
_PAIRS, _OTHER_PAIRS = 40, 20
_BALANCE_COMMANDS = ("sweeps", "pick and place")
_BALANCE_FRICTION = 0.3
# The golden ratio's fraction: its multiples fill an interval evenly, whatever their number.
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass(frozen=True)
class Truth:
    """What a machine has: names of hidden effects, and CSJ (Nm) and BLK (mm) healthy and today; None where no controller is known."""

    effects: tuple[str, ...]
    faults: Mapping[str, float]
    healthy: Mapping[str, float] | None
    today: Mapping[str, float] | None


@dataclass(frozen=True)
class Trial:
    """One walk. `plant`: truth, simulator or a kind of benchmarks.machines; `faults`: relative shifts of csj and blk; `baseline`: number of healthy records given."""

    number: int
    kind: str
    plant: str
    unit: int
    effects: tuple[str, ...] = ()
    size: str = ""
    faults: tuple[tuple[str, float], ...] = ()
    baseline: int = _BASELINE
    position_only: bool = False
    command: str = "chirp"

    @property
    def key(self) -> str:
        """Name of the walk, by which an interrupted run goes on."""
        hidden = " + ".join((*self.effects, *(f"{name} {100.0 * shift:+.0f} %" for name, shift in self.faults))) or "nothing"
        baseline = f"{self.baseline} baseline records" if self.baseline else "no baseline"
        return f"{self.number}: {self.kind}, {self.plant} {self.unit}, {self.command}: {hidden} {self.size}, {baseline}".replace(" ,", ",")

    @property
    def group(self) -> str:
        """File of its row."""
        return f"walk_{self.number:04d}"

    @property
    def by_balance(self) -> bool:
        """Whether the machine's controller is not known."""
        return self.kind == "balance"

    @property
    def first(self) -> str:
        """The command that begins the walk."""
        return "diagnose" if self.by_balance else _FIRST[seed_of("first", self.number) % len(_FIRST)]

    def prepare(self, folder: Path) -> tuple[list[str], Truth]:
        """Writes the files of the walk into `folder`; the arguments of the first command, and the truth."""
        if self.by_balance:
            return self._motion(folder)
        runs, truth = (_of_truth if self.plant == "truth" else _of_simulator)(self)
        channels = ("position_mm",) if self.position_only else None
        names = ["today.csv", *(f"healthy_{place}.csv" for place in range(1, len(runs)))]
        for name, run in zip(names, runs, strict=True):
            write_record(folder / name, record_of(run, 1, channels), digits=9)
        return ["ema", self.first, "reference", *_with_healthy(names[:1], names[1:])], truth

    def _motion(self, folder: Path) -> tuple[list[str], Truth]:
        size = SIZES[self.size] if self.size else 0.0
        hidden = {name: plants.EFFECTS[name] * size for name in self.effects}
        changed = {"friction": dict(self.faults)["csj"]} if self.faults else {}
        healthy: list[MotionRecord] = []
        for day in range(1, self.baseline + 1):
            healthy += plants.records_of_day(plants.Machine(self.plant, self.unit, {}), self.command, day)
        today = plants.records_of_day(plants.Machine(self.plant, self.unit, hidden, changed), self.command, 9)
        actuator_of(self.plant, self.unit).write(str(folder / "machine.toml"), False)
        names = [[f"{stem}_{place}.csv" for place in range(1, len(runs) + 1)] for stem, runs in (("today", today), ("healthy", healthy))]
        for name, run in zip(itertools.chain(*names), (*today, *healthy), strict=True):
            write_motion_record(folder / name, run)
        return ["ema", "diagnose", "machine.toml", *_with_healthy(*names)], Truth(self.effects, dict(self.faults), None, None)


def _with_healthy(records: Sequence[str], healthy: Sequence[str]) -> list[str]:
    return [*records, *(("--healthy", *healthy) if healthy else ())]


def _of_truth(trial: Trial) -> tuple[list[Recording], Truth]:
    unit, sheet = machine(trial.unit), reference_actuator()
    names = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}
    healthy = {name: unit.values.get(full, sheet[full]) for name, full in names.items()}
    today = {name: value * (1.0 + dict(trial.faults).get(name, 0.0)) for name, value in healthy.items()}
    values = {names[name]: today[name] for name, _ in trial.faults}
    for effect in trial.effects:
        values |= change(unit, effect, SEVERITIES[trial.size], trial.command).values
    runs = [measured(unit, values, trial.command, seed_of("walk", trial.number))]
    runs += [measured(unit, {}, trial.command, seed_of("walk", trial.number, day)) for day in range(trial.baseline)]
    return runs, Truth(trial.effects, dict(trial.faults), healthy, today)


def _of_simulator(trial: Trial) -> tuple[list[Recording], Truth]:
    names = {"csj": "csj_Nm", "blk": "blk_mm"}
    unit = simulator.unit_values(trial.unit)
    healthy = {name: unit[full] for name, full in names.items()}
    today = {name: value * (1.0 + dict(trial.faults).get(name, 0.0)) for name, value in healthy.items()}
    values = {names[name]: today[name] for name, _ in trial.faults}
    values |= {effect: simulator.EFFECTS[effect] * _OTHER_SIZES[trial.size] for effect in trial.effects}
    runs = [simulator.record(trial.unit, (trial.number, 99), values)]
    runs += [simulator.record(trial.unit, (trial.number, day), {}) for day in range(trial.baseline)]
    return runs, Truth(trial.effects, dict(trial.faults), healthy, today)


def _pairs(names: Sequence[str], count: int) -> list[tuple[str, ...]]:
    possible = [pair for pair in itertools.combinations(names, 2) if not any(set(pair) <= alike for alike in INSEPARABLE)]
    order = np.random.default_rng(2_718).permutation(len(possible))[:count].tolist()
    return [possible[place] for place in order]


def _rows() -> list[dict[str, object]]:
    """All walks but for their numbers and units, kind by kind."""
    library, outside = tuple(LIBRARY), tuple(OUTSIDE)
    other = tuple(name for name in simulator.EFFECTS if name not in simulator.OUTSIDE)
    effects = (("truth", library), ("simulator", other))
    either = (_BASELINE, 0)
    rows: list[dict[str, object]] = []

    def put(kind: str, plant: str, **values: object) -> None:
        rows.append({"kind": kind, "plant": plant, **values})

    for plant, names in effects:
        for name, size, baseline in itertools.product(names, _STRONG, either):
            put("effect", plant, effects=(name,), size=size, baseline=baseline)
    for plant, pairs in (("truth", _pairs(library, _PAIRS)), ("simulator", _pairs(other, _OTHER_PAIRS))):
        for place, pair in enumerate(pairs):
            put("pair", plant, effects=pair, size=_STRONG[place % 2], baseline=either[place % 4 == 3])
    for plant, names in effects:
        for place, (name, beside) in enumerate(itertools.product(names, _BESIDE)):
            put("effect and fault", plant, effects=(name,), size=_STRONG[place // 2 % 2], faults=beside, baseline=either[place % 3 == 2])
    for plant, faults, baseline in itertools.product(("truth", "simulator"), FAULTS, (*either, _BASELINE)):
        put("fault", plant, faults=faults, baseline=baseline)
    for plant, place in itertools.product(("truth", "simulator"), range(24)):
        put("nothing", plant, baseline=either[place % 3 == 2])
    for plant, strange in (("truth", outside), ("simulator", simulator.OUTSIDE)):
        for name, size, baseline in itertools.product(strange, _STRONG, either):
            put("outside the library", plant, effects=(name,), size=size, baseline=baseline)
    for name in library:
        put("position alone", "truth", effects=(name,), size="large", position_only=True)
    for plant, faults in itertools.product(("truth", "simulator"), (*FAULTS, {}, {}, {})):
        put("position alone", plant, faults=faults, position_only=True)
    for kind, command in itertools.product(plants.KINDS, _BALANCE_COMMANDS):
        shown = [name for name in plants.EFFECTS if plants.shows(kind, name, command)]
        for place, name in enumerate(shown):
            put("balance", kind, effects=(name,), size=tuple(SIZES)[place % 2], baseline=(0, 2)[place % 3 == 0], command=command)
        for baseline in (0, 2):
            put("balance", kind, baseline=baseline, command=command)
        put("balance", kind, faults={"csj": _BALANCE_FRICTION}, baseline=2, command=command)
    return rows


def trials(sample: int | None = None) -> list[Trial]:
    """All walks, or an even subset; a larger sample holds every smaller one."""
    found = []
    for number, row in enumerate(_rows()):
        faults = row.pop("faults", {})
        assert isinstance(faults, Mapping)
        unit = _FIRST_UNIT + number % 7
        found.append(Trial(number, unit=unit, faults=tuple(faults.items()), **row))  # type: ignore[arg-type]
    order = sorted(found, key=lambda trial: trial.number * _GOLDEN % 1.0)
    return order[:sample]
