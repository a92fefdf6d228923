"""The page of several results: what all of them say on its first screen, a unit over its dates, each result with its own answers, and what is common to them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape

from ema_tools.results.over_dates import UnitOverDates
from ema_tools.words.page import (
    comparison_page,
    diagnosis,
    first_screen,
    gathered,
    identification_screen,
    identified_part,
    map_page,
    names,
    over_dates,
    workbench,
)
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Diagnosed
from ema_tools.words.page.gathered import Gathered
from ema_tools.words.page.results import Mapped, Result, ShownComparison, ShownIdentification
from ema_tools.words.page.sheet import Chapter, FirstScreen, Reply, document, kept, replies
from ema_tools.words.page.uplot import ABSENT, library

_OPEN_MAX = 3  # results that stand open on the page; of more, each is opened when it is asked for [layout]
_LISTED_MAX = 6  # results that the menu names; more are reached from the first screen [layout]
_TILES_MAX = 15  # results that the first screen shows: three rows of five [layout]
# What a result concludes: how many of them there are in words, a tile's short answer, its tone.
_SAID = {
    "fault": ("a fault in {}", "Fault", "bad"),
    "healthy": ("{} healthy", "Healthy", "good"),
    "undecided": ("{} undecided", "Undecided", "unsure"),
    "missing": ("an effect missing in {}", "Effect missing", "bad"),
    "adequate": ("nothing missing in {}", "Nothing missing", "good"),
    "unknown": ("something unknown in {}", "Unknown effect", "bad"),
    "added": ("an effect added in {}", "Effect added", ""),
    "compared": ("{} compared with the model", "Compared", ""),
    "mapped": ("{} of friction against speed", "Friction map", ""),
}


def render(results: Sequence[Result], command: str, units: Sequence[UnitOverDates] = ()) -> str:
    """The page as text. `command` made it and stands in its provenance; `units`: results of one unit over dates."""
    page = Gathered()
    # without dates an order is no history, and each result is told by itself
    unit = units[0] if len(units) == 1 and units[0].dated else None
    chapters = [Chapter("dates", "Over dates", over_dates.section(units, said=unit is not None))]
    for place, result in enumerate(results, start=1):
        identity = f"result-{place}"
        _part(page, result, identity, len(results) <= _OPEN_MAX)
        chapters.append(Chapter(identity, result.title, page.taken(), len(results) <= _LISTED_MAX))
    # one workbench a page, of the first result that brings what it needs
    bench = next((result.workbench for result in results if not isinstance(result, Mapped) and result.workbench is not None), None)
    chapters.append(Chapter("workbench", "Workbench", workbench.markup(bench) if bench is not None else ""))
    cases = [result for result in results if isinstance(result, ShownIdentification) and result.case is not None]
    if cases:
        identified_part.paper_section(page, cases)
        chapters.append(Chapter("paper", "Beside the paper", page.taken()))
    chapters.append(Chapter("provenance", "Provenance", origins(results, command)))
    beside = f'<p class="absent">{escape(ABSENT)}</p>' if page.curves and not library().there else ""
    first = _of_unit(unit, results) if unit is not None else _overview(results, units)
    name = unit.unit if unit is not None else f"{len(results)} results"
    return document(name, first, beside, chapters, page.data(), bench is not None, gathered.STYLES, gathered.SCRIPTS)


def own_answers(result: Result) -> FirstScreen:
    """The sentence and the answers of one result, as on its own page."""
    if isinstance(result, ShownIdentification):
        return identification_screen.first_screen_of(result)
    if isinstance(result, Diagnosed):
        return first_screen.first_screen(result)
    return map_page.first_screen(result) if isinstance(result, Mapped) else comparison_page.first_screen(result)


def _part(page: Gathered, result: Result, identity: str, opened: bool) -> None:
    """One result: its answers, then all about it."""
    answers = own_answers(result)
    page.add(f'<p class="lead">{kept(answers.sentence)}</p>', replies(answers, f"{identity}-command"))
    page.add(f'<details class="whole"{" open" if opened else ""}><summary>Signals, pictures and tables of {escape(result.title)}</summary>')
    if isinstance(result, ShownIdentification):
        identified_part.section(page, result, identity)
    elif isinstance(result, Diagnosed):
        diagnosis.section(page, result, identity)
    elif isinstance(result, Mapped):
        map_page.part(page, result, identity)
    else:
        comparison_page.part(page, result, identity)
    page.add("</details>")


def _kind(result: Result) -> str:
    """What it concludes, as in _SAID."""
    if isinstance(result, ShownComparison):
        return "compared"
    if isinstance(result, Mapped):
        return "mapped"
    return "added" if isinstance(result, Diagnosed) and result.added else result.verdict


def _overview(results: Sequence[Result], units: Sequence[UnitOverDates]) -> FirstScreen:
    """A tile for each result."""
    counts = Counter(map(_kind, results))
    told = [said.format(counts[kind]) for kind, (said, _, _) in _SAID.items() if counts[kind]]
    sentence = f"{len(results)} results: {names.listed(told)}."
    if len(units) > 1:
        changed = [one.unit for one in units if any(trend.changed for trend in one.trends.values())]
        sentence = f"{len(units)} units over {len(results)} results: {f'{names.listed(changed)} drift{chr(115) if len(changed) == 1 else str()}' if changed else 'none drifts'}."
    tiles = [_tile(result, f"result-{place}") for place, result in enumerate(results, start=1)]
    if len(tiles) > _TILES_MAX:
        more = Reply("And", f"{len(tiles) - _TILES_MAX + 1} more", "below, in the order given", "", "", f"result-{_TILES_MAX}")
        tiles = [*tiles[: _TILES_MAX - 1], more]
    return FirstScreen(sentence, tuple(tiles), tiles=True)


def _tile(result: Result, identity: str) -> Reply:
    """One result in a few words."""
    _, short, tone = _SAID[_kind(result)]
    more = ""
    if isinstance(result, ShownIdentification):
        more = ", ".join(
            f"{identification_screen.SHORT[name]} {identification_screen.shift_words(one)[0]}" for name, one in result.faults.items()
        )
        effect = result.found.missing_effect
        if result.verdict == "undecided" and effect is not None and effect.name is not None:
            more += f"; {names.within(effect.name)}"
    elif isinstance(result, Diagnosed):
        named = [result.added] if result.added else [one.name for one in result.suspects if one.accepted]
        if named:
            short = names.listed([names.display(named[0]), *map(names.within, named[1:])])
        before, after = result.errors.get("before"), result.errors.get("after")
        error = "" if before is None else f"error {words.number(before)}" + (f" → {words.number(after)}" if after is not None else "")
        more = "; ".join(filter(None, (("added" if result.added else "is missing") if named else "", error)))
    elif isinstance(result, ShownComparison):
        worst = comparison_page.worst_block(result)
        if worst is not None:
            short, more = f"Off by {words.number(worst[1])} %", f"{names.block(worst[0]).lower()}"
    else:
        more = f"{result.found.runs} runs at constant speed"
    return Reply(result.title, short, more, tone, "", identity)


def _of_unit(one: UnitOverDates, results: Sequence[Result]) -> FirstScreen:
    """The five answers of one unit: how it is now, both sizes, when a limit is reached, and what next by its last result."""
    place, last = next(
        ((place, result) for place, result in reversed(list(enumerate(results, start=1))) if result.name == one.rows[-1].file),
        (len(results), results[-1]),
    )
    answers = own_answers(last)
    when = f"{one.rows[-1].date.date().isoformat()}, " if one.dated else ""
    _, short, tone = _SAID[_kind(last)]
    now = Reply("How is it now?", short, f"{when}{last.name}", tone, "", f"result-{place}")
    shown = (now, *(_size(one, name) for name in ("csj", "blk")), _limit(one), answers.replies[-1])
    return FirstScreen(f"{one.sentence[:1].upper()}{one.sentence[1:]}", shown)


def _size(one: UnitOverDates, name: str) -> Reply:
    """The last reading of csj or blk that counts, and since when it has changed."""
    question = names.FAULT_TITLES[name]
    trend, limit = one.trends.get(name), one.thresholds_percent.get(name)
    if trend is None or not len(trend.shift_percent):
        return Reply(question, "Not known", "no reading that counts", "unsure")
    last = float(trend.shift_percent[-1])
    beyond = limit is not None and last > limit
    since = f"since {trend.since}" if trend.changed and trend.since and one.dated else "no drift is told" if not trend.changed else ""
    told = "; ".join(filter(None, (f"a fault from +{limit:g} % on" if limit is not None else "", since)))
    return Reply(
        question,
        names.changed(last, float(trend.std_percent[-1])),
        told,
        "bad" if beyond else "good" if limit is not None else "",
        "",
        "dates",
    )


def _limit(one: UnitOverDates) -> Reply:
    """When the nearer limit is reached."""
    question = "When is a limit reached?"
    lives = [
        (name, trend.life, trend.limit_percent)
        for name, trend in one.trends.items()
        if trend.life is not None and trend.life.interval90_days[0] is not None
    ]
    if not lives:
        if not one.dated:
            return Reply(question, "Not told", "the results have no dates", "", "", "dates")
        return Reply(question, "Not in sight", "no drift that leads there is told from these readings", "", "", "dates")
    name, life, limit = min(lives, key=lambda pair: pair[1].interval90_days[0] or 0.0)
    low, high = life.interval90_days
    ends = f"{low:.0f} … {f'{high:.0f}' if high is not None else '∞'} days"
    middle = f"In {life.median_days:.0f} days" if life.median_days is not None else f"In {ends}"
    return Reply(question, middle, f"{name.upper()} +{limit:g} %; 90 %: {ends} after the last reading", "bad", "", "dates")


def origins(results: Sequence[Result], command: str) -> str:
    """What made the page and its results."""
    parts = [f'<dl class="origin"><dt>page</dt><dd><code>{escape(command)}</code></dd>']
    shared = _shared([result.provenance for result in results])
    parts += [f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>" for key, value in shared.items()]
    for result in results:
        own = {key: value for key, value in result.provenance.items() if key not in shared}
        if own:
            told = "<br>".join(f"{escape(key)}: {escape(value)}" for key, value in own.items())
            parts.append(f"<dt>{escape(result.title)}</dt><dd>{told}</dd>")
    return "".join((*parts, "</dl>"))


def _shared(tables: Iterable[dict[str, str]]) -> dict[str, str]:
    """Entries that all tables have alike."""
    first, *others = tables
    return {key: value for key, value in first.items() if all(other.get(key) == value for other in others)}
