"""The page's workbench: the module's own C, compiled to WebAssembly, simulates and fits in the page. `section` is all that a page needs.

The HTML brings its own style, scripts and data, and reads nothing else of the page but the colours of its style sheet. The page's policy must allow
`script-src 'wasm-unsafe-eval'` and `worker-src blob:`. What the page's other parts may call, once the workbench stands: `emaWorkbench.load({"screw.csj_Nm": 0.2, ...})`.
"""

from __future__ import annotations

import base64
import json
import math
import zlib
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.data.actuator import Actuator, Row, actuator_of, row_of, scattering_rows, shown
from ema_tools.library.definitions import Effect, EffectParameter, library_folder, load_definitions
from ema_tools.library.display_names import value_words
from ema_tools.library.registry import record_of
from ema_tools.results.workbench import BenchEntry, SpreadEntry, WeighedEntry

# What a page that holds a workbench must allow beside its own scripts.
POLICY = "script-src 'unsafe-inline' 'wasm-unsafe-eval'; worker-src blob:"

_MODULE = "ema.wasm"
_ABSENT = (
    f"The page has no workbench: {_MODULE} was not built. Install the packages clang and lld, build the project and write the page again."
)
# Values beside the effects': each with the share of the healthy value up to which its slider goes, and the bounds of its fit.
_FAULTS = {
    "screw.csj_Nm": ("CSJ, static dry friction", ("search.csj_lower_Nm", "search.csj_upper_Nm")),
    "screw.blk_mm": ("BLK, backlash at the rod", ("search.blk_lower_mm", "search.blk_upper_mm")),
}
_OTHERS = {"screw.viscous_Nm_s_per_rad": "Viscous friction", "motor.resistance_ohm": "Winding resistance"}
_SIZE_REACH = 10.0  # a slider reaches so many times the lower end of an effect's usual size [judgement]
_SHAPE_REACH = 6.0  # and from a share of a shape's usual value to as many times it [judgement]
_OTHER_REACH = 3.0  # and alike of a value of the machine [judgement]
_FAULT_REACH = 4.0  # and up to so many times a healthy value [judgement]
_WHOLE = "periods"  # a value that is a whole number: tried, not fitted
_PLACES = 21  # places along the recorded stroke where a fit of an effect with a place begins [effort]
_PLACE_SCALE = 0.3  # of the stroke, in which a place is stepped [precision]
_PHASE_SCALE = 0.5  # rad, the same of a phase [precision]


def why_not(entry: BenchEntry | None, changes: Mapping[str, float] | None, by_forces: bool) -> str:
    """Why a model, by what makes it of the first, cannot be loaded into the workbench, in a few words; empty where it can."""
    if entry is None:
        return "balance only, not simulated" if by_forces else "not simulated on this page"
    if not module_path().is_file():
        return "no workbench"
    if changes is None:
        return "its values were not kept"
    lacking = next((name for name in changes if name not in _loadable()), None)
    return f"no {lacking} in this build" if lacking is not None else ""


@cache
def _loadable() -> dict[str, Row]:
    """Rows of every value that makes a machine, by full name."""
    rows: tuple[Row, ...] = (*scattering_rows().values(), *load_definitions().effect_values)
    return {shown(row): row for row in rows}


def module_path() -> Path:
    """Where the module's WebAssembly is, or would be."""
    return library_folder() / _MODULE


def section(entry: BenchEntry, identity: str = "workbench") -> str:
    """The workbench as one section of a page.

    Raises InputError when the result's actuator cannot be read.
    """
    return (
        f'<section id="{identity}" aria-labelledby="{identity}-title"><div class="wrap"><h2 id="{identity}-title">Workbench</h2>'
        f"{markup(entry)}</div></section>"
    )


def markup(entry: BenchEntry, loads: Collection[str] = ()) -> str:
    """What stands under the section's title, scripts and data included; a note where the module was not built. Raises InputError as `section`.

    `loads`: full names of values that the page's other parts load into it, some of which may have no slider.
    """
    if not module_path().is_file():
        return f'<p class="note">{escape(_ABSENT)}</p>'
    assets = resources.files("ema_tools.words.page") / "assets"
    style, engine, fit, text, plot, script = (
        (assets / name).read_text(encoding="utf-8")
        for name in ("workbench.css", "workbench_engine.js", "workbench_fit.js", "workbench_text.js", "workbench_plot.js", "workbench.js")
    )
    # `<` would let a text in the data end the script element.
    data = json.dumps(payload(entry, loads), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return (
        "<p>The module's own C runs in this page. Switch effects on, move values, fit them to the record: the error follows. "
        "What it shows is an error, not a verdict: effects that look alike fit alike, and <code>ema diagnose</code> judges.</p>"
        f'<div class="bench" data-workbench></div><noscript><p>The workbench needs JavaScript.</p></noscript><style>\n{style}</style>\n'
        f'<script type="application/json" id="workbench-data">{data}</script>\n'
        f'<script id="workbench-engine">\n{engine}{fit}</script>\n<script>\n{text}{plot}{script}</script>'
    )


def payload(entry: BenchEntry, loads: Collection[str] = ()) -> dict[str, Any]:
    """What the scripts take: the model as flat arrays, its rows, the record and the module, both packed; `loads` as of `markup`."""
    actuator = actuator_of(entry.actuator, entry.actuator_file)
    known = load_definitions()
    values, options = actuator.arrays()
    columns = {name: np.frombuffer(base64.b64decode(text), dtype="<f4") for name, text in entry.columns.items()}
    stroke_mm = float(np.min(columns["position_mm"])), float(np.max(columns["position_mm"]))
    rows = [_fault(actuator, name) for name in _FAULTS] + [_other(actuator, name) for name in _OTHERS if actuator[name] > 0.0]
    effects = [
        _effect(actuator, effect, entry.usual, stroke_mm)
        for effect in known.effects
        if not effect.is_learned or effect.name in actuator.active_effects
    ]
    shown_rows = {row["name"] for row in (*rows, *(row for effect in effects for row in effect["rows"]))}
    moved = {*loads, *(name for one in (entry.weighed.spread if entry.weighed is not None else ()) for name in one.names)}
    return {
        "module": _deflated(module_path().read_bytes()),
        "model": {"values": values.tolist(), "options": options.tolist()},
        "rows": rows,
        "effects": effects,
        "unseen": [_unseen(actuator, row) for name, row in _loadable().items() if name in moved and name not in shown_rows],
        "start": {"blk_upper_mm": actuator["search.blk_upper_mm"], "noise_mm": actuator["verdict.position_noise_mm"]},
        "record": {
            "file": entry.record_file,
            "start_s": entry.start_s,
            "period_s": entry.period_s,
            "rows": int(columns["command_mm"].size),
            "columns": {name: _deflated(_planes(column)) for name, column in columns.items()},
        },
        "weighed": _weighed(actuator, entry.weighed),
        "actuator": {"name": actuator.name, "file": entry.actuator_file, "toml": entry.actuator, "header": entry.header},
        # the module's position in the list of a value that it refuses
        "names": list(known.ids),
    }


def _weighed(actuator: Actuator, weighed: WeighedEntry | None) -> dict[str, Any] | None:
    """How a diagnosis weighs the record, packed as its columns are; values by their place in the model."""
    if weighed is None:
        return None

    def packed(columns: dict[str, str]) -> dict[str, str]:
        return {name: _deflated(_planes(np.frombuffer(base64.b64decode(text), dtype="<f4"))) for name, text in columns.items()}

    def placed(changes: Mapping[str, float]) -> list[tuple[int, float]]:
        return [(load_definitions().ids[row_of(name).name], value) for name, value in changes.items()]

    return {
        "rows": weighed.rows,
        "target": packed(weighed.target),
        "weights": packed(weighed.weights),
        "spread": [_spread(actuator, one) for one in weighed.spread],
        "zeros": weighed.zeros,
        "gains": weighed.gains,
        "unit": placed(weighed.unit),
        "slight": [{"changes": placed(changes), "size": size} for changes, size in zip(weighed.slight, weighed.sizes, strict=True)],
    }


def _spread(actuator: Actuator, spread: SpreadEntry) -> dict[str, Any]:
    """Values with a prior: where they are expected, one standard deviation and the range of the first."""
    rows = [row_of(name) for name in spread.names]
    zeros = [actuator[row.name] for row in rows]
    std = spread.std * abs(zeros[0]) if spread.relative else spread.std
    return {
        "ids": [load_definitions().ids[row.name] for row in rows],
        "zeros": zeros,
        "std": std,
        "lower": rows[0].lower,
        "upper": rows[0].upper,
    }


def _deflated(raw: bytes) -> str:
    return base64.b64encode(zlib.compress(raw, 9)).decode("ascii")


def _planes(values: np.ndarray[Any, Any]) -> bytes:
    """The bytes of float32 numbers, the first of each, then the second, and so on: neighbouring rows differ in the last ones alone, so that the others pack well."""
    return values.view(np.uint8).reshape(-1, 4).T.tobytes()


def _row(actuator: Actuator, row: Row, label: str, slider: tuple[float, float], bounds: tuple[float, float]) -> dict[str, Any]:
    """A value with its slider's range and the bounds of its fit, both wide enough for what the model has."""
    value = actuator[row.name]
    low, high = (min(slider[0], value), max(slider[1], value))
    fit = (min(bounds[0], value), max(bounds[1], value))
    remark = row.text + (f" [{row.unit}]" if row.unit else "")
    place = shown(row).rsplit(".", 1)[0]
    return {
        "name": shown(row), "id": load_definitions().ids[row.name], "table": place, "field": row.field, "label": label, "unit": row.unit,
        "remark": remark, "value": value, "zero": row.nominal, "low": low, "high": high, "bounds": fit,
    }  # fmt: skip


def _unseen(actuator: Actuator, row: Row) -> dict[str, Any]:
    """A value without a slider, which a model that is loaded may set."""
    value = actuator[row.name]
    return _row(actuator, row, value_words(row.text, row.field), (value, value), (value, value))


def _fault(actuator: Actuator, name: str) -> dict[str, Any]:
    label, (lower, upper) = _FAULTS[name]
    bounds = actuator[lower], actuator[upper]
    slider = 0.0, min(bounds[1], _FAULT_REACH * actuator[name]) or bounds[1]
    return _row(actuator, load_definitions().by_name[name], label, slider, bounds)


def _other(actuator: Actuator, name: str) -> dict[str, Any]:
    bounds = actuator[name] / _OTHER_REACH, actuator[name] * _OTHER_REACH
    return _row(actuator, load_definitions().by_name[name], _OTHERS[name], bounds, bounds)


def _effect(actuator: Actuator, effect: Effect, usual: dict[str, float], stroke_mm: tuple[float, float]) -> dict[str, Any]:
    """One effect: its values, what they are where it is switched on, and where its fit starts from."""
    reach_mm = max(map(abs, stroke_mm))
    active = effect.name in actuator.active_effects
    rows = effect.parameters[:1] if effect.is_learned else effect.parameters
    shown_rows = []
    for row in rows:
        typical = usual.get(shown(row), row.nominal)
        bounds = _bounds(row, row is effect.size, actuator[row.name] if active else typical, reach_mm)
        # a fit may go where no slider does, as a diagnosis' does; a place lies on the stroke
        entry = _row(actuator, row, row.field, bounds, bounds if _is_place(effect, row) else (row.lower, row.upper))
        # where nothing says what is usual, a tenth of the range is seen at once
        first = typical if typical != row.nominal or row is not effect.size else 0.1 * bounds[1]
        on = actuator[row.name] if active else min(max(first, bounds[0]), bounds[1])
        scale = _PHASE_SCALE if row.field.endswith("phase_rad") else _PLACE_SCALE * reach_mm if _is_place(effect, row) else 0.0
        shown_rows.append({**entry, "on": on, "scale": scale, "whole": row.field == _WHOLE})
    return {
        "name": effect.name,
        "title": effect.name.replace("_", " ").capitalize(),
        "equation": effect.equation,
        "source": effect.source,
        "active": active,
        "rows": shown_rows,
        "ranked": not effect.is_learned and not active,
        "starts": {} if effect.is_learned else _starts(effect, usual, stroke_mm),
    }


def _is_place(effect: Effect, row: EffectParameter) -> bool:
    return row is not effect.size and row.unit == "mm" and row.lower < 0.0


def _starts(effect: Effect, usual: dict[str, float], stroke_mm: tuple[float, float]) -> dict[str, list[float]]:
    """Values by field that a fit of the effect starts from, every combination; what is left out starts as usual."""
    record = record_of(effect.name)
    reach_mm = max(map(abs, stroke_mm))
    onboard = record.onboard
    found: dict[str, Sequence[float]] = {**record.shapes}
    found |= {
        name: [share * (reach_mm if name in onboard.of_reach else 1.0) for share in shares] for name, shares in onboard.shapes.items()
    }
    found |= {row.field: np.linspace(*stroke_mm, _PLACES).tolist() for row in effect.parameters if _is_place(effect, row)}
    if record.periodic is not None and record.periodic.periods:
        found[_WHOLE] = record.periodic.periods
    if record.below_peak is not None and shown(effect.size) in usual:
        found[effect.size.field] = [share / record.below_peak.typical * usual[shown(effect.size)] for share in record.below_peak.tried]
    elif record.first:
        found[effect.size.field] = record.first
    elif record.bending is not None and not callable(record.bending.sizes):
        found[effect.size.field] = record.bending.sizes
    known = {row.field for row in effect.parameters}
    return {name: list(values) for name, values in found.items() if name in known}


def _bounds(row: EffectParameter, is_size: bool, usual: float, reach_mm: float) -> tuple[float, float]:
    """From where to where a value of an effect is moved and fitted."""
    if row.field.endswith("phase_rad"):
        return -math.pi, math.pi
    limit = record_of(row.effect).below_peak
    if is_size and limit is not None:
        # of the peak, of which the usual value is a share
        return min(limit.tried) / limit.typical * usual, usual / limit.typical
    if is_size:
        upper = min(row.upper, _SIZE_REACH * abs(usual)) or row.upper
        return (row.lower if row.lower == row.nominal else max(row.lower, -upper)), upper
    if row.unit == "mm" and row.lower < 0.0:
        return max(row.lower, -reach_mm), min(row.upper, reach_mm)
    if row.lower > 0.0 and usual > 0.0:
        return max(row.lower, usual / _SHAPE_REACH), min(row.upper, usual * _SHAPE_REACH)
    return row.lower, row.upper
