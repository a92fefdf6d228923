"""Work on all cores by threads: a call into the C module releases the interpreter."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def workers() -> int:
    """Threads that run at once: the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def each(work: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None) -> list[Result]:
    """`work` of every item, in their order. `done` is told how many are finished. The first exception ends it and is raised."""
    results: list[Result] = []
    with ThreadPoolExecutor(max_workers=workers()) as pool:
        futures = [pool.submit(work, item) for item in items]
        try:
            for count, future in enumerate(futures, start=1):
                results.append(future.result())
                if done is not None:
                    done(count)
        except BaseException:
            for future in futures:
                future.cancel()
            raise
    return results
