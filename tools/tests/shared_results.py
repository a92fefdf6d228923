"""Results that several tests look at: the first process that asks computes them, all others read them until a source, a library or a recording changes.

They lie in `story_cache` of the build folder, one folder for each state of the sources, so that a second test run and every entry of ctest find them.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import inspect
import os
import pickle
import platform
import shutil
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import ParamSpec, TypeVar

import numpy as np

from ema_tools.library.definitions import library_folder

P = ParamSpec("P")
T = TypeVar("T")

_TESTS = Path(__file__).resolve().parent
_ROOT = _TESTS.parents[1]
_SOURCES = ("tools/ema_tools", "tools/tests/records", "tools/reference_model", "tools/page", "benchmarks", "actuators", "recordings")
# A state of the sources that no test run has read for so long is deleted.
_KEPT_S = 24 * 3600.0


def _files() -> Iterator[Path]:
    for folder in (*(_ROOT / name for name in _SOURCES), library_folder()):
        for path in sorted(folder.rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts and path.suffix != ".a":
                yield path
    yield from sorted(path for path in _TESTS.glob("*.py") if not path.name.startswith("test_"))


@functools.cache
def _folder() -> Path:
    """Folder of the present state of the sources; older states are deleted."""
    digest = hashlib.sha256(f"{platform.python_version()} {platform.machine()} {np.__version__}".encode())
    for path in _files():
        digest.update(str(path.relative_to(path.anchor)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    store = library_folder().parent / "story_cache"
    folder = store / digest.hexdigest()[:16]
    folder.mkdir(parents=True, exist_ok=True)
    os.utime(folder)
    for other in store.iterdir():
        if time.time() - other.stat().st_mtime > _KEPT_S:
            shutil.rmtree(other, ignore_errors=True)
    return folder


def _made(function: Callable[..., object], arguments: object, make: Callable[[Path], None]) -> Path:
    """Folder that `make` has filled, by this process or another: named after the function, its file and its arguments."""
    source = Path(inspect.getfile(function))
    digest = hashlib.sha256(source.read_bytes() + repr(arguments).encode()).hexdigest()[:16]
    folder = _folder() / f"{source.stem}-{function.__name__}-{digest}"
    complete = folder / "complete"
    if not complete.exists():
        with folder.with_suffix(".lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not complete.exists():
                # what a killed process left
                shutil.rmtree(folder, ignore_errors=True)
                folder.mkdir()
                make(folder)
                complete.touch()
    return folder


def shared_result(function: Callable[P, T]) -> Callable[P, T]:
    """Like `functools.cache`, for all processes: arguments need a `repr` that says all of them, the result is pickled."""

    @functools.cache
    def result(arguments: tuple[object, ...], named: tuple[tuple[str, object], ...]) -> T:
        def make(folder: Path) -> None:
            (folder / "result").write_bytes(pickle.dumps(function(*arguments, **dict(named))))  # type: ignore[arg-type]

        found: T = pickle.loads((_made(function, (arguments, named), make) / "result").read_bytes())
        return found

    @functools.wraps(function)
    def asked(*arguments: P.args, **named: P.kwargs) -> T:
        return result(arguments, tuple(sorted(named.items())))

    return asked


def shared_folder(function: Callable[[Path], None]) -> Callable[[], Path]:
    """The folder that `function` fills; tests read it and write nothing into it."""

    @functools.cache
    def folder() -> Path:
        return _made(function, (), function)

    return folder
