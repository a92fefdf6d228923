"""What records say of the torque at which the machine breaks away from rest, today's against healthy ones.

The balance of forces fits friction where the machine slides, and a bump of friction that is over before it slides well shows at rest alone: the drive rises to what holds the machine, and then it
moves. The level is told as the share of it at which the machine slides, as the model has it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence

import numpy as np

from ema_tools.balances.effects import adjusted
from ema_tools.balances.mechanical import best_placed, mechanical_model
from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord
from ema_tools.library.registry import named, record_of
from ema_tools.select.healthy_balance import SURE_RECORDS, HealthyByBalance
from ema_tools.select.value_changes import Change

SHARE = "screw.dynamic_ratio"
_LEAST = 0.04  # scatter of the level from record to record, relative: the filter takes off each peak what its haste makes it [judgement]
_LEAST_TIMES = 3.0  # such standard deviations are a change [chance]
_STARTS = 3  # from rest, that a record must hold for its level to be told [chance]


def standstill_changes(
    machine: HealthyByBalance, today: Actuator, records: Sequence[AnyRecord], missing: Collection[str]
) -> tuple[Change, ...]:
    """Sliding friction as a share of what holds the machine at rest, where enough records on both sides tell it; nothing where they do not, where a contact that yields never rests, and where
    friction that falls with the speed is `missing`, which goes on to rest.

    `today`: the model with what was found in today's records, its friction among it. A level that falls is no change: whatever moves the machine early looks like it. Raises MissingSignal.
    """
    if set(_falling()) & set(missing):
        return ()
    before = [level for record in machine.records if (level := _breaks_away(machine.actuator, record)) is not None]
    after = [level for record in records if (level := _breaks_away(today, record)) is not None]
    share = machine.actuator[SHARE]
    if len(before) < SURE_RECORDS or not after or not share > 0.0:
        return ()
    healthy, now = float(np.mean(before)), float(np.mean(after))
    shown, least = float(np.std(before, ddof=1)), _LEAST * healthy
    # few records tell their scatter badly
    limit = max(machine.times * shown, _LEAST_TIMES * least) * math.sqrt(1.0 / len(before) + 1.0 / len(after))
    std = max(shown, least) * math.sqrt(1.0 / len(before) + 1.0 / len(after))
    # where the drive does not show what holds the healthy machine, the change is still one of the level
    found = share * healthy / now
    return (Change(SHARE, share, found, found * std / now, found * limit / now, now - healthy > limit),)


def looks_like(changes: Sequence[Change]) -> tuple[str, ...]:
    """Effects that a level which has risen looks like: friction that falls with the speed, over before the machine slides well."""
    return tuple(name for name in _falling() if not record_of(name).special_case) if any(one.counts for one in changes) else ()


def _falling() -> list[str]:
    """Effects of friction that falls with the speed."""
    return [name for name in named() if (local := record_of(name).local) is not None and local.falls]


def _breaks_away(actuator: Actuator, record: AnyRecord) -> float | None:
    """The torque at which a record leaves its rests, in the middle of them, as a share of what the model holds at most; None of too few rests."""
    model, values = mechanical_model(actuator, best_placed(actuator, record)), adjusted(actuator)
    parameters = np.array((values["screw.inertia_kgm2"], values["screw.viscous_Nm_s_per_rad"], 0.0, values["screw.load_torque_Nm"]))
    net, backward, forward = model.at_rest_Nm(parameters, values["screw.csj_Nm"])
    holds = np.where(net > 0.0, forward, backward)
    if not np.all(holds[model.resting] > 0.0):
        return None
    share = np.abs(net) / np.where(holds > 0.0, holds, 1.0)
    peaks = _peaks(share, model.resting)
    return float(np.median(peaks)) if peaks.size >= _STARTS else None


def _peaks(share: Reals, resting: np.ndarray) -> Reals:
    """The largest value in each rest that ends in a motion, [rests]."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], resting.astype(np.int8), [0]))))
    return np.array([np.max(share[first:last]) for first, last in zip(edges[::2], edges[1::2], strict=True) if last < resting.size])
