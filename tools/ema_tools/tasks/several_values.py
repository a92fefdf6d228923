"""Several values of one record at once, by the module's least squares: what `ema identify --values` adds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError
from ema_tools.base.interval import interval95
from ema_tools.base.noise import white_noise
from ema_tools.data.actuator import SETTINGS, Actuator, row_of, shown
from ema_tools.data.records import Record
from ema_tools.fit.nuisance import FROM_DATA_SHEET
from ema_tools.library.definitions import EffectParameter, Parameter, load_definitions
from ema_tools.library.registry import record_of
from ema_tools.plant.least_squares import SEARCHED_MAX, FoundValue, Searched, SquaresFound, SquaresSettings, least_squares
from ema_tools.plant.native import CHANNELS
from ema_tools.tasks.onboard_search import BOUNDS

_REACH = 3.0  # a value is sought from a third of it to three times it: wider than wear, temperature and data sheets are off [judgement]
_EFFECT_REACH = 5.0  # an effect up to so many times the lower end of its usual size [judgement]
_NOISE_FLOOR = 5e-4  # of a signal's own spread: below it float32 does not tell values apart that are told at more noise [precision]
_BLK = "screw.blk_mm"
# Values that are one property of the machine move together.
_TOGETHER = tuple(names for names in FROM_DATA_SHEET if len(names) > 1)


@dataclass(frozen=True)
class SeveralValues:
    """What was found, in the order asked. `before`: what the actuator has, by name; `companions`: values that moved in proportion to another one, by that one's name; `noise` by signal."""

    found: SquaresFound
    before: Mapping[str, float]
    companions: Mapping[str, str]
    noise: Mapping[str, float]

    def determined(self, one: FoundValue) -> bool:
        """Whether the record determines a value by itself. A play that was never crossed is not known, whatever the signals say."""
        return one.determined == "yes" and (one.name != _BLK or self.found.crossed)

    def interval95(self, one: FoundValue) -> tuple[float | None, float | None] | None:
        """Where a value lies with 95 % certainty, by the residual's own size and what lasts in it; None where the record does not determine it."""
        return interval95(one.estimate, one.std, one.bias) if self.determined(one) else None


def _bounds_given(name: str, text: str) -> tuple[float, float]:
    low, dots, high = text.partition("..")
    try:
        bounds = float(low), float(high)
    except ValueError:
        bounds = (np.nan, np.nan)
    if not dots or not bounds[0] < bounds[1]:
        raise InputError(f"--values {name}={text}: not bounds: write for example screw.load_torque_Nm=-0.1..0.1")
    return bounds


def _row(name: str) -> Parameter | EffectParameter:
    """The row of a value that can be searched. Raises InputError."""
    row = row_of(name)
    if isinstance(row, Parameter) and (row.is_option or row.section in (*SETTINGS, "timing")):
        raise InputError(
            f"--values {shown(row)}: no value of the machine: give numbers of its drive, motor, gearbox, screw, encoder or effects"
        )
    if isinstance(row, EffectParameter) and load_definitions().effect(row.effect).is_learned:
        raise InputError(f"--values {shown(row)}: belongs to a learned table, which is not searched: give another value")
    return row


def _usual(actuator: Actuator, row: Parameter | EffectParameter) -> tuple[float, float] | None:
    """Bounds where none were given; None where nothing says what is usual."""
    value = actuator[row.name]
    if row.name in BOUNDS:
        return actuator[BOUNDS[row.name][0]], actuator[BOUNDS[row.name][1]]
    if value != 0.0:
        return (value / _REACH, value * _REACH) if value > 0.0 else (value * _REACH, value / _REACH)
    if isinstance(row, EffectParameter):
        typical = record_of(row.effect).typical
        size = _EFFECT_REACH * abs(typical.values.get(row.field, 0.0)) if typical is not None else 0.0
        return (-size, size) if size > 0.0 else None
    # a torque beside the dry friction
    return (-actuator["screw.csj_Nm"], actuator["screw.csj_Nm"]) if row.unit == "Nm" and actuator["screw.csj_Nm"] > 0.0 else None


def searched_of(actuator: Actuator, text: str) -> tuple[Searched, ...]:
    """What `--values NAME,NAME=LOWER..UPPER,...` asks for, each from the actuator's own value inside the bounds given, or usual ones.

    Raises InputError that names the value.
    """
    parts = [part.strip() for part in text.split(",") if part.strip()]
    rows = {}
    for part in parts:
        name, given, bounds = part.partition("=")
        row = _row(name.strip())
        if row.name in rows:
            raise InputError(f"--values {shown(row)}: stands there twice: leave one out")
        rows[row.name] = (row, _bounds_given(name.strip(), bounds) if given else None)
    if not 1 <= len(rows) <= SEARCHED_MAX:
        raise InputError(f"--values: {len(rows)} values: give one to {SEARCHED_MAX} with commas between")
    found = []
    for row, stated in rows.values():
        usual = stated or _usual(actuator, row)
        if usual is None:
            raise InputError(f"--values {shown(row)}: it is zero, so nothing says where to look: give bounds, {shown(row)}=LOWER..UPPER")
        lower, upper = (max(usual[0], row.lower), min(usual[1], row.upper)) if stated is None else usual
        if not (row.lower <= lower < upper <= row.upper):
            raise InputError(f"--values {shown(row)}={lower:g}..{upper:g}: outside {row.lower:g} .. {row.upper:g}: give bounds inside")
        start = min(max(actuator[row.name], lower), upper)
        found.append(Searched(row.name, lower, upper, start, _companion(actuator, row.name, rows)))
    return tuple(found)


def _companion(actuator: Actuator, name: str, asked: Mapping[str, object]) -> str | None:
    for names in _TOGETHER:
        others = [other for other in names if other != name]
        if name in names and not any(other in asked for other in others) and actuator[name] != 0.0 and actuator[others[0]] != 0.0:
            return others[0]
    return None


def _shaped(actuator: Actuator, searched: tuple[Searched, ...]) -> Actuator:
    """The actuator with the usual shape of effects that are searched and that it does not have: its own would be none."""
    known = load_definitions()
    absent = {row.effect for one in searched if isinstance(row := known.by_name[one.name], EffectParameter)} - set(actuator.active_effects)
    shapes: dict[str, float] = {}
    for effect in absent:
        typical = record_of(effect).typical
        fields = typical.values if typical is not None else {}
        shapes |= {f"effects.{effect}.{field}": value for field, value in fields.items() if field != known.effect(effect).size.field}
    return actuator.changed(shapes)


def noise_of_signals(record: Record) -> dict[str, float]:
    """How noisy each recorded signal of CHANNELS is, rms, by the signal itself."""

    def noise(values: Reals) -> float:
        return max(white_noise(values), _NOISE_FLOOR * float(np.std(values)))

    found = {name: noise(values) for name in CHANNELS if (values := record.channel(name)) is not None}
    # a signal that never moves tells nothing
    return {name: std for name, std in found.items() if std > 0.0}


def several_values(
    actuator: Actuator, record: Record, text: str, bits: int = 32, progress: Callable[[int, float], None] | None = None
) -> SeveralValues:
    """Search the values of `text` (`searched_of`) on a record, by every signal that it has. `progress` gets model runs and misfit. Raises InputError."""
    searched = searched_of(actuator, text)
    noise = noise_of_signals(record)
    if not noise:
        raise InputError(f"{record.file}: no signal moves: nothing can be found on it")
    four = [noise.get(name, 0.0) for name in CHANNELS]
    settings = SquaresSettings(searched, (four[0], four[1], four[2], four[3]))
    values, options = _shaped(actuator, searched).arrays()
    found = least_squares(
        values,
        options,
        record.command_mm,
        record.table(),
        settings,
        bits,
        None if progress is None else lambda runs, misfit, _lowest: progress(runs, misfit),
    )
    return SeveralValues(
        found,
        {one.name: actuator[one.name] for one in searched},
        {one.name: one.companion for one in searched if one.companion is not None},
        noise,
    )
