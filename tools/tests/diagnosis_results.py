"""Four kinds of results of `ema diagnose` for the tests of its page, made up about real curves: an effect is missing, all is healthy, a fault alone, something unknown."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ema_tools.data.actuator import reference_actuator
from ema_tools.data.records import simulated
from ema_tools.results.codec import to_json
from ema_tools.results.diagnosis import DiagnosisResult
from ema_tools.results.localisation import BinPicture, BlockEntry, Localisation, Pictures, SignalErrorEntry
from ema_tools.results.parts import EffectEntry, StepEntry, WeightedErrors
from ema_tools.results.provenance import curves
from ema_tools.results.validity import Remark, Validity
from ema_tools.words.page import write_report
from repeated_runs import measured

KINDS = ("missing", "healthy", "fault", "unknown")
BINS = 24
COMMAND = "ema diagnose mine.toml today.csv --healthy 'runs/healthy *.csv' --holdout other.csv --json d.json"
_HIDDEN = {"effects.stribeck_friction.rise": 0.3, "screw.csj_Nm": 0.2}
_SAMPLES = 40000.0


@cache
def _made(kind: str) -> str:
    hidden = _HIDDEN if kind in ("missing", "unknown") else {"screw.csj_Nm": 0.2} if kind == "fault" else {}
    record, model = measured(hidden, 5), reference_actuator()
    found, loud = kind in ("missing", "fault"), kind != "healthy"
    stribeck = EffectEntry(
        name="stribeck_friction",
        alike=("stribeck_friction",),
        parameters={"rise": 0.3, "speed_rad_s": 10.0, "shape": 1.0},
        std={"rise": 0.002, "speed_rad_s": 0.02, "shape": 0.004},
        score=_SAMPLES * (8.0**2 - 4.0**2),
        limit=30.0,
        accepted=kind == "missing",
    )
    rival = EffectEntry(name="spring_load", alike=("spring_load",), score=_SAMPLES * (8.0**2 - 6.0**2), limit=30.0, accepted=False)
    csj = EffectEntry(
        name="csj",
        parameters={"csj_Nm": 0.2},
        std={"csj_Nm": 0.0003},
        score=_SAMPLES * 16.0,
        limit=30.0,
        accepted=True,
        shift_percent=44.93,
        shift_interval95=(44.5, 45.36),
    )
    steps = [StepEntry((), "as given", 48.0, 54.0), StepEntry((), "what scatters from run to run", 8.0, 9.0)]
    if kind == "missing":
        steps += [
            StepEntry(("stribeck_friction",), "stribeck_friction", 4.0, 4.4),
            StepEntry(("stribeck_friction", "csj"), "csj", 0.86, 0.95),
        ]
    errors = WeightedErrors(48.0, 0.86, 0.87, 54.0, 0.95) if found else WeightedErrors(48.0 if loud else 0.88, 8.0 if loud else 0.87, 0.87)
    result = DiagnosisResult(
        name="today.csv",
        verdict={"missing": "missing", "unknown": "unknown"}.get(kind, "adequate"),  # type: ignore[arg-type]
        sentence="What the terminal says.",
        effects=(stribeck, rival) if kind == "missing" else (rival,) if kind == "unknown" else (),
        faults={"csj": csj} if found else {},
        error=errors,
        unexplained=0.0 if kind != "unknown" else 0.9,
        next_experiment="Next: look at the pictures (--report), and write the effect yourself.",
        steps=tuple(steps) if loud else (),
        gate=Validity(remarks=(Remark("coverage", "fine", "the stroke is long enough"),)),
        where=_where(loud, float(record.time_s[-1])),
        curves=curves(record, before=simulated(model, record), after=simulated(model.changed(_HIDDEN), record) if found else None),
        provenance={"command": COMMAND, "record": "today.csv"},
    )
    return json.dumps(to_json(result), allow_nan=False)


def _where(loud: bool, end_s: float) -> Localisation:
    blocks = (
        BlockEntry("mechanical", "Nm", 0.06 if loud else 0.002, 0.002, 25.0, 100.0 if loud else 0.0, loud, ()),
        BlockEntry("electrical", "V", 0.02, 0.018, 0.3, 0.0, False, ()),
    )
    share = np.linspace(0.5, 1.5, BINS)
    bins = []
    for by, unit, low, high in (("time", "s", 0.0, end_s), ("speed", "rad/s", -200.0, 200.0), ("position", "mm", -1.9, 1.9)):
        width = (high - low) / BINS
        center = tuple(low + width * (np.arange(BINS) + 0.5))
        flat, even = (0.01,) * BINS, (100.0 / BINS,) * BINS
        shares = tuple(100.0 * share / share.sum())
        bins += [BinPicture(one.name, one.unit, by, unit, False, center, flat, flat, flat, shares, even) for one in blocks]
    signals = (SignalErrorEntry("position_mm", "mm", 0.1, 0.0024, 60.0), SignalErrorEntry("current_A", "A", 0.5, 0.03, 40.0))
    return Localisation(True, "Where it fails, in words.", blocks, signals, (), Pictures(tuple(bins)))


def diagnosis(kind: str, **changes: Any) -> dict[str, Any]:
    """A result of one of KINDS; `changes` replace keys."""
    return {**json.loads(_made(kind)), **changes}


def diagnosis_page(folder: Path, data: dict[str, Any]) -> Path:
    """The page of one result, written into `folder`."""
    (folder / "today.json").write_text(json.dumps(data), encoding="utf-8")
    write_report([folder / "today.json"], folder / "page.html", "ema report today.json", force=True)
    return folder / "page.html"
