"""`python -m reference_model.vectors OUTDIR` writes every reference vector and `manifest.json`, byte for byte the same each time."""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track

from reference_model.vectors import parts, session, text, trends
from reference_model.vectors.cases import CASES, CHANNELS, Tolerance
from reference_model.vectors.records import OVERSAMPLE, rows_of

VERSION = 1


def _pid_text() -> str:
    lines = text.head("The control law alone: command mm, feedback mm, output; one run per row, 1 ms apart")
    names = " ".join(f"X({case.name}, {case.name.upper()})" for case in parts.PID_CASES)
    lines += [
        f"#define EMA_VEC_PID_CASES(X) {names}",
        f"#define EMA_VEC_PID_RUNS {parts.PID_RUNS}U",
        f"#define EMA_VEC_PID_PERIOD_S {text.real(parts.STEP_S)}",
    ]
    lines += _alone("EMA_VEC_PID_TOLERANCE", parts.PID_TOLERANCE)
    for case in parts.PID_CASES:
        lines += text.settings(f"EMA_VEC_PID_{case.name.upper()}", case.values)
        lines += text.table(f"ema_vec_pid_{case.name}_bits", parts.pid_rows(case))
    return "\n".join(lines) + "\n"


def _command_text() -> str:
    lines = text.head("The commands: value in mm at every EVERY-th step of 1 ms")
    names = " ".join(f"X({case.name}, {case.name.upper()})" for case in parts.COMMAND_CASES)
    lines += [
        f"#define EMA_VEC_COMMAND_CASES(X) {names}",
        f"#define EMA_VEC_COMMAND_ROWS {parts.COMMAND_ROWS}U",
        f"#define EMA_VEC_COMMAND_STEP_S {text.real(parts.STEP_S)}",
    ]
    for case in parts.COMMAND_CASES:
        prefix = f"EMA_VEC_COMMAND_{case.name.upper()}"
        amplitude = abs(case.command.amplitude_mm)
        allowed = {"f64": case.tolerance64 * amplitude, "f32": case.tolerance32 * amplitude}
        _, values = parts.command_rows(case.command, case.every)
        lines += [
            f"#define {prefix}_CONFIG {text.initialiser(case.command)}",
            f"#define {prefix}_EVERY {case.every}U",
            *_alone(f"{prefix}_TOLERANCE_MM", allowed),
            *text.table(f"ema_vec_command_{case.name}_bits", values[:, np.newaxis]),
        ]
    return "\n".join(lines) + "\n"


def _random_text() -> str:
    lines = text.head("The random numbers of a seed and a stream: words, then uniforms and normals of a fresh start")
    calls = " ".join(f"X({index}, 0x{seed:X}ULL, 0x{stream:X}ULL)" for index, (seed, stream) in enumerate(parts.RANDOM_CASES))
    lines += [f"#define EMA_VEC_RANDOM_CASES(X) {calls}", f"#define EMA_VEC_RANDOM_DRAWS {parts.RANDOM_DRAWS}U"]
    lines += _alone("EMA_VEC_RANDOM_NORMAL_TOLERANCE", parts.NORMAL_TOLERANCE)
    for index, (seed, stream) in enumerate(parts.RANDOM_CASES):
        lines += text.words(f"ema_vec_random_{index}_words", parts.random_draws(seed, stream))
        reals = np.array([parts.uniform_draws(seed, stream), parts.normal_draws(seed, stream)]).T
        lines += text.table(f"ema_vec_random_{index}_bits", reals)
    return "\n".join(lines) + "\n"


def _alone(name: str, tolerance: dict[str, float]) -> list[str]:
    wide, narrow = text.real(tolerance["f64"]), text.real(tolerance["f32"])
    return ["#if EMA_REAL64", f"#define {name} {wide}", "#else", f"#define {name} {narrow}", "#endif"]


def _index_text() -> str:
    lines = [
        *text.head("All records of the whole model; X(case, CASE) finds ema_vec_<case>_bits and EMA_VEC_<CASE>_..."),
        "#ifndef EMA_VECTORS_INC",
        "#define EMA_VECTORS_INC",
        "",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        '#include "ema/ema_command.h"',
        '#include "ema/ema_real.h"',
        "",
        "/* The bits of an ema_real: copy them with memcpy. */",
        "#if EMA_REAL64",
        "typedef uint64_t ema_vec_bits_t;",
        "#else",
        "typedef uint32_t ema_vec_bits_t;",
        "#endif",
        "",
        f"#define EMA_VEC_CHANNELS {len(CHANNELS)}U",
        "",
    ]
    lines += [f'#include "ema_vec_{case.name}.inc"' for case in CASES]
    calls = " \\\n".join(f"    X({case.name}, {case.name.upper()})" for case in CASES)
    return "\n".join([*lines, "", "#define EMA_VEC_CASES(X) \\", calls, "", "#endif"]) + "\n"


def _allowed(tolerance: Tolerance) -> dict[str, object]:
    return {
        "largest": dict(zip(CHANNELS, tolerance.largest, strict=True)),
        "rms": dict(zip(CHANNELS, tolerance.rms, strict=True)),
        "why": tolerance.why,
    }


def texts() -> dict[str, str]:
    """Every file by its name."""
    files = {
        "ema_vectors.inc": _index_text(),
        "ema_vec_pid.inc": _pid_text(),
        "ema_vec_commands.inc": _command_text(),
        "ema_vec_random.inc": _random_text(),
        trends.FILE: trends.trend_text(),
    }
    entries: list[dict[str, object]] = []
    for case in track(CASES, "reference vectors", console=Console(stderr=True)):
        rows = rows_of(case)
        name = f"ema_vec_{case.name}.inc"
        files[name] = text.case_text(case, rows)
        entries.append(
            {
                "name": case.name,
                "file": name,
                "shows": case.shows,
                "parameters": case.values,
                "command": dict(vars(case.command)),
                "start_mm": case.start_mm,
                "steps": case.steps,
                "every_rows": case.every_rows,
                "samples": int(rows.shape[0]),
                "tolerance": {"f64": _allowed(case.tolerance64), "f32": _allowed(case.tolerance32)},
            }
        )
    alone = [
        {
            "name": f"pid_{case.name}",
            "file": "ema_vec_pid.inc",
            "shows": case.shows,
            "parameters": case.values,
            "seed": parts.PID_SEED,
            "samples": parts.PID_RUNS,
            "tolerance": {**parts.PID_TOLERANCE, "why": parts.PID_WHY},
        }
        for case in parts.PID_CASES
    ]
    alone += [
        {
            "name": f"command_{case.name}",
            "file": "ema_vec_commands.inc",
            "parameters": vars(case.command),
            "every_steps": case.every,
            "samples": parts.COMMAND_ROWS,
            "tolerance_of_amplitude": {"f64": case.tolerance64, "f32": case.tolerance32, "why": case.why},
        }
        for case in parts.COMMAND_CASES
    ]
    alone += [
        {
            "name": f"random_{index}",
            "file": "ema_vec_random.inc",
            "seed": seed,
            "stream": stream,
            "samples": parts.RANDOM_DRAWS,
            "tolerance": {"words": 0, "uniform": 0.0, "normal": {**parts.NORMAL_TOLERANCE, "why": parts.NORMAL_WHY}},
        }
        for index, (seed, stream) in enumerate(parts.RANDOM_CASES)
    ]
    alone += [
        {
            "name": f"trend_{case.name}",
            "file": trends.FILE,
            "shows": case.shows,
            "samples": case.count,
            "looks": list(case.looks),
            "tolerance_of_value": {**trends.TOLERANCE, "why": trends.WHY},
        }
        for case in trends.CASES
    ]
    files[session.FILE] = (
        json.dumps(
            {
                "shows": "a session with standing effects in its model and grease and winding of the day searched beside CSJ and BLK",
                "source": "the desk's float32 library, record kept in float32; reals as the bits of float32",
                "actuator": f"recordings/unit/{session.ACTUATOR}",
                "record": f"recordings/unit/{session.RECORD}",
                "seed": session.SEED,
                "answer": session.answer(),
            },
            indent=1,
        )
        + "\n"
    )
    manifest = {
        "generator": "reference_model.vectors",
        "version": VERSION,
        "source": "float64 reference model (reference), rounded once to float32 for the f32 tables",
        "same_bits_because": "IEEE additions, multiplications, divisions and square roots in a fixed order, own sine and"
        " exponential, no library function whose last bit differs between machines",
        "oversample": OVERSAMPLE,
        "channels": list(CHANNELS),
        "records": entries,
        "parts": alone,
        "sha256": {name: hashlib.sha256(content.encode()).hexdigest() for name, content in sorted(files.items())},
    }
    files["manifest.json"] = json.dumps(manifest, indent=1) + "\n"
    return files


def main() -> int:
    """Entry point; 0 when all files are written."""
    parser = argparse.ArgumentParser(prog="python -m reference_model.vectors", description=__doc__)
    parser.add_argument("folder", type=Path, metavar="OUTDIR")
    folder: Path = parser.parse_args().folder
    if not folder.is_dir():
        print(f"{folder}: not a folder: make it first", file=sys.stderr)
        return 1
    for name, content in texts().items():
        (folder / name).write_text(content, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
