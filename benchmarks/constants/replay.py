"""Cases replayed with constants changed, or with its readings noted: a process of its own, told what to do on its input, which answers a line of JSON for each case."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TextIO

from benchmarks.constants.changing import install_change, install_notes

ARGUMENTS = "arguments.json"


@dataclass(frozen=True)
class Job:
    """`folders`: by case, its files and the arguments of its call. `keys`: of the constants that are taken times `factor`; none, and readings are noted. `core`: the one to run on."""

    folders: dict[str, str]
    keys: tuple[str, ...] = ()
    factor: float = 1.0
    core: int | None = None

    def text(self) -> str:
        """As the process reads it."""
        return json.dumps(asdict(self))


def outline(answer: dict[str, Any]) -> dict[str, Any]:
    """Of an answer what a user acts on: the verdict, the first name, what is accepted, the weighted error that is left; for one that was refused the line."""
    if "error_line" in answer:
        return {"verdict": "refused", "first": answer["error_line"], "accepted": [], "error": None}
    listed = [*answer["effects"], *({**entry, "name": name} for name, entry in answer["faults"].items())]
    accepted = sorted({one["name"] for one in listed if one["accepted"]})
    first = max(listed, key=lambda one: (one["accepted"], one["score"] or 0.0), default={"name": None})["name"]
    return {"verdict": answer["verdict"], "first": first, "accepted": accepted, "error": answer["error"]["after"]}


@contextlib.contextmanager
def _copied(source: str) -> Iterator[list[str]]:
    """The arguments of a case, its files in the working folder: several processes may replay one case."""
    with tempfile.TemporaryDirectory() as name:
        there = Path(name) / "case"
        shutil.copytree(source, there)
        with contextlib.chdir(there):
            arguments: list[str] = json.loads(Path(ARGUMENTS).read_text(encoding="utf-8"))
            yield arguments


def replay(job: Job, out: TextIO) -> None:
    """Writes a line for each case: name, seconds, outline or the error that ended it, and without a change the constants that were read."""
    changed: dict[str, bool] = {}
    read: set[str] = set()
    imported: set[str] = set()
    if job.keys:
        changed = install_change(job.keys, job.factor)
    else:
        read, imported = install_notes()
    from benchmarks.frozen import whole_answer_to

    for name, folder in job.folders.items():
        read.clear()
        row: dict[str, Any] = {"case": name}
        with _copied(folder) as arguments:
            begun = time.perf_counter()
            try:
                row["outline"] = outline(whole_answer_to(arguments))
            except Exception as error:
                # a constant far from its value may break what relies on it: that is an answer too
                row["broken"] = f"{type(error).__name__}: {error}"[:200]
            row["seconds"] = round(time.perf_counter() - begun, 2)
        if job.keys:
            row["unchanged"] = sorted(key for key, differs in changed.items() if not differs)
        else:
            row |= {"read": sorted(read), "imported": sorted(imported)}
        print(json.dumps(row), file=out, flush=True)


def main() -> None:
    """Entry point."""
    job = Job(**json.load(sys.stdin))
    if job.core is not None and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {job.core})
    out = sys.stdout
    with contextlib.redirect_stdout(sys.stderr):
        replay(job, out)


if __name__ == "__main__":
    main()
