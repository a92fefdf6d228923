"""Which shapes of a torque on the shaft fit the residual: hundreds tried in a fraction of a second, before any of them is simulated.

While the machine slides it is linear in a small torque. Its response to one is found by simulating the model without friction and play at rest; filtered by it, the
residual becomes a time series whose product with a torque pattern says how much the pattern explains (a matched filter). It only chooses shapes: what is reported comes from
simulations of the whole model.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ema_tools.base.arrays import Complexes, Reals
from ema_tools.base.errors import InputError
from ema_tools.base.parallel import each
from ema_tools.fit.evidence import Evidence, View
from ema_tools.fit.whitening import counted, frequencies, lines_of, spectrum
from ema_tools.library.registry import record_of
from ema_tools.library.torques import LocalTorque, PeriodicTorque, Shape, States, combined, values_in
from ema_tools.plant.native import library

_PROBE_SHARE = 0.02  # of the friction level: far below any saturation, far above rounding [precision]
# What makes the model linear, so that its answer to a torque is a filter [physics]
_SMOOTH: Mapping[str, float] = {
    "screw.csj_Nm": 0.0,
    "screw.blk_mm": 0.0,
    "screw.load_torque_Nm": 0.0,
    "screw.friction_asymmetry": 0.0,
    "gearbox.efficiency": 1.0,
}
_QUARTERS = (
    0.5 * np.pi,
    np.pi,
    -0.5 * np.pi,
)  # the other phases at which what holds at rest is tried: it need not stand where it slides [physics]
_AT_ONCE = 16  # patterns of one sign whose lines are found together: they fit the fast memory [effort]
_KEPT = 3  # shapes that go on to simulation. One whose neighbour is close in score and was kept adds nothing [effort]


@dataclass(frozen=True)
class Shaped:
    """A shape of an effect: the size that fits best, and by how much it lowers the cost; a guess."""

    shape: Shape
    size: float
    score: float


class Screen:
    """The matched filter of one view."""

    def __init__(self, view: View) -> None:
        evidence = view.evidence
        self.view = view
        self.actuator = evidence.actuator.changed(dict(view.values))
        self.states = _states(evidence, view)
        response = _response(evidence)
        self._response = response
        self._residual = view.unwhitened()
        self._weights = evidence.whiten.weights**2
        self._filtered = np.sum(np.conj(response) * self._residual, axis=0)
        self._power = np.sum(np.abs(response) ** 2 * self._weights, axis=0)
        self._shapes: dict[str, list[Shaped] | None] = {}
        self._waves: dict[tuple[Callable[[States], Reals], int], Reals] = {}

    def look(self, effects: Sequence[str]) -> list[list[Shaped] | None]:
        """`shapes_of` each of several effects, on all cores."""
        periodic = [one for effect in effects if effect not in self._shapes and (one := record_of(effect).periodic) is not None]
        asked = Counter((one.angle, number) for one in periodic for number in one.periods or (1,))
        shared = [key for key, count in asked.items() if count > 1 and key not in self._waves]
        self._waves |= zip(shared, each(lambda key: self._wave(*key), shared), strict=True)
        return each(self.shapes_of, effects)

    def shapes_of(self, effect: str) -> list[Shaped] | None:
        """The shapes of an effect that the residual suggests, best first; None for an effect whose shapes are not a matter of torque patterns. Found once."""
        if effect not in self._shapes:
            record = record_of(effect)
            if record.periodic is not None:
                self._shapes[effect] = self.periodic(effect, record.periodic)
            else:
                self._shapes[effect] = self.local(effect, record.local) if record.local is not None else None
        return self._shapes[effect]

    def fits(self, patterns: Reals) -> tuple[Reals, float]:
        """Sizes [k] of torque patterns [k, rows] that together explain most, and by how much they lower the cost."""
        lines = spectrum(patterns)
        products = np.real(np.conj(lines) @ self._filtered)
        square = np.real((np.conj(lines) * self._power) @ lines.T)
        return _solved(square, products)

    def fits_with_voltage(self, torques: Reals, voltages: Reals) -> tuple[Reals, float]:
        """The same for patterns that are a torque and a voltage in the winding at once, [k, rows] each: the current that the voltage drives is seen, and is a torque too."""
        actuator = self.actuator
        currents = spectrum(voltages) / self._impedance
        lines = (spectrum(torques) + actuator["motor.torque_constant_Nm_per_A"] * currents)[:, None, :] * self._response
        if "current_A" in self.view.evidence.channels:
            lines[:, self.view.evidence.channels.index("current_A")] += currents
        flat = lines.reshape(len(lines), -1)
        turned = np.conj(flat)
        products = np.real(turned @ self._residual.ravel())
        square = np.real((turned * self._weights.ravel()) @ flat.T)
        return _solved(square, products)

    @cached_property
    def _impedance(self) -> Complexes:
        """Of the winding, [lines]; without end where the drive holds the current."""
        if self.actuator["drive.mode"] != 0.0:
            return np.full(self._power.size, np.inf + 0.0j)
        evidence = self.view.evidence
        pulsation = 2.0 * np.pi * frequencies(evidence.record.rows, evidence.record.period_s)
        return np.asarray(self.actuator["motor.resistance_ohm"] + 1j * pulsation * self.actuator["motor.inductance_H"])

    def _level(self, of_level: bool) -> float:
        """What a size of one stands for, Nm."""
        return self.actuator["screw.csj_Nm"] * self.actuator["screw.dynamic_ratio"] if of_level else 1.0

    def local(self, effect: str, one: LocalTorque) -> list[Shaped]:
        """The best shapes of a torque of one sign, best first."""
        found = []
        level = self._level(one.of_level)
        shapes = combined(values_in(one.tried, self.states))
        for first in range(0, len(shapes), _AT_ONCE):
            some = shapes[first : first + _AT_ONCE]
            lines = spectrum(np.array([level * one.torque(self.states, shape) for shape in some]))
            products = np.real(np.conj(lines) @ self._filtered)
            squares = (lines.real**2 + lines.imag**2) @ self._power
            for shape, product, square in zip(some, products, squares, strict=True):
                if product > 0.0 and square > 0.0:
                    named = {f"effects.{effect}.{field}": value for field, value in shape.items()}
                    found.append(Shaped(named, float(product / square), float(product * (product / square))))
        return sorted(found, key=lambda one: -one.score)[:_KEPT]

    def _wave(self, angle: Callable[[States], Reals], number: int) -> Reals:
        """Sine and cosine of so many periods per turn of an angle, [2, rows]."""
        angle_rad = angle(self.states)
        turned = number * angle_rad
        # what the ripple leaves of itself over a row
        mean = np.sinc(number * np.gradient(angle_rad) / (2.0 * np.pi))
        return np.array([mean * np.sin(turned), mean * np.cos(turned)])

    def periodic(self, effect: str, one: PeriodicTorque) -> list[Shaped]:
        """The best numbers of periods per turn with their amplitude and phase, best first."""
        found = []
        torque = self._level(one.of_level) * one.torque(self.states)
        voltage = one.voltage(self.states) if one.voltage is not None else None
        for number in one.periods or (1,):
            known = self._waves.get((one.angle, number))
            waves = known if known is not None else self._wave(one.angle, number)
            (in_phase, quadrature), score = (
                self.fits(torque * waves) if voltage is None else self.fits_with_voltage(torque * waves, voltage * waves)
            )
            phase = np.arctan2(-in_phase, quadrature) if one.cosine else np.arctan2(quadrature, in_phase)
            shape = {f"effects.{effect}.phase_rad": float(phase)} | ({f"effects.{effect}.periods": float(number)} if one.periods else {})
            found.append(Shaped(shape, float(np.hypot(in_phase, quadrature)), score))
        best = sorted(found, key=lambda one: -one.score)[:_KEPT]
        return [*best, *_turned(effect, best)] if one.holds_at_rest else best


def _turned(effect: str, found: Sequence[Shaped]) -> list[Shaped]:
    """The same shapes at phases by quarters of a turn away."""
    phase = f"effects.{effect}.phase_rad"
    return [
        replace(one, shape={**one.shape, phase: float(np.angle(np.exp(1j * (one.shape[phase] + quarter))))})
        for quarter in _QUARTERS
        for one in found
    ]


def _solved(square: Reals, products: Reals) -> tuple[Reals, float]:
    sizes = np.asarray(np.linalg.lstsq(square, products, rcond=1e-9)[0], dtype=float)
    return sizes, float(sizes @ products)


def _states(evidence: Evidence, view: View) -> States:
    model = evidence.actuator.changed(dict(view.values))
    values, options = model.arrays()
    run = library(32).simulate(values, options, evidence.record.command_mm, evidence.start_mm)
    angle = run.motor_position_mm / model.lead_mm_per_rad
    middle = _between_rows(angle)
    # of dozens of periods per turn the model without them loses count
    moved = dict(zip(evidence.channels, evidence.target, strict=True)).get("motor_position_mm")
    turned = middle if moved is None else _between_rows(moved / model.lead_mm_per_rad)
    speed = np.append(np.diff(angle), 0.0) / evidence.record.period_s
    slow = 1e-3 * float(np.max(np.abs(speed), initial=0.0))
    direction = np.where(np.abs(speed) > slow, np.sign(speed), 0.0)
    return States(
        direction,
        speed,
        turned,
        turned / model["gearbox.ratio"],
        middle * model.lead_mm_per_rad,
        run.current_A,
        evidence.record.period_s * np.arange(angle.size, dtype=np.float64),
        model["motor.torque_constant_Nm_per_A"],
        model["motor.back_emf_V_s_per_rad"],
        model["screw.csj_Nm"] * model["screw.dynamic_ratio"],
        model["screw.viscous_Nm_s_per_rad"],
    )


def _between_rows(values: Reals) -> Reals:
    """The mean of a row and the next: patterns act between rows."""
    return np.asarray(0.5 * (values + np.append(values[1:], values[-1])))


def _response(evidence: Evidence) -> Complexes:
    """Lines [channels, lines] of the linear machine's answer to a torque of 1 Nm on its shaft during one row."""
    actuator = evidence.actuator
    probe = _PROBE_SHARE * max(actuator["screw.csj_Nm"], 1e-3)
    still = np.zeros(evidence.record.rows)
    try:
        values, options = actuator.changed({**_SMOOTH, "screw.load_torque_Nm": -probe}).arrays()
        run = library(64).simulate(values, options, still, 0.0)
    except InputError:
        return np.zeros((len(evidence.channels), lines_of(still.size)), dtype=np.complex128)
    steps = np.array([getattr(run, name) for name in evidence.channels]) / probe
    pulses = np.diff(steps, axis=1, prepend=0.0)
    # the answer dies away long before the record ends: what does not is the drift of a free position and is not of use here
    return np.asarray(spectrum(pulses) * np.sqrt(counted(still.size)))
