"""Four balances, each from measured signals and one group of blocks, so that its residual accuses that group.

mechanical: kt i - (J dw/dt + D w + F sgn w + load); electrical: u - (R i + L di/dt + ke w); kinematic: rod position - play of the motor
position; controller: applied command - control law of command and feedback. What the actuator's enabled effects add is part of the model side.
"""

from __future__ import annotations

from collections.abc import Callable

from ema_tools.balances.balance import Balance
from ema_tools.balances.controller import controller
from ema_tools.balances.electrical import electrical
from ema_tools.balances.filtering import Smoother
from ema_tools.balances.kinematic import kinematic
from ema_tools.balances.mechanical import filter_of, mechanical
from ema_tools.base.errors import MissingSignal
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record

BALANCES = ("mechanical", "electrical", "kinematic", "controller")
_OTHERS: dict[str, Callable[[Actuator, Record], Balance]] = {"electrical": electrical, "kinematic": kinematic, "controller": controller}


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
