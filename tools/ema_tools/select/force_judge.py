"""What speaks against an effect that was fitted by the balance of forces: its size, what it does to parts, places and speeds to which it was not fitted, and whether it is what its name says."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy import special

from ema_tools.base import leastsquares
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import row_of
from ema_tools.fit.division import PART, PARTS
from ema_tools.library.definitions import load_definitions
from ema_tools.library.display_names import value_coded
from ema_tools.library.registry import record_of
from ema_tools.library.torques import WIDEST_SPOT
from ema_tools.select.balance_bench import Bench, Fitted, floor_of
from ema_tools.select.balance_setting import LEVEL, VISCOUS
from ema_tools.select.force_steps import Tried
from ema_tools.select.foretold_drive import foretold_percent, reads_drive
from ema_tools.select.torque_patterns import Pattern, is_texture

SIZE_IN_STD = 3.0  # an effect must show a size of so many standard errors ... [chance]
AGREED_STD = 2.0  # ... and of so many by which records differ, where it lowers the error by less than a fifth, ... [chance]
# ... and one of all it hangs on, its shape and the records: a size that may be twice or none is no finding [judgement]
_TOLD_STD = 1.0
CLEARLY = 0.8  # of the error left, which nobody takes for chance [judgement]
FALL_IN_STD = 2.5  # ... a fall of the held-out squared error of so many of its own ... [chance]
_STRETCHES = 60  # of all records together, in most of which the error must fall where the mean of all is one start's [judgement]
LEAST_SHARE = 0.03  # ... that takes off this share of the squared error above the floor ... [judgement]
# ... and of what is left beside others so much where no laps tell chance from what has a form: another law than the first one's own
# leaves as much [judgement]
_LATER_SHARE = 0.1
# ... and of that of the refitted base values: products of large effects look like small effects of their own [judgement]
LEAST_OF_FIRST = 0.02
# By how much it may raise the error at places and speeds to which nothing was fitted: in all, and in any third of them ... [judgement]
WORSE_ELSEWHERE, WORSE_THIRD = 1.01, 1.1
WORSE_OF_GAIN = 0.2  # ... where it matters beside what it takes off the squared error in all [judgement]
# an effect of which the other two thirds show less than this, as a share of what all show, cannot be told from them [judgement]
_SEEN_ELSEWHERE = 0.1
_THIRDS = 3  # of the places and of the speeds, each told from the other two: what is seen in one of them only is no law [judgement]
# quantile of the speeds from which friction is looked at on its way to the fastest, and at how many [precision]
_SLOWEST, _SPEEDS = 0.01, 64
_FALLS = 0.1  # of what an effect adds to friction, by which all of it must fall with the speed [judgement]
_BOUND = 1e-6  # so near to an end of its range, relative, a value lies on it [precision]
_ONCE_PER_TURN = 1.0  # periods per motor turn of what hangs on the motor itself; faster are magnets and teeth [physics]
_MOST_FLOOR = 0.9  # of the error: a floor beyond it would make any gain look like all there is [judgement]
# Of what is above the floor: a texture that only laps of one motion show must take off more than it leaves, which repeats as it does [judgement]
_MOST = 0.5
REPEATED_MOTION = (
    "laps of one motion alone do not tell it from all else that is missing and comes back at the same places: record another motion"
)
_THIRD_WORDS = {"places": ("near", "middle", "far"), "speeds": ("low", "middle", "high")}

# What else may be said against an effect, judged, beside accepted ones; empty where nothing is.
Veto = Callable[[Fitted, Tried], str]


class Judge:
    """Says why an effect on a bench is not added. `first`: squared error of the training parts that the first model left."""

    def __init__(self, bench: Bench, veto: Veto | None = None) -> None:
        """`veto`: why else an effect is not added, asked last."""
        self.bench, self.veto = bench, veto
        self.first = float(np.sum(bench.without_load().residual[bench.training] ** 2))

    def left_by_loads(self, accepted: Fitted) -> float:
        """Squared error of the training parts that the first model leaves once it knows what the machine carries, of which an effect must take off enough.

        A weight may be ten times the friction, which would hide half of it; while what an effect of friction leaves is often a product of it.
        """
        owners = [pattern for pattern in accepted.patterns for _ in range(pattern.columns.shape[1])]
        carried = tuple(pattern for pattern in accepted.patterns if is_carried(pattern))
        if not carried and not self.bench.load_named:
            return self.first
        columns = accepted.columns[:, [is_carried(owner) for owner in owners]]
        fit = self.bench.fit(self.bench.start, carried, columns)
        return min(self.first, float(np.sum(fit.residual[self.bench.training] ** 2)))

    def refusal(self, accepted: Fitted, tried: Tried) -> str:
        """Why an effect, judged, is not added; empty when it is."""
        bench, fit = self.bench, tried.fit
        beyond = outside(fit)
        if beyond:
            return f"beside it {beyond}"
        # what needs a base value pushed as far as it goes stands in for it, or for something else
        pushed = [name for name in bench.pushed_to_ends(fit) if name not in bench.at_ends(accepted)]
        if pushed:
            return f"beside it {value_coded(pushed[0])} would lie on an end of where it may be: {fit.values[pushed[0]]:.3g}"
        if another := self.another(fit, tried.effect):
            return another
        size = load_definitions().effect(tried.effect).size.name
        std = fit.std.get(size, math.inf)
        if abs(fit.values[size]) < SIZE_IN_STD * std:
            return f"its size {fit.values[size]:.3g} is not distinguishable from zero: standard error {std:.2g}"
        apart = bench.std_of_records(fit).get(size, 0.0) if fit.errors.training > CLEARLY * accepted.errors.training else 0.0
        if abs(fit.values[size]) < AGREED_STD * apart:
            return f"the records do not agree on its size {fit.values[size]:.3g}: leaving one out after another it is off by {apart:.2g}, one standard error"
        if at_bound(size, fit.values[size]):
            return f"at a bound: {value_coded(size)} = {fit.values[size]:.3g}"
        # every part held out once
        change = (bench.held_out(accepted) ** 2 - bench.held_out(fit) ** 2)[bench.sliding]
        if not self._falls(change):
            return f"it does not lower the error of the held-out {PARTS[bench.division.by]} significantly: {accepted.errors.holdout:.3g} % to {fit.errors.holdout:.3g} %"
        gain = accepted.errors.training**2 - fit.errors.training**2
        worse = [part for part in range(bench.division.folds) if _worse(accepted.errors.each[part], fit.errors.each[part], gain, 1.0)]
        if bench.division.apart and fit.errors.holdout > accepted.errors.holdout:
            return f"it raises the error of what was held out: {accepted.errors.holdout:.3g} % to {fit.errors.holdout:.3g} %"
        # friction itself differs from part to part: what is asked of the effect is whether it is the same there
        if any(_worse(bench.foretold_part(accepted, part), bench.foretold_part(fit, part), gain, 1.0) for part in worse):
            return f"it raises the error of a {PART[bench.division.by]} when that one is held out"
        here = self.elsewhere(accepted, fit)
        before, after = (math.hypot(*(errors[side] for errors in here.values())) / math.sqrt(max(len(here), 1)) for side in (0, 1))
        if _worse(before, after, gain, WORSE_ELSEWHERE):
            return f"it does not carry over to places and speeds to which nothing was fitted: {before:.3g} % to {after:.3g} %"
        for where, (before, after) in here.items():
            if _worse(before, after, gain, WORSE_THIRD):
                return f"it does not carry over to {where} to which nothing was fitted: {before:.3g} % to {after:.3g} %"
        share, least = self.share(accepted, tried.gain), self._least_share(accepted)
        if share < least:
            return f"it takes off {100.0 * share:.1f} % of what is above the floor, less than {100.0 * least:g} %"
        if share < _MOST and self._repeats_alone(tried):
            return f"{REPEATED_MOTION}: it takes off {100.0 * share:.0f} % of that"
        first = self.left_by_loads(accepted)
        if tried.gain < LEAST_OF_FIRST * first:
            whose = "the first model" if first == self.first else "the first model and the loads"
            return f"it takes off {100.0 * tried.gain / first:.2f} % of what {whose} left, less than {100.0 * LEAST_OF_FIRST:g} %"
        whole = bench.stated(fit).std.get(size, math.inf)
        if abs(fit.values[size]) < _TOLD_STD * whole:
            return f"its size {fit.values[size]:.3g} is not told: standard error {whole:.2g} with its shape, which is fitted too"
        circle = self._in_a_circle(accepted, tried)
        return circle or (self.veto(accepted, tried) if self.veto is not None else "")

    def _repeats_alone(self, tried: Tried) -> bool:
        """Whether an effect is a texture along the way, and laps of one motion are all that shows it: whatever else is missing comes back at the same places there."""
        division, setting = self.bench.division, tried.fit.samples.setting
        if division.by != "lap" or division.apart:
            return False
        return any(
            is_texture(setting, one.effect, one.shape)
            # the weight of an arm swings likewise, but not on a screw
            and (setting.actuator.has("screw.lead_mm") or not is_carried(one))
            for one in tried.fit.patterns
            if one.effect == tried.effect
        )

    def _falls(self, change: Reals) -> bool:
        """Whether a fall of the squared error, of every sliding sample, is more than chance: in its mean, or in most stretches of time, since a single start of a motion may outweigh all else."""
        if not float(np.mean(change)) > 0.0:
            return False
        # half a second to load, for this one method
        from scipy.stats import wilcoxon

        of_record = self.bench.of_record[self.bench.sliding]
        numbers = np.unique(of_record)
        count = math.ceil(_STRETCHES / numbers.size)
        sums = [float(np.sum(part)) for number in numbers for part in np.array_split(change[of_record == number], count) if part.size]
        by_sign = wilcoxon(sums, alternative="greater").pvalue
        return self._in_std(change) >= FALL_IN_STD or bool(by_sign < special.ndtr(-FALL_IN_STD))

    def _in_std(self, change: Reals) -> float:
        """A mean fall in its standard errors, as neighbours are alike."""
        fall, of_record = float(np.mean(change)), self.bench.of_record[self.bench.sliding]
        runs = (leastsquares.long_run((change - fall)[of_record == number, None]) for number in np.unique(of_record))
        spread = math.sqrt(sum(float(one[0, 0]) for one in runs)) / change.size
        return fall / spread if spread > 0.0 else 0.0

    def _in_a_circle(self, accepted: Fitted, tried: Tried) -> str:
        """Why an effect that reads the drive finds itself in the drive's own error; empty for any other."""
        if not reads_drive(accepted.samples.setting.actuator, tried.effect):
            return ""
        before, after = foretold_percent(self.bench, accepted), foretold_percent(self.bench, tried.fit)
        if not after >= before:
            return ""
        return f"it reads the drive, and lowers the error of the balance with the measured one alone: of the drive foretold from the motion {before:.3g} % to {after:.3g} %"

    def share(self, accepted: Fitted, gain: float) -> float:
        """Part of the squared error above the floor that a gain is."""
        rows = self.bench.training
        total = float(np.sum(accepted.residual[rows] ** 2))
        floor = (0.01 * floor_of(self.bench, accepted)) ** 2 * float(np.sum(accepted.samples.drive[rows] ** 2))
        # the floor is itself known from a few laps only
        return gain / (total - min(floor, _MOST_FLOOR * total)) if math.isfinite(floor) else gain / total

    def _least_share(self, accepted: Fitted) -> float:
        """Of what is above the floor that an effect must take off."""
        later = bool(accepted.patterns) or self.bench.load_named
        return _LATER_SHARE if later and not math.isfinite(floor_of(self.bench, accepted)) else LEAST_SHARE

    def slight(self, worse: Fitted, gain: float) -> bool:
        """Whether a gain over a fit is too little of what is above the floor, or of what the first model left."""
        return self.share(worse, gain) < LEAST_SHARE or gain < LEAST_OF_FIRST * self.left_by_loads(worse)

    def another(self, fit: Fitted, effect: str) -> str:
        """Why an effect as it was fitted is none, or another one; empty where it is what its name says."""
        beyond = outside(fit, effect)
        if beyond:
            return f"physically impossible: {beyond}"
        record = record_of(effect)
        size = load_definitions().effect(effect).size.name
        if record.adds and fit.values[size] < 0.0:
            return f"{value_coded(size)} would be {fit.values[size]:.3g}: less than none of it is another effect"
        local = record.local
        if local is not None and local.spot:
            width, stroke = fit.values[f"{effect}.{local.spot}"], float(np.ptp(fit.samples.setting.states.screw_mm))
            return f"{width:.3g} of {stroke:.3g} mm is no spot: friction differs by place" if width > WIDEST_SPOT * stroke else ""
        if local is None or not local.falls:
            return ""
        states, values = fit.samples.setting.states, fit.values
        seen = np.abs(states.speed_rad_s)[np.abs(states.direction) > 0.0]
        speeds = np.linspace(float(np.quantile(seen, _SLOWEST)), float(np.max(seen)), _SPEEDS)
        extent = values[size] * (values[LEVEL] if local.of_level else 1.0)
        shape = {name.removeprefix(f"{effect}."): value for name, value in values.items() if name.startswith(f"{effect}.")}
        for side in (-1.0, 1.0):
            at = replace(states, direction=np.full(speeds.size, side), speed_rad_s=side * speeds)
            extra = -side * extent * local.torque(at, shape)
            friction = extra + values[VISCOUS] * speeds
            if friction[0] - float(np.min(friction)) >= _FALLS * float(np.ptp(extra)) > 0.0:
                return ""
        return "with it friction falls at no speed: what is seen is a drag that bends"

    def elsewhere(self, before: Fitted, after: Fitted) -> dict[str, tuple[float, float]]:
        """Errors in % without and with the last effect where neither was fitted: each third of the places, and of the speeds, told from the others where those show the effect."""
        states, rows = before.samples.setting.states, self.bench.fitted
        found: dict[str, tuple[float, float]] = {}
        # what a table says of one place it does not say of another
        of_place = bool(after.patterns) and record_of(after.patterns[-1].effect).along is not None
        for by, values in (("places", states.screw_mm), ("speeds", np.abs(states.speed_rad_s)))[of_place:]:
            seen = self.bench.kept(values)
            third = np.searchsorted(np.quantile(seen[rows], np.arange(1, _THIRDS) / _THIRDS), seen, side="right")
            for number, word in enumerate(_THIRD_WORDS[by]):
                told = rows & (third == number)
                if told.any() and self.bench.seen_share(after, rows & ~told) > _SEEN_ELSEWHERE:
                    found[f"{word} {by}"] = (
                        self.bench.foretold(before, rows & ~told, told),
                        self.bench.foretold(after, rows & ~told, told),
                    )
        return found


def is_carried(pattern: Pattern) -> bool:
    """Whether an effect is what the machine carries, and no friction: a spring, or a swing no faster than the motor turns, as of an arm's weight."""
    return is_load(pattern.effect, pattern.shape.get(f"{pattern.effect}.periods", 1.0))


def is_load(effect: str, periods: float) -> bool:
    """The same of an effect by its name, and for a swing by how often it comes per turn of the motor."""
    periodic = record_of(effect).periodic
    if periodic is not None:
        return periodic.behind_gear and periods <= _ONCE_PER_TURN
    return load_definitions().effect(effect).site == "LOAD"


def _worse(before: float, after: float, gain: float, allowed: float) -> bool:
    """Whether an error, in %, rises by more than is allowed, and by what matters beside what is gained of the squared error in all."""
    return after > allowed * before and after**2 - before**2 > WORSE_OF_GAIN * gain


def outside(fit: Fitted, effect: str = "") -> str:
    """The first value that lies outside its range, of one effect or of all and the base; empty when all lie inside."""
    for name, value in fit.values.items():
        if effect and not name.startswith(f"{effect}."):
            continue
        row = row_of(name)
        if not row.lower <= value <= row.upper:
            return f"{value_coded(name)} would be {value:.3g}, outside {row.lower:g} .. {row.upper:g}{' ' + row.unit if row.unit else ''}"
    return ""


def unphysical(name: str, fit: Fitted) -> bool:
    """Whether a base value of a fit lies outside its range, or on an end of it."""
    row, value = row_of(name), fit.values[name]
    return not row.lower < value < row.upper


def at_bound(name: str, value: float) -> bool:
    """Whether a value of an effect lies on an end of its range."""
    row = row_of(name)
    return value >= row.upper - _BOUND * abs(row.upper) or value <= row.lower + _BOUND * abs(row.lower)
