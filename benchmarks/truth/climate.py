"""What a day's temperature makes of a machine: resistance of copper, viscosity of grease, level of dry friction, each by its own law."""

from __future__ import annotations

import math
from collections.abc import Mapping

from benchmarks.truth.forms import COPPER_PER_DEGC

# Greases lose half of their viscosity in about 23 degC near room temperature.
GREASE_PER_DEGC = 0.03
# Boundary friction falls a little as the film thickens with temperature's help: half a percent per degC.
DRY_PER_DEGC = 0.005


def at_temperature(values: Mapping[str, float], warmer_degC: float) -> dict[str, float]:
    """The values `warmer_degC` above the temperature at which they hold; those without a law stay."""
    factors = {
        "motor.resistance_ohm": 1.0 + COPPER_PER_DEGC * warmer_degC,
        "screw.viscous_Nm_s_per_rad": math.exp(-GREASE_PER_DEGC * warmer_degC),
        "screw.csj_Nm": math.exp(-DRY_PER_DEGC * warmer_degC),
    }
    return {name: value * factors.get(name, 1.0) for name, value in values.items()}
