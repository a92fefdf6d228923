"""How machines differ: from run to run, and from their data sheet. What of that lies in a parameter of the model is free within its spread, never named as an effect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, row_of, scatters_by_share
from ema_tools.library.definitions import is_size, load_definitions
from ema_tools.library.faults import FAULTS, effect_of
from ema_tools.library.registry import record_of, records

# Usual scatter of one machine from run to run, relative: dry friction, grease, winding; [scatter] of an actuator's file states its own in their place [physics]
FROM_RUN_TO_RUN: Mapping[str, float] = {"screw.csj_Nm": 0.004, "screw.viscous_Nm_s_per_rad": 0.01, "motor.resistance_ohm": 0.003}

# The usual scatter counts as much as so many healthy runs that had shown it [judgement]
USUAL_WEIGHT = 4.0
COPPER_PER_DEGC = 0.00393  # IEC 60028 [physics]
GREASE_PER_DEGC = 0.028  # a grease loses half of its viscosity in about 25 degC near room temperature [physics]
FRICTION_PER_DEGC = 0.005  # of dry friction, one standard deviation about none: greases and seals differ in sign as well [physics]
# What varies besides, by a little that the signals follow evenly, relative [judgement]
BESIDES: Mapping[tuple[str, ...], float] = {
    ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad"): 0.001,
    ("drive.supply_V",): 0.002,
    ("screw.inertia_kgm2",): 0.001,
    ("motor.inductance_H",): 0.005,
    ("control.kp_per_m",): 0.0005,
}
# Where the recorded voltage is what the controller asks for of a supply that is taken for constant, it is less where the supply gives more: by this from run to run, relative [judgement]
ASKED = "asked voltage"
ASKED_VARIES = 0.002
# The same of what a data sheet gives as zero, in its own unit [judgement]
BESIDES_IN_UNIT: Mapping[str, float] = {
    "screw.friction_asymmetry": 0.0005,
    "screw.load_torque_Nm": 1e-4,
    "encoder.rod_gain_error": 5e-5,
    "encoder.rod_offset_mm": 2e-4,
}
# The standing effects of the machine vary by this share of their size [judgement]
STANDING_VARIES = 0.05
# What every machine has a little of and its model does not hold varies by this share of what counts as slight [judgement]
SLIGHT_VARIES = 0.1
# A day of another temperature moves these together: one standard deviation in degC [judgement]
DAY_DEGC = 5.0
# What a degree makes of each, relative: of magnets between those that hardly care (samarium-cobalt) and ferrite (R. Krishnan, Permanent Magnet Synchronous and Brushless DC
# Motor Drives, 2010, ch. 1) [physics]
PER_DEGC: Mapping[str, float] = {
    "motor.resistance_ohm": COPPER_PER_DEGC,
    "screw.viscous_Nm_s_per_rad": -GREASE_PER_DEGC,
    "motor.torque_constant_Nm_per_A": -0.001,
    "motor.back_emf_V_s_per_rad": -0.001,
}
TEMPERATURE = "temperature"  # what moves them
# By how much these differ from machine to machine, one standard deviation [physics]
PER_DEGC_DIFFERS: Mapping[str, float] = {
    "screw.csj_Nm": FRICTION_PER_DEGC,
    "screw.viscous_Nm_s_per_rad": 0.012,
    "motor.torque_constant_Nm_per_A": 0.0007,
}

# Of these what the onboard search finds beside CSJ and BLK where it is told to search values of the day [physics]
DAY = ("screw.viscous_Nm_s_per_rad", "motor.resistance_ohm")

# Usual distance of one unit from its data sheet, relative: estimates, after the tolerances that makers of motors (constants 5 .. 10 %,
# resistance 5 .. 10 %) and screws state. Torque and back-EMF constant are one property of the magnets and move together [physics]
FROM_DATA_SHEET: Mapping[tuple[str, ...], float] = {
    ("screw.csj_Nm",): 0.1,
    ("screw.viscous_Nm_s_per_rad",): 0.2,
    ("screw.inertia_kgm2",): 0.05,
    ("screw.blk_mm",): 0.1,
    ("motor.resistance_ohm",): 0.04,
    ("motor.inductance_H",): 0.1,
    ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad"): 0.025,
    ("drive.supply_V",): 0.01,
}
# How far a known machine may be today from what is known of it, with nobody the wiser: winding and magnets by 20 and 10 degC, grease by as much, supply, gain
# as they vary between days and installations, relative; the sizes of effects that come and go so stand in their records [judgement]
OF_TODAY: Mapping[tuple[str, ...], float] = {
    ("motor.resistance_ohm",): 0.08,
    ("screw.viscous_Nm_s_per_rad",): 0.3,
    ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad"): 0.02,
    ("drive.supply_V",): 0.03,
    ("control.kp_per_m",): 0.02,
}
HEALTHY_FREEDOM = 5.0  # a healthy machine is fitted as freely as its records allow: factor on the spreads above [judgement]
# And of what a data sheet gives as zero [judgement]
STANDING: Mapping[str, float] = {"screw.friction_asymmetry": 0.05, "encoder.rod_gain_error": 0.005, "encoder.rod_offset_mm": 0.05}
# The same of a unit that is known by its data sheet alone [physics]
UNIT_STANDING: Mapping[str, float] = {
    "screw.friction_asymmetry": 0.004,
    "encoder.rod_gain_error": 0.0003,
    "encoder.rod_offset_mm": 0.003,
}
# And what a data sheet states as exact: the gain of the loop [physics]
UNIT_GAIN: Mapping[tuple[str, ...], float] = {("control.kp_per_m",): 0.005}
# Dry friction and backlash are what wears: without repeats a worn unit must not be read as a missing effect [judgement]
WORN: Mapping[str, float] = {"screw.csj_Nm": 0.5, "screw.blk_mm": 0.7}
# A size of an effect up to so many of the standard deviations that its record calls slight is what every machine has, and is not named
# without repeats [chance]
SLIGHT_REACH = 2.0
OFFSET_SHARE = 0.05  # offsets of the recorded signals, relative to the signal's size [judgement]
OFFSET_CHANNELS = ("motor_position_mm", "current_A")
# Gain errors of the recorded signals of a unit that is known by its data sheet alone, relative [physics]
GAIN_SHARE: Mapping[str, float] = {"current_A": 0.005}


@dataclass(frozen=True)
class Spread:
    """Values that move together, by `std` (1 standard deviation): relative to each value, or absolute where it is zero on the data sheet. `shares`: how far each moves of that, all alike
    unless told; `cause`: what moves them, where it is no value itself; `step`: over how many standard deviations its slope is taken, where the usual step would not show."""

    names: tuple[str, ...]
    std: float
    relative: bool
    shares: tuple[float, ...] = ()
    cause: str = ""
    step: float = 0.0

    @property
    def title(self) -> str:
        """The value that stands for all, or what moves them."""
        return self.cause or self.names[0]

    def moves(self, actuator: Actuator) -> bool:
        """Whether it moves anything: a share of zero does not."""
        return not self.relative or actuator[self.names[0]] > 0.0

    def in_unit(self, actuator: Actuator) -> float:
        """One standard deviation of the first value, in its unit."""
        return self.std * abs(actuator[self.title]) if self.relative else self.std

    def changes(self, actuator: Actuator, deviations: float, moved: Mapping[str, float] | None = None) -> dict[str, float]:
        """The values at so many standard deviations from the actuator's own, or from those that something else has `moved` already, held inside their ranges."""
        found = {}
        for name, share in zip(self.names, self.shares or (1.0,) * len(self.names), strict=True):
            row = row_of(name)
            known = (moved or {}).get(name, actuator[row.name])
            value = known * (1.0 + share * self.std * deviations) if self.relative else known + share * self.std * deviations
            found[name] = min(max(value, row.lower), row.upper)
        return found


def moved(actuator: Actuator, spread: Sequence[Spread], deviations: Sequence[float] | Reals) -> dict[str, float]:
    """The values of all of `spread` at their `deviations`, one after the other; what else is free stands behind those and is left out."""
    found: dict[str, float] = {}
    for one, at in zip(spread, deviations[: len(spread)], strict=True):
        found |= one.changes(actuator, float(at), found)
    return found


def share_from_run_to_run(actuator: Actuator, name: str) -> float:
    """By how much a value differs from run to run, relative, without what its healthy records show: as the actuator states, else the usual; zero for what does not scatter."""
    return actuator.scatter.get(name, FROM_RUN_TO_RUN.get(name, 0.0))


def stated_std(actuator: Actuator, name: str) -> float | None:
    """What the actuator states of a value's scatter from run to run, one standard deviation in its unit; None where it states nothing."""
    std = actuator.scatter.get(name)
    return None if std is None else Spread((name,), std, scatters_by_share(row_of(name))).in_unit(actuator)


def from_run_to_run(actuator: Actuator) -> tuple[Spread, ...]:
    """What scatters between runs: as the actuator states, and by the usual figure of what it does not state."""
    std = {**FROM_RUN_TO_RUN, **actuator.scatter}
    return tuple(Spread((name,), value, scatters_by_share(row_of(name))) for name, value in std.items() if value > 0.0)


def besides(actuator: Actuator) -> tuple[Spread, ...]:
    """What varies between runs beside `from_run_to_run`, of what the actuator has and states nothing of: the temperature first, then parameters, and the sizes of effects."""
    active = actuator.active_effects
    standing = [Spread((effect.size.name,), STANDING_VARIES, True) for effect in load_definitions().physical if effect.name in active]
    shares = [*(Spread(names, std, True) for names, std in BESIDES.items()), *standing]
    sizes = {effect.size.name: record_of(effect.name).varies for effect in load_definitions().physical}
    in_unit = [
        Spread((name,), std, False) for name, std in {**BESIDES_IN_UNIT, **sizes}.items() if std > 0.0 and name.split(".")[0] not in active
    ]
    in_unit += [
        Spread((effect.size.name,), SLIGHT_VARIES * record.slight.usual(actuator["screw.csj_Nm"]), False, step=1.0 / SLIGHT_VARIES)
        for effect in load_definitions().physical
        for record in (record_of(effect.name),)
        if record.slight is not None and not record.is_shaped and effect.name not in active
    ]
    every = [*(one for one in shares if actuator[one.title] != 0.0), *in_unit]
    warmer = Spread(tuple(PER_DEGC), DAY_DEGC, True, tuple(PER_DEGC.values()), TEMPERATURE)
    asked = Spread(("drive.supply_V",), ASKED_VARIES, True, cause=ASKED)
    return (warmer, *(one for one in (asked, *every) if not set(one.names) & set(actuator.scatter)))


def from_day_to_day(actuator: Actuator) -> tuple[Spread, ...]:
    """Of what scatters between runs that which no one searches for: grease, winding and what is stated besides, of those values that the actuator has at all."""
    return tuple(one for one in from_run_to_run(actuator) if one.title not in FAULTS.values() and one.moves(actuator))


def variances_shown(usual: Reals, values: Reals, doubt: Reals | float = 0.0) -> Reals:
    """Variances [k] that `values` [k, runs] show about their mean, each known to the variance `doubt` [k], beside the `usual` ones [k]."""
    told = values.shape[1] - 1
    return np.asarray((USUAL_WEIGHT * usual + np.sum(values**2, axis=1) + told * doubt) / (USUAL_WEIGHT + told))


def widths_shown(actuator: Actuator, usual: Sequence[Spread], shares: Reals) -> Reals:
    """By how many times the usual each spread scatters, [spreads], as `shares` [spreads, runs] of healthy runs show, in spreads.

    What the actuator states is known, and a few runs do not change it.
    """
    return np.where([one.title in actuator.scatter for one in usual], 1.0, np.sqrt(variances_shown(np.ones(len(usual)), shares)))


def _no_less_than_stated(actuator: Actuator, spread: Sequence[Spread]) -> tuple[Spread, ...]:
    """The spread of a machine over more than two runs: no narrower than it is stated to be from one to the next, and with what is stated besides."""
    stated = {one.title: one for one in from_run_to_run(actuator) if one.title in actuator.scatter}
    wider = [replace(one, std=max([one.std, *(stated[name].std for name in one.names if name in stated)])) for one in spread]
    named = {name for one in spread for name in one.names} | set(FAULTS.values())
    return (*wider, *(one for name, one in stated.items() if name not in named and one.moves(actuator)))


def from_data_sheet(actuator: Actuator, freedom: float = 1.0) -> tuple[Spread, ...]:
    """What differs from the data sheet, of those values that the actuator has at all."""
    return tuple(Spread(names, freedom * std, True) for names, std in FROM_DATA_SHEET.items() if actuator[names[0]] > 0.0)


def of_today(actuator: Actuator) -> tuple[Spread, ...]:
    """How far a known machine may be today from what is known of it, of those values that the actuator has at all."""
    values = _no_less_than_stated(actuator, [Spread(names, std, True) for names, std in OF_TODAY.items() if actuator[names[0]] > 0.0])
    sizes = {effect.name: f"effects.{effect.size.name}" for effect in load_definitions().physical}
    effects = tuple(Spread((sizes[name],), record.today, False) for name, record in records().items() if record.today > 0.0)
    return (*values, *effects)


def of_unit(actuator: Actuator) -> tuple[Spread, ...]:
    """What is free in a unit that is known by its data sheet alone."""
    sheet = tuple(replace(one, std=WORN.get(one.title, one.std)) for one in from_data_sheet(actuator))
    gains = tuple(Spread(names, std, True) for names, std in UNIT_GAIN.items() if actuator[names[0]] > 0.0)
    return _no_less_than_stated(actuator, [*sheet, *gains, *(Spread((name,), std, False) for name, std in UNIT_STANDING.items())])


def of_healthy_machine(actuator: Actuator, channels: Sequence[str]) -> tuple[Spread, ...]:
    """What is fitted to healthy records before anything is compared with them."""
    standing = tuple(Spread((name,), std, False) for name, std in STANDING.items())
    alone = tuple(channels) == ("position_mm",)
    # with the rod position alone the electrical values are hardly determined: as tight as the data sheet says
    return (*from_data_sheet(actuator, 1.0 if alone else HEALTHY_FREEDOM), *standing)


def slight() -> list[dict[str, float]]:
    """Effects that every machine has a little of, free within one standard deviation, in the order of their names."""
    known = sorted(records().items(), key=lambda item: item[0])
    free = [(effect, values) for effect, record in known if record.slight is not None for values in record.slight.free]
    return [{f"effects.{effect}.{field}": value for field, value in values.items()} for effect, values in free]


def is_free(effect: str) -> bool:
    """Whether a little of an effect is free in a unit that is known by its data sheet alone."""
    record = record_of(effect).slight
    return record is not None and bool(record.free)


def is_slight(actuator: Actuator, name: str, size: float) -> bool:
    """Whether a size is what every machine has of an effect; `name`: of a value, of which only sizes count."""
    one = record_of(effect_of(name)).slight
    return one is not None and is_size(name) and abs(size) <= SLIGHT_REACH * one.usual(actuator["screw.csj_Nm"])


def are_slight(actuator: Actuator, values: Mapping[str, float]) -> bool:
    """`is_slight` by any of an effect's values."""
    return any(is_slight(actuator, name, value) for name, value in values.items())
