"""`python -m ema_tools.benchmarks.lives --histories 1000 -o docs/REMAINING_LIFE.md`: how well remaining life is foretold on histories whose wear follows no law of the library.

Histories are of four kinds: even wear, wear that feeds on itself (its rate a power of what has worn, integrated), wear in jumps of random size at random times, and wear that stalls and goes
on; some begin with grease that runs in. Readings scatter with heavy tails (Student, 4 degrees of freedom), by a size that is stated a tenth too small, and flights are missing in runs. Units
that do not wear are drawn beside them.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.files import write_text
from ema_tools.fit.wear import READINGS_LEAST, Life, outlook
from ema_tools.plant.trend import OnboardOutlook, onboard_outlooks
from ema_tools.words.terminal.console import progress, run_command

KINDS = ("even", "feeding on itself", "jumps", "stalling")
_SHARES = (0.3, 0.5, 0.7, 0.9)  # of the life gone by when it is foretold
_HALF = 0.5  # of the life, from which on accuracy counts
_LIMIT = 50.0  # %
_LAMBDA_ALPHA = 0.2  # accuracy of the alpha-lambda measure
_FALSE_ALARM = 0.01
_LONG = 12_000.0  # days that are simulated
_UNDERSTATED = 1.1  # scatter, beside what is stated of it


@dataclass(frozen=True)
class Foretold:
    """One forecast: how much of the life had gone, the true time left and what was told, by the desk and by firmware; None where no drift was found yet."""

    kind: str
    share: float
    left: float
    told: Life | None
    onboard: Life | None

    @property
    def apart(self) -> float:
        """By how much of it the medians of desk and firmware differ; infinite where one tells none and the other does."""
        if self.told is None or self.onboard is None:
            return 0.0 if self.told is self.onboard else math.inf
        medians = (self.told.median, self.onboard.median)
        if not all(map(math.isfinite, medians)):
            return 0.0 if medians[0] == medians[1] else math.inf
        return abs(medians[1] - medians[0]) / max(medians[0], 1.0)


@dataclass(frozen=True)
class Still:
    """Whether a unit that does not wear is said to drift: by its last reading at the desk and onboard, and onboard after any of them."""

    desk: bool
    onboard: bool
    ever: bool


def wear_of(kind: str, random: np.random.Generator) -> tuple[Reals, Reals, float]:
    """Days, wear in % and the day on which the limit is reached."""
    days = np.arange(0.0, _LONG, 1.0)
    onset, length = random.uniform(0.0, 300.0), random.uniform(400.0, 1500.0)
    gone = np.maximum(days - onset, 0.0)
    if kind == "even":
        wear = _LIMIT * gone / length
    elif kind == "feeding on itself":
        wear = _feeding(gone, length, random.uniform(0.5, 2.0))
    elif kind == "jumps":
        wear = _jumps(days, onset, length, random)
    else:
        wear = _stalls(gone, length, random)
    if random.random() < 0.3:
        wear = wear - random.uniform(1.0, 4.0) * -np.expm1(-days / random.uniform(20.0, 80.0))
    return days, wear, float(days[int(np.argmax(wear >= _LIMIT))])


def _feeding(gone: Reals, length: float, exponent: float) -> Reals:
    """d wear = C (1 + wear / 10 %)^exponent, so that the limit is reached after `length`: time as a function of wear, turned round."""
    wear = np.linspace(0.0, 40.0 * _LIMIT, 40_000)
    pace = (1.0 + wear / 10.0) ** -exponent
    time = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]))])
    return np.interp(gone, time * length / np.interp(_LIMIT, wear, time), wear)


def _jumps(days: Reals, onset: float, length: float, random: np.random.Generator) -> Reals:
    """Jumps at random times, as many as make the limit in about `length` days, of sizes that vary by their own mean."""
    jumps = int(random.integers(5, 20))
    count = int(4 * jumps * _LONG / length)
    at = onset + np.cumsum(random.exponential(length / jumps, count))
    size = random.gamma(2.0, 0.5 * _LIMIT / jumps, count)
    return np.concatenate([[0.0], np.cumsum(size)])[np.searchsorted(at, days, side="right")]


def _stalls(gone: Reals, length: float, random: np.random.Generator) -> Reals:
    """Even wear that stops once or twice for a while."""
    going = np.ones_like(gone)
    for _ in range(int(random.integers(1, 3))):
        start, lasts = random.uniform(0.2, 0.8) * length, random.uniform(0.2, 0.8) * length
        going[(gone > start) & (gone < start + lasts)] = 0.0
    return _LIMIT / length * np.cumsum(going * (gone > 0.0))


def readings(days: Reals, wear: Reals, until: float, random: np.random.Generator) -> tuple[Reals, Reals, Reals]:
    """Days, readings in % and the standard errors that are stated, with missing flights in runs."""
    at = np.cumsum(random.gamma(2.0, 0.5 * random.uniform(6.0, 25.0), 4000))
    kept = np.ones(at.size, dtype=bool)
    for _ in range(int(random.integers(0, 4))):
        start = int(random.integers(0, 60))
        kept[start : start + int(random.integers(2, 10))] = False
    at = at[kept & (at <= until)]
    std = random.uniform(0.4, 1.5)
    scatter = _UNDERSTATED * std * random.standard_t(4, at.size) / math.sqrt(2.0)
    return at, np.interp(at, days, wear) + scatter, np.full(at.size, std)


def history(seed: int) -> list[Foretold]:
    """The forecasts of one unit that wears."""
    random = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    days, wear, end = wear_of(kind, random)
    at, read, std = readings(days, wear, end, random)
    found = []
    for share in _SHARES:
        seen = at <= share * end
        if not seen.any():
            continue
        left = end - float(at[seen][-1])
        found.append(Foretold(kind, share, left, *_both(at[seen], read[seen], std[seen])))
    return found


def _both(days: Reals, values: Reals, stds: Reals) -> tuple[Life | None, Life | None]:
    """What the desk and what firmware tells of the time left, None without a drift towards the limit."""
    if days.size < READINGS_LEAST:
        return None, None
    desk = outlook(days, values, stds, _LIMIT, _FALSE_ALARM)
    (onboard,) = onboard_outlooks(days, values, stds, _LIMIT, [days.size], _FALSE_ALARM)
    told = desk.life if desk is not None and desk.drift.changed and desk.drift.by > 0.0 else None
    return told, _life(onboard) if onboard.towards else None


def _life(one: OnboardOutlook) -> Life:
    return Life(one.median_days, one.low_days, one.high_days, one.reached_ratio, one.now_percent)


def still(seed: int) -> Still:
    """Whether a unit that does not wear is said to drift."""
    random = np.random.default_rng(1_000_000 + seed)
    at, read, std = readings(np.array([0.0, _LONG]), np.zeros(2), random.uniform(100.0, 1500.0), random)
    desk = outlook(at, read, std, _LIMIT, _FALSE_ALARM)
    if desk is None:
        return Still(False, False, False)
    onboard = [one.drifts for one in onboard_outlooks(at, read, std, _LIMIT, range(READINGS_LEAST, at.size + 1), _FALSE_ALARM)]
    return Still(desk.drift.changed, onboard[-1], any(onboard))


def accuracy(left: float, told: Life | None) -> float:
    """Relative accuracy, 1 less the relative error of the median, not below 0."""
    if told is None or not math.isfinite(told.median):
        return 0.0
    return max(0.0, 1.0 - abs(told.median - left) / left)


def within(left: float, told: Life | None) -> bool:
    """Whether the 90 % interval holds what is left."""
    return told is not None and told.low <= left <= told.high


@dataclass(frozen=True)
class _Score:
    """Of the goals: intervals that hold, accuracy from half life on, units that do not wear and are said to drift."""

    held: float
    cumulative: float
    alarmed: float


def _score(found: Sequence[tuple[float, float, Life | None]], alarms: Sequence[bool]) -> _Score:
    """`found`: share of the life gone, time left, what was told."""
    told = [(share, left, life) for share, left, life in found if life is not None]
    held = _mean([within(left, life) for _, left, life in told])
    return _Score(held, _mean([accuracy(left, life) for share, left, life in told if share >= _HALF]), _mean(alarms))


def document(found: Sequence[Foretold], alarms: Sequence[Still], histories: int) -> str:
    """The document, in Markdown."""
    desk = _score([(one.share, one.left, one.told) for one in found], [one.desk for one in alarms])
    onboard = _score([(one.share, one.left, one.onboard) for one in found], [one.onboard for one in alarms])
    ever = _mean([one.ever for one in alarms])
    apart = np.array([one.apart for one in found])
    same = np.isfinite(apart)
    lines = [
        "# How well remaining life is foretold",
        "",
        "Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:",
        "",
        f"    python -m ema_tools.benchmarks.lives --histories {histories} -o docs/REMAINING_LIFE.md",
        "",
        " ".join((__doc__ or "").partition("\n\n")[2].split()),
        "",
        "| | goal | met | desk | onboard |",
        "|---|---|---|---:|---:|",
        _goal(
            "90 % intervals of the time to the limit that hold it",
            "85 .. 95 %",
            all(0.85 <= one.held <= 0.95 for one in (desk, onboard)),
            *(f"{100.0 * one.held:.1f} %" for one in (desk, onboard)),
        ),
        _goal(
            "cumulative relative accuracy from half life on",
            ">= 0.8",
            all(one.cumulative >= 0.8 for one in (desk, onboard)),
            *(f"{one.cumulative:.2f}" for one in (desk, onboard)),
        ),
        _goal(
            "units that do not wear and are said to drift",
            "<= 1 %",
            all(one.alarmed <= 0.01 for one in (desk, onboard)),
            *(f"{100.0 * one.alarmed:.2f} %" for one in (desk, onboard)),
        ),
        _goal("the same, asked after every reading of the whole history", "<= 1 %", ever <= 0.01, "", f"{100.0 * ever:.2f} %"),
        "",
        (
            "Counted are the forecasts for units that were found to drift by then; without a drift no remaining life is told. Onboard is the module's float32 as firmware runs it, fed reading by"
            " reading; the desk works the same filter out from its equations by other means, in float64."
            f" {'All' if same.all() else f'{int(same.sum())} of {same.size}'} forecasts agree on whether there is a drift and an end, and their medians to {100.0 * float(apart[same].max()):.2g} %."
        ),
        "",
        "By the kind of wear and how much of the life has gone: histories with a drift found by then, share of the intervals that hold the truth, their median width over what is left, relative",
        f"accuracy, and share of medians within {100.0 * _LAMBDA_ALPHA:.0f} % of what is left (alpha-lambda).",
        "",
        "| wear | life gone | drift found | interval holds | width | accuracy | alpha-lambda |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    groups: dict[tuple[str, float], list[Foretold]] = defaultdict(list)
    for one in found:
        groups[one.kind, one.share].append(one)
    for (kind, share), group in sorted(groups.items()):
        there = [one for one in group if one.told is not None]
        width = (
            float(np.median([(one.told.high - one.told.low) / one.left for one in there if one.told is not None])) if there else math.nan
        )
        near = _mean([accuracy(one.left, one.told) >= 1.0 - _LAMBDA_ALPHA for one in there])
        lines.append(
            f"| {kind} | {100.0 * share:.0f} % | {100.0 * len(there) / len(group):.0f} % | {100.0 * _mean([within(one.left, one.told) for one in there]):.0f} % | "
            f"{'no upper end' if math.isinf(width) else f'{width:.1f} x'} | {_mean([accuracy(one.left, one.told) for one in there]):.2f} | {100.0 * near:.0f} % |"
        )
    lines += [
        "",
        "A jump that takes a unit over its limit cannot be seen in the readings before it, and a stall that has begun does not say when it ends; wear that feeds on itself looks in early readings as",
        "wear that goes on evenly does.",
        "",
    ]
    return "\n".join(lines)


def _goal(what: str, goal: str, met: bool, desk: str, onboard: str) -> str:
    return f"| {what} | {goal} | {'yes' if met else '**no**'} | {desk} | {onboard} |"


def _mean(group: Sequence[float]) -> float:
    return float(np.mean(group)) if group else math.nan


@click.command()
@click.option("--histories", type=click.IntRange(4), default=40, show_default=True, help="Units that wear; as many that do not.")
@click.option("-o", "--output", "out", type=click.Path(path_type=Path), help="The document.")
def main(histories: int, out: Path | None) -> None:
    """Foretell the remaining life of units whose wear is known, and say how often it was right."""
    found: list[Foretold] = []
    alarms: list[Still] = []
    with ProcessPoolExecutor() as pool, progress("histories", 2 * histories) as bar:
        for place, one in enumerate(pool.map(history, range(histories)), 1):
            found += one
            bar.update(place)
        for place, alarm in enumerate(pool.map(still, range(histories), chunksize=16), 1):
            alarms.append(alarm)
            bar.update(histories + place)
    text = document(found, alarms, histories)
    if out is None:
        click.echo(text)
    else:
        write_text(out, text, True)


if __name__ == "__main__":
    run_command(main)
