"""Pictures of results as SVG and PNG, for documents and slides; drawn by Matplotlib, which is loaded when one is asked for. What is looked at closely is the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_bytes
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.first_screen import first_screen, model_titles
from ema_tools.words.page.identification_screen import headline
from ema_tools.words.page.results import Mapped, Result, ShownIdentification
from ema_tools.words.page.signals import traces
from ema_tools.words.plots.friction import map_picture, torque_picture
from ema_tools.words.plots.ladder import candidates_picture, ladder_picture
from ema_tools.words.plots.objective import objective_picture, search_picture
from ema_tools.words.plots.signals import signals_picture
from ema_tools.words.plots.style import saved, styled
from ema_tools.words.plots.where import balances_picture, shares_picture, where_picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENDINGS = ("svg", "png")
# Everything that a result may have, in the order in which it is written.
KINDS = ("signals", "where", "candidates", "ladder", "friction", "objective", "search", "balances")
_Draw = Callable[[], "Figure | None"]


def targets(folder: Path, name: str) -> list[Path]:
    """Every file that the pictures of a result may be written to."""
    return [folder / f"{name}_{kind}.{ending}" for kind in KINDS for ending in ENDINGS]


def write_pictures(result: Result, folder: Path, name: str, force: bool = False) -> list[Path]:
    """Writes what `result` has to show to FOLDER/NAME_KIND.svg and .png; their paths. Raises InputError for one that has nothing, and for files that exist without `force`."""
    written = []
    with styled():
        for kind, draw in _pictures(result):
            made = draw()
            for ending in ENDINGS if made is not None else ():
                assert made is not None
                written.append(folder / f"{name}_{kind}.{ending}")
                write_bytes(written[-1], saved(made, ending), force)
    if not written:
        raise InputError(f"{result.name}: nothing to draw: the result holds no curves and no findings")
    return written


def _pictures(result: Result) -> Iterator[tuple[str, _Draw]]:
    """The pictures of a result by their kind."""
    if isinstance(result, Mapped):
        yield "friction", lambda: map_picture(result)
    elif isinstance(result, Diagnosed):
        yield "signals", lambda: _diagnosed_signals(result)
        yield "where", lambda: where_picture(result)
        yield "candidates", lambda: candidates_picture(result)
        yield "ladder", lambda: ladder_picture(result)
        yield "friction", lambda: torque_picture(result)
    elif isinstance(result, ShownIdentification):
        titles = {"before": "healthy values", "after": "identified values"}
        curves = result.curves
        if curves is not None:
            yield "signals", lambda: signals_picture(curves, curves.channels(), titles, f"{result.title}: {headline(result)}")
        yield "objective", lambda: objective_picture(result)
        yield "search", lambda: search_picture(result)
    else:
        drawn = result.curves
        if drawn is not None:
            yield "signals", lambda: signals_picture(drawn, drawn.channels(), {"model": "model"}, result.title)
        yield "where", lambda: shares_picture(result.where, f"{result.title}: where the error sits")
        yield "balances", lambda: balances_picture(result)


def _diagnosed_signals(result: Diagnosed) -> Figure | None:
    found = traces(result.curves, result.found.curves)
    if found is None or not found.names:
        return None
    return signals_picture(found.curves, found.names, model_titles(result, found.curves), f"{result.name}: {first_screen(result).sentence}")
