"""What docs/REMAINING_LIFE.md says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.lives import histories as goals
from benchmarks.lives import others as other_processes
from benchmarks.lives.scores import Asked, Said, accuracy, cumulative, held, mean, unfloored, within

ASKED_EVERY = 5  # readings after which a unit that does not wear is asked again [effort]
_LAMBDA_ALPHA = 0.2  # accuracy of the alpha-lambda measure [judgement]


@dataclass(frozen=True)
class Still:
    """Whether a unit that does not wear is said to drift: by its last reading at the desk and onboard, and onboard after any of them."""

    desk: bool
    onboard: bool
    ever: bool


@dataclass(frozen=True)
class Found:
    """What desk, firmware and the ideal observer said; `sharpest`: the latter's points of the greatest accuracy to be expected in place of medians."""

    desk: list[Asked]
    onboard: list[Asked]
    ideal: list[Asked]
    sharpest: list[Asked]

    def add(self, one: Found) -> None:
        """Appends what was said of another unit."""
        for mine, its in zip(
            (self.desk, self.onboard, self.ideal, self.sharpest), (one.desk, one.onboard, one.ideal, one.sharpest), strict=True
        ):
            mine.extend(its)


def document(
    found: Found,
    harder: Sequence[Asked],
    others: Sequence[Asked],
    otherwise: Mapping[str, Sequence[Asked]],
    alarms: Sequence[Still],
    histories: int,
    ideals: int,
) -> str:
    """The document, in Markdown: of so many histories of each sort, the ideal observer asked of the first `ideals`; and of HARDER; `otherwise`: the same drawn otherwise, by what."""
    ideal, sharpest, beside = _asked_of(found.ideal, found.desk), _asked_of(found.sharpest, found.desk), _asked_of(found.desk, found.ideal)
    apart = np.array([_apart(desk.told, onboard.told) for desk, onboard in zip(found.desk, found.onboard, strict=True)])
    same = np.isfinite(apart)
    both = (found.desk, found.onboard)
    alarmed = (mean([one.desk for one in alarms]), mean([one.onboard for one in alarms]))
    ever = mean([one.ever for one in alarms])
    low, share = unfloored(found.desk)
    lines = [
        "# How well remaining life is foretold",
        "",
        "Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`:",
        "",
        f"    python -m benchmarks.lives --histories {histories} --ideal {ideals} -o docs/REMAINING_LIFE.md",
        "",
        _words(goals.__doc__),
        "",
        "| | goal | met | desk | onboard | ideal | desk beside it |",
        "|---|---|---|---:|---:|---:|---:|",
        _goal(
            "90 % intervals of the time to the limit that hold it",
            "85 .. 95 %",
            all(0.85 <= held(one) <= 0.95 for one in both),
            [f"{100.0 * held(one):.1f} %" for one in (*both, ideal, beside)],
        ),
        _goal(
            "cumulative relative accuracy from half life on, of medians",
            ">= 0.8",
            all(cumulative(one) >= 0.8 for one in both),
            [f"{cumulative(one):.2f}" for one in (*both, ideal, beside)],
        ),
        f"| the same of the points where the greatest is to be expected | | | | | {cumulative(sharpest):.2f} | |",
        _goal(
            "units that do not wear and are said to drift",
            "<= 1 %",
            all(one <= 0.01 for one in alarmed),
            [*(f"{100.0 * one:.2f} %" for one in alarmed), "", ""],
        ),
        _goal(
            f"the same, asked after every {ASKED_EVERY}th reading of the whole history",
            "<= 1 %",
            ever <= 0.01,
            ["", f"{100.0 * ever:.2f} %", "", ""],
        ),
        "",
        (
            "Counted are the forecasts for units that were found to drift by then; without a drift no remaining life is told. Onboard is the module's float32 as firmware runs it, fed reading by"
            " reading; the desk's is written from the same equations on its own, in float64."
            f" {'All' if same.all() else f'{int(same.sum())} of {same.size}'} forecasts agree on whether there is a drift and an end, and their medians to {100.0 * float(apart[same].max()):.2g} %."
        ),
        "",
        (
            f"**Ideal** is an observer who knows how these histories are drawn, kinds, priors, scatter and all, and works out by Bayes' rule what can be known of the time left (asked of the first {ideals}"
            " of them, at the looks at which the desk told one; the last column is the desk at the same looks). What it lacks is not in the readings: no filter can have it on the average, whatever its"
            " laws. What the filter lacks beside it is what the priors are worth, which a filter for machines of unknown wear does not have."
        ),
        "",
        (
            "Relative accuracy is `1 - |told - left| / left` of the median, cumulative accuracy its mean over a unit's instants (at 50, 70 and 90 % of the time from the first reading to the limit, of equal"
            ' weight) and then over units, as Saxena et al. define them (2010, "Metrics for offline evaluation of prognostic performance"). A median more than twice as long as what is left, or without end,'
            f" counts 0; with what is below 0 left as it is, the desk's mean over the {100.0 * share:.0f} % of forecasts that have an end is {low:.2f}. The median is what is told: it is wrong on either"
            " side as often. The point where the greatest relative accuracy is to be expected lies before it, since too short a time can be wrong by no more than all of it."
        ),
        "",
        "| wear | accuracy from half life on: desk | desk beside the ideal | ideal | ideal, sharpest point |",
        "|---|---:|---:|---:|---:|",
        *(
            f"| {kind} | {' | '.join(f'{cumulative([one for one in group if one.kind == kind]):.2f}' for group in (found.desk, beside, ideal, sharpest))} |"
            for kind in goals.KINDS
        ),
        "",
        (
            "By the kind of wear and how much of the life has gone: histories with a drift found by then, share of the intervals that hold the truth, their median width over what is left, relative"
            f" accuracy beside the ideal one's, and share of medians within {100.0 * _LAMBDA_ALPHA:.0f} % of what is left (alpha-lambda)."
        ),
        "",
        "| wear | life gone | drift found | interval holds | width | accuracy | ideal | alpha-lambda |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
        *_rows(found.desk, goals.KINDS, lambda kind, share: _ratio([one for one in ideal if (one.kind, one.share) == (kind, share)])),
        "",
        (
            "A jump that takes a unit over its limit cannot be seen in the readings before it, and a stall that has begun does not say when it ends; wear that feeds on itself looks in early readings as"
            " wear that goes on evenly does."
        ),
        "",
        "## What the accuracy hangs on",
        "",
        (
            "The same histories, onboard, drawn with one thing otherwise, and in the last row with three that are harder at once. What the goals are stated for is this benchmark's own choice, and none of"
            " these numbers is the filter's; where the goal is not reached, better readings or more of them would, or steps that are smaller."
        ),
        "",
        f"| histories | intervals hold | accuracy from half life on | ideal | {' | '.join(goals.KINDS)} |",
        f"|---|---:|---:|---:|{'---:|' * len(goals.KINDS)}",
        *(
            f"| {name} | {100.0 * held(some):.0f} % | {cumulative(some):.2f} | "
            + {goals.AS_ABOVE: f"{cumulative(ideal):.2f}", goals.HARDER: f"{cumulative(_asked_of(harder, some)):.2f}"}.get(name, "")
            + " | "
            + " | ".join(f"{cumulative([one for one in some if one.kind == kind]):.2f}" for kind in goals.KINDS)
            + " |"
            for name, some in otherwise.items()
        ),
        "",
        "## Other processes",
        "",
        f"The same filter, onboard, on {histories} histories of processes that the goals are not stated for, so that it is seen not to be made for the ones above; its numbers of judgement were chosen where both sets are flat in them. "
        + _words(other_processes.__doc__),
        "",
        f"Intervals hold {100.0 * held(others):.1f} %, cumulative relative accuracy from half life on is {cumulative(others):.2f}.",
        "",
        "| wear | life gone | drift found | interval holds | width | accuracy | alpha-lambda |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *_rows(others, other_processes.OTHER_KINDS, None),
        "",
    ]
    return "\n".join(lines)


def _words(doc: str | None) -> str:
    """A module's description behind its first line, in one line."""
    return " ".join((doc or "").partition("\n\n")[2].split())


def _asked_of(some: Sequence[Asked], others: Sequence[Asked]) -> list[Asked]:
    """Those of the forecasts at looks at which others told one, too."""
    told = {(one.seed, one.share) for one in others if one.told is not None}
    return [one for one in some if one.told is not None and (one.seed, one.share) in told]


def _apart(one: Said | None, other: Said | None) -> float:
    """By how much of it two medians differ; infinite where one is told and the other is not."""
    if one is None or other is None:
        return 0.0 if one is other else math.inf
    if not (math.isfinite(one.median) and math.isfinite(other.median)):
        return 0.0 if one.median == other.median else math.inf
    return abs(other.median - one.median) / max(one.median, 1.0)


def _ratio(group: Sequence[Asked]) -> str:
    return f"{mean([accuracy(one.left, one.told.median) for one in group if one.told is not None]):.2f}"


def _rows(asked: Sequence[Asked], kinds: Sequence[str], beside: Callable[[str, float], str] | None) -> list[str]:
    """A row of the table for each kind and share of the life."""
    rows = []
    for kind in kinds:
        for share in sorted({one.share for one in asked}):
            group = [one for one in asked if (one.kind, one.share) == (kind, share)]
            there = [(one.left, one.told) for one in group if one.told is not None]
            width = (
                float(np.median([(told.high - told.low) / left if math.isfinite(told.low) else math.inf for left, told in there]))
                if there
                else math.nan
            )
            near = mean([accuracy(left, told.median) >= 1.0 - _LAMBDA_ALPHA for left, told in there])
            rows.append(
                f"| {kind} | {100.0 * share:.0f} % | {100.0 * len(there) / max(1, len(group)):.0f} % | {100.0 * mean([within(left, told) for left, told in there]):.0f} % | "
                f"{'no upper end' if math.isinf(width) else f'{width:.1f} x'} | {_ratio(group)} | {f'{beside(kind, share)} | ' if beside else ''}{100.0 * near:.0f} % |"
            )
    return rows


def _goal(what: str, goal: str, met: bool, figures: Sequence[str]) -> str:
    return f"| {what} | {goal} | {'yes' if met else '**no**'} | {' | '.join(figures)} |"
