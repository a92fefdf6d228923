"""A warm winding resists more: R (1 + 0.00393 rise).

Source: temperature coefficient of copper at 20 degC, IEC 60028.
"""

from collections.abc import Mapping
from typing import Any

COPPER_PER_DEGC = 0.00393
EXAMPLE = {"rise_degC": 60.0}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """The resistance grows with the temperature."""
    return {"motor.resistance_ohm": values["motor.resistance_ohm"] * (1.0 + COPPER_PER_DEGC * effect.rise_degC)}
