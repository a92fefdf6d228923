"""The configuration that firmware compiles in: what `ema export` writes.

Valid in C11 and C++11: initialisers without designators, each value followed by a comment with its field.
Numbers are the shortest decimals that give the float32 value.
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
    """The shortest C literal with the float32 value nearest to `value`."""
    return f"{float(str(np.float32(value)))!r}f"


def _lines(actuator: Actuator, rows: Iterable[Row], indent: str) -> list[str]:
    lines = []
    for row in rows:
        value = actuator[row.name]
        number, remark = literal(value), ""
        if isinstance(row, Parameter) and row.is_option:
            number, remark = str(int(value)), row.choices[int(value)] if row.choices else ""
        elif row.name in MIN_SHIFTS.values():
            remark = _in_comment(actuator.remark(row.name))
        lines.append(f"{indent}{number}, /* {row.field}{': ' if remark else ''}{remark} */")
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


def _head(actuator: Actuator) -> str:
    return f"/* {_title(actuator)}: written by ema export. To change it, change the actuator's TOML file and export again. */"


def _definition(actuator: Actuator) -> list[str]:
    known = load_definitions()
    lines = [
        f"const ema_actuator_t {_NAME} = {{",
        "    { /* params */",
        *_lines(actuator, known.reals, " " * 8),
        "    },",
        "    { /* options */",
        *_lines(actuator, known.options, " " * 8),
        "    },",
        "    { /* effects */",
    ]
    for effect in known.effects:
        lines += [f"        {{ /* {effect.name} */", *_lines(actuator, effect.parameters, " " * 12), "        },"]
    return [*lines, "    },", "};", ""]


def _header(actuator: Actuator, output: str, body: Sequence[str]) -> str:
    lines = [
        _head(actuator),
        f"#ifndef {_GUARD}",
        f"#define {_GUARD}",
        "",
        '#include "ema/ema.h"',
        "",
        *_refusal(_NAME, f"ACTUATOR -o {output}"),
        *body,
        "#endif",
        "",
    ]
    return "\n".join(lines)


def header_text(actuator: Actuator) -> str:
    """A C header with `static const ema_actuator_t EMA_ACTUATOR`: one constant in each file that includes it and uses it."""
    first, *others = _definition(actuator)
    return _header(actuator, "FILE.h", [f"static {first}", *others])


def declaration_text(actuator: Actuator) -> str:
    """A C header with `extern const ema_actuator_t EMA_ACTUATOR`, for C and C++."""
    begin, end = (["#ifdef __cplusplus", line, "#endif", ""] for line in ('extern "C" {', "}"))
    return _header(actuator, "FILE.c", [*begin, f"extern const ema_actuator_t {_NAME};", "", *end])


def source_text(actuator: Actuator, header: str) -> str:
    """The C source that defines what `declaration_text` declares; `header`: name of its file."""
    return "\n".join([_head(actuator), f'#include "{header}"', "", *_definition(actuator)])


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
        f"    {_SIGNATURES_VERSION}U, /* version */",
        f"    {fingerprint(table.actuator)}U, /* fingerprint */",
        f"    {table.record_rows}U, /* record_rows */",
        f"    {table.bin_rows}U, /* bin_rows */",
        f"    {table.bins}U, /* bins */",
        f"    {len(table.signals)}U, /* channels */",
        f"    {{{', '.join(str(CHANNELS.index(name)) for name in table.signals)}}}, /* channel */",
        f"    {len(table.patterns)}U, /* patterns */",
        f"    {len(table.faults)}U, /* faults */",
        f"    {table.nuisances}U, /* nuisances */",
        f"    {len(table.rows)}U, /* rows */",
        f"    {literal(float(command_unit[0]))}, /* command_unit_mm */",
        f"    {literal(table.command_apart_mm)}, /* command_apart_mm */",
        f"    {_reals(reference_unit)}, /* reference */",
        f"    {_reals(table.weight)}, /* weight */",
        f"    {literal(table.limit)}, /* limit */",
        f"    {literal(table.energy)}, /* energy */",
        "    { /* fault */",
        *faults,
        "    },",
        "    ema_exported_patterns, /* pattern */",
        "    ema_exported_units, /* unit */",
        "    ema_exported_values, /* value */",
        "};",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)
