"""The two sizes at a glance: each on a line of its own, with its 95 % interval against what a healthy machine shows and the shift from which on it is called a fault."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from ema_tools.words.page import names
from ema_tools.words.page import text as words
from ema_tools.words.page.identification_screen import SHORT, faults_of, shift_words
from ema_tools.words.page.results import ShownEstimate, ShownIdentification
from ema_tools.words.page.sheet import kept

_ROOM = 1.35  # of the threshold, drawn to either side at least [layout]
_BEYOND = 1.12  # of the largest value, drawn at least [layout]
_WIDEST = 6.0  # times shift or threshold: what an interval reaches beyond is cut, or it alone would be seen [layout]
_ZERO, _WORDS = 0.04, 0.45  # of the width, which the zero and the words of the threshold take [layout]
_RIGHT = 0.62  # of the width: a mark beyond it has its word on the left [layout]
_EVERYTHING = -100.0  # %: less than nothing is left of no value [physics]
_UNITS = {"csj_Nm": "Nm", "blk_mm": "mm"}


@dataclass(frozen=True)
class Gauge:
    """A line of shifts in %: its ends, and what is drawn of the interval."""

    low: float
    high: float
    interval: tuple[float, float] | None

    def at(self, percent: float) -> float:
        """Share of the width, 0..1."""
        return min(1.0, max(0.0, (percent - self.low) / (self.high - self.low)))


def gauge_of(one: ShownEstimate, *others: float) -> Gauge:
    """The line on which an estimate stands; `others`: further shifts that it must hold."""
    limit = one.threshold_percent or 0.0
    widest = _WIDEST * max(abs(one.shift_percent), limit, 1.0)
    interval = None
    if one.interval is not None:
        below, above = one.reach_percent
        interval = (max(one.shift_percent - min(below, widest), _EVERYTHING), one.shift_percent + min(above, widest))
    held = [one.shift_percent, 0.0, *others, *(interval or ())]
    low, high = min(-_ROOM * limit, _BEYOND * min(held)), max(_ROOM * limit, _BEYOND * max(held))
    return Gauge(low, high, interval) if high > low else Gauge(-1.0, 1.0, interval)


def value_words(name: str, one: ShownEstimate) -> str:
    """The value in its own unit, with its interval and the healthy one."""
    ends = f" ({words.interval(*one.interval)})" if one.interval is not None else ""
    return f"{words.number(one.estimate, 4)} {_UNITS[name]}{ends}, healthy {words.number(one.healthy, 4)} {_UNITS[name]}"


def gauges(result: ShownIdentification) -> str:
    """Markup of all that was identified."""
    return f'<div class="gauges">{"".join(_gauge(result, name, one) for name, one in result.faults.items())}</div>\n'


def _gauge(result: ShownIdentification, name: str, one: ShownEstimate) -> str:
    others = _others(result, name)
    line = gauge_of(one, *(value for _, value, _ in others))
    shift, ends = shift_words(one)
    tone = "good" if result.verdict == "healthy" or not one.beyond else "unsure"
    if result.verdict == "undecided":
        tone = "unsure"
    elif result.verdict == "fault" and name in faults_of(result):
        tone = "bad"
    title = names.FAULT_TITLES[name.partition("_")[0]]
    said = f"{SHORT[name]} {shift}" + (f", 95 %: {ends}" if ends else ", not determined by this record")
    marks = [f'<i class="zero" style="left:{_percent(line.at(0.0))}"></i>']
    scale = []
    limit, taken = one.threshold_percent, 0.0
    if limit is not None:
        first, last = line.at(-limit), line.at(limit)
        marks.insert(0, f'<i class="healthy" style="left:{_percent(first)};width:{_percent(last - first)}"></i>')
        marks.append(f'<i class="threshold" style="left:{_percent(last)}"></i>')
        side, taken = ("before", _WORDS) if last > _RIGHT else ("behind", _ZERO)
        scale.append(f'<span class="{side}" style="left:{_percent(last)}">fault from +{limit:g} %</span>')
        said += f"; a fault from +{limit:g} % on"
    if limit is None or line.at(limit) - line.at(0.0) > taken:
        scale.append(f'<span class="middle" style="left:{_percent(line.at(0.0))}">0</span>')
    if line.interval is not None:
        low, high = (line.at(end) for end in line.interval)
        marks.append(f'<i class="interval" style="left:{_percent(low)};width:{_percent(high - low)}"></i>')
    for kind, value, text in others:
        marks.append(f'<i class="mark {kind}" style="left:{_percent(line.at(value))}" title="{escape(text)}"></i>')
        said += f"; {text}"
    marks.append(f'<i class="mark dot" style="left:{_percent(line.at(one.shift_percent))}"></i>')
    bound = ["at a bound of the search"] if one.at_bound else []
    open_ = ["not determined by this record"] if ends and name in result.undetermined else []
    told = "; ".join([value_words(name, one), *bound, *open_, *(text for _, _, text in others)])
    doubt = f"95 % {ends}" if ends else "not determined by this record"
    return (
        f'<div class="gauge {tone}" data-fault="{name}"><p class="gauge-head"><span>{escape(title)}</span> <b>{kept(shift)}</b> <span>{kept(doubt)}</span></p>'
        f'<div class="line" role="img" aria-label="{escape(said)}">{"".join(marks)}</div><div class="scale" aria-hidden="true">{"".join(scale)}</div>'
        f"<small>{kept(told)}</small></div>"
    )


def _others(result: ShownIdentification, name: str) -> list[tuple[str, float, str]]:
    """Other shifts that are known of the value: class of the mark, shift in %, in words."""
    found: list[tuple[str, float, str]] = []
    guard, effect = result.found.guard, result.found.missing_effect
    apart = guard is not None and (guard.objection == "signals" or guard.verdict == "missing")
    if guard is not None and apart and name in guard.shift_percent:
        beside = f" beside {names.within(effect.name)}" if effect is not None and effect.name is not None else ""
        shift = guard.shift_percent[name]
        found.append(("diamond", shift, f"◇ all signals{beside} {words.shift(shift)}"))
    if result.case is not None:
        shift = result.case.shift_percent(name)
        found.append(("ring", shift, f"○ true {words.shift(shift)}"))
    if result.paper is not None:
        shift = result.paper.paper_shift_percent(name)
        found.append(("diamond", shift, f"◇ paper {words.shift(shift)}"))
    return found


def _percent(share: float) -> str:
    return f"{100.0 * share:.2f}%"
