"""The document of the comparison: ranks in plain words, a table for each problem, what the records determine, the session itself, and what needs no search."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.hidden.documents import table
from benchmarks.searches.problems import CAP, KINDS, NOISE
from benchmarks.searches.rivals import FEWER_STARTS, RIVALS
from ema_tools.data.cases import CASES

Row = Mapping[str, Any]
_OWN = "this annealer"
_MODULE = "this module's least squares (sees residuals)"
_SQUARES = "SciPy least_squares (sees residuals)"
_GOAL = 600
_TITLES = {"exact": "exact", "noise": "with sensor noise", "hidden": "with sensor noise and Stribeck friction that the model lacks"}


def written(rows: Sequence[Row], command: str) -> str:
    """As Markdown; `command` writes it again."""
    problems = [(values, kind) for values in CAP for kind in KINDS if _of(rows, values, kind)]
    parts = [
        _head(command),
        _ranks(rows, problems),
        *(_problem(rows, *one) for one in problems),
        _session(rows),
        _determined(rows),
        _baseline(rows),
    ]
    return "\n".join(part for part in parts if part)


def _of(rows: Sequence[Row], values: int, kind: str, rival: str | None = None) -> list[Row]:
    found = [row for row in rows if (row["values"], row["kind"]) == (values, kind)]
    return [row for row in found if row["rival"] == rival] if rival else [row for row in found if row["rival"] in RIVALS]


def _name(values: int, kind: str) -> str:
    return f"{'Two' if values == 2 else 'Eight'} values, {_TITLES[kind]}"


def _reached(rows: Sequence[Row], target: str, within: int | None = None) -> list[tuple[int, float]]:
    """Runs and seconds until a target, of the searches that reached it."""
    found = [(int(row["when"][target][0]), float(row["when"][target][1])) for row in rows if target in row["when"]]
    return [one for one in found if within is None or one[0] <= within]


def expected_runs(rows: Sequence[Row], target: str) -> float:
    """Model runs until a target where a search that ends without it begins again from another start: all runs over the number of arrivals."""
    there = _reached(rows, target)
    spent = sum(runs for runs, _ in there) + sum(row["runs"] for row in rows if target not in row["when"])
    return spent / len(there) if there else float("inf")


def ranked(rows: Sequence[Row], values: int, kind: str) -> list[tuple[str, float]]:
    """Rivals by the expected runs to the noise limit, fewest first."""
    found = [(name, expected_runs(some, "noise")) for name in RIVALS if (some := _of(rows, values, kind, name))]
    return sorted(found, key=lambda one: one[1])


def _head(command: str) -> str:
    paper = ", ".join(str(case.paper_iterations) for case in CASES)
    return f"""# The search beside others

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`, in the project's folder with the build's Python:

    {command}

All search the same objective, the flight's own C code in float32, on records of the truth plant (the reference chirp); a model run is one call of it. Two values: CSJ and BLK between the paper's bounds, by the rod position
alone. Eight: static and dynamic friction, viscous friction, BLK, resistance, torque constant, gain and load, by all four signals, each weighted by its noise ({NOISE[0] * 1e3:g} µm for both positions, {NOISE[2]:g} A,
{NOISE[3]:g} V). Starts fill the box by Sobol's sequence; each has its own seed. Times are of one core of a desktop processor, the search's own work in them.

Two targets: *0.1 %*, every value no farther from the lowest point than a thousandth of its healthy value (the load: of CSJ's); *noise limit*, a cost no more above the lowest than one standard error adds. The lowest point is
known from another search with more information (dense grid, least squares from many starts). A search ends where it has reached both, by its own rule, or after {CAP[2]} model runs ({CAP[8]} for eight values). *Expected runs*
counts a search that ended without arriving as one that begins again elsewhere: all model runs over the number of arrivals.

- *This annealer* is the module's own code with the shipped settings, for eight values cooled four times slower. It takes no gradients and 2.5 kB of memory.
- *This module's least squares* is the flight code's too, a search of its own for up to eight values (`ema/ema_least_squares.h`): bounded, sliced, with further starts of its own where the first ends in a wrong valley. Its
  model runs are all that it makes, those beside the present values and those that are given up among them. It takes 10 kB of memory.
- *Textbook annealer*: Metropolis, geometric cooling over all {CAP[2]} runs from the paper's objective before the search (0.66 mm² s) to a billionth of it, all coordinates moved at once, by less as it cools. The paper prints
  bounds and numbers of runs ({paper}), not its temperatures. From {FEWER_STARTS["textbook annealer"]} of the starts.
- Local searches end in the valley where they begin; DIRECT knows neither start nor seed and searches once.
- dual_annealing takes its local differences over a thousandth of the box: over its own step, 1e-8, a float32 cost does not change.
- **Least squares has more information**: it sees every residual of a run, 10 000 numbers and more, where the others see one. Each of its steps is a run for each value beside the present one, as the
  assessment after the annealer's search makes it once.
- Where the model lacks an effect, the objective is large and its last digits are rounding: 0.1 % of BLK is then less than float32 resolves, and not every search that is down says the same third digit.
"""


def _ranks(rows: Sequence[Row], problems: Sequence[tuple[int, str]]) -> str:
    lines = []
    for values, kind in problems:
        order = ranked(rows, values, kind)
        names = [name for name, _ in order]
        if _OWN not in names:
            continue
        place = names.index(_OWN)
        own = dict(order)[_OWN]
        before = ", ".join(f"{name} ({runs:.0f}{_mark(rows, values, kind, name)})" for name, runs in order[:place])
        after = ", ".join(f"{name} ({'never' if np.isinf(runs) else f'{runs:.0f}'})" for name, runs in order[place + 1 :])
        if np.isinf(own):
            lines.append(f"- {_name(values, kind)}: **this annealer never reaches the noise limit**. Those that do: {before or 'none'}.")
            continue
        lines.append(
            f"- {_name(values, kind)}: this annealer is **{place + 1} of {len(order)}**, {own:.0f} runs expected"
            f"{_mark(rows, values, kind, _OWN)}. Before it: {before or 'none'}. After it: {after or 'none'}."
        )
    return f"""## Ranks

By the expected model runs to the noise limit; in brackets also the share of starts that arrive, where it is not all of them.

{chr(10).join(lines)}
{_meaning(rows, problems)}"""


def _mark(rows: Sequence[Row], values: int, kind: str, name: str) -> str:
    some = _of(rows, values, kind, name)
    share = 100.0 * len(_reached(some, "noise")) / len(some)
    return "" if share == 100.0 else f", {share:.0f} % of the starts"


def _meaning(rows: Sequence[Row], problems: Sequence[tuple[int, str]]) -> str:
    """What the flight code would gain by another search."""
    two = [(values, kind) for values, kind in problems if values == 2]
    own = [row for one in two for row in _of(rows, *one, _OWN)]
    if not own:
        return ""
    most = max((runs for runs, _ in _reached(own, "noise")), default=0)
    share = 100.0 * len(_reached(own, "noise")) / len(own)
    sure = [
        name
        for name in RIVALS
        if name not in (_OWN, _MODULE, _SQUARES, *FEWER_STARTS)
        and all(len(_reached(some, "noise")) == len(some) for one in two if (some := _of(rows, *one, name)))
        and all(expected_runs(_of(rows, *one, name), "noise") < expected_runs(_of(rows, *one, _OWN), "noise") for one in two)
    ]
    better = (
        f"Searches on the same single number that are faster on every problem of two values and arrive from every start as well: {', '.join(sure)}."
        if sure
        else "No search on the same single number is faster on every problem of two values and arrives from every start as well."
    )
    squares = [row for one in two for row in _of(rows, *one, _MODULE)]
    residuals = _onboard_squares(rows, problems, own, squares) if squares else ""
    textbook = [row["above"] for one in two for row in _of(rows, *one, "textbook annealer")]
    plain = (
        f"\nThe textbook annealer ends {np.median(textbook):.1e} mm² s above the lowest cost, median, after all of its runs; the paper's case A ends at 4.2e-4 mm² s after {CASES[0].paper_iterations}.\n"
        if textbook
        else ""
    )
    return f"""
For two values this annealer arrives from {share:.1f} % of the starts, after {most} runs at the most. {better} It searches on to a tolerance far below the noise after it has arrived, which costs it more runs than arriving; the
session's own figures stand below. With eight values its quadratic is separable, blind to what two values do together, and what follows valleys is ahead of it: onboard it searches two to four values, where the quadratic is full.
{residuals}{plain}"""


def _onboard_squares(rows: Sequence[Row], problems: Sequence[tuple[int, str]], own: Sequence[Row], squares: Sequence[Row]) -> str:
    """What the module's least squares brings."""
    gain = expected_runs(own, "noise") / expected_runs(squares, "noise")
    eight = [row for one in problems if one[0] == 8 for row in _of(rows, *one, _MODULE)]
    more = (
        f", and eight within {CAP[8]} from {100.0 * len(_reached(eight, 'noise')) / len(eight):.0f} % of the starts, {expected_runs(eight, 'noise'):.0f} runs expected"
        if eight
        else ""
    )
    return (
        f"\nLeast squares is onboard as a search of its own: it finds two values {gain:.1f} times as fast as the annealer, from {100.0 * len(_reached(squares, 'noise')) / len(squares):.0f} % of the starts{more}. It comes in beside the annealer, not in its\n"
        "place: firmware that searches two to four values and asks for a verdict links the annealer alone, in a quarter of the memory (`ema_annealer_t` beside `ema_least_squares_t`; the session round it takes four fifths), and gives hopeless runs up early; firmware that is to know up to eight values links least squares.\n"
    )


def _median(values: Sequence[float], form: str) -> str:
    return form.format(np.median(values)) if len(values) else ""


def _problem(rows: Sequence[Row], values: int, kind: str) -> str:
    found = []
    data = _of(rows, values, kind, "data")
    level = float(data[0]["level"]) if data else math.nan
    for name, expected in ranked(rows, values, kind):
        some = _of(rows, values, kind, name)
        noise, close = _reached(some, "noise"), _reached(some, "close")
        found.append(
            (
                name,
                str(len(some)),
                f"{100.0 * len(noise) / len(some):.0f}",
                f"{100.0 * len(_reached(some, 'noise', _GOAL)) / len(some):.0f}",
                _median([runs for runs, _ in noise], "{:.0f}"),
                _median([1e3 * seconds for _, seconds in noise], "{:.0f}"),
                "" if np.isinf(expected) else f"{expected:.0f}",
                f"{100.0 * len(close) / len(some):.0f}",
                _median([runs for runs, _ in close], "{:.0f}"),
                _median([1e3 * seconds for _, seconds in close], "{:.0f}"),
                _median([row["above"] / level for row in some if "noise" not in row["when"]], "{:.3g}") if data else "",
            )
        )
    headings = (
        "search",
        "starts",
        "to the noise limit, %",
        f"within {_GOAL} runs, %",
        "runs, median",
        "ms, median",
        "expected runs",
        "to 0.1 %, %",
        "runs, median",
        "ms, median",
        "of the others: cost above the lowest, noise limits",
    )
    return f"## {_name(values, kind)}\n\n{table(headings, found, 10)}"


def _session(rows: Sequence[Row]) -> str:
    found = []
    for kind in KINDS:
        some = _of(rows, 2, kind, "session")
        if not some:
            continue
        there = [row["runs_noise"] for row in some if row["runs_noise"] is not None]
        found.append(
            (
                kind,
                str(len(some)),
                f"{100.0 * len(there) / len(some):.0f}",
                _median(there, "{:.0f}"),
                f"{np.mean([row['runs'] for row in some]):.0f}",
                f"{np.max([row['runs'] for row in some]):.0f}",
                f"{np.mean([row['full_runs'] for row in some]):.0f}",
                f"{np.max(np.abs([row['off_percent'] for row in some])):.2g}",
            )
        )
    if not found:
        return ""
    headings = (
        "record",
        "starts",
        "to the noise limit, %",
        "runs until then, median",
        "runs in all, mean",
        "most",
        "in full runs, mean",
        "farthest off, % of healthy",
    )
    return f"""## The session itself

From the same starts, as it flies: it ends by its own rule, gives up a run once it is worse than the search can use, and assesses the best point.

{table(headings, found, 7)}"""


def _determined(rows: Sequence[Row]) -> str:
    parts = []
    for values in CAP:
        data = next((row for kind in ("noise", "hidden", "exact") for row in _of(rows, values, kind, "data")), None)
        if data is None:
            continue
        place, every = data["determined"]["position"], data["determined"]["all"]
        found = [
            (title, _std(one), _std(other), f"{least:+.2f}", f"{most:+.2f}")
            for title, one, other, least, most in zip(
                data["titles"], place["std_percent"], every["std_percent"], place["least"], every["least"], strict=True
            )
        ]
        headings = ("value", "std error by the rod position, %", "by all signals, %", "least determined: rod", "all")
        sizes = {name: [f"{one:.3g}" for one in some["singular"]] for name, some in (("the rod position", place), ("all signals", every))}
        parts.append(table(headings, found, 4))
        parts.append("; ".join(f"singular values by {name}: {', '.join(some)}" for name, some in sizes.items()) + ".\n")
    if not parts:
        return ""
    return "\n".join(
        [
            "## What the records determine at all\n",
            "From the singular values of the sensitivities over the noise, each value in units of its healthy one (the load: of CSJ's): standard errors in %, and the direction that is determined least. A singular",
            "value of one is a standard error of 100 %. By the rod position alone eight values are not determined, whichever search is asked; by all four signals they are.\n",
            *parts,
        ]
    )


def _std(value: float) -> str:
    return "none" if value >= 100.0 else f"{value:.2g}"


def _baseline(rows: Sequence[Row]) -> str:
    found = [
        (
            _name(row["values"], row["kind"]),
            ", ".join(f"{title} {off:+.1f}" for title, off in row["off_percent"].items()),
            f"{1e3 * row['seconds']:.0f}",
        )
        for row in rows
        if row["rival"] == "baseline"
    ]
    if not found:
        return ""
    return f"""## Without a search: recursive least squares

One pass over the record, sample by sample: torque, circuit and play, each linear in what is sought; no model run. It reads motor position and current beside the rod's position, needs the constants of the motor, and its
errors are those of the differentiating filter and of what the balances leave out, not of a search. Off the truth, in % of the healthy value:

{table(("record", "off, %", "ms"), found, 1)}"""
