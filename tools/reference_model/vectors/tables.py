"""Reads the stored vectors and writes them as C tables. The build runs this file by its path, so it needs the standard library alone."""

from __future__ import annotations

import argparse
import hashlib
import json
import struct
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

MANIFEST = "manifest.json"
NUMBERS = "vectors.bin"  # float64, little-endian, the tables of the manifest one after another, row by row
_COMMAND_REALS = ("amplitude_mm", "start_hz", "end_hz", "duration_s", "share", "time_s")

Rows = list[tuple[float, ...]]


def packed(rows: Sequence[Sequence[float]]) -> bytes:
    """A table [rows, columns] as it is stored; negative zero becomes zero."""
    values = [float(value) + 0.0 for row in rows for value in row]
    return struct.pack(f"<{len(values)}d", *values)


@dataclass(frozen=True)
class Stored:
    """The manifest, and the rows of each table by its name."""

    manifest: dict[str, Any]
    rows: dict[str, Rows]


def read(folder: Path) -> Stored:
    """The vectors stored in `folder`. Raises ValueError if the numbers are not those of the manifest."""
    manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    content = (folder / NUMBERS).read_bytes()
    rows: dict[str, Rows] = {}
    offset = 0
    for name, shape in manifest["tables"].items():
        size = 8 * shape["rows"] * shape["columns"]
        part = content[offset : offset + size]
        offset += size
        if hashlib.sha256(part).hexdigest() != shape["sha256"]:
            raise ValueError(
                f"{folder / NUMBERS}: {name} differs from its hash in {MANIFEST}: run python -m reference_model.vectors {folder}"
            )
        rows[name] = list(struct.iter_unpack(f"<{shape['columns']}d", part))
    if offset != len(content):
        raise ValueError(
            f"{folder / NUMBERS}: {len(content)} bytes, {offset} in {MANIFEST}: run python -m reference_model.vectors {folder}"
        )
    return Stored(manifest, rows)


def bits64(value: float) -> str:
    """The bits of a float64."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}U"


def bits32(value: float) -> str:
    """The bits of the float32 nearest to a float64, rounded once."""
    return f"0x{struct.unpack('<I', struct.pack('<f', value))[0]:08X}U"


def table(name: str, rows: Sequence[Sequence[float]]) -> list[str]:
    """One array `name[rows][columns]` per precision, chosen by EMA_REAL64."""
    lines = []
    for condition, bits in (("#if EMA_REAL64", bits64), ("#else", bits32)):
        lines += [condition, f"static const ema_vec_bits_t {name}[{len(rows)}][{len(rows[0])}] = {{"]
        lines += ["    {" + ", ".join(map(bits, row)) + "}," for row in rows]
        lines.append("};")
    return [*lines, "#endif"]


def words(name: str, values: Sequence[float]) -> list[str]:
    """An array of 32-bit words."""
    return [f"static const uint32_t {name}[{len(values)}] = {{", *(f"    0x{int(value):08X}U," for value in values), "};"]


def real(value: float) -> str:
    """A number as a literal of the module's type."""
    return f"EMA_R({float(value)!r})"


def initialiser(command: Mapping[str, Any]) -> str:
    """An `ema_command_config_t` with every field named."""
    numbers = ", ".join(f".{name} = {real(command[name])}" for name in _COMMAND_REALS)
    return f"{{.kind = EMA_COMMAND_{command['kind']}, {numbers}, .count = {command['count']}U, .samples_mm = NULL}}"


def settings(prefix: str, case: Mapping[str, Any]) -> list[str]:
    """X-macros of what differs from the nominal actuator: X(section, field, value), by kind of value."""
    lines = []
    for macro, kind in (("OVERRIDES", "parameters"), ("OPTIONS", "options"), ("EFFECTS", "effects")):
        calls = " ".join(f"X({name.replace('.', ', ')}, {value!r})" for name, value in case.get(kind, {}).items())
        lines.append(f"#define {prefix}_{macro}(X) {calls}".rstrip())
    return lines


def by_precision(name: str, wide: str, narrow: str) -> list[str]:
    """A macro with one value for float64 and one for float32."""
    return ["#if EMA_REAL64", f"#define {name} {wide}", "#else", f"#define {name} {narrow}", "#endif"]


def _head(title: str) -> list[str]:
    return [f"/* {title}; generated from tests/vectors by the build. */"]


def _cases(name: str, names: Sequence[str]) -> str:
    return f"#define {name}(X) {' '.join(f'X({case}, {case.upper()})' for case in names)}"


def _array(values: Sequence[float]) -> str:
    return f"{{{', '.join(map(real, values))}}}"


def _record_text(stored: Stored) -> str:
    manifest = stored.manifest
    lines = [
        *_head("All records of the whole model"),
        "#ifndef EMA_VECTORS_INC",
        "#define EMA_VECTORS_INC",
        "",
        "#include <stddef.h>",
        "#include <stdint.h>",
        "",
        '#include "ema/ema.h"',
        "",
        "/* The bits of an ema_real: copy them with memcpy. */",
        "#if EMA_REAL64",
        "typedef uint64_t ema_vec_bits_t;",
        "#else",
        "typedef uint32_t ema_vec_bits_t;",
        "#endif",
        "",
        f"#define EMA_VEC_CHANNELS {len(manifest['channels'])}U",
    ]
    for case in manifest["records"]:
        prefix, rows = f"EMA_VEC_{case['name'].upper()}", stored.rows[case["name"]]
        wide, narrow = (manifest["tolerances"][case["tolerance"][precision]] for precision in ("f64", "f32"))
        lines += [
            "",
            f"/* {case['shows']}: {', '.join(manifest['channels'])} */",
            *settings(prefix, case),
            f"#define {prefix}_COMMAND {initialiser(case['command'])}",
            f"#define {prefix}_START_MM {real(case['start_mm'])}",
            f"#define {prefix}_STEPS {case['steps']}U",
            f"#define {prefix}_EVERY_ROWS {case['every_rows']}U",
            f"#define {prefix}_ROWS {len(rows)}U",
            *by_precision(f"{prefix}_LARGEST", _array(wide["largest"]), _array(narrow["largest"])),
            *by_precision(f"{prefix}_RMS", _array(wide["rms"]), _array(narrow["rms"])),
            *table(f"ema_vec_{case['name']}_bits", rows),
        ]
    lines += ["", _cases("EMA_VEC_CASES", [case["name"] for case in manifest["records"]]), "", "#endif"]
    return "\n".join(lines) + "\n"


def _pid_text(stored: Stored) -> str:
    shared, cases = stored.manifest["pid"], stored.manifest["pid_cases"]
    tolerance = shared["tolerance"]
    lines = [
        *_head("The control law alone: command mm, feedback mm, output; one run per row"),
        _cases("EMA_VEC_PID_CASES", [case["name"] for case in cases]),
        f"#define EMA_VEC_PID_RUNS {shared['runs']}U",
        f"#define EMA_VEC_PID_PERIOD_S {real(shared['period_s'])}",
        *by_precision("EMA_VEC_PID_TOLERANCE", real(tolerance["f64"]), real(tolerance["f32"])),
    ]
    for case in cases:
        lines += settings(f"EMA_VEC_PID_{case['name'].upper()}", case)
        lines += table(f"ema_vec_pid_{case['name']}_bits", stored.rows[f"pid_alone_{case['name']}"])
    return "\n".join(lines) + "\n"


def _command_text(stored: Stored) -> str:
    shared, cases = stored.manifest["commands"], stored.manifest["command_cases"]
    lines = [
        *_head("The commands: value in mm at every EVERY-th step"),
        _cases("EMA_VEC_COMMAND_CASES", [case["name"] for case in cases]),
        f"#define EMA_VEC_COMMAND_ROWS {shared['rows']}U",
        f"#define EMA_VEC_COMMAND_STEP_S {real(shared['step_s'])}",
    ]
    for case in cases:
        prefix, allowed = f"EMA_VEC_COMMAND_{case['name'].upper()}", case["tolerance_mm"]
        lines += [
            f"#define {prefix}_CONFIG {initialiser(case['command'])}",
            f"#define {prefix}_EVERY {case['every_steps']}U",
            *by_precision(f"{prefix}_TOLERANCE_MM", real(allowed["f64"]), real(allowed["f32"])),
            *table(f"ema_vec_command_{case['name']}_bits", stored.rows[f"command_{case['name']}"]),
        ]
    return "\n".join(lines) + "\n"


def _random_text(stored: Stored) -> str:
    shared, cases = stored.manifest["random"], stored.manifest["random_cases"]
    calls = " ".join(f"X({place}, 0x{case['seed']:X}ULL, 0x{case['stream']:X}ULL)" for place, case in enumerate(cases))
    tolerance = shared["tolerance"]
    lines = [
        *_head("The random numbers of a seed and a stream: words, then uniforms and normals of a fresh start"),
        f"#define EMA_VEC_RANDOM_CASES(X) {calls}",
        f"#define EMA_VEC_RANDOM_DRAWS {shared['draws']}U",
        *by_precision("EMA_VEC_RANDOM_NORMAL_TOLERANCE", real(tolerance["f64"]), real(tolerance["f32"])),
    ]
    for place in range(len(cases)):
        rows = stored.rows[f"random_{place}"]
        lines += words(f"ema_vec_random_{place}_words", [row[0] for row in rows])
        lines += table(f"ema_vec_random_{place}_bits", [row[1:] for row in rows])
    return "\n".join(lines) + "\n"


def _trend_text(stored: Stored) -> str:
    shared, cases = stored.manifest["trend"], stored.manifest["trend_cases"]
    tolerance = shared["tolerance"]
    lines = [
        *_head(f"Trend: readings (day, value %, standard error %), and after some of them: {', '.join(shared['columns'])}"),
        _cases("EMA_VEC_TREND_CASES", [case["name"] for case in cases]),
        f"#define EMA_VEC_TREND_COLUMNS {len(shared['columns'])}U",
        f"#define EMA_VEC_TREND_FALSE_ALARM {real(shared['false_alarm'])}",
        *by_precision("EMA_VEC_TREND_TOLERANCE", repr(tolerance["f64"]), repr(tolerance["f32"])),
    ]
    for case in cases:
        prefix, name = f"EMA_VEC_TREND_{case['name'].upper()}", f"trend_{case['name']}"
        lines += [
            f"#define {prefix}_READINGS {len(stored.rows[f'{name}_readings'])}U",
            f"#define {prefix}_LIMIT {real(case['limit'])}",
            f"#define {prefix}_LOOKS {{{', '.join(f'{count}U' for count in case['looks'])}}}",
            *table(f"ema_vec_{name}_readings", stored.rows[f"{name}_readings"]),
            *table(f"ema_vec_{name}_said", stored.rows[f"{name}_said"]),
        ]
    return "\n".join(lines) + "\n"


def texts(stored: Stored) -> dict[str, str]:
    """The C files by name."""
    return {
        "ema_vectors.inc": _record_text(stored),
        "ema_vec_pid.inc": _pid_text(stored),
        "ema_vec_commands.inc": _command_text(stored),
        "ema_vec_random.inc": _random_text(stored),
        "ema_vec_trend.inc": _trend_text(stored),
    }


def main() -> int:
    """Entry point; 0 when all files are written."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("vectors", type=Path, help="folder of the stored vectors")
    parser.add_argument("output", type=Path, help="folder for the C tables; made if it does not exist")
    arguments = parser.parse_args()
    try:
        files = texts(read(arguments.vectors))
    except (OSError, ValueError) as problem:
        print(problem, file=sys.stderr)
        return 1
    output: Path = arguments.output
    output.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (output / name).write_text(content, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
