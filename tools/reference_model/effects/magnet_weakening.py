"""Magnets that lost flux: kt, ke (1 - loss).

Source: reversible flux loss of NdFeB magnets with temperature, about 0.1 % per degC.
"""

from collections.abc import Mapping
from typing import Any

EXAMPLE = {"loss": 0.05}


def change_values(effect: Any, values: Mapping[str, float]) -> dict[str, float]:
    """Torque constant and back-EMF fall together."""
    left = 1.0 - effect.loss
    names = ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad")
    return {name: values[name] * left for name in names}
