"""The mechanical balance: kt i - (J dw/dt + D w + F sgn w + load).

While the shaft rests, friction is taken as whatever balances the torque, up to its static level. On the record of a real ball-screw axis this reproduces the published force
error: A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, 2019.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ema_tools.balances.balance import Balance
from ema_tools.balances.effects import acts, adjusted, transmission_of
from ema_tools.balances.filtering import Smoother, gain_of_noise
from ema_tools.balances.motion import Motion, at_points, current_of, motion_of, noise_of_motion, raw_speed, train_of, warmth
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import MissingSignal
from ema_tools.base.lag import lagged, remembered
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord
from ema_tools.data.motion_signals import disturbance_torque, motor_angle
from ema_tools.library.registry import record_of
from ema_tools.plant.native import library

MECHANICAL_PARAMETERS = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", "screw.csj_Nm", "screw.load_torque_Nm")
SLOW_SHARE = 0.01  # the shaft rests where it stays below this share of its largest speed ... [judgement]
_OF_STEADY = 0.5  # of one speed, which the mean of a record is at least this share of, noise hides no more than as much [judgement]
REST_S = 0.01  # ... for at least this time: a reversal is shorter [judgement]
_REST_ROWS = 3  # ... and so many rows of a slow record: a reversal passes within one [judgement]
_REACH = 1.0  # periods of the cutoff over which the filter carries a step [precision]
_LOW_HZ = 25.0  # a cutoff up to which starts and stops of usual drives last less than the filter [judgement]
_QUIET = 0.03  # of the largest speed, that the rows' own noise may be where they tell a rest [judgement]
NOISE_SHARE = 0.02  # largest noise of the inertia torque over the drive torque, by which the filter is chosen [judgement]
_STARTS = 24  # places in one wave at which a record may begin that are tried, before the best is refined [effort]
_WAVES_MAX = 10.0  # of the fastest wave in one of the slowest, that are tried [effort]
_START_RAD = 0.01  # to which the best of them is refined [precision]
CUTOFF_MIN_HZ = 12.5  # the lowest filter, three octaves below the highest: a lower one takes the motion itself away [judgement]


Sliding = tuple[NDArray[np.bool_], Reals]


@dataclass(frozen=True)
class Mechanical:
    """The mechanical balance as a linear model on smoothed rows, all [rows] or [rows, 4].

    drive = load + added + columns @ parameters; columns: acceleration (inertia), speed (viscous), contact (level of sliding friction),
    one (load against extension). `contact` is the direction of sliding, or what of friction a stretched contact carries; in its column the asymmetry of the level is in it.
    `load` and `added` are what effects and efficiency add, the latter while sliding; `static_extra` is what they add to the static level backward and forward, where the shaft rests;
    `eased`: relative change of dry and viscous friction by temperature. `still`: rows of lasting rest; `elastic`: whether the contact stretches.
    `lag_s`: time constant by which the drive was recorded late, which all that it is held against has as well. `slides`: rows of lasting rest in the motion itself, and its direction.
    """

    smoother: Smoother
    drive_Nm: Reals
    load_Nm: Reals
    added_Nm: Reals
    static_extra_Nm: tuple[Reals, Reals]
    contact: Reals
    eased: Reals
    asymmetry: float
    columns: Reals
    time_s: Reals
    still: NDArray[np.bool_]
    elastic: bool
    slides: Sliding
    lag_s: float = 0.0

    @property
    def resting(self) -> NDArray[np.bool_]:
        """Rows at which friction is whatever balances the torque, [rows]: none where the contact stretches."""
        return np.zeros_like(self.still) if self.elastic else self.still

    def at_rest_Nm(self, parameters: Reals, static_Nm: float) -> tuple[Reals, Reals, Reals]:
        """The torque that friction has to balance, and the most that it balances backward and forward, on every row; true where the shaft rests. `parameters` [4] of the columns."""
        net = self.drive_Nm - self.load_Nm - self.columns @ (parameters * (1.0, 1.0, 0.0, 1.0))
        backward, forward = self.static_extra_Nm
        return net, (1.0 - self.asymmetry) * static_Nm + backward, (1.0 + self.asymmetry) * static_Nm + forward

    def friction_at_rest_Nm(self, parameters: Reals, static_Nm: float) -> Reals:
        """What balances the torque, up to the static level, as `at_rest_Nm` has both."""
        net, backward, forward = self.at_rest_Nm(parameters, static_Nm)
        return np.clip(net, -backward, forward)


def _contact(actuator: Actuator, motion: Motion, direction: Reals) -> tuple[Reals, bool]:
    """Share of the level of dry friction that acts against extension, [rows], -1 to 1, and whether the contact stretches, so that the shaft never rests."""
    if acts(actuator, "PRESLIDING"):
        return library().contact(*actuator.arrays(), motion.angle_rad), True
    return direction, False


def _resting(speed_rad_s: Reals, noise_rad_s: float, smoother: Smoother) -> NDArray[np.bool_]:
    """Rows of lasting rest, where friction may have any value up to its level. A reversal that only passes zero is none."""
    inner = slice(smoother.edge_rows, -smoother.edge_rows)
    fastest = float(np.max(np.abs(speed_rad_s[inner]), initial=0.0))
    # a record of one slow speed moves, however coarsely it was read
    steady = float(abs(np.mean(speed_rad_s[inner]))) if fastest > 0.0 else 0.0
    hidden = min(3.0 * noise_rad_s, _OF_STEADY * steady) if steady > _OF_STEADY * fastest else 3.0 * noise_rad_s
    slow = np.abs(speed_rad_s) <= max(SLOW_SHARE * fastest, hidden)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], slow.astype(np.int8), [0]))))
    resting = np.zeros(slow.size, dtype=bool)
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if (last - first) * smoother.period_s >= max(REST_S, _REST_ROWS * smoother.period_s):
            resting[first:last] = True
    return resting


def _sliding(actuator: Actuator, record: AnyRecord, motion: Motion, smoother: Smoother) -> Sliding:
    """Rows of lasting rest, and the direction of sliding. Of a slow record the filter begins a motion before it begins and rings behind every stop: there the rows themselves tell, where their
    noise hides no motion, and a rest reaches as far into the motion as the filter does."""
    smooth = _resting(motion.speed_rad_s, _speed_noise_rad_s(actuator, record, smoother), smoother)
    if smoother.cutoff_hz > _LOW_HZ:
        return smooth, np.sign(motion.speed_rad_s)
    speed = raw_speed(actuator, record, motion)
    noise, derivatives = noise_of_motion(actuator, record)
    of_speed = noise if derivatives else noise / (math.sqrt(2.0) * record.period_s)
    if of_speed > _QUIET * float(np.max(np.abs(motion.speed_rad_s))):
        return smooth, np.sign(motion.speed_rad_s)
    # a tenth of a second to load, for slow records alone
    from scipy import ndimage

    rows = _resting(speed, of_speed, smoother)
    reach = round(_REACH / (smoother.cutoff_hz * smoother.period_s))
    return np.asarray(ndimage.binary_dilation(rows, iterations=reach)) if rows.any() else rows, np.where(rows, 0.0, np.sign(speed))


def mechanical_model(
    actuator: Actuator,
    record: AnyRecord,
    smoother: Smoother | None = None,
    motion: Motion | None = None,
    slides: Sliding | None = None,
) -> Mechanical:
    """Drive torque, what the effects add, and the columns of the base parameters; `motion`: of the record, and where it slides, where they are known already. Raises MissingSignal."""
    values = adjusted(actuator)
    use = smoother or quiet_smoother(actuator, record)
    motion = motion or motion_of(actuator, record, use)
    ripple = at_points(actuator, motion, "MOTOR")
    drive = values["motor.torque_constant_Nm_per_A"] * (1.0 + ripple) * motion.current_A
    if values["motor.torque_limit_Nm"] > 0.0:
        drive = np.clip(drive, -values["motor.torque_limit_Nm"], values["motor.torque_limit_Nm"])
    lag_s = actuator.drive_lag_s or 0.0
    # a motion that is late is held against a drive as late
    drive = lagged(drive, record.period_s, -lag_s)
    slides = slides or _sliding(actuator, record, motion, use)
    rests, direction = slides
    contact, elastic = _contact(actuator, motion, direction)
    asymmetry = values["screw.friction_asymmetry"]
    load = at_points(actuator, motion, "LOAD")
    passed = load + values["screw.load_torque_Nm"]
    still = replace(motion, speed_rad_s=np.zeros_like(contact))
    torque = at_points(actuator, motion, "TORQUE")
    eased = warmth(actuator, motion.current_A, "GREASE", record.period_s)
    torque -= eased * values["screw.viscous_Nm_s_per_rad"] * motion.speed_rad_s

    def added(level: float, side: float, seen: Motion, rows: NDArray[np.bool_]) -> Reals:
        """What effects and efficiency add to a level of friction to one side; holds on `rows`."""
        passing = np.where(passed * side > 0.0, 1.0 / values["gearbox.efficiency"] - 1.0, 1.0 - values["gearbox.efficiency"]) * np.abs(
            passed
        )
        own = level * (1.0 + side * asymmetry)
        return passing + eased * own + at_points(actuator, seen, "FRICTION", level_Nm=own, rows=rows, side=side)

    sliding, static = values["screw.dynamic_ratio"] * values["screw.csj_Nm"], values["screw.csj_Nm"]
    at_rest = remembered(rests, record.period_s, lag_s)

    def late(values: Reals) -> Reals:
        return lagged(values, record.period_s, lag_s)

    resting = np.zeros_like(at_rest) if elastic else at_rest
    backward = contact < 0.0
    extra = np.where(backward, added(sliding, -1.0, motion, backward), added(sliding, 1.0, motion, ~backward))
    level = use.as_seen(contact * (1.0 + asymmetry * np.sign(contact)))
    return Mechanical(
        smoother=use,
        drive_Nm=drive,
        load_Nm=late(use.as_seen(load - torque + _soft_mass_Nm(actuator, record, motion, use)) + known_torque_Nm(actuator, record, use)),
        added_Nm=late(use.as_seen(extra * contact)),
        static_extra_Nm=(added(static, -1.0, still, resting), added(static, 1.0, still, resting)),
        contact=contact,
        eased=eased,
        asymmetry=asymmetry,
        columns=late(np.column_stack([motion.acceleration_rad_s2, motion.speed_rad_s, level, np.ones_like(contact)])),
        time_s=record.time_s,
        still=at_rest,
        elastic=elastic,
        slides=slides,
        lag_s=lag_s,
    )


def _soft_mass_Nm(actuator: Actuator, record: AnyRecord, motion: Motion, smoother: Smoother) -> Reals:
    """What a mass behind a soft transmission takes more than one that is rigidly coupled, as torque against extension, [rows]."""
    transmission = transmission_of(actuator)
    if not transmission:
        return np.zeros(record.rows)
    if record.position_mm is None:
        raise MissingSignal(f"position_mm is not recorded, and the rod follows the motor with {transmission}")
    mass_kg, lead_m = actuator[f"{transmission}.mass_kg"], 1e-3 * actuator.lead_mm_per_rad
    rod_m = 1e-3 * smoother.smooth(record.position_mm) / (1.0 + adjusted(actuator)["encoder.rod_gain_error"])
    acceleration = np.gradient(np.gradient(rod_m, record.period_s), record.period_s)
    return np.asarray(mass_kg * lead_m * (acceleration - lead_m * motion.acceleration_rad_s2))


def _speed_noise_rad_s(actuator: Actuator, record: AnyRecord, smoother: Smoother) -> float:
    """Standard deviation that the motion's white noise leaves on the smoothed speed."""
    noise, derivatives = noise_of_motion(actuator, record)
    return noise * gain_of_noise(smoother, 1 - derivatives)


def known_torque_Nm(actuator: Actuator, record: AnyRecord, smoother: Smoother) -> Reals:
    """Known torque against extension, smoothed, [rows]."""
    if not isinstance(record, MotionRecord) or (record.disturbance_Nm is None and record.disturbance_N is None):
        return np.zeros(record.rows)
    return smoother.smooth(disturbance_torque(record, train_of(actuator)))


def quiet_smoother(actuator: Actuator, record: AnyRecord) -> Smoother:
    """The usual filter, or a lower one while sensor noise in the inertia torque exceeds its allowed share of the drive torque."""
    values = adjusted(actuator)
    drive = values["motor.torque_constant_Nm_per_A"] * current_of(actuator, record)
    noise, derivatives = noise_of_motion(actuator, record)
    noise_Nm = values["screw.inertia_kgm2"] * noise
    smoother = Smoother.of(record.period_s)
    allowed = NOISE_SHARE * float(np.std(drive))
    while noise_Nm * gain_of_noise(smoother, 2 - derivatives) > allowed and smoother.cutoff_hz > CUTOFF_MIN_HZ:
        smoother = Smoother(record.period_s, 0.5 * smoother.cutoff_hz)
    return smoother


def filter_of(actuator: Actuator, record: AnyRecord) -> Smoother:
    """The filter of a record's mechanical balance; the usual one where there is no such balance."""
    try:
        return quiet_smoother(actuator, record)
    except MissingSignal:
        return Smoother.of(record.period_s)


def mechanical(actuator: Actuator, record: AnyRecord, smoother: Smoother | None = None) -> Balance:
    """Drive torque minus what the mechanics need, Nm at the motor shaft. At rest friction answers the torque up to its static level.

    Of a record that does not say where it begins, the place at which a wave of the model fits it best is taken. Raises MissingSignal.
    """
    return _mechanical(actuator, best_placed(actuator, record, smoother), smoother)


def best_placed(actuator: Actuator, record: AnyRecord, smoother: Smoother | None = None) -> AnyRecord:
    """A record that tells how the machine moves and not where it is, begun where the model's waves fit it best; any other as it is. Raises MissingSignal."""
    waves = [_periods(actuator, name) for name in actuator.active_effects if record_of(name).periodic is not None]
    if not (waves and isinstance(record, MotionRecord) and motor_angle(record, train_of(actuator)).origin == "integrated"):
        return record
    from scipy.optimize import minimize_scalar

    use = smoother or quiet_smoother(actuator, record)
    moves = motion_of(actuator, replace(record, start_rad=0.0), use)

    def square(start_rad: float) -> float:
        there = replace(record, start_rad=start_rad)
        return float(np.sum(_mechanical(actuator, there, use, moves.begun_at(actuator, start_rad)).residual ** 2))

    step = 2.0 * math.pi / (_STARTS * max(waves))
    starts = [step * place for place in range(math.ceil(_STARTS * min(max(waves) / min(waves), _WAVES_MAX)))]
    best = min(starts, key=square)
    found = minimize_scalar(square, bounds=(best - step, best + step), method="bounded", options={"xatol": _START_RAD})
    return replace(record, start_rad=float(found.x) if found.fun < square(best) else best)


def _periods(actuator: Actuator, effect: str) -> float:
    """Of a wave per turn of the motor; of one that the list gives no number, once per turn of the screw."""
    return actuator.values.get(f"{effect}.periods", 1.0 / max(actuator.values["gearbox.ratio"], 1.0))


def _mechanical(actuator: Actuator, record: AnyRecord, smoother: Smoother | None, motion: Motion | None = None) -> Balance:
    """The balance of a record as it is."""
    model = mechanical_model(actuator, record, smoother, motion)
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
