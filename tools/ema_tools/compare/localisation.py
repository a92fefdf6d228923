"""Where a model fails: which balance holds the excess, what it is proportional to, in which parts of the record it lies, and the data of the pictures.

With healthy repeats of the same command everything is the record minus their mean, and the floor is how the repeats differ among themselves; without them it is measured minus model, and the floor
is what sensor noise and the method leave. A balance is accused when what one simple term explains of it, or its whole size, exceeds the floor: sensor noise is spread over all
of a record, an effect is not, so the term sees what the size alone does not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ema_tools.balances.all import BALANCES, all_balances
from ema_tools.balances.balance import Balance
from ema_tools.balances.filtering import Smoother, coarse, thinned
from ema_tools.balances.mechanical import filter_of
from ema_tools.base.arrays import Reals
from ema_tools.compare.axes import Axis, MachineState, explained, fitted_energy, machine_state_of
from ema_tools.compare.comparison import FLOOR_MARGIN, TITLES, ErrorPart, divided, judged_balances, states_of
from ema_tools.compare.readings import ReadingError, reading_error
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, simulated
from ema_tools.fit.nuisance import share_from_run_to_run
from ema_tools.fit.whitening import Whitener, counted, spectrum
from ema_tools.plant.native import CHANNELS
from ema_tools.results import localisation as picture
from ema_tools.results.codec import Series
from ema_tools.results.localisation import Pictures

# What a term explains must exceed the most that any term explains of a healthy repeat by this factor; with healthy repeats only [judgement]
_TERM_MARGIN = 2.5
# And the variance of so many independent samples: the best of a dozen terms on white noise, with room for noise that is not white [chance]
_TERM_VARIANCES = 40.0
_TERM_LEAST = 0.02  # and this share on passes that it was not fitted to, or it is chance [judgement]
_TERM_SHARE = 0.1  # without repeats: it must explain this share on passes that it was not fitted to [judgement]
_SELDOM = 3.0  # standard deviations of the usual scatter that count as one more repeat: more is seldom [chance]
_WINNER_SHARE = 0.25  # a term that explains less of the excess is no description [judgement]
_SLOW_RAD_S = 10.0  # near standstill: the speeds of a Stribeck bump [physics]
_BINS = 24  # of a picture of means over an axis [layout]
_POINTS_MAX = 1200  # of a picture: more are not told apart [layout]
_DIGITS = 5  # of numbers that only a picture needs [layout]
_PLACES_MAX = 24  # of the list of where the error is largest [layout]
# Lines per turn of the motor in the spectrum over angle: beyond, the balance's filter passes little [layout]
_MOTOR_ORDERS = np.arange(1.0, 40.5)
_SEEN_SHARE = 0.01  # an order is drawn when this share of it passes the balance's filter ... [judgement]
_DISTINCT = 100.0  # ... and its sine and cosine differ on the stroke: the condition number of the two stays below this [judgement]
_LEAD_ORDERS = np.arange(0.5, 12.1, 0.5)  # the same per turn of the screw, whose stroke is few turns: halves too [layout]


@dataclass(frozen=True)
class Term:
    """A simple description of a residual: `words` after "proportional to" or alike; share explained out of sample; coefficient of the first column in the balance's unit."""

    words: str
    explained: float
    energy: float
    coefficient: float


@dataclass(frozen=True)
class Block:
    """One balance: its excess. `rms` of what is judged, `floor_rms` of repeats, or of noise and method; `share` of the excess of all balances; `terms` best first; or the reason why there is none."""

    name: str
    unit: str
    rms: float
    floor_rms: float
    relative_percent: float
    share: float
    telling: bool
    terms: tuple[Term, ...]
    reason: str = ""

    @property
    def beyond(self) -> float:
        """Share of the squared residual that the floor does not explain."""
        return max(0.0, 1.0 - (self.floor_rms / self.rms) ** 2) if self.rms > 0.0 else 0.0

    def of_excess(self, term: Term) -> float:
        """Share of the excess that a term explains."""
        return min(1.0, max(term.explained, 0.0) / max(self.beyond, term.explained, 1e-9))

    @property
    def winner(self) -> Term | None:
        """The term that describes the excess, where one does."""
        return self.terms[0] if self.telling and self.terms and self.of_excess(self.terms[0]) >= _WINNER_SHARE else None


@dataclass(frozen=True)
class Channel:
    """One signal of the closed loop: rms of the judged difference, of the floor, and its share of the squared residual in units of the floor."""

    name: str
    rms: float
    floor_rms: float
    share: float


@dataclass(frozen=True)
class Reference:
    """A balance of the healthy repeats: their mean residual, how each differs from it, as large as a further run would, and what the usual scatter makes of it, [n, samples],
    and the rms of the repeats' part."""

    mean: Reals
    deviations: Reals
    floor_rms: float


@dataclass(frozen=True)
class Where:
    """The whole answer on the record called `record`. `references`: by balance what healthy repeats say; `smoother`: the filter of all balances. `residuals`: by balance what is judged,
    on coarse samples; `pictures`: data that the page draws; `reading`: the error of one sensor's reading that explains it."""

    record: str
    relative: bool
    blocks: tuple[Block, ...]
    channels: tuple[Channel, ...]
    places: tuple[ErrorPart, ...]
    pictures: Pictures
    residuals: dict[str, Balance] = field(repr=False)
    references: dict[str, Reference] = field(repr=False)
    smoother: Smoother = field(repr=False)
    reading: ReadingError | None = None


def short(values: Reals) -> Series:
    """Values [n] with the digits that a picture needs."""
    return tuple(float(f"{value:.{_DIGITS}g}") for value in values)


def mean_record(records: Sequence[Record]) -> Record:
    """The mean of repeats of one command, in the signals that all have."""
    names = [name for name in records[0].present if all(name in record.present for record in records)]
    absent: dict[str, Any] = {name: None for name in records[0].present if name not in names}
    means = {name: np.mean([record.recorded(name) for record in records], axis=0) for name in names}
    return replace(records[0], **absent).with_columns(means)


def terms_of(balance: str, motion: MachineState) -> dict[str, list[Reals]]:
    """Simple terms on samples, by what is said of them; several columns where a term has a phase. All [samples]."""
    w, a, x = motion.speed_rad_s, motion.acceleration_rad_s2, motion.position_mm
    one, sign = np.ones_like(w), motion.direction
    turn = 2.0 * math.pi * motion.motor_mm / motion.lead_mm
    wave = [np.sin(turn), np.cos(turn)]
    terms = {
        "constant": [one],
        "proportional to speed": [w],
        "with the sign of the motion": [sign],
        "proportional to acceleration": [a],
        "proportional to position": [x],
    }
    if motion.current_A is not None:
        i = motion.current_A
        size = max(float(np.max(np.abs(i))), 1e-9)
        terms["proportional to current"] = [i]
        terms["with the sign of the current"] = [np.tanh(i / (0.05 * size))]
    # below one lead it cannot be told from position
    turns = float(np.ptp(motion.motor_mm)) >= motion.lead_mm
    if turns:
        terms["once per screw lead"] = wave
    if balance in ("mechanical", "electrical"):
        terms["proportional to the square of the speed"] = [w * np.abs(w)]
    if balance == "mechanical":
        slow = np.exp(-np.abs(w) / _SLOW_RAD_S)
        terms["as friction near standstill"] = [sign * slow]
        if turns:
            terms["as friction once per screw lead"] = [sign * wave[0], sign * wave[1]]
        terms["proportional to the size of the speed"] = [np.abs(w)]
        terms["proportional to the root of the speed"] = [sign * np.sqrt(np.abs(w))]
        terms["in the first moments after a reversal"] = [sign * np.exp(-motion.since_reversal_s / 0.02)]
        if motion.current_A is not None:
            terms["as friction that grows with the motor torque"] = [sign * np.abs(motion.current_A)]
    if balance == "electrical" and motion.current_A is not None and motion.voltage_V is not None:
        terms["proportional to the applied voltage"] = [motion.voltage_V]
        terms["proportional to voltage times current"] = [motion.voltage_V * np.abs(motion.current_A)]
    if balance == "controller" and motion.voltage_V is not None:
        terms["proportional to the controller's output"] = [motion.voltage_V]
    return terms


@dataclass(frozen=True)
class Lines:
    """Sines and cosines of orders of an angle, as the filter of the balances leaves them, [orders, samples, 2]; `name` says of what an order is a multiple."""

    name: str
    orders: Reals
    waves: Reals

    @staticmethod
    def of(name: str, angle_rad: Reals, orders: Reals, smoother: Smoother) -> Lines:
        """From the angle on every row, [rows]."""
        phase = orders[:, None] * angle_rad
        smooth = smoother.smooth(np.concatenate([np.sin(phase), np.cos(phase)]))
        kept = thinned(smooth[:, smoother.edge_rows : -smoother.edge_rows], smoother.every)
        return Lines(name, orders, np.stack([kept[: orders.size], kept[orders.size :]], axis=2))

    def amplitudes(self, residual: Reals, at: MachineState) -> tuple[Reals, Reals]:
        """Amplitude of every order by least squares over the angle, which also holds for motion to and fro, and what noise of the residual's size makes of it, both
        [orders]; NaN where the filter leaves too little of an order."""
        # a constant, the sign of the motion and the speed are no lines
        moving = at.moving
        trend = np.column_stack([np.ones_like(at.direction), at.direction, at.speed_rad_s])[moving]
        left = residual[moving] - trend @ np.linalg.lstsq(trend, residual[moving], rcond=None)[0]
        waves = self.waves[:, moving]
        normal = np.einsum("osi,osj->oij", waves, waves)
        power = np.trace(normal, axis1=1, axis2=2)
        seen = (power > _SEEN_SHARE * left.size) & (np.linalg.cond(normal + 1e-12 * np.eye(2)) < _DISTINCT)
        found, chance = np.full(self.orders.size, math.nan), np.full(self.orders.size, math.nan)
        if np.any(seen):
            solved = np.linalg.solve(normal[seen], np.einsum("osi,s->oi", waves[seen], left)[..., None])
            found[seen] = np.linalg.norm(solved[..., 0], axis=1)
            chance[seen] = 2.0 * np.sqrt(np.mean(left**2) / power[seen])
        return found, chance

    def strongest(self, residual: Reals, at: MachineState) -> tuple[str, list[Reals]] | None:
        """The order that stands out most, as a term."""
        amplitudes, chance = self.amplitudes(residual, at)
        if not np.any(chance > 0.0):
            return None
        place = int(np.nanargmax(amplitudes / np.where(chance > 0.0, chance, math.nan)))
        return f"in {self.orders[place]:g} periods per {self.name}", [self.waves[place, :, 0], self.waves[place, :, 1]]


def lines_of(motion: MachineState, smoother: Smoother) -> tuple[Lines, Lines]:
    """Orders per motor turn and per screw lead."""
    return Lines.of("motor turn", motion.angle_rad, _MOTOR_ORDERS, smoother), Lines.of(
        "screw lead", 2.0 * math.pi / motion.lead_mm * motion.motor_mm, _LEAD_ORDERS, smoother
    )


def _terms(balance: Balance, motion: MachineState, lines: Sequence[Lines]) -> tuple[Term, ...]:
    """Every term with what it explains, best first."""
    at = motion.at(balance.time_s)
    half = at.halves()
    offered = terms_of(balance.name, at)
    if balance.name == "mechanical":
        strongest = lines[0].strongest(balance.residual, at)
        offered |= dict([strongest]) if strongest else {}
    found = []
    for words, parts in offered.items():
        columns = np.column_stack(parts)
        if not np.all(np.linalg.norm(columns, axis=0) > 0.0):
            continue
        share = explained(balance.residual, columns, half)
        coefficient = float(np.linalg.lstsq(columns, balance.residual, rcond=None)[0][0])
        found.append(Term(words, share, fitted_energy(balance.residual, columns), coefficient))
    return tuple(sorted(found, key=lambda term: -term.explained))


def _usual(actuator: Actuator, name: str, at: MachineState) -> list[Reals]:
    """What the scatter of friction, grease and winding from run to run, as stated or as usual, makes of a balance, as large as it is seldom, [samples] each."""
    found = []
    for balance, value, direction in (
        ("mechanical", "screw.csj_Nm", at.direction),
        ("mechanical", "screw.viscous_Nm_s_per_rad", at.speed_rad_s),
        ("electrical", "motor.resistance_ohm", at.current_A),
    ):
        share = share_from_run_to_run(actuator, value)
        if balance == name and direction is not None and share > 0.0:
            found.append(_SELDOM * share * actuator[value] * direction)
    return found


# Blocks, and by balance: what is judged, what healthy repeats say, and the rms of noise in what is judged.
_Judged = tuple[list[Block], dict[str, Balance], dict[str, Reference], dict[str, float]]


def _blocks_against_repeats(
    actuator: Actuator, record: Record, healthy: Sequence[Record], smoother: Smoother, motion: MachineState, lines: Sequence[Lines]
) -> _Judged:
    """Blocks with share 0 yet, and their judged residuals. The mean is taken of the balances, not of the signals: a play takes noise to one side."""
    count = len(healthy)
    here, *repeats = (_coarsened(all_balances(actuator, like, smoother), smoother) for like in (record, *healthy))
    blocks, residuals, references, noise = [], {}, {}, {}
    for name in BALANCES:
        mine, own = here[name], [repeat[name] for repeat in repeats]
        there = [one for one in own if isinstance(one, Balance)]
        if isinstance(mine, str) or len(there) < count:
            why = mine if isinstance(mine, str) else f"{next(one for one in own if isinstance(one, str))} in a healthy record"
            blocks.append(_absent(name, why))
            continue
        middle = np.mean([one.residual for one in there], axis=0)
        judged = replace(mine, residual=mine.residual - middle)
        widen = math.sqrt((1.0 + 1.0 / count) * count / (count - 1))
        deviations = widen * np.array([one.residual - middle for one in there])
        floor = float(np.sqrt(np.mean(deviations**2)))
        # few repeats seldom show the whole of what is usual
        usual = _usual(actuator, name, motion.at(mine.time_s))
        deviations = np.vstack([deviations, *usual])
        wide = math.sqrt(floor**2 + sum(float(np.mean(one**2)) for one in usual))
        terms = _terms(judged, motion, lines)
        limit = _TERM_MARGIN * max(
            (term.energy for one in deviations for term in _terms(replace(mine, residual=one), motion, lines)), default=0.0
        )
        limit = max(limit, _TERM_VARIANCES * floor**2)
        loud = judged.rms > FLOOR_MARGIN * wide
        telling = loud or any(term.energy > limit and term.explained > _TERM_LEAST for term in terms)
        blocks.append(Block(name, mine.unit, judged.rms, floor, _relative(judged), 0.0, telling, terms))
        residuals[name] = judged
        references[name], noise[name] = Reference(middle, deviations, floor), floor
    return blocks, residuals, references, noise


def _blocks_against_model(actuator: Actuator, record: Record, smoother: Smoother, motion: MachineState, lines: Sequence[Lines]) -> _Judged:
    """The same against the model, where noise and method are the floor."""
    found, errors = judged_balances(actuator, record, simulated(actuator, record), smoother)
    blocks, residuals, coarse_noise = [], {}, {}
    for name, one in _coarsened(found, smoother).items():
        if isinstance(one, str):
            blocks.append(_absent(name, one))
            continue
        fine = errors[name]
        # noise is judged before the coarsening, which takes most of it away
        terms = _terms(one, motion, lines)
        floor = math.hypot(fine.noise_rms, fine.method_rms)
        coarse_noise[name] = floor * one.rms / fine.rms if fine.rms > 0.0 else floor
        noise = one.residual.size * coarse_noise[name] ** 2
        telling = fine.rms > FLOOR_MARGIN * floor or any(
            term.explained > _TERM_SHARE and term.energy > 0.5 * noise and fine.rms > 1.05 * floor for term in terms
        )
        blocks.append(Block(name, one.unit, fine.rms, floor, fine.relative_percent, 0.0, telling, terms))
        residuals[name] = one
    return blocks, residuals, {}, coarse_noise


def _coarsened(found: dict[str, Balance | str], smoother: Smoother) -> dict[str, Balance | str]:
    return {name: one if isinstance(one, str) else coarse(one, smoother) for name, one in found.items()}


def _absent(name: str, why: str) -> Block:
    return Block(name, "", math.nan, math.nan, math.nan, 0.0, False, (), why)


def _relative(balance: Balance) -> float:
    value = balance.relative_percent
    return value if math.isfinite(value) else 0.0


def _with_shares(blocks: Sequence[Block]) -> tuple[Block, ...]:
    """Each telling block's share of the excess: of its relative size, without the floor's part or as far as its best term carries it."""

    def weight(block: Block) -> float:
        if not block.telling:
            return 0.0
        best = max((term.explained for term in block.terms), default=0.0)
        return block.relative_percent**2 * min(1.0, max(block.beyond, best, 0.0))

    total = sum(map(weight, blocks))
    return tuple(replace(block, share=weight(block) / total if total > 0.0 else 0.0) for block in blocks)


def _channel_residuals(actuator: Actuator, record: Record, mean: Record | None) -> dict[str, Reals]:
    """Closed-loop residual of every signal [rows]: minus the mean of the repeats, or minus the model."""
    if mean is not None:
        return {name: record.recorded(name) - mean.recorded(name) for name in CHANNELS if name in record.present and name in mean.present}
    run = simulated(actuator, record)
    return {name: record.recorded(name) - getattr(run, name) for name in CHANNELS if name in record.present}


def _channels(
    record: Record,
    healthy: Sequence[Record],
    mean: Record | None,
    residuals: dict[str, Reals],
    whiten: Whitener | None,
    names: Sequence[str],
) -> tuple[list[Channel], dict[str, Reals]]:
    """Every signal's error and its residual in units of the floor [rows]; `whiten` of the signals `names` where there is one, else the rms of floor or signal."""
    units: dict[str, Reals] = {}
    floors: dict[str, float] = {}
    for name, residual in residuals.items():
        if mean is not None:
            count = len(healthy)
            scatter = [float(np.mean((one.recorded(name) - mean.recorded(name)) ** 2)) for one in healthy]
            floors[name] = math.sqrt(sum(scatter) / (count - 1) * (1.0 + 1.0 / count))
        else:
            floors[name] = math.nan
        if whiten is not None and name in names:
            weights = whiten.weights[list(names).index(name)].copy()
            rows = counted(residual.size)
            last = weights.size - 1 if rows % 2 == 0 else weights.size
            weights[1:last] /= math.sqrt(2.0)
            units[name] = np.zeros_like(residual)
            units[name][:rows] = np.fft.irfft(spectrum(residual[None, :])[0] * weights, n=rows, norm="ortho")
        else:
            scale = floors[name] if mean is not None else float(np.sqrt(np.mean(record.recorded(name) ** 2)))
            units[name] = residual / scale if scale > 0.0 else np.zeros_like(residual)
    total = sum(float(values @ values) for values in units.values())
    channels = [
        Channel(name, float(np.sqrt(np.mean(residual**2))), floors[name], float(units[name] @ units[name]) / total if total > 0.0 else 0.0)
        for name, residual in residuals.items()
    ]
    return sorted(channels, key=lambda one: -one.share), units


def where(
    actuator: Actuator, record: Record, healthy: Sequence[Record] = (), whiten: Whitener | None = None, whitened: Sequence[str] = ()
) -> Where:
    """Where the model fails on a record; with healthy repeats of its command, where the record differs from them. `whiten` of the signals `whitened`: the noise's own filter, where it is known.

    Raises InputError when the model refuses the actuator.
    """
    mean = mean_record(healthy) if len(healthy) > 1 else None
    smoother = filter_of(actuator, record)
    motion = machine_state_of(actuator, record, smoother)
    lines = lines_of(motion, smoother)
    if mean is not None:
        raw, residuals, references, noise = _blocks_against_repeats(actuator, record, healthy, smoother, motion, lines)
    else:
        raw, residuals, references, noise = _blocks_against_model(actuator, record, smoother, motion, lines)
    blocks = _with_shares(raw)
    fails = any(block.telling for block in blocks)
    reading = reading_error(actuator, record, residuals, noise, smoother) if fails else None
    errors = _channel_residuals(actuator, record, mean)
    channels, units = _channels(record, healthy, mean, errors, whiten, whitened)
    places = _places(actuator, record, blocks, residuals, units, smoother)
    pictures = _pictures(actuator, record, smoother, motion, lines, residuals, mean)
    return Where(
        record.file,
        mean is not None,
        blocks,
        tuple(channels),
        places,
        pictures,
        residuals,
        references,
        smoother,
        reading,
    )


def _places(
    actuator: Actuator, record: Record, blocks: Sequence[Block], residuals: dict[str, Balance], units: dict[str, Reals], smoother: Smoother
) -> tuple[ErrorPart, ...]:
    """Parts of every telling balance and of every signal, the most telling first."""
    states = states_of(actuator, record)
    places: list[ErrorPart] = []
    for block in blocks:
        if block.telling:
            places += divided(f"{block.name} balance", residuals[block.name], states, record.first_time_s)
    for name, values in units.items():
        error = Balance(name, "", smoother.inner(record.time_s), smoother.inner(record.recorded(name)), smoother.inner(values))
        places += divided(TITLES[name], error, states, record.first_time_s)
    kept = [place for place in places if place.surprise > 0.0 or (place.time_share is None and place.share > 0.2)]
    return tuple(sorted(kept, key=lambda place: (-place.surprise, -place.share))[:_PLACES_MAX])


@dataclass(frozen=True)
class Bins:
    """A residual over an axis in equal bins: centres, mean, the band of one standard deviation, and the shares of its square and of the samples, all [bins]; empty bins left out."""

    centers: Reals
    mean: Reals
    low: Reals
    high: Reals
    share: Reals
    time_share: Reals

    @property
    def steady(self) -> float:
        """Mean square of the bins' means."""
        return float(np.sum(self.time_share * self.mean**2))

    def drawn(self) -> picture.BinsEntry:
        """With the digits that a picture needs."""
        return picture.BinsEntry(*map(short, (self.centers, self.mean, self.low, self.high, 100.0 * self.share, 100.0 * self.time_share)))


def binned(axis: Axis, values: Reals, bins: int = _BINS) -> Bins | None:
    """Values [samples] over an axis; None when the axis does not change."""
    low, high = float(np.min(axis.values)), float(np.max(axis.values))
    if not high > low:
        return None
    index = np.clip(((axis.values - low) / (high - low) * bins).astype(int), 0, bins - 1)
    count = np.bincount(index, minlength=bins)
    there = count > 0
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.bincount(index, values, bins) / count
        spread = np.sqrt(np.maximum(np.bincount(index, values**2, bins) / count - mean**2, 0.0))
    energy = np.bincount(index, values**2, bins)
    centers = low + (np.arange(bins) + 0.5) * (high - low) / bins
    share = energy / max(float(energy.sum()), 1e-300)
    return Bins(centers[there], mean[there], (mean - spread)[there], (mean + spread)[there], share[there], count[there] / values.size)


def _pictures(
    actuator: Actuator,
    record: Record,
    smoother: Smoother,
    motion: MachineState,
    lines: tuple[Lines, Lines],
    residuals: dict[str, Balance],
    mean: Record | None,
) -> Pictures:
    bins, orders = [], {}
    for name, balance in residuals.items():
        at = motion.at(balance.time_s)
        for axis in at.axes(rod=name == "kinematic"):
            found, friction = binned(axis, balance.residual), False
            if name == "mechanical":
                # as friction, which turns round with the motion, where this is more even
                turned = binned(axis, balance.residual * at.direction)
                friction = found is not None and turned is not None and turned.steady > found.steady
                found = turned if friction else found
            if found is not None:
                drawn = vars(found.drawn())
                bins.append(
                    picture.BinPicture(**drawn, source=name, unit=balance.unit, by=axis.name, axis_unit=axis.unit, friction=friction)
                )
    torque = residuals.get("mechanical")
    against = _torque_speed(actuator, torque, mean is not None, motion) if torque is not None else None
    for name in ("mechanical", "kinematic"):
        if name in residuals and residuals[name].time_s.size == lines[0].waves.shape[1]:
            orders[name] = _orders(residuals[name], motion, lines)
    return Pictures(tuple(bins), orders, against, _hysteresis(actuator, record, smoother, motion, torque, mean))


def _torque_speed(actuator: Actuator, judged: Balance, relative: bool, motion: MachineState) -> picture.TorqueSpeed:
    """Torque without inertia against speed: the measured points, their bins, and the bins of the model, or of the healthy repeats."""
    at = motion.at(judged.time_s)
    torque = judged.measured - actuator["screw.inertia_kgm2"] * at.acceleration_rad_s2
    # what is judged is the difference, so the other side is what is left without it
    expected = torque - judged.residual
    axis = Axis("speed", "rad/s", at.speed_rad_s)
    measured, model = binned(axis, torque), binned(axis, expected)
    every = max(1, torque.size // _POINTS_MAX)
    points = picture.Points(short(at.speed_rad_s[::every]), short(torque[::every]))
    other: Literal["healthy", "model"] = "healthy" if relative else "model"
    return picture.TorqueSpeed("Nm", "rad/s", other, points, measured.drawn() if measured else None, model.drawn() if model else None)


def _orders(balance: Balance, motion: MachineState, lines: tuple[Lines, Lines]) -> picture.Orders:
    """Amplitudes over orders, in turns of the motor and in leads of the screw."""
    at = motion.at(balance.time_s)

    def drawn(one: Lines) -> picture.LinesEntry:
        amplitudes, chance = one.amplitudes(balance.residual, at)
        known = np.isfinite(amplitudes)
        return picture.LinesEntry(short(one.orders[known]), short(amplitudes[known]), short(chance[known]))

    turns, leads = map(drawn, lines)
    return picture.Orders(
        balance.unit, turns, leads, float(np.ptp(at.angle_rad) / (2.0 * math.pi)), float(np.ptp(at.motor_mm) / motion.lead_mm)
    )


def _thin(x: Reals, y: Reals) -> picture.Points:
    every = max(1, x.size // _POINTS_MAX)
    return picture.Points(short(x[::every]), short(y[::every]))


def _hysteresis(
    actuator: Actuator, record: Record, smoother: Smoother, motion: MachineState, mechanical: Balance | None, mean: Record | None
) -> picture.Hysteresis:
    """Loops at reversals: rod minus motor position over motor position in um, of record, repeats and model; torque without inertia over position."""
    play = around = None
    if record.motor_position_mm is not None:
        run = simulated(actuator, record)

        def loop(rod: Reals, motor: Reals) -> picture.Points:
            # the loop is slow; the filter keeps it and drops the sensor noise
            return _thin(smoother.kept(smoother.smooth(motor)), 1e3 * smoother.kept(smoother.smooth(rod - motor)))

        play = picture.Loop(
            "um",
            "mm",
            loop(record.position_mm, record.motor_position_mm),
            loop(run.position_mm, run.motor_position_mm),
            loop(mean.position_mm, mean.motor_position_mm) if mean is not None and mean.motor_position_mm is not None else None,
        )
    if mechanical is not None:
        at = motion.at(mechanical.time_s)
        torque = mechanical.measured - actuator["screw.inertia_kgm2"] * at.acceleration_rad_s2
        expected = _thin(at.position_mm, torque - mechanical.residual)
        around = picture.Loop("Nm", "mm", _thin(at.position_mm, torque), **{"healthy" if mean is not None else "model": expected})
    return picture.Hysteresis(play, around)
