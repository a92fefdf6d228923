"""Work on all cores by threads, where a call into the C module releases the interpreter; and tasks that ask for the same kind of work, in lock step."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import cache, partial
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")
Asked = TypeVar("Asked")
Answer = TypeVar("Answer")


def workers() -> int:
    """Threads that run at once: the cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


@cache
def _helpers() -> ThreadPoolExecutor:
    """Threads that help whoever has work for several cores; kept, since starting them anew for each call costs as much as a short run of the model."""
    return ThreadPoolExecutor(os.cpu_count() or 1)


# Threads that work on items at this moment.
_working: set[int] = set()


def idle() -> int:
    """Cores on which nobody works on an item of `each`, that of the thread that asks among them."""
    return max(1, workers() - len(_working - {threading.get_ident()}))


# a process that was forked has none of its parent's threads
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helpers.cache_clear)
    os.register_at_fork(after_in_child=_working.clear)


def each(work: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None) -> list[Result]:
    """`work` of every item, in their order. `done` is told how many are finished, by the thread that asked. An exception ends it; of several the one of the first item is raised.

    Who asks works too, so that work inside of work waits for no free thread.
    """
    results: dict[int, Result] = {}
    failed: dict[int, BaseException] = {}
    left = iter(range(len(items)))

    def one_after_another() -> Iterator[None]:
        for place in left:
            try:
                results[place] = work(items[place])
            except BaseException as error:
                failed[place] = error
            if failed:
                break
            yield

    def help_out() -> None:
        _working.add(threading.get_ident())
        try:
            for _ in one_after_another():
                pass
        finally:
            _working.discard(threading.get_ident())

    own = threading.get_ident()
    inside = own in _working
    _working.add(own)
    helping = [_helpers().submit(help_out) for _ in range(min(workers(), len(items)) - 1)]
    told = 0
    try:
        for _ in one_after_another():
            while done is not None and told < len(results):
                done(told := told + 1)
    finally:
        # nobody begins another item
        for _ in left:
            pass
        _working.discard(own)
        wait([helper for helper in helping if not helper.cancel()])
        if inside:
            _working.add(own)
    if failed:
        raise failed[min(failed)]
    while done is not None and told < len(results):
        done(told := told + 1)
    return [results[place] for place in range(len(items))]


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
