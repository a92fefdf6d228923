"""The part of the page for a result of `ema map`: torque against speed with its band, both directions, beside the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from ema_tools.base.arrays import Reals
from ema_tools.results.friction_map import MapPointEntry
from ema_tools.words.page import diagnosis_figures
from ema_tools.words.page import text as words
from ema_tools.words.page.diagnosis import Sheet
from ema_tools.words.page.diagnosis_results import Line, Picture
from ema_tools.words.page.results import Mapped


def tile(result: Mapped) -> str:
    """The result in a few words, for the overview."""
    return (
        f'<span class="head"><span>{escape(result.name)}</span></span><span class="big">Friction against speed</span>'
        f'<span class="small">{result.found.runs} runs at constant speed</span>'
    )


def section(page: Sheet, result: Mapped, identity: str) -> None:
    """Everything about one map."""
    page.add(f'<h2 id="{identity}-title">{escape(result.title)}</h2>')
    # the sentence of the first result stands in the head of the page
    if identity != "result-1":
        page.add(f"<p>{escape(result.sentence)}</p>")
    points = result.found.points
    page.add('<div class="pair">')
    for title, side in (("Backward", -1.0), ("Forward", 1.0)):
        here = [one for one in points if one.speed_rad_s * side > 0.0]
        if here:
            _picture(page, f"{identity}-{title.lower()}", title, here)
    page.add("</div>")
    page.add(
        '<p class="note">The drive\'s torque at the motor shaft, inertia taken off: mean, and band of one standard deviation, of every speed that was kept.</p>'
    )
    rows = "".join(
        f'<tr><th scope="row">{words.number(one.speed_rad_s, 4)}</th><td>{words.number(one.torque_Nm, 4)}</td><td>{_interval(one.interval95)}</td>'
        f"<td>{words.number(one.model_Nm, 4)}</td><td>{one.runs}</td><td>{words.number(one.seconds)}</td></tr>"
        for one in points
    )
    heads = "".join(
        f'<th scope="col">{name}</th>' for name in ("Speed, rad/s", "Torque, Nm", "95 % of the mean", "Model, Nm", "Runs", "Seconds")
    )
    page.add(
        '<div class="scroll" role="region" aria-label="Table: torque at constant speed" tabindex="0"><table>'
        f"<caption>Torque at constant speed.</caption><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>"
    )
    if result.found.left_out:
        told = "; ".join(f"{file}: {why}" for file, why in result.found.left_out.items())
        page.add(f'<p class="note">Left out: {escape(told)}.</p>')


def _picture(page: Sheet, identity: str, title: str, points: Sequence[MapPointEntry]) -> None:
    """One direction."""

    def column(of: Callable[[MapPointEntry], float]) -> Reals:
        return np.array([of(one) for one in points])

    speed = column(lambda one: one.speed_rad_s)
    measured = Line(speed, column(lambda one: one.torque_Nm), column(lambda one: one.low_Nm), column(lambda one: one.high_Nm))
    lines = {"measured": measured, "model": Line(speed, column(lambda one: one.model_Nm))}
    page.add(
        f'<figure><div class="figure-head"><h3>{title}</h3><ul class="legend"><li><span class="key before"></span>measured</li>'
        '<li><span class="key after"></span>model</li></ul></div>',
        page.figure(identity, diagnosis_figures.picture(Picture("torque at constant speed", "speed", "Nm", "rad/s", lines))),
        "</figure>",
    )


def _interval(ends: tuple[float | None, float | None]) -> str:
    low, high = ends
    return "–" if low is None or high is None else words.interval(low, high)
