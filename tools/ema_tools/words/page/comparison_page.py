"""A result of `ema compare`: the page of one, and its part of a page of several."""

from __future__ import annotations

import math
from html import escape

from ema_tools.results.comparison import BalanceErrorEntry
from ema_tools.words.advice import after_comparison
from ema_tools.words.page import figures, names, signals, workbench
from ema_tools.words.page import text as words
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.gathered import Gathered, draw_curves
from ema_tools.words.page.results import ShownComparison
from ema_tools.words.page.sheet import Chapter, FirstScreen, Reply, document, kept, next_reply, origin, table
from ema_tools.words.page.uplot import ABSENT, library

_MODELS = {"model": "model as given"}
_PLACES_MAX = 8  # places that a table shows: as many as are taken in [layout]


def render(result: ShownComparison, command: str) -> str:
    """The page as text. `command` made it and stands in its provenance."""
    found = signals.traces(result.curves, result.found.curves)
    titles = {key: _MODELS.get(key, key) for key in found.curves.models} if found is not None else {}
    chapters = [
        Chapter("signals", "Signals", signals.section(found, titles, "" if library().there else ABSENT)),
        Chapter("where", "Where", _where(result, "where")),
        Chapter("workbench", "Workbench", workbench.markup(result.workbench) if result.workbench is not None else ""),
        Chapter("provenance", "Provenance", origin(command, result.provenance)),
    ]
    data = signals.packed_signals(found, titles, {}) if found is not None else {}
    return document(result.name, first_screen(result), "", chapters, data, result.workbench is not None)


def part(page: Gathered, result: ShownComparison, identity: str) -> None:
    """What stands below the answers where there are other results beside it."""
    if result.curves is not None:
        draw_curves(page, result.curves, identity, {"model": "Measured and simulated"}, result.title)
    page.add(_where(result, identity))


def first_screen(result: ShownComparison) -> FirstScreen:
    """The sentence and the answers: is what is left noise, where and when does the model fail, how far is it off, what next."""
    return FirstScreen(
        _sentence(result), (_noise(result), _block(result), _moment(result), _off(result), next_reply(after_comparison(result.found)))
    )


def worst_block(result: ShownComparison) -> tuple[str, float] | None:
    """The equation with the largest share of its measured side left over, %: what neither noise nor method explains where that is known; None without any."""
    there = {name: one for name, one in result.found.balances.items() if one.relative_percent is not None}
    if not there:
        return None
    name = max(there, key=lambda one: (there[one].excess_percent or 0.0, there[one].relative_percent or 0.0))
    return name, there[name].relative_percent or 0.0


def _floor(one: BalanceErrorEntry) -> float | None:
    """What noise and method make of an equation's residual, in its unit; None where it is not known."""
    if one.noise_rms is None or one.method_rms is None:
        return None
    floor = math.hypot(one.noise_rms, one.method_rms)
    return floor if floor > 0.0 else None


def _sentence(result: ShownComparison) -> str:
    error = result.found.error
    if error is not None and error.after is not None and error.floor is not None:
        told = f"weighted error {words.number(error.after)}, noise level {words.number(error.floor)}"
        if result.found.explained:
            return f"The model explains the record: {told}."
        largest = worst_block(result)
        most = f"; {words.number(largest[1])} % unexplained in the {names.block(largest[0]).lower()}" if largest is not None else ""
        return f"The model does not explain the record: {told}{most}."
    worst, rod = worst_block(result), result.channels.get("position_mm", (0.0, None))[1]
    moved = f"the rod position is off by {words.number(rod)} %" if rod is not None else "the rod does not move"
    if worst is None:
        return f"No equation can be weighed on this record; {moved}."
    if result.found.explained:
        return f"The model explains the record as far as noise can tell; {moved}."
    return f"The model leaves {words.number(worst[1])} % unexplained in the {names.block(worst[0]).lower()}; {moved}."


def _noise(result: ShownComparison) -> Reply:
    question = "Is what is left noise?"
    explained, worst, error = result.found.explained, worst_block(result), result.found.error
    if explained is not None and error is not None and error.after is not None and error.floor is not None:
        told = f"{words.number(error.after / error.floor, 2)} times its noise level with today's CSJ and BLK"
        return Reply(question, "Yes", told, "good") if explained else Reply(question, "No", told, "bad")
    floor = _floor(result.found.balances[worst[0]]) if worst is not None else None
    if explained is None or worst is None:
        return Reply(question, "Not told", "the result states no noise level")
    rms = result.found.balances[worst[0]].rms
    told = f"{names.block(worst[0]).lower()} {words.number(rms / floor, 2)} times its noise level" if floor and rms is not None else ""
    return Reply(question, "Yes", told, "good") if explained else Reply(question, "No", told, "bad")


def _block(result: ShownComparison) -> Reply:
    question = "Where does it fail?"
    worst = worst_block(result)
    if worst is None:
        return Reply(
            question, "Not told", next((one.reason for one in result.found.balances.values() if one.reason), "no equation can be drawn")
        )
    if result.found.explained:
        return Reply(question, "Nowhere", "no equation stands above its noise level", "good")
    weighs = names.BLOCKS[worst[0]][1] if worst[0] in names.BLOCKS else ""
    return Reply(question, names.block(worst[0]), f"{weighs}: {words.number(worst[1])} % of its measured side", "bad")


def _moment(result: ShownComparison) -> Reply:
    question = "When?"
    worst = worst_block(result)
    if result.found.explained or not result.where:
        return Reply(question, "At no time in particular", "", "good" if result.found.explained else "")
    of_block = [place for place in result.where if worst is not None and place.source == f"{worst[0]} balance"]
    first = (of_block or list(result.where))[0]
    shown = f"{first.by} {first.part}".strip() or first.name.partition(": ")[2] or first.name
    told = f"{words.number(first.share_percent, 2)} % of what is left, in {words.number(first.time_percent, 2)} % of the time"
    return Reply(question, f"At {shown}", told)


def _off(result: ShownComparison) -> Reply:
    question = "How far is it off?"
    there = {name: one for name, one in result.channels.items() if one[1] is not None}
    if not there:
        return Reply(question, "Not known", "no signal moves")
    first = "position_mm" if "position_mm" in there else next(iter(there))
    others = [f"{names.signal(name).lower().split(',')[0]} {words.number(one[1] or 0.0)} %" for name, one in there.items() if name != first]
    return Reply(question, f"{names.signal(first)} {words.number(there[first][1] or 0.0)} %", ", ".join(others))


def _where(result: ShownComparison, identity: str) -> str:
    parts = [f"<p>{kept(result.sentence)}</p>" if result.sentence else "", _equations(result), _channels(result)]
    if result.where:
        rows = [
            f'<tr><th scope="row">{escape(place.name)}</th><td>{words.number(place.share_percent, 2)} %</td><td>{words.number(place.time_percent, 2)} %</td></tr>'
            for place in result.where[:_PLACES_MAX]
        ]
        listed = table("places", "Shares of the squared residual and of the time.", ("Part of the record", "Residual", "Time"), rows)
        parts.append(
            '<div class="pair"><figure><div class="figure-head"><h3>Where the error sits</h3><ul class="legend"><li><span class="key dot before"></span>share of the squared error</li>'
            '<li><span class="key ring"></span>share of the time</li></ul></div>'
            f"{figure_svg(figures.shares(result.where), f'{identity}-shares')}"
            f"<figcaption>Parts of the record that hold more of a residual than of the time, the most telling first.</figcaption></figure><div>{listed}</div></div>"
        )
    return "".join(parts)


def _equations(result: ShownComparison) -> str:
    rows = []
    for name, one in sorted(result.found.balances.items(), key=lambda pair: -(pair[1].excess_percent or 0.0)):
        title, weighs = names.BLOCKS.get(name, (name, ""))
        head = f'<th scope="row">{escape(title)} <small>{escape(weighs)}</small></th>'
        if one.rms is None or one.relative_percent is None:
            rows.append(f'<tr>{head}<td colspan="4" class="words">{escape(one.reason or "not available")}</td></tr>')
            continue
        floor = _floor(one)
        unit = f" {one.unit}" if one.unit else ""
        level, times = ("–", "–") if floor is None else (f"{words.number(floor)}{unit}", f"{words.number(one.rms / floor, 2)} ×")
        rows.append(
            f"<tr>{head}<td>{words.number(one.rms)}{unit}</td><td>{level}</td><td>{times}</td><td>{words.number(one.relative_percent)} %</td></tr>"
        )
    if not rows:
        return ""
    caption = "Equation residual: measured signals alone, against one group of blocks; the noise level is what sensor noise and the method make of it."
    return table("equation residuals", caption, ("Equation", "Residual, rms", "Noise level", "Times", "Of its measured side"), rows)


def _channels(result: ShownComparison) -> str:
    rows = []
    for name, (rmse, share) in result.channels.items():
        title, _, unit, scale = names.SIGNALS.get(name, (name, "", "", 1.0))
        told = "–" if share is None else f"{words.number(share)} %"
        rows.append(f'<tr><th scope="row">{escape(title)}</th><td>{words.number(scale * rmse)} {escape(unit)}</td><td>{told}</td></tr>')
    if not rows:
        return ""
    caption = "Measured minus simulated; a few rows at the ends of the record are left out."
    return table("error per channel", caption, ("Signal", "Residual, rms", "Of the measured"), rows)
