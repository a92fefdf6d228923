"""Base values from records by the balance of forces: what `ema calibrate` does for a machine whose controller is not known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.select.balance_bench import compared_percent
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_refit import ForceRefit, refit_by_forces
from ema_tools.tasks.diagnose_by_balance import gates_of


@dataclass(frozen=True)
class BalanceCalibration:
    """The calibrated model; errors are relative force errors in %. `compared`: what `ema compare` reads of all rows, before and after."""

    records: tuple[AnyRecord, ...]
    known: Actuator
    forces: ForceRefit
    compared: tuple[float, float]

    @property
    def actuator(self) -> Actuator:
        """What `ema calibrate` writes."""
        return self.forces.actuator


def calibrate_by_balance(
    actuator: Actuator, records: Sequence[AnyRecord], fixes: Fixes = NONE, report: Report | None = None
) -> BalanceCalibration:
    """Fits base values, and with them the sizes of the model's own effects, to all records. Raises InputError for records that cannot answer."""
    gates_of(actuator, records)
    found = refit_by_forces(actuator, records, fixes, report)
    compared = (compared_percent(actuator, records), compared_percent(found.actuator, records))
    return BalanceCalibration(tuple(records), actuator, found, compared)
