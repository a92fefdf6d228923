"""Packed results on the terminal."""

from __future__ import annotations

from rich.console import Console

from ema_tools.results.telemetry import Packet, TelemetryResult
from ema_tools.words.terminal.console import number, table
from ema_tools.words.terminal.show import say


def _sentences(packet: Packet) -> list[str]:
    because = ", because" if packet.reasons else "."
    told = [f"{packet.verdict.capitalize()}{because}", *(f"- {text}" for text in packet.reasons)]
    if packet.finding is not None:
        effect = f", {packet.finding.effect}" if packet.finding.kind == "missing" and packet.finding.effect else ""
        told.append(f"The table of signatures says: {packet.finding.kind}{effect}.")
    return told


def print_packets(console: Console, found: TelemetryResult) -> None:
    """Of each packet where it is from, its verdict with the reasons, and its values."""
    for place, packet in enumerate(found.packets, start=1):
        say(console, f"Packet {place}: configuration {packet.configuration}, module {packet.software}")
        for text in _sentences(packet):
            say(console, text)
        rows = table("", "value", "estimate", "+- 95 %", "shift", "at a bound")
        for value in packet.values:
            rows.add_row(
                value.name,
                number(value.estimate, 5),
                number(value.half_95, 3),
                f"{number(value.shift_percent, 3)} %",
                "yes" if value.at_bound else "no",
            )
        console.print(rows)
