"""Every signal of a record, measured and simulated, with its residual: the whole record, and beside it the moment in which the first model is most off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.words.page import names
from ema_tools.words.page.recorded import Curves
from ema_tools.words.page.text import number
from ema_tools.words.plots.style import COLOURS, MEASURED, SOFT, figure, titled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLUMNS = 700  # pieces of a curve of which the smallest and the largest value are drawn [layout]
_NEAR = 0.06  # of the record, shown in detail [layout]
_SIGNALS_MAX = 5  # signals of one picture [layout]


def signals_picture(curves: Curves, channels: tuple[str, ...], models: Mapping[str, str], title: str) -> Figure:
    """`models`: what each model of the curves is called."""
    shown = channels[:_SIGNALS_MAX]
    time = curves.start_s + curves.period_s * np.arange(curves.rows, dtype=np.float64)
    made = figure(title, 0.9 + 2.5 * len(shown))
    grid = made.subplots(
        2 * len(shown), 2, sharex="col", squeeze=False, gridspec_kw={"height_ratios": [5, 3] * len(shown), "width_ratios": [2, 1]}
    )
    near = _worst(curves, shown)
    for place, name in enumerate(shown):
        for column, rows in enumerate((slice(0, curves.rows), near)):
            _signal(grid[2 * place, column], grid[2 * place + 1, column], curves, name, models, time, rows, column == 0)
    for column, said in enumerate(("time, s", "time, s: where the first model is most off")):
        grid[-1, column].set_xlabel(said)
        grid[-1, column].set_xlim(*((time[0], time[-1]) if column == 0 else (time[near.start], time[near.stop - 1])))
    handles, labels = grid[0, 0].get_legend_handles_labels()
    made.legend(handles, labels, loc="outside lower left", ncols=len(labels))
    return made


def _signal(main: Axes, beneath: Axes, curves: Curves, name: str, models: Mapping[str, str], time: Reals, rows: slice, whole: bool) -> None:
    signal, unit, residual_unit, scale = names.SIGNALS[name]
    measured = curves.measured[name]
    main.plot(*thinned(time[rows], measured[rows]), color=MEASURED, linewidth=3.0, label="measured")
    told = []
    for key, said in models.items():
        model = curves.models[key][name]
        style = {"color": COLOURS[key], "linestyle": (0, (5, 1.5)) if key == "before" else "-", "linewidth": 1.1}
        main.plot(*thinned(time[rows], model[rows]), label=said, **style)
        residual = scale * (measured - model)
        beneath.plot(*thinned(time[rows], residual[rows]), color=COLOURS[key], linewidth=0.9)
        told.append(f"{number(float(np.sqrt(np.mean(residual**2))))}")
    if whole:
        titled(main, f"{signal}, {unit}")
        beneath.set_ylabel(residual_unit)
        said = f"measured minus simulated, {residual_unit}: rms {' before, '.join(told)}{' after' if len(told) > 1 else ''}"
        beneath.set_title(said, fontsize=9, color=SOFT)
    main.tick_params(labelbottom=False)


def _worst(curves: Curves, channels: tuple[str, ...]) -> slice:
    """Rows round the largest residual of the first signal, by the first model."""
    key = next(iter(curves.models))
    residual = np.abs(curves.measured[channels[0]] - curves.models[key][channels[0]])
    size = max(int(_NEAR * curves.rows), min(curves.rows, 20))
    start = int(np.clip(int(np.argmax(residual)) - size // 2, 0, curves.rows - size))
    return slice(start, start + size)


def thinned(time: Reals, values: Reals) -> tuple[Reals, Reals]:
    """The smallest and the largest value of equal pieces, in their order: what an eye sees of a long curve."""
    size = len(values) // _COLUMNS
    if size < 3:
        return time, values
    rows = len(values) // size * size
    pieces = values[:rows].reshape(-1, size)
    places = np.sort(np.stack([pieces.argmin(axis=1), pieces.argmax(axis=1)]), axis=0)
    chosen = np.unique(np.concatenate([[0], (np.arange(len(pieces)) * size + places).ravel(), [len(values) - 1]]))
    return time[chosen], values[chosen]
