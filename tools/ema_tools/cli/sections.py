"""The commands in the order of their use, as `ema --help` shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import click

SECTIONS: Mapping[str, Sequence[str]] = {
    "Records": ("import", "simulate"),
    "Where the model fails, and what it lacks": ("loop", "compare", "diagnose", "effects", "add", "next", "map"),
    "A unit and its faults": ("calibrate", "identify", "fleet", "export", "telemetry"),
    "To look at": ("report", "watch", "demo"),
}


class InSections(click.Group):
    """A group whose help lists its commands by section."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """In the order of SECTIONS, and what stands in none of them behind."""
        placed = [name for names in SECTIONS.values() for name in names if name in self.commands]
        return [*placed, *(name for name in sorted(self.commands) if name not in placed)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """One table for each section."""
        width = max(map(len, self.commands))
        for title, names in SECTIONS.items():
            rows = [(name.ljust(width), self.commands[name].get_short_help_str(limit=formatter.width - width - 6)) for name in names]
            with formatter.section(title):
                formatter.write_dl(rows)
