"""The pictures of a result as SVG and PNG, where a command was asked for them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ema_tools.words.terminal.console import output

if TYPE_CHECKING:
    from ema_tools.results.reading import Result


def picture_files(folder: str | None, command: str, record: str) -> list[str]:
    """Files that the pictures of a result may be written to, none without a folder."""
    if not folder:
        return []
    from ema_tools.words.plots import targets

    return list(map(str, targets(Path(folder), _name(command, record))))


def draw(folder: str | None, result: Result, record: str, force: bool) -> None:
    """Write the pictures of a command's result on a record, and say so."""
    if not folder:
        return
    from ema_tools.words.page.results import shown
    from ema_tools.words.plots import write_pictures

    name = _name(result.command, record)
    written = write_pictures(shown(result, record, Path(record).stem), Path(folder), name, force)
    say_drawn(folder, name, written)


def say_drawn(folder: str, name: str, written: list[Path]) -> None:
    """One line for all pictures of a result."""
    kinds = ", ".join(dict.fromkeys(path.stem.removeprefix(f"{name}_") for path in written))
    output().print(f"{Path(folder) / name}_*: {kinds}, each as .svg and .png", highlight=False)


def _name(command: str, record: str) -> str:
    return f"{Path(record).stem}_{command}"
