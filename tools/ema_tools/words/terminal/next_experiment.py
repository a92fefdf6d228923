"""The answer of `ema next` on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.results.experiment import Experiment
from ema_tools.words.sentences.experiment import limits
from ema_tools.words.terminal.console import number, table


def _numbers(command: str) -> str:
    """The numbers of a command of the menu in short, a command of the user's as it is."""
    _, _, text = command.partition(":")
    given = dict(part.split("=", 1) for part in text.split(",") if "=" in part)
    if "amplitude_mm" not in given:
        return command
    ends = "-".join(given[name] for name in ("start_hz", "end_hz") if name in given)
    return f"{given['amplitude_mm']} mm" + (f", {ends} Hz" if ends else "")


def print_next(console: Console, found: Experiment) -> None:
    """The answer on the terminal: the sentence, the menu, what was left out."""
    console.print(Text(found.sentence))
    console.print()
    many = len(found.effects) > 2
    heads = ("worst pair",) if many else ()
    rows = table(
        "Separation, standard deviations",
        "command",
        "numbers",
        *heads,
        "apart",
        *(() if many else (f"shows {effect}" for effect in found.effects)),
        text_columns=3 if many else 2,
    )
    for option in found.options:
        worst = (" / ".join(min(option.pairs, key=lambda pair: pair.separation).effects),) if many else ()
        visible = () if many else (number(option.shown[effect], 3) for effect in found.effects)
        rows.add_row(option.title, _numbers(option.command), *worst, number(option.separation, 3), *visible)
    console.print(rows)
    sizes = "; ".join(
        f"{effect} {', '.join(f'{name} = {value:.4g}' for name, value in values.items())}" for effect, values in found.sizes.items()
    )
    console.print(Text(f"Sizes: {sizes}. Recorded: {', '.join(found.channels)}."))
    console.print(Text(f"Safe is {limits(found.limits)}."))
    for command, reason in found.unsafe.items():
        console.print(Text(f"Left out: {command}: it {reason}." if not reason.startswith("with ") else f"Left out: {command}: {reason}."))
