"""Base parameters from healthy records: what `ema calibrate` does.

First the balances, linear in the parameters: inertia, viscous damping, dry friction and load from the mechanical one, resistance, inductance and
back-EMF from the electrical one, the play from the kinematic one; the torque constant is kept, since with it all of them would only be known as
ratios. Then the whole loop is simulated by the C module and every recorded channel is fitted: that needs no derivative of a measured signal, which
sensor noise biases, but it trusts every block of the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.electrical import ELECTRICAL_PARAMETERS, electrical_model
from ema_tools.balances.kinematic import kinematic
from ema_tools.balances.mechanical import MECHANICAL_PARAMETERS, Mechanical, mechanical_model
from ema_tools.base import leastsquares
from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, MissingSignal
from ema_tools.base.noise import white_noise
from ema_tools.base.parallel import each
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.linear_axis import VALUES, ForceModel, at_rod, lead_m_per_rad
from ema_tools.data.records import Record, simulated
from ema_tools.fit import bounded
from ema_tools.fit.bounded import Found, FreeValue, Stop, TwoSided
from ema_tools.plant.native import CHANNELS, Simulation
from ema_tools.select.healthy_records import check_alike
from ema_tools.tasks.onboard_search import BOUNDS

PLAY = "screw.blk_mm"
FRICTION = "screw.csj_Nm"
SUPPLY = "drive.supply_V"
_REST_ROUNDS = 20  # friction at rest and the parameters settle together, within few of these [effort]
_WEIGHING_ROUNDS = 3  # fits in which each channel weighs by what the last one left of it [effort]
_STEPS = 30  # of one fit: far more than it takes [effort]
_STEP = 1e-3  # of a parameter, for a central difference; the model is not smooth in the small [precision]
_STEP_LEAST = 0.1  # a parameter that has become small is moved as one of this share of its first size [precision]
_AT_BOUND = 1e-6  # of its first size: so near to an end of its range a parameter lies on it [precision]
_SHRINK = 1e-9  # relative: parameters that move less have settled [precision]
_AT_BOUND_MM = 1e-6  # the search for the play comes this near to a bound, and not onto it [precision]
# What makes the time constants: a fit that the records do not hold drives them to where the model cannot be stepped.
_TIME_CONSTANTS = ("screw.inertia_kgm2", "screw.viscous_Nm_s_per_rad", *ELECTRICAL_PARAMETERS)
# No channel is trusted to a smaller share of its size than this: the model's own arithmetic and steps are not better [precision]
_TRUST = 1e-4

# A calibrated model follows its records: of a position it leaves no more than this share of the motion. A healthy machine stays far below,
# a record of another machine or command, or a bad signal, far above [judgement]
_REST_OF_MOTION = 0.05
_REST_IN_NOISE = 10.0  # or so many times the sensor noise, where that is more [judgement]
_REST_OF_DRIVE = 0.5  # the same share of current and voltage, whose noise is larger [judgement]

# Share by which the loop's fit must lower the errors to be preferred to the balances', which depend on fewer blocks [judgement]
_LOOP_GAIN = 0.02
# What no grease, wear or weather changes: a data sheet has it right to some per cent, and a file with a wrong lead makes it wrong by the lead's square [physics]
_CONSTANTS = ("screw.inertia_kgm2", "motor.resistance_ohm", "motor.back_emf_V_s_per_rad", "motor.torque_constant_Nm_per_A")
_FAR = 2.0  # times [judgement]


@dataclass(frozen=True)
class FittedParameter:
    """One calibrated value in its unit: before, after, its standard error, and what gave it: `balance`, `loop`, or the onboard module's own `search`."""

    name: str
    before: float
    after: float
    std: float
    source: Literal["balance", "loop", "search"]
    at_bound: bool


@dataclass(frozen=True)
class Calibration:
    """The calibrated actuator, its parameters, rms errors per channel before and after, the noise of the sensors there, and what could not be calibrated and why."""

    actuator: Actuator
    parameters: tuple[FittedParameter, ...]
    errors_before: dict[str, float]
    errors_after: dict[str, float]
    noise: dict[str, float]
    left_out: dict[str, str]

    def far(self) -> dict[str, float]:
        """Constants of the machine that are many times what its file said, or a small part of it, and how many times: then other numbers of the file may be another machine's."""
        times = {one.name: one.after / one.before for one in self.parameters if one.name in _CONSTANTS and one.before > 0.0 < one.after}
        return {name: value for name, value in times.items() if not 1.0 / _FAR < value < _FAR}

    def at_rod(self) -> dict[str, ForceModel]:
        """The mechanics as a force model at the rod: `before`, `after`, `std`; empty when they were not calibrated."""
        found = {parameter.name: parameter for parameter in self.parameters}
        if not set(VALUES) <= set(found):
            return {}
        lead = lead_m_per_rad(self.actuator)
        return {title: at_rod({name: getattr(found[name], title) for name in VALUES}, lead) for title in ("before", "after", "std")}


def channel_errors(actuator: Actuator, records: Sequence[Record]) -> dict[str, float]:
    """Rms of measured minus simulated over all records, by channel, in the channel's unit."""
    squares: dict[str, list[Reals]] = {}
    for record, simulation in zip(records, each(lambda record: simulated(actuator, record), records), strict=True):
        for name in CHANNELS:
            measured = record.channel(name)
            if measured is not None:
                squares.setdefault(name, []).append((measured - getattr(simulation, name)) ** 2)
    return {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()}


def range_of(actuator: Actuator, name: str) -> tuple[float, float]:
    """Where a value may lie: its own range, and for CSJ and BLK the bounds in which `ema identify` will look for it. Raises InputError when nothing is left."""
    row = row_of(name)
    if name not in BOUNDS:
        return row.lower, row.upper
    low, high = BOUNDS[name]
    lower, upper = max(row.lower, actuator[low]), min(row.upper, actuator[high])
    if not lower < upper:
        raise InputError(f"{actuator.file}: {low} = {actuator[low]:g}: not below {high} = {actuator[high]:g}: correct the bounds")
    return lower, upper


def _simulated(fitted: Actuator, given: Actuator, record: Record) -> Simulation:
    """A run of what a fit came to. Raises InputError that names the value which the record does not determine: that of a time constant which went furthest from what was `given`."""
    try:
        return simulated(fitted, record)
    except InputError:

        def went(name: str) -> float:
            before, after = max(abs(given[name]), 1e-300), max(abs(fitted[name]), 1e-300)
            return abs(float(np.log(after / before)))

        raise _undetermined(max(_TIME_CONSTANTS, key=went)) from None


def _undetermined(name: str) -> InputError:
    """What to do about a value that the records do not determine."""
    return InputError(
        f"calibrate: {name}: the records do not determine it: check it and screw.lead_mm in the file, record another command, or fit the others alone (--fit)"
    )


def check_followed(actuator: Actuator, records: Sequence[Record]) -> None:
    """Raises InputError that names record and channel when the calibrated actuator does not follow what was recorded."""
    noise_mm = actuator["verdict.position_noise_mm"]
    for record in records:
        for name, rms in channel_errors(actuator, [record]).items():
            measured = record.recorded(name)
            if name in ("position_mm", "motor_position_mm"):
                size = float(np.std(measured))
                limit = max(_REST_OF_MOTION * size, _REST_IN_NOISE * noise_mm)
            else:
                size = float(np.sqrt(np.mean(measured**2)))
                limit = _REST_OF_DRIVE * size
            if not rms <= limit:
                unit = name.removeprefix("motor_").partition("_")[2]
                raise InputError(
                    f"{record.file}: {name}: the calibrated model misses it by {rms:.3g} {unit} rms where at most {limit:.3g} {unit} is credible: "
                    "check that command, signals, units and signs are those of this healthy actuator, then calibrate again"
                )


def _base_of(actuator: Actuator, name: str, effective: float) -> tuple[float, float]:
    """The value whose effective one, with the enabled PARAMETER effects, is `effective`, and its slope: such effects are linear."""
    step = max(abs(actuator[name]), 1e-6)
    here = adjusted(actuator)[name]
    slope = (adjusted(actuator.changed({name: actuator[name] + step}))[name] - here) / step
    return actuator[name] + (effective - here) / slope, 1.0 / slope


def _taken(
    actuator: Actuator, fitted: leastsquares.LinearFit, names: Sequence[str], scale: Sequence[float]
) -> tuple[Actuator, list[FittedParameter]]:
    """The actuator with the fitted effective values times `scale`, held inside their ranges."""
    found = []
    changes = {}
    for name, effective, std, factor in zip(names, fitted.parameters, fitted.std, scale, strict=True):
        base, slope = _base_of(actuator, name, float(effective) * factor)
        lower, upper = range_of(actuator, name)
        held = min(max(base, lower), upper)
        found.append(FittedParameter(name, actuator[name], held, abs(slope) * float(std) * factor, "balance", held != base))
        changes[name] = held
    return actuator.changed(changes), found


def from_mechanics(actuator: Actuator, records: Sequence[Record]) -> tuple[Actuator, list[FittedParameter]]:
    """Inertia, viscous damping, dry friction and load from the mechanical balance. Raises MissingSignal and InputError."""
    models = [mechanical_model(actuator, record) for record in records]
    values = adjusted(actuator)
    start = [values[name] for name in MECHANICAL_PARAMETERS]
    ratio = values["screw.dynamic_ratio"]
    if not ratio > 0.0:
        raise MissingSignal("screw.dynamic_ratio is zero: sliding friction says nothing about CSJ")
    parameters = np.array([start[0], start[1], start[2] * ratio, start[3]])
    for _ in range(_REST_ROUNDS):
        pairs = [_with_rest(model, parameters, ratio) for model in models]
        fitted = leastsquares.fit([target for target, _ in pairs], [columns for _, columns in pairs], MECHANICAL_PARAMETERS)
        moved = np.abs(fitted.parameters - parameters) > _SHRINK * np.abs(fitted.parameters)
        parameters = fitted.parameters
        if not moved.any():
            break
    return _taken(actuator, fitted, MECHANICAL_PARAMETERS, (1.0, 1.0, 1.0 / ratio, 1.0))


def _with_rest(model: Mechanical, parameters: Reals, ratio: float) -> tuple[Reals, Reals]:
    """Target and columns in which friction at rest is what the present parameters say: whatever balances the torque, up to the static level."""
    friction = np.where(model.resting, model.friction_at_rest_Nm(parameters, abs(float(parameters[2])) / ratio), model.added_Nm)
    columns = model.columns.copy()
    columns[model.resting, 2] = 0.0
    use = model.smoother
    return use.decimated(model.drive_Nm - model.load_Nm - friction), np.column_stack([use.decimated(column) for column in columns.T])


def from_electrics(actuator: Actuator, records: Sequence[Record]) -> tuple[Actuator, list[FittedParameter]]:
    """Resistance, inductance and back-EMF constant from the electrical balance. Raises MissingSignal and InputError."""
    models = [electrical_model(actuator, record) for record in records]
    fitted = leastsquares.fit(
        [model.voltage_V + model.known_V for model in models], [model.columns for model in models], ELECTRICAL_PARAMETERS
    )
    return _taken(actuator, fitted, ELECTRICAL_PARAMETERS, (1.0, 1.0, 1.0))


def from_kinematics(actuator: Actuator, records: Sequence[Record]) -> tuple[Actuator, list[FittedParameter]]:
    """The play from rod and motor position. Raises MissingSignal."""
    from scipy.optimize import minimize_scalar

    def residuals(width_mm: float) -> list[Reals]:
        return [kinematic(actuator.changed({PLAY: width_mm}), record).residual for record in records]

    def cost(width_mm: float) -> float:
        return float(sum(residual @ residual for residual in residuals(width_mm)))

    lower, upper = range_of(actuator, PLAY)
    gaps = [record.position_mm - record.motor_position_mm for record in records if record.motor_position_mm is not None]
    if len(gaps) < len(records):
        raise MissingSignal("motor_position_mm is not recorded")
    # A play wider than twice the range of the gap between the two positions is not in the records.
    widest = 2.0 * max(float(np.ptp(gap)) for gap in gaps)
    found = float(
        minimize_scalar(cost, bounds=(lower, max(min(upper, widest), lower)), method="bounded", options={"xatol": 0.1 * _AT_BOUND_MM}).x
    )
    step = max(_STEP * found, 1e-6)
    slopes = [(high - low) / (2.0 * step) for high, low in zip(residuals(found + step), residuals(max(found - step, 0.0)), strict=True)]
    normal = sum(float(slope @ slope) for slope in slopes)
    scores = sum(
        float(leastsquares.long_run((slope * residual)[:, None])[0, 0]) for slope, residual in zip(slopes, residuals(found), strict=True)
    )
    std = np.sqrt(scores) / normal if normal > 0.0 else np.inf
    return actuator.changed({PLAY: found}), [
        FittedParameter(PLAY, actuator[PLAY], found, float(std), "balance", not lower + _AT_BOUND_MM < found < upper - _AT_BOUND_MM)
    ]


def free_parameters(actuator: Actuator, records: Sequence[Record]) -> tuple[str, ...]:
    """What the records can tell: the mechanics with current or voltage, the winding with both in voltage mode, the play with both positions.

    With the rod position alone, which a stiff loop makes nearly blind to the rest, CSJ and the play.
    """

    def has(name: str) -> bool:
        return all(record.channel(name) is not None for record in records)

    if not (has("current_A") or has("voltage_V")):
        return (FRICTION, PLAY) if actuator[PLAY] > 0.0 else (FRICTION,)
    names = list(MECHANICAL_PARAMETERS)
    if actuator["drive.mode"] == 0.0 and has("current_A") and has("voltage_V"):
        names += [name for name in ELECTRICAL_PARAMETERS if actuator[name] > 0.0]
    if has("motor_position_mm") and actuator[PLAY] > 0.0:
        names.append(PLAY)
    return tuple(names)


def _supply_shows(actuator: Actuator, records: Sequence[Record]) -> bool:
    """Whether the records can tell the supply: in voltage mode, from what the controller asked for."""
    return actuator["drive.mode"] == 0.0 and all(record.channel("voltage_V") is not None for record in records)


def _unknown(actuator: Actuator, name: str) -> FreeValue:
    """A parameter in units of its own size; one that may be zero is measured by what it competes with: load by friction."""
    lower, upper = range_of(actuator, name)
    size = abs(actuator[name]) or max(actuator[FRICTION], 1e-6)
    return FreeValue(name, actuator[name], size, lower, upper, _AT_BOUND * size)


def _errors(actuator: Actuator, given: Actuator, record: Record) -> Reals:
    """Measured minus simulated, [rows, channels]."""
    simulation = _simulated(actuator, given, record)
    return np.column_stack([record.recorded(name) - getattr(simulation, name) for name in CHANNELS if name in record.present])


def _weights(errors: Reals, record: Record) -> Reals:
    """One over the rms error of each channel, [channels], or over the smallest that is believed."""
    sizes = [float(np.sqrt(np.mean(values**2))) for name in CHANNELS if (values := record.channel(name)) is not None]
    return np.asarray(1.0 / np.maximum(np.sqrt(np.mean(errors**2, axis=0)), np.maximum(_TRUST * np.array(sizes), 1e-12)))


def in_the_loop(
    actuator: Actuator, records: Sequence[Record], names: Sequence[str], given: Actuator, report: Report | None = None
) -> tuple[Actuator, list[FittedParameter]]:
    """Fit `names` so that the simulated loop follows every recorded channel, each weighted by its own rms error; `given`: the actuator before any fit.

    Raises InputError when the records do not determine a parameter.
    """
    unknowns = [_unknown(actuator, name) for name in names]

    def errors(values: Mapping[str, float]) -> list[Reals]:
        machine = actuator.changed(values)
        return each(lambda record: _errors(machine, given, record), records)

    here = errors({one.name: one.held(one.start) for one in unknowns})
    taken = 0
    for turn in range(_WEIGHING_ROUNDS):
        weights = [_weights(error, record) for error, record in zip(here, records, strict=True)]

        def weighted(values: Mapping[str, float], weights: list[Reals] = weights) -> Reals:
            return np.concatenate([(error * weight).ravel() for error, weight in zip(errors(values), weights, strict=True)])

        def told(turn: int = turn) -> None:
            nonlocal taken
            taken += 1
            if report is not None:
                report(turn, f"round {turn + 1} of {_WEIGHING_ROUNDS}, step {taken}")

        found = bounded.fit(unknowns, weighted, TwoSided(_STEP, _STEP_LEAST), Stop(_STEPS, 1e-10, 1e-12, 1e-12), told=told)
        unknowns = [replace(one, start=found.values[one.name]) for one in unknowns]
        here = [part / weight for part, weight in zip(_parts(found.residual, here), weights, strict=True)]
    std = np.sqrt(np.diag(_loop_covariance(found, here)))
    return actuator.changed(found.values), [
        FittedParameter(name, actuator[name], after, float(error), "loop", name in found.at_bound)
        for (name, after), error in zip(found.values.items(), std, strict=True)
    ]


def _parts(tall: Reals, errors: Sequence[Reals]) -> list[Reals]:
    """Each record's share of a vector [n] or of columns [n, p], as [rows, channels] or [rows, channels, p]."""
    ends = np.cumsum([error.size for error in errors])[:-1]
    return [part.reshape(*error.shape, *tall.shape[1:]) for part, error in zip(np.split(tall, ends), errors, strict=True)]


def _loop_covariance(found: Found, errors: Sequence[Reals]) -> Reals:
    """Covariance of the values with correlated residuals, in their units [p, p]; `errors` of each record, for their shapes."""
    # in scales, not units: the lags that count are chosen for all unknowns together
    normal = np.zeros((found.scale.size, found.scale.size))
    scores = np.zeros_like(normal)
    for slopes, residual in zip(_parts(found.slopes, errors), _parts(found.residual, errors), strict=True):
        normal += np.einsum("rcp,rcq->pq", slopes, slopes)
        scores += leastsquares.long_run(np.einsum("rcp,rc->rp", slopes, residual))
    size = np.sqrt(np.diag(normal))
    if not np.all(size > 0.0) or np.linalg.cond(normal / np.outer(size, size)) > 1e12:
        worst = tuple(found.values)[int(np.argmin(size))]
        raise _undetermined(worst)
    inverse = np.linalg.inv(normal / np.outer(size, size)) / np.outer(size, size)
    return np.asarray(inverse @ scores @ inverse * np.outer(found.scale, found.scale))


def calibrate(
    actuator: Actuator,
    records: Sequence[Record],
    names: Sequence[str] | None = None,
    loop: bool | None = None,
    report: Report | None = None,
) -> Calibration:
    """Fit base parameters on healthy records; `names` restricts them. `loop`: whether to fit the simulated loop after the balances; None keeps that
    fit only where it follows the records clearly better, since the balances depend on fewer blocks.

    Raises InputError when a record is unlike the others of its command, when the records do not determine a parameter, and when the calibrated model does not follow them.
    """
    check_alike(actuator, records)
    before = channel_errors(actuator, records)
    free = tuple(row_of(name).name for name in names) if names is not None else free_parameters(actuator, records)
    found: dict[str, FittedParameter] = {}
    left_out: dict[str, str] = {}
    fitted = actuator
    for group, take in ((MECHANICAL_PARAMETERS, from_mechanics), (ELECTRICAL_PARAMETERS, from_electrics), ((PLAY,), from_kinematics)):
        if not set(group) <= set(free):
            continue
        try:
            fitted, parameters = take(fitted, records)
        except MissingSignal as missing:
            left_out[", ".join(group)] = str(missing)
        else:
            found |= {parameter.name: parameter for parameter in parameters}
    for record in records:
        _simulated(fitted, actuator, record)

    tries = [(free, loop is True or len(found) < len(free))] if loop is not False else []
    if tries and names is None and _supply_shows(actuator, records):
        # what the controller asks for is a share of the supply, so a wrong one makes every electrical value wrong, and the play with them
        tries.append(((*free, SUPPLY), False))
    refused: InputError | None = None
    for wanted, needed in tries:
        try:
            closer, parameters = in_the_loop(fitted, records, wanted, actuator, report)
        except InputError as error:
            # a loop whose model lacks something may lead nowhere, where the balances each stand by themselves
            if needed:
                raise
            refused = refused or error
            continue
        if needed or _gain(channel_errors(fitted, records), channel_errors(closer, records)) > _LOOP_GAIN:
            fitted, free = closer, wanted
            found |= {parameter.name: parameter for parameter in parameters}
    if not found:
        why = "; ".join(left_out.values()) or "a balance gives only all of its parameters"
        raise InputError(f"calibrate: nothing to fit without the closed loop ({why}): leave --balances-only out")
    try:
        check_followed(fitted, records)
    except InputError as error:
        raise refused or error from None
    parameters = [_begun(found[name], actuator) for name in free if name in found]
    after = channel_errors(fitted, records)
    noise = {name: max(white_noise(record.recorded(name)) for record in records if name in record.present) for name in after}
    return Calibration(fitted, tuple(parameters), before, after, noise, left_out)


def _gain(before: dict[str, float], after: dict[str, float]) -> float:
    """By which share the errors of the channels fell, in the geometric mean."""
    return 1.0 - float(np.exp(np.mean([np.log(max(after[name], 1e-300) / max(before[name], 1e-300)) for name in before])))


def _begun(parameter: FittedParameter, actuator: Actuator) -> FittedParameter:
    """The parameter with the value before any calibration."""
    return FittedParameter(parameter.name, actuator[parameter.name], parameter.after, parameter.std, parameter.source, parameter.at_bound)
