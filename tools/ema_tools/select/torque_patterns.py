"""Every effect of the library as a torque that the motor must bring up, from measured signals: one column per amplitude, in all shapes worth trying.

An effect whose record has no torque in closed form is asked through the balances themselves, at a small size, so that an effect of one's own needs nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.registry import record_of
from ema_tools.library.torques import AlongStroke, Bending, Grid, LocalTorque, PeriodicTorque, Shape, combined, values_in
from ema_tools.select.balance_setting import LEVEL, VISCOUS, Piece, Setting
from ema_tools.select.swings import swings

NOT_PLACED = "the records say how the machine moves and not where it is: record a position or an angle"
NO_SCREW = "it acts along the stroke, and the actuator states neither lead nor ratio"
NOT_BY_PLACE = "its table is over something else than the position"
NOT_SHARED = "no two records pass the same places: record one more over all of them"
NOT_HERE = "it does not show between the motor's torque and the measured motion"
# Base values that an effect's size may be a share of.
_RELATIVE_TO = (LEVEL, VISCOUS)
_OVER_POSITION = 1.0  # the axis of a table, as EMA_TABLE counts them [layout]
_STRETCHES = 8  # of a record, by turns, from whose one half the phase of a wave in the other half is taken [judgement]
_PROBE = 1e-3  # probe of an effect asked through the balances: its size as a share of its range; larger when nothing shows [precision]
_SLOWER = 0.25  # of the motion, in which a wave passes the filter at least [judgement]
_OF_OUTPUT = 3  # waves per turn of what a gear drives: itself, and the pairs of whatever holds it [judgement]
_SWINGS_MAX = 60.0  # periods per motor turn, that are looked for where no number is stated [judgement]
_ROUNDING = 1e-9  # share of the drive that is no torque [precision]


@dataclass(frozen=True)
class Pattern:
    """An effect in one shape. `columns` [rows, k]: torque against extension per unit of the fitted coefficients: one, two for an amplitude and a phase, or as many as a table has waves.

    `size_per`: the size is the coefficient over this base value; empty when it is the coefficient. `phase`: name of the phase parameter of a pair, which are the sine and the cosine of
    an angle to which the effect's own `cosine` or sine adds its phase. An effect that is not a torque on top but changes the balance itself has no columns, and `shape` holds its size.
    """

    effect: str
    shape: Shape
    columns: Reals
    size_per: str = ""
    phase: str = ""
    cosine: bool = False

    @property
    def bends(self) -> bool:
        """Whether the effect changes the balance itself, so that its size is searched and not solved for."""
        return bool(self.columns.shape[1] == 0)

    @property
    def light(self) -> Pattern:
        """The same without its rows, [0, k]: of minutes of record all shapes of all effects together are gigabytes."""
        return replace(self, columns=self.columns[:0].copy())

    def values(self, coefficients: Reals, base: Mapping[str, float]) -> dict[str, float]:
        """The effect's values by name for fitted coefficients [k] and base values."""
        row = load_definitions().effect(self.effect)
        if self.bends:
            return dict(self.shape)
        per = base[self.size_per] if self.size_per else 1.0
        nodes = _along(len(row.nodes), coefficients.size) @ coefficients if row.nodes else np.zeros(0)
        largest = float(np.max(np.abs(nodes), initial=0.0))
        amount = float(np.hypot(*coefficients)) if self.phase else largest if row.nodes else float(coefficients[0])
        # a share of nothing is no size
        found = {row.size.name: amount / per if per else math.inf, **self.shape}
        found |= {node.name: float(share) for node, share in zip(row.nodes, nodes / (largest or 1.0), strict=True)}
        if self.phase:
            sine, cosine = float(coefficients[0]), float(coefficients[1])
            found[self.phase] = float(np.arctan2(-sine, cosine) if self.cosine else np.arctan2(cosine, sine))
        return found


def _pair(angle: Reals) -> Reals:
    return np.column_stack([np.sin(angle), np.cos(angle)])


def _along(nodes: int, waves: int) -> Reals:
    """Waves over the nodes of a table, whose mean is zero, since the level of friction is a base value: [nodes, waves]."""
    place = (np.arange(nodes) + 0.5) / nodes
    return np.cos(np.pi * place[:, None] * np.arange(1, waves + 1))


def _tabled(setting: Setting, effect: str, one: AlongStroke, shape: Shape) -> Pattern | str:
    """A table over the stroke, one column for each of its waves; none of a table over something else, or where records share no stroke."""
    if shape[f"{effect}.axis"] != _OVER_POSITION:
        return NOT_BY_PLACE
    states, nodes = setting.states, len(load_definitions().effect(effect).nodes)
    first, last = (shape[f"{effect}.{end}"] for end in ("first", "last"))
    if not first < last:
        return NOT_SHARED
    waves = _along(nodes, one.waves)
    places = np.linspace(first, last, nodes)
    columns = np.column_stack([np.interp(states.screw_mm, places, wave) for wave in waves.T])
    return Pattern(effect, shape, setting.as_seen(states.direction[:, None] * columns))


def _stroke(setting: Setting, effect: str) -> Shape:
    """The range that two records show, as a table has it: what one alone shows cannot be told by the others, and holds the edge's value."""
    ends = np.cumsum([piece.record.rows for piece in setting.pieces])[:-1]
    seen = np.sort([(float(np.min(one)), float(np.max(one))) for one in np.split(setting.states.screw_mm, ends)], axis=0)
    first, last = (seen[1, 0], seen[-2, 1]) if len(seen) > 1 else seen[0]
    return {f"{effect}.axis": _OVER_POSITION, f"{effect}.first": float(first), f"{effect}.last": float(last)}


def _moving(piece: Piece) -> Reals:
    """Speeds of a record while the machine moves, rad/s; zero where it never does."""
    speeds = np.abs(piece.motion.speed_rad_s[~piece.model.still])
    return speeds if speeds.size else np.zeros(1)


def _in_band(setting: Setting, one: PeriodicTorque) -> list[float]:
    """Periods per motor turn that pass the filter at least at the record's slower speeds; of what may turn behind a gear also those at which the records swing."""
    highest = max(
        0.5 * piece.model.smoother.cutoff_hz * 2.0 * np.pi / max(float(np.quantile(_moving(piece), _SLOWER)), 1e-9)
        for piece in setting.pieces
    )
    return [periods for periods in (*one.in_balance, *(_behind_gear(setting, highest) if one.behind_gear else ())) if periods <= highest]


def _behind_gear(setting: Setting, highest: float) -> tuple[float, ...]:
    """Periods per motor turn of what turns behind a stated gear, and those at which what the base values leave swings."""
    ratio = setting.actuator["gearbox.ratio"] if setting.actuator.has("gearbox.ratio") else 1.0
    stated = tuple(number / ratio for number in range(1, _OF_OUTPUT + 1) if number % ratio != 0.0)
    residuals, angles = [], []
    for piece in setting.pieces:
        model, moves = piece.model, ~piece.model.still
        moves[: model.smoother.edge_rows] = moves[-model.smoother.edge_rows :] = False
        target = (model.drive_Nm - model.load_Nm - model.added_Nm)[moves]
        columns = model.columns[moves]
        residuals.append(target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0])
        angles.append(piece.motion.angle_rad[moves])
    return (*stated, *swings(residuals, angles, min(highest, _SWINGS_MAX)))


def _periodic(setting: Setting, effect: str, one: PeriodicTorque, shape: Shape) -> Pattern:
    columns = -one.torque(setting.states)[:, None] * _pair(shape.get(f"{effect}.periods", 1.0) * one.angle(setting.states))
    return Pattern(effect, shape, setting.as_seen(columns), LEVEL if one.of_level else "", f"{effect}.phase_rad", one.cosine)


def _aligned(setting: Setting, pattern: Pattern) -> Pattern:
    """A wave whose phase is another in every record, since nobody knows where each begins: one column for its amplitude.

    The phase in one half of a record's stretches is that which the other half shows, so that noise, which has no phase, gives nothing.
    """
    found, place = np.zeros(setting.rows), 0
    for piece in setting.pieces:
        rows, model = piece.record.rows, piece.model
        pair, here = pattern.columns[place : place + rows], slice(place, place + rows)
        half = (np.arange(rows) * _STRETCHES // rows) % 2
        inner = np.zeros(rows, dtype=bool)
        inner[model.smoother.edge_rows : -model.smoother.edge_rows] = True
        inner &= ~model.still  # where friction answers whatever there is, and shows no wave
        target, matrix = model.drive_Nm - model.load_Nm - model.added_Nm, np.column_stack([model.columns, pair])
        column = np.zeros(rows)
        for side in (0, 1):
            other = inner & (half != side)
            wave = np.linalg.lstsq(matrix[other], target[other], rcond=None)[0][-2:]
            column[half == side] = pair[half == side] @ (wave / (float(np.hypot(*wave)) or 1.0))
        found[here] = column
        place += rows
    return Pattern(pattern.effect, pattern.shape, found[:, None], pattern.size_per)


def _local_of(effect: str) -> LocalTorque | None:
    """The torque in closed form of an effect that the balance seeks; what it does not seek has no shapes here."""
    record = record_of(effect)
    return record.local if record.in_balance else None


def _local(setting: Setting, effect: str, one: LocalTorque, shape: Shape) -> Pattern:
    torque = one.torque(setting.states, {name.removeprefix(f"{effect}."): value for name, value in shape.items()})
    return Pattern(effect, shape, setting.as_seen(-torque[:, None]), LEVEL if one.of_level else "")


def _in_ranges(setting: Setting, effect: str, grid: Grid) -> list[Shape]:
    """Every shape of a grid, within the ranges of its values."""
    values = {}
    for name, wanted in values_in(grid, setting.states).items():
        row = load_definitions().by_name[f"{effect}.{name}"]
        values[row.name] = sorted({float(np.clip(value, row.lower, row.upper)) for value in wanted})
    return combined(values)


def _bending_shapes(setting: Setting, effect: str, one: Bending) -> list[Shape]:
    shapes = _in_ranges(setting, effect, {load_definitions().effect(effect).size.field: one.sizes, **one.beside})
    if one.of_drive:
        changed = setting.with_actuator(setting.actuator.changed(shapes[0]))
        return shapes if not np.array_equal(changed.drive_Nm, setting.drive_Nm) else []
    return shapes


def _shapes(setting: Setting, effect: str) -> list[Shape] | None:
    """The shapes to try of an effect whose record has them; None of any other."""
    record = record_of(effect)
    if record.periodic is not None:
        numbers = _in_band(setting, record.periodic)
        return [{f"{effect}.periods": float(number)} for number in numbers] if record.periodic.in_balance else [{}]
    if (local := _local_of(effect)) is not None:
        return _in_ranges(setting, effect, local.in_balance)
    if record.along is not None:
        return [_stroke(setting, effect)]
    return _bending_shapes(setting, effect, record.bending) if record.bending is not None else None


def _asked(setting: Setting, effect: Effect) -> Pattern | str:
    """The column of an effect of one shape, from the balances with and without it; or why there is none."""
    size = effect.size

    def column(halved: str = "") -> Reals:
        base = {halved: 0.5 * setting.actuator[halved]} if halved else {}
        with_it = setting.actuator.changed({**base, size.name: size.nominal + probe})
        return (setting.with_actuator(with_it).required_Nm() - setting.required_Nm(halved)) / probe

    reach = size.upper - size.nominal if size.upper > size.nominal else size.lower - size.nominal
    probe = _PROBE * reach
    try:
        found = column()
        # what the whole range of the effect makes may be nothing but rounding
        if float(np.max(np.abs(found))) * abs(reach) <= _ROUNDING * float(np.max(np.abs(setting.drive_Nm))):
            return NOT_HERE
        for name in _RELATIVE_TO:
            base = setting.actuator[name]
            if base > 0.0 and np.allclose(column(name), 0.5 * found, rtol=1e-6, atol=1e-9 * float(np.max(np.abs(found)))):
                return Pattern(effect.name, {}, found[:, None] / base, name)
    except (InputError, MissingSignal) as error:
        return str(error)
    return Pattern(effect.name, {}, found[:, None])


def patterns_of(setting: Setting, effect: str, taken: Callable[[Pattern], Pattern] | None = None) -> Sequence[Pattern] | str:
    """Every shape of an effect that is tried, each as `taken` makes of it as soon as it is there; or in one sentence why none can be."""
    shapes = [{}] if (known := _shapes(setting, effect)) is None else known
    why = _not_known(setting.waveless, effect, shapes[0]) if shapes else ""
    if why:
        return why
    found: list[Pattern] = []
    refused = ""
    for shape in shapes:
        one = pattern_of(setting, effect, shape)
        if isinstance(one, str):
            refused = refused or one
        else:
            found.append(taken(one) if taken is not None else one)
    return tuple(found) or refused or NOT_HERE


def is_texture(setting: Setting, effect: str, shape: Shape) -> bool:
    """Whether an effect is a pattern along the way: a wave, or something at one place of it."""
    record, states = record_of(effect), setting.states
    local = _local_of(effect)
    if local is None:
        return record.periodic is not None or record.along is not None
    field_by_field = {name.removeprefix(f"{effect}."): value for name, value in shape.items()}
    moved = replace(states, screw_mm=states.screw_mm + float(np.ptp(states.screw_mm)))
    return not np.array_equal(local.torque(states, field_by_field), local.torque(moved, field_by_field))


def _not_known(setting: Setting, effect: str, shape: Shape) -> str:
    """Why an effect that acts at a place cannot be told from records that do not say where the machine is; empty where it can."""
    if record_of(effect).bending is not None:
        on_screw = any(name.endswith("_mm") for name in shape)
        return NO_SCREW if on_screw and setting.on_another_screw is not setting else ""
    if not setting.placed and record_of(effect).periodic is None and _differ(effect, shape, setting, setting.elsewhere):
        return NOT_PLACED
    return NO_SCREW if _differ(effect, shape, setting, setting.on_another_screw) else ""


def _differ(effect: str, shape: Shape, one: Setting, other: Setting) -> bool:
    if one is other:
        return False
    here, there = pattern_of(one, effect, shape), pattern_of(other, effect, shape)
    if isinstance(here, str) or isinstance(there, str):
        return False
    largest = float(np.max(np.abs(here.columns), initial=0.0))
    return not np.allclose(here.columns, there.columns, rtol=1e-6, atol=1e-6 * largest)


def pattern_of(setting: Setting, effect: str, shape: Shape) -> Pattern | str:
    """An effect in one shape; or in one sentence why there is no such pattern."""
    record = record_of(effect)
    if record.periodic is not None:
        wave = _periodic(setting, effect, record.periodic, shape)
        return wave if setting.placed else _aligned(setting, wave)
    if (local := _local_of(effect)) is not None:
        return _local(setting, effect, local, shape)
    if record.along is not None:
        return _tabled(setting, effect, record.along, shape)
    if record.bending is not None:
        return Pattern(effect, shape, np.zeros((setting.rows, 0)))
    return _asked(setting.foretold if load_definitions().effect(effect).site == "FRICTION" else setting, load_definitions().effect(effect))


def rows_of(setting: Setting, pattern: Pattern) -> Reals:
    """A pattern's columns in a setting, [rows, k]. Raises InputError where the effect has none there."""
    found = pattern_of(setting, pattern.effect, pattern.shape)
    if isinstance(found, str):
        raise InputError(f"{pattern.effect}: {found}: leave it out")
    return found.columns


def continuous_of(effect: str) -> tuple[str, ...]:
    """The shape parameters of an effect that lie between the shapes tried."""
    local = _local_of(effect)
    return tuple(f"{effect}.{field}" for field in local.in_balance) if local is not None else ()
