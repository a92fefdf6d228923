"""The answer of `ema next` on the terminal."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console
from rich.text import Text

from ema_tools.results.detection import DetectionResult, SightEntry
from ema_tools.results.experiment import Experiment
from ema_tools.words.sentences.experiment import limits
from ema_tools.words.terminal.console import number, table

_SHOWN, _LONGER = 8, 4  # safe commands, and those among them that take longer than the present one [layout]


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


def print_detection(console: Console, found: DetectionResult) -> None:
    """What the present ground test sees, and the best safe ones beside it."""
    console.print(Text(found.sentence))
    console.print()
    names = list(found.present.onboard)
    rows = table(
        f"Smallest shifts that are found, {' / '.join(name.upper() for name in names)}, % of healthy",
        "command",
        "each alone",
        "both together",
        "all signals",
        "today",
        "",
    )
    rows.columns[0].no_wrap = True

    def pair(values: Iterable[float]) -> str:
        return " / ".join(number(value, 2) for value in values)

    def add(one: SightEntry, note: str) -> None:
        rows.add_row(
            f"{one.command.partition(':')[0]} {_numbers(one.command)}, {one.duration_s:g} s",
            pair(one.onboard[name].alone for name in names),
            pair(one.onboard[name].together for name in names),
            pair(one.signals[name].alone for name in names),
            pair(one.onboard[name].today for name in names),
            note,
        )

    add(found.present, "now")
    longer = [one for one in found.options if one.duration_s > found.present.duration_s]
    for one in [one for one in found.options if one not in longer][:_SHOWN] + longer[:_LONGER]:
        add(one, "better" if found.best == one else "serves" if one.could_replace else "")
    console.print(rows)
    console.print(
        Text(
            f"Alone and together by the rod position, as onboard; all signals: by the best use of {', '.join(found.channels)}, each value alone; today: how far the "
            "onboard reading moves besides for what the machine may be today without anybody knowing (winding, grease, magnets, supply, gain; one standard deviation). A command serves that is "
            "no longer than the present one and hangs no more on that."
        )
    )
    console.print(Text(f"Safe is {limits(found.limits)}. {len(found.options)} commands are; {len(found.unsafe)} were left out."))
