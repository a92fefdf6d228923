"""`python -m benchmarks.lives --histories 1000 -o docs/REMAINING_LIFE.md`: how well remaining life is foretold on histories whose wear follows no law of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np

from benchmarks.lives.document import ASKED_EVERY, Found, Still, document
from benchmarks.lives.histories import AS_ABOVE, GOALS, HARDER, KINDS, LIMIT, LONG, OTHERWISE, Draw, readings, wear_of
from benchmarks.lives.ideal import ideal
from benchmarks.lives.others import OTHER_KINDS, other_wear
from benchmarks.lives.scores import Asked, Said
from ema_tools.base.arrays import Reals
from ema_tools.base.files import write_text
from ema_tools.fit.wear import READINGS_LEAST, outlook
from ema_tools.plant.trend import onboard_outlooks
from ema_tools.words.terminal.console import progress, run_command

_SHARES = (0.3, 0.5, 0.7, 0.9)  # of the life gone by when it is foretold [judgement]
_FALSE_ALARM = 0.01  # of a unit that does not wear [chance]
_STILL_DAYS = (100.0, 1500.0)  # for which a unit is followed that does not wear [judgement]
_OTHERS = 500_000  # first seed of the other processes [layout]
_STILL = 1_000_000  # first seed of units that do not wear [layout]
_DRAWING = 2_000_000  # first seed of what the ideal observer draws [layout]


@dataclass(frozen=True)
class _Unit:
    """Readings [n] of a unit that wears until its limit, and at which shares of its life how many of them are in."""

    seed: int
    kind: str
    days: Reals
    values: Reals
    stds: Reals
    end: float
    looks: tuple[tuple[float, int], ...]

    def asked(self, place: int, told: Said | None) -> Asked:
        """The look of that place with what was told."""
        share, count = self.looks[place]
        return Asked(self.seed, self.kind, share, self.end - float(self.days[count - 1]), told)


def _unit(
    seed: int,
    kinds: Sequence[str],
    wear: Callable[[str, np.random.Generator], tuple[Reals, Reals, float]],
    random: np.random.Generator,
    draw: Draw = GOALS,
) -> _Unit:
    kind = kinds[seed % len(kinds)]
    days, worn, end = wear(kind, random)
    at, read, std = readings(days, worn, end, random, draw)
    counts = [(share, int(np.sum(at <= share * end))) for share in _SHARES]
    return _Unit(seed, kind, at, read, std, end, tuple(one for one in counts if one[1] > 0))


def _drawn(seed: int, draw: Draw) -> _Unit:
    return _unit(seed, KINDS, lambda kind, random: wear_of(kind, random, draw), np.random.default_rng(seed), draw)


def history(seed: int) -> Found:
    """What desk and firmware say of one unit that wears."""
    unit = _drawn(seed, GOALS)
    desk = [unit.asked(place, _desk(unit, count)) for place, (_, count) in enumerate(unit.looks)]
    return Found(desk, _onboard(unit), [], [])


def observed(name: str, seed: int) -> Found:
    """What the ideal observer says of it, drawn by a name of OTHERWISE."""
    draw = OTHERWISE[name]
    unit = _drawn(seed, draw)
    looks = [place for place, (_, count) in enumerate(unit.looks) if count >= READINGS_LEAST]
    # where flights are missing, two looks may be after the same reading
    counts = sorted({unit.looks[place][1] for place in looks})
    told = ideal(unit.days, unit.values, unit.stds, counts, np.random.default_rng(_DRAWING + seed), draw) if looks else []
    both = [(place, told[counts.index(unit.looks[place][1])]) for place in looks]
    said = [unit.asked(place, one.said) for place, one in both]
    return Found([], [], said, [unit.asked(place, Said(one.sharpest, one.said.low, one.said.high)) for place, one in both])


def otherwise(name: str, seed: int) -> list[Asked]:
    """What firmware says of the same unit drawn otherwise, by a name of OTHERWISE."""
    return _onboard(_drawn(seed, OTHERWISE[name]))


def other(seed: int) -> list[Asked]:
    """What firmware says of one unit that wears by another process."""
    return _onboard(_unit(seed, OTHER_KINDS, other_wear, np.random.default_rng(_OTHERS + seed)))


def _desk(unit: _Unit, count: int) -> Said | None:
    found = outlook(unit.days[:count], unit.values[:count], unit.stds[:count], LIMIT, _FALSE_ALARM)
    if found is None or not found.drift.changed or not found.drift.by > 0.0:
        return None
    return Said(found.life.median, found.life.low, found.life.high)


def _onboard(unit: _Unit) -> list[Asked]:
    places = [place for place, (_, count) in enumerate(unit.looks) if count >= READINGS_LEAST]
    told = onboard_outlooks(unit.days, unit.values, unit.stds, LIMIT, [unit.looks[place][1] for place in places], _FALSE_ALARM)
    by_place = {place: Said(one.median_days, one.low_days, one.high_days) for place, one in zip(places, told, strict=True) if one.towards}
    return [unit.asked(place, by_place.get(place)) for place in range(len(unit.looks))]


def still(seed: int) -> Still:
    """Whether a unit that does not wear is said to drift."""
    random = np.random.default_rng(_STILL + seed)
    at, read, std = readings(np.array([0.0, LONG]), np.zeros(2), random.uniform(*_STILL_DAYS), random)
    desk = outlook(at, read, std, LIMIT, _FALSE_ALARM)
    if desk is None:
        return Still(False, False, False)
    onboard = [
        one.drifts for one in onboard_outlooks(at, read, std, LIMIT, [*range(READINGS_LEAST, at.size, ASKED_EVERY), at.size], _FALSE_ALARM)
    ]
    return Still(desk.drift.changed, onboard[-1], any(onboard))


@click.command()
@click.option(
    "--histories",
    type=click.IntRange(4),
    default=40,
    show_default=True,
    help="Units that wear; as many that do not, and as many of other processes.",
)
@click.option(
    "--ideal",
    "ideals",
    type=click.IntRange(4),
    help="The ideal observer is asked of the first so many, which takes some seconds each. [default: a quarter]",
)
@click.option("-o", "--output", "out", type=click.Path(path_type=Path), help="The document.")
def main(histories: int, ideals: int | None, out: Path | None) -> None:
    """Foretell the remaining life of units whose wear is known, and say how often it was right."""
    found, harder = Found([], [], [], []), Found([], [], [], [])
    others: list[Asked] = []
    otherwise_ones: dict[str, list[Asked]] = {name: found.onboard if name == AS_ABOVE else [] for name in OTHERWISE}
    alarms: list[Still] = []
    ideals = min(histories, ideals if ideals is not None else max(4, histories // 4))
    with ProcessPoolExecutor() as pool, progress("histories", (2 + len(OTHERWISE)) * histories + 2 * ideals) as bar:
        done = 0
        for work, count, into in (
            (history, histories, found),
            (partial(observed, AS_ABOVE), ideals, found),
            (partial(observed, HARDER), ideals, harder),
        ):
            for one in pool.map(work, range(count)):
                into.add(one)
                bar.update(done := done + 1)
        for asked in pool.map(other, range(histories), chunksize=16):
            others += asked
            bar.update(done := done + 1)
        for name, some in list(otherwise_ones.items())[1:]:
            for asked in pool.map(partial(otherwise, name), range(histories), chunksize=16):
                some.extend(asked)
                bar.update(done := done + 1)
        for alarm in pool.map(still, range(histories), chunksize=16):
            alarms.append(alarm)
            bar.update(done := done + 1)
    text = document(found, harder.ideal, others, otherwise_ones, alarms, histories, ideals)
    if out is None:
        click.echo(text)
    else:
        write_text(out, text, True)


if __name__ == "__main__":
    run_command(main)
