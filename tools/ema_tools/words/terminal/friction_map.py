"""The friction map on the terminal."""

from __future__ import annotations

from rich.console import Console

from ema_tools.results.friction_map import MapResult
from ema_tools.words.sentences.friction_map import rpm
from ema_tools.words.sentences.sizes import ends_text
from ema_tools.words.terminal.console import number, table
from ema_tools.words.terminal.show import say


def print_map(console: Console, found: MapResult) -> None:
    """The sentence and the table."""
    say(console, found.sentence)
    console.print()
    rows = table("Torque at constant speed, Nm at the motor shaft", "rad/s", "rpm", "mean", "95 % interval", "band", "model", "runs", "s")
    for one in found.points:
        rows.add_row(
            number(one.speed_rad_s, 4),
            number(rpm(one.speed_rad_s), 4),
            number(one.torque_Nm, 4),
            ends_text(*one.interval95),
            f"{number(one.low_Nm, 3)} .. {number(one.high_Nm, 3)}",
            number(one.model_Nm, 4),
            str(one.runs),
            number(one.seconds, 3),
        )
    console.print(rows)
    if found.both_ways:
        console.print()
        rows = table("Both directions", "rad/s", "rpm", "friction Nm", "load Nm")
        for pair in found.both_ways:
            rows.add_row(*(number(value, 4) for value in (pair.speed_rad_s, rpm(pair.speed_rad_s), pair.friction_Nm, pair.load_Nm)))
        console.print(rows)
    for file, why in found.left_out.items():
        say(console, f"{file}: left out: {why}.")
