"""Reading and writing files with one-line complaints; nothing is overwritten unless asked."""

from __future__ import annotations

import codecs
import contextlib
import io
import json
import math
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from ema_tools.base.errors import InputError


def readable(text: str | Path) -> str:
    """`text` with only what UTF-8 can hold: the bytes of a file name that are not UTF-8 are shown as \\xff.

    The system hands such a name over with a lone surrogate in the place of each byte, and opens the file by it; no text can be written with one.
    """
    return re.sub("[\ud800-\udfff]", lambda lone: f"\\x{ord(lone[0]) - 0xDC00:02x}" if lone[0] >= "\udc80" else "?", str(text))


def show_any_name(stream: TextIO) -> None:
    """Lets a stream take what its encoding cannot hold, as `readable` writes it."""

    def shown(error: UnicodeError) -> tuple[str, int]:
        if not isinstance(error, UnicodeEncodeError):
            raise error
        text = readable(error.object[error.start : error.end])
        return text.encode(error.encoding, "backslashreplace").decode(error.encoding), error.end

    codecs.register_error("ema_readable", shown)
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="ema_readable")


def one_line(text: str) -> str:
    """`text` without line ends and other control characters, for a line of a file."""
    return " ".join("".join(one if one.isprintable() else " " for one in text).split())


def read_text(path: str | Path) -> str:
    """The UTF-8 text of a file. Raises InputError when it cannot be read."""
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: check the path") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: byte {error.start} is not UTF-8: save the file as UTF-8") from None


@contextlib.contextmanager
def read_again(path: Path) -> Iterator[Path]:
    """`path`, or a file with what comes out of it when it is a pipe: that gives its bytes once. What is said of that file is said of `path`."""
    try:
        once = stat.S_ISFIFO(path.stat().st_mode)
    except OSError:
        once = False  # the reader says why
    if not once:
        yield path
        return
    with standing_in(path, os.fspath(path)) as copy:
        try:
            with path.open("rb") as source, copy.open("wb") as kept:
                shutil.copyfileobj(source, kept)
        except OSError as error:
            raise InputError(f"{path}: {reason(error)}: write the recording to a file first") from None
        yield copy


@contextlib.contextmanager
def standing_in(path: Path, said: str) -> Iterator[Path]:
    """A place for a file that is read in place of `path`; what is said of it is said of `said`."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        try:
            yield copy
        except InputError as error:
            raise InputError(str(error).replace(str(copy), said)) from None


def reason(error: OSError) -> str:
    """Why the system refused, in lower case."""
    if isinstance(error, IsADirectoryError):
        return "is a folder, and one file is wanted here"
    text = error.strerror or str(error)
    return text[:1].lower() + text[1:]


def may_write(path: str | Path, force: bool) -> Path:
    """The file that `path` means, symbolic links followed, when it may be written; its folder is made.

    Raises InputError when it exists and `force` is not set, when it is no regular file (writing would put one in the place of a device or pipe), or
    when the folder cannot be made.
    """
    target = Path(os.path.realpath(path))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        mode = None
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: choose another place") from None
    if mode is not None and stat.S_ISDIR(mode):
        raise InputError(f"{path}: is a folder: name a file")
    if mode is not None and not stat.S_ISREG(mode):
        raise InputError(f"{path}: is a device or pipe, not a file: name a file")
    if mode is not None and not force:
        raise InputError(f"{path}: exists already: choose another name or give --force")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: {reason(error)}: choose another place") from None
    return target


def has_folder(path: str | Path) -> None:
    """Raises InputError when the folder that a file is to be written in does not exist."""
    if not Path(os.path.realpath(path)).parent.is_dir():
        raise InputError(f"{path}: there is no folder {Path(path).parent}: make it, or choose another place")


def keep_apart(outputs: Iterable[str | Path], inputs: Iterable[str | Path] = ()) -> None:
    """Raises InputError when an output is also an input, or two outputs are one file; links are followed."""
    sources = list(inputs)
    seen: list[str | Path] = []
    for output in outputs:
        if any(_same(output, source) for source in sources):
            raise InputError(f"{output}: is read by this command and would be overwritten: choose another name for the output")
        if any(_same(output, other) for other in seen):
            raise InputError(f"{output}: named for two outputs: give each its own name")
        seen.append(output)


def _same(first: str | Path, second: str | Path) -> bool:
    """Whether two paths lead to one file, which need not exist."""
    try:
        return os.path.samefile(first, second)
    except OSError:
        return os.path.realpath(first) == os.path.realpath(second)


def write_text(path: str | Path, text: str, force: bool = False) -> None:
    """Write a UTF-8 file in one go: it is whole or not there. Raises InputError as `may_write`."""
    write_bytes(path, readable(text).encode(), force)


def write_bytes(path: str | Path, data: bytes, force: bool = False) -> None:
    """Write a file in one go, as `write_text`."""
    target = may_write(path, force)
    part = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        part.write_bytes(data)
        part.replace(target)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(f"{path}: {reason(error)}: choose another place") from None


def are_finite(values: Sequence[Any]) -> bool:
    """Whether a sequence holds finite numbers of Python alone: curves have thousands."""
    return {*map(type, values)} == {float} and all(map(math.isfinite, values))


def plain(value: Any) -> Any:
    """`value` for JSON: arrays become lists, numbers that are not finite null, text what UTF-8 can hold."""
    if isinstance(value, Mapping):
        return {readable(str(key)): plain(inner) for key, inner in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return list(value) if are_finite(value) else [plain(inner) for inner in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, str | Path):
        return readable(value)
    return value


def _indented(value: Any, margin: str = "\n") -> str:
    """The text of `json.dumps` with an indent of 1 for a value of `plain`. With an indent that is worked out in Python, number by number; rows of numbers, which make
    up nearly all of a result, are not."""
    inner = margin + " "
    if isinstance(value, dict) and value:
        parts = [f"{json.dumps(key)}: {_indented(one, inner)}" for key, one in value.items()]
        return "{" + inner + ("," + inner).join(parts) + margin + "}"
    if isinstance(value, list) and value:
        if {*map(type, value)} <= {float, int, type(None)}:
            return "[" + inner + json.dumps(value, allow_nan=False)[1:-1].replace(", ", "," + inner) + margin + "]"
        return "[" + inner + ("," + inner).join(_indented(one, inner) for one in value) + margin + "]"
    return json.dumps(value, allow_nan=False)


def write_json(path: str | Path, result: Mapping[str, Any], force: bool = False) -> None:
    """Write a result. Raises InputError as `may_write`."""
    write_text(path, _indented(plain(result)) + "\n", force)


def read_json(path: str | Path) -> dict[str, Any]:
    """Read a result. Raises InputError when it is not a JSON object."""
    try:
        result = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, row {error.lineno}: {error.msg}: give a file that --json wrote") from None
    if not isinstance(result, dict):
        raise InputError(f"{path}: not a result: give a file that --json wrote")
    return result
