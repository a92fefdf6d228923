"""How every picture looks: light, the page's colours, which eyes that tell red from green badly tell apart too, and lines that differ in width and stroke besides."""

from __future__ import annotations

import io
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MEASURED, BEFORE, AFTER, NOISE, HEALTHY, OTHER = "#8d99a6", "#b8480f", "#0a5f9c", "#7a6200", "#1d6b3d", "#6b7784"
COLOURS = {"measured": MEASURED, "before": BEFORE, "after": AFTER, "model": AFTER}
INK, SOFT, GRID = "#1d2530", "#55606d", "#e4e7ea"
# Light to dark, so that it reads in grey: a cell in the noise, then six steps above it.
HEAT = ("#ffffff", "#fde3c8", "#fbc48d", "#f29b4b", "#d9701a", "#a94a08", "#6b2b02")
WIDTH_IN = 10.0  # of a picture [layout]
_DPI = 150  # of the PNG: 1500 points across [layout]
_TITLE_CHARACTERS = 96  # a line of the title holds [layout]
_SETTINGS = {
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "axes.edgecolor": "#aeb6be",
    "axes.labelcolor": SOFT,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "text.color": INK,
    "legend.frameon": False,
    "lines.solid_joinstyle": "round",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    # text stays text in the SVG; the same picture again is the same file
    "svg.fonttype": "none",
    "svg.hashsalt": "ema",
    "axes.formatter.use_mathtext": True,
}


@contextmanager
def styled() -> Iterator[None]:
    """The settings, for the time of one picture; the user's own are left alone."""
    import matplotlib

    with matplotlib.rc_context(rc={**matplotlib.rcParamsDefault, "backend": "Agg", **_SETTINGS}):
        yield


def figure(title: str, height_in: float) -> Figure:
    """An empty picture with its title."""
    from matplotlib.figure import Figure

    made = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    made.suptitle(textwrap.fill(title, _TITLE_CHARACTERS), x=0.012, ha="left", fontsize=12.5, fontweight="bold")
    return made


def titled(axes: Axes, title: str, x_title: str = "", y_title: str = "") -> None:
    """Titles of one diagram."""
    axes.set_title(title)
    axes.set_xlabel(x_title)
    axes.set_ylabel(y_title)


def saved(made: Figure, ending: str) -> bytes:
    """The picture as `svg` or `png`."""
    stream = io.BytesIO()
    metadata = {"Date": None} if ending == "svg" else {"Software": None}
    made.savefig(stream, format=ending, dpi=_DPI, metadata=metadata)
    return stream.getvalue()
