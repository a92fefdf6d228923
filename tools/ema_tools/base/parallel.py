"""Work on all cores by threads, where a call into the C module releases the interpreter; and tasks that ask for the same kind of work, in lock step."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
Asked = TypeVar("Asked")
Answer = TypeVar("Answer")


def workers() -> int:
    """Threads that run at once: the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def each(work: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None) -> list[Result]:
    """`work` of every item, in their order. `done` is told how many are finished. The first exception ends it and is raised."""
    if len(items) == 1 and done is None:
        # no other core is of use
        return [work(items[0])]
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


def in_step(tasks: Sequence[Generator[Asked, Answer, Result]], answers: Callable[[Sequence[Asked]], Sequence[Answer]]) -> list[Result]:
    """What tasks return that each ask for one thing after another, in their order; what those that still go on ask for is answered all at once, round by round."""
    results: dict[int, Result] = {}
    asked: dict[int, Asked] = {}

    def go_on(place: int, go: Callable[[], Asked]) -> None:
        try:
            asked[place] = go()
        except StopIteration as end:
            results[place] = end.value

    for place, task in enumerate(tasks):
        go_on(place, partial(next, task))
    while asked:
        places, wanted = list(asked), list(asked.values())
        asked.clear()
        for place, answer in zip(places, answers(wanted), strict=True):
            go_on(place, partial(tasks[place].send, answer))
    return [results[place] for place in range(len(tasks))]


@contextmanager
def beside(work: Callable[[], Result]) -> Iterator[Future[Result]]:
    """`work` on a thread of its own while the body runs; leaving waits for it, and its exception is raised where its result is asked for."""
    with ThreadPoolExecutor(max_workers=1) as pool:
        yield pool.submit(work)
