"""A constant torque against extension, from the force balance of the rod."""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"torque_Nm": 0.05}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The load torque is larger by the effect's."""
    return {"screw.load_torque_Nm": values["screw.load_torque_Nm"] + effect.torque_Nm}
