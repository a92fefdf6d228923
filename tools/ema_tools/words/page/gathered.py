"""What the parts of a page of several results are gathered in: markup, curves and lines for the page's scripts, and the plots of one result with their buttons."""

from __future__ import annotations

from html import escape
from typing import Any

from ema_tools.words.page import figures
from ema_tools.words.page import text as words
from ema_tools.words.page.curves import pack
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.legend import LegendKey, switches
from ema_tools.words.page.recorded import Curves
from ema_tools.words.page.uplot import ABSENT, library

# What a page that is made of such parts needs beside the files of every page.
STYLES = ("curves.css", "parts.css")
SCRIPTS = ("curves.js",)


class Gathered:
    """Collects parts: HTML, and what scripts draw."""

    def __init__(self) -> None:
        self.parts: list[str] = []
        self.curves: list[dict[str, Any]] = []
        self.lines: list[dict[str, Any]] = []

    def add(self, *html: str) -> None:
        """Appends markup."""
        self.parts.extend(html)

    def taken(self) -> str:
        """The markup since the last time."""
        html = "".join(self.parts)
        self.parts = []
        return html

    def figure(self, identity: str, figure: figures.Figure) -> str:
        """The figure as it stands in the page."""
        return figure_svg(figure, identity)

    def data(self) -> dict[str, Any]:
        """For the scripts."""
        return {"curves": self.curves, "lines": self.lines}


def draw_curves(page: Gathered, curves: Curves, identity: str, models: dict[str, str], titled: str) -> None:
    """Every channel of a result with its residual, for each of `models` by what it is called; the plots of one `identity` are zoomed and switched together; `titled`: whose they are."""
    packed = pack(curves)
    for channel in packed["channels"]:
        channel["rms_text"] = {key: f"{words.number(value)} {channel['residual_unit']}" for key, value in channel.pop("rms").items()}
    page.curves.append({"id": identity, **packed})
    keys = [LegendKey("measured", "measured", "measured")]
    keys += [
        LegendKey(key, _role(key), f"simulated{'' if key == 'model' else ', ' + title.split(': ')[1]}") for key, title in models.items()
    ]
    page.add(f'<div class="bar">{switches(keys, titled, identity)}<div class="zoom" role="group" aria-label="Zoom of the curves">')
    for how, text in (("whole", "Whole record"), ("in", "Zoom in"), ("out", "Zoom out"), ("earlier", "← Earlier"), ("later", "Later →")):
        page.add(f'<button type="button" data-zoom="{how}" data-zoom-of="{identity}">{text}</button>')
    page.add(f'</div></div><div class="{"pair" if len(models) > 1 else "single"}">')
    titles = ", ".join(channel["title"].lower() for channel in packed["channels"])
    absent = "" if library().there else f'<p class="absent">{escape(ABSENT)}</p>'
    for key, title in models.items():
        label = f"{title}. Measured and simulated {titles} against time, each with its residual. " + "; ".join(
            f"{channel['title']} residual rms {channel['rms_text'][key]}" for channel in packed["channels"]
        )
        page.add(f'<figure><div class="figure-head"><h3>{escape(title)}</h3></div>{absent}')
        page.add(
            f'<div class="curves" data-curves="{identity}" data-model="{key}" role="group" aria-label="{escape(label)}"></div></figure>'
        )
    page.add("</div>")
    scale, follow = (", on the same scale before and after", "; all follow") if len(models) > 1 else ("", "")
    derived = " Speed is the slope of the position over 9 rows, the same for every curve." if curves.derived else ""
    page.add(
        f'<p class="note">Under each signal: measured minus simulated{scale}. Drag across a plot to zoom{follow}; double click shows the whole record.{derived}</p>'
    )


def _role(model: str) -> str:
    return "before" if model == "before" else "after"
