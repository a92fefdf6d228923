"""The trials: units with standing errors on many days, judged against their own healthy runs; and records drawn at random over commands, signals, noise, temperature, drives and wear.

Units are of the truth plant, which shares no code with the module; what is drawn is of it and of machines of another build by turns. What is drawn hangs on the trial's number alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.hidden.machines import CHANNELS, COMMANDS, Machine, command_mm, machine, measured, seed_of
from benchmarks.hidden.sealed import record_of
from benchmarks.verdicts import two_mass
from ema_tools.base.errors import InputError
from ema_tools.base.recording import Recording
from ema_tools.data.actuator import Actuator, reference_actuator
from ema_tools.plant.native import SearchSettings
from ema_tools.results.codec import to_json
from ema_tools.tasks.calibrate import calibrate
from ema_tools.tasks.identify import identify
from ema_tools.tasks.onboard_search import run
from ema_tools.tasks.own_machine import own_machine
from ema_tools.words.answers.identification import identification

# Wear of a worn day, relative: the least that must be found, and more.
WORN: Sequence[Mapping[str, float]] = ({"csj": 0.2}, {"blk": 0.5}, {"csj": 0.4, "blk": 1.0})
_VALUE = {"csj": "screw.csj_Nm", "blk": "screw.blk_mm"}
_KEY = {"csj": "csj_Nm", "blk": "blk_mm"}
# Names of changes that the machine of two masses calls otherwise.
_OF_TWO_MASSES: Mapping[str, str] = {"inverter_dead_time.drop_V": "dead_V"}
_KEY_OF = {_VALUE[name]: key for name, key in _KEY.items()}
# What every second unit has besides the usual standing errors, healthy or not: effects in a form that the library does not have, slight as on machines that work.
STANDING_FORMS: Sequence[Mapping[str, float]] = (
    {},
    {"stribeck_gauss.rise": 0.05, "stribeck_gauss.speed_rad_s": 8.0},
    {},
    {"dead_time_tanh.drop_V": 0.05, "dead_time_tanh.width_A": 0.3},
    {},
    {"winding_warming.rise_degC_per_W": 1.0, "winding_warming.time_s": 5.0},
)
_FIRST_UNIT, _FIRST_DRAWN = 2_000, 3_000
# Shares of the healthy value from which on a wear is one, and up to which it is none: between them either answer serves.
_IS_WORN, _IS_SOUND = {"csj": 0.1, "blk": 0.2}, {"csj": 0.05, "blk": 0.1}
# A stated size is surely wrong that lies this far from the truth and half an interval outside of its own: three standard errors, where one in twenty misses two.
_FAR_OUTSIDE = 1.5
_SIZE_OFF = {"csj": 0.05, "blk": 0.15}
_SLOW = ("slow chirp", "triangle")
# What may differ on the day from when the unit was made known, each in one of four drawn records.
DISTURBANCES: Mapping[str, tuple[str, float]] = {
    "winding": ("motor.resistance_ohm", 0.2),
    "grease": ("screw.viscous_Nm_s_per_rad", 0.6),
    "supply": ("drive.supply_V", 0.1),
    "gain": ("control.kp_per_m", 0.05),
    "inverter": ("inverter_dead_time.drop_V", 0.6),
}
TRUTH_PLANT, TWO_MASSES = "truth plant", "two masses"
BUILDS = (TRUTH_PLANT, TWO_MASSES)
_LATE: Mapping[str, float] = {"stribeck_friction.rise": 0.2, "stribeck_friction.speed_rad_s": 10.0}


@dataclass(frozen=True)
class VerdictTrial:
    """One verdict on a machine of a `build`.

    `kind`: "unit" of `ema identify` beside healthy records, "drawn" the same of anything, "flight" of the flight code with the model that `ema calibrate` makes of
    the healthy records; `setting`: of the machines; `healthy`: records given; `wear`: by fault, relative; `disturbance`: what else differs today."""

    kind: str
    number: int
    setting: str
    command: str
    healthy: int
    day: int
    wear: tuple[tuple[str, float], ...] = ()
    disturbance: str = ""
    off: float = 0.0
    signals: tuple[str, ...] = CHANNELS
    build: str = TRUTH_PLANT

    @property
    def key(self) -> str:
        """A name by which an interrupted run is taken up again."""
        return "|".join(
            map(str, (self.kind, self.number, self.setting, self.command, self.healthy, self.day, self.wear, self.disturbance, self.build))
        )

    @property
    def group(self) -> str:
        """Trials of one unit, of which desk and flight code get the same records."""
        return f"{self.recorded.kind}_{self.number}_{self.setting}_{self.healthy}"

    @property
    def recorded(self) -> VerdictTrial:
        """The trial whose record this one gets."""
        return replace(self, kind="unit") if self.kind == "flight" else self

    @property
    def unit(self) -> Machine:
        """The machine, with what every second one has of an effect in another form."""
        own = machine(self.number, setting=self.setting)
        form = STANDING_FORMS[self.number % len(STANDING_FORMS)] if self.kind != "drawn" else {}
        return replace(own, values={**own.values, **form})

    @property
    def is_worn(self) -> bool:
        """Whether a healthy verdict would be wrong."""
        return any(share >= _IS_WORN[name] for name, share in self.wear)

    @property
    def is_sound(self) -> bool:
        """Whether a fault would be wrong."""
        return all(share <= _IS_SOUND[name] for name, share in self.wear)


def units(
    kind: str, count: int, days: int, healthy: Sequence[int] = (3, 5), settings: Sequence[str] = ("", "scatter")
) -> list[VerdictTrial]:
    """Of each unit `days` sound and as many worn days, by turns with each number of healthy records, in each setting. `kind`: unit or flight."""
    found = []
    for place in range(count):
        given = healthy[place // 2 % len(healthy)]
        for setting in settings:
            for day in range(days):
                common = VerdictTrial(kind, _FIRST_UNIT + place, setting, "chirp", given, day)
                found += [common, replace(common, wear=tuple(WORN[(place + day) % len(WORN)].items()))]
    return found


def drawn(count: int, first: int = 0) -> list[VerdictTrial]:
    """Records drawn at random: command, signals, noise, healthy records or none, wear or none, and what else differs that day."""
    found = []
    names = [*DISTURBANCES, "late"]
    for number in range(first, first + count):
        random = np.random.default_rng([7_927, number])
        kinds = [{}, {}, {"csj": float(random.uniform(0.1, 0.4))}, {"blk": float(random.uniform(0.2, 1.0))}]
        wear = kinds[int(random.integers(len(kinds)))]
        disturbance = names[int(random.integers(len(names)))] if random.random() < 0.6 else ""
        sign = -1.0 if random.random() < 0.5 and disturbance not in ("inverter", "late") else 1.0
        alone = random.random() < 0.4
        found.append(
            VerdictTrial(
                "drawn",
                _FIRST_DRAWN + number,
                str(random.choice(["", "coloured", "counts_20um"])),
                str(random.choice([*COMMANDS, *_SLOW])),
                int(random.choice([0, 0, 2, 3])),
                0,
                tuple(wear.items()),
                disturbance,
                sign * float(random.uniform(0.2, 1.0)),
                ("position_mm",) if alone else CHANNELS,
                BUILDS[number % len(BUILDS)],
            )
        )
    return found


def _changes(trial: VerdictTrial, values: Mapping[str, float]) -> dict[str, float]:
    """What differs today on a machine of these values."""
    found = {}
    for name, share in trial.wear:
        found[_VALUE[name]] = (1.0 + share) * values[_VALUE[name]]
    if trial.disturbance in DISTURBANCES:
        name, most = DISTURBANCES[trial.disturbance]
        size = trial.off * most
        found[name] = size if trial.disturbance == "inverter" else (1.0 + size) * values[name]
    return found


def _run_of(trial: VerdictTrial, changes: Mapping[str, float], seed: int) -> Recording:
    """One run on a day that hangs on the seed."""
    if trial.build == TRUTH_PLANT:
        return measured(trial.unit, changes, trial.command, seed)
    named = {_OF_TWO_MASSES.get(name, name): value for name, value in changes.items() if name not in _LATE}
    if _LATE.keys() & changes.keys():
        named |= {"late_rise": _LATE["stribeck_friction.rise"], "late_row": command_mm(trial.command).size // 2}
    return two_mass.measured(two_mass.unit(trial.number, trial.setting), named, command_mm(trial.command), seed)


@lru_cache(maxsize=4)
def _healthy(known: VerdictTrial) -> tuple[Recording, ...]:
    """The healthy runs of a machine: of a trial with nothing of today in it."""
    kind = "drawn" if known.kind == "drawn" else "unit"
    return tuple(_run_of(known, {}, seed_of("verdicts", kind, known.number, known.command, k)) for k in range(known.healthy))


def known_by(trial: VerdictTrial) -> VerdictTrial:
    """The trial that stands for what is known of its unit beforehand."""
    kind = "drawn" if trial.kind == "drawn" else "unit"
    return VerdictTrial(kind, trial.number, trial.setting, trial.command, trial.healthy, 0, build=trial.build)


@lru_cache(maxsize=16)
def _record(trial: VerdictTrial) -> Recording:
    seed = seed_of("verdicts", trial.key)
    if trial.build == TRUTH_PLANT:
        sheet = reference_actuator()
        differs = [*_VALUE.values(), *(name for name, _ in DISTURBANCES.values())]
        values = {name: sheet[name] for name in differs if name in sheet.values} | dict(trial.unit.values)
    else:
        values = dict(two_mass.unit(trial.number, trial.setting).sheet)
    changes = _changes(trial, values)
    if trial.disturbance != "late":
        return _run_of(trial, changes, seed)
    if trial.build == TWO_MASSES:
        return _run_of(trial, {**changes, **_LATE}, seed)
    run, after = _run_of(trial, changes, seed), _run_of(trial, {**changes, **_LATE}, seed)
    half = run.command_mm.size // 2
    return replace(run, **{name: np.concatenate([getattr(run, name)[:half], getattr(after, name)[half:]]) for name in CHANNELS})


@lru_cache(maxsize=4)
def calibrated(known: VerdictTrial) -> Actuator:
    """What `ema calibrate` makes of a unit's healthy records."""
    healthy = [record_of(one, place) for place, one in enumerate(_healthy(known))]
    base = calibrate(reference_actuator(), healthy).actuator
    own = own_machine(base, healthy)
    return own.actuator if own is not None else base


def _flown(trial: VerdictTrial) -> dict[str, Any]:
    """The flight code's own verdict, by the rod position alone."""
    actuator = calibrated(known_by(trial))
    answer = run(actuator, record_of(_record(trial.recorded), 99, ("position_mm",)), SearchSettings(), 32)
    found: dict[str, Any] = {"verdict": answer.verdict, "reasons": list(answer.reasons), "guard": None}
    for one in answer.identified:
        known = math.isfinite(one.half_95)
        ends = (one.estimate - one.half_95, one.estimate + one.half_95) if known else (None, None)
        found[_KEY_OF[one.name]] = {
            "estimate": one.estimate,
            "interval95": ends,
            "shift_percent": one.shift_percent,
            "healthy": actuator[one.name],
        }
    return found


def _identified(trial: VerdictTrial) -> dict[str, Any]:
    """What `ema identify ACTUATOR RECORD --healthy ... --json` writes."""
    healthy = [record_of(one, place, trial.signals) for place, one in enumerate(_healthy(known_by(trial)))]
    return to_json(identification(identify(reference_actuator(), record_of(_record(trial), 99, trial.signals), healthy), "record", {}))


def perform(trial: VerdictTrial) -> dict[str, Any]:
    """One trial as a row of plain values. The code under test gets the data sheet's actuator and records, as a user gives them, and the result that the user gets is read."""
    row: dict[str, Any] = {
        "key": trial.key,
        "kind": trial.kind,
        "build": trial.build,
        "setting": trial.setting,
        "command": trial.command,
        "healthy": trial.healthy,
        "alone": len(trial.signals) == 1,
        "wear": dict(trial.wear),
        "disturbance": trial.disturbance,
        "off": trial.off,
        "worn": trial.is_worn,
        "sound": trial.is_sound,
    }
    try:
        result = _flown(trial) if trial.kind == "flight" else _identified(trial)
    except InputError as error:
        return {**row, "verdict": "refused", "reasons": [str(error)], "sizes": {}, "wrong": ""}
    sizes = {name: _size(result[key], dict(trial.wear).get(name, 0.0)) for name, key in _KEY.items()}
    return {
        **row,
        "verdict": result["verdict"],
        "reasons": result["reasons"],
        "objection": result["guard"]["objection"] if result["guard"] else None,
        "sizes": sizes,
        "wrong": _wrong(trial, result["verdict"], sizes),
    }


def _size(one: Mapping[str, Any], share: float) -> dict[str, float | bool | None]:
    """Shift, half its interval, how far that reaches on the truth's side, and truth, in % of the healthy value; whether the interval holds the truth."""
    found, true = one["shift_percent"], 100.0 * share
    if one["interval95"][0] is None:
        return {"shift": found, "half": None, "side": None, "true": true, "held": None}
    # the interval lies about the estimate, and that about the shift, in the same unit
    lower, upper = (100.0 * end / one["healthy"] for end in one["interval95"])
    middle = 100.0 * one["estimate"] / one["healthy"]
    side = upper - middle if true > found else middle - lower
    return {"shift": found, "half": 0.5 * (upper - lower), "side": side, "true": true, "held": bool(abs(found - true) <= side)}


def _wrong(trial: VerdictTrial, verdict: str, sizes: Mapping[str, Mapping[str, Any]]) -> str:
    """In what a sure answer is surely wrong; empty where it is not."""
    if verdict == "healthy" and trial.is_worn:
        return "healthy on a worn unit"
    if verdict == "fault" and trial.is_sound:
        return "fault on a sound unit"
    if verdict == "fault":
        for name, one in sizes.items():
            off = abs(one["shift"] - one["true"])
            if one["side"] is not None and off > max(100.0 * _SIZE_OFF[name], _FAR_OUTSIDE * one["side"]):
                return f"size of {name}"
    return ""
