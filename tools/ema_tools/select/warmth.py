"""What a day of another temperature makes of a healthy machine: winding, grease and magnets as warm as each other are no effect.

The winding is the thermometer, copper by its constant. What a degree does to magnets differs by their material from next to nothing (samarium-cobalt) to 0.2 % (ferrite), always to the same side
(R. Krishnan, Permanent Magnet Synchronous and Brushless DC Motor Drives, 2010, ch. 1), so their change is read from the record itself, and what lies on the other side or beyond is none of theirs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ema_tools.data.actuator import Actuator
from ema_tools.fit.evidence import Evidence
from ema_tools.fit.nuisance import COPPER_PER_DEGC, GREASE_PER_DEGC
from ema_tools.select.known_machine import LAST_STEPS, KnownMachine, MachineFit
from ema_tools.select.strategies.strategy import LEAST_LIMIT

_WINDING, _GREASE = "motor.resistance_ohm", "screw.viscous_Nm_s_per_rad"
# One property of the magnets, which move together [physics]
_OF_MAGNETS = ("motor.torque_constant_Nm_per_A", "motor.back_emf_V_s_per_rad")
_MOST_PER_DEGC = 0.0025  # ferrite loses 0.2 % of its flux in a degree [physics]
_LEAST_DEGC = 2.0  # of a winding over its healthy runs: less is what days differ by anyway [judgement]
_MOST_DEGC = 45.0  # and more is no day's: a winding that is hot alone, or no longer what it was [judgement]
_SHOWN = 3.0  # standard errors of what the record says of its winding, which hold what the model leaves: less is no thermometer [chance]
_ALIKE = 3.0  # times as far from the healthy runs as the winding may the grease's temperature be: greases differ [judgement]
_TRIED = (0.0, 0.4, 0.8)  # of the most, at which the rest of the machine is fitted again [precision]


@dataclass(frozen=True)
class MagnetsToday:
    """How much warmer the winding is than on the healthy runs, and what share of their flux the magnets have lost with it: below none where it is colder."""

    warmer_degC: float
    loss: float


def without_magnets(known: KnownMachine, base: MachineFit) -> tuple[Evidence, MagnetsToday] | None:
    """A record beside healthy runs without what another temperature makes of the magnets, and what that was; None where it shows nothing of the kind. `base`: of CSJ, BLK and what scatters.

    For what takes the machine for known but for these: an effect that is missing bends what is read here.
    """
    evidence = known.evidence
    if not evidence.relative or len(evidence.channels) < 2 or not known.actuator.has(_OF_MAGNETS[0]) or _WINDING not in known.scatter:
        return None
    if known.plain(base) or not _is_of_a_day(known, base):
        return None
    found = _read(known, base)
    if found is None:
        return None
    today, fit = found
    by_magnets = known.signals(fit.values) - known.signals({**fit.values, **_changed(known.actuator, 0.0)})
    return replace(evidence, target=evidence.target - by_magnets), today


def winding_alone(known: KnownMachine, base: MachineFit) -> float | None:
    """By what share the winding's resistance is surely off the healthy runs where nothing else of the record is as warm; None where it is not, or the record does not compare current and voltage.

    A current that is read wrongly makes the same of both signals.
    """
    if not {"current_A", "voltage_V"} <= set(known.evidence.channels) or _WINDING not in known.scatter:
        return None
    if not _is_of_a_day(known, base):
        return None
    if _GREASE in known.scatter and _is_grease_as_warm(known, base):
        return None
    return base.values[_WINDING] / known.actuator[_WINDING] - 1.0


def _is_grease_as_warm(known: KnownMachine, base: MachineFit) -> bool:
    """Whether the grease is off the healthy runs, surely, and about as warm as the winding."""
    change = base.values[_GREASE] / known.actuator[_GREASE] - 1.0
    if abs(change) * known.actuator[_GREASE] < _SHOWN * known.with_whole_std(base).std.get(_GREASE, math.inf):
        return False
    by_grease = -math.log1p(max(change, -0.99)) / GREASE_PER_DEGC
    return 1.0 / _ALIKE < by_grease / _warmer_degC(known, base) < _ALIKE


def _is_of_a_day(known: KnownMachine, base: MachineFit) -> bool:
    """Whether the winding is off the healthy runs, surely, and no farther than a day takes it."""
    if not _LEAST_DEGC <= abs(_warmer_degC(known, base)) <= _MOST_DEGC or known.at_reach(base):
        return False
    # what is missing bends every value
    std = known.with_whole_std(base).std.get(_WINDING, math.inf)
    return abs(base.values[_WINDING] - known.actuator[_WINDING]) >= _SHOWN * std


def _warmer_degC(known: KnownMachine, fit: MachineFit) -> float:
    return (fit.values[_WINDING] / known.actuator[_WINDING] - 1.0) / COPPER_PER_DEGC


def _changed(actuator: Actuator, loss: float) -> Mapping[str, float]:
    return {name: actuator[name] * (1.0 - loss) for name in _OF_MAGNETS}


def _read(known: KnownMachine, base: MachineFit) -> tuple[MagnetsToday, MachineFit] | None:
    """What the magnets have lost and the rest of the machine beside it, by the lowest point of the cost through three losses; None where that is not inside what temperature does."""
    most = _MOST_PER_DEGC * _warmer_degC(known, base)
    losses = [share * most for share in _TRIED]
    costs = [base.cost]
    for loss in losses[1:]:
        fit = _beside(known, base, loss)
        if fit is None:
            return None
        costs.append(fit.cost)
    bend, slope, _ = np.polyfit(losses, costs, 2)
    if not bend > 0.0:
        return None
    loss = float(-slope / (2.0 * bend))
    fit = _beside(known, base, loss) if 0.0 < loss / most < 1.0 else None
    if fit is None or base.cost - fit.cost < LEAST_LIMIT:
        return None
    warmer = _warmer_degC(known, fit)
    is_theirs = abs(warmer) >= _LEAST_DEGC and 0.0 < loss / (_MOST_PER_DEGC * warmer) < 1.0
    return (MagnetsToday(warmer, loss), fit) if is_theirs else None


def _beside(known: KnownMachine, base: MachineFit, loss: float) -> MachineFit | None:
    """CSJ, BLK and what scatters beside magnets that have lost so much."""
    return known.fit("", {**base.values, **_changed(known.actuator, loss)}, known.free, LAST_STEPS)
