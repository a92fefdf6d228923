"""The result of `ema calibrate`."""

from __future__ import annotations

import math
from dataclasses import asdict

from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import row_of
from ema_tools.data.linear_axis import VALUES, at_rod, lead_m_per_rad
from ema_tools.results import calibration as result
from ema_tools.results.parts import ComparedErrors, Provenance
from ema_tools.tasks.calibrate import Calibration, FittedParameter
from ema_tools.tasks.calibrate_by_balance import BalanceCalibration
from ema_tools.tasks.own_machine import OwnMachine
from ema_tools.words.answers.addition import fitted_values


def calibration(found: Calibration, actuator: str, provenance: Provenance, own: OwnMachine | None = None) -> result.CalibrationResult:
    """What was found; `actuator` is the file that was written, `own` what the unit's runs show beside base values."""
    return result.CalibrationResult(
        command="calibrate",
        actuator=actuator,
        parameters={parameter.name: _calibrated(parameter) for parameter in found.parameters},
        at_rod={title: result.RodModel(**asdict(model)) for title, model in found.at_rod().items()},
        error=result.ChannelErrors(found.errors_before, found.errors_after, found.noise),
        left_out=found.left_out,
        far=found.far(),
        own_machine=None
        if own is None
        else result.OwnMachineEntry(
            own.records,
            dict(own.standing),
            dict(own.scatter_percent),
            dict(own.least_percent),
            dict(own.exceeded),
            dict(own.found_percent),
            own.doubt,
            dict(own.unseen_percent),
            own.per_degC_percent,
            own.per_degC_std_percent,
        ),
        provenance=provenance,
    )


def calibration_by_balance(found: BalanceCalibration, actuator: str, provenance: Provenance, because: str) -> result.CalibrationResult:
    """What was found by the balance of forces; `because`: why by this method."""
    forces, known = found.forces, found.known
    parameters = {}
    for name, one in fitted_values(forces).items():
        before = known[row_of(name).name]
        change = 100.0 * (one.value - before) / before if before else None
        parameters[name] = result.Calibrated(
            before, one.value, one.std, change, one.unit, "balance", one.at_bound, one.interval95 or (None, None)
        )
    return result.CalibrationResult(
        command="calibrate",
        actuator=actuator,
        parameters=parameters,
        at_rod=_at_rod(found),
        error=result.ChannelErrors({}, {}, {}),
        left_out={name: f"{why}: it stays {found.actuator[name]:.4g} {row_of(name).unit}" for name, why in forces.kept.items()},
        method="balance",
        method_reason=because,
        forces=result.ForceCalibration(
            tuple(record.file for record in found.records),
            forces.division.by,
            forces.errors.training,
            forces.errors.each,
            forces.floor_percent,
            ComparedErrors(*found.compared),
            forces.held,
        ),
        provenance=provenance,
    )


def _at_rod(found: BalanceCalibration) -> dict[str, result.RodModel]:
    """The mechanics as a force model at the rod; empty for a machine without one."""
    if not all(found.known.has(name) for name in ("screw.lead_mm", "gearbox.ratio")):
        return {}
    lead = lead_m_per_rad(found.known)
    before, after = ({name: one[name] for name in VALUES} for one in (found.known, found.actuator))
    known_std = {name: value for name, value in found.forces.std.items() if name not in found.forces.at_ends}
    std = {name: known_std.get(name, math.nan) for name in VALUES}
    models = {title: asdict(at_rod(values, lead)) for title, values in (("before", before), ("after", after), ("std", std))}
    return {
        title: result.RodModel(**{name: value if math.isfinite(value) else None for name, value in model.items()})
        for title, model in models.items()
    }


def _calibrated(one: FittedParameter) -> result.Calibrated:
    change_percent = 100.0 * (one.after - one.before) / one.before if one.before else None
    return result.Calibrated(
        one.before, one.after, one.std, change_percent, row_of(one.name).unit, one.source, one.at_bound, interval_of(one.after, one.std)
    )
