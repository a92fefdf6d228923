"""The page of the paper's cases: command and responses, what CSJ and BLK each do, the objective, the search, and each case fitted, beside the paper's numbers.

Everything on it is simulated and searched by this project; of the paper stand there the names of its authors and the numbers of its tables.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from ema_tools.results.paper import PaperResponses, PaperRun
from ema_tools.words.page import gathered, identified_part
from ema_tools.words.page import text as words
from ema_tools.words.page.gathered import Gathered
from ema_tools.words.page.legend import LegendKey, switches
from ema_tools.words.page.line_charts import LineChart, NamedCurve
from ema_tools.words.page.paper_figures import LEAST, SIZES, best_so_far, box_surface
from ema_tools.words.page.results import ShownIdentification
from ema_tools.words.page.several_page import origins
from ema_tools.words.page.sheet import Chapter, FirstScreen, Reply, document
from ema_tools.words.page.uplot import ABSENT, library

CITED = (
    "M. D. L. Dalla Vedova, D. Lauria, P. Maggiore, L. Pace: “Electromechanical actuators affected by multiple failures: "
    "a simulated-annealing-based fault identification algorithm”."
)
_NEAR = (1.0, 1.6)  # s: the first reversal, where friction and play are seen apart [layout]
_UM = 1000.0  # um in a mm [physics]


def paper_page(found: PaperResponses, results: Sequence[ShownIdentification], command: str) -> str:
    """The page as text; `results` are those of the paper's cases, and `command` made it."""
    page = Gathered()
    absent = "" if library().there else f'<p class="absent">{escape(ABSENT)}</p>'
    beside = (
        f'<p class="note">After {escape(CITED)} The paper prints no electrical data, gear ratio, gains or sweep: the reference actuator is an estimate that agrees with all it does print. '
        f"Curves and surfaces are this project’s own.</p>{absent}"
    )
    _responses(page, found)
    chapters = [Chapter("responses", "Command and response", page.taken())]
    for name, title, runs, told in (
        ("csj", "What static dry friction does", found.csj, _CSJ_WORDS),
        ("blk", "What backlash does", found.blk, _BLK_WORDS),
    ):
        _one_value(page, found, name, runs, told)
        chapters.append(Chapter(name, title, page.taken()))
    _objective(page, found, results)
    chapters.append(Chapter("objective", "The objective, and how the annealer converges", page.taken()))
    for place, result in enumerate(results, start=1):
        identified_part.section(page, result, f"result-{place}")
        chapters.append(Chapter(f"result-{place}", result.title, page.taken()))
    identified_part.paper_section(page, results)
    chapters += [Chapter("paper", "Beside the paper", page.taken()), Chapter("provenance", "Provenance", origins(results, command))]
    return document(
        "The paper’s cases", _first_screen(results), beside, chapters, page.data(), False, gathered.STYLES, (*gathered.SCRIPTS, "lines.js")
    )


def _first_screen(results: Sequence[ShownIdentification]) -> FirstScreen:
    """What is reached here beside what the paper reaches."""
    worst, paper = _worst(results), _worst_of_paper(results)
    runs, times = [one.evaluations for one in results], [one.wall_s for one in results if one.wall_s is not None]
    cited = [one.paper for one in results if one.paper is not None]
    replies = [
        Reply(
            "How near to the truth?", f"{words.number(worst, 2)} % off at most", "of the healthy value, over all cases", "good", "", "paper"
        ),
        Reply("And the paper’s search?", f"{words.number(paper, 2)} % off at most", "as its tables print", "", "", "paper"),
        Reply("How many model runs?", _span(runs), f"the paper’s {_span([one.paper_iterations for one in cited])}", "", "", "objective"),
    ]
    if times:
        replies.append(
            Reply(
                "How long does it take?",
                f"{words.number(max(times), 2)} s at most",
                f"the paper’s {_span([one.paper_wall_s for one in cited])} s on its computer",
            )
        )
    ask = "ema identify actuators/reference.toml recordings/case_a.csv --report case_a.html"
    replies.append(Reply("What next?", "Look at one case", "with its workbench, from a clone of the project", "", ask))
    return FirstScreen(_title(results), tuple(replies))


def _span(numbers: Sequence[float]) -> str:
    low, high = min(numbers), max(numbers)
    return f"{low:.0f}" if low == high else f"{low:.0f} … {high:.0f}"


_CSJ_WORDS = "The rod stays longer at each reversal and lags the command by more; the motor draws more current in both directions."
_BLK_WORDS = "The rod lags by half the play after each reversal, whatever the speed; the motor, whose encoder closes the loop, notices nothing, and its current stays as it was."


def _worst(results: Sequence[ShownIdentification]) -> float:
    """The largest error of an estimate, % of the healthy value."""
    return max(
        abs(one.faults[name].shift_percent - one.case.shift_percent(name)) for one in results if one.case is not None for name in one.faults
    )


def _worst_of_paper(results: Sequence[ShownIdentification]) -> float:
    """The same of what the paper prints."""
    return max(
        abs(one.paper.paper_shift_percent(name) - one.paper.shift_percent(name))
        for one in results
        if one.paper is not None
        for name in one.faults
    )


def _title(results: Sequence[ShownIdentification]) -> str:
    return (
        f"The paper’s {len(results)} cases are found to {words.number(_worst(results), 2)} % of the healthy value, "
        f"where the paper is off by up to {words.number(_worst_of_paper(results), 2)} %."
    )


def _charts(page: Gathered, charts: Sequence[LineChart], captions: Sequence[str], kind: str = "pair") -> None:
    page.lines += [one.data() for one in charts]
    page.add(f'<div class="{kind}">', *(one.markup(caption) for one, caption in zip(charts, captions, strict=True)), "</div>")


def _zoom(page: Gathered, group: str) -> None:
    near = " ".join(f"{end:g}" for end in _NEAR)
    page.add(
        f'<div class="bar"><div class="zoom" role="group" aria-label="Zoom of these curves"><button type="button" data-lines-of="{group}">Whole record</button>'
        f'<button type="button" data-lines-of="{group}" data-view="{near}">One reversal</button></div></div>'
    )


def _responses(page: Gathered, found: PaperResponses) -> None:
    """Command, healthy and faulty response."""
    seconds = found.period_s * found.command_mm.size
    page.add(
        f"<p>A linear sweep of the position command, {seconds:.0f} s, unloaded; the healthy actuator, and case A with more friction and a little more play.</p>"
    )
    _zoom(page, "responses")
    worn = found.cases[0]
    charts = []
    for name, title, unit in (
        ("position_mm", "Rod position", "mm"),
        ("speed_mm_s", "Rod speed", "mm/s"),
        ("current_A", "Motor current", "A"),
    ):
        curves = [NamedCurve("healthy", "after", getattr(found.healthy, name)), NamedCurve(worn.name, "two", getattr(worn, name))]
        if name == "position_mm":
            curves.insert(0, NamedCurve("command", "measured", found.command_mm))
        charts.append(LineChart(f"response-{name}", title, unit, "responses", found.period_s, curves))
    charts.append(
        LineChart(
            "response-lag",
            "Command minus rod position",
            "µm",
            "responses",
            found.period_s,
            [
                NamedCurve(one.name, role, _UM * (found.command_mm - one.position_mm))
                for one, role in ((found.healthy, "after"), (worn, "two"))
            ],
        )
    )
    captions = ("", "", "", "What the rod lags behind the command by: friction adds to it at every reversal.")
    _charts(page, charts, captions)
    page.add('<p class="note">Drag across a plot to zoom, all of a group follow; double click shows the whole record.</p>')


def _one_value(page: Gathered, found: PaperResponses, name: str, runs: Sequence[PaperRun], told: str) -> None:
    """What one value alone does to position and current, in rising sizes."""
    page.add(f"<p>{escape(told)}</p>")
    _zoom(page, name)
    rod = [NamedCurve(one.name, role, _UM * (one.position_mm - found.healthy.position_mm)) for one, role in zip(runs, SIZES, strict=True)]
    drive = [NamedCurve("healthy", "after", found.healthy.current_A)] + [
        NamedCurve(one.name, role, one.current_A) for one, role in zip(runs, SIZES, strict=True)
    ]
    position = [NamedCurve("healthy", "after", found.healthy.position_mm)] + [
        NamedCurve(one.name, role, one.position_mm) for one, role in zip(runs, SIZES, strict=True)
    ]
    charts = [
        LineChart(f"{name}-position", "Rod position", "mm", name, found.period_s, position, _NEAR),
        LineChart(f"{name}-change", "Change of the rod position against healthy", "µm", name, found.period_s, rod, _NEAR),
        LineChart(f"{name}-current", "Motor current", "A", name, found.period_s, drive, _NEAR),
    ]
    _charts(page, charts, ("", _largest(runs, found), ""), "thirds")


def _largest(runs: Sequence[PaperRun], found: PaperResponses) -> str:
    rms = [_UM * float(np.sqrt(np.mean((one.position_mm - found.healthy.position_mm) ** 2))) for one in runs]
    return (
        "rms over the record: " + ", ".join(f"{one.name} {words.number(value, 2)} µm" for one, value in zip(runs, rms, strict=True)) + "."
    )


def _objective(page: Gathered, found: PaperResponses, results: Sequence[ShownIdentification]) -> None:
    """The objective of one case over the whole box, and the annealer's way down on every case."""
    box = found.box
    page.add(
        f"<p>The integrated squared position error of case {escape(box.case)} for every CSJ and BLK that the search may try. A valley runs along BLK: "
        "there the error hardly says which value is right, and this, not the search, is what makes backlash hard to find.</p>"
    )
    marks = (LegendKey("before", "diamond full before", "healthy"), LegendKey("after", "dot", "truth"))
    page.add(
        f'<div class="pair"><figure><div class="figure-head"><h3>Integrated squared error over the box</h3>{switches(marks, "the box")}</div>'
    )
    page.add(page.figure("objective-box", box_surface(found)))
    ends = (words.number(float(np.max(box.objective_mm2s)), 2), words.number(max(float(np.min(box.objective_mm2s)), LEAST), 2))
    page.add(f"<figcaption>In logarithmic steps; dark is small: from {ends[0]} down to {ends[1]} mm² s on this grid.</figcaption></figure>")
    shown = [one for one in results if one.search is not None and one.paper is not None]
    if shown:
        keys = switches([LegendKey(role, role, one.label) for one, role in zip(shown, SIZES, strict=False)], "best error so far")
        page.add(
            f'<figure><div class="figure-head"><h3>Best error so far</h3>{keys}</div>',
            page.figure("search-best", best_so_far(shown)),
        )
        paper = min(one.paper.paper_iterations for one in shown if one.paper is not None)
        page.add(
            f"<figcaption>From the healthy values. The paper’s search takes {paper} iterations and more; how often this one arrives, and from where, "
            "is counted over 500 searches a case in docs/RESULTS.md.</figcaption></figure>"
        )
    page.add("</div>")
