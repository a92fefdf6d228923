"""The picture of one value of a unit over its days: readings with their intervals, the healthy band, threshold and limit, and what remaining life says."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.base.interval import WIDTH_95
from ema_tools.results.fleet import TrendEntry
from ema_tools.words.page.charts import Drawing, ends
from ema_tools.words.page.legend import LegendKey, switches
from ema_tools.words.page.names import FAULT_TITLES

SHORT = {"csj": "CSJ", "blk": "BLK"}
# By the part of a class that what is drawn has, `s-reading` and so on.
_KEYS = (
    LegendKey("reading", "dot after", "reading, 95 %"),
    LegendKey("open", "dot open", "reading that does not count"),
    LegendKey("healthy", "block healthy", "healthy"),
    LegendKey("threshold", "dashed threshold", "threshold of a fault"),
    LegendKey("limit", "noise", "limit of service"),
    LegendKey("since", "dashed back", "since when it drifts"),
    LegendKey("life", "block life", "remaining life, 90 %"),
)
_AHEAD = 0.25  # of the days so far, drawn beyond the last [layout]
_BARS_MAX = 30  # readings whose intervals stand as bars, too; of more the band alone is seen [layout]
_LIMIT_NEAR = 0.4  # of the limit: from here on it is drawn [layout]


def _none() -> Reals:
    return np.zeros(0)


def legend(drawn: str, of: str) -> str:
    """The keys of what the markup of one drawing or of many holds, by which each is switched in all of them."""
    return switches([key for key in _KEYS if f"s-{key.series}" in drawn], of)


@dataclass(frozen=True)
class Beside:
    """What a picture has besides its trend: the axis' title, the threshold in %, readings that do not count ([n] each: days, %), and whether days are places in an order, of which none lies ahead."""

    x_title: str = "days since the first reading"
    threshold_percent: float | None = None
    more_days: Reals = field(default_factory=_none)
    more_percent: Reals = field(default_factory=_none)
    by_order: bool = False
    first: float = 0.0  # where the trend's days begin on the axis


def drawing(name: str, trend: TrendEntry | None, beside: Beside | None = None) -> str:
    """Readings of csj or blk with their intervals over days, in % of the healthy value; without a trend the readings that do not count, alone."""
    beside = beside or Beside()
    days = np.array(trend.days if trend is not None else ()) + beside.first
    shift = np.array(trend.shift_percent if trend is not None else ())
    half = WIDTH_95 * np.array(trend.std_percent if trend is not None else ())
    every = np.concatenate([days, beside.more_days])
    begin, last = float(np.min(every)), float(np.max(every))
    span = max(last - begin, 1.0)
    end = last + span * (0.02 if beside.by_order else _AHEAD)
    low, high = trend.life.interval90_days if trend is not None and trend.life is not None else (None, None)
    if low is not None:
        end = max(end, min(last + 1.05 * (high if high is not None else low), last + span))
    x_ends = (begin - (0.06 if beside.by_order else 0.02) * span, end + (0.04 * span if beside.by_order else 0.0))
    limit = trend.limit_percent if trend is not None else np.inf
    told = trend.sentence if trend is not None else "no reading that counts"
    shows_limit = trend is not None and ((trend.changed and trend.by_percent > 0.0) or float(np.max(shift)) > _LIMIT_NEAR * limit)
    marks = [0.0, *([limit] if shows_limit else [])]
    if beside.threshold_percent is not None:
        marks += [beside.threshold_percent, -beside.threshold_percent]
    drawn = Drawing(
        f"{FAULT_TITLES[name]}, {beside.x_title}: {told}",
        beside.x_title,
        f"{SHORT[name]}, % of healthy",
        x_ends,
        ends(np.concatenate([shift - half, shift + half, beside.more_percent, np.array(marks)])),
        counts=beside.by_order,
    )
    if beside.threshold_percent is not None:
        both = np.full(2, beside.threshold_percent)
        drawn.band(np.array(x_ends), -both, both, "healthy s-healthy")
        drawn.line(np.array(x_ends), both, "threshold thin s-threshold")
    if days.size > 1:
        drawn.band(days, shift - half, shift + half, "after s-reading")
        drawn.line(days, shift, "after thin s-reading")
    if 0 < days.size <= _BARS_MAX:
        drawn.bars(days, shift - half, shift + half, "after s-reading")
    size = " big" if every.size <= _BARS_MAX else ""
    drawn.dots(days, shift, "after s-reading" + size)
    if beside.more_days.size:
        drawn.dots(beside.more_days, beside.more_percent, "open s-open" + size)
    if shows_limit:
        drawn.line(np.array(x_ends), np.full(2, limit), "noise thin s-limit")
    if trend is not None and trend.since_day is not None and not beside.by_order:
        drawn.line(np.full(2, trend.since_day), np.array(drawn.y_ends), "back thin s-since")
    if trend is not None and trend.life is not None and low is not None:
        beyond = x_ends[1] - float(days[-1])
        fan = days[-1] + np.array([0.0, low, min(high if high is not None else beyond, beyond)])
        now = trend.life.now_percent
        drawn.band(fan, np.array([now, limit, limit]), np.array([now, now, limit]), "s-life")
    return drawn.svg()
