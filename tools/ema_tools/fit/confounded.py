"""Effects that do exactly what a parameter of the machine does: a hot winding has a higher resistance, and no record tells which of the two it is.

Without repeats such an effect stands against what a data sheet leaves open of that parameter. How far the parameter is off is what the record shows; the effect then takes
the whole of it, and its standard error is the parameter's spread. Fitting both together would seek the bottom of a valley that has none.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from ema_tools.data.actuator import row_of
from ema_tools.fit.evidence import FAR, View, settled, view
from ema_tools.fit.refit import Fit
from ema_tools.library.definitions import is_size, load_definitions
from ema_tools.library.faults import effect_of
from ema_tools.library.record import ConfoundedParameter
from ema_tools.library.registry import record_of, records

_LOOSE = 100.0  # spreads to which the twin of an effect is let go: it is then free [judgement]
_ROUNDS = 6  # of linear steps to where it is best [effort]
_WORTH = 1.0  # prior standard deviations that an effect must save to be tried in place of a parameter [effort]


def confounded_parameter(name: str) -> ConfoundedParameter | None:
    """The parameter that does what this size of an effect does."""
    return record_of(effect_of(name)).confounded if is_size(name) else None


def confounded_with(parameter: str) -> dict[str, ConfoundedParameter]:
    """Sizes of effects that this parameter does as well."""
    sizes = {effect.name: f"effects.{effect.size.name}" for effect in load_definitions().effects}
    return {
        sizes[effect]: record.confounded
        for effect, record in records().items()
        if record.confounded is not None and record.confounded.parameter == parameter
    }


def confounded_fits(free: View, held: Fit | None = None) -> list[Fit]:
    """Per such effect the fit in which it takes over from the parameter, seen from `free`, where the machine itself explains most; beside effects that are `held` as they are, which the view
    holds too."""
    evidence = free.evidence
    fitted = {name: held.values[name] for name in held.fitted} if held is not None else {}
    kept = {name: value for name, value in held.values.items() if name not in fitted} if held is not None else {}
    effects = held.effects if held is not None else ()
    found = []
    for place, one in enumerate(evidence.spread):
        # without its prior a parameter moves on, and the cost falls by the square of this
        if abs(free.deviations[place]) < _WORTH * float(np.sqrt(max(1.0 - free.doubt(place) ** 2, 0.0))):
            continue
        known = {
            name: parameter
            for name, parameter in confounded_with(one.title).items()
            if effect_of(name) not in (*evidence.actuator.active_effects, *effects)
        }
        if not known:
            continue
        # the parameter as the record alone has it: what else a data sheet leaves open need not make up for it any more
        loose = replace(one, std=_LOOSE * one.std)
        start = free.deviations.copy()
        start[place] /= _LOOSE
        seen = settled(
            replace(evidence, spread=tuple(loose if other is one else other for other in evidence.spread)), free.values, start, _ROUNDS, FAR
        )
        change = loose.std * float(seen.deviations[place])
        for name, parameter in known.items():
            size, row = parameter.size_per_change * change, row_of(name)
            if not row.lower <= size <= row.upper:
                continue
            at = seen.deviations.copy()
            at[place] = 0.0
            values = {**fitted, name: size, **kept}
            # a relative spread is one of the value with the effect in it
            std = parameter.size_per_change * float(
                np.hypot(one.std * (1.0 + change if one.relative else 1.0), loose.std * seen.doubt(place))
            )
            covariance = block_diag(held.covariance, np.array([[std**2]])) if held is not None else np.array([[std**2]])
            found.append(Fit((*effects, effect_of(name)), values, covariance, (), view(evidence, values, at), seen.cost))
    return found
