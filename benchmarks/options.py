"""Options that benchmarks of many trials share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

workers_option: Decorator = click.option("--workers", type=click.IntRange(0), help="Processes; all cores unless told, 0 for this one.")


def folder_option(default: str) -> Decorator:
    """Where the rows are kept."""
    return click.option(
        "-o",
        "--output",
        "folder",
        type=click.Path(path_type=Path, file_okay=False),
        default=Path(default),
        show_default=True,
        help="Folder of the rows; a run that was interrupted goes on.",
    )
