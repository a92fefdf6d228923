"""The result of `ema calibrate`."""

from __future__ import annotations

from dataclasses import asdict

from ema_tools.base.interval import interval_of
from ema_tools.data.actuator import row_of
from ema_tools.results import calibration as result
from ema_tools.results.parts import Provenance
from ema_tools.tasks.calibrate import Calibration, FittedParameter
from ema_tools.tasks.own_machine import OwnMachine


def calibration(found: Calibration, actuator: str, provenance: Provenance, own: OwnMachine | None = None) -> result.CalibrationResult:
    """What was found; `actuator` is the file that was written, `own` what the unit's runs show beside base values."""
    return result.CalibrationResult(
        command="calibrate",
        actuator=actuator,
        parameters={parameter.name: _calibrated(parameter) for parameter in found.parameters},
        at_rod={title: result.RodModel(**asdict(model)) for title, model in found.at_rod().items()},
        error=result.ChannelErrors(found.errors_before, found.errors_after, found.noise),
        left_out=found.left_out,
        own_machine=None
        if own is None
        else result.OwnMachineEntry(
            own.records,
            dict(own.standing),
            dict(own.scatter_percent),
            dict(own.least_percent),
            dict(own.exceeded),
            dict(own.found_percent),
        ),
        provenance=provenance,
    )


def _calibrated(one: FittedParameter) -> result.Calibrated:
    change_percent = 100.0 * (one.after - one.before) / one.before if one.before else None
    return result.Calibrated(
        one.before, one.after, one.std, change_percent, row_of(one.name).unit, one.source, one.at_bound, interval_of(one.after, one.std)
    )
