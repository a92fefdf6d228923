"""A fleet on the terminal."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from ema_tools.results.fleet import FleetResult, LifeEntry, TrendEntry
from ema_tools.words.terminal.console import table

_SHORT = {"csj": "CSJ", "blk": "BLK"}
_UNITS_MAX = 20  # units on the terminal; the page has all [layout]


def print_fleet(console: Console, found: FleetResult) -> None:
    """What `ema fleet` found: the most urgent units first."""
    console.print(Text(found.sentence))
    console.print()
    rows = table("", "unit", *_SHORT.values(), "drifts since", "reaches a limit in days", "verdict", "records")
    for one in found.units[:_UNITS_MAX]:
        drifting = [trend for trend in one.trends.values() if trend.changed]
        since = min((trend.since for trend in drifting if trend.since), default="-")
        lives = [trend.life for trend in one.trends.values() if trend.life is not None]
        soonest = min(lives, key=_low, default=None)
        rows.add_row(
            one.unit, *(_last(one.trends.get(name)) for name in _SHORT), since, _life(soonest), one.verdict or "-", f"{one.records}"
        )
    console.print(rows)
    if len(found.units) > _UNITS_MAX:
        console.print(Text(f"and {len(found.units) - _UNITS_MAX} more units, on the page"))


def _low(life: LifeEntry) -> float:
    low = life.interval90_days[0]
    return float("inf") if low is None else low


def _last(trend: TrendEntry | None) -> str:
    return "-" if trend is None else f"{trend.shift_percent[-1]:+.1f} %"


def _life(life: LifeEntry | None) -> str:
    if life is None or life.interval90_days[0] is None:
        return "-"
    low, high = life.interval90_days
    return f"{low:.0f} .. {high:.0f}" if high is not None else f"{low:.0f} .. never"
