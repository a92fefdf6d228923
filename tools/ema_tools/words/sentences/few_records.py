"""What few healthy records leave open."""

from __future__ import annotations

from ema_tools.data.actuator import Actuator
from ema_tools.fit.nuisance import FROM_RUN_TO_RUN
from ema_tools.select.healthy_balance import SURE_RECORDS


def few_records(count: int, actuator: Actuator) -> str:
    """That so few healthy records hardly tell how runs differ, as a further sentence; empty where there are enough or none, and where the actuator states what they would tell."""
    if not 0 < count < SURE_RECORDS or set(FROM_RUN_TO_RUN) <= set(actuator.scatter):
        return ""
    return (
        f" How much runs differ is uncertain with {count} healthy record{'s' if count > 1 else ''}: "
        f"give {SURE_RECORDS} or more, or state it in [scatter] of the actuator."
    )
