"""Tasks in lock step: what they ask for comes round by round, what they return in their order."""

from __future__ import annotations

import os
import threading
from collections.abc import Generator, Sequence

import pytest

from ema_tools.base.parallel import beside, each, idle, in_step, workers


def halvings(number: int) -> Generator[int, float, list[float]]:
    """Asks for the half of a number until it is one."""
    found = []
    while number > 1:
        half = yield number
        found.append(half)
        number = int(half)
    return found


def test_tasks_of_different_lengths_are_answered_round_by_round() -> None:
    rounds: list[list[int]] = []

    def halves(asked: Sequence[int]) -> list[float]:
        rounds.append(list(asked))
        return [number / 2 for number in asked]

    assert in_step([halvings(8), halvings(1), halvings(3), halvings(5)], halves) == [[4.0, 2.0, 1.0], [], [1.5], [2.5, 1.0]]
    assert rounds == [[8, 3, 5], [4, 2], [2]]


def test_what_the_answers_raise_ends_them_all() -> None:
    def none(asked: Sequence[int]) -> list[float]:
        raise ValueError(f"{len(asked)} asked")

    with pytest.raises(ValueError, match="2 asked"):
        in_step([halvings(8), halvings(3)], none)
    assert in_step([], none) == []


@pytest.mark.parametrize("count", [0, 1, 5])
def test_each_keeps_the_order_and_raises_what_is_raised(count: int) -> None:
    told: list[int] = []
    assert each(lambda number: number * number, range(count)) == [number * number for number in range(count)]
    assert each(lambda number: number, range(count), told.append) == list(range(count)) and told == list(range(1, count + 1))
    if count:
        with pytest.raises(ZeroDivisionError):
            each(lambda number: 1 // number, range(count))


def test_cores_without_work_are_known() -> None:
    assert idle() == workers()
    together = threading.Barrier(workers())

    def seen(_: int) -> int:
        together.wait(timeout=10.0)
        found = idle()
        together.wait(timeout=10.0)
        return found

    # each of them has its own core and no other
    assert each(seen, range(workers())) == [1] * workers()
    with pytest.raises(ZeroDivisionError):
        each(lambda number: 1 // number, range(3))
    assert idle() == workers()


def test_work_inside_of_work_waits_for_no_free_thread() -> None:
    def inner(number: int) -> int:
        return sum(each(lambda factor: number * factor, range(20)))

    assert each(inner, range(40)) == [190 * number for number in range(40)]


def test_the_error_of_the_first_item_is_raised_and_no_further_one_begins() -> None:
    begun: list[int] = []
    together = threading.Barrier(workers(), timeout=10.0)

    def work(number: int) -> int:
        begun.append(number)
        together.wait()  # as many as there are threads
        raise ValueError(str(number))

    with pytest.raises(ValueError, match=r"^0$"):
        each(work, range(10 * workers()))
    assert len(begun) == workers()


def test_a_process_that_was_forked_has_threads_of_its_own() -> None:
    each(abs, range(4))
    child = os.fork()
    if child == 0:
        os._exit(0 if each(abs, range(-3, 1)) == [3, 2, 1, 0] else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_work_beside_the_body_raises_where_it_is_asked_for() -> None:
    begun, go_on = threading.Event(), threading.Event()

    def work() -> int:
        begun.set()
        assert go_on.wait(10.0)
        raise ValueError("here")

    with beside(work) as found:
        assert begun.wait(10.0)  # while the body runs
        go_on.set()
        with pytest.raises(ValueError, match="here"):
            found.result()
    with beside(lambda: 5) as kept:
        pass
    assert kept.result() == 5
