"""Every effect of the library as candidates: the shapes in which it may appear, each at a size that matches the evidence.

Play, delay and stiction are not differentiable at zero, so a signature is a difference of finite size. The size is found, not given: it is scaled until the
signature explains as much of the residual as it can.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Generator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.errors import InputError, taken
from ema_tools.base.parallel import each, in_step
from ema_tools.data.actuator import Actuator
from ema_tools.fit.evidence import ROUGHNESS, Sensitivity, View
from ema_tools.library.definitions import Effect, load_definitions
from ema_tools.library.faults import FAULTS
from ema_tools.library.registry import record_of
from ema_tools.library.shapes import penalty
from ema_tools.library.torques import PeriodicTorque, combined
from ema_tools.select.matched_filter import Screen, Shaped

_FIRST_SHARE = 0.002  # first size tried, as a share of an effect's range; then it is scaled by what the residual asks for [judgement]
_SCALINGS = 4  # how often it is scaled [effort]
# Where the scatter of the healthy machine explains a small change, only a large one shows, and not in proportion: further first sizes for
# effects of one shape [judgement]
_LADDER = (1.0, 8.0, 30.0, 100.0)
_SHOWN_SHARE = 0.05  # a signature shows when this share of its square is left beside what scatters [judgement]
_NOTHING = 4.0  # a signature that would take off less than this at any size is not scaled: two standard deviations [chance]
_PROMISING_SHARE = 0.3  # after the first round, effects that may take off this share of what is needed .. [judgement]
_PROMISING_MAX = 7  # ... and at most so many, are simulated [effort]
# Where periods are tried by simulation, each number of them at these phases, a quarter of a turn apart [effort]
_SIMULATED_PHASES = np.array([0.0, 0.5 * np.pi])
# ... of so many phases that follow from them the best is taken [precision]
_FINE_PHASES = np.linspace(-np.pi, np.pi, 24, endpoint=False)
_FINE_KEPT = 3  # ... and so many numbers are kept [effort]


def _harmonics(phases: Reals) -> Reals:
    """What turns with the phase, [phases, 2]."""
    return np.column_stack([np.cos(phases), np.sin(phases)])


_OF_PHASES = np.linalg.inv(_harmonics(_SIMULATED_PHASES))
_AT_FINE = _harmonics(_FINE_PHASES)
_FACTORS = (1e-3, 1e3)  # by which a size is scaled at once, at least and at most [judgement]
_POWERS = (0.5, 3.0)  # of its size with which a signature grows, at least and at most: friction's root and a cube [physics]


_Result = TypeVar("_Result")
# What asks for the sensitivity to changes of the model, one after the other, before it has its result.
_Asking = Generator[Mapping[str, float], Sensitivity | InputError, _Result]


@dataclass(frozen=True)
class Candidate:
    """One effect in one shape: names of its values, the size first, and where the size may lie. `ladders`: sizes to begin with, each ladder gone up until the effect shows."""

    effect: str
    size: str
    shape: Mapping[str, float]
    ladders: tuple[tuple[float, ...], ...]
    lower: float
    upper: float
    zero: float

    @property
    def first(self) -> tuple[float, ...]:
        """All sizes to begin with."""
        return tuple(size for ladder in self.ladders for size in ladder)

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


def _ladders(lower: float, upper: float, zero: float, rungs: Sequence[float]) -> tuple[tuple[float, ...], ...]:
    """One for each side of zero."""
    reaches = [reach for reach in (upper - zero, lower - zero) if reach != 0.0]
    return tuple(tuple(zero + _FIRST_SHARE * rung * reach for rung in rungs) for reach in reaches)


def _apart(sizes: Sequence[float]) -> tuple[tuple[float, ...], ...]:
    """Each size a ladder of its own."""
    return tuple((size,) for size in sizes)


def _of_effect(effect: Effect, view: View, screen: Screen) -> list[Candidate]:
    size = effect.size
    name = f"effects.{size.name}"
    actuator = view.evidence.actuator
    present = effect.name in actuator.active_effects
    record = record_of(effect.name)

    def one(shape: Mapping[str, float], ladders: tuple[tuple[float, ...], ...], zero: float = size.nominal) -> Candidate:
        return Candidate(effect.name, name, shape, ladders, size.lower, size.upper, zero)

    if record.below_peak is not None:
        peak = float(np.max(np.abs(screen.states.current_A)))
        return [one({}, _apart((share * peak,))) for share in record.below_peak.tried]
    suggested = screen.shapes_of(effect.name)
    if record.periodic is not None and record.periodic.simulated_at > 0.0 and not present and "current_A" not in view.evidence.channels:
        suggested = [*(suggested or ()), *_by_simulation(effect, record.periodic, view)]
    if suggested is not None and not present:
        return [
            one(shaped.shape, _apart((float(np.clip(shaped.size, size.lower, size.upper)),))) for shaped in suggested if shaped.size != 0.0
        ]
    if suggested is not None and "phase_rad" in {value.field for value in effect.parameters}:
        return [one(*_turned(effect, actuator, shaped)) for shaped in suggested if _same_periods(effect, actuator, shaped.shape)]
    if not record.shapes and not present:
        # nothing suggests its further values: they are fitted from where they stand, except one at zero, which has no scale
        stands = {
            f"effects.{value.name}": actuator[value.name]
            for value in effect.parameters[1:]
            if actuator[value.name] != 0.0 or value.field == "phase_rad"
        }
        return [one(stands, _ladders(size.lower, size.upper, size.nominal, _LADDER))]
    grid = {} if present else {f"effects.{effect.name}.{field}": values for field, values in record.shapes.items()}
    zero = actuator[size.name]
    first = () if present else _apart(record.first)
    return [one(shape, first or _ladders(size.lower, size.upper, zero, _LADDER), zero) for shape in combined(grid)]


def _by_simulation(effect: Effect, periodic: PeriodicTorque, view: View) -> list[Shaped]:
    """The best numbers of periods and phases of an effect by two simulations each, a quarter of a turn apart, best first.

    A small torque's signature turns with its phase, so that every other phase follows from these.
    """
    first = periodic.simulated_at * (view.evidence.actuator["screw.csj_Nm"] if effect.size.unit == "Nm" else 1.0)
    amplitude, periods, turn = (f"effects.{name}" for name in (effect.size.name, f"{effect.name}.periods", f"{effect.name}.phase_rad"))
    tasks = [(float(number), float(phase)) for number in periodic.periods for phase in _SIMULATED_PHASES]
    shown = taken(view.sensitivities([{amplitude: first, periods: number, turn: phase} for number, phase in tasks]))
    count = len(_SIMULATED_PHASES)
    found = []
    for place, number in enumerate(periodic.periods):
        vectors = shown[count * place : count * (place + 1)]
        product = _OF_PHASES @ np.array([one.with_residual() for one in vectors])
        square = _OF_PHASES @ np.array([[one.with_other(other) for other in vectors] for one in vectors]) @ _OF_PHASES.T
        at_phases = [_gain(float(at @ product), float(at @ square @ at)) for at in _AT_FINE]
        best = max(range(len(at_phases)), key=lambda k: at_phases[k][1])
        wanted, gain = at_phases[best]
        found.append(Shaped({periods: float(number), turn: float(_FINE_PHASES[best])}, first * wanted, gain))
    return sorted(found, key=lambda one: -one.score)[:_FINE_KEPT]


def _same_periods(effect: Effect, actuator: Actuator, shape: Mapping[str, float]) -> bool:
    name = f"{effect.name}.periods"
    return all(abs(value - actuator[name]) < 1e-6 for key, value in shape.items() if key.endswith(name))


def _turned(effect: Effect, actuator: Actuator, change: Shaped) -> tuple[Mapping[str, float], tuple[tuple[float, ...], ...]]:
    """Shape and size of a periodic effect that is there already and changes in amplitude and phase."""
    phase = f"{effect.name}.phase_rad"
    both = actuator[effect.size.name] * np.exp(1j * actuator[phase]) + change.size * np.exp(1j * change.shape[f"effects.{phase}"])
    return {**change.shape, f"effects.{phase}": float(np.angle(both))}, _apart(
        (float(np.clip(abs(both), effect.size.lower, effect.size.upper)),)
    )


def candidates(screen: Screen, without: Collection[str] = (), only: Collection[str] | None = None) -> list[Candidate]:
    """Every effect in every shape that is tried, a change of those that the actuator holds already among them; and the fault parameters. `only`: of these effects."""
    view = screen.view
    evidence = view.evidence
    found = []
    scattering = {name for one in evidence.spread for name in one.names} if not evidence.relative else set()
    for fault, value in FAULTS.items():
        nominal = evidence.actuator[value]
        if fault not in without and (only is None or fault in only) and nominal > 0.0 and value not in scattering:
            found.append(
                Candidate(fault, value, {}, _ladders(0.0, 20.0 * nominal, nominal, _LADDER[:3]), 0.05 * nominal, 20.0 * nominal, nominal)
            )
    wanted = [effect for effect in load_definitions().physical if effect.name not in without and (only is None or effect.name in only)]
    screen.look([effect.name for effect in wanted])
    return [*found, *itertools.chain.from_iterable(each(lambda effect: _of_effect(effect, view, screen), wanted))]


def _gain(product: float, square: float) -> tuple[float, float]:
    """How far the size should be scaled, and the cost that it then takes off, by what is left of a sensitivity: its product with the residual and its squared length."""
    if not square > 0.0:
        return 0.0, 0.0
    share = product / square
    kept = float(np.clip(share, 0.0, 2.0))
    return share, 2.0 * kept * product - kept * kept * square


def _matched(candidate: Candidate, ladder: Sequence[float]) -> _Asking[Signature | None]:
    """The candidate at the size that explains most. A larger first size is tried only where a smaller one does not show beside what scatters: what shows is scaled."""
    best: Signature | None = None
    for first in ladder:
        found = yield from _scaled(candidate, first)
        if found is not None and (best is None or found[0].score > best.score):
            best = found[0]
        if found is None or found[1]:
            break
    return best


def _scaled(candidate: Candidate, first: float) -> _Asking[tuple[Signature, bool] | None]:
    """The candidate at the best of the sizes that lead on from `first`, and whether it showed there or they came to an end; None where the model refuses it."""
    best: Signature | None = None
    shows = False
    record = record_of(candidate.effect)
    size, power = first, record.power
    earlier: tuple[float, float] | None = None
    for place in range(_SCALINGS if record.below_peak is None else 1):
        shown = yield candidate.changes(size)
        if isinstance(shown, InputError):
            break
        square, product = shown.square, shown.with_residual()
        share, gain = _gain(product, square)
        score = gain - penalty([candidate.effect])
        if best is None or score > best.score:
            best = Signature(candidate, size, shown, score)
        whole = float(shown.vector @ shown.vector)
        beside_scatter = square > _SHOWN_SHARE * whole
        if place == 0:
            shows = whole > ROUGHNESS**2 and beside_scatter
            if product * product < _NOTHING * square:
                # what bends may show at a larger size
                shows = False
                break
        if share <= 0.0 or abs(share - 1.0) < 0.2:
            # where it shows, a larger first size would lead here again; where what scatters hides nearly all of it, perhaps not
            shows = shows or (share > 0.0 and beside_scatter)
            break
        reach, length = abs(size - candidate.zero), float(np.sqrt(max(square, 1e-300)))
        if earlier is not None and reach != earlier[0]:
            # a stretch grows with the square of its period, a play not at all before it is left
            power = float(np.clip(np.log(length / earlier[1]) / np.log(reach / earlier[0]), *_POWERS))
        earlier = (reach, length)
        factor = float(np.clip(share, *_FACTORS)) ** (1.0 / power)
        wanted = float(np.clip(candidate.zero + (size - candidate.zero) * factor, candidate.lower, candidate.upper))
        if wanted == size:
            break
        size = wanted
    return None if best is None else (best, shows)


def promising(screen: Screen, earlier: Sequence[Signature], least: float) -> tuple[str, ...]:
    """Effects that may lower the cost by a good part of `least`, judged without simulating them: by the signatures that they had before another effect was added, and by
    torque patterns. A simulation beside an effect that is hard to compute costs ten times as much."""
    view = screen.view
    guessed: dict[str, float] = {}
    places = {id(one.view): one.view for one in earlier}
    meets = {place: (there.shared(view.residual), view.overlap(there)) for place, there in places.items()}
    for signature in earlier:
        name = signature.candidate.effect
        product, length = signature.shown.seen_from(view, *meets[id(signature.view)])
        if length > 0.0 and (product > 0.0 or signature.candidate.lower < signature.candidate.zero):
            guessed[name] = max(guessed.get(name, 0.0), product * product / length)
    effects = load_definitions().physical
    for effect, shaped in zip(effects, screen.look([effect.name for effect in effects]), strict=True):
        if shaped:
            guessed[effect.name] = max(guessed.get(effect.name, 0.0), shaped[0].score)
    kept = sorted((name for name, score in guessed.items() if score > _PROMISING_SHARE * least), key=lambda name: -guessed[name])
    return tuple(kept[:_PROMISING_MAX])


def signatures(screen: Screen, without: Collection[str] = (), only: Collection[str] | None = None) -> list[Signature]:
    """The best-matched signature of every candidate beside what the screen's view holds already, or of `only` these effects, strongest first. All of them side by side."""
    tasks = [(candidate, ladder) for candidate in candidates(screen, without, only) for ladder in candidate.ladders]
    found = in_step([_matched(candidate, ladder) for candidate, ladder in tasks], screen.view.sensitivities)
    return sorted((signature for signature in found if signature is not None), key=lambda signature: -signature.score)
