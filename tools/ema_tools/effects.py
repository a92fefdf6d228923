"""The library of optional effects: what `ema effects` shows."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from ema_tools.actuator import nearest
from ema_tools.console import table
from ema_tools.definitions import Effect, load_definitions
from ema_tools.errors import InputError
from ema_tools.signatures import signature_of

SITES = {
    "PARAMETER": "changes parameters",
    "FRICTION": "level of dry friction",
    "TORQUE": "torque on the shaft",
    "LOAD": "load against extension",
    "VOLTAGE": "motor voltage",
    "MOTOR": "torque constant and back-EMF",
    "PRESLIDING": "contact before it slides",
    "TRANSMISSION": "between play and rod",
    "READING": "rod sensor's reading",
}


def find_effect(name: str) -> Effect:
    """The effect called `name`. Raises InputError with the nearest name."""
    known = {effect.name: effect for effect in load_definitions().effects}
    if name not in known:
        raise InputError(f"effect {name}: unknown{nearest(name, known)}: effects are {', '.join(known)}")
    return known[name]


def describe(effect: Effect) -> dict[str, Any]:
    """Everything about an effect, for JSON."""
    return {
        "name": effect.name,
        "acts_on": SITES.get(effect.site, effect.site.lower()),
        "learned": effect.is_learned,
        "own": effect.is_own,
        "equation": effect.equation,
        "source": effect.source,
        "signature": signature_of(effect.name),
        "look_alikes": list(effect.look_alikes),
        "parameters": [
            {
                "field": row.field,
                "unit": row.unit,
                "zero": row.nominal if row is effect.size else None,
                "nominal": row.nominal,
                "lower": row.lower,
                "upper": row.upper,
                "text": row.text,
            }
            for row in effect.parameters
        ],
    }


def print_all(console: Console) -> None:
    """One line per effect."""
    shown = table("Effects that an actuator file may enable as \\[effects.<name>]", "effect", "acts on", "equation", text_columns=3)
    for effect in load_definitions().effects:
        shown.add_row(effect.name, SITES.get(effect.site, effect.site.lower()), effect.equation)
    console.print(shown)


def print_one(console: Console, effect: Effect) -> None:
    """One effect with its parameters."""
    console.print(f"[bold]{effect.name}[/bold]: {effect.equation}", highlight=False)
    console.print(f"acts on: {SITES.get(effect.site, effect.site.lower())}")
    if effect.is_learned:
        console.print(
            "learned: no physical effect but a table; it says what was seen from first to last, and the edge value is held outside"
        )
    console.print(f"signature: {signature_of(effect.name)}", highlight=False)
    console.print(f"source: {effect.source}")
    console.print(f"look-alikes: {', '.join(effect.look_alikes) or 'none known'}")
    shown = table(f"\\[effects.{effect.name}]", "parameter", "meaning", "unit", "zero", "lower", "upper", text_columns=3)
    for row in effect.parameters:
        zero = f"{row.nominal:g}" if row is effect.size else ""
        shown.add_row(row.field, row.text, row.unit, zero, f"{row.lower:g}", f"{row.upper:g}")
    console.print(shown)
