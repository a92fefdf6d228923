"""Pictures for documents from a result of `ema diagnose`: `python -m ema_tools.words.page.pictures RESULT.json OUTDIR NAME` writes OUTDIR/NAME_record.svg, _torque.svg and _error.svg.

Drawn as SVG text, which needs no library and changes in a readable way; the page for looking closer is that of `ema report`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from pathlib import Path

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import write_text
from ema_tools.library.faults import FAULTS
from ema_tools.select.holdout import ErrorFall, Rung
from ema_tools.words.page.diagnosis_results import Diagnosed, Line
from ema_tools.words.page.recorded import Curves, Series
from ema_tools.words.page.results import read_result
from ema_tools.words.page.text import number

_COLOURS = {"measured": "#9aa5b1", "before": "#c8501e", "after": "#0a6aa8", "floor": "#8a6d00"}
_INK, _GRID = "#333333", "#e4e7ea"
_CHANNELS = {"position_mm": ("rod position", "mm"), "current_A": ("motor current", "A")}
# A record has more rows than a picture has columns: each column shows its smallest and its largest value.
_COLUMNS = 300


@dataclass
class _Panel:
    """One diagram: its place in the picture, its ranges, and the SVG drawn into it."""

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]
    log: bool = False
    parts: list[str] = field(default_factory=list)

    def at(self, x: Series, y: Series) -> str:
        """Points as SVG has them."""
        low, high = np.log10(self.y) if self.log else self.y
        across = self.left + self.width * (np.asarray(x) - self.x[0]) / (self.x[1] - self.x[0])
        up = self.top + self.height * (high - (np.log10(y) if self.log else np.asarray(y))) / (high - low)
        return " ".join(f"{one:.1f},{other:.1f}" for one, other in zip(across, up, strict=True))

    def line(self, x: Series, y: Series, colour: str, width: float = 1.0, dash: str = "") -> None:
        """A polyline."""
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(
            f'<polyline points="{self.at(x, y)}" fill="none" stroke="{colour}" stroke-width="{width:g}" stroke-linejoin="round"{dashed}/>'
        )

    def dots(self, x: Series, y: Series, colour: str, radius: float, opacity: float = 1.0) -> None:
        """Points."""
        self.parts += [
            f'<circle cx="{place.split(",")[0]}" cy="{place.split(",")[1]}" r="{radius:g}" fill="{colour}" fill-opacity="{opacity:g}"/>'
            for place in self.at(x, y).split()
        ]

    def band(self, line: Line, colour: str) -> None:
        """The area between the edges of a line."""
        assert line.low is not None and line.high is not None
        self.parts.append(
            f'<polygon points="{self.at(line.x, line.low)} {self.at(line.x[::-1], line.high[::-1])}" fill="{colour}" fill-opacity="0.18"/>'
        )

    def axes(self, title: str, below: bool, unit: str = "") -> None:
        """Grid and ticks; the scale of x only where `below`."""
        for value in _decades(self.y) if self.log else _ticks(self.y):
            y = float(self.at(np.array([self.x[0]]), np.array([value])).split(",")[1])
            line = f'<line x1="{self.left:g}" x2="{self.left + self.width:g}" y1="{y:.1f}" y2="{y:.1f}" stroke="{_GRID}"/>'
            self.parts += [line, _text(self.left - 6.0, y + 3.5, f"{value:g}".replace("-", "−"), "end")]
        if below:
            for value in _ticks(self.x, 6):
                x = self.left + self.width * (value - self.x[0]) / (self.x[1] - self.x[0])
                self.parts.append(_text(x, self.top + self.height + 14.0, f"{value:g}".replace("-", "−"), "middle"))
            self.parts.append(_text(self.left + self.width, self.top + self.height + 28.0, unit, "end"))
        self.parts.append(_text(self.left, self.top - 6.0, title, "start"))


def _text(x: float, y: float, text: str, anchor: str, bold: bool = False) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{" font-weight=" + chr(34) + "bold" + chr(34) if bold else ""}>{escape(text)}</text>'


def _ticks(ends: tuple[float, float], count: int = 4) -> list[float]:
    """Round values between the ends, no more than about `count`."""
    raw = (ends[1] - ends[0]) / count
    power = 10.0 ** np.floor(np.log10(raw))
    step = power * next(factor for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= raw)
    return [float(round(step * place, 12)) for place in range(int(np.ceil(ends[0] / step)), int(np.floor(ends[1] / step)) + 1)]


def _decades(ends: tuple[float, float]) -> list[float]:
    return [10.0**power for power in range(int(np.ceil(np.log10(ends[0]))), int(np.floor(np.log10(ends[1]))) + 1)]


def _svg(width: float, height: float, parts: Sequence[str], title: str) -> str:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" font-family="sans-serif" font-size="11" fill="{_INK}" role="img">'
    return "\n".join(
        [head, f"<title>{escape(title)}</title>", f'<rect width="{width:g}" height="{height:g}" fill="white"/>', *parts, "</svg>", ""]
    )


def _legend(x: float, y: float, entries: dict[str, str]) -> list[str]:
    """A row of coloured names."""
    parts = []
    for name, colour in entries.items():
        parts += [
            f'<line x1="{x:g}" x2="{x + 18.0:g}" y1="{y - 4.0:g}" y2="{y - 4.0:g}" stroke="{colour}" stroke-width="3"/>',
            _text(x + 23.0, y, name, "start"),
        ]
        x += 40.0 + 6.0 * len(name)
    return parts


def _thinned(time: Series, values: Series) -> tuple[Series, Series]:
    """The smallest and the largest value of each column, in the order in which they come."""
    size = max(1, len(values) // _COLUMNS)
    rows = len(values) // size * size
    columns = values[:rows].reshape(-1, size)
    places = np.sort(np.stack([columns.argmin(axis=1), columns.argmax(axis=1)]), axis=0)
    chosen = (np.arange(len(columns)) * size + places).T.ravel()
    return time[chosen], values[chosen]


def _around(values: Series, room: float = 0.08) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    return low - room * (high - low), high + room * (high - low)


def of_record(curves: Curves, added: str) -> str:
    """Measured and simulated signals with their difference, before and after."""
    time = curves.start_s + curves.period_s * np.arange(curves.rows, dtype=np.float64)
    ends = (float(time[0]), float(time[-1]))
    titles = {"before": "the model before", "after": f"with {added}"}
    shown = {name: shape for name, shape in _CHANNELS.items() if name in curves.channels()}
    parts = _legend(60.0, 20.0, {"measured": _COLOURS["measured"], **{title: _COLOURS[key] for key, title in titles.items()}})
    for column, (key, title) in enumerate(titles.items()):
        left = 60.0 + 400.0 * column
        for row, (name, (label, unit)) in enumerate(shown.items()):
            top = 60.0 + 210.0 * row
            measured, model = curves.measured[name], curves.models[key][name]
            worst = max(float(np.max(np.abs(curves.measured[name] - curves.models[one][name]))) for one in titles)
            upper = _Panel(left, top, 350.0, 95.0, ends, _around(np.concatenate([measured, model])))
            upper.axes(f"{label}, {unit}: {title}", False)
            upper.line(*_thinned(time, measured), _COLOURS["measured"], 3.0)
            upper.line(*_thinned(time, model), _COLOURS[key])
            lower = _Panel(left, top + 120.0, 350.0, 40.0, ends, (-1.08 * worst, 1.08 * worst))
            lower.axes(f"measured minus simulated, rms {number(curves.rms(name, key), 2)} {unit}", row == len(shown) - 1, "time, s")
            lower.line(*_thinned(time, measured - model), _COLOURS[key])
            parts += [*upper.parts, *lower.parts]
    return _svg(830.0, 80.0 + 210.0 * len(shown), parts, f"Measured and simulated signals before and after {added}")


def of_torque(result: Diagnosed) -> str:
    """Torque without inertia against speed, of the record and of the healthy repeats or the model."""
    drawn = next((one for one in result.pictures if one.source == "torque without inertia"), None)
    if drawn is None or "measured" not in drawn.lines:
        raise InputError(
            f"{result.name}: no torque against speed in the result: the record needs motor_position_mm or speed, and current_A"
        )
    points, measured = drawn.lines["points"], drawn.lines["measured"]
    other = next(name for name in drawn.lines if name not in ("points", "measured"))
    panel = _Panel(60.0, 55.0, 500.0, 230.0, _around(points.x, 0.03), _around(points.y))
    panel.axes(f"torque without inertia, {drawn.unit}", True, f"speed of the motor, {drawn.axis_unit}")
    panel.dots(points.x, points.y, _COLOURS["measured"], 1.4, 0.7)
    names = {"healthy": "healthy repeats", "model": "model"}
    for line, colour in ((drawn.lines[other], _COLOURS["after"]), (measured, _COLOURS["before"])):
        panel.band(line, colour)
        panel.line(line.x, line.y, colour, 2.0)
    return _svg(
        590.0,
        325.0,
        [
            *_legend(60.0, 20.0, {"today": _COLOURS["before"], names[other]: _COLOURS["after"], "samples of today": _COLOURS["measured"]}),
            *panel.parts,
        ],
        "Torque against speed",
    )


@dataclass(frozen=True)
class NotebookPicture:
    """A picture that a notebook shows as it is."""

    svg: str

    def _repr_svg_(self) -> str:
        return self.svg


def of_steps(errors: ErrorFall, steps: Sequence[Rung]) -> NotebookPicture:
    """The fall of the error of a diagnosis, from its answer itself; the first of `steps` is the model as given."""
    if not steps:
        raise InputError("no fall of an error: nothing was fitted to the record")
    rungs = [(one.added or "as given", *one.told) for one in steps]
    return NotebookPicture(_fall(rungs, errors.floor))


def of_error(result: Diagnosed) -> str:
    """The weighted error from the first model to the last, on the record and on the one held out, over the floor."""
    if "before" not in result.errors or "floor" not in result.errors or not result.steps:
        raise InputError(
            f"{result.name}: no fall of an error in the result: give the --json result of an `ema diagnose` that found something"
        )
    held = [result.errors.get("holdout_before"), *(step.read[1] for step in result.steps)]
    training = [result.errors["before"], *(step.read[0] for step in result.steps)]
    names = ["as given", *(step.added for step in result.steps)]
    return _fall(list(zip(names, training, held, strict=True)), result.errors["floor"])


def _fall(rungs: Sequence[tuple[str, float, float | None]], floor: float) -> str:
    """Each model's name, and its error on the record and on the one held out."""
    names = [rungs[0][0], *(f"+ {_name(one[0])}" for one in rungs[1:])]
    training, held = np.array([one[1] for one in rungs]), [one[2] for one in rungs]
    known = np.array([floor, *training, *(value for value in held if value is not None)])
    panel = _Panel(60.0, 55.0, 500.0, 200.0, (-0.4, len(names) - 0.6), (0.6 * float(known.min()), 1.6 * float(known.max())), log=True)
    panel.axes("weighted error, rms; 1 is sensor noise", False)
    places = np.arange(len(names), dtype=float)
    panel.line(np.array(panel.x), np.full(2, floor), _COLOURS["floor"], 1.5, "6 4")
    entries = {"on the record": _COLOURS["after"], "floor: healthy runs among each other": _COLOURS["floor"]}
    if all(value is not None for value in held):
        others = np.array([value for value in held if value is not None])
        panel.line(places, others, _COLOURS["before"], 2.0, "2 3")
        panel.dots(places, others, _COLOURS["before"], 4.0)
        entries["on the record held out"] = _COLOURS["before"]
    panel.line(places, training, _COLOURS["after"], 2.0)
    panel.dots(places, training, _COLOURS["after"], 4.0)
    parts = [*_legend(60.0, 20.0, entries), *panel.parts]
    for place, name in enumerate(names):
        x = float(panel.at(np.array([float(place)]), np.array([floor])).split(",")[0])
        # Two rows: long names of neighbours would run into each other.
        y = panel.top + panel.height + 16.0 + 28.0 * (place % 2)
        parts += [_text(x, y, name, "middle"), _text(x, y + 13.0, number(float(training[place])), "middle", bold=True)]
    return _svg(590.0, 320.0, parts, "Fall of the weighted error")


def _name(effect: str) -> str:
    return effect.upper() if effect in FAULTS else effect


def targets(folder: Path, name: str) -> dict[str, Path]:
    """Where the pictures of a result are written, by what they show."""
    return {kind: folder / f"{name}_{kind}.svg" for kind in ("record", "torque", "error")}


def write_pictures(result: Path, folder: Path, name: str, force: bool = True) -> list[Path]:
    """Writes the three pictures of a result into `folder`; returns their paths. Raises InputError for a result that does not hold what is drawn, and for files that exist without `force`."""
    found = read_result(result)
    if not isinstance(found, Diagnosed) or found.curves is None or "after" not in found.curves.models:
        raise InputError(
            f"{result}: no diagnosis with curves before and after: give the --json result of an `ema diagnose` that found something"
        )
    added = " and ".join(map(_name, found.steps[-1].effects)) if found.steps else "the effect"
    texts = {"record": of_record(found.curves, added), "torque": of_torque(found), "error": of_error(found)}
    paths = targets(folder, name)
    for kind, text in texts.items():
        write_text(paths[kind], text, force)
    return list(paths.values())


def main() -> int:
    """Entry point; 0 when the pictures are written."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("result", type=Path, metavar="RESULT.json")
    parser.add_argument("folder", type=Path, metavar="OUTDIR")
    parser.add_argument("name", metavar="NAME")
    given = parser.parse_args()
    if not given.folder.is_dir():
        print(f"{given.folder}: not a folder: make it first", file=sys.stderr)
        return 1
    try:
        for path in write_pictures(given.result, given.folder, given.name):
            print(path)
    except InputError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
