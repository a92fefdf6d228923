"""Puts one effect into a model by the balance of forces: on the same bench as `ema diagnose`, so that both say the same of the same records."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ema_tools.base.errors import InputError
from ema_tools.base.progress import Report
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.library.registry import named
from ema_tools.select.balance_bench import compared_percent
from ema_tools.select.fixes import NONE, Fixes
from ema_tools.select.force_refit import ForceRefit, add_by_forces
from ema_tools.select.forward_errors import Forward, forward_of
from ema_tools.tasks.diagnose_by_balance import gates_of


@dataclass(frozen=True)
class BalanceAdded:
    """The model with the effect, refitted on `records`, nothing of it to `holdout`; errors are relative force errors in %. `compared`: what `ema compare` reads of all rows, before and after."""

    effect: str
    records: tuple[AnyRecord, ...]
    holdout: tuple[AnyRecord, ...]
    known: Actuator
    forces: ForceRefit
    compared: tuple[float, float]
    forward: Forward

    @property
    def actuator(self) -> Actuator:
        """What `ema add` writes."""
        return self.forces.actuator

    @property
    def recommended(self) -> bool:
        """Whether to keep the effect."""
        return not self.forces.reason

    @property
    def refitted(self) -> bool:
        """Whether the model held the effect before."""
        return self.effect in self.known.active_effects


def add_by_balance(
    actuator: Actuator,
    effect: str,
    records: Sequence[AnyRecord],
    holdout: Sequence[AnyRecord] = (),
    fixes: Fixes = NONE,
    report: Report | None = None,
) -> BalanceAdded:
    """Fits `effect` together with base values and the model's own effects. Raises InputError for records that cannot answer, and for an effect that they do not show."""
    if effect not in named():
        raise InputError(
            f"add {effect}: a table that is learned: by the balance only the physical effects that ema effects lists are fitted, so give --method simulation"
        )
    if effect in fixes.effects:
        raise InputError(f"add {effect}: --fix {effect}: what is kept is not fitted: leave one of the two out")
    gates_of(actuator, records, holdout)
    found = add_by_forces(actuator, effect, records, holdout, fixes, report)
    compared = (compared_percent(actuator, records), compared_percent(found.actuator, records))
    forward = forward_of(actuator, found.actuator, records, holdout, found.division, found.foretold)
    return BalanceAdded(effect, tuple(records), tuple(holdout), actuator, found, compared, forward)
