"""`--healthy REC...`: an option that takes every file behind it, as the shell expands a pattern."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])
_HEALTHY = "--healthy"


class TakesHealthy(click.Command):
    """A command whose --healthy takes the words up to the next option, but for the last of them where an argument of the command would be wanting."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does, with --healthy said before each of its files."""
        return super().parse_args(ctx, self._said_each(args))

    def _said_each(self, args: Sequence[str]) -> list[str]:
        valued = {name for one in self.params if isinstance(one, click.Option) and not one.is_flag for name in one.opts}
        arguments: list[int] = []
        more: list[int] = []  # places of a further file behind --healthy
        option = ""
        files = 0
        for place, word in enumerate(args):
            if word == "--":
                arguments += range(place + 1, len(args))
                break
            if option == _HEALTHY and not word.startswith("-"):
                files += 1
                more += [place] * (files > 1)
            elif option and option != _HEALTHY:
                option = ""
            elif word.startswith("-"):
                option, files = word if word in valued else "", 0
            else:
                arguments.append(place)
        required = sum(max(one.nargs, 1) for one in self.params if isinstance(one, click.Argument) and one.required)
        wanting = max(0, required - len(arguments))
        healthy = set(more[: len(more) - wanting])
        return [one for place, word in enumerate(args) for one in ([_HEALTHY, word] if place in healthy else [word])]


def healthy_option(what: str) -> Callable[[Command], Command]:
    """--healthy REC..., of a command of the class TakesHealthy; `what` begins its help."""
    told = f"{what} Files, patterns, folders; all that stand behind it, up to the next option."
    return click.option(_HEALTHY, multiple=True, metavar="REC...", help=told)
