"""A winding that its own loss warms: R (1 + 0.00393 T), time dT/dt = rise_degC_per_W R i^2 - T.

Source: thermal resistance and time constant of a winding as motor makers state them; copper, IEC 60028. `memory` is T in degC.
"""

from typing import Any

from ema_tools.base.compiled import compiled

EXAMPLE = {"rise_degC_per_W": 0.5, "time_s": 2.0}


@compiled
def change(effect: Any, memory: float) -> float:
    """Relative change of the resistance."""
    return 0.00393 * memory


@compiled
def rate_per_s(effect: Any, memory: float, heat_W: float) -> float:
    """Rate of the temperature, degC/s."""
    return (effect.rise_degC_per_W * heat_W - memory) / effect.time_s
