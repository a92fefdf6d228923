"""Every effect of the library as a torque that the motor must bring up, from measured signals: one column per amplitude, in all shapes worth trying.

An effect without parameters of shape is asked through the balances themselves, at a small size, so that an effect of one's own needs nothing here. Those with many shapes are
written out, since hundreds of them are tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.mechanical import Mechanical, mechanical_model
from ema_tools.balances.motion import Motion, motion_of
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import Effect, load_definitions

LEVEL = "screw.csj_Nm"
VISCOUS = "screw.viscous_Nm_s_per_rad"
NOT_HERE = "it does not show between the motor's torque and the measured motion"
# Base values that an effect's size may be a share of.
_RELATIVE_TO = (LEVEL, VISCOUS)

_PERIODS = (*range(1, 61), 64, 66, 72, 78, 80, 84, 90, 96, 108, 120, 126, 132, 144, 156, 168, 180)
_STRIBECK_SPEED_SHARES = (0.01, 0.02, 0.04, 0.08, 0.15, 0.25, 0.4, 0.6)
_STRIBECK_SHAPES = (0.5, 1.0, 2.0)
_JAM_WIDTH_SHARES = (0.003, 0.006, 0.0125, 0.025, 0.05)
_JAM_PLACES = 61
_STRETCHES_RAD = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
_DELAYS_S = (5e-5, 1e-4, 2e-4, 3.5e-4, 5e-4, 7e-4, 1e-3, 1.5e-3, 2e-3, 3e-3)
# Probe of an effect asked through the balances: its size as a share of its range; larger when nothing shows.
_PROBE = 1e-3


Shape = Mapping[str, float]


@dataclass(frozen=True)
class Pattern:
    """An effect in one shape. `columns` [rows, 1 or 2]: torque against extension per unit of the fitted coefficient, two for an amplitude and a phase.

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

    def values(self, coefficients: Reals, base: Mapping[str, float]) -> dict[str, float]:
        """The effect's values by name for fitted coefficients [1 or 2] and base values."""
        size = load_definitions().effect(self.effect).size.name
        if self.bends:
            return dict(self.shape)
        amount = float(np.hypot(*coefficients)) if self.phase else float(coefficients[0])
        found = {size: amount / base[self.size_per] if self.size_per else amount, **self.shape}
        if self.phase:
            sine, cosine = float(coefficients[0]), float(coefficients[1])
            found[self.phase] = float(np.arctan2(-sine, cosine) if self.cosine else np.arctan2(cosine, sine))
        return found


@dataclass(frozen=True)
class Setting:
    """What the patterns of one record are made from: the actuator as far as it is known, its balance and its motion, each on every row."""

    actuator: Actuator
    record: Record
    model: Mechanical
    motion: Motion
    _required: dict[str, Reals] = field(default_factory=dict)

    def required_Nm(self, halved: str = "") -> Reals:
        """What the balance requires without any further effect, with one base value halved, [rows]."""
        if halved not in self._required:
            actuator = self.actuator.changed({halved: 0.5 * self.actuator[halved]}) if halved else self.actuator
            self._required[halved] = required_Nm(actuator, self.record, self.model.smoother)
        return self._required[halved]

    @staticmethod
    def of(actuator: Actuator, record: Record, smoother: Smoother) -> Setting:
        """Raises MissingSignal."""
        return Setting(
            actuator, record, mechanical_model(actuator, record, smoother, held=True), motion_of(actuator, record, smoother, held=True)
        )


def _pair(angle: Reals) -> Reals:
    return np.column_stack([np.sin(angle), np.cos(angle)])


def _periods_in_band(setting: Setting) -> list[int]:
    """Periods per motor turn that pass the filter at least at the record's slower speeds."""
    slow = float(np.quantile(np.abs(setting.motion.speed_rad_s), 0.25))
    highest = 0.5 * setting.model.smoother.cutoff_hz * 2.0 * np.pi / max(slow, 1e-9)
    return [periods for periods in _PERIODS if periods <= highest]


def _cogging(setting: Setting, shape: Shape) -> Pattern:
    columns = -_pair(shape["cogging_torque.periods"] * setting.motion.angle_rad)
    return Pattern("cogging_torque", shape, columns, phase="cogging_torque.phase_rad")


def _torque_ripple(setting: Setting, shape: Shape) -> Pattern:
    torque = adjusted(setting.actuator)["motor.torque_constant_Nm_per_A"] * setting.motion.current_A
    columns = -torque[:, None] * _pair(shape["torque_ripple.periods"] * setting.motion.angle_rad)
    return Pattern("torque_ripple", shape, columns, phase="torque_ripple.phase_rad", cosine=True)


def _pitch_ripple(setting: Setting, shape: Shape) -> Pattern:
    turns = 2.0 * np.pi * setting.motion.motor_mm / setting.actuator["screw.lead_mm"]
    return Pattern("pitch_ripple", shape, setting.model.contact[:, None] * _pair(turns), LEVEL, phase="pitch_ripple.phase_rad")


def _stribeck(setting: Setting, shape: Shape) -> Pattern:
    faded = np.exp(-((np.abs(setting.motion.speed_rad_s) / shape["stribeck_friction.speed_rad_s"]) ** shape["stribeck_friction.shape"]))
    return Pattern("stribeck_friction", shape, (setting.model.contact * faded)[:, None], LEVEL)


def _jam(setting: Setting, shape: Shape) -> Pattern:
    spot = np.exp(-(((setting.motion.motor_mm - shape["jam_spot.place_mm"]) / shape["jam_spot.width_mm"]) ** 2))
    return Pattern("jam_spot", shape, (setting.model.contact * spot)[:, None])


def _bending(effect: str) -> Callable[[Setting, Shape], Pattern]:
    return lambda setting, shape: Pattern(effect, shape, np.zeros((setting.record.rows, 0)))


def _stribeck_shapes(setting: Setting) -> list[Shape]:
    fastest = float(np.max(np.abs(setting.motion.speed_rad_s), initial=0.0))
    row = load_definitions().by_name["stribeck_friction.speed_rad_s"]
    speeds = sorted({float(np.clip(share * fastest, row.lower, row.upper)) for share in _STRIBECK_SPEED_SHARES})
    return [
        {"stribeck_friction.speed_rad_s": speed, "stribeck_friction.shape": power}
        for speed, power in itertools.product(speeds, _STRIBECK_SHAPES)
    ]


def _jam_shapes(setting: Setting) -> list[Shape]:
    first, last = float(setting.motion.motor_mm.min()), float(setting.motion.motor_mm.max())
    least = load_definitions().by_name["jam_spot.width_mm"].lower
    places = np.linspace(first, last, _JAM_PLACES).tolist()
    return [
        {"jam_spot.place_mm": place, "jam_spot.width_mm": max(share * (last - first), least)}
        for place, share in itertools.product(places, _JAM_WIDTH_SHARES)
    ]


def _delay_shapes(setting: Setting) -> list[Shape]:
    late = setting.actuator.changed({"actuation_delay.delay_s": _DELAYS_S[0]})
    if np.array_equal(mechanical_model(late, setting.record, setting.model.smoother, held=True).drive_Nm, setting.model.drive_Nm):
        return []
    return [{"actuation_delay.delay_s": delay} for delay in _DELAYS_S]


@dataclass(frozen=True)
class _Written:
    """How an effect's patterns are made: the shapes to try, and the pattern of one; `continuous` of its shape parameters lie between the shapes tried."""

    shapes: Callable[[Setting], Sequence[Shape]]
    make: Callable[[Setting, Shape], Pattern]
    continuous: tuple[str, ...] = ()


_WRITTEN: Mapping[str, _Written] = {
    "cogging_torque": _Written(
        lambda setting: [{"cogging_torque.periods": float(periods)} for periods in _periods_in_band(setting)], _cogging
    ),
    "torque_ripple": _Written(
        lambda setting: [{"torque_ripple.periods": float(periods)} for periods in _periods_in_band(setting)], _torque_ripple
    ),
    "pitch_ripple": _Written(lambda setting: [{}], _pitch_ripple),
    "stribeck_friction": _Written(_stribeck_shapes, _stribeck, ("stribeck_friction.speed_rad_s", "stribeck_friction.shape")),
    "jam_spot": _Written(_jam_shapes, _jam, ("jam_spot.place_mm", "jam_spot.width_mm")),
    "presliding": _Written(lambda setting: [{"presliding.stretch_rad": stretch} for stretch in _STRETCHES_RAD], _bending("presliding")),
    "actuation_delay": _Written(_delay_shapes, _bending("actuation_delay")),
}


def required_Nm(actuator: Actuator, record: Record, smoother: Smoother) -> Reals:
    """What the balance says the motor must bring up, less what it does, on every row that slides; a constant torque apart. Raises MissingSignal."""
    model = mechanical_model(actuator, record, smoother, held=True)
    values = adjusted(actuator)
    base = (values["screw.inertia_kgm2"], values[VISCOUS], values["screw.dynamic_ratio"] * values[LEVEL], values["screw.load_torque_Nm"])
    return np.asarray(model.load_Nm + model.added_Nm + model.columns @ np.array(base) - model.drive_Nm)


def _asked(setting: Setting, effect: Effect) -> Pattern | str:
    """The column of an effect of one shape, from the balances with and without it; or why there is none."""
    size = effect.size

    def column(halved: str = "") -> Reals:
        base = {halved: 0.5 * setting.actuator[halved]} if halved else {}
        with_it = setting.actuator.changed({**base, size.name: size.nominal + probe})
        return (required_Nm(with_it, setting.record, setting.model.smoother) - setting.required_Nm(halved)) / probe

    reach = size.upper - size.nominal if size.upper > size.nominal else size.lower - size.nominal
    probe = _PROBE * reach
    try:
        found = column()
        if not np.any(found):
            return NOT_HERE
        for name in _RELATIVE_TO:
            base = setting.actuator[name]
            if base > 0.0 and np.allclose(column(name), 0.5 * found, rtol=1e-6, atol=1e-9 * float(np.max(np.abs(found)))):
                return Pattern(effect.name, {}, found[:, None] / base, name)
    except (InputError, MissingSignal) as error:
        return str(error)
    return Pattern(effect.name, {}, found[:, None])


def patterns_of(setting: Setting, effect: str) -> Sequence[Pattern] | str:
    """Every shape of an effect that is tried; or in one sentence why none can be."""
    if effect in _WRITTEN:
        written = _WRITTEN[effect]
        return tuple(written.make(setting, shape) for shape in written.shapes(setting)) or NOT_HERE
    found = _asked(setting, load_definitions().effect(effect))
    return found if isinstance(found, str) else (found,)


def pattern_of(setting: Setting, effect: str, shape: Shape) -> Pattern | str:
    """An effect in one shape; or in one sentence why there is no such pattern."""
    return _WRITTEN[effect].make(setting, shape) if effect in _WRITTEN else _asked(setting, load_definitions().effect(effect))


def continuous_of(effect: str) -> tuple[str, ...]:
    """The shape parameters of an effect that lie between the shapes tried."""
    return _WRITTEN[effect].continuous if effect in _WRITTEN else ()
