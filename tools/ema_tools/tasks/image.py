"""The configuration as data: the binary image of one or more units that `ema_image.h` reads in flash, written and read.

Every number stands with its least byte first, on a boundary of its size. Layout: docs/FIRMWARE.md, "Configuration as data".
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ema_tools.base.errors import InputError
from ema_tools.base.files import reason
from ema_tools.data.actuator import Actuator
from ema_tools.library.definitions import load_definitions
from ema_tools.plant.native import CHANNELS, Table, checked_schema
from ema_tools.results.files import ImageEntry, UnitEntry

_MARK = b"EMAI"
_ORDER = 0x01020304  # reads otherwise in another order of bytes [layout]
_VERSION = 1  # of the image's layout: EMA_IMAGE_VERSION [layout]
_HEAD = struct.Struct("<4s5I")  # mark, order, version, length, schema, units
_ENTRY = struct.Struct("<32s4I")  # name, identity, place of the actuator, place and bytes of the table
_CRC = struct.Struct("<I")
_NAME_BYTES = 31  # the zero behind it not counted [layout]
_FAULTS = 2  # EMA_SIGNATURE_FAULTS_MAX [layout]


@dataclass(frozen=True)
class Unit:
    """A unit as an image holds it: bytes of its actuator, and of its table of signatures, empty without one."""

    name: str
    actuator: bytes
    table: bytes = b""

    @property
    def identity(self) -> int:
        """`ema_actuator_identity`: what tells its configuration from another."""
        return zlib.crc32(self.actuator)


def actuator_bytes(actuator: Actuator) -> bytes:
    """The actuator as `ema_actuator_t` in float32: parameters, options, values of effects."""
    values, options = actuator.arrays()
    reals, count = values.astype("<f4"), len(load_definitions().reals)
    return reals[:count].tobytes() + options.astype("<i4").tobytes() + reals[count:].tobytes()


def identity(actuator: Actuator) -> int:
    """`ema_actuator_identity` of an actuator."""
    return zlib.crc32(actuator_bytes(actuator))


def _padded(values: Sequence[float], count: int) -> list[float]:
    return [*values, *[0.0] * (count - len(values))]


def table_bytes(table: Table) -> bytes:
    """A table of signatures as the image holds it: the members of `ema_signatures_t`, then patterns, units and counts."""
    channels = len(CHANNELS)
    head = struct.pack("<6I", table.version, table.fingerprint, table.record_rows, table.bin_rows, table.bins, len(table.channels))
    head += bytes([*table.channels, *[0] * (channels - len(table.channels))])
    head += struct.pack("<4I", len(table.patterns), len(table.faults), table.nuisances, len(table.unit))
    reals = [table.command_unit_mm, table.command_apart_mm, *_padded(table.reference, channels), *_padded(table.weight, channels)]
    head += np.array([*reals, table.limit, table.energy], dtype="<f4").tobytes()
    for index in range(_FAULTS):
        row = table.faults[index] if index < len(table.faults) else np.zeros(5)
        head += struct.pack("<HBx", int(row[0]), int(row[1])) + row[2:].astype("<f4").tobytes()
    patterns = b"".join(bytes(int(value) for value in row[:4]) + row[4:].astype("<f4").tobytes() for row in table.patterns)
    body = head + patterns + table.unit.astype("<f4").tobytes() + table.value.astype("<i2").tobytes()
    return body + bytes(-len(body) % 4)


def check_table(table: Table, fingerprint: int, file: str) -> None:
    """Raises InputError when the table of `file` was made for another actuator than the one of `fingerprint`."""
    if table.fingerprint != fingerprint:
        raise InputError(f"{file}: its signatures belong to another actuator: make them for this one with --healthy")


def unit_of(actuator: Actuator, table: Table | None = None, name: str | None = None) -> Unit:
    """The actuator as a unit called `name`, its own name where none is given. Raises InputError for a name that an image cannot hold."""
    called = actuator.name if name is None else name
    if not called or not called.isprintable() or len(called.encode()) > _NAME_BYTES:
        raise InputError(f"{actuator.file}: {called!r}: no name for a unit: give one of 1 to {_NAME_BYTES} bytes with --name")
    return Unit(called, actuator_bytes(actuator), b"" if table is None else table_bytes(table))


def joined(others: Sequence[Unit], unit: Unit) -> list[Unit]:
    """The units of an image with one more, or with it in the place of the one of its name."""
    if any(other.name == unit.name for other in others):
        return [unit if other.name == unit.name else other for other in others]
    return [*others, unit]


def image_bytes(units: Sequence[Unit]) -> bytes:
    """The image of these units, each of another name."""
    place = _HEAD.size + _ENTRY.size * len(units)
    entries, parts = b"", b""
    for unit in units:
        table_place = place + len(parts) + len(unit.actuator)
        entries += _ENTRY.pack(unit.name.encode(), unit.identity, place + len(parts), table_place if unit.table else 0, len(unit.table))
        parts += unit.actuator + unit.table
    length = place + len(parts) + _CRC.size
    whole = _HEAD.pack(_MARK, _ORDER, _VERSION, length, checked_schema(), len(units)) + entries + parts
    return whole + _CRC.pack(zlib.crc32(whole))


def read_image(path: str | Path) -> list[Unit]:
    """The units of an image. Raises InputError when the file is none, is damaged, or was made for other lists or by another version."""
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: name an image that `ema export --image` wrote") from None
    if len(data) < _HEAD.size + _CRC.size or not data.startswith(_MARK):
        raise InputError(f"{path}: no image: name one that `ema export --image` wrote")
    _, order, version, length, schema, count = _HEAD.unpack_from(data)
    sound = order == _ORDER and version == _VERSION and length == len(data)
    if not sound or zlib.crc32(data[: -_CRC.size]) != _CRC.unpack_from(data, len(data) - _CRC.size)[0]:
        raise InputError(f"{path}: of another version, cut off or damaged: export it again")
    if schema != checked_schema():
        raise InputError(f"{path}: made for other lists of values than those of this module: export it again")
    size = len(load_definitions().value_names + load_definitions().option_names) * 4
    units = []
    for index in range(count):
        name, _, place, table, more = _ENTRY.unpack_from(data, _HEAD.size + index * _ENTRY.size)
        units.append(Unit(name.rstrip(b"\0").decode(), data[place : place + size], data[table : table + more] if table else b""))
    return units


def entry(file: str, data: bytes, units: Sequence[Unit]) -> ImageEntry:
    """The image for a result file."""
    held = tuple(UnitEntry(unit.name, f"{unit.identity:08x}", len(unit.table)) for unit in units)
    return ImageEntry(file, len(data), f"{checked_schema():08x}", held)
