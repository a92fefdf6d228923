"""What a ground test can see: the smallest shifts of CSJ and BLK that it finds at a chosen rate of false alarms, for the present command and for safe ones beside it.

Two who look at the record are asked: the onboard search, which has the rod position alone, and the best that any estimate by all recorded signals could do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report, untold
from ema_tools.data.actuator import Actuator, nearest
from ema_tools.data.commands import parsed_numbers
from ema_tools.design.menu import Offence, SafeRange, limits_of, menu
from ema_tools.design.runs import CommandRun, checked_channels, noise_rms, rows_noise, run_of, safe_of
from ema_tools.design.typical import typical_change
from ema_tools.fit.detection import Scatter, ShiftTest, scatter_by_search, scatter_by_signals
from ema_tools.fit.nuisance import share_from_run_to_run
from ema_tools.library.faults import FAULTS
from ema_tools.plant.native import CHANNELS

_AMPLITUDES = (0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # factors by which the present chirp is moved [judgement]
_ENDS = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0)  # of the sweep [judgement]
_LENGTHS = (0.5, 1.0, 2.0)  # of the record [judgement]
_NO_WORSE = 1.1  # a better test may hang on what the machine is today by no more than this factor more than the present one [judgement]
_BETTER = 0.99  # of what the present test finds: a gain that is worth another command [judgement]
_NOISE = "verdict.position_noise_mm"
_THRESHOLDS = {"csj": "verdict.csj_min_shift_percent", "blk": "verdict.blk_min_shift_percent"}


@dataclass(frozen=True)
class Limit:
    """Of one value, in % of healthy: `std` its scatter, `threshold` of its own test, `alone` the shift that this test finds, `together` the shift of it alone that the test of both finds.
    `today`: how far it moves besides, for what the machine may be today without anybody knowing."""

    std: float
    threshold: float
    alone: float
    together: float
    today: float


@dataclass(frozen=True)
class Sight:
    """What is seen on one command, by value (csj, blk): `onboard` by the rod position, `signals` by all that are recorded; `verdict`: the shift that the onboard module calls a fault by the
    actuator's own thresholds, with the test's power. `false_alarms`: how often a healthy machine exceeds one of
    those; `over_wanted`: the shift that the onboard test finds over the one that is to be called a fault, root mean square of both."""

    title: str
    command: str
    duration_s: float
    onboard: Mapping[str, Limit]
    signals: Mapping[str, Limit]
    verdict: Mapping[str, float]
    false_alarms: float
    over_wanted: float
    peak_current_A: float
    peak_speed_mm_s: float

    def serves_for(self, present: Sight) -> bool:
        """Whether it could take the present test's place: no longer, and what a machine may be today moves its answers no farther."""
        today = all(self.onboard[name].today <= _NO_WORSE * one.today for name, one in present.onboard.items())
        return today and self.duration_s <= present.duration_s


@dataclass(frozen=True)
class Detection:
    """The present ground test and the safe ones beside it, best first; `unsafe`: command to why it was left out, `one_way`: those that push the rod one way alone, which shows no play."""

    test: ShiftTest
    channels: tuple[str, ...]
    scatter_percent: Mapping[str, float]
    present: Sight
    options: tuple[Sight, ...]
    unsafe: Mapping[str, Offence]
    one_way: tuple[str, ...]
    limits: SafeRange

    @property
    def best(self) -> Sight | None:
        """The best one that could take the present one's place; None where none is better."""
        return self._first(lambda one: one.serves_for(self.present))

    @property
    def best_of_any_length(self) -> Sight | None:
        """The same where it may take longer; None where that gains nothing."""
        found = self._first(lambda one: replace(one, duration_s=self.present.duration_s).serves_for(self.present))
        best = self.best or self.present
        return found if found is not None and found.over_wanted < _BETTER * best.over_wanted else None

    def _first(self, able: Callable[[Sight], bool]) -> Sight | None:
        found = next(filter(able, self.options), None)
        return found if found is not None and found.over_wanted < _BETTER * self.present.over_wanted else None


def scatter_given(text: str | None) -> dict[str, float]:
    """Scatter from run to run by `csj=0.6,blk=0.4`, in % of healthy. Raises InputError that names the value."""
    found: dict[str, float] = {}
    for part in filter(None, (text or "").split(",")):
        name, _, value = part.partition("=")
        if name.strip() not in FAULTS:
            raise InputError(f"--scatter {part}: no such value{nearest(name.strip(), FAULTS)}: values are {', '.join(FAULTS)}")
        try:
            found[name.strip()] = float(value)
        except ValueError:
            raise InputError(f"--scatter {part}: not a number: write for example --scatter csj=0.6,blk=0.4") from None
        if not 0.0 <= found[name.strip()] < math.inf:
            raise InputError(f"--scatter {part}: not a scatter: give standard deviations in %, zero or more")
    return found


def moved_chirps(command: str, period_s: float) -> dict[str, str]:
    """The chirp with amplitude, sweep and length moved, by what is moved; empty for another kind of command."""
    kind, _, text = command.partition(":")
    if kind != "chirp":
        return {}
    numbers = parsed_numbers(kind, text)
    found = {}
    for reach in _AMPLITUDES:
        for end in _ENDS:
            for length in _LENGTHS:
                moved = {
                    **numbers,
                    "amplitude_mm": reach * numbers["amplitude_mm"],
                    "end_hz": end * numbers["end_hz"],
                    "duration_s": length * numbers["duration_s"],
                }
                what = (("amplitude", reach), ("sweep", end), ("length", length))
                title = ", ".join(f"{name} x {factor:g}" for name, factor in what if factor != 1.0)
                if title and moved["end_hz"] * period_s < 0.5:
                    found[title] = f"{kind}:{','.join(f'{name}={value:g}' for name, value in moved.items())}"
    return found


def _both_ways(one: CommandRun, blk_mm: float) -> bool:
    """Whether the rod goes forth and back by more than the play."""
    rod = one.run.position_mm
    forth = float(np.max(rod - np.minimum.accumulate(rod)))
    back = float(np.max(np.maximum.accumulate(rod) - rod))
    return min(forth, back) > blk_mm


class _Asked:
    """What is the same for every command."""

    def __init__(self, actuator: Actuator, test: ShiftTest, channels: Sequence[str], noise: Mapping[str, float]) -> None:
        self.actuator, self.test = actuator, test
        self.names = {fault: value for fault, value in FAULTS.items() if actuator[value] > 0.0}
        self.noise = {name: noise[name] for name in channels}
        self.rod = noise["position_mm"]
        self.own = {value: 100.0 * share_from_run_to_run(actuator, value) for value in self.names.values()}

    def search(self, one: CommandRun) -> Scatter:
        """What the onboard search scatters by."""
        return scatter_by_search(
            self.actuator, one.record, tuple(self.names.values()), self.rod, self.own, bool(self.actuator["search.day_values"])
        )

    def sight(self, one: CommandRun) -> Sight:
        """What is seen on one command."""
        search = self.search(one)
        signals = scatter_by_signals(self.actuator, one.record, tuple(self.names.values()), self.noise, self.own)
        sure, missed = self.actuator["verdict.confidence_std"], self.test.missed()
        onboard = {fault: self._limit(search, value) for fault, value in self.names.items()}
        return Sight(
            one.title,
            one.text,
            one.record.rows * one.record.period_s,
            onboard,
            {fault: self._limit(signals, value) for fault, value in self.names.items()},
            {
                fault: self.actuator[_THRESHOLDS[fault]] + sure * search.noise_std(value) + missed * search.std(value)
                for fault, value in self.names.items()
            },
            self.test.exceeded(
                [
                    (self.actuator[_THRESHOLDS[fault]] + sure * search.noise_std(value)) / search.std(value)
                    for fault, value in self.names.items()
                ]
            ),
            float(np.sqrt(np.mean([(limit.alone / self.actuator[_THRESHOLDS[fault]]) ** 2 for fault, limit in onboard.items()]))),
            float(np.max(np.abs(one.run.current_A))),
            float(np.max(np.abs(one.run.speed_mm_s))),
        )

    def _limit(self, scatter: Scatter, value: str) -> Limit:
        tests, std = len(self.names), scatter.std(value)
        return Limit(
            std,
            self.test.threshold(tests) * std,
            self.test.found(tests) * std,
            self.test.found_together() * scatter.alone(value),
            float(scatter.today[scatter.names.index(value)]),
        )


def sight_of(actuator: Actuator, test: ShiftTest, command: str, noise: Mapping[str, float] | None = None) -> Sight:
    """What one command shows on an actuator whose scatter is the usual. Raises InputError for a command that does not exist."""
    return _Asked(actuator, test, CHANNELS, _noise(actuator, noise)).sight(run_of(actuator, "", command))


def _noise(actuator: Actuator, noise: Mapping[str, float] | None) -> dict[str, float]:
    """Of each channel, rms per row; `noise` at 1 kHz."""
    own = {"position_mm": actuator[_NOISE] / rows_noise(actuator)}
    return {name: one * rows_noise(actuator) for name, one in noise_rms(actuator, {**own, **(noise or {})}).items()}


def detection(
    actuator: Actuator,
    test: ShiftTest,
    command: str | None = None,
    channels: Sequence[str] = CHANNELS,
    noise: Mapping[str, float] | None = None,
    scatter_percent: Mapping[str, float] | None = None,
    own_limits: Mapping[str, float] | None = None,
    more: Sequence[str] = (),
    report: Report | None = None,
) -> Detection:
    """The smallest shifts that are found under `command` (the actuator's reference chirp unless told), under the menu's commands, under the chirp moved, and under `more` ones.

    `noise` of the channels, rms at 1 kHz: the rod's is the actuator's own unless told, the others as of common sensors. `scatter_percent`: by what the onboard search reads healthy runs of the
    present command apart, as `ema calibrate` says; what the actuator states, else the usual, unless told. Raises InputError for channels and commands that do not exist.
    """
    tell = report or untold
    recorded = checked_channels(channels)
    limits = limits_of(actuator, own_limits)
    texts = menu(actuator, limits)
    present_text = command or texts["chirp"]
    present = run_of(actuator, "the present test", present_text)
    asked = _Asked(actuator, test, recorded, _noise(actuator, noise))
    if not asked.names:
        raise InputError(
            f"{actuator.file}: screw.csj_Nm = 0, screw.blk_mm = 0: a shift is counted in % of the healthy value: calibrate first"
        )
    for fault, percent in (scatter_percent or {}).items():
        if fault in asked.names:
            # what the present command's own noise and day make of it is computed for each command
            rest = asked.search(present).std(asked.names[fault]) ** 2 - asked.own[asked.names[fault]] ** 2
            asked.own[asked.names[fault]] = math.sqrt(max(percent**2 - rest, 0.0))
    texts |= moved_chirps(present_text, actuator.record_period_s)
    texts |= {f"own command {place}": text for place, text in enumerate(more, start=1)}
    others = {title: text for title, text in texts.items() if text != present_text}
    runs = [run_of(actuator, title, text) for title, text in others.items()]
    worn = {fault: typical_change(actuator, fault, 0.0) or {} for fault in asked.names}
    _, refused = safe_of([present], actuator, {}, limits)
    safe, unsafe = safe_of(runs, actuator, worn, limits)
    one_way = tuple(one.text for one in safe if not _both_ways(one, actuator["screw.blk_mm"]))
    safe = [one for one in safe if one.text not in one_way]
    sights = each(
        asked.sight, [present, *safe], lambda count: tell(count / (len(safe) + 1), safe[min(count, len(safe) - 1)].title if safe else "")
    )
    first = sights[0]
    options = sorted(sights[1:], key=lambda one: one.over_wanted)
    tell(1.0, "done")
    known = {fault: first.onboard[fault].std for fault in asked.names}
    return Detection(test, recorded, known, first, tuple(options), unsafe | refused, one_way, limits)
