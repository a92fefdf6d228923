"""The trials: what is hidden in which machine under which command, and one trial from its records to a row of figures."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from benchmarks.hidden import observer, sealed
from benchmarks.hidden.catalogue import FAULTS, FORMS, INSEPARABLE, LIBRARY, OUTSIDE, SEVERITIES, Change, change
from benchmarks.hidden.machines import CHANNELS, HELD_OUT, SETTINGS, Machine, machine, measured, seed_of
from ema_tools.base.recording import Recording

# Kinds of trial whose machines are set otherwise, by the name of the setting.
SET = tuple(filter(None, SETTINGS))
# Trials that run by themselves on all cores, with nothing remembered, as a user's diagnosis does: against repeats, without, with the rod position alone.
TIMED = ("time", "time_alone", "time_position")
KINDS = ("library", "fault", "outside", "healthy", "stranger", "pair", "position", "alone", "same", "placebo", "form", *SET, *TIMED)
OTHER_COMMANDS = ("fast chirp", "slow chirp", "multisine", "triangle")
# A placebo deals the record's difference from the repeats anew, in pieces of so many rows with random signs.
_PIECE_ROWS = 250
# Strangers are machines of which nothing else is asked.
_FIRST_STRANGER = 600
# Healthy records of one machine and command.
_DAYS = 20
# Of one machine of a setting.
_SET_DAYS = 4
# Where the voltage is recorded at the motor, what makes it another than the one asked for, and what it tells from that.
_ELECTRICAL = (
    "inverter_dead_time",
    "source_resistance",
    "supply_sag",
    "actuation_delay",
    "current_limit",
    "winding_heating",
    "magnet_weakening",
    "torque_ripple",
)
# How near its true size what a unit has by itself must be told.
_OF_ITS_SIZE = 0.25
# Settings that differ from what the search assumes of a data sheet, which counts most where there are no repeats.
_PRIORS = ("twice", "half")


@dataclass(frozen=True)
class Trial:
    """One trial. `kind`: of KINDS; `effects`: what is hidden; `machine`: number of the unit; `repeats`: healthy records given, 0 for none; `day` tells runs apart that are alike else."""

    kind: str
    effects: tuple[str, ...]
    severity: str
    command: str
    machine: int
    repeats: int = 5
    day: int = 0
    held_out: bool = False

    @property
    def key(self) -> str:
        """A name by which an interrupted run is taken up again."""
        return "|".join(
            (self.kind, "+".join(self.effects), self.severity, self.command, str(self.machine), str(self.repeats), str(self.day))
        )

    @property
    def group(self) -> str:
        """Trials of one machine and command."""
        own = self.kind == "same"
        return f"machine_{self.machine}_{self.command.replace(' ', '_')}_{own:d}{self.setting and '_' + self.setting}"

    @property
    def setting(self) -> str:
        """How its machine is set, of SETTINGS."""
        return self.kind if self.kind in SET else ""

    @property
    def unit(self) -> Machine:
        """The machine."""
        return machine(self.machine, self.kind == "same", self.setting)

    @property
    def channels(self) -> tuple[str, ...] | None:
        """The signals given; None for all."""
        return ("position_mm",) if self.kind in ("position", "time_position") else None


def _pairs(count: int, numbers: Sequence[int], severities: Sequence[str], command: str, names: Sequence[str], repeats: int) -> list[Trial]:
    possible = [pair for pair in itertools.combinations(names, 2) if not any(set(pair) <= kind for kind in INSEPARABLE)]
    drawn: Sequence[int] = np.random.default_rng(4_711).permutation(len(possible))[:count].tolist() if possible else []
    places = enumerate(possible[k] for k in drawn)
    return [
        Trial("pair", pair, severities[place % len(severities)], command, numbers[place % len(numbers)], repeats) for place, pair in places
    ]


def _command_of(place: int) -> str:
    """Of the healthy machines every third runs another command than the first."""
    return "chirp" if place % 3 != 2 else OTHER_COMMANDS[place // 3 % len(OTHER_COMMANDS)]


@dataclass(frozen=True)
class Plan:
    """How many trials of what: `strangers` healthy machines known by their data sheet alone; `seeds` machines for each effect and severity, every third under another command;
    the others by their counts. Other forms of effects are hidden in `seeds` machines each, at medium and large; every setting of machines gets every effect once at each of those severities,
    on `seeds` machines in turn, and `seeds` times `set_healthy` healthy records, few of any machine.

    `timed`: trials of each kind of TIMED.
    """

    seeds: int
    severities: tuple[str, ...] = tuple(SEVERITIES)
    effects: tuple[str, ...] = ()
    kinds: tuple[str, ...] = KINDS
    healthy: int = 200
    strangers: int = 100
    pairs: int = 40
    outside_seeds: int = 2
    repeats: int = 5
    timed: int = 3
    first_machine: int = 1
    set_healthy: int = 17

    def trials(self) -> list[Trial]:
        """All of them."""
        wanted = self.effects or (*LIBRARY, *FAULTS, *OUTSIDE, *FORMS)
        library, faults, outside, forms = ([name for name in table if name in wanted] for table in (LIBRARY, FAULTS, OUTSIDE, FORMS))
        numbers = range(self.first_machine, self.first_machine + self.seeds)
        strong = [name for name in self.severities if SEVERITIES[name] >= 1.0]
        found: list[Trial] = []
        for place, number in enumerate(numbers):
            for order, name in enumerate(library):
                command = "chirp" if place % 3 != 2 else OTHER_COMMANDS[(order + place) % len(OTHER_COMMANDS)]
                found += [
                    Trial("library", (name,), severity, command, number, self.repeats, held_out=severity in strong)
                    for severity in self.severities
                ]
                if place < 2:
                    found += [
                        Trial("position", (name,), severity, "chirp", number, self.repeats) for severity in strong if severity == "medium"
                    ]
                    found += [Trial("alone", (name,), severity, "chirp", number, 0) for severity in strong]
            found += [Trial("fault", (name,), severity, "chirp", number, self.repeats) for name in faults for severity in self.severities]
        first = numbers[0] if len(numbers) else self.first_machine
        found += [Trial("same", (name,), severity, "chirp", first, self.repeats) for name in library for severity in self.severities]
        found += [Trial("placebo", (name,), severity, "chirp", first, self.repeats) for name in library for severity in strong[:1]]
        for number in range(self.first_machine, self.first_machine + self.outside_seeds):
            found += [Trial("outside", (name,), severity, "chirp", number, self.repeats) for name in outside for severity in strong]
        if strong and numbers:
            found += _pairs(self.pairs, numbers, strong, "chirp", library, self.repeats)
        for count in range(self.healthy):
            place, day = divmod(count, _DAYS)
            found.append(Trial("healthy", (), "", _command_of(place), self.first_machine + place, self.repeats, day))
        for place in range(self.strangers):
            found.append(Trial("stranger", (), "", _command_of(place), self.first_machine + _FIRST_STRANGER + place, 0))
        for number in numbers:
            found += [Trial("form", (name,), severity, "chirp", number, self.repeats) for name in forms for severity in strong]
        for setting in SET:
            found += self._set(setting, library, numbers, strong)
        for kind in TIMED:
            repeats = 0 if kind == "time_alone" else self.repeats
            found += [Trial(kind, (name,), strong[0], "chirp", first, repeats) for name in library[: self.timed] if strong]
        return [trial for trial in found if trial.kind in self.kinds]

    def _set(self, setting: str, library: Sequence[str], numbers: Sequence[int], strong: Sequence[str]) -> list[Trial]:
        """The trials of one setting, those of one that defies a data sheet without repeats too."""
        names = [name for name in library if name in _ELECTRICAL] if setting == "terminals" else library
        found = []
        for repeats in (self.repeats, 0) if setting in _PRIORS else (self.repeats,):
            places = enumerate(names) if numbers else ()
            found += [
                Trial(setting, (name,), severity, "chirp", numbers[order % len(numbers)], repeats)
                for order, name in places
                for severity in strong
            ]
            # a machine without repeats is another stranger every time, and one whose few repeats lie closer than its days would be accused of each of them
            found += [
                Trial(
                    setting,
                    (),
                    "",
                    "chirp",
                    number + (len(numbers) * (day // _SET_DAYS) if repeats else _FIRST_STRANGER + 100 * day),
                    repeats,
                    day,
                )
                for number in numbers
                for day in range(self.set_healthy)
            ]
        return found


# What the document is meant to show.
FULL = Plan(3)


def hidden_changes(unit: Machine, trial: Trial, command: str) -> list[Change]:
    """What is hidden, effect by effect."""
    return [change(unit, effect, SEVERITIES[trial.severity], command) for effect in trial.effects]


def runs(trial: Trial, command: str, hidden: Sequence[Change]) -> tuple[Recording, list[Recording]]:
    """The record with what is hidden, and the healthy repeats, all of different days."""
    unit = trial.unit
    values = {name: value for one in hidden for name, value in one.values.items()}
    return measured(unit, values, command, seed_of(trial.key, command)), list(
        _repeats(unit.number, unit.own, command, trial.repeats, unit.setting)
    )


@lru_cache(maxsize=4)
def _repeats(number: int, own: bool, command: str, count: int, setting: str = "") -> tuple[Recording, ...]:
    """The healthy runs of a machine, the same for all its trials."""
    unit = machine(number, own, setting)
    return tuple(measured(unit, {}, command, seed_of("healthy", number, own, command, k)) for k in range(count))


def _dealt(run: Recording, healthy: Sequence[Recording], seed: int) -> Recording:
    """The placebo: differences of the same size in every signal, which no effect makes."""
    random = np.random.default_rng(seed)
    pieces = run.command_mm.size // _PIECE_ROWS
    order = random.permutation(pieces)
    signs = random.choice([-1.0, 1.0], size=pieces)
    changed = {}
    for channel in CHANNELS:
        mean = np.mean([getattr(other, channel) for other in healthy], axis=0)
        dealt = (getattr(run, channel) - mean)[: pieces * _PIECE_ROWS].reshape(pieces, _PIECE_ROWS)[order] * signs[:, None]
        changed[channel] = mean + np.pad(dealt.ravel(), (0, mean.size - dealt.size))
    return Recording(**{**{name: getattr(run, name) for name in run.__dataclass_fields__}, **changed})


def _sizes(answer: sealed.SealedAnswer, hidden: Sequence[Change], effects: Sequence[str]) -> list[dict[str, Any]]:
    """Per hidden effect that was accepted by its own name: true change of its size, estimate, its standard error, whether the 95 % interval holds."""
    found = []
    for name, one in zip(effects, hidden, strict=True):
        field = one.size.rpartition(".")[2]
        said = next((said for said in answer.said if said.name == name and said.accepted and name not in FAULTS), None)
        if said is None or field not in said.values:
            continue
        estimate, std = _estimated_change(answer, said, field), said.std.get(field, 0.0)
        found.append({"effect": name, "true": one.true, "estimate": estimate, "std": std, "held": abs(estimate - one.true) <= 1.96 * std})
    return found


def _standing(unit: Machine, answer: sealed.SealedAnswer) -> list[str]:
    """Accepted names of what the unit has by itself, by about its true size: without repeats they are right."""
    return [
        said.name
        for said in answer.said
        if said.accepted
        and any(
            unit.values.get(f"{said.name}.{field}", 0.0) != 0.0 and abs(value / unit.values[f"{said.name}.{field}"] - 1.0) <= _OF_ITS_SIZE
            for field, value in said.values.items()
            if not field.startswith("phase")
        )
    ]


def _estimated_change(answer: sealed.SealedAnswer, said: sealed.Said, size: str) -> float:
    """From the healthy machine's model, which may hold a little of the effect already; what has a phase changes as a vector."""
    stood = answer.standing.get(said.name, {})
    if "phase_rad" in said.values:
        before = stood.get(size, 0.0) * np.exp(1j * stood.get("phase_rad", 0.0))
        return float(abs(said.values[size] * np.exp(1j * said.values["phase_rad"]) - before))
    return said.values[size] - stood.get(size, 0.0)


def perform(trial: Trial) -> dict[str, Any]:
    """One trial as a row of plain values."""
    unit = trial.unit
    hidden = hidden_changes(unit, trial, trial.command)
    run, healthy = runs(trial, trial.command, hidden)
    if trial.kind == "placebo":
        run = _dealt(run, healthy, seed_of(trial.key))
    other: Recording | None = None
    others: list[Recording] = []
    if trial.held_out:
        command = HELD_OUT[trial.command]
        other, others = runs(trial, command, _same_hidden(unit, trial, command))
    answer = sealed.answered(run, healthy, trial.channels, other, others)
    row: dict[str, Any] = {
        "key": trial.key,
        **asdict(trial),
        "verdict": answer.verdict,
        "first": answer.first,
        "accepted": list(answer.accepted),
    }
    row["class"] = list(answer.said[0].alike) if answer.said else []
    row["ranked"] = [[one.name, round(one.score, 1)] for one in answer.said[:6]]
    row |= {name: getattr(answer, name) for name in ("error", "unexplained", "sensor", "refused", "run_s", "cpu_s")}
    if trial.effects and trial.kind not in ("placebo", *TIMED):
        row["observer"] = observer.judged(
            trial.machine, unit.own, trial.command, trial.effects, trial.severity, run, healthy, trial.channels, unit.setting
        )
    row["sizes"] = _sizes(answer, hidden, trial.effects)
    row["standing"] = [] if trial.repeats else _standing(unit, answer)
    if answer.held_out is not None:
        row["held_out"] = {"command": HELD_OUT[trial.command], **answer.held_out}
    return row


def _same_hidden(unit: Machine, trial: Trial, command: str) -> Sequence[Change]:
    # a limit is the same limit under another command
    return hidden_changes(unit, trial, trial.command if "current_limit" in trial.effects else command)


def restored(row: Mapping[str, Any]) -> Trial:
    """The trial of a row read back."""
    values = {name: row[name] for name in Trial.__dataclass_fields__}
    return Trial(**{**values, "effects": tuple(row["effects"])})
