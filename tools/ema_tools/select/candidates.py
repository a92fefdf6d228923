"""Every effect of the library as candidates: the shapes in which it may appear, each at a size that matches the evidence.

Play, delay and stiction are not differentiable at zero, so a signature is a difference of finite size. The size is found, not given: it is scaled until the
signature explains as much of the residual as it can.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.data.actuator import Actuator
from ema_tools.fit.evidence import Sensitivity, View
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.library.shapes import penalty
from ema_tools.library.torques import PeriodicTorque, combined
from ema_tools.select.matched_filter import Screen, Shaped, shapes_of

# First size tried, as a share of an effect's range; then it is scaled by what the residual asks for.
_FIRST_SHARE = 0.002
_SCALINGS = 4
# Where the scatter of the healthy machine explains a small change, only a large one shows, and not in proportion: further first sizes for effects of one shape.
_LADDER = (1.0, 8.0, 30.0, 100.0)
# After the first round, effects that may take off this share of what is needed, and at most so many, are simulated.
_PROMISING_SHARE = 0.3
_PROMISING_MAX = 7
# Where periods are tried by simulation, each number of them at so many phases, and the best are kept.
_FINE_PHASES = 6
_FINE_KEPT = 3
_FACTORS = (1e-3, 1e3)
_POWERS = (0.5, 3.0)


@dataclass(frozen=True)
class Candidate:
    """One effect in one shape: names of its values, the size first, the sizes to begin with, and where the size may lie."""

    effect: str
    size: str
    shape: Mapping[str, float]
    first: tuple[float, ...]
    lower: float
    upper: float
    zero: float

    def changes(self, size: float) -> dict[str, float]:
        """The model's changed values at a size."""
        return {self.size: size, **self.shape}


@dataclass(frozen=True)
class Signature:
    """A candidate at the size that explains most: what it shows there, by how much it lowers the cost of the residual, less what the choice of its shape would of noise."""

    candidate: Candidate
    size: float
    shown: Sensitivity
    score: float

    @property
    def view(self) -> View:
        """The view that shows it so."""
        return self.shown.view

    def start(self) -> dict[str, float]:
        """Where a refit of the effect begins."""
        return self.candidate.changes(self.size)


def _ladder(lower: float, upper: float, zero: float, rungs: Sequence[float]) -> tuple[float, ...]:
    reaches = [reach for reach in (upper - zero, lower - zero) if reach != 0.0]
    return tuple(zero + _FIRST_SHARE * rung * reach for reach in reaches for rung in rungs)


def _of_effect(effect: Effect, view: View, screen: Screen) -> list[Candidate]:
    size = effect.size
    name = f"effects.{size.name}"
    actuator = view.evidence.actuator
    present = effect.name in actuator.active_effects
    record = record_of(effect.name)

    def one(shape: Mapping[str, float], first: tuple[float, ...], zero: float = size.nominal) -> Candidate:
        return Candidate(effect.name, name, shape, first, size.lower, size.upper, zero)

    if record.below_peak is not None:
        peak = float(np.max(np.abs(screen.states.current_A)))
        return [one({}, (share * peak,)) for share in record.below_peak.tried]
    suggested = shapes_of(screen, effect.name)
    if record.periodic is not None and record.periodic.simulated_at > 0.0 and not present and "current_A" not in view.evidence.channels:
        suggested = [*(suggested or ()), *_by_simulation(effect, record.periodic, view)]
    if suggested is not None and not present:
        return [one(shaped.shape, (float(np.clip(shaped.size, size.lower, size.upper)),)) for shaped in suggested if shaped.size != 0.0]
    if suggested is not None and "phase_rad" in {value.field for value in effect.parameters}:
        return [one(*_turned(effect, actuator, shaped)) for shaped in suggested if _same_periods(effect, actuator, shaped.shape)]
    if not record.shapes and not present:
        # nothing suggests its further values: they are fitted from where they stand, except one at zero, which has no scale
        stands = {
            f"effects.{value.name}": actuator[value.name]
            for value in effect.parameters[1:]
            if actuator[value.name] != 0.0 or value.field == "phase_rad"
        }
        return [one(stands, _ladder(size.lower, size.upper, size.nominal, _LADDER))]
    grid = {} if present else {f"effects.{effect.name}.{field}": values for field, values in record.shapes.items()}
    zero = actuator[size.name]
    first = () if present else record.first
    return [one(shape, first or _ladder(size.lower, size.upper, zero, _LADDER), zero) for shape in combined(grid)]


def _by_simulation(effect: Effect, periodic: PeriodicTorque, view: View) -> list[Shaped]:
    """The best numbers of periods and phases of an effect by one simulation each, best first."""
    first = periodic.simulated_at * (view.evidence.actuator["screw.csj_Nm"] if effect.size.unit == "Nm" else 1.0)
    phases = np.linspace(-np.pi, np.pi, _FINE_PHASES, endpoint=False)
    shapes = [
        {f"effects.{effect.name}.periods": float(number), f"effects.{effect.name}.phase_rad": float(phase)}
        for number in periodic.periods
        for phase in phases
    ]

    def tried(shape: Mapping[str, float]) -> Shaped:
        shown = view.sensitivity({f"effects.{effect.size.name}": first, **shape})
        wanted, gain = _gain(shown.with_residual(), shown.square)
        return Shaped(shape, first * wanted, gain)

    return sorted(each(tried, shapes), key=lambda one: -one.score)[:_FINE_KEPT]


def _same_periods(effect: Effect, actuator: Actuator, shape: Mapping[str, float]) -> bool:
    name = f"{effect.name}.periods"
    return all(abs(value - actuator[name]) < 1e-6 for key, value in shape.items() if key.endswith(name))


def _turned(effect: Effect, actuator: Actuator, change: Shaped) -> tuple[Mapping[str, float], tuple[float, ...]]:
    """Shape and size of a periodic effect that is there already and changes in amplitude and phase."""
    phase = f"{effect.name}.phase_rad"
    both = actuator[effect.size.name] * np.exp(1j * actuator[phase]) + change.size * np.exp(1j * change.shape[f"effects.{phase}"])
    return {**change.shape, f"effects.{phase}": float(np.angle(both))}, (float(np.clip(abs(both), effect.size.lower, effect.size.upper)),)


def candidates(view: View, without: Collection[str] = (), only: Collection[str] | None = None) -> list[Candidate]:
    """Every effect in every shape that is tried, a change of those that the actuator holds already among them; and the fault parameters. `only`: of these effects."""
    evidence = view.evidence
    found = []
    scattering = {name for one in evidence.spread for name in one.names} if not evidence.relative else set()
    for fault, value in FAULTS.items():
        nominal = evidence.actuator[value]
        if fault not in without and (only is None or fault in only) and nominal > 0.0 and value not in scattering:
            found.append(
                Candidate(fault, value, {}, _ladder(0.0, 20.0 * nominal, nominal, _LADDER[:3]), 0.05 * nominal, 20.0 * nominal, nominal)
            )
    screen = Screen(view)
    for effect in load_definitions().effects:
        if effect.name not in without and (only is None or effect.name in only) and not effect.is_learned:
            found += _of_effect(effect, view, screen)
    return found


def _gain(product: float, square: float) -> tuple[float, float]:
    """How far the size should be scaled, and the cost that it then takes off, by what is left of a sensitivity: its product with the residual and its squared length."""
    if not square > 0.0:
        return 0.0, 0.0
    share = product / square
    kept = float(np.clip(share, 0.0, 2.0))
    return share, 2.0 * kept * product - kept * kept * square


def _matched(candidate: Candidate, first: float, view: View) -> Signature | None:
    best: Signature | None = None
    record = record_of(candidate.effect)
    size, power = first, record.power
    earlier: tuple[float, float] | None = None
    for _ in range(_SCALINGS if record.below_peak is None else 1):
        try:
            shown = view.sensitivity(candidate.changes(size))
        except InputError:
            break
        share, gain = _gain(shown.with_residual(), shown.square)
        score = gain - penalty([candidate.effect])
        if best is None or score > best.score:
            best = Signature(candidate, size, shown, score)
        if share <= 0.0 or abs(share - 1.0) < 0.2:
            break
        reach, length = abs(size - candidate.zero), float(np.sqrt(max(shown.square, 1e-300)))
        if earlier is not None and reach != earlier[0]:
            # a stretch grows with the square of its period, a play not at all before it is left
            power = float(np.clip(np.log(length / earlier[1]) / np.log(reach / earlier[0]), *_POWERS))
        earlier = (reach, length)
        factor = float(np.clip(share, *_FACTORS)) ** (1.0 / power)
        wanted = float(np.clip(candidate.zero + (size - candidate.zero) * factor, candidate.lower, candidate.upper))
        if wanted == size:
            break
        size = wanted
    return best


def promising(view: View, earlier: Sequence[Signature], least: float) -> tuple[str, ...]:
    """Effects that may lower the cost by a good part of `least`, judged without simulating them: by the signatures that they had before another effect was added, and by
    torque patterns. A simulation beside an effect that is hard to compute costs ten times as much."""
    guessed: dict[str, float] = {}
    places = {id(one.view): one.view for one in earlier}
    meets = {place: (there.shared(view.residual), view.overlap(there)) for place, there in places.items()}
    for signature in earlier:
        name = signature.candidate.effect
        product, length = signature.shown.seen_from(view, *meets[id(signature.view)])
        if length > 0.0 and (product > 0.0 or signature.candidate.lower < signature.candidate.zero):
            guessed[name] = max(guessed.get(name, 0.0), product * product / length)
    screen = Screen(view)
    for effect in load_definitions().effects:
        shaped = None if effect.is_learned else shapes_of(screen, effect.name)
        if shaped:
            guessed[effect.name] = max(guessed.get(effect.name, 0.0), shaped[0].score)
    kept = sorted((name for name, score in guessed.items() if score > _PROMISING_SHARE * least), key=lambda name: -guessed[name])
    return tuple(kept[:_PROMISING_MAX])


def signatures(view: View, without: Collection[str] = (), only: Collection[str] | None = None) -> list[Signature]:
    """The best-matched signature of every candidate beside what the view holds already, or of `only` these effects, strongest first; both cores at work."""
    tasks = [(candidate, first) for candidate in candidates(view, without, only) for first in candidate.first]
    found = each(lambda task: _matched(task[0], task[1], view), tasks)
    return sorted((signature for signature in found if signature is not None), key=lambda signature: -signature.score)
