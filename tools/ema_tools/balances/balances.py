"""Four balances, each from measured signals and one group of blocks, so that its residual accuses that group.

mechanical: kt i - (J dw/dt + D w + F sgn w + load); electrical: u - (R i + L di/dt + ke w); kinematic: rod position - play of the motor
position; controller: applied command - control law of command and feedback. What the actuator's enabled effects add is part of the model side.

Every channel of the first two passes the same zero-phase Butterworth filter of fourth order before differences are taken, edges are dropped, and
the result is decimated to the filter's band; while the shaft rests, friction is taken as whatever balances the torque, up to its static level. On the record of a real ball-screw
axis this reproduces the published force error: A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, 2019.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.library.definitions import load_definitions

BALANCES = ("mechanical", "electrical", "kinematic", "controller")
# Rows at both ends that carry the filters' edges: 50 at 1 kHz.
EDGE_S = 0.05
# The shaft rests where it stays below this share of its largest speed for at least this time.
SLOW_SHARE = 0.01
REST_S = 0.01
# Largest noise of the inertia torque over the drive torque, by which the filter is chosen, and the lowest filter.
NOISE_SHARE = 0.02
CUTOFF_MIN_HZ = 12.5
_ORDER = 4
_RATE_OVER_CUTOFF = 10
_CUTOFF_MAX_HZ = 100.0


@functools.cache
def _butterworth(share: float) -> Reals:
    """Second-order sections for a cutoff as share of half the sample rate."""
    return np.asarray(signal.butter(_ORDER, share, output="sos"))


@functools.cache
def _chebyshev(every: int) -> Reals:
    """Second-order sections in front of a decimation."""
    return np.asarray(signal.cheby1(8, 0.05, 0.8 / every, output="sos"))


@dataclass(frozen=True)
class Smoother:
    """The zero-phase filter of all channels and the decimation behind it."""

    period_s: float
    cutoff_hz: float

    @staticmethod
    def of(period_s: float) -> Smoother:
        """The usual one: a tenth of the sample rate, at most 100 Hz."""
        return Smoother(period_s, min(_CUTOFF_MAX_HZ, 1.0 / (_RATE_OVER_CUTOFF * period_s)))

    @property
    def every(self) -> int:
        """Rows per decimated sample: its rate is the filter's cutoff."""
        return max(1, round(1.0 / (self.cutoff_hz * self.period_s)))

    @property
    def edge_rows(self) -> int:
        """Rows dropped at each end."""
        return max(1, round(EDGE_S / self.period_s))

    @property
    def least_rows(self) -> int:
        """Rows of the shortest record that is worth filtering: half of it is left."""
        return 4 * self.edge_rows

    def smooth(self, values: Reals) -> Reals:
        """Filtered forward and backward, [rows]."""
        return np.asarray(signal.sosfiltfilt(_butterworth(2.0 * self.cutoff_hz * self.period_s), values))

    @property
    def low_pass(self) -> Reals:
        """Second-order sections of the filter in front of the decimation."""
        return _chebyshev(self.every)

    def inner(self, values: NDArray[Any]) -> NDArray[Any]:
        """Without the edges, [rows - 2 edge_rows]."""
        return values[self.edge_rows : -self.edge_rows]

    def decimated(self, values: Reals) -> Reals:
        """Edges dropped, then low-passed below the new rate and every n-th row kept, [samples]. Raises MissingSignal for fewer than the least rows."""
        if len(values) < self.least_rows:
            raise MissingSignal(f"{len(values)} rows are too few for any filter, {self.least_rows} are needed")
        inner = self.inner(values)
        return inner if self.every == 1 else np.asarray(signal.sosfiltfilt(self.low_pass, inner))[:: self.every]

    def kept(self, values: NDArray[Any]) -> NDArray[Any]:
        """The rows at which `decimated` has its samples, without filtering, [samples]."""
        return self.inner(values)[:: self.every]


@dataclass(frozen=True)
class Motion:
    """Motor signals on every row: current A, speed rad/s, acceleration rad/s2, angle rad, all smoothed; and the unsmoothed motor position mm."""

    current_A: Reals
    speed_rad_s: Reals
    acceleration_rad_s2: Reals
    angle_rad: Reals
    motor_mm: Reals


@dataclass(frozen=True)
class Balance:
    """One balance on its samples: measured side and residual, both [samples] in `unit`, and their time; `resting_percent` is the share of
    the record in which the shaft rests and friction is not tested."""

    name: str
    unit: str
    time_s: Reals
    measured: Reals
    residual: Reals
    resting_percent: float = 0.0

    @property
    def rms(self) -> float:
        """Root mean square of the residual."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def relative_percent(self) -> float:
        """100 * norm of the residual / norm of the measured side; NaN when nothing was measured."""
        size = float(np.linalg.norm(self.measured))
        return 100.0 * float(np.linalg.norm(self.residual)) / size if size > 0.0 else math.nan


def adjusted(actuator: Actuator) -> dict[str, float]:
    """The values with the enabled PARAMETER effects in them, by name."""
    values = dict(actuator.values)
    for module, effect in _active(actuator, "PARAMETER"):
        values.update(module.change_values(effect, values))
    return values


def _active(actuator: Actuator, site: str) -> Iterator[tuple[Any, Any]]:
    """The reference module and the values of every active effect of a site."""
    active = set(actuator.active_effects)
    names = [effect.name for effect in load_definitions().effects if effect.site == site and effect.name in active]
    if not names:
        return
    from ema_tools.reference.actuator import build
    from ema_tools.reference.effects import module_of

    effects = build(actuator.values).effects
    for name in names:
        yield module_of(name), getattr(effects, name)


def _at_points(
    actuator: Actuator,
    motion: Motion,
    site: str,
    equation: str,
    level_Nm: float | None = None,
    voltage_V: Reals | None = None,
    rows: NDArray[np.bool_] | None = None,
) -> Reals:
    """Sum of an equation over the active effects of a site, on every row, or on `rows` and zero elsewhere; zeros at no cost when there are none.

    `level_Nm`: of friction, `voltage_V` [rows]: for equations that look at them.
    """
    total = np.zeros(motion.speed_rad_s.size)
    active = list(_active(actuator, site))
    kept = np.ones(total.size, dtype=bool) if rows is None else rows
    if not active or not kept.any():
        return total
    from ema_tools.reference.actuator import plain
    from ema_tools.reference.compiled import interpreted
    from ema_tools.reference.point import Data, Point

    terms = [(interpreted(getattr(module, equation)), plain(effect)) for module, effect in active]
    given = () if level_Nm is None else (level_Nm,)
    values = adjusted(actuator)
    data = Data(
        values["motor.torque_constant_Nm_per_A"], values["screw.viscous_Nm_s_per_rad"], values["screw.lead_mm"], values["drive.supply_V"]
    )
    voltage = np.zeros(total.size) if voltage_V is None else voltage_V
    columns = (motion.current_A, motion.speed_rad_s, motion.angle_rad, motion.motor_mm, voltage)
    rows_at = zip(*(column[kept].tolist() for column in columns), strict=True)
    points = (Point(current, speed, angle, motor, volts, data) for current, speed, angle, motor, volts in rows_at)
    total[kept] = [sum(term(effect, *given, point) for term, effect in terms) for point in points]
    return total


def _mixed(values: Reals, rows: int, share: float) -> Reals:
    """(1 - share) of `values` [rows] `rows` earlier and `share` of one more row earlier; the first and the last value go on beyond the record."""
    place = np.arange(values.size) - rows
    last = values.size - 1
    return (1.0 - share) * values[np.clip(place, 0, last)] + share * values[np.clip(place - 1, 0, last)]


def _split(rows: float) -> tuple[int, float]:
    """A delay in whole rows and the rest of one; what is a whole number but for rounding counts as one."""
    whole = math.floor(rows + 1e-9)
    return whole, max(rows - whole, 0.0)


def drive_current(actuator: Actuator, record: Record, held: bool = False) -> Reals:
    """The motor current, [rows]: as recorded, or from the command of a current drive that is never short of voltage.

    A drive without lag and delay has the command of the row, as published models take it, which leads by half a row what is held from row to row. That half counts as soon as
    a delay is known, or with `held`: the drive then has the mean of what it holds over half a row to both sides. Raises MissingSignal.
    """
    values = adjusted(actuator)
    current_drive = values["drive.mode"] == 1.0
    lag_s = values["drive.current_loop_s"]
    delay = values["drive.output_delay_s"] / record.period_s
    late, rest = _split(delay)
    whole, share = _split(delay + 0.5)
    stands = (delay == 0.0 and not held) or not current_drive or lag_s > 0.0
    if record.current_A is not None:
        # the row shows what the drive holds at its instant: with a part of a row of delay, still the command before
        shown = late + (1 if rest > 0.0 else 0)
        return record.current_A if stands else _mixed(record.current_A, whole - shown, share)
    if not (current_drive and values["drive.command_scale_V"] > 0.0 and record.voltage_V is not None):
        raise MissingSignal("current_A is not recorded")
    asked = record.voltage_V * (values["drive.current_scale_A"] / values["drive.command_scale_V"])
    if lag_s == 0.0:
        return asked if stands else _mixed(asked, whole, share)
    # exact for a reference that is held: over a row the older command acts first
    fade, newer = math.exp(-record.period_s / lag_s), math.exp(-(1.0 - rest) * record.period_s / lag_s)
    weights = (0.0, 1.0 - newer, newer - fade)
    reference = _mixed(asked, late, 0.0)
    start = signal.lfiltic(weights, (1.0, -fade), [reference[0]], [reference[0], reference[0]])
    return np.asarray(signal.lfilter(weights, (1.0, -fade), reference, zi=start)[0])


def _learned_reading_mm(actuator: Actuator, rod_mm: Reals) -> Reals:
    """What learned tables add to the rod sensor's reading, [rows]."""
    functions = list(_active(actuator, "READING"))
    if not functions:
        return np.zeros_like(rod_mm)
    nothing = np.zeros_like(rod_mm)
    seen = Motion(nothing, nothing, nothing, rod_mm / actuator.lead_mm_per_rad, rod_mm)
    return _at_points(actuator, seen, "READING", "reading_mm")


def _read_right(actuator: Actuator, record: Record) -> Reals:
    """The recorded rod position without what learned tables add to it, [rows]."""
    return record.position_mm - _learned_reading_mm(actuator, record.position_mm)


def motor_position(actuator: Actuator, record: Record) -> Reals:
    """The motor position at the rod in mm, [rows]; the rod's own where nothing lies between them. Raises MissingSignal."""
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    if actuator["screw.blk_mm"] == 0.0 and not _transmission(actuator):
        return (_read_right(actuator, record) - actuator["encoder.rod_offset_mm"]) / (1.0 + actuator["encoder.rod_gain_error"])
    between = _transmission(actuator) or "play"
    raise MissingSignal(f"motor_position_mm is not recorded, and the rod follows the motor with {between}")


def _transmission(actuator: Actuator) -> str:
    for effect in load_definitions().effects:
        if effect.site == "TRANSMISSION" and effect.name in actuator.active_effects:
            return effect.name
    return ""


def motion_of(actuator: Actuator, record: Record, smoother: Smoother, held: bool = False) -> Motion:
    """Smoothed motor signals. Raises MissingSignal."""
    motor_mm = motor_position(actuator, record)
    angle = smoother.smooth(motor_mm) / actuator.lead_mm_per_rad
    speed = np.gradient(angle, record.period_s)
    return Motion(smoother.smooth(drive_current(actuator, record, held)), speed, np.gradient(speed, record.period_s), angle, motor_mm)


def _contact(actuator: Actuator, motion: Motion) -> tuple[Reals, bool]:
    """Share of the level of dry friction that acts against extension, [rows], -1 to 1, and whether the contact stretches, so that the shaft never rests."""
    found = [float(effect.stretch_rad) for _, effect in _active(actuator, "PRESLIDING")]
    direction = np.sign(motion.speed_rad_s)
    return (stretched(motion.angle_rad, found[0]), True) if found else (direction, False)


def stretched(angle_rad: Reals, stretch_rad: float) -> Reals:
    """Share of the sliding level that a contact carries which stretches before it slides, [rows]: dz/dtheta = (1 - z sgn w) / stretch, from zero."""
    turns = np.diff(angle_rad, prepend=angle_rad[:1])
    out = np.empty_like(turns)
    share = 0.0
    for row, (side, kept) in enumerate(
        zip(np.where(turns < 0.0, -1.0, 1.0).tolist(), np.exp(-np.abs(turns) / stretch_rad).tolist(), strict=True)
    ):
        share = side + (share - side) * kept
        out[row] = share
    return out


@dataclass(frozen=True)
class Mechanical:
    """The mechanical balance as a linear model on smoothed rows, all [rows] or [rows, 4].

    drive = load + extra contact + columns @ parameters; columns: acceleration (inertia), speed (viscous), contact (level of sliding friction),
    one (load against extension). `contact` is the direction of sliding, or what of friction a stretched contact carries; in its column the asymmetry of the level is in it.
    `load` and `extra` are what effects and efficiency add; `static_extra` is what they add to the static level backward and forward, where the shaft rests.
    """

    smoother: Smoother
    drive_Nm: Reals
    load_Nm: Reals
    extra_Nm: Reals
    static_extra_Nm: tuple[Reals, Reals]
    contact: Reals
    asymmetry: float
    columns: Reals
    time_s: Reals
    resting: NDArray[np.bool_]

    @property
    def added_Nm(self) -> Reals:
        """Torque of the friction that effects and efficiency add while sliding, against extension, [rows]."""
        return self.extra_Nm * self.contact

    def friction_at_rest_Nm(self, parameters: Reals, static_Nm: float) -> Reals:
        """What balances the torque, up to the static level, on every row; holds where the shaft rests. `parameters` [4] of the columns."""
        net = self.drive_Nm - self.load_Nm - self.columns @ (parameters * (1.0, 1.0, 0.0, 1.0))
        backward, forward = self.static_extra_Nm
        return np.clip(net, -((1.0 - self.asymmetry) * static_Nm + backward), (1.0 + self.asymmetry) * static_Nm + forward)


MECHANICAL_PARAMETERS = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", "screw.load_torque_Nm")
ELECTRICAL_PARAMETERS = ("motor.resistance_ohm", "motor.inductance_H", "motor.back_emf_V_s_per_rad")


def noise_of(values: Reals) -> float:
    """Standard deviation of white noise on a signal [rows], from its fourth differences, which smooth motion hardly has."""
    differences = np.diff(values, 4)
    return 1.4826 * float(np.median(np.abs(differences - np.median(differences)))) / math.sqrt(70.0)


def _resting(motion: Motion, noise_rad_s: float, smoother: Smoother) -> NDArray[np.bool_]:
    """Rows of lasting rest, where friction may have any value up to its level. A reversal that only passes zero is none."""
    inner = slice(smoother.edge_rows, -smoother.edge_rows)
    fastest = float(np.max(np.abs(motion.speed_rad_s[inner]), initial=0.0))
    slow = np.abs(motion.speed_rad_s) <= max(SLOW_SHARE * fastest, 3.0 * noise_rad_s)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], slow.astype(np.int8), [0]))))
    resting = np.zeros(slow.size, dtype=bool)
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if (last - first) * smoother.period_s >= REST_S:
            resting[first:last] = True
    return resting


def mechanical_model(actuator: Actuator, record: Record, smoother: Smoother | None = None, held: bool = False) -> Mechanical:
    """Drive torque, what the effects add, and the columns of the base parameters; `held` as in `drive_current`. Raises MissingSignal."""
    values = adjusted(actuator)
    use = smoother or quiet_smoother(actuator, record)
    motion = motion_of(actuator, record, use, held)
    ripple = _at_points(actuator, motion, "MOTOR", "motor_change")
    drive = values["motor.torque_constant_Nm_per_A"] * (1.0 + ripple) * motion.current_A
    if values["motor.torque_limit_Nm"] > 0.0:
        drive = np.clip(drive, -values["motor.torque_limit_Nm"], values["motor.torque_limit_Nm"])
    contact, elastic = _contact(actuator, motion)
    asymmetry = values["screw.friction_asymmetry"]
    load = _at_points(actuator, motion, "LOAD", "load_Nm")
    passed = load + values["screw.load_torque_Nm"]
    still = replace(motion, speed_rad_s=np.zeros_like(contact))
    torque = _at_points(actuator, motion, "TORQUE", "torque_Nm")

    def added(level: float, side: float, seen: Motion, rows: NDArray[np.bool_]) -> Reals:
        """What effects and efficiency add to a level of friction to one side; holds on `rows`."""
        passing = np.where(passed * side > 0.0, 1.0 / values["gearbox.efficiency"] - 1.0, 1.0 - values["gearbox.efficiency"]) * np.abs(
            passed
        )
        return passing + _at_points(actuator, seen, "FRICTION", "level_change_Nm", level_Nm=level * (1.0 + side * asymmetry), rows=rows)

    sliding, static = values["screw.dynamic_ratio"] * values["screw.csj_Nm"], values["screw.csj_Nm"]
    resting = np.zeros(contact.size, dtype=bool) if elastic else _resting(motion, _speed_noise_rad_s(actuator, record, use), use)
    backward = contact < 0.0
    return Mechanical(
        smoother=use,
        drive_Nm=drive,
        load_Nm=load - torque + _soft_mass_Nm(actuator, record, motion, use),
        extra_Nm=np.where(backward, added(sliding, -1.0, motion, backward), added(sliding, 1.0, motion, ~backward)),
        static_extra_Nm=(added(static, -1.0, still, resting), added(static, 1.0, still, resting)),
        contact=contact,
        asymmetry=asymmetry,
        columns=np.column_stack(
            [motion.acceleration_rad_s2, motion.speed_rad_s, contact * (1.0 + asymmetry * np.sign(contact)), np.ones_like(contact)]
        ),
        time_s=record.time_s,
        resting=resting,
    )


def _soft_mass_Nm(actuator: Actuator, record: Record, motion: Motion, smoother: Smoother) -> Reals:
    """What a mass behind a soft transmission takes more than one that is rigidly coupled, as torque against extension, [rows]."""
    if not _transmission(actuator):
        return np.zeros(record.rows)
    mass_kg, lead_m = actuator["transmission_compliance.mass_kg"], 1e-3 * actuator.lead_mm_per_rad
    rod_m = 1e-3 * smoother.smooth(record.position_mm) / (1.0 + adjusted(actuator)["encoder.rod_gain_error"])
    acceleration = np.gradient(np.gradient(rod_m, record.period_s), record.period_s)
    return np.asarray(mass_kg * lead_m * (acceleration - lead_m * motion.acceleration_rad_s2))


def _speed_noise_rad_s(actuator: Actuator, record: Record, smoother: Smoother) -> float:
    """Standard deviation that the position's white noise leaves on the smoothed speed."""
    return noise_of(motor_position(actuator, record)) / actuator.lead_mm_per_rad * _gain_of_noise(smoother, 1)


def _gain_of_noise(smoother: Smoother, derivatives: int) -> float:
    """What smoothing and differences make of white noise of unit standard deviation: the norm of their impulse response."""
    impulse = np.zeros(2 * round(10.0 / (smoother.cutoff_hz * smoother.period_s)) + 1)
    impulse[impulse.size // 2] = 1.0
    response = smoother.smooth(impulse)
    for _ in range(derivatives):
        response = np.gradient(response, smoother.period_s)
    if derivatives == 2 and smoother.every > 1:
        response = signal.sosfiltfilt(smoother.low_pass, response)
    return float(np.linalg.norm(response))


def quiet_smoother(actuator: Actuator, record: Record) -> Smoother:
    """The usual filter, or a lower one while sensor noise in the inertia torque exceeds its allowed share of the drive torque."""
    values = adjusted(actuator)
    drive = values["motor.torque_constant_Nm_per_A"] * drive_current(actuator, record)
    noise_Nm = values["screw.inertia_kgm2"] * noise_of(motor_position(actuator, record)) / actuator.lead_mm_per_rad
    smoother = Smoother.of(record.period_s)
    allowed = NOISE_SHARE * float(np.std(drive))
    while noise_Nm * _gain_of_noise(smoother, 2) > allowed and smoother.cutoff_hz > CUTOFF_MIN_HZ:
        smoother = Smoother(record.period_s, 0.5 * smoother.cutoff_hz)
    return smoother


def mechanical(actuator: Actuator, record: Record, smoother: Smoother | None = None) -> Balance:
    """Drive torque minus what the mechanics need, Nm at the motor shaft. At rest friction answers the torque up to its static level.

    Raises MissingSignal.
    """
    model = mechanical_model(actuator, record, smoother)
    values = adjusted(actuator)
    static = values["screw.csj_Nm"]
    parameters = np.array((values["screw.inertia_kgm2"], values["screw.viscous_Nm_s_per_rad"], 0.0, values["screw.load_torque_Nm"]))
    sliding = values["screw.dynamic_ratio"] * static * model.columns[:, 2] + model.added_Nm
    friction = np.where(model.resting, model.friction_at_rest_Nm(parameters, static), sliding)
    residual = model.drive_Nm - model.load_Nm - model.columns @ parameters - friction
    use = model.smoother
    return Balance(
        "mechanical",
        "Nm",
        use.kept(model.time_s),
        use.decimated(model.drive_Nm),
        use.decimated(residual),
        100.0 * float(np.mean(use.inner(model.resting))),
    )


@dataclass(frozen=True)
class Electrical:
    """The electrical balance as a linear model at the middles of the rows' intervals: voltage + known = columns @ (R, L, ke)."""

    voltage_V: Reals
    known_V: Reals
    columns: Reals
    time_s: Reals


def electrical_model(actuator: Actuator, record: Record) -> Electrical:
    """Voltage, what the effects add, and the columns current, its rate and speed.

    The voltage is held over a row's interval, so its sum over the interval is exact with the mean current and the differences of current and
    angle between the interval's ends. Raises MissingSignal.
    """
    if record.voltage_V is None:
        raise MissingSignal("voltage_V is not recorded")
    if actuator["drive.mode"] == 1.0:
        if actuator["drive.command_scale_V"] > 0.0:
            raise MissingSignal("voltage_V is the drive's command, not the motor's voltage")
        raise MissingSignal("the current drive changes the motor's voltage between rows")
    if record.current_A is None:
        raise MissingSignal("current_A is not recorded")
    if actuator["drive.current_limit_A"] > 0.0 and np.max(np.abs(record.current_A)) >= 0.999 * actuator["drive.current_limit_A"]:
        raise MissingSignal("the current limit is reached, where the drive takes voltage away")
    motor_rad = motor_position(actuator, record) / actuator.lead_mm_per_rad
    period = record.period_s
    current = 0.5 * (record.current_A[1:] + record.current_A[:-1])
    rate = np.diff(record.current_A) / period
    speed = np.diff(motor_rad) / period
    angle = 0.5 * (motor_rad[1:] + motor_rad[:-1])
    middle = Motion(current, speed, np.zeros_like(speed), angle, angle * actuator.lead_mm_per_rad)
    voltage = _mixed(record.voltage_V[:-1], *_split(adjusted(actuator)["drive.output_delay_s"] / period))
    known = _at_points(actuator, middle, "VOLTAGE", "voltage_change_V", voltage_V=voltage)
    ripple = _at_points(actuator, middle, "MOTOR", "motor_change")
    known -= adjusted(actuator)["motor.back_emf_V_s_per_rad"] * ripple * speed

    smoother = Smoother.of(period)

    def kept(values: Reals) -> Reals:
        return smoother.decimated(smoother.smooth(values))

    return Electrical(
        voltage_V=kept(voltage),
        known_V=kept(known),
        columns=np.column_stack([kept(current), kept(rate), kept(speed)]),
        time_s=smoother.kept(record.time_s[:-1] + 0.5 * period),
    )


def electrical(actuator: Actuator, record: Record) -> Balance:
    """Motor voltage minus what winding and back-EMF need, V. Raises MissingSignal."""
    model = electrical_model(actuator, record)
    values = adjusted(actuator)
    residual = model.voltage_V + model.known_V - model.columns @ np.array([values[name] for name in ELECTRICAL_PARAMETERS])
    return Balance("electrical", "V", model.time_s, model.voltage_V, residual)


def played(motor_mm: Reals, width_mm: float, start_mm: float) -> Reals:
    """Output of a play of full width `width_mm` that follows `motor_mm` [rows], from `start_mm`."""
    half = 0.5 * width_mm
    out = np.empty_like(motor_mm)
    position = start_mm
    for row, motor in enumerate(motor_mm.tolist()):
        position = min(max(position, motor - half), motor + half)
        out[row] = position
    return out


def kinematic(actuator: Actuator, record: Record) -> Balance:
    """Rod position minus the motor position behind the play, mm. Raises MissingSignal."""
    if record.motor_position_mm is None:
        raise MissingSignal("motor_position_mm is not recorded")
    transmission = _transmission(actuator)
    if transmission:
        raise MissingSignal(f"{transmission} moves the rod on its own; compare position_mm instead")
    values = adjusted(actuator)
    gain, offset = 1.0 + values["encoder.rod_gain_error"], values["encoder.rod_offset_mm"]
    rod = played(record.motor_position_mm, values["screw.blk_mm"], (float(record.position_mm[0]) - offset) / gain)
    inner = Smoother.of(record.period_s).inner
    return Balance(
        "kinematic",
        "mm",
        inner(record.time_s),
        inner(record.position_mm),
        inner(record.position_mm - (gain * rod + offset + _learned_reading_mm(actuator, rod))),
    )


def feedback_of(actuator: Actuator, record: Record) -> Reals:
    """The position that the loop is closed on, as recorded, mm [rows]. Raises MissingSignal."""
    if actuator["encoder.side"] == 1.0:
        return record.position_mm
    if record.motor_position_mm is not None:
        return record.motor_position_mm
    raise MissingSignal("motor_position_mm is not recorded, and the loop is closed on the motor encoder")


def controller_output(values: Mapping[str, float], command_mm: Reals, feedback_mm: Reals) -> Reals:
    """Normalised output of the control law for measured command and feedback, both [rows], one row per record period.

    Raises MissingSignal when the control law runs between the rows.
    """
    from ema_tools.reference import encoder, pid
    from ema_tools.reference.actuator import build, plain
    from ema_tools.reference.compiled import interpreted

    part = build(values)
    row_steps = part.timing.record_every_steps
    if part.control.every_steps % row_steps:
        raise MissingSignal("the control law runs between the recorded rows")
    if row_steps > 1 and part.encoder.delay_s > 0.0:
        raise MissingSignal("the feedback's delay needs a row at every model step")
    every_rows = part.control.every_steps // row_steps
    period_s = part.control.every_steps * part.timing.step_s
    history = feedback_mm.tolist()
    law, sensor, step_s = plain(part.control), plain(part.encoder), float(part.timing.step_s)
    run, seen_mm = interpreted(pid.run), interpreted(encoder.feedback_mm)
    state = interpreted(pid.at_rest)()
    out = np.empty(len(history))
    for row, command in enumerate(command_mm.tolist()):
        if row % every_rows == 0:
            state = run(law, period_s, 1e-3 * command, 1e-3 * seen_mm(sensor, step_s, history, row), state)
        out[row] = state.output
    return out


def controller(actuator: Actuator, record: Record) -> Balance:
    """Applied command minus the control law of measured command and feedback, in V. Raises MissingSignal."""
    if record.voltage_V is None:
        raise MissingSignal("voltage_V is not recorded")
    values = adjusted(actuator)
    if actuator["drive.mode"] == 1.0:
        scale = values["drive.command_scale_V"]
        if not scale > 0.0:
            raise MissingSignal("the drive's command is not recorded, only the motor's voltage")
    else:
        scale = values["drive.supply_V"]
    output = controller_output(values, record.command_mm, feedback_of(actuator, record))
    inner = Smoother.of(record.period_s).inner
    return Balance("controller", "V", inner(record.time_s), inner(record.voltage_V), inner(record.voltage_V - scale * output))


_OTHERS: dict[str, Callable[[Actuator, Record], Balance]] = {"electrical": electrical, "kinematic": kinematic, "controller": controller}


def filter_of(actuator: Actuator, record: Record) -> Smoother:
    """The filter of a record's mechanical balance; the usual one where there is no such balance."""
    try:
        return quiet_smoother(actuator, record)
    except MissingSignal:
        return Smoother.of(record.period_s)


def all_balances(actuator: Actuator, record: Record, smoother: Smoother | None = None) -> dict[str, Balance | str]:
    """Every balance by name: a `Balance`, or in one sentence why it cannot be had. `smoother` is the mechanical one's, to compare like with like."""
    use = smoother or filter_of(actuator, record)
    found: dict[str, Balance | str] = {}
    for name in BALANCES:
        try:
            found[name] = mechanical(actuator, record, use) if name == "mechanical" else _OTHERS[name](actuator, record)
        except MissingSignal as missing:
            found[name] = str(missing)
    return found
