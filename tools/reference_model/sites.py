"""Where effects act: all active effects of one site behind one function.

The functions are folded together once, from the modules that `effects` finds; an effect at its zero is not called.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ema_tools.base.compiled import compiled
from ema_tools.library.definitions import project_definitions
from reference_model.effects import module_of
from reference_model.point import Point

_ROWS = project_definitions().effects
EFFECT_MEMORY = sum(effect.memory for effect in _ROWS)
FIRST_MEMORY = 3  # current, speed and angle stand before it


def _rows(site: str) -> list[tuple[int, float, int, Any]]:
    """Place in the list, zero, place of its memory and module, of every effect of `site`."""
    found = []
    memory = FIRST_MEMORY
    for place, effect in enumerate(_ROWS):
        if effect.site == site:
            found.append((place, effect.size.nominal, memory, module_of(effect.name)))
        memory += effect.memory
    return found


def _add_level(first: Any, place: int, zero: float, function: Any) -> Any:
    @compiled
    def both(effects: Any, level_Nm: float, point: Point) -> float:
        total = first(effects, level_Nm, point)
        if effects[place][0] != zero:
            total += function(effects[place], level_Nm, point)
        return total

    return both


def _add_at_point(first: Any, place: int, zero: float, function: Any) -> Any:
    @compiled
    def both(effects: Any, point: Point) -> float:
        total = first(effects, point)
        if effects[place][0] != zero:
            total += function(effects[place], point)
        return total

    return both


def _sum_at_point(site: str, function: str) -> Callable[..., float]:
    @compiled
    def total(effects: Any, point: Point) -> float:
        return 0.0

    for place, zero, _, module in _rows(site):
        total = _add_at_point(total, place, zero, getattr(module, function))
    return total


def _sum_of_levels() -> Callable[..., float]:
    @compiled
    def total(effects: Any, level_Nm: float, point: Point) -> float:
        return 0.0

    for place, zero, _, module in _rows("FRICTION"):
        total = _add_level(total, place, zero, module.level_change_Nm)
    return total


friction_change_Nm = _sum_of_levels()
extra_torque_Nm = _sum_at_point("TORQUE", "torque_Nm")
extra_load_Nm = _sum_at_point("LOAD", "load_Nm")
voltage_change_V = _sum_at_point("VOLTAGE", "voltage_change_V")
motor_change = _sum_at_point("MOTOR", "motor_change")
extra_reading_mm = _sum_at_point("READING", "reading_mm")


def _add_contact(first: Any, place: int, zero: float) -> Any:
    @compiled
    def both(effects: Any) -> bool:
        return effects[place][0] != zero or first(effects)

    return both


def _add_share(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray) -> float:
        if effects[place][0] != zero:
            return function(effects[place], memory[at])
        return first(effects, memory)

    return both


def _add_stretch(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, speed_rad_s: float, direction: int, lead_mm_per_rad: float, out: np.ndarray) -> None:
        first(effects, memory, speed_rad_s, direction, lead_mm_per_rad, out)
        if effects[place][0] != zero:
            out[at] = speed_rad_s * function(effects[place], memory[at], direction, lead_mm_per_rad)

    return both


def _add_contact_rate(first: Any, place: int, zero: float, function: Any) -> Any:
    @compiled
    def both(effects: Any, level_per_inertia: float, speed_rad_s: float, lead_mm_per_rad: float) -> float:
        fastest = first(effects, level_per_inertia, speed_rad_s, lead_mm_per_rad)
        if effects[place][0] != zero:
            fastest = max(fastest, function(effects[place], level_per_inertia, speed_rad_s, lead_mm_per_rad))
        return fastest

    return both


def _contacts() -> tuple[Callable[..., Any], ...]:
    @compiled
    def elastic(effects: Any) -> bool:
        return False

    @compiled
    def share(effects: Any, memory: np.ndarray) -> float:
        return 0.0

    @compiled
    def rates(effects: Any, memory: np.ndarray, speed_rad_s: float, direction: int, lead_mm_per_rad: float, out: np.ndarray) -> None:
        pass

    @compiled
    def fastest(effects: Any, level_per_inertia: float, speed_rad_s: float, lead_mm_per_rad: float) -> float:
        return 0.0

    # of several contacts the first of the list is felt
    for place, zero, at, module in reversed(list(_rows("PRESLIDING"))):
        elastic = _add_contact(elastic, place, zero)
        share = _add_share(share, place, zero, at, module.share)
        rates = _add_stretch(rates, place, zero, at, module.slope_per_rad)
        fastest = _add_contact_rate(fastest, place, zero, module.fastest_rate_per_s)
    return elastic, share, rates, fastest


is_elastic, contact_share, contact_rates, contact_rate_per_s = _contacts()


def _add_change(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray) -> float:
        total = first(effects, memory)
        if effects[place][0] != zero:
            total += function(effects[place], memory[at])
        return total

    return both


def _changes(site: str) -> Callable[..., float]:
    @compiled
    def total(effects: Any, memory: np.ndarray) -> float:
        return 0.0

    for place, zero, at, module in _rows(site):
        total = _add_change(total, place, zero, at, module.change)
    return total


def _add_warmth(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, heat_W: float, out: np.ndarray) -> None:
        first(effects, memory, heat_W, out)
        if effects[place][0] != zero:
            out[at] = function(effects[place], memory[at], heat_W)

    return both


def _warmths() -> Callable[..., None]:
    @compiled
    def rates(effects: Any, memory: np.ndarray, heat_W: float, out: np.ndarray) -> None:
        pass

    for place, zero, at, module in (*_rows("WINDING"), *_rows("GREASE")):
        rates = _add_warmth(rates, place, zero, at, module.rate_per_s)
    return rates


winding_change = _changes("WINDING")
grease_change = _changes("GREASE")
warmth_rates = _warmths()


def _add_inertia(first: Any, place: int, zero: float, function: Any) -> Any:
    @compiled
    def both(effects: Any, inertia_kgm2: float, lead_m_per_rad: float) -> float:
        left = first(effects, inertia_kgm2, lead_m_per_rad)
        if effects[place][0] != zero:
            left = function(effects[place], left, lead_m_per_rad)
        return left

    return both


def _add_rest(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, start_mm: float) -> None:
        first(effects, memory, start_mm)
        if effects[place][0] != zero:
            function(effects[place], memory, at, start_mm)

    return both


def _add_reaction(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float, lead_m_per_rad: float) -> float:
        total = first(effects, memory, play_mm, play_mm_s, lead_m_per_rad)
        if effects[place][0] != zero:
            total += function(effects[place], memory, at, play_mm, play_mm_s, lead_m_per_rad)
        return total

    return both


def _add_rates(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float, out: np.ndarray) -> None:
        first(effects, memory, play_mm, play_mm_s, out)
        if effects[place][0] != zero:
            function(effects[place], memory, at, play_mm, play_mm_s, out)

    return both


def _add_rod(first: Any, place: int, zero: float, at: int, function: Any) -> Any:
    @compiled
    def both(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float) -> tuple[float, float]:
        if effects[place][0] != zero:
            return function(effects[place], memory, at)
        return first(effects, memory, play_mm, play_mm_s)

    return both


def _add_rate(first: Any, place: int, zero: float, function: Any) -> Any:
    @compiled
    def both(effects: Any, shaft_inertia: float, lead_m_per_rad: float) -> float:
        fastest = first(effects, shaft_inertia, lead_m_per_rad)
        if effects[place][0] != zero:
            fastest = max(fastest, function(effects[place], shaft_inertia, lead_m_per_rad))
        return fastest

    return both


def _transmissions() -> tuple[Callable[..., Any], ...]:
    @compiled
    def inertia(effects: Any, inertia_kgm2: float, lead_m_per_rad: float) -> float:
        return inertia_kgm2

    @compiled
    def start(effects: Any, memory: np.ndarray, start_mm: float) -> None:
        pass

    @compiled
    def reaction(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float, lead_m_per_rad: float) -> float:
        return 0.0

    @compiled
    def rates(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float, out: np.ndarray) -> None:
        pass

    @compiled
    def rod(effects: Any, memory: np.ndarray, play_mm: float, play_mm_s: float) -> tuple[float, float]:
        return play_mm, play_mm_s

    @compiled
    def fastest(effects: Any, shaft_inertia: float, lead_m_per_rad: float) -> float:
        return 0.0

    for place, zero, at, module in _rows("TRANSMISSION"):
        inertia = _add_inertia(inertia, place, zero, module.shaft_inertia_kgm2)
        start = _add_rest(start, place, zero, at, module.rest)
        reaction = _add_reaction(reaction, place, zero, at, module.reaction_Nm)
        rates = _add_rates(rates, place, zero, at, module.rates)
        rod = _add_rod(rod, place, zero, at, module.rod)
        fastest = _add_rate(fastest, place, zero, module.fastest_rate_per_s)
    return inertia, start, reaction, rates, rod, fastest


(
    shaft_inertia_kgm2,
    rest_transmission,
    transmission_reaction_Nm,
    transmission_rates,
    rod_behind_play,
    transmission_rate_per_s,
) = _transmissions()
