"""The configuration that firmware compiles in: what `ema export` writes.

Numbers are hexadecimal literals of the float64 values, so that the compiler rounds each once to the module's type; the decimal stands beside it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.data.actuator import Actuator, Row, shown
from ema_tools.library.definitions import EffectParameter, Parameter, load_definitions
from ema_tools.plant.native import CHANNELS, checked_schema, library
from ema_tools.tasks.onboard_search import MIN_SHIFTS, check_bounds
from ema_tools.tasks.signature_table import Signatures

_GUARD = "EMA_EXPORTED_ACTUATOR_H"
_NAME = "EMA_ACTUATOR"
_SIGNATURES_GUARD = "EMA_EXPORTED_SIGNATURES_H"
_SIGNATURES_NAME = "EMA_SIGNATURES"
_SIGNATURES_VERSION = 1  # of ema_signatures_t: version of its layout [layout]
_FULL = 32767  # its largest count [layout]
_LINE = 24  # numbers of a line [layout]
_TITLE = 200  # characters of a user's text in a comment [layout]


def check_for_firmware(actuator: Actuator) -> None:
    """Raises InputError when the float32 build of the module refuses the actuator, or a search that begins at its healthy values."""
    values, options = actuator.arrays()
    library(32).check(values, options)
    check_bounds(actuator)


def literal(value: float) -> str:
    """A C literal of the module's type with exactly this value before rounding."""
    if value == int(value) and abs(value) < 1e6:
        return f"EMA_R({value:.1f})"
    sign, digits = ("-", (-value).hex()) if value < 0.0 else ("", value.hex())
    return f"EMA_R({sign}{digits})"


def _remark(row: Row, value: float, more: str = "") -> str:
    unit = f" {row.unit}" if row.unit else ""
    text = f"; {_in_comment(more)}" if more else ""
    return f"/* {value:.9g}{unit}{text} */"


def _lines(actuator: Actuator, rows: Iterable[Row], indent: str) -> list[str]:
    lines = []
    for row in rows:
        value = actuator[row.name]
        if isinstance(row, Parameter) and row.is_option:
            word = f" /* {row.choices[int(value)]} */" if row.choices else ""
            lines.append(f"{indent}.{row.field} = {int(value)},{word}")
        else:
            more = actuator.remark(row.name) if row.name in MIN_SHIFTS.values() else ""
            lines.append(f"{indent}.{row.field} = {literal(value)}, {_remark(row, value, more)}")
    return lines


def _title(actuator: Actuator) -> str:
    """The actuator's name as a part of a comment, in C and for the host program, which takes no line of more than 1023 bytes."""
    return _in_comment(actuator.name)


def _in_comment(text: str) -> str:
    return text.replace("*/", "* /").replace("/*", "/ *")[:_TITLE]


def _refusal(what: str, arguments: str) -> list[str]:
    """What makes the compiler refuse a header of other lists than the module's."""
    return [
        f"#if EMA_CONFIG_SCHEMA != 0x{checked_schema():08x}U",
        f'#error "{what}: made for other lists of values than those of this module: export it again: ema export {arguments}"',
        "#endif",
        "",
    ]


def header_text(actuator: Actuator) -> str:
    """A C header with `static const ema_actuator_t EMA_ACTUATOR`."""
    known = load_definitions()
    title = _title(actuator)
    lines = [
        f"/* {title}: written by ema export. To change it, change the actuator's TOML file and export again. */",
        f"#ifndef {_GUARD}",
        f"#define {_GUARD}",
        "",
        '#include "ema/ema.h"',
        "",
        *_refusal(_NAME, "ACTUATOR -o FILE.h"),
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
    lines = [f"# {_title(actuator)}: written by ema export"]
    for row in known.rows:
        value = actuator[row.name]
        if isinstance(row, EffectParameter) or not row.is_option:
            text = repr(float(value))
        else:
            text = row.choices[int(value)] if row.choices else str(int(value))
        lines.append(f"{shown(row)} = {text}")
    return "\n".join(lines) + "\n"


def fingerprint(actuator: Actuator) -> int:
    """`ema_onboard_fingerprint`: a checksum of the actuator's numbers as float32 and of its options, CSJ and BLK left out."""
    values, options = actuator.arrays()
    single = values.astype(np.float32)
    ids = load_definitions().ids
    single[[ids["screw.csj_Nm"], ids["screw.blk_mm"]]] = 0.0
    found = 2166136261
    for word in (*single.view(np.uint32).tolist(), *options.view(np.uint32).tolist()):
        found = ((found ^ word) * 16777619) & 0xFFFFFFFF
    return found


def _counts(values: Reals) -> tuple[Reals, Reals]:
    """Whole numbers of 16 bits for rows [k, ...], and what one count of each row stands for [k]."""
    largest = np.max(np.abs(values.reshape(len(values), -1)), axis=1)
    unit = np.where(largest > 0.0, largest, 1.0) / _FULL
    return np.rint(values / unit.reshape(-1, *[1] * (values.ndim - 1))), unit


def _array(head: str, words: Sequence[str], per_line: int) -> list[str]:
    lines = [", ".join(words[k : k + per_line]) for k in range(0, len(words), per_line)]
    return [f"{head} = {{", *(f"    {line}," for line in lines), "};", ""]


def _reals(values: Iterable[float]) -> str:
    return "{" + ", ".join(literal(float(value)) for value in values) + "}"


def signatures_text(table: Signatures) -> str:
    """A C header with `static const ema_signatures_t EMA_SIGNATURES`, for the actuator in the header beside it."""
    known = load_definitions()
    place = {effect.name: k for k, effect in enumerate(known.effects)}
    command, command_unit = _counts(table.command_mm[None])
    reference, reference_unit = _counts(table.reference)
    rows, unit = _counts(table.rows)
    # a bin: the command, the reference of each signal, then the signals of each row
    values = np.concatenate([command.T, reference.T, np.moveaxis(rows, 2, 0).reshape(table.bins, -1)], axis=1).astype(np.int64)
    patterns = [
        f"{{{place[one.effect]}, {one.first}, {one.rows}, {str(one.one_sided).lower()}, {_reals(one.turn)}, {literal(one.penalty)}}}, /* {one.effect} */"
        for one in table.patterns
    ]
    faults = [
        f"        {{{known.ids[one.name]}, {one.row}, {literal(one.healthy)}, {literal(one.turn)}, {literal(one.length)}}}, /* {one.name} */"
        for one in table.faults
    ]
    title = _title(table.actuator)
    lines = [
        f"/* {title}: signatures of {len({one.effect for one in table.patterns})} effects in {', '.join(table.signals)} under the ground test, {2 * table.numbers} bytes.",
        " * Written by ema export: it belongs to the actuator exported with it and to that one command. */",
        f"#ifndef {_SIGNATURES_GUARD}",
        f"#define {_SIGNATURES_GUARD}",
        "",
        '#include "ema/ema.h"',
        "",
        *_refusal(_SIGNATURES_NAME, "ACTUATOR -o FILE.h --signatures FILE.h --healthy REC ..."),
        "static const ema_pattern_t ema_exported_patterns[] = {",
        *(f"    {line}" for line in patterns),
        "};",
        "",
        *_array("static const ema_real ema_exported_units[]", [literal(float(value)) for value in unit], 4),
        *_array("static const int16_t ema_exported_values[]", [str(value) for value in values.ravel().tolist()], _LINE),
        f"static const ema_signatures_t {_SIGNATURES_NAME} = {{",
        f"    .version = {_SIGNATURES_VERSION}U,",
        f"    .fingerprint = {fingerprint(table.actuator)}U,",
        f"    .record_rows = {table.record_rows}U,",
        f"    .bin_rows = {table.bin_rows}U,",
        f"    .bins = {table.bins}U,",
        f"    .channels = {len(table.signals)}U,",
        f"    .channel = {{{', '.join(str(CHANNELS.index(name)) for name in table.signals)}}},",
        f"    .patterns = {len(table.patterns)}U,",
        f"    .faults = {len(table.faults)}U,",
        f"    .nuisances = {table.nuisances}U,",
        f"    .rows = {len(table.rows)}U,",
        f"    .command_unit_mm = {literal(float(command_unit[0]))},",
        f"    .command_apart_mm = {literal(table.command_apart_mm)},",
        f"    .reference = {_reals(reference_unit)},",
        f"    .weight = {_reals(table.weight)},",
        f"    .limit = {literal(table.limit)},",
        f"    .energy = {literal(table.energy)},",
        "    .fault = {",
        *faults,
        "    },",
        "    .pattern = ema_exported_patterns,",
        "    .unit = ema_exported_units,",
        "    .value = ema_exported_values,",
        "};",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)
