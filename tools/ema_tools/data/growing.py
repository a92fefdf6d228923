"""A recording that another program is still writing: the rows that are complete so far, from a file, a named pipe or a serial line."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from ema_tools.base.errors import InputError
from ema_tools.base.files import readable, reason, standing_in
from ema_tools.data.actuator import Actuator
from ema_tools.data.records import Record, read_record

BYTES_MAX = 64 << 20  # as large as the longest record is; what is longer is no ground test [layout]
_READ = 1 << 20  # bytes at once [layout]
_TAIL = 256  # bytes before the place of reading that tell a file that was written anew from one that grew [layout]


class Growing:
    """The bytes of a recording as they come. `begun` counts how often the file was begun anew: replaced, or cut short."""

    def __init__(self, path: str | Path) -> None:
        """A file that is not there yet is waited for."""
        self.path = Path(path)
        self.begun = 0
        self._bytes = bytearray()
        self._line: int | None = None  # of a pipe or serial line, which is opened once
        self._inode: tuple[int, int] | None = None

    @property
    def file(self) -> str:
        """The name for messages."""
        return readable(self.path.name)

    @property
    def lines(self) -> int:
        """Complete lines so far."""
        return self._bytes.count(b"\n")

    def read(self) -> bool:
        """Take what has come since; whether there is a further complete row, or the file was begun anew. Raises InputError for one that cannot be read, or is too long."""
        rows = self._rows()
        begun = self.begun
        try:
            state = self.path.stat()
            if stat.S_ISREG(state.st_mode):
                self._read_file(state)
            elif stat.S_ISDIR(state.st_mode):
                raise InputError(f"{self.path}: a folder: give the file that the recording is written to")
            else:
                self._read_line()
        except FileNotFoundError:
            return False
        except OSError as error:
            raise InputError(f"{self.path}: {reason(error)}: check the path") from None
        if len(self._bytes) > BYTES_MAX:
            raise InputError(f"{self.file}: more than {BYTES_MAX >> 20} MiB: begin a new file for every ground test")
        return begun != self.begun or self._rows() != rows

    def record(self, actuator: Actuator) -> Record:
        """The complete rows so far. Raises InputError in one line that names file, row and field."""
        with standing_in(self.path, self.file) as kept:
            kept.write_bytes(self._bytes[: self._rows()])
            return read_record(kept, actuator)

    def close(self) -> None:
        """Let go of a pipe or a serial line."""
        if self._line is not None:
            os.close(self._line)
            self._line = None

    def _rows(self) -> int:
        """Bytes up to the end of the last complete row."""
        return self._bytes.rfind(b"\n") + 1

    def _read_file(self, state: os.stat_result) -> None:
        with self.path.open("rb") as stream:
            if self._bytes and not self._has_grown(stream.fileno(), state):
                self.begun += 1
                self._bytes.clear()
            self._inode = (state.st_dev, state.st_ino)
            stream.seek(len(self._bytes))
            while len(self._bytes) <= BYTES_MAX and (more := stream.read(_READ)):
                self._bytes += more

    def _has_grown(self, descriptor: int, state: os.stat_result) -> bool:
        """Whether it is the same file, with all that was read of it still there."""
        size = len(self._bytes)
        if (state.st_dev, state.st_ino) != self._inode or state.st_size < size:
            return False
        known = min(size, _TAIL)
        return (
            os.pread(descriptor, known, size - known) == self._bytes[size - known :]
            and os.pread(descriptor, known, 0) == self._bytes[:known]
        )

    def _read_line(self) -> None:
        if self._line is None:
            self._line = os.open(self.path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
        while len(self._bytes) <= BYTES_MAX:
            try:
                more = os.read(self._line, _READ)
            except BlockingIOError:
                return
            if not more:
                return
            self._bytes += more
