"""Signatures of all effects under one fixed command, as the onboard module reads them: what `ema export --signatures` writes and `ema_onboard.h` multiplies.

The desk's method in small. Rows are averaged in bins and weighted per signal; what scatters (friction, grease, winding) is taken off with its spread, CSJ and BLK entirely,
so that a fault is not named as an effect; grease and winding entirely too, where the search finds those of the day.
Each row of the table has length one: its product with a whitened residual is normal with variance 1 where nothing is missing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, nearest
from ema_tools.data.records import Record, start_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import measured_channels, simulate_channels, slope_step
from ema_tools.fit.whitening import least_noise
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.faults import FAULT_RECORDS, FAULTS
from ema_tools.library.registry import record_of
from ema_tools.plant.native import CHANNELS
from ema_tools.results.files import SignatureTable
from ema_tools.select.baseline import gather, same_command
from ema_tools.select.healthy_groups import state_doubt
from ema_tools.select.healthy_records import check_alike, check_once
from ema_tools.select.known_machine import live
from ema_tools.tasks.onboard_search import DAY_VALUES

TABLE_BYTES_MAX = 131_072  # what the table may take in flash: docs/ONBOARD_DIAGNOSIS.md has the measurement behind it [measured]
ROWS_MAX = 112  # what the module holds, EMA_SIGNATURE_ROWS_MAX [layout]
SIGNALS = ("position_mm", "current_A")
RATE_HZ = 25.0  # of the bins it is made of unless told: as much as fits into the flash [measured]
LIMIT = 30.0  # an effect must take off so many units of cost, as on the desk ... [chance]
HEALTHY_FACTOR = 1.3  # ... and more than healthy runs of the machine show, by this factor; the same for what is left in all [judgement]
# So much of what CSJ and BLK have moved in the signals may look like something else: standing errors of a machine grow with its friction.
# As on the desk [judgement]
TRUST = 0.02
LEFT_SHARE = 0.5  # an effect that leaves more than this share of the excess is not what is missing [judgement]
# No signal is trusted beyond this part of what the desk trusts it to: a bin's mean is less noisy than its rows [judgement]
_LEAST_NOISE_PART = 0.3
# The mean of the healthy runs is off a calibrated model by 2 to 8 times the noise of a bin, off a data sheet by 17 to 58: the story's unit
# and four machines of the trials [measured]
_CALIBRATED = 12.0
_COMMAND_APART = 0.005  # a command that differs by more than this part of its reach is another one [judgement]
# A signature is taken at the size at which it stands so many standard deviations out of the noise; one that turns with its size at
# more [judgement]
_APART = 60.0
_SHARE_MAX = 0.3  # or at this share of its range, where it never stands out so far ... [judgement]
_SHARE_FIRST = 0.002  # ... beginning at this one ... [judgement]
_SCALINGS = 4  # ... in so many steps ... [effort]
_NEAR_ENOUGH = 0.3  # ... until it is this near to it, as a logarithm [judgement]
_INDEPENDENT = 1e-3  # two signatures of which less than this is the second's own are one [precision]


@dataclass(frozen=True)
class TablePattern:
    """One effect in one shape: `rows` rows (1 or 2) of the table from `first`. `turn` [3] makes sizes of products p: turn[0] p0 + turn[1] p1, and turn[2] p1 a quarter period apart.

    `one_sided`: a negative product does not mean the effect; `penalty`: what the choice among the effect's shapes explains of pure noise, units of cost.
    """

    effect: str
    first: int
    rows: int
    turn: tuple[float, float, float]
    one_sided: bool
    penalty: float
    shape: Mapping[str, float]


@dataclass(frozen=True)
class Fault:
    """CSJ or BLK: its row of the table, its value where the table was made, the change of the value that a product of one stands for, and the whitened signals' length per unit of it."""

    key: str
    name: str
    row: int
    healthy: float
    turn: float
    length: float


@dataclass(frozen=True)
class Signatures:
    """The table. `command_mm` [bins]; `reference` [signals, bins]: by what the healthy machine differs from its model; `weight` [signals]: one over the noise of a bin's mean;
    `rows` [k, signals, bins]: first what scatters, orthonormal, then the patterns' and the faults'. `limit`, `energy`: largest score and squared residual of a healthy machine;
    `doubt`: why two runs may not both be healthy, in words."""

    actuator: Actuator
    signals: tuple[str, ...]
    record_rows: int
    bin_rows: int
    command_mm: Reals
    command_apart_mm: float
    reference: Reals
    weight: Reals
    nuisances: int
    rows: Reals
    patterns: tuple[TablePattern, ...]
    faults: tuple[Fault, ...]
    limit: float = LIMIT
    energy: float = 0.0
    doubt: str = ""

    @property
    def bins(self) -> int:
        """Bins of a signal."""
        return int(self.command_mm.size)

    @property
    def numbers(self) -> int:
        """Numbers of 16 bits in the table."""
        return self.bins * (1 + len(self.signals) * (1 + len(self.rows)))

    @property
    def misfit(self) -> dict[str, float]:
        """By how many times the noise of a bin the healthy machine differs from its model, rms, by signal."""
        rms = np.sqrt(np.mean(self.reference**2, axis=1)) * self.weight
        return dict(zip(self.signals, rms.tolist(), strict=True))

    @property
    def warning(self) -> str | None:
        """What speaks against the table: that its runs may not be healthy, or that its actuator is not their machine."""
        if self.doubt:
            return f"--signatures: {self.doubt}"
        worst = max(self.misfit, key=self.misfit.__getitem__)
        if self.misfit[worst] <= _CALIBRATED:
            return None
        return (
            f"--signatures: {worst}: {self.actuator.file or self.actuator.name} misses the healthy records by {self.misfit[worst]:.3g} times their noise:"
            " calibrate it on them (ema calibrate) and export that, or what the table names may be wrong"
        )

    def summary(self) -> SignatureTable:
        """What the table is made of."""
        rate_hz = 1.0 / (self.bin_rows * self.actuator.record_period_s)
        effects = tuple(sorted({one.effect for one in self.patterns}))
        return SignatureTable(
            2 * self.numbers,
            tuple(self.signals),
            len(self.rows),
            self.bins,
            rate_hz,
            effects,
            self.limit,
            self.energy,
            self.misfit,
            self.warning,
        )


@dataclass(frozen=True)
class Scored:
    """One effect at its best shape: units of cost that it takes off, and its size."""

    effect: str
    score: float
    size: float
    shape: Mapping[str, float]


@dataclass(frozen=True)
class Judged:
    """What the table says of a residual. `kind`: adequate, missing (the first of `scored`, which is best first) or unknown; `energy`: the squared residual after what scatters;
    `limit`: what a score must exceed; `moved`: changes of CSJ and BLK by key beyond the known machine."""

    kind: str
    scored: tuple[Scored, ...]
    energy: float
    limit: float
    moved: Mapping[str, float]


def binned(signals: Reals, bin_rows: int) -> Reals:
    """Means of `bin_rows` neighbouring rows, [..., rows] to [..., bins]; an incomplete last bin is left out."""
    bins = signals.shape[-1] // bin_rows
    return np.asarray(signals[..., : bins * bin_rows].reshape(*signals.shape[:-1], bins, bin_rows).mean(axis=-1))


class _Bench:
    """The known machine under the fixed command: signals in bins [signals, bins], vectors [signals * bins] weighted."""

    def __init__(self, actuator: Actuator, record: Record, signals: tuple[str, ...], bin_rows: int) -> None:
        self.actuator, self.record, self.signals, self.bin_rows = actuator, record, signals, bin_rows
        self.start_mm = start_of(actuator, record)
        self.here = self.run({})
        self.weight = np.ones(len(signals))

    def run(self, changes: Mapping[str, float]) -> Reals:
        """Signals with `changes`. Raises InputError when the model refuses."""
        return binned(simulate_channels(self.actuator.changed(dict(changes)), self.record, self.signals, self.start_mm), self.bin_rows)

    def vector(self, changes: Mapping[str, float]) -> Reals:
        """What `changes` make of the signals."""
        return self.weighted(self.run(changes) - self.here)

    def weighted(self, signals: Reals) -> Reals:
        """Signals as a vector."""
        return np.asarray((signals * self.weight[:, None]).ravel())

    def of_spread(self, one: spreads.Spread) -> Reals:
        """What one standard deviation of a spread makes of the signals."""
        step = slope_step(one)
        return np.asarray((self.run(one.changes(self.actuator, step)) - self.here) / step)


@dataclass(frozen=True)
class _Space:
    """Vectors with the scatter taken off, its spread counted, and hard directions entirely. `basis` [n + scatter, k]."""

    basis: Reals
    scatter: int

    @staticmethod
    def of(soft: Reals, hard: Sequence[Reals]) -> _Space:
        """`soft` [n, scatter]: what one standard deviation makes; `hard`: vectors [n]."""
        count = soft.shape[1]
        columns = [np.vstack([soft, -np.eye(count)]), *(np.concatenate([one, np.zeros(count)])[:, None] for one in hard)]
        basis, _ = np.linalg.qr(np.hstack(columns))
        return _Space(basis, count)

    def __call__(self, vector: Reals) -> Reals:
        """[n] to [n + scatter]; its product with a plain vector is that of both freed vectors."""
        tall = np.concatenate([vector, np.zeros(self.scatter)])
        return np.asarray(tall - self.basis @ (self.basis.T @ tall))

    def short(self, tall: Reals) -> Reals:
        """The part [..., n] that meets a residual, of vectors [..., n + scatter]."""
        return tall[..., : tall.shape[-1] - self.scatter]


@dataclass(frozen=True)
class _Wanted:
    """A pattern to be made: the values that grow with the size, one for each row; where they start and how far they may go; `fixed`: taken as it is, not scaled."""

    effect: str
    size: str
    zero: float
    first: float
    largest: float
    rows: tuple[Mapping[str, float], ...]
    one_sided: bool
    shape: Mapping[str, float]
    apart: float = _APART
    fixed: bool = False


def _wanted(bench: _Bench, effect: Effect) -> list[_Wanted]:
    """The patterns of one effect."""
    size, record = effect.size, record_of(effect.name)
    if record.below_peak is not None:
        peak_A = float(np.max(np.abs(simulate_channels(bench.actuator, bench.record, ("current_A",), bench.start_mm))))
        return [
            _Wanted(effect.name, size.name, 0.0, share * peak_A, share * peak_A, ({},), True, {}, fixed=True)
            for share in record.below_peak.onboard
        ]
    zero = bench.actuator[size.name]
    span = size.upper - zero
    phased = any(value.field == "phase_rad" for value in effect.parameters)
    found = []
    for by_field in record.onboard.shapes_at(float(np.max(np.abs(bench.record.command_mm)))):
        shape = {f"{effect.name}.{field}": value for field, value in by_field.items()}
        if record.onboard.sizes:
            found += [
                _Wanted(effect.name, size.name, 0.0, value, value, (shape,), True, shape, fixed=True) for value in record.onboard.sizes
            ]
            continue
        rows = tuple({**shape, f"{effect.name}.phase_rad": phase} for phase in (0.0, np.pi / 2.0)) if phased else (shape,)
        one_sided = size.lower >= size.nominal and not phased and zero == size.nominal
        found += [
            _Wanted(effect.name, size.name, zero, _SHARE_FIRST * span, _SHARE_MAX * span, rows, one_sided, shape, apart)
            for apart in (_APART, *record.onboard.larger)
        ]
    return found


def _row(bench: _Bench, space: _Space, wanted: _Wanted, values: Mapping[str, float]) -> tuple[float, Reals] | None:
    """The change of size at which a row stands out as it should, and its vector; None where it shows nothing or the model refuses it."""
    found: tuple[float, Reals] | None = None
    change, power = wanted.first, 1.0
    earlier: tuple[float, float] | None = None
    for _ in range(1 if wanted.fixed else _SCALINGS):
        try:
            vector = bench.vector({**values, wanted.size: wanted.zero + change})
        except InputError:
            break
        length = float(np.linalg.norm(space(vector)))
        if not length > 0.0:
            change = min(30.0 * change, wanted.largest)
            continue
        found = (change, vector)
        if abs(np.log(length / wanted.apart)) < _NEAR_ENOUGH or (change >= wanted.largest and length < wanted.apart):
            break
        if earlier is not None and change != earlier[0]:
            # a stretch grows with the square of its period
            power = float(np.clip(np.log(length / earlier[1]) / np.log(change / earlier[0]), 0.5, 3.0))
        earlier = (change, length)
        change = min(change * float(np.clip(wanted.apart / length, 1e-3, 30.0)) ** (1.0 / power), wanted.largest)
    return found


def _patterns(bench: _Bench, space: _Space, first: int) -> tuple[list[TablePattern], list[Reals]]:
    """Patterns of all effects, and their rows [n], the first of which is row `first` of the table."""
    tasks = [one for effect in load_definitions().physical for one in _wanted(bench, effect)]
    made = each(lambda one: [_row(bench, space, one, values) for values in one.rows], tasks)
    patterns: list[TablePattern] = []
    rows: list[Reals] = []
    for one, found in zip(tasks, made, strict=True):
        present = [row for row in found if row is not None]
        if len(present) < len(found):
            continue
        unit, turn = np.linalg.qr(np.column_stack([space(vector) for _, vector in present]))
        sign = np.sign(np.diag(turn))
        unit, turn = unit * sign, turn * sign[:, None]
        if abs(turn[-1, -1]) < _INDEPENDENT * abs(turn).max():
            continue
        back = np.eye(2)
        back[: len(present), : len(present)] = np.linalg.inv(turn)
        sizes = [change for change, _ in present] * 2
        patterns.append(
            TablePattern(
                one.effect,
                first + len(rows),
                len(present),
                (sizes[0] * back[0, 0], sizes[0] * back[0, 1], sizes[1] * back[1, 1]),
                one.one_sided,
                0.0,
                one.shape,
            )
        )
        rows += list(space.short(unit.T))
    tried = {one.effect: sum(other.rows for other in patterns if other.effect == one.effect) for one in patterns}
    return [replace(one, penalty=2.0 * float(np.log(tried[one.effect]))) for one in patterns], rows


def _noise(bench: _Bench, runs: Reals) -> tuple[Reals, Reals]:
    """Noise of a bin's mean, rms [signals], and widths of what scatters over the usual [spreads], of a run against the mean of healthy `runs` [count, signals, bins]."""
    count = len(runs)
    usual = spreads.from_run_to_run(bench.actuator)
    mean = runs.mean(axis=0)
    deviations = runs - mean
    least = _LEAST_NOISE_PART * least_noise(mean)
    level = np.maximum(np.sqrt(np.mean(deviations**2, axis=(0, 2))), least)
    directions = np.array(each(bench.of_spread, usual)).reshape(len(usual), *mean.shape)
    shares = np.linalg.lstsq(
        (directions / level[:, None]).reshape(len(usual), mean.size).T, (deviations / level[:, None]).reshape(count, -1).T, rcond=None
    )[0]
    widths = spreads.widths_shown(bench.actuator, usual, shares)
    left = deviations - np.einsum("kr,kcn->rcn", shares, directions)
    noise = np.sqrt(np.mean(left**2, axis=(0, 2)) * count / (count - 1.0) + least**2)
    widen = np.sqrt(1.0 + 1.0 / count)
    return noise * widen, widths * widen


def _check_runs(actuator: Actuator, healthy: Sequence[Record], signals: Sequence[str]) -> None:
    if len(healthy) < 2:
        raise InputError(
            f"--signatures: {len(healthy)} healthy record tells nothing of what scatters: give two or more of the ground test with --healthy"
        )
    for name in signals:
        if name not in CHANNELS:
            raise InputError(f"--signals {name}: unknown signal{nearest(name, CHANNELS)}: use {', '.join(CHANNELS)}")
    for other in healthy:
        if not same_command(healthy[0], other):
            raise InputError(f"{other.file}: command_mm: not the command of {healthy[0].file}: the signatures belong to one command")
        for name in signals:
            if other.channel(name) is None:
                raise InputError(f"{other.file}: {name}: not recorded: name the recorded signals with --signals")
    check_once(healthy)
    check_alike(actuator, healthy)


def signals_of(records: Sequence[Record], text: str | None = None) -> tuple[str, ...]:
    """The signals that a table of these healthy records is made of: as told, or the usual ones that all of them have."""
    if text:
        return tuple(part.strip() for part in text.split(",") if part.strip())
    return tuple(name for name in SIGNALS if all(record.channel(name) is not None for record in records))


def signatures(actuator: Actuator, healthy: Sequence[Record], signals: Sequence[str] = SIGNALS, rate_hz: float = RATE_HZ) -> Signatures:
    """The table of `actuator`, calibrated, for the command of the `healthy` runs, two or more. A rate with which it would not fit is lowered.

    Raises InputError for runs that do not serve, and when the effects need more rows than the module holds.
    """
    names = tuple(name for name in CHANNELS if name in signals)
    _check_runs(actuator, healthy, signals)
    record = healthy[0]
    doubt = state_doubt(gather(actuator, record, healthy, live(*healthy)), healthy)
    bin_rows = max(1, round(1.0 / (rate_hz * record.period_s)))
    table = _table(_Bench(actuator, record, names, bin_rows), healthy)
    if len(table.rows) > ROWS_MAX:
        raise InputError(
            f"--signatures: {len(table.rows)} rows where the module holds {ROWS_MAX}: raise EMA_SIGNATURE_ROWS_MAX, or leave effects out of own_effects.def"
        )
    if 2 * table.numbers > TABLE_BYTES_MAX:
        fitting = -(-2 * table.numbers * bin_rows // TABLE_BYTES_MAX)
        table = _table(_Bench(actuator, record, names, fitting), healthy)
    return replace(table, doubt=doubt)


def _table(bench: _Bench, healthy: Sequence[Record]) -> Signatures:
    actuator, record = bench.actuator, bench.record
    runs = binned(np.array([measured_channels(one, bench.signals) for one in healthy]), bench.bin_rows)
    count = len(runs)
    noise, widths = _noise(bench, runs)
    bench.weight = 1.0 / noise
    usual = spreads.from_run_to_run(actuator)
    scattering = {one.title: bench.weighted(bench.of_spread(one) * width) for one, width in zip(usual, widths, strict=True)}
    # what the search moves must not be read as an effect, however far it goes, also where it is stated not to scatter
    searched = [name for name in spreads.DAY if actuator[DAY_VALUES] != 0.0 and actuator[name] > 0.0]
    day = [
        scattering[name]
        if name in scattering
        else bench.weighted(bench.of_spread(spreads.Spread((name,), spreads.FROM_RUN_TO_RUN[name], True)))
        for name in searched
    ]
    soft = np.array([vector for name, vector in scattering.items() if name not in searched]).reshape(-1, bench.here.size).T
    steps = {key: FAULT_RECORDS[key].typical_share * actuator[name] for key, name in FAULTS.items() if actuator[name] > 0.0}
    vectors = {key: bench.vector({FAULTS[key]: actuator[FAULTS[key]] + step}) for key, step in steps.items()}
    space = _Space.of(soft, [*vectors.values(), *day])
    rows = list(space.short(space.basis.T))
    nuisances = len(rows)
    patterns, more = _patterns(bench, space, nuisances)
    rows += more
    faults = []
    for key, vector in vectors.items():
        own = _Space.of(soft, [*(other for name, other in vectors.items() if name != key), *day])
        tall = own(vector)
        length = float(np.linalg.norm(tall))
        faults.append(
            Fault(key, FAULTS[key], len(rows), actuator[FAULTS[key]], steps[key] / length, float(np.linalg.norm(vector)) / steps[key])
        )
        rows.append(own.short(tall) / length)
    shape = bench.here.shape
    reach_mm = float(np.max(np.abs(record.command_mm)))
    table = Signatures(
        actuator, bench.signals, record.rows, bench.bin_rows, binned(record.command_mm, bench.bin_rows), _COMMAND_APART * reach_mm, runs.mean(axis=0) - bench.here, bench.weight,
        nuisances, np.array(rows).reshape(-1, *shape), tuple(patterns), tuple(faults),
    )  # fmt: skip
    # a run against the mean of the others scatters a little more than a record against the mean of them all
    shrink = np.sqrt((1.0 + 1.0 / count) / (1.0 + 1.0 / (count - 1)))
    seen = [judge(table, (runs[k] - np.delete(runs, k, axis=0).mean(axis=0)) * shrink) for k in range(count)]
    limit = max(LIMIT, HEALTHY_FACTOR * max(one.scored[0].score for one in seen))
    return replace(table, limit=limit, energy=HEALTHY_FACTOR * max(one.energy for one in seen))


def judge(table: Signatures, residual: Reals, known: Actuator | None = None) -> Judged:
    """What the table says of the residual in bins [signals, bins] against the table's machine, or the `known` one with other CSJ and BLK, the reference taken off already."""
    white = residual * table.weight[:, None]
    products = np.einsum("kcb,cb->k", table.rows, white)
    best: dict[str, Scored] = {}
    for one in table.patterns:
        own = products[one.first : one.first + one.rows]
        wrong_sign = one.one_sided and own[0] <= 0.0
        score = 0.0 if wrong_sign else float(own @ own) - one.penalty
        size = one.turn[0] * own[0] if one.rows == 1 else np.hypot(one.turn[0] * own[0] + one.turn[1] * own[1], one.turn[2] * own[1])
        if one.effect not in best or score > best[one.effect].score:
            best[one.effect] = Scored(one.effect, score, 0.0 if wrong_sign else float(size), one.shape)
    scored = tuple(sorted(best.values(), key=lambda one: -one.score))
    scattered = products[: table.nuisances]
    energy = float(np.sum(white**2) - scattered @ scattered)
    shifted = [((known or table.actuator)[one.name] - one.healthy) * one.length for one in table.faults]
    wider = TRUST**2 * float(np.sum(np.square(shifted)))
    limit, excess, score = table.limit + wider, energy - table.energy - wider, scored[0].score
    kind = (
        "adequate"
        if score <= limit and excess <= limit
        else "missing"
        if score > limit and excess - score <= LEFT_SHARE * excess
        else "unknown"
    )
    return Judged(kind, scored, energy, limit, {one.key: one.turn * float(products[one.row]) for one in table.faults})


def residual_of(table: Signatures, record: Record, known: Actuator | None = None) -> Reals:
    """A record of the table's command against the table's machine or the `known` one, in bins [signals, bins], the reference taken off."""
    actuator = known or table.actuator
    difference = measured_channels(record, table.signals) - simulate_channels(actuator, record, table.signals, start_of(actuator, record))
    return np.asarray(binned(difference, table.bin_rows) - table.reference)
