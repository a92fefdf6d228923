"""Effects that do exactly what a parameter of the machine does: a hot winding has a higher resistance, and no record tells which of the two it is.

Without repeats such an effect stands against what a data sheet leaves open of that parameter. How far the parameter is off is what the record shows; the effect then takes
the whole of it, and its standard error is the parameter's spread. Fitting both together would seek the bottom of a valley that has none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.data.actuator import row_of
from ema_tools.fit.evidence import FAR, View, settled, view
from ema_tools.fit.refit import Fit
from ema_tools.library.faults import effect_of

_LOOSE = 100.0  # spreads
_ROUNDS = 6
_COPPER_PER_DEGC = 0.00393  # IEC 60028, as the effect has it


@dataclass(frozen=True)
class _Twin:
    """The parameter that stands for all that move with it, and the effect's size per relative change of it, or per its own unit where it is zero on a data sheet."""

    parameter: str
    per_change: float


TWINS: Mapping[str, _Twin] = {
    "effects.winding_heating.rise_degC": _Twin("motor.resistance_ohm", 1.0 / _COPPER_PER_DEGC),
    "effects.magnet_weakening.loss": _Twin("motor.torque_constant_Nm_per_A", -1.0),
    "effects.inertia_change.change": _Twin("screw.inertia_kgm2", 1.0),
    "effects.supply_sag.sag": _Twin("drive.supply_V", -1.0),
    "effects.gain_drift.drift": _Twin("control.kp_per_m", 1.0),
    "effects.sensor_gain.error": _Twin("encoder.rod_gain_error", 1.0),
    "effects.sensor_offset.offset_mm": _Twin("encoder.rod_offset_mm", 1.0),
    "effects.coulomb_asymmetry.asymmetry": _Twin("screw.friction_asymmetry", 1.0),
}


def twins(free: View) -> list[Fit]:
    """Per such effect the fit in which it takes over from the parameter, seen from `free`, where the machine itself explains most."""
    evidence = free.evidence
    found = []
    for place, one in enumerate(evidence.spread):
        names = [
            name for name, twin in TWINS.items() if twin.parameter == one.title and effect_of(name) not in evidence.actuator.active_effects
        ]
        if not names:
            continue
        # the parameter as the record alone has it: what else a data sheet leaves open need not make up for it any more
        loose = replace(one, std=_LOOSE * one.std)
        start = free.deviations.copy()
        start[place] /= _LOOSE
        seen = settled(
            replace(evidence, spread=tuple(loose if other is one else other for other in evidence.spread)), {}, start, _ROUNDS, FAR
        )
        change = loose.std * float(seen.deviations[place])
        for name in names:
            size, row = TWINS[name].per_change * change, row_of(name)
            if not row.lower <= size <= row.upper:
                continue
            at = seen.deviations.copy()
            at[place] = 0.0
            values = {name: size}
            # a relative spread is one of the value with the effect in it
            std = TWINS[name].per_change * float(np.hypot(one.std * (1.0 + change if one.relative else 1.0), loose.std * seen.doubt(place)))
            found.append(Fit((effect_of(name),), values, np.array([[std**2]]), (), view(evidence, values, at), seen.cost))
    return found
