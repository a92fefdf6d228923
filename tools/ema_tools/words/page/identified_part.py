"""An identification beside other results on one page: its sizes, curves, search and the objective round the answer; and what the paper says of the cases that it names."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from ema_tools.words.page import figures, names
from ema_tools.words.page import text as words
from ema_tools.words.page.gathered import Gathered, draw_curves
from ema_tools.words.page.gauges import gauges
from ema_tools.words.page.identification_screen import objective
from ema_tools.words.page.results import ShownIdentification
from ema_tools.words.page.sheet import kept
from ema_tools.words.page.tables import beside_paper


def section(page: Gathered, result: ShownIdentification, identity: str) -> None:
    """Everything about one identification, below its answers."""
    page.add(gauges(result))
    for name, reason in result.left_out.items():
        page.add(f"<p>{escape(names.FAULT_TITLES[name.partition('_')[0]])}: not identified: {escape(reason)}.</p>")
    time = f" in {words.duration(result.wall_s)}" if result.wall_s is not None else ""
    page.add(f'<p class="note">Objective {kept(objective(result))}, by {result.evaluations} model runs{time}.</p>')
    if result.reasons:
        page.add(f'<ul class="told">{"".join(f"<li>{kept(one)}</li>" for one in result.reasons)}</ul>')
    for undetermined in result.undetermined.values():
        page.add(f"<p>{kept(undetermined)}</p>")
    if result.curves is not None:
        draw_curves(page, result.curves, identity, {"before": "Before: healthy values", "after": "After: identified values"}, result.title)
    if result.search is not None:
        page.add('<div class="pair"><figure><div class="figure-head"><h3>The search</h3><ul class="legend">')
        page.add('<li><span class="key dot candidate"></span>candidate</li><li><span class="key after"></span>best so far</li></ul></div>')
        page.add(page.figure(f"{identity}-search", figures.search(result)))
        page.add(
            "<figcaption>A candidate that could no longer be accepted was given up early; its dot is the error that had come together by then.</figcaption></figure></div>"
        )
    _shape(page, result, identity)


def _shape(page: Gathered, result: ShownIdentification, identity: str) -> None:
    """The objective round the answer."""
    if not result.profiles:
        return
    page.add('<div class="pair">')
    page.add(
        '<figure><div class="figure-head"><h3>The error along each parameter</h3><ul class="legend"><li><span class="key after"></span>profile</li>'
    )
    page.add('<li><span class="key dot"></span>estimate, 95 %</li><li><span class="key diamond full before"></span>healthy</li>')
    page.add(
        '<li><span class="key dashed"></span>limit of noise</li></ul></div>', page.figure(f"{identity}-profiles", figures.profiles(result))
    )
    page.add(
        "<figcaption>The other values follow along the valley. A value under the dashed line would explain this record as well; "
        "the bar counts what differs from day to day, too.</figcaption></figure>"
    )
    if result.map is not None:
        page.add('<figure><div class="figure-head"><h3>The error over both, and the way of the search</h3><ul class="legend">')
        page.add('<li><span class="key dot soft"></span>candidate</li><li><span class="key after"></span>best so far</li>')
        page.add(
            '<li><span class="key diamond full before"></span>healthy</li></ul></div>',
            page.figure(f"{identity}-map", figures.surface(result)),
        )
        page.add("<figcaption>Logarithmic; dark is small. Candidates beyond the map are not drawn.</figcaption></figure>")
    page.add("</div>")


def paper_section(page: Gathered, results: Sequence[ShownIdentification]) -> None:
    """What the paper reaches, beside what is reached here; of results that are of its cases."""
    page.add(
        "<p>Dalla Vedova, Lauria, Maggiore and Pace search the same two parameters with simulated annealing. They print no electrical data, gear ratio, gains or "
        "sweep, so the reference actuator here is an estimate that agrees with all they do print.</p>"
    )
    page.add(beside_paper(list(results)))
    page.add(
        '<figure><div class="figure-head"><h3>Error of the estimates</h3><ul class="legend"><li><span class="key dot"></span>here</li>'
    )
    page.add(
        '<li><span class="key diamond full paper"></span>paper</li></ul></div>',
        page.figure("paper-accuracy", figures.accuracy(list(results))),
    )
    page.add(
        "<figcaption>Logarithmic: each step is ten times; an error below 0.0001 % is drawn at 0.0001 %. "
        "The records were made by an independent model in double precision.</figcaption></figure>"
    )
