"""What to measure next: of a menu of safe commands, the one on which effects that are still confused differ most.

Two effects differ on a command by what the second cannot mend of the first: the first is simulated at its size, the second is fitted to that with all its values and shapes, beside what
scatters from run to run, and what is left is counted in standard deviations of the sensors' noise (d'), widened by the share to which the model itself is trusted. The smaller of both
directions is the pair's separation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report, untold
from ema_tools.data.actuator import Actuator, nearest, parsed, row_of, shown
from ema_tools.design.menu import LIMIT_NAMES, Offence, SafeRange, limits_of, menu
from ema_tools.design.runs import CommandRun, checked_channels, noise_rms, rows_noise, run_of, safe_of
from ema_tools.design.typical import scaled, typical_change, zero_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import Evidence, View, view
from ema_tools.fit.refit import refit
from ema_tools.fit.whitening import Whitener, least_noise, lines_of
from ema_tools.library.definitions import load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.plant.native import CHANNELS
from ema_tools.select.candidates import signatures
from ema_tools.select.matched_filter import Screen

_MODEL_ERROR = 0.02  # an effect's signature is trusted to this share of itself: a difference below it is no difference [judgement]
SEPARATE = 3.0  # from here on effects can be told apart on one record, in standard deviations [chance]
_PLAIN = 10.0  # an effect is far above detection from here on; below, a pair may be alike only because there is little to see [judgement]
_LARGER = (3.0, 10.0)  # sizes that are tried where the first ones cannot be told apart [judgement]
_VISIBLE = 30.0  # an effect without a usual size: the size at which the first command shows it this well [judgement]
_FIRST_SHARE = 0.0002  # of a range: the size from which on it is sought [judgement]
_FIT_STARTS = 2  # of the other effect of a pair, from which the nearest is sought [effort]
_REPEATS_MAX = 25  # averaging more repeats than this is no advice [judgement]
_REMEDY_COMMANDS = 3  # commands on which a remedy is tried: the best ones of the menu [effort]


@dataclass(frozen=True)
class Option:
    """A command of the menu: how far each pair is apart on it, and how well it shows each effect, in standard deviations of the noise."""

    title: str
    command: str
    pairs: Mapping[tuple[str, str], float]
    shown: Mapping[str, float]
    peak_current_A: float
    peak_speed_mm_s: float

    @property
    def separation(self) -> float:
        """Of the pair that is told apart worst."""
        return min(self.pairs.values())


@dataclass(frozen=True)
class Next:
    """The menu ranked, best first; `unsafe`: command to why it was left out. `values`: at which sizes; `larger`: how much larger than first asked.

    `with_channels`: the same menu's best with signals recorded that are not now; None where all are, or nothing is gained.
    """

    effects: tuple[str, ...]
    channels: tuple[str, ...]
    values: Mapping[str, Mapping[str, float]]
    options: tuple[Option, ...]
    unsafe: Mapping[str, Offence]
    limits: SafeRange
    larger: float = 1.0
    with_channels: tuple[tuple[str, ...], Option] | None = None

    @property
    def best(self) -> Option | None:
        """The command that separates them, None when none does."""
        return self.options[0] if self.options and self.options[0].separation >= SEPARATE else None

    @property
    def confused(self) -> tuple[tuple[str, str], ...]:
        """Pairs that no command of the menu separates."""
        if not self.options:
            return tuple(combinations(self.effects, 2))
        return tuple(pair for pair in self.options[0].pairs if max(option.pairs[pair] for option in self.options) < SEPARATE)

    @property
    def hidden(self) -> tuple[str, ...]:
        """Effects of confused pairs that no command shows plainly."""
        involved = dict.fromkeys(name for pair in self.confused for name in pair)
        return tuple(name for name in involved if max((option.shown[name] for option in self.options), default=0.0) < _PLAIN)

    @property
    def best_of_each(self) -> dict[tuple[str, str], Option]:
        """For each pair the command that tells it apart best."""
        return {pair: max(self.options, key=lambda option: option.pairs[pair]) for pair in self.options[0].pairs}

    def repeats(self) -> int | None:
        """How many repeats of the best command would separate them in their mean; None where that is no advice."""
        most = max((option.separation for option in self.options), default=0.0)
        wanted = math.ceil((SEPARATE / most) ** 2) if most > 0.0 else _REPEATS_MAX + 1
        return wanted if 1 < wanted <= _REPEATS_MAX else None


def check_effects(effects: Sequence[str]) -> tuple[str, ...]:
    """The effects and fault parameters, each once. Raises InputError for an unknown or learned one, and for fewer than two."""
    known = [effect.name for effect in load_definitions().physical]
    for name in effects:
        if name not in known and name not in FAULTS:
            raise InputError(
                f"--between {name}: no such effect{nearest(name, [*known, *FAULTS])}: ema effects lists the library; csj and blk are taken too"
            )
    found = tuple(dict.fromkeys(effects))
    if len(found) < 2:
        raise InputError(f"--between {' '.join(effects)}: one effect is confused with nothing: name two or more")
    return found


def sizes_of(settings: Sequence[str]) -> dict[str, float]:
    """The values of `name=value` texts by their full names. Raises InputError that names the setting."""
    found = {}
    for setting in settings:
        name, equals, value = setting.partition("=")
        if not equals:
            raise InputError(f"--set {setting}: no value: write --set effects.EFFECT.FIELD=VALUE")
        row = row_of(name.strip())
        found[shown(row)] = parsed(row, value.strip(), "--set ")
    return found


def limits_given(text: str | None) -> dict[str, float]:
    """Limits of `name=value,...`. Raises InputError that names the limit."""
    found = {}
    for part in filter(None, (text or "").split(",")):
        name, _, value = part.partition("=")
        if name.strip() not in LIMIT_NAMES:
            raise InputError(f"--limit {part}: no such limit{nearest(name.strip(), LIMIT_NAMES)}: limits are {', '.join(LIMIT_NAMES)}")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--limit {part}: not a number: write for example --limit stroke_mm=5") from None
        if not 0.0 < found[name.strip()] < math.inf:
            raise InputError(f"--limit {part}: not above zero: give the largest value that is safe")
    return found


def _evidence(actuator: Actuator, one: CommandRun, channels: Sequence[str], noise: Mapping[str, float]) -> Evidence:
    """What a record of this command would say about a machine that is as known."""
    base = np.array([one.record.recorded(name) for name in channels])
    white = np.array([noise.get(name, 0.0) for name in channels]) * rows_noise(actuator)
    level = np.maximum(white, least_noise(base))
    power = np.broadcast_to((level**2)[:, None], (len(channels), lines_of(one.record.rows)))
    # a healthy repeat with nothing new stands behind it: what scatters is what differs from run to run
    return Evidence(
        actuator,
        one.record,
        tuple(channels),
        base,
        spreads.from_run_to_run(actuator),
        Whitener.of(power, one.record.rows),
        power,
        np.empty((0, *base.shape)),
        0.0,
        (base,),
    )


def _seen(evidence: Evidence, changes: Mapping[str, float]) -> View:
    """The evidence of a record that shows `changes`, without noise, from the healthy machine. Raises InputError when the model refuses them."""
    target = evidence.simulate(changes, np.zeros(len(evidence.spread)))
    return view(replace(evidence, target=target), {})


def _left(seen: View, other: str) -> float:
    """What `other` at its best leaves of what is seen, in standard deviations of noise and model."""
    least = seen.cost
    for start in signatures(Screen(seen), only=(other,))[:_FIT_STARTS]:
        fit = refit(seen, start.start())
        least = min(least, fit.cost)
    return math.sqrt(max(least, 0.0) / (1.0 + _MODEL_ERROR**2 * seen.cost))


def _option(
    actuator: Actuator,
    one: CommandRun,
    effects: Sequence[str],
    values: Mapping[str, Mapping[str, float]],
    channels: Sequence[str],
    noise: Mapping[str, float],
) -> Option:
    evidence = _evidence(actuator, one, channels, noise)
    seen = {effect: _seen(evidence, values[effect]) for effect in effects}
    pairs = {(first, second): min(_left(seen[first], second), _left(seen[second], first)) for first, second in combinations(effects, 2)}
    visible = {effect: math.sqrt(max(look.cost, 0.0)) for effect, look in seen.items()}
    return Option(one.title, one.text, pairs, visible, float(np.max(np.abs(one.run.current_A))), float(np.max(np.abs(one.run.speed_mm_s))))


def _visible(actuator: Actuator, effect: str, evidence: Evidence) -> dict[str, float]:
    """An effect that has no usual size, at the size at which the command shows it plainly, or at its bound."""
    name, present = zero_of(actuator, effect)
    row = row_of(name)
    reach = row.upper - present if row.upper > present else row.lower - present
    share = _FIRST_SHARE
    while True:
        values = {name: present + share * reach}
        try:
            if _seen(evidence, values).cost >= _VISIBLE**2 or share >= 1.0:
                return values
        except InputError:
            if share <= _FIRST_SHARE:
                raise
            return {name: present + share / 2.0 * reach}
        share = min(2.0 * share, 1.0)


def sizes_for(actuator: Actuator, effects: Sequence[str], evidence: Evidence, given: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """The values of each effect: `given` ones by name, else those at the lower end of their usual size, else the size at which the evidence's command shows it.

    Raises InputError for a given value that belongs to none of the effects.
    """
    peak = float(np.max(np.abs(evidence.record.recorded("current_A"))))
    found = {effect: dict(typical_change(actuator, effect, peak) or _visible(actuator, effect, evidence)) for effect in effects}
    for name, value in given.items():
        effect = next((fault for fault, fault_name in FAULTS.items() if fault_name == name), name.split(".")[-2])
        if effect not in found:
            raise InputError(f"--set {name}: belongs to none of {', '.join(effects)}: name effects.EFFECT.FIELD of one of them")
        found[effect][name] = value
    for effect, values in found.items():
        size, present = zero_of(actuator, effect)
        if values[size] == present:
            raise InputError(f"--set {size}={present:g}: at this size {effect} is not there: give another")
    return found


def next_experiment(
    actuator: Actuator,
    effects: Sequence[str],
    channels: Sequence[str] = CHANNELS,
    values: Mapping[str, float] | None = None,
    noise: Mapping[str, float] | None = None,
    own_limits: Mapping[str, float] | None = None,
    more: Sequence[str] = (),
    report: Report | None = None,
) -> Next:
    """The commands of the menu, and `more` ones, by how far they separate `effects` (csj and blk among them) with `channels` recorded.

    `values` of the effects by name, as a diagnosis found them; usual sizes where none are given. `noise` of the channels, rms at 1 kHz; `own_limits` as `limits_of` takes them.
    Raises InputError for effects, values, channels and commands that do not exist.
    """
    tell = report or untold
    names = check_effects(effects)
    recorded = checked_channels(channels)
    rms = noise_rms(actuator, noise)
    limits = limits_of(actuator, own_limits)
    texts = menu(actuator, limits) | {f"own command {place}": text for place, text in enumerate(more, start=1)}
    runs = [run_of(actuator, title, text) for title, text in texts.items()]
    sizes = sizes_for(actuator, names, _evidence(actuator, runs[0], CHANNELS, rms), dict(values or {}))
    safe, unsafe = safe_of(runs, actuator, sizes, limits)
    done = 0.0

    def ranked(some: Sequence[CommandRun], at: Mapping[str, Mapping[str, float]], seen: Sequence[str], share: float) -> tuple[Option, ...]:
        nonlocal done
        begun, done = done, done + share
        options = each(
            lambda one: _option(actuator, one, names, at, seen, rms),
            some,
            lambda count: tell(begun + share * count / max(len(some), 1), some[min(count, len(some) - 1)].title),
        )
        return tuple(sorted(options, key=lambda option: -option.separation))

    found = Next(names, recorded, sizes, ranked(safe, sizes, recorded, 0.5), unsafe, limits)
    factors = _LARGER if not values and found.hidden else ()
    for factor in factors:
        if found.confused and found.hidden:
            at = {effect: scaled(actuator, effect, changes, factor) for effect, changes in sizes.items()}
            still, dropped = safe_of(safe, actuator, at, limits)
            found = Next(names, recorded, at, ranked(still, at, recorded, 0.15), unsafe | dropped, limits, factor)
    if found.confused and len(recorded) < len(CHANNELS):
        found = replace(found, with_channels=_more_channels(found, safe, lambda some, seen: ranked(some, found.values, seen, 0.05)))
    tell(1.0, "done")
    return found


def _more_channels(found: Next, runs: Sequence[CommandRun], ranked: Any) -> tuple[tuple[str, ...], Option] | None:
    """The fewest signals more that would separate the effects, and the command; None when not even all signals do."""
    absent = [name for name in CHANNELS if name not in found.channels]
    # where all signals do not help, none of them does
    everything = ranked(runs, CHANNELS)
    if not everything or everything[0].separation < SEPARATE:
        return None
    some = [one for one in runs if one.text in {option.command for option in everything[:_REMEDY_COMMANDS]}]
    for channel in absent:
        names = tuple(name for name in CHANNELS if name in found.channels or name == channel)
        option = ranked(some, names)[0]
        if option.separation >= SEPARATE:
            return names, option
    return CHANNELS, everything[0]
