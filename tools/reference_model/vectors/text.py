"""C text of the vectors: bits in hexadecimal, the number beside them as a comment."""

from __future__ import annotations

import struct
from collections.abc import Iterable

import numpy as np

from ema_tools.library.definitions import EffectParameter, load_definitions
from reference_model.vectors.cases import Case, Command, Tolerance


def bits64(value: float) -> str:
    """The bits of a float64."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}U"


def bits32(value: float) -> str:
    """The bits of the float32 nearest to a float64, rounded once."""
    return f"0x{struct.unpack('<I', struct.pack('<f', value))[0]:08X}U"


def head(title: str) -> list[str]:
    """First lines of a file."""
    return [f"/* {title}", " * Made by `python -m reference_model.vectors`; do not edit. */"]


def table(name: str, rows: np.ndarray) -> list[str]:
    """One array `name[rows][columns]` per precision, chosen by EMA_REAL64."""
    lines = []
    for condition, bits in (("#if EMA_REAL64", bits64), ("#else", bits32)):
        lines += [condition, f"static const ema_vec_bits_t {name}[{rows.shape[0]}][{rows.shape[1]}] = {{"]
        for row in rows:
            # one comment serves both tables
            plain = f" /* {', '.join(f'{value + 0.0:.9g}' for value in row)} */" if bits is bits64 else ""
            lines.append("    {" + ", ".join(bits(float(value) + 0.0) for value in row) + "}," + plain)
        lines.append("};")
    return [*lines, "#endif"]


def words(name: str, values: Iterable[int]) -> list[str]:
    """An array of 32-bit words."""
    numbers = [f"0x{value:08X}U" for value in values]
    lines = [f"static const uint32_t {name}[{len(numbers)}] = {{"]
    lines += ["    " + ", ".join(numbers[start : start + 8]) + "," for start in range(0, len(numbers), 8)]
    return [*lines, "};"]


def real(value: float) -> str:
    """A number as a literal of the module's type."""
    return f"EMA_R({float(value)!r})"


def initialiser(command: Command) -> str:
    """An `ema_command_config_t` with every field named."""
    numbers = ", ".join(
        f".{name} = {real(getattr(command, name))}" for name in ("amplitude_mm", "start_hz", "end_hz", "duration_s", "share", "time_s")
    )
    return f"{{.kind = EMA_COMMAND_{command.kind}, {numbers}, .count = {command.count}U, .samples_mm = NULL}}"


def settings(prefix: str, values: dict[str, float]) -> list[str]:
    """X-macros of what differs from the nominal actuator: X(section, field, value), by kind of value."""
    known = load_definitions()
    overrides, options, effects = [], [], []
    for name, value in values.items():
        row = known.find(name)
        first, field = name.split(".")
        if isinstance(row, EffectParameter):
            effects.append(f"X({first}, {field}, {float(value)!r})")
        elif row.is_option:
            options.append(f"X({first}, {field}, {int(value)})")
        else:
            overrides.append(f"X({first}, {field}, {float(value)!r})")
    found = (("OVERRIDES", overrides), ("OPTIONS", options), ("EFFECTS", effects))
    return [f"#define {prefix}_{kind}(X) {' '.join(calls)}".rstrip() for kind, calls in found]


def limits(prefix: str, tolerance: Tolerance) -> list[str]:
    """The tolerances of a case as initialisers."""
    return [
        f"#define {prefix}_LARGEST {{{', '.join(map(real, tolerance.largest))}}}",
        f"#define {prefix}_RMS {{{', '.join(map(real, tolerance.rms))}}}",
    ]


def case_text(case: Case, rows: np.ndarray) -> str:
    """The file of one record of the whole model; `rows` [n, channels]."""
    prefix = f"EMA_VEC_{case.name.upper()}"
    lines = head(f"{case.shows}: position mm, motor position mm, current A, voltage V, rod speed mm/s")
    lines += settings(prefix, case.values)
    lines += [
        f"#define {prefix}_COMMAND {initialiser(case.command)}",
        f"#define {prefix}_START_MM {real(case.start_mm)}",
        f"#define {prefix}_STEPS {case.steps}U",
        f"#define {prefix}_EVERY_ROWS {case.every_rows}U",
        f"#define {prefix}_ROWS {rows.shape[0]}U",
        "#if EMA_REAL64",
        *limits(prefix, case.tolerance64),
        "#else",
        *limits(prefix, case.tolerance32),
        "#endif",
        *table(f"ema_vec_{case.name}_bits", rows),
    ]
    return "\n".join(lines) + "\n"
