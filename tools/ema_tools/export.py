"""The configuration that firmware compiles in: what `ema export` writes.

Numbers are hexadecimal literals of the float64 values, so that the compiler rounds each once to the module's type; the decimal stands beside it.
"""

from __future__ import annotations

from collections.abc import Iterable

from ema_tools.actuator import Actuator, Row, shown
from ema_tools.definitions import EffectParameter, Parameter, load_definitions
from ema_tools.native import library

_GUARD = "EMA_EXPORTED_ACTUATOR_H"
_NAME = "EMA_ACTUATOR"


def check_for_firmware(actuator: Actuator) -> None:
    """Raises InputError when the float32 build of the module refuses the actuator."""
    values, options = actuator.arrays()
    library(32).check(values, options)


def literal(value: float) -> str:
    """A C literal of the module's type with exactly this value before rounding."""
    if value == int(value) and abs(value) < 1e6:
        return f"EMA_R({value:.1f})"
    sign, digits = ("-", (-value).hex()) if value < 0.0 else ("", value.hex())
    return f"EMA_R({sign}{digits})"


def _remark(row: Row, value: float) -> str:
    unit = f" {row.unit}" if row.unit else ""
    return f"/* {value:.9g}{unit} */"


def _lines(actuator: Actuator, rows: Iterable[Row], indent: str) -> list[str]:
    lines = []
    for row in rows:
        value = actuator[row.name]
        if isinstance(row, Parameter) and row.is_option:
            word = f" /* {row.choices[int(value)]} */" if row.choices else ""
            lines.append(f"{indent}.{row.field} = {int(value)},{word}")
        else:
            lines.append(f"{indent}.{row.field} = {literal(value)}, {_remark(row, value)}")
    return lines


def header_text(actuator: Actuator) -> str:
    """A C header with `static const ema_actuator_t EMA_ACTUATOR`."""
    known = load_definitions()
    title = actuator.name.replace("*/", "* /")
    lines = [
        f"/* {title}: written by ema export. To change it, change the actuator's TOML file and export again. */",
        f"#ifndef {_GUARD}",
        f"#define {_GUARD}",
        "",
        '#include "ema/ema_actuator.h"',
        "",
        f"static const ema_actuator_t {_NAME} = {{",
        "    .params = {",
        *_lines(actuator, known.reals, " " * 8),
        "    },",
        "    .options = {",
        *_lines(actuator, known.options, " " * 8),
        "    },",
        "    .effects = {",
    ]
    for effect in known.effects:
        lines += [f"        .{effect.name} = {{", *_lines(actuator, effect.parameters, " " * 12), "        },"]
    lines += ["    },", "};", "", "#endif", ""]
    return "\n".join(lines)


def flat_text(actuator: Actuator) -> str:
    """`section.field = value` lines, as the host program reads them."""
    known = load_definitions()
    lines = [f"# {actuator.name}: written by ema export"]
    rows: tuple[Row, ...] = (*known.parameters, *known.effect_values)
    for row in rows:
        value = actuator[row.name]
        if isinstance(row, EffectParameter) or not row.is_option:
            text = repr(float(value))
        else:
            text = row.choices[int(value)] if row.choices else str(int(value))
        lines.append(f"{shown(row)} = {text}")
    return "\n".join(lines) + "\n"
