"""What a model lacks, named by the mechanical balance alone: for records without a known controller, or of a loop so stiff that the position hardly shows the mechanics.

The motor's torque is linear in the base values and in the sizes of most effects, so that every effect of the library, in every shape, is fitted together with the base values in a
moment. Greedy: the effect that lowers the error of the fitted parts most joins, if the parts that were held out confirm it; the rest is tried again beside it; what has become needless is
dropped. Parts are records where there are several, else laps, else stretches of time. Standard errors hold for a residual that is missing model rather than noise, which repeats
(`ema_tools.base.leastsquares`).

All errors are relative: 100 * norm of the balance's residual over norm of the motor's torque. The floor is how far the torque of one lap is from that of the others.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.fit.division import PARTS
from ema_tools.library.definitions import load_definitions
from ema_tools.library.display_names import coded, value_coded
from ema_tools.library.registry import called, named, record_of
from ema_tools.library.torques import Shape
from ema_tools.select.balance_bench import (
    BY_RECORDS,
    INERTIA,
    LOAD,
    Bench,
    Fitted,
    FoldErrors,
    Samples,
    floor_of,
    given_errors,
    load_effect,
    size_of_load,
    solved,
)
from ema_tools.select.balance_setting import LEVEL, VISCOUS, Setting
from ema_tools.select.base_values import base_values
from ema_tools.select.drive_lag import with_lag_fitted
from ema_tools.select.few_samples import too_few
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_floor import estimated_floor
from ema_tools.select.force_judge import CLEARLY, LEAST_OF_FIRST, LEAST_SHARE, SIZE_IN_STD, Judge, at_bound, is_carried, outside, unphysical
from ema_tools.select.force_steps import ForceStep, ForceSteps, Refusal, Tried
from ema_tools.select.foretold_drive import foretold_percent
from ema_tools.select.torque_patterns import NOT_HERE, Pattern, continuous_of, is_texture, pattern_of, patterns_of, rows_of

SAME_SWING = "its waves are whole multiples of one that was accepted, and no record says where the machine is: it may be the same swing, which is no pure sine"
_STANDS_IN = "beside refitted base values it would stand in for others: it is sought by simulation alone"
UNSOUGHT = f"{_STANDS_IN} (--method simulation)"
NOT_SIMULATED = f"{_STANDS_IN}, which needs a known controller, and a record with the command and the position"
ONE_MOTION = "one motion alone does not tell friction that differs by place from friction that differs by speed: record another motion"
EFFECTS_MAX = 8  # more at once are not believed from one record [judgement]
MANY = f"{EFFECTS_MAX} effects have been added: confirm them on another record before adding more"
_OWN = 1e-3  # a column is the base values' own when they leave less than this of it [precision]
_ZERO = 0.025  # of the dry friction: a constant torque that the zero of a current or torque sensor makes as well [judgement]
_ONE_TURN = 1.5  # turns of a wave: of fewer a constant torque beside it is hardly told from its own [judgement]
_AS_WELL = 1.03  # times the error with one effect less, which the simpler answer may have [judgement]
_AS_LOAD = 0.2  # of which all but this share is a constant torque is taken for one: the samples next to a standstill are few [judgement]
_SHAPE_SHARE = 0.02  # a shape that explains less than this share of the best one's is no shape of the effect [judgement]
_ROUND_SHARE = 0.15  # of the bar that shows how far it is, for one effect [layout]
# times the estimated floor: where no more is left, an effect must lower the error itself clearly, as a texture does that the estimate takes for chance [judgement]
_AS_FLOOR = 1.2
_AS_NOISE = 1.05  # of the noise alone, likewise: it is rather too low [judgement]
_NO_MODEL = 30.0  # % of the drive: what leaves more is no model of the machine, and what it names is chance [judgement]
_BASE_ROUNDS, _BASE_SAME = 5, 1e-4  # until base values and what is a share of them agree [precision]
_CLASS_GAIN = 0.8  # effects that lower the fitted error by nearly as much as the best ... [judgement]
_CLASS_COSINE = 0.8  # ... and look like it, are its class [judgement]
_WHOLE = 1e-6  # periods per turn that are so near to a whole multiple are one [precision]


# Effects refused alone that are tried beside each other [effort]
_PAIRED = 4

# What else may be said against an effect, judged, beside accepted ones; empty where nothing is.
Veto = Callable[["ForceSearch", Fitted, Tried], str]


class ForceSearch:
    """Effects beside base values on a bench, and what speaks for and against each."""

    def __init__(self, bench: Bench, report: Report, effects: Sequence[str] | None = None, veto: Veto | None = None) -> None:
        """`effects`: that are looked at; without them all that the actuator does not hold. `veto`: why else an effect is not added, asked last."""
        actuator = bench.start.setting.actuator
        self.bench = bench
        self.bench.keep_undetermined()
        self.judge = Judge(bench, None if veto is None else lambda accepted, tried: veto(self, accepted, tried))
        self.report = report
        others = [effect for effect in named() if effect not in actuator.active_effects]
        self.effects = [name for name in others if record_of(name).in_balance] if effects is None else list(effects)
        # what cannot be done here is not advised
        known = not actuator.absent and not any(isinstance(record, MotionRecord) for record in bench.records)
        self.unsought = [Refusal(name, UNSOUGHT if known else NOT_SIMULATED) for name in others if not record_of(name).in_balance]
        self.setting: Setting | None = None
        self.weak: list[Tried] = []  # of the last round: what was refused after it was judged
        # whether an effect that matters would make the inertia impossible: these records do not tell the two apart
        self.upsets_inertia = False
        self.patterns: dict[str, Sequence[Pattern] | str] = {}
        self.columns: dict[str, list[Reals]] = {}
        self.carried: list[tuple[str, tuple[tuple[str, float], ...]]] = []  # of what the machine carries, the shapes that are known

    def prepare(self, setting: Setting) -> None:
        """All patterns in a setting."""
        same_current = self.setting is not None and np.array_equal(self.setting.states.current_A, setting.states.current_A)
        self.setting = setting
        # torques and loads do not look at the contact, so that without another current they are what they were
        anew = [effect for effect in self.effects if not (same_current and load_definitions().effect(effect).site in ("TORQUE", "LOAD"))]

        def made(effect: str) -> tuple[Sequence[Pattern] | str, list[Reals]]:
            columns: list[Reals] = []

            def taken(pattern: Pattern) -> Pattern:
                columns.append(self.bench.decimated(pattern.columns))
                return pattern.light

            return patterns_of(setting, effect, taken), columns

        for effect, (found, columns) in zip(anew, each(made, anew), strict=True):
            self.patterns[effect], self.columns[effect] = found, columns

    def settled(self, fit: Fitted) -> Fitted:
        """A fit whose last effect changed the balance itself, with all patterns made again from it."""
        self.prepare(fit.samples.setting)
        return self.with_patterns(fit.patterns, fit.samples)

    def finished(self, fit: Fitted, bent: bool) -> Fitted:
        """A fit that was accepted with its shape as it is best; `bent`: with all patterns made again from a balance that it changed, unless that is impossible."""
        if not bent:
            return self.refined(fit)
        settled = self.settled(fit)
        if not outside(settled):
            return settled
        self.prepare(self.bench.start.setting)
        return fit

    def with_patterns(self, patterns: Sequence[Pattern], samples: Samples) -> Fitted:
        """A fit of known shapes, their columns from the present setting."""
        columns = [self.bench.decimated(rows_of(samples.setting, pattern)) for pattern in patterns]
        return self.bench.fit(samples, patterns, np.column_stack([np.zeros((self.bench.fold.size, 0)), *columns]))

    def refined(self, fit: Fitted) -> Fitted:
        """A fit with the continuous shape parameters of its last effect between the shapes tried."""
        *others, last = fit.patterns
        names = continuous_of(last.effect)
        if not names:
            return fit
        rows, rest = self.bench.training, fit.columns[:, : fit.columns.shape[1] - last.columns.shape[1]]
        scale = np.array([abs(last.shape[name]) or 1.0 for name in names])
        ranges = [(row_of(name).lower, row_of(name).upper) for name in names]

        def shape_at(point: Reals) -> Shape:
            return {
                **last.shape,
                **{name: float(np.clip(value, *limits)) for name, value, limits in zip(names, point * scale, ranges, strict=True)},
            }

        def at(point: Reals) -> Fitted:
            pattern = pattern_of(fit.samples.setting, last.effect, shape_at(point))
            assert not isinstance(pattern, str)
            return self.bench.fit(fit.samples, (*others, pattern), np.column_stack([rest, self.bench.decimated(pattern.columns)]))

        def square(point: Reals) -> float:
            return at(point).square(rows)

        start = np.array([last.shape[name] for name in names]) / scale
        found = minimize(square, start, method="Nelder-Mead", options={"xatol": 0.01, "fatol": 1e-6 * fit.square(rows), "maxfev": 120})
        best = at(found.x)
        return best if best.square(rows) < fit.square(rows) and not outside(best) and not self.judge.another(best, last.effect) else fit

    def indistinct(self, accepted: Fitted, effect: str) -> str:
        """Why these records cannot tell an effect from one that was accepted, whatever it gains; empty where they can."""
        known = self.patterns[effect]
        if isinstance(known, str):
            return ""
        known, _ = self._told_apart(accepted, effect, known)
        if not known:
            return SAME_SWING
        if record_of(effect).along is not None and self.bench.division.by != "record":
            return ONE_MOTION
        texture = next((one.effect for one in accepted.patterns if is_texture(accepted.samples.setting, one.effect, one.shape)), "")
        if texture and self.bench.division.by != "record" and is_texture(accepted.samples.setting, effect, known[0].shape):
            return f"{coded(texture)} was accepted, and one record of one motion does not tell textures along the way apart: record another motion"
        return ""

    def tried(self, accepted: Fitted, effect: str, asked: bool = False) -> Tried | Refusal:
        """The best permitted shape of an effect beside the accepted ones; one that was `asked` for is fitted though it may be the same as another."""
        known = self.patterns[effect]
        if isinstance(known, str):
            return Refusal(effect, known)
        why = self.indistinct(accepted, effect)
        if why and not asked:
            return Refusal(effect, why)
        apart, columns_of = self._told_apart(accepted, effect, known)
        known, columns_of = (apart, columns_of) if apart else (known, self.columns[effect])
        bench, rows = self.bench, self.bench.training
        if known[0].bends:
            fit = bench.searched(accepted, effect, known)
            if fit.square(rows) >= accepted.square(rows):
                return Refusal(effect, f"in no size it lowers the error of the {PARTS[bench.division.by]} fitted")
            return self._tried(accepted, effect, fit)
        basis, _ = np.linalg.qr(accepted.matrix[rows])
        ranked = []
        for pattern, columns in zip(known, columns_of, strict=True):
            here = columns[rows]
            own = here - basis @ (basis.T @ here)
            if np.linalg.norm(own) < _OWN * np.linalg.norm(here):
                continue
            solved_own = solved(own, accepted.residual[rows])
            ranked.append((float(np.sum((own @ solved_own) ** 2)), pattern, columns))
        if not ranked:
            return Refusal(effect, self.taken_up(self.columns[effect][0][rows], accepted.samples.base[rows]))
        if len(known) == 1 and _like(ranked[0][2][rows, 0], np.column_stack([accepted.samples.base, accepted.samples.drive])[rows]):
            return Refusal(effect, "it scales every torque alike: beside a given torque constant only ratios are known")
        ranked.sort(key=lambda one: -one[0])
        why = ""
        first: Fitted | None = None
        for gain, pattern, columns in ranked:
            if gain < _SHAPE_SHARE * ranked[0][0]:
                break
            fit = bench.fit(accepted.samples, (*accepted.patterns, pattern), np.column_stack([accepted.columns, columns]))
            first = first or fit
            refused = self.judge.another(fit, pattern.effect)
            if not refused:
                return self._tried(accepted, effect, fit)
            why = why or refused
        assert first is not None
        return Refusal(effect, why, _of(effect, first.values))

    def _told_apart(self, accepted: Fitted, effect: str, known: Sequence[Pattern]) -> tuple[Sequence[Pattern], list[Reals]]:
        """The patterns that can be another cause than what was accepted, with their columns: where no record says where the machine is, waves of whole multiples are one swing that is no pure sine."""
        columns = self.columns[effect]
        turns = [_periods(one) for one in accepted.patterns if record_of(one.effect).periodic is not None]
        if accepted.samples.setting.placed or record_of(effect).periodic is None or not turns:
            return known, columns
        kept = [place for place, one in enumerate(known) if not any(_multiples(_periods(one), other) for other in turns)]
        return [known[place] for place in kept], [columns[place] for place in kept]

    def taken_up(self, columns: Reals, base: Reals) -> str:
        """Which base value takes a pattern [samples, k] up."""
        if not np.any(columns):
            return NOT_HERE
        name = MECHANICAL_PARAMETERS[int(np.argmax(np.abs(base.T @ columns[:, 0]) / np.maximum(np.linalg.norm(base, axis=0), 1e-300)))]
        taker = coded(load_effect()) if name == LOAD and self.bench.load_named else value_coded(name)
        return f"no gain over {taker}, which is refitted at every step and takes the same torque up"

    def constant(self) -> tuple[Tried, Fitted, str]:
        """The change of the constant torque as the first effect, the base values without it, and why it is not added."""
        bench = self.bench
        before = bench.judged(bench.without_load())
        nothing = Tried(load_effect(), before, 0.0, np.zeros(int(bench.training.sum())))
        if LOAD in bench.fixes.kept:
            return nothing, before, f"{LOAD} is fixed"
        if load_effect() in bench.start.setting.actuator.active_effects:
            return nothing, before, f"the model has it already, and {LOAD}, which is refitted, takes up what is more of it"
        bench.load_named = True
        found = self._tried(before, load_effect(), bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0)))))
        why = self.judge.refusal(before, found) or self._as_zero(found.fit)
        bench.load_named = not why
        return found, before, why

    def loaded(self, accepted: Fitted) -> bool:
        """Whether something that the machine carries was accepted, so that a share of what is left is one of less than the first model left."""
        return self.bench.load_named or any(is_carried(one) for one in accepted.patterns)

    def carrying(self, accepted: Fitted) -> Fitted:
        """A fit with what the machine carries known wherever it hid something: the inertia, and what friction makes of the torque that the gears transmit."""
        carried = [one for one in accepted.patterns if is_carried(one)]
        seen = [(one.effect, tuple(one.shape.items())) for one in carried]
        if seen == self.carried:
            return accepted
        self.carried = seen
        bench, setting = self.bench, accepted.samples.setting
        bench.carry(np.column_stack([np.zeros((setting.rows, 0)), *(rows_of(setting, one) for one in carried)]))
        if carried:
            bench.release_inertia(accepted.patterns, accepted.columns)
        self.prepare(bench.with_bends(accepted.patterns).setting)
        return bench.judged(self.with_patterns(accepted.patterns, bench.with_bends(accepted.patterns)))

    def constant_beside(self, accepted: Fitted) -> tuple[Fitted, Fitted] | None:
        """The change of the constant torque as an effect beside what was accepted, without it and with it; None where it is none, or one already. A weight that swings hides it until it is known."""
        bench = self.bench
        if bench.load_named or LOAD in bench.fixes.as_stated or load_effect() in bench.start.setting.actuator.active_effects:
            return None
        if not self.loaded(accepted):
            return None
        before = bench.judged(bench.with_load_as_given(accepted))
        bench.load_named = True
        fit = bench.judged(self.with_patterns(accepted.patterns, accepted.samples))
        why = self.judge.refusal(before, self._tried(before, load_effect(), fit)) or self._as_zero(fit)
        bench.load_named = not why
        return None if why else (before, fit)

    @staticmethod
    def _as_zero(fit: Fitted) -> str:
        """Why a constant torque is none of the machine: it is no more than a sensor's zero."""
        size, friction = abs(fit.values[size_of_load()]), fit.values["screw.csj_Nm"]
        if size > _ZERO * friction:
            return ""
        return f"it is {100.0 * size / friction:.2g} % of the dry friction, which the zero of the drive's sensor may be off by"

    def same_as_load(self) -> tuple[str, ...]:
        """Effects that nothing but a constant torque is seen of."""
        rows = self.bench.training
        load = self.bench.start.base[rows, 3:]
        return tuple(
            effect
            for effect in self.effects
            if effect != load_effect()
            and len(self.columns[effect]) == 1
            and np.any(self.columns[effect][0])
            and _like(self.columns[effect][0][rows, 0], load, _AS_LOAD)
        )

    def beside_constant(self, first: Fitted) -> list[Tried]:
        """What every other effect of one value does of what the `first` model leaves, where the constant torque stays as given, the best first: alone either may be what the records show."""
        simple = [one for one in self.effects if len(load_definitions().effect(one).parameters) == 1 and not self.patterns_bend(one)]
        self.bench.load_named = False
        tried = [self.tried(first, effect) for effect in simple if effect != load_effect()]
        self.bench.load_named = True
        return sorted((one for one in tried if isinstance(one, Tried)), key=lambda one: -one.gain)

    def instead_of_constant(self, first: Fitted, constant: Tried, others: Sequence[Tried]) -> tuple[Tried, Fitted] | None:
        """The best of these that may be added and foretells every part better than the constant torque does, and the fit with it in its place; None where there is none."""
        same = self.same_as_load()
        self.bench.load_named = False
        for one in others:
            # what the machine carries is sought once a constant torque is known
            if one.gain <= constant.gain or one.effect in same or is_carried(one.fit.patterns[-1]):
                continue
            judged = replace(one, fit=self.bench.judged(one.fit))
            if judged.fit.errors.foretells_each_better(constant.fit.errors) and not self.judge.refusal(first, judged):
                fit = self.finished(self.with_patterns(one.fit.patterns, self.bench.start), False)
                if outside(fit):
                    break
                return judged, self.bench.judged(fit)
        self.bench.load_named = True
        return None

    def _tried(self, accepted: Fitted, effect: str, fit: Fitted) -> Tried:
        return Tried(effect, fit, self._gain(accepted, fit), (accepted.residual - fit.residual)[self.bench.training])

    def without_effects(self) -> None:
        """Takes for what the first model left that which the base values leave, the constant torque among them unless it is an effect of its own."""
        bench = self.bench
        first = bench.without_load() if bench.load_named else bench.fit(bench.start, (), np.zeros((bench.fold.size, 0)))
        self.judge.first = float(np.sum(first.residual[bench.training] ** 2))

    def judged_against(self, accepted: Fitted, effect: str, fit: Fitted) -> str:
        """Why an effect that was fitted, judged, should not be added; empty when it should."""
        return self.judge.refusal(accepted, self._tried(accepted, effect, fit))

    def round(self, accepted: Fitted, share: float) -> tuple[list[Tried], list[Refusal]]:
        """Every effect that is left: those that may be added, best first, and the others with the reason."""
        here = {pattern.effect for pattern in accepted.patterns} | ({load_effect()} if self.bench.load_named else set())
        general = {special: one for one in here if (special := record_of(one).special_case)}
        left = [one for one in self.effects if one not in here and one not in general and record_of(one).special_case not in here]
        untold = {one: value for one in left if (value := self._untold(one))}
        left = [one for one in left if one not in untold]
        added: list[Tried] = []
        refused = [
            Refusal(one, f"{coded(called(general[one]))} was accepted, of which it is a special case")
            for one in self.effects
            if one in general
        ]
        refused += [
            Refusal(one, f"it is one with {value_coded(value)}, which these records do not determine") for one, value in untold.items()
        ]
        for effect in self.effects:
            if effect not in here and record_of(effect).special_case in here:
                instead = self._instead(accepted, effect)
                if isinstance(instead, Refusal):
                    refused.append(instead)
                else:
                    added.append(instead)
        self.weak = []
        least = LEAST_OF_FIRST * self.judge.left_by_loads(accepted)
        for place, effect in enumerate(left):
            self.report(share + _ROUND_SHARE * place / len(left), effect)
            found = self.tried(accepted, effect)
            if isinstance(found, Refusal):
                refused.append(found)
                continue
            judged = replace(found, fit=self.bench.judged(found.fit))
            if self.bench.keep_barely_outside(judged.fit):
                return self.round(accepted, share)
            self.upsets_inertia |= found.gain >= least and unphysical(INERTIA, judged.fit)
            why = self.judge.refusal(accepted, judged)
            beyond = "" if why else self._another_than_its_special(judged)
            if beyond:
                refused.append(_refused(judged, beyond))
            elif why:
                self.weak.append(judged)  # which may be more beside another
                refused.append(_refused(judged, why))
            else:
                added.append(judged)
        needless = [one for one in added if self.needless(one, added)]
        refused += [
            Refusal(one.effect, f"{coded(called(record_of(one.effect).special_case))} does nearly as much with one value less")
            for one in needless
        ]
        return sorted((one for one in added if one not in needless), key=lambda one: -one.gain), refused

    def _untold(self, effect: str) -> str:
        """A base value that an effect is one with and that is taken as stated since the records do not determine it; empty where there is none."""
        own = record_of(effect).confounded
        return own.parameter if own is not None and self.bench.kept_because.get(own.parameter) == BY_RECORDS else ""

    def _another_than_its_special(self, tried: Tried) -> str:
        """Why an effect is not a general case of another one: what it adds to that one lies on an end of where it may be, even between the shapes tried; empty where it may be."""
        special = record_of(tried.effect).special_case
        if not special:
            return ""
        fields = {row.field for row in load_definitions().effect(special).parameters}
        fit = self.refined(tried.fit)
        for name in continuous_of(tried.effect):
            if name.partition(".")[2] not in fields and at_bound(name, fit.values[name]):
                return (
                    f"at a bound: {value_coded(name)} = {fit.values[name]:.3g}, which is no {coded(called(special))} that differs a little"
                )
        return ""

    def _instead(self, accepted: Fitted, effect: str) -> Tried | Refusal:
        """An effect in place of its special case, which was accepted: what it takes off beyond that one."""
        special = record_of(effect).special_case
        without = self.bench.judged(self._without(accepted, special))
        found = self.tried(without, effect)
        if isinstance(found, Refusal):
            return found
        judged = replace(found, fit=self.bench.judged(found.fit))
        gain = self._gain(accepted, judged.fit)
        if self.judge.slight(accepted, gain):
            why = f"{coded(special)} was accepted, which does nearly as much with one value less"
        else:
            why = self.judge.refusal(without, judged)
        return _refused(judged, why) if why else replace(judged, gain=gain)

    def _without(self, accepted: Fitted, effect: str) -> Fitted:
        """A fit without one of its effects."""
        rest = tuple(one for one in accepted.patterns if one.effect != effect)
        bends = any(one.bends for one in accepted.patterns if one.effect == effect)
        owners = [one.effect for one in accepted.patterns for _ in range(one.columns.shape[1])]
        columns = accepted.columns[:, [owner != effect for owner in owners]]
        return self.bench.fit(self.bench.with_bends(rest) if bends else accepted.samples, rest, columns)

    def _gain(self, before: Fitted, after: Fitted) -> float:
        """By how much a fit lowers the squared error of what is fitted."""
        rows = self.bench.training
        return float(np.sum(before.residual[rows] ** 2) - np.sum(after.residual[rows] ** 2))

    def needless(self, general: Tried, added: Sequence[Tried]) -> bool:
        """Whether an effect that is another one in a special case takes off too little beyond that one."""
        wanted = record_of(general.effect).special_case
        special = next((one for one in (*added, *self.weak) if one.effect == wanted and not outside(one.fit)), None)
        return special is not None and self.judge.share(special.fit, general.gain - special.gain) < LEAST_SHARE

    def pair(self, accepted: Fitted, added: Sequence[Tried]) -> tuple[Tried, Tried] | None:
        """Two effects, at least one of which may not be added alone, that each may beside the other: the pair that lowers the error most; the first of them as it is alone.

        One that stands in for another beside it goes wrong wherever the other is large, so that alone it raises the error of a part held out. `added`: what may be added alone; a pair is sought
        where nothing may, or where what takes off more than the best of it is refused.
        """
        least = LEAST_OF_FIRST * self.judge.left_by_loads(accepted)
        worth = [one for one in self.weak if one.gain >= least and not outside(one.fit)]
        stronger = {one.effect for one in worth if not added or one.gain > added[0].gain}
        worth = sorted([*worth, *added], key=lambda one: -one.gain)[:_PAIRED]
        best: tuple[Tried, Tried] | None = None
        for first, second in itertools.permutations(worth, 2):
            both = self._beside(first, second.effect) if {first.effect, second.effect} & stronger else None
            if both is None or (best is not None and both.fit.errors.training >= best[1].fit.errors.training):
                continue
            if self.loaded(accepted) and not _clear(first.fit, [both], _least(self.bench, first.fit))[0]:
                continue
            other = self.judged_against(second.fit, first.effect, both.fit)
            if not other and not self.judged_against(accepted, second.effect, both.fit):
                best = first, both
        return best

    def _beside(self, first: Tried, effect: str) -> Tried | None:
        """An effect beside another one that alone is refused; None where it is refused there, too."""
        # a balance that bends is made again from the one that bends, which then comes first
        if self.patterns_bend(effect):
            return None
        found = self.tried(first.fit, effect)
        if isinstance(found, Refusal):
            return None
        judged = replace(found, fit=self.bench.judged(self.refined(found.fit)))
        return None if self.judge.refusal(first.fit, judged) else judged

    def consistent(self, fit: Fitted) -> Fitted:
        """A fit whose patterns are those of its own base values, of which some are shares, and not of the values that were stated."""
        for _ in range(_BASE_ROUNDS if fit.patterns else 0):
            base = {name: fit.values[name] for name in (LEVEL, VISCOUS) if row_of(name).lower <= fit.values[name] <= row_of(name).upper}
            bends = {name: value for pattern in fit.patterns if pattern.bends for name, value in pattern.shape.items()}
            found = self.with_patterns(fit.patterns, self.bench.changed({**base, **bends}))
            if outside(found):
                return fit
            fit, before = found, fit
            if all(math.isclose(fit.values[name], value, rel_tol=_BASE_SAME, abs_tol=1e-300) for name, value in before.values.items()):
                break
        return fit

    def answer(
        self, actuator: Actuator, given: FoldErrors, first: Fitted, accepted: Fitted, steps: Sequence[ForceStep], refused: Sequence[Refusal]
    ) -> ForceSteps:
        """The whole of it."""
        bench = self.bench
        states = accepted.samples.setting.states
        curves = {
            "time_s": _time_s(bench),
            "position_mm": bench.kept(states.screw_mm),
            "speed_rad_s": bench.kept(states.speed_rad_s),
            "torque_Nm": accepted.samples.drive,
            "residual_before_Nm": first.residual,
            "residual_after_Nm": accepted.residual,
        }
        return ForceSteps(
            actuator.changed(accepted.values),
            given,
            first.errors,
            tuple(steps),
            (*refused, *self.unsought),
            floor_of(bench, accepted),
            bench.division,
            bench.records[0].period_s if len(bench.records) == 1 else None,
            curves,
            estimated_floor(bench, accepted),
            (foretold_percent(bench, first), foretold_percent(bench, accepted)),
            base_values(actuator, bench, bench.stated(accepted)),
            float(np.ptp(states.angle_rad)) / (2.0 * math.pi),
            first.values,
            math.sqrt(float(np.mean(accepted.samples.drive[bench.training] ** 2))),
        )

    def patterns_bend(self, effect: str) -> bool:
        """Whether an effect changes the balance itself."""
        known = self.patterns[effect]
        return not isinstance(known, str) and known[0].bends

    def pruned(self, accepted: Fitted) -> tuple[Fitted, tuple[str, ...]]:
        """Without each earlier effect that the others have made needless, and their names."""
        dropped = []
        for pattern in accepted.patterns[:-1]:
            without = self._without(accepted, pattern.effect)
            if self.judge.slight(without, self._gain(without, accepted)) and not outside(without):
                settled = self.settled(without)
                # columns of the others that were made beside it still hold what it does
                if outside(settled) or not self.judge.slight(settled, self._gain(settled, accepted)):
                    self.prepare(accepted.samples.setting)
                    continue
                accepted = settled
                dropped.append(pattern.effect)
        if self.bench.load_named and accepted.patterns:
            size = size_of_load()
            judged = self.bench.judged(accepted)
            held = self.bench.with_load_as_given(accepted)
            gain = self._gain(held, accepted)
            unseen = abs(judged.values[size]) < SIZE_IN_STD * judged.std.get(size, math.inf) or bool(self._as_zero(judged))
            if unseen or self.judge.slight(held, gain):
                self.bench.load_named = False
                unnamed = self.with_patterns(accepted.patterns, accepted.samples)
                if outside(unnamed):
                    self.bench.load_named = True
                else:
                    accepted = unnamed
                    dropped.append(load_effect())
        return (self.bench.judged(accepted) if dropped else accepted), tuple(dropped)

    def raises(self, accepted: Fitted) -> tuple[str, Fitted] | None:
        """An effect without which neither what is fitted nor what is held out is told worse, and the fit without it: what helped beside the base values as they were need not beside its own."""
        for pattern in reversed(accepted.patterns):
            rest = tuple(one for one in accepted.patterns if one is not pattern)
            without = self.bench.judged(self.consistent(self.with_patterns(rest, self.bench.with_bends(rest))))
            pairs = ((without.errors.training, accepted.errors.training), (without.errors.holdout, accepted.errors.holdout))
            if not outside(without) and all(one <= other for one, other in pairs if math.isfinite(other)):
                return pattern.effect, without
        return None

    def simplified(self, accepted: Fitted) -> tuple[Fitted, dict[str, str]]:
        """With the special case in place of each effect that does hardly more beside the others, and what stands for what."""
        instead: dict[str, str] = {}
        for pattern in accepted.patterns:
            special = record_of(pattern.effect).special_case
            if special not in self.effects or any(one.effect == special for one in accepted.patterns):
                continue
            rest = tuple(one for one in accepted.patterns if one.effect != pattern.effect)
            without = self.bench.judged(self.with_patterns(rest, self.bench.with_bends(rest) if pattern.bends else accepted.samples))
            found = self.tried(without, special)
            if isinstance(found, Refusal):
                continue
            fit = self.bench.judged(self.finished(found.fit, found.fit.patterns[-1].bends))
            if self.judge.slight(fit, self._gain(fit, accepted)) and not self.judge.refusal(without, self._tried(without, special, fit)):
                accepted, instead[pattern.effect] = fit, special
        return accepted, instead


def _clear(accepted: Fitted, added: Sequence[Tried], least: float) -> tuple[list[Tried], list[Refusal]]:
    """Of effects that may be added those that are clear where the error is no more than `least`, which records differ by as well, and the others with the reason."""
    error = accepted.errors.training
    clear = [one for one in added if error > least or one.fit.errors.training <= CLEARLY * error]
    why = f"an error of {error:.3g} % by which records that do the same may differ"
    refused = [_refused(one, f"it lowers to {one.fit.errors.training:.3g} % {why}") for one in added if one not in clear]
    return clear, refused


def _refused(tried: Tried, why: str) -> Refusal:
    """An effect that was fitted and judged, and is not added."""
    fit = tried.fit
    return Refusal(tried.effect, why, _of(tried.effect, fit.values), _of(tried.effect, fit.std), fit.errors)


def _of(effect: str, values: Mapping[str, float]) -> dict[str, float]:
    """The values of one effect that are numbers."""
    return {name: value for name, value in values.items() if name.startswith(f"{effect}.") and math.isfinite(value)}


def _periods(pattern: Pattern) -> float:
    """Of a wave per turn of the motor, one where its effect has no such number."""
    return float(pattern.shape.get(f"{pattern.effect}.periods", 1.0))


def _multiples(one: float, other: float) -> bool:
    ratio = max(one, other) / min(one, other)
    return abs(ratio - round(ratio)) < _WHOLE


def _like(column: Reals, others: Reals, share: float = _OWN) -> bool:
    """Whether a column [samples] is a sum of others [samples, k], but for a share of its length."""
    return float(np.linalg.norm(column - others @ solved(others, column))) < share * float(np.linalg.norm(column))


def _class_of(best: Tried, tried: Sequence[Tried]) -> tuple[str, ...]:
    """What lowers the error nearly as much as the best and by the same torque, and what the library says looks like it."""
    found = []
    for other in tried:
        cosine = abs(float(best.part @ other.part)) / float(np.linalg.norm(best.part) * np.linalg.norm(other.part))
        if other is not best and other.gain > _CLASS_GAIN * best.gain and cosine > _CLASS_COSINE:
            found.append(other.effect)
    declared = [
        name
        for name in load_definitions().effect(best.effect).look_alikes
        if any(other.effect == name and other.gain > _CLASS_GAIN * best.gain for other in tried)
    ]
    return tuple(dict.fromkeys([*found, *declared]))


def _renamed(step: ForceStep, instead: Mapping[str, str]) -> ForceStep:
    """A step by the effect that stands in place of its own."""
    name = instead.get(step.effect, step.effect)
    return replace(step, effect=name, alike=tuple(one for one in step.alike if one != name))


def improve_by_forces(
    actuator: Actuator,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord] = (),
    progress: Report | None = None,
    fixes: Fixes = NONE,
    veto: Veto | None = None,
) -> ForceSteps:
    """Add what the mechanical balance of the records asks for, effect by effect, `holdout` never being fitted; `progress` is told the share done and what is at work.

    Where the actuator does not state by how much the drive records late, that is fitted as a base value is, and kept where it explains the records better than effects alone.
    Raises MissingSignal when a record has no mechanical balance.
    """
    return with_lag_fitted(
        lambda known, report: _fewest(known, records, holdout, report, fixes, veto), actuator, records, holdout, fixes, progress
    )


def _fewest(
    actuator: Actuator, records: Sequence[AnyRecord], holdout: Sequence[AnyRecord], report: Report, fixes: Fixes, veto: Veto | None
) -> ForceSteps:
    """The effects that lower the error, without a constant torque where the motion sees hardly more than one turn of a wave beside it and the wave alone does as well: an arm's weight is both."""
    found = _improved(actuator, records, holdout, report, fixes, veto)
    if not any(_is_slow_wave(step, found) for step in found.steps) or load_effect() not in [step.effect for step in found.steps]:
        return found
    other = _improved(actuator, records, holdout, report, fixes.without(LOAD), veto)
    pairs = ((other.errors.training, found.errors.training), (other.errors.holdout, found.errors.holdout))
    does_as_well = all(one <= _AS_WELL * beside for one, beside in pairs if math.isfinite(beside))
    return other if does_as_well and 0 < len(other.steps) < len(found.steps) else found


def _is_slow_wave(step: ForceStep, found: ForceSteps) -> bool:
    """Whether an effect is a wave of which the motion sees hardly more than one turn."""
    periods = step.values.get(f"{step.effect}.periods", math.inf)
    return record_of(step.effect).periodic is not None and periods * found.motor_turns < _ONE_TURN


def _improved(
    actuator: Actuator,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord],
    report: Report,
    fixes: Fixes,
    veto: Veto | None,
) -> ForceSteps:
    """The same with the drive as late as the actuator says, at once where it says nothing."""
    report(0.0, "parts and balance")
    bench = Bench(actuator, records, holdout, fixes)
    if few := too_few(actuator, bench):
        raise InputError(f"{records[0].file}: {few}")
    search = ForceSearch(bench, report, veto=veto)
    bench.keep_inertia()
    search.prepare(bench.start.setting)
    given = given_errors(actuator, bench)
    steps: list[ForceStep] = []
    refused: list[Refusal] = []
    needless: list[Refusal] = []
    constant, first, why = search.constant()
    if why:
        first = accepted = bench.judged(bench.fit(bench.start, (), np.zeros((bench.fold.size, 0))))
    else:
        accepted = constant.fit
        others = search.beside_constant(first)
        better = search.instead_of_constant(first, constant, others)
        if better is None:
            alike = (*search.same_as_load(), *_class_of(constant, others))
            steps.append(_step(search, load_effect(), first, accepted, tuple(dict.fromkeys(alike))))
        else:
            best, accepted = better
            steps.append(_step(search, best.effect, first, accepted, _class_of(best, [constant, *others])))
    count = len(steps)
    while True:
        added, refused = search.round(accepted, min(0.1 + _ROUND_SHARE * count, 0.85))
        if search.upsets_inertia:
            return _improved(actuator, records, holdout, report, fixes.without(INERTIA), veto)
        if not steps or search.loaded(accepted):
            # what takes off a share of what was there before any load was known is no chance of a smaller error
            large = [one for one in added if steps and one.gain >= LEAST_OF_FIRST * search.judge.first]
            clear, slight = _clear(accepted, [one for one in added if one not in large], _least(bench, accepted if steps else first))
            added = [one for one in added if one in large or one in clear]
            refused += slight
        pair = search.pair(accepted, added) if all(is_carried(one) for one in accepted.patterns) else None
        if pair is None and not added:
            break
        if pair is None and count >= EFFECTS_MAX:
            refused += [_refused(one, MANY) for one in added]
            break
        before = accepted
        if pair is not None:
            first_of, best = pair
            steps.append(_step(search, first_of.effect, accepted, first_of.fit))
            before, bent = first_of.fit, first_of.fit.patterns[-1].bends
        else:
            best = added[0]
            bent = best.fit.patterns[-1].bends
        # what the records show too weakly to name it may explain as much
        weak = [one for one in search.weak if not outside(one.fit) and not search.judge.another(one.fit, one.effect)]
        alike = _class_of(best, [*added, *weak]) if pair is None else ()
        special = record_of(best.effect).special_case
        if special and any(one.effect == special for one in before.patterns):
            needless.append(Refusal(special, f"a special case of {coded(called(best.effect))}, which came later and does more"))
        accepted = bench.judged(search.finished(best.fit, bent))
        accepted, instead = search.simplified(accepted)
        steps.append(_step(search, best.effect, before, accepted, alike))
        count += 1 if pair is None else len(pair)
        steps = [_renamed(one, instead) for one in steps]
        accepted, dropped = search.pruned(accepted)
        needless += [Refusal(name, f"needless beside {coded(called(steps[-1].effect))}, which came later") for name in dropped]
        accepted = search.carrying(accepted)
        steps = _in_model(steps, accepted, bench)
        loaded = search.constant_beside(accepted)
        if loaded is not None and count < EFFECTS_MAX:
            without, accepted = loaded
            steps.append(_step(search, load_effect(), without, accepted, search.same_as_load()))
            count += 1
    if steps and accepted.errors.training > _NO_MODEL:
        why = f"with what was found {accepted.errors.training:.3g} % of the drive stays: too much for a name"
        needless += [Refusal(step.effect, why, _of(step.effect, step.values), _of(step.effect, step.std), step.errors) for step in steps]
        steps, accepted = [], first
    accepted = bench.judged(search.consistent(accepted))
    while (raising := search.raises(accepted)) is not None:
        name, accepted = raising
        needless.append(Refusal(name, "beside the others it lowers neither the error of what is fitted nor that of what is held out"))
    if steps:
        steps = _in_model(steps, accepted, bench, bench.stated(accepted).std)
    here = {one.effect for one in steps}
    refused = [*needless, *(one for one in refused if one.effect not in {gone.effect for gone in needless})]
    report(1.0, "done")
    return search.answer(actuator, given, first, accepted, steps, [one for one in refused if one.effect not in here])


def _least(bench: Bench, fit: Fitted) -> float:
    """The error in % by which records that do the same may differ in what a fit leaves; laps that differ may be what an effect does to them."""
    repeats = floor_of(bench, fit)
    if math.isfinite(repeats):
        return repeats
    estimated = estimated_floor(bench, fit)
    return (_AS_FLOOR if estimated.compared else _AS_NOISE) * estimated.percent


def _step(search: ForceSearch, effect: str, before: Fitted, after: Fitted, alike: tuple[str, ...] = ()) -> ForceStep:
    """An effect that was added."""
    return ForceStep(effect, after.values, after.std, alike, after.errors, search.judge.elsewhere(before, after))


def _in_model(steps: Sequence[ForceStep], accepted: Fitted, bench: Bench, std: Mapping[str, float] | None = None) -> list[ForceStep]:
    """The steps whose effects are in the model, each once and where it came last; the last of them with the values and errors of the model as it is."""
    names = {one.effect for one in accepted.patterns} | ({load_effect()} if bench.load_named else set())
    later = [{other.effect for other in steps[place + 1 :]} for place in range(len(steps))]
    kept = [step for step, after in zip(steps, later, strict=True) if step.effect in names and step.effect not in after]
    if kept:
        kept[-1] = replace(kept[-1], values=accepted.values, std=accepted.std if std is None else std, errors=accepted.errors)
    return kept


def _time_s(bench: Bench) -> Reals:
    """Time of the samples, each record beginning where the one before it ended, [samples]."""
    times, end = [], bench.records[0].first_time_s
    for record in bench.records:
        times.append(end + record.time_s - record.first_time_s)
        end += record.rows * record.period_s
    return bench.kept(np.concatenate(times))
