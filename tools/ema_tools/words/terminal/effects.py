"""The library of effects on the terminal."""

from __future__ import annotations

from rich.console import Console

from ema_tools.results.effects import Effects, LibraryEffect
from ema_tools.words.terminal.console import table


def print_all(console: Console, found: Effects) -> None:
    """One line per effect."""
    shown = table("Effects that an actuator file may enable as \\[effects.<name>]", "effect", "acts on", "equation", text_columns=3)
    for effect in found.effects:
        shown.add_row(effect.name, effect.acts_on, effect.equation)
    console.print(shown)


def print_one(console: Console, effect: LibraryEffect) -> None:
    """One effect with its parameters."""
    console.print(f"[bold]{effect.name}[/bold]: {effect.equation}", highlight=False)
    console.print(f"acts on: {effect.acts_on}")
    if effect.learned:
        console.print(
            "learned: no physical effect but a table; it says what was seen from first to last, and the edge value is held outside"
        )
    console.print(f"signature: {effect.signature}", highlight=False)
    console.print(f"source: {effect.source}")
    console.print(f"look-alikes: {', '.join(effect.look_alikes) or 'none known'}")
    shown = table(f"\\[effects.{effect.name}]", "parameter", "meaning", "unit", "zero", "lower", "upper", text_columns=3)
    for row in effect.parameters:
        zero = f"{row.zero:g}" if row.zero is not None else ""
        shown.add_row(row.field, row.text, row.unit, zero, f"{row.lower:g}", f"{row.upper:g}")
    console.print(shown)
