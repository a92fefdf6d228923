"""How remaining life is measured: accuracy as it is defined, the ideal observer's own equations against the histories that are drawn, and the document."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.lives.document import Found, Still, document
from benchmarks.lives.few_numbers import FewNumbers
from benchmarks.lives.histories import FED, HARDER, KINDS, LENGTHS, LIMIT, ONSETS, POWERS, STALLS, Draw, readings, wear_of
from benchmarks.lives.ideal import ideal
from benchmarks.lives.others import OTHER_KINDS, other_wear
from benchmarks.lives.scores import Asked, Said, accuracy, cumulative, held, unfloored


def _place(ends: tuple[float, float], value: float) -> float:
    return (value - ends[0]) / (ends[1] - ends[0])


def test_accuracy_is_as_it_is_defined() -> None:
    """By hand: one unit of 0.9 and 0.5, one of 0 (three times too long); half a life earlier does not count."""
    told = [
        Asked(0, "even", 0.3, 100.0, Said(1.0, 1.0, 200.0)),
        Asked(0, "even", 0.5, 100.0, Said(90.0, 50.0, 200.0)),
        Asked(0, "even", 0.7, 60.0, Said(30.0, 10.0, 50.0)),
        Asked(1, "even", 0.9, 10.0, Said(30.0, 5.0, math.inf)),
        Asked(2, "even", 0.9, 10.0, None),
    ]
    assert cumulative(told) == pytest.approx((0.7 + 0.0) / 2.0)
    assert held(told) == pytest.approx(0.75)
    assert unfloored(told) == (pytest.approx((0.9 + 0.5 - 1.0) / 3.0), 1.0)
    assert accuracy(10.0, math.inf) == 0.0


@pytest.mark.parametrize("power", [0.5, 1.0, 1.3, 2.0])
def test_wear_that_feeds_on_itself_obeys_its_equation(power: float) -> None:
    """Its rate is that power of what has worn, whatever the time."""
    family = FewNumbers("feeding", 0, False)
    cube = np.array([[0.0, _place(LENGTHS, 1000.0), _place(POWERS, power)]])
    days = np.linspace(0.0, 990.0, 34)
    wear, later, before = (family.wear(cube, days + by)[0] for by in (0.0, 0.01, -0.01))
    rate = (later - before)[1:] / 0.02
    shape = rate / (1.0 + wear[1:] / FED) ** power
    assert shape == pytest.approx(np.full(33, shape[0]), rel=1e-3)
    assert family.end(cube, 500.0)[0] == pytest.approx(1000.0)


@pytest.mark.parametrize("stalls", [0, 1, 2])
def test_the_end_is_where_wear_reaches_the_limit(stalls: int) -> None:
    family = FewNumbers("stalling" if stalls else "even", stalls, True)
    cube = np.random.default_rng(stalls).random((40, family.numbers))
    end = family.end(cube, 300.0)
    for one, day in zip(cube, end, strict=True):
        assert family.wear(one[None, :], np.array([day]))[0, 0] == pytest.approx(LIMIT, abs=0.05)


def test_two_stalls_that_overlap_are_one() -> None:
    """Stalls from 0.3 to 0.7 and from 0.5 to 0.8 of the length: half of it is lost."""
    family = FewNumbers("stalling", 2, False)
    cube = np.array([[_place(ONSETS, 0.0), _place(LENGTHS, 1000.0), *(_place(STALLS, one) for one in (0.3, 0.4, 0.5, 0.3))]])
    assert family.end(cube, 0.0)[0] == pytest.approx(1500.0)
    assert family.wear(cube, np.array([600.0, 900.0]))[0] == pytest.approx([15.0, 20.0])


@pytest.mark.release
def test_the_ideal_observer_knows_what_it_can() -> None:
    """Of twelve units at 90 % of their life, with readings so rare that it soon has them, the intervals hold most, and even wear is foretold to some percent."""
    hold, rare = [], Draw(every=(20.0, 25.0))
    for seed in range(12):
        random = np.random.default_rng(seed)
        kind = KINDS[seed % len(KINDS)]
        days, wear, end = wear_of(kind, random)
        at, read, std = readings(days, wear, end, random, rare)
        count = int(np.sum(at <= 0.9 * end))
        (told,) = ideal(at, read, std, [count], np.random.default_rng(seed))
        left = end - at[count - 1]
        hold.append(told.said.low <= left <= told.said.high)
        assert told.said.low <= told.said.median <= told.said.high
        if kind == "even":
            assert accuracy(left, told.said.median) > 0.8
    assert sum(hold) >= 9


@pytest.mark.parametrize("kind", OTHER_KINDS)
def test_other_processes_reach_the_limit(kind: str) -> None:
    for seed in range(20):
        days, wear, end = other_wear(kind, np.random.default_rng(seed))
        assert np.interp(end, days, wear) >= LIMIT
        assert np.all(np.diff(wear) >= -1e-9)


def test_another_draw_changes_what_it_says_and_no_more() -> None:
    """The unit stays the same in everything that is drawn before."""
    for seed, kind in enumerate(KINDS):
        as_above, fewer = (
            wear_of(kind, np.random.default_rng(seed), draw) for draw in (Draw(), Draw(scatter=(0.3, 3.0), every=(9.0, 10.0)))
        )
        assert np.array_equal(as_above[1], fewer[1]) and as_above[2] == fewer[2]
    random = np.random.default_rng

    def jumps(draw: Draw) -> int:
        """To the limit; grease that runs in falls, and does not count."""
        days, wear, end = wear_of("jumps", random(2), draw)
        return int(np.count_nonzero(np.diff(wear[days <= end]) > 0.05))

    assert 2 <= jumps(Draw(jumps=(5, 20))) <= 30 < jumps(Draw(jumps=(60, 61)))
    days, wear, end = wear_of("even", random(2))
    plain, exact = (readings(days, wear, end, random(5), draw) for draw in (Draw(scatter=(1.0, 1.001)), Draw(scatter=(0.1, 0.1001))))
    assert np.array_equal(plain[0], exact[0]) and exact[2] == pytest.approx(0.1 * plain[2], rel=1e-2)
    assert readings(days, wear, end, random(5), Draw(every=(1.0, 1.1)))[0].size > 2 * plain[0].size


def test_what_is_drawn_keeps_to_its_ranges() -> None:
    """Scatter, days between readings and jumps to the limit lie where the document says, on both sides of their middle."""
    stds, days_between = [], []
    for seed in range(60):
        random = np.random.default_rng(seed)
        days, wear, end = wear_of(KINDS[seed % 4], random)
        at, _, std = readings(days, wear, end, random)
        stds.append(float(std[0]))
        days_between.append(float(np.median(np.diff(at))))
        assert at[-1] <= end
    assert 0.1 <= min(stds) < 0.15 and 0.4 < max(stds) <= 0.5
    assert 0.17 < np.median(stds) < 0.28
    assert 1.0 < min(days_between) < 4.0 < max(days_between) < 9.0


def test_the_document_says_what_was_found() -> None:
    looks = [Asked(seed, KINDS[seed % 4], share, 100.0, Said(90.0, 50.0, 200.0)) for seed in range(8) for share in (0.5, 0.9)]
    others = [Asked(seed, OTHER_KINDS[seed % 4], 0.5, 100.0, None if seed == 0 else Said(80.0, 50.0, math.inf)) for seed in range(8)]
    found = Found([], [], [], [])
    found.add(Found(looks, looks, looks[:6], looks[:6]))
    text = document(found, looks[:6], others, {"exact readings": looks, HARDER: looks}, [Still(False, False, False)] * 50, 8, 4)
    assert "| exact readings | 100 % | 0.90 |  | 0.90 | 0.90 | 0.90 | 0.90 |" in text
    assert f"| {HARDER} | 100 % | 0.90 | 0.90 | 0.90 |" in text
    assert "| cumulative relative accuracy from half life on, of medians | >= 0.8 | yes | 0.90 | 0.90 | 0.90 | 0.90 |" in text
    assert "| 90 % intervals of the time to the limit that hold it | 85 .. 95 % | **no** | 100.0 % |" in text
    assert "--histories 8 --ideal 4" in text
    assert "no upper end" in text
