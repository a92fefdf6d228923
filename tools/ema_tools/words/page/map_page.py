"""A result of `ema map`: torque against speed with its band, both directions, beside the model; the page of one, and its part of a page of several."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.results.friction_map import MapPointEntry
from ema_tools.words.advice import after_map
from ema_tools.words.page import diagnosis_figures
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis_results import Line, Picture
from ema_tools.words.page.figure_svg import figure_svg
from ema_tools.words.page.gathered import Gathered
from ema_tools.words.page.legend import LegendKey, switches
from ema_tools.words.page.results import Mapped
from ema_tools.words.page.sheet import Chapter, FirstScreen, Reply, document, next_reply, origin, table

_KEYS = (LegendKey("before", "before", "measured"), LegendKey("after", "after", "model"))


def render(result: Mapped, command: str) -> str:
    """The page as text. `command` made it and stands in its provenance."""
    chapters = [
        Chapter("law", "Friction law", _pictures(result, "law")),
        Chapter("speeds", "Speeds", _speeds(result)),
        Chapter("provenance", "Provenance", f"{_records(result)}{origin(command, result.provenance)}"),
    ]
    return document(result.title, first_screen(result), "", chapters, {}, False)


def part(page: Gathered, result: Mapped, identity: str) -> None:
    """What stands below the answers where there are other results beside it."""
    page.add(_pictures(result, identity), _speeds(result), _records(result))


def first_screen(result: Mapped) -> FirstScreen:
    """The sentence and the answers: which speeds, how much friction and load, does the model ask for as much, what next."""
    return FirstScreen(
        _sentence(result), (_range(result), _friction(result), _load(result), _agrees(result), next_reply(after_map(result.found)))
    )


def off_model(result: Mapped) -> tuple[MapPointEntry, float]:
    """The speed at which the model asks for another torque than the drive gives, most of all, and by how much, Nm."""
    worst = max(result.found.points, key=lambda one: abs(one.torque_Nm - one.model_Nm))
    return worst, worst.torque_Nm - worst.model_Nm


def _sentence(result: Mapped) -> str:
    ways = result.found.both_ways
    gap = off_model(result)[1]
    model = (
        f"the model is off by up to {words.number(abs(gap))} Nm" if any(one.outside for one in result.found.points) else "the model agrees"
    )
    if not ways:
        return f"The drive's torque at {len(result.found.points)} speeds is known; {model}. Friction and load are not told apart."
    low, high = (words.number(at.friction_Nm) for at in (ways[0], ways[-1]))
    if len(ways) == 1:
        return f"Friction is {low} Nm at {_rpm(ways[0].speed_rad_s)} rpm; {model}."
    return f"Friction is {low} Nm at {_rpm(ways[0].speed_rad_s)} rpm and {high} Nm at {_rpm(ways[-1].speed_rad_s)} rpm; {model}."


def _rpm(speed_rad_s: float) -> str:
    return words.number(speed_rad_s * 60.0 / (2.0 * np.pi))


def _range(result: Mapped) -> Reply:
    speeds = [abs(one.speed_rad_s) for one in result.found.points]
    told = f"of the motor; {result.found.runs} runs at constant speed in {len(result.found.records) - len(result.found.left_out)} records"
    return Reply("Which speeds?", f"{_rpm(min(speeds))} … {_rpm(max(speeds))} rpm", told)


def _friction(result: Mapped) -> Reply:
    question, ways = "How much friction?", result.found.both_ways
    if not ways:
        return Reply(question, "Not told", "no speed was run in both directions", "unsure")
    least = min(ways, key=lambda one: one.friction_Nm)
    return Reply(
        question,
        f"{words.number(least.friction_Nm)} Nm at least",
        f"at {_rpm(least.speed_rad_s)} rpm; half the difference of both directions",
    )


def _load(result: Mapped) -> Reply:
    question, ways = "How much load?", result.found.both_ways
    if not ways:
        return Reply(question, "Not told", "friction and load are not told apart", "unsure")
    load = float(np.mean([one.load_Nm for one in ways]))
    return Reply(question, f"{words.number(load)} Nm", "against extension, on the mean of the speeds; half the sum of both directions")


def _agrees(result: Mapped) -> Reply:
    question, points = "Does the model agree?", result.found.points
    off = [one for one in points if one.outside]
    one, gap = off_model(result)
    told = f"most at {_rpm(one.speed_rad_s)} rpm: {words.signed(gap, 2)} Nm beside the model's {words.number(one.model_Nm)} Nm"
    if not off:
        return Reply(question, "Yes", f"inside what is known of the mean at each speed; {told}", "good")
    return Reply(question, f"Not at {len(off)} of {len(points)} speeds", told, "bad" if 2 * len(off) > len(points) else "unsure")


def _pictures(result: Mapped, identity: str) -> str:
    points = result.found.points
    shown = []
    for title, side in (("Backward", -1.0), ("Forward", 1.0)):
        here = [one for one in points if one.speed_rad_s * side > 0.0]
        if here:
            shown.append(_picture(f"{identity}-{title.lower()}", title, here))
    note = (
        "The drive's torque at the motor shaft, inertia taken off: mean, and band of one standard deviation, of every speed that was kept."
    )
    return f'<div class="pair">{"".join(shown)}</div><p class="note">{note}</p>'


def _speeds(result: Mapped) -> str:
    rows = [
        f'<tr><th scope="row">{words.number(one.speed_rad_s, 4)}</th><td>{words.number(one.torque_Nm, 4)}</td><td>{_interval(one.interval95)}</td>'
        f"<td>{words.number(one.model_Nm, 4)}</td><td>{one.runs}</td><td>{words.number(one.seconds)}</td></tr>"
        for one in result.found.points
    ]
    heads = ("Speed, rad/s", "Torque, Nm", "95 % of the mean", "Model, Nm", "Runs", "Seconds")
    return table("torque at constant speed", "Torque at constant speed.", heads, rows)


def _records(result: Mapped) -> str:
    said = f"<p>{escape(result.sentence)}</p>" if result.sentence else ""
    if not result.found.left_out:
        return said
    told = "; ".join(f"{file}: {why}" for file, why in result.found.left_out.items())
    return f'{said}<p class="note">Left out: {escape(told)}.</p>'


def _picture(identity: str, title: str, points: Sequence[MapPointEntry]) -> str:
    """One direction."""

    def column(of: Callable[[MapPointEntry], float]) -> Reals:
        return np.array([of(one) for one in points])

    speed = column(lambda one: one.speed_rad_s)
    measured = Line(speed, column(lambda one: one.torque_Nm), column(lambda one: one.low_Nm), column(lambda one: one.high_Nm))
    lines = {"measured": measured, "model": Line(speed, column(lambda one: one.model_Nm))}
    drawn = figure_svg(diagnosis_figures.picture(Picture("torque at constant speed", "speed", "Nm", "rad/s", lines)), identity)
    return f'<figure><div class="figure-head"><h3>{title}</h3>{switches(_KEYS, f"torque, {title.lower()}")}</div>{drawn}</figure>'


def _interval(ends: tuple[float | None, float | None]) -> str:
    low, high = ends
    return "–" if low is None or high is None else words.interval(low, high)
