"""A recording of any machine: read as one of a machine whose controller is known where the actuator and the file have what that needs."""

from __future__ import annotations

import glob
from collections.abc import Sequence
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import read_again
from ema_tools.data.actuator import Actuator
from ema_tools.data.motion_records import AnyRecord, MotionRecord, read_motion_record
from ema_tools.data.records import read_record
from ema_tools.data.voltage_drive import with_current

_NEEDED = ("command_mm", "position_mm")
_ENDINGS = (".csv", ".mat", ".parquet", ".pq")


def record_files(names: Sequence[str], held_out: str | None = None) -> tuple[str, ...]:
    """The files that names of files, patterns and folders stand for, those of a pattern or folder in the order of their names and without the one that is held out. Raises InputError for a
    pattern or a folder without any."""
    aside = Path(held_out).resolve() if held_out else None
    found: list[str] = []
    for name in names:
        path = Path(name)
        if path.is_dir():
            here = sorted(str(one) for one in path.iterdir() if one.suffix.lower() in _ENDINGS)
        elif not path.exists() and glob.has_magic(name):
            here = sorted(glob.glob(name))
        else:
            here = [name]
        if here != [name]:
            here = [one for one in here if Path(one).resolve() != aside]
        if not here:
            raise InputError(f"{name}: no recordings there: files end in {', '.join(_ENDINGS)}")
        found += here
    return tuple(found)


def read_any_record(path: str | Path, actuator: Actuator) -> AnyRecord:
    """Read a recording; where a voltage is its only drive, with the current that it makes. Raises InputError in one line that names file, row and field."""
    with read_again(Path(path)) as place:
        if actuator.absent:
            return with_current(read_motion_record(place), actuator)
        try:
            return read_record(place, actuator)
        except InputError as refused:
            # what is not a controlled machine's record may be one of any machine; if it is not, the first complaint says more
            try:
                found = read_motion_record(place)
            except InputError:
                raise refused from None
            if all(name in found.present for name in _NEEDED):
                raise
            return with_current(found, actuator)


def lacks(record: AnyRecord) -> tuple[str, ...]:
    """What a record lacks to be simulated."""
    return tuple(name for name in _NEEDED if name not in record.present) if isinstance(record, MotionRecord) else ()
