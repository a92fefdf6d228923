"""Which shapes of a torque on the shaft fit the residual: hundreds tried in a fraction of a second, before any of them is simulated.

While the machine slides it is linear in a small torque. Its response to one is found by simulating the model without friction and play at rest; filtered by it, the
residual becomes a time series whose product with a torque pattern says how much the pattern explains (a matched filter). It only chooses shapes: what is reported comes from
simulations of the whole model.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy import fft

from ema_tools.base.arrays import Complexes, Reals
from ema_tools.base.errors import InputError
from ema_tools.fit.evidence import Evidence, View
from ema_tools.fit.whitening import spectrum
from ema_tools.plant.native import library

_PROBE_SHARE = 0.02  # of the friction level: far below any saturation
_SMOOTH: Mapping[str, float] = {
    "screw.csj_Nm": 0.0,
    "screw.blk_mm": 0.0,
    "screw.load_torque_Nm": 0.0,
    "screw.friction_asymmetry": 0.0,
    "gearbox.efficiency": 1.0,
}
COGGING_PERIODS = (*range(1, 61), 64, 66, 72, 78, 80, 84, 90, 96, 108, 120, 126, 132, 144, 156, 168, 180)
RIPPLE_PERIODS = tuple(range(1, 49))
_STRIBECK_SPEEDS = (2.0, 4.0, 7.0, 12.0, 20.0, 32.0, 50.0)
_STRIBECK_SHAPES = (1.0, 2.0)
_JAM_WIDTHS = (0.06, 0.12, 0.25, 0.5, 1.0)
_JAM_PLACES = 61
_QUARTERS = (0.5 * np.pi, np.pi, -0.5 * np.pi)
# A shape whose neighbour is this close in score and was kept adds nothing.
_KEPT = 3

Shape = Mapping[str, float]


@dataclass(frozen=True)
class States:
    """The model's run, each [rows]: what torque patterns depend on."""

    direction: Reals
    speed_rad_s: Reals
    angle_rad: Reals
    screw_mm: Reals
    current_A: Reals


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
        products = np.real(np.einsum("kcl,cl->k", np.conj(lines), self._residual))
        square = np.real(np.einsum("kcl,cl,mcl->km", np.conj(lines), self._weights, lines))
        return _solved(square, products)

    @property
    def _impedance(self) -> Complexes:
        """Of the winding, [lines]; without end where the drive holds the current."""
        if self.actuator["drive.mode"] != 0.0:
            return np.full(self._power.size, np.inf + 0.0j)
        evidence = self.view.evidence
        pulsation = 2.0 * np.pi * fft.rfftfreq(evidence.record.rows, evidence.record.period_s)
        return np.asarray(self.actuator["motor.resistance_ohm"] + 1j * pulsation * self.actuator["motor.inductance_H"])

    def best(self, shapes: list[Shape], pattern: Callable[[Shape], Reals], positive: bool, count: int = _KEPT) -> list[Shaped]:
        """The `count` best shapes of one pattern each, best first."""
        found = []
        for shape in shapes:
            sizes, score = self.fits(pattern(shape)[None, :])
            if not (positive and sizes[0] <= 0.0):
                found.append(Shaped(shape, float(sizes[0]), score))
        return sorted(found, key=lambda one: -one.score)[:count]

    def periodic(
        self,
        effect: str,
        periods: tuple[float, ...],
        angle_rad: Reals,
        torque: Reals,
        voltage: Reals | None,
        sine: bool,
        count: int = _KEPT,
    ) -> list[Shaped]:
        """The `count` best numbers of periods per turn of `angle_rad`, with amplitude and phase of torque * sin (or cos) (periods * angle + phase), and the same of a voltage."""
        found = []
        turn = np.gradient(angle_rad)
        for number in periods:
            turned = number * angle_rad
            # what the ripple leaves of itself over a row
            mean = np.sinc(number * turn / (2.0 * np.pi))
            waves = np.array([mean * np.sin(turned), mean * np.cos(turned)])
            (in_phase, quadrature), score = (
                self.fits(torque * waves) if voltage is None else self.fits_with_voltage(torque * waves, voltage * waves)
            )
            phase = np.arctan2(quadrature, in_phase) if sine else np.arctan2(-in_phase, quadrature)
            shape = {f"effects.{effect}.phase_rad": float(phase)} | (
                {f"effects.{effect}.periods": float(number)} if len(periods) > 1 else {}
            )
            found.append(Shaped(shape, float(np.hypot(in_phase, quadrature)), score))
        return sorted(found, key=lambda one: -one.score)[:count]


def _solved(square: Reals, products: Reals) -> tuple[Reals, float]:
    sizes = np.asarray(np.linalg.lstsq(square, products, rcond=1e-9)[0], dtype=float)
    return sizes, float(sizes @ products)


def _states(evidence: Evidence, view: View) -> States:
    model = evidence.actuator.changed(dict(view.values))
    values, options = model.arrays()
    run = library(32).simulate(values, options, evidence.record.command_mm, evidence.start_mm)
    angle = run.motor_position_mm / model.lead_mm_per_rad
    middle = _between_rows(angle)
    measured = evidence.record.motor_position_mm
    # of dozens of periods per turn the model without them loses count; against repeats, which have the same standing errors, it does not
    turned = middle if measured is None or evidence.relative else _between_rows(measured / model.lead_mm_per_rad)
    speed = np.append(np.diff(angle), 0.0) / evidence.record.period_s
    slow = 1e-3 * float(np.max(np.abs(speed), initial=0.0))
    direction = np.where(np.abs(speed) > slow, np.sign(speed), 0.0)
    return States(direction, speed, turned, middle * model.lead_mm_per_rad, run.current_A)


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
        return np.zeros((len(evidence.channels), still.size // 2 + 1), dtype=np.complex128)
    steps = np.array([getattr(run, name) for name in evidence.channels]) / probe
    pulses = np.diff(steps, axis=1, prepend=0.0)
    # the answer dies away long before the record ends: what does not is the drift of a free position and is not of use here
    return np.asarray(fft.rfft(pulses, axis=1))


def shapes_of(screen: Screen, effect: str) -> list[Shaped] | None:
    """The shapes of an effect that the residual suggests, best first; None for an effect whose shapes are not a matter of torque patterns."""
    states, actuator = screen.states, screen.actuator
    level = actuator["screw.csj_Nm"] * actuator["screw.dynamic_ratio"]
    if effect == "cogging_torque":
        found = screen.periodic(effect, COGGING_PERIODS, states.angle_rad, np.ones_like(states.angle_rad), None, True)
        # cogging that is large beside the friction holds the motor at rest: then the filter, which knows no rest, is right in the periods and wrong in the phase
        phase = f"effects.{effect}.phase_rad"
        turned = [
            replace(one, shape={**one.shape, phase: float(np.angle(np.exp(1j * (one.shape[phase] + quarter))))})
            for quarter in _QUARTERS
            for one in found
        ]
        return [*found, *turned]
    if effect == "torque_ripple":
        torque = actuator["motor.torque_constant_Nm_per_A"] * states.current_A
        back_emf = -actuator["motor.back_emf_V_s_per_rad"] * states.speed_rad_s
        return screen.periodic(effect, RIPPLE_PERIODS, states.angle_rad, torque, back_emf, False)
    if effect == "pitch_ripple":
        return screen.periodic(effect, (1.0,), states.angle_rad / actuator["gearbox.ratio"], -level * states.direction, None, True, 1)
    if effect == "stribeck_friction":
        names = (f"effects.{effect}.speed_rad_s", f"effects.{effect}.shape")
        grid: list[Shape] = [{names[0]: speed, names[1]: power} for speed in _STRIBECK_SPEEDS for power in _STRIBECK_SHAPES]
        return screen.best(
            grid, lambda one: -level * states.direction * np.exp(-((np.abs(states.speed_rad_s) / one[names[0]]) ** one[names[1]])), True
        )
    if effect == "jam_spot":
        names = (f"effects.{effect}.place_mm", f"effects.{effect}.width_mm")
        places = np.linspace(float(states.screw_mm.min()), float(states.screw_mm.max()), _JAM_PLACES)
        grid = [{names[0]: float(place), names[1]: width} for place in places for width in _JAM_WIDTHS]
        return screen.best(grid, lambda one: -states.direction * np.exp(-(((states.screw_mm - one[names[0]]) / one[names[1]]) ** 2)), True)
    return None
