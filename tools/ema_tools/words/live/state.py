"""What the live page shows of a recording, as data for its script."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record
from ema_tools.plant.native import CHANNELS, Simulation
from ema_tools.tasks.watch import Phase, Seen, residual
from ema_tools.words.page.names import SIGNALS
from ema_tools.words.page.text import number, shift
from ema_tools.words.sentences.identification import BECAUSE, TITLES, reasons, sentence
from ema_tools.words.sentences.paths import with_paths
from ema_tools.words.sentences.sizes import ends_text

_BINS = 1000  # of a curve on the page, two rows each: the first, and that of the largest residual [layout]
_DIGITS = 6  # of a number of a curve, which are finer than a screen [layout]
_WIDE = 10.0  # %: half of an interval that leaves no decimals [layout]
_TONES = {"healthy": "good", "fault": "bad", "undecided": "unsure"}


def state(seen: Seen, actuator: Actuator, file: str) -> dict[str, Any]:
    """The page's data: `headline` and `tone`, `details` and `notes` in words, `values` found, `channels` with their curves."""
    record = seen.record
    return {
        "version": seen.version,
        "phase": seen.phase,
        "file": file,
        "rows": record.rows if record is not None else 0,
        "seconds": record.rows * record.period_s if record is not None else 0.0,
        "headline": headline(seen, file),
        "tone": _tone(seen),
        "details": [*_details(seen, actuator, file), *([seen.trouble] if seen.trouble else [])],
        "notes": list(seen.notes),
        "values": _values(seen, actuator),
        "channels": _channels(record, seen.model) if record is not None and seen.model is not None else [],
    }


def headline(seen: Seen, file: str) -> str:
    """Where the recording stands, or the verdict, in one sentence."""
    if seen.found is not None:
        # the reasons stand below, one a line
        verdict, because, _ = sentence(seen.found).partition(BECAUSE)
        return f"{verdict}, which does not stand." if because else verdict
    told = f"{seen.record.rows * seen.record.period_s:.4g} s" if seen.record is not None else ""
    said: dict[Phase, str] = {
        "waiting": f"Waiting for the first rows of {file}.",
        "recording": f"Recording: {told} so far.",
        "judging": f"The recording is complete, {told}: held against every signal now.",
        "judged": f"No verdict on {f'the recording of {told}' if told else file}.",
    }
    return said[seen.phase]


def _tone(seen: Seen) -> str:
    if seen.found is not None:
        return _TONES[seen.found.verdict]
    return "unsure" if seen.phase == "judged" or (seen.trouble and seen.phase == "waiting") else "running"


def _details(seen: Seen, actuator: Actuator, file: str) -> list[str]:
    found = seen.found
    if found is None:
        return []
    held = [f"Held against the healthy runs {', '.join(seen.healthy)}."] if seen.healthy else []
    if found.verdict != "undecided":
        return held
    why = reasons(found)
    # what the sentence says besides them, as of few healthy runs
    besides = sentence(found).partition("; ".join(why) + ".")[2].strip()
    typed = [with_paths(one, actuator.file or "ACTUATOR", [file], seen.healthy) for one in why]
    return [*(f"{one[:1].upper()}{one[1:]}." for one in typed), *filter(None, [besides]), *held]


def _values(seen: Seen, actuator: Actuator) -> list[dict[str, Any]]:
    """CSJ and BLK: of the verdict, or of the rows so far."""
    answer = seen.found.answer if seen.found is not None else seen.so_far
    if answer is None:
        return []
    shown = []
    for one in answer.identified:
        healthy = (seen.found.healthy if seen.found is not None else actuator)[one.name]
        interval = seen.found.interval95(one) if seen.found is not None else (None, None)
        percent = [None if end is None or healthy == 0.0 else 100.0 * (end / healthy - 1.0) for end in interval]
        low, high = percent
        half = 0.5 * (high - low) if low is not None and high is not None else None
        shown.append(
            {
                "title": TITLES.get(one.name, one.name),
                "name": one.name,
                "estimate": f"{one.estimate:.4g}",
                "interval": ends_text(*interval),
                "shift_percent": one.shift_percent,
                "shift_interval_percent": percent,
                "so_far": seen.found is None,
                "shown": f"{shift(one.shift_percent, _decimals(half))} of the healthy value",
                "told": _told(seen, low, high, half),
            }
        )
    return shown


def _decimals(half: float | None) -> int:
    """Of a shift in %: no finer than half of its interval."""
    return 0 if half is not None and half >= _WIDE else 1


def _told(seen: Seen, low: float | None, high: float | None, half: float | None) -> str:
    """What stands under a value."""
    if seen.found is None:
        return "not held against the other signals yet"
    digits = _decimals(half)
    between = "" if low is None or high is None else f"95 %: {shift(low, digits).removesuffix(' %')} … {shift(high, digits)}"
    return "; ".join(filter(None, (between, "does not stand" if seen.found.verdict == "undecided" else "")))


def _channels(record: Record, model: Simulation) -> list[dict[str, Any]]:
    there = [name for name in CHANNELS if record.channel(name) is not None]
    keep = _kept(record, model, there)
    shown = []
    for name in there:
        title, unit, residual_unit, scale = SIGNALS[name]
        left = residual(record, model, name) * scale
        shown.append(
            {
                "name": name,
                "title": title,
                "unit": unit,
                "residual_unit": residual_unit,
                "rms": (rms := float(np.sqrt(np.mean(left**2)))),
                "rms_text": f"residual rms {number(rms)} {residual_unit}",
                "time": _short(record.time_s[keep]),
                "measured": _short(record.recorded(name)[keep]),
                "model": _short(np.asarray(getattr(model, name))[keep]),
                "residual": _short(left[keep]),
            }
        )
    return shown


def _kept(record: Record, model: Simulation, names: list[str]) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Rows that the page draws, in order."""
    if record.rows <= 2 * _BINS:
        return np.arange(record.rows)
    most = np.zeros(record.rows)
    for name in names:
        left = np.abs(residual(record, model, name))
        most += left / (left.max() or 1.0)
    ends = np.linspace(0, record.rows, _BINS + 1).astype(np.intp)
    kept = {int(start) for start in ends[:-1]} | {int(start + np.argmax(most[start:end])) for start, end in itertools.pairwise(ends)}
    return np.array(sorted({*kept, record.rows - 1}), dtype=np.intp)


def _short(values: Reals) -> list[float]:
    return [float(f"{value:.{_DIGITS}g}") for value in values]
