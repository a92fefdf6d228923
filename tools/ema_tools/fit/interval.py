"""How far what a search reads may be off what wears: sensor noise is only a small part of it, since friction, grease and winding are another every day.

An estimate is where the weighted squared error of the recorded signals is least; there it follows a change of any other value by the normal equations of least squares.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator, row_of
from ema_tools.data.records import Record, start_of
from ema_tools.fit import nuisance as spreads
from ema_tools.fit.evidence import simulate_channels, slope_step
from ema_tools.fit.nuisance import Spread

_STEP = 0.01  # of a value, to both sides: large against reversals that jump a step, small against what bends [precision]


def slopes(
    actuator: Actuator, record: Record, names: Sequence[str], weights: Mapping[str, float], scattering: Sequence[Spread] = ()
) -> dict[str, Reals]:
    """How the weighted signals move with each value of `names` and of what is `scattering`, per unit of it, [channels * rows] by name; `weights` as `scatter_of` takes them.

    A value at the end of its range does not move.
    Raises InputError when the model refuses a value near the actuator's.
    """
    channels = tuple(name for name, weight in weights.items() if weight > 0.0)
    root = np.sqrt([weights[name] for name in channels])[:, None]
    steps = {one.title: slope_step(one) * one.std for one in scattering if not one.relative}
    start = start_of(actuator, record)

    def slope(name: str) -> Reals:
        value, row = actuator[name], row_of(name)
        # what is zero on the data sheet has no share to step by
        low, high = (value - steps[name], value + steps[name]) if name in steps else (value * (1.0 - _STEP), value * (1.0 + _STEP))
        low, high = max(low, row.lower), min(high, row.upper)
        if not high > low:
            return np.zeros(root.size * record.rows)
        ends = [simulate_channels(actuator.changed({name: at}), record, channels, start) for at in (low, high)]
        return np.asarray(((ends[1] - ends[0]) * root / (high - low)).ravel())

    return dict(zip(found := [*dict.fromkeys([*names, *(one.title for one in scattering)])], each(slope, found), strict=True))


def scatter_of(actuator: Actuator, record: Record, names: Sequence[str], weights: Mapping[str, float]) -> dict[str, float]:
    """Standard deviation, in their own units, by which the estimates of `names` move from run to run with what scatters on a healthy machine.

    `weights`: of the squared error of each signal by name, as in the search. `actuator` holds the estimates. Raises InputError when the model refuses a value near them.
    """
    scattering = spreads.from_run_to_run(actuator)
    moving = {one.title: one.in_unit(actuator) for one in scattering}
    columns = slopes(actuator, record, names, weights, scattering)
    own = np.column_stack([columns[name] for name in names])
    follow = np.linalg.pinv(own)
    moved = np.array([std * (follow @ columns[name]) for name, std in moving.items()]).reshape(len(moving), len(names))
    return {name: float(size) for name, size in zip(names, np.sqrt(np.sum(moved**2, axis=0)), strict=True)}
