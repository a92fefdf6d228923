"""`python -m reference_model.vectors OUTDIR` writes every reference vector and `manifest.json`, byte for byte the same each time."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import track

from ema_tools.library.definitions import EffectParameter, load_definitions
from reference_model.vectors import parts, session, trends
from reference_model.vectors.cases import CASES, CHANNELS, Case
from reference_model.vectors.records import OVERSAMPLE, rows_of
from reference_model.vectors.tables import MANIFEST, NUMBERS, packed

VERSION = 2


def settings(values: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """`values` by name `section.field`, apart by kind: `parameters` and `effects` as floats, `options` as whole numbers; empty kinds are left out."""
    known = load_definitions()
    found: dict[str, dict[str, float]] = {"parameters": {}, "options": {}, "effects": {}}
    for name, value in values.items():
        row = known.find(name)
        if isinstance(row, EffectParameter):
            found["effects"][name] = float(value)
        elif row.is_option:
            found["options"][name] = int(value)
        else:
            found["parameters"][name] = float(value)
    return {kind: entries for kind, entries in found.items() if entries}


def record_entry(case: Case) -> dict[str, Any]:
    """What the manifest holds of one record of the whole model."""
    return {
        "name": case.name,
        "shows": case.shows,
        **settings(case.values),
        "command": vars(case.command),
        "start_mm": case.start_mm,
        "steps": case.steps,
        "every_rows": case.every_rows,
        "tolerance": {"f64": case.tolerance64.name, "f32": case.tolerance32.name},
    }


def _part_tables() -> dict[str, np.ndarray]:
    """The tables of what is called on its own, [rows, columns] each."""
    rows = {f"pid_alone_{case.name}": parts.pid_rows(case) for case in parts.PID_CASES}
    for case in parts.COMMAND_CASES:
        rows[f"command_{case.name}"] = parts.command_rows(case.command, case.every)[1][:, np.newaxis]
    for place, start in enumerate(parts.RANDOM_CASES):
        rows[f"random_{place}"] = np.array([parts.random_draws(*start), parts.uniform_draws(*start), parts.normal_draws(*start)]).T
    for unit in trends.CASES:
        rows[f"trend_{unit.name}_readings"] = np.array(trends.readings(unit)).T
        rows[f"trend_{unit.name}_said"] = trends.said(unit)
    return rows


def _manifest() -> dict[str, Any]:
    """All but the tables."""
    tolerances = {tolerance.name: tolerance for case in CASES for tolerance in (case.tolerance64, case.tolerance32)}
    return {
        "generator": "reference_model.vectors",
        "version": VERSION,
        "source": "float64 reference model, rounded once to float32 for the f32 tables",
        "same_bits_because": "IEEE additions, multiplications, divisions and square roots in a fixed order, own sine and"
        " exponential, no library function whose last bit differs between machines",
        "oversample": OVERSAMPLE,
        "channels": list(CHANNELS),
        "tolerances": {
            name: {"largest": tolerance.largest, "rms": tolerance.rms, "why": tolerance.why} for name, tolerance in tolerances.items()
        },
        "records": [record_entry(case) for case in CASES],
        "pid": {
            "runs": parts.PID_RUNS,
            "period_s": parts.STEP_S,
            "seed": parts.PID_SEED,
            "tolerance": parts.PID_TOLERANCE,
            "why": parts.PID_WHY,
        },
        "pid_cases": [{"name": case.name, "shows": case.shows, **settings(case.values)} for case in parts.PID_CASES],
        "commands": {"rows": parts.COMMAND_ROWS, "step_s": parts.STEP_S},
        "command_cases": [
            {
                "name": case.name,
                "command": vars(case.command),
                "every_steps": case.every,
                "tolerance_mm": {
                    "f64": case.tolerance64 * abs(case.command.amplitude_mm),
                    "f32": case.tolerance32 * abs(case.command.amplitude_mm),
                },
                "why": case.why,
            }
            for case in parts.COMMAND_CASES
        ],
        "random": {"draws": parts.RANDOM_DRAWS, "tolerance": parts.NORMAL_TOLERANCE, "why": parts.NORMAL_WHY},
        "random_cases": [{"seed": seed, "stream": stream} for seed, stream in parts.RANDOM_CASES],
        "trend": {
            "columns": trends.COLUMNS,
            "false_alarm": trends.FALSE_ALARM,
            "tolerance": trends.TOLERANCE,
            "why": trends.WHY,
        },
        "trend_cases": [{"name": case.name, "shows": case.shows, "limit": case.limit, "looks": case.looks} for case in trends.CASES],
    }


def _text_of(manifest: Mapping[str, Any]) -> str:
    """JSON with one line per entry; a list or an object of objects has one line per object."""
    entries = []
    for key, value in manifest.items():
        objects = list(value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ())
        if not objects or not all(isinstance(part, Mapping) for part in objects):
            entries.append(f"{json.dumps(key)}: {json.dumps(value)}")
        elif isinstance(value, Mapping):
            lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(part)}" for name, part in value.items())
            entries.append(f"{json.dumps(key)}: {{\n{lines}\n }}")
        else:
            lines = ",\n".join(f"  {json.dumps(part)}" for part in value)
            entries.append(f"{json.dumps(key)}: [\n{lines}\n ]")
    return "{\n " + ",\n ".join(entries) + "\n}\n"


def _session_text(search: str) -> str:
    content = {
        "shows": "a session with standing effects in its model and grease and winding of the day searched beside CSJ and BLK",
        "source": "the desk's float32 library, record kept in float32; reals as the bits of float32",
        "actuator": f"recordings/unit/{session.ACTUATOR}",
        "record": f"recordings/unit/{session.RECORD}",
        "seed": session.SEED,
        "search": search,
        "answer": session.answer(search),
    }
    return json.dumps(content, indent=1) + "\n"


def files() -> dict[str, bytes]:
    """Every file by its name."""
    rows = {case.name: rows_of(case) for case in track(CASES, "reference vectors", console=Console(stderr=True))} | _part_tables()
    content = {name: packed(table.tolist()) for name, table in rows.items()}
    manifest = _manifest()
    manifest["tables"] = {
        name: {"rows": table.shape[0], "columns": table.shape[1], "sha256": hashlib.sha256(content[name]).hexdigest()}
        for name, table in rows.items()
    }
    return {
        MANIFEST: _text_of(manifest).encode(),
        NUMBERS: b"".join(content.values()),
        **{name: _session_text(search).encode() for search, name in session.FILES.items()},
    }


def main() -> int:
    """Entry point; 0 when all files are written."""
    parser = argparse.ArgumentParser(prog="python -m reference_model.vectors", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="OUTDIR")
    folder: Path = parser.parse_args().folder
    if not folder.is_dir():
        print(f"{folder}: not a folder: make it first", file=sys.stderr)
        return 1
    for name, content in files().items():
        (folder / name).write_bytes(content)
    return 0


if __name__ == "__main__":
    sys.exit(main())
