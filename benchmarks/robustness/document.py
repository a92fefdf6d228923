"""The document of the annealer's robustness: goals, shares by factor, warnings counted, the shipped settings moved one at a time, and every sensible search that failed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from benchmarks.hidden.documents import table
from benchmarks.robustness.design import EFFECTS, FACTORS, FAULTS, MOVED, RUNS_GOAL
from ema_tools.plant.native import WARNINGS

Row = Mapping[str, Any]
_QUARTERS = 4
_LISTED = 40


def written(rows: Sequence[Row], command: str) -> str:
    """As Markdown; `command` writes it again."""
    parts = [_head(command), _goals(rows), _warnings(rows), _defaults(rows), _factors(rows), _failures(rows)]
    return "\n".join(part for part in parts if part)


def _of(rows: Sequence[Row], design: str) -> list[Row]:
    return [row for row in rows if row["design"] == design]


def _searches(rows: Sequence[Row]) -> Iterator[tuple[Row, Row]]:
    """Every search with its setting."""
    for row in rows:
        for found in row["found"]:
            yield row, found


def _within(found: Row) -> bool:
    """At the lowest point within the goal's model runs."""
    return bool(found["reached"]) and found["runs"] is not None and found["runs"] <= RUNS_GOAL


def _share(pairs: Sequence[tuple[Row, Row]], holds: Callable[[Row, Row], bool]) -> float:
    return 100.0 * sum(holds(row, found) for row, found in pairs) / len(pairs) if pairs else float("nan")


def _percent(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.1f}"


def _runs(pairs: Sequence[tuple[Row, Row]], share: float) -> str:
    runs = [found["runs"] for _, found in pairs if found["reached"] and found["runs"] is not None]
    return f"{np.quantile(runs, share):.0f}" if runs else ""


def _ends(ends: tuple[float, float]) -> str:
    return f"{ends[0]:g}" if ends[0] == ends[1] else f"{ends[0]:g} .. {ends[1]:g}"


def _head(command: str) -> str:
    factors = [(one.title, _ends(one.sensible), one.why, _ends(one.all)) for one in FACTORS.values()]
    factors += [
        ("start", "anywhere inside the bounds", "", "the same"),
        ("seed", "any", "", "the same"),
        ("truth", ", ".join(FAULTS), "the paper's cases", "the same"),
        ("effect that the model lacks", ", ".join(EFFECTS), "Stribeck 0.2, winding +30 %, supply -10 %, gain +10 %", "the same"),
    ]
    return f"""# Does the search reach the lowest point?

Written by a command; do not edit. To write it again, after `cmake --workflow --preset test`, in the project's folder with the build's Python:

    {command}

The onboard session searches CSJ and BLK on records of the truth plant (the reference chirp, the rod position alone), with settings drawn by Sobol's sequence over all of these at once, logarithmically:

{table(("setting", "sensible", "why", "any"), factors, 0)}
What is sensible is said beforehand by what a setting means, not by what came of it. First step (0.2 of the box) and stall window (20 model runs for each value) are the session's own.

The lowest point inside the bounds is found by another search on the same objective: a dense grid, least squares on the float64 residuals from its best cells, a simplex on the flight's float32 cost. A search has reached
it that ends no farther than 0.1 % of the healthy values from it, or whose cost is no more above it than one standard error of the sensor adds (5 µm, or the record's own noise where that is more), and what float32 leaves
open: where the model lacks an effect, the objective is a hundred thousand times that large and its last digits are rounding. Counted are the model runs until the best cost was there.
"""


def _goals(rows: Sequence[Row]) -> str:
    found = []
    for design in ("sensible", "any"):
        pairs = list(_searches(_of(rows, design)))
        if not pairs:
            continue
        inside = [pair for pair in pairs if not pair[0]["at_bound"]]
        walls = [pair for pair in pairs if pair[0]["at_bound"]]
        for title, some in (("all", pairs), ("lowest point inside the bounds", inside), ("lowest point on a bound", walls)):
            failed = [pair for pair in some if not _within(pair[1])]
            found.append(
                (
                    design,
                    title,
                    str(len(some)),
                    _percent(_share(some, lambda _, one: one["reached"])),
                    _percent(_share(some, lambda _, one: _within(one))),
                    _runs(some, 0.5),
                    _runs(some, 0.99),
                    str(len(failed)),
                    str(sum(bool(row["warnings"]) for row, _ in failed)),
                    str(sum(one["said"] for _, one in failed)),
                    str(sum(not row["warnings"] and not one["said"] for row, one in failed)),
                )
            )
    better = sum(one["above"] < -row["rounding"] - 1e-9 for row, one in _searches(rows))
    pairs = list(_searches(_of(rows, "sensible")))
    share = _share(pairs, lambda _, one: _within(one))
    inside_share = _share([pair for pair in pairs if not pair[0]["at_bound"]], lambda _, one: _within(one))
    silent = sum(not _within(one) and not row["warnings"] and not one["said"] for row, one in pairs)
    return f"""## Goals

- Of the sensible settings and starts >= 99 % reach the lowest point within {RUNS_GOAL} model runs: **{
        "met" if share >= 99.0 else "not met"
    }**, {share:.2f} % of {len(pairs)} searches; of those whose lowest point lies inside the
  bounds {inside_share:.2f} %.
- The rest is warned of: **{"met" if silent == 0 else "not met"}**, {
        silent
    } failed without a warning beforehand and without a reason in the answer.

{
        table(
            (
                "design",
                "searches",
                "number",
                "reached, %",
                f"within {RUNS_GOAL} runs, %",
                "runs, median",
                "99 %",
                "failed",
                "warned of before",
                "said after",
                "neither",
            ),
            found,
            9,
        )
    }
*Said after* is what the session's own answer says: an estimate on its bound, evaluations used up while the cost fell, or a residual that the model does not explain; the verdict is then `undecided`. Where an effect is hidden
the last is so for every search, reached or not. A cost below the other search's by more than rounding, which would show that one wrong: {
        better
    }.
"""


def _warnings(rows: Sequence[Row]) -> str:
    parts = []
    counted = []
    for design in ("sensible", "any"):
        # nothing that a setting says tells where the lowest point lies
        pairs = [pair for pair in _searches(_of(rows, design)) if not pair[0]["at_bound"]]
        failed = [pair for pair in pairs if not _within(pair[1])]
        good = [pair for pair in pairs if _within(pair[1])]
        if not pairs:
            continue
        counted.append(
            (
                design,
                str(len(failed)),
                _percent(_share(failed, lambda row, _: bool(row["warnings"]))),
                str(len(good)),
                _percent(_share(good, lambda row, _: bool(row["warnings"]))),
            )
        )
        if design == "any":
            for text in WARNINGS.values():
                some = [pair for pair in pairs if text in pair[0]["warnings"]]
                alone = [pair for pair in some if len(pair[0]["warnings"]) == 1]
                parts.append(
                    (
                        text,
                        str(len(some)),
                        _percent(_share(some, lambda _, one: not _within(one))),
                        str(len(alone)),
                        _percent(_share(alone, lambda _, one: not _within(one))),
                    )
                )
    if not counted:
        return ""
    return f"""## The warnings

`ema_annealer_check` (`ema identify`, `ema export`) looks at the settings alone. Its limits were chosen on 768 other settings drawn from anywhere, and are counted here, where the lowest point lies inside the bounds:

{table(("design", "failed", "of them warned of, %", "reached", "of them warned of wrongly, %"), counted, 4)}
A setting that is warned of works now and then, by the seed or because the objective has one valley. Of the settings drawn from anywhere:

{table(("warning", "searches", "failed, %", "with this warning alone", "failed, %"), parts, 4)}
The first is the session's to refuse: a healthy value outside its bounds is an error of `ema_session_init`, so that none of these settings has it.
"""


def _defaults(rows: Sequence[Row]) -> str:
    found = []
    for name, values in MOVED.items():
        for value in values:
            moved = "shipped" if name == "shipped" else f"{name} = {value:g}"
            pairs = [pair for pair in _searches(_of(rows, "one")) if pair[0]["moved"] == moved and not pair[0]["at_bound"]]
            if not pairs:
                continue
            used = [one["evaluations"] for _, one in pairs]
            found.append(
                (
                    moved,
                    str(len(pairs)),
                    _percent(_share(pairs, lambda _, one: _within(one))),
                    _runs(pairs, 0.5),
                    _runs(pairs, 1.0),
                    f"{np.mean(used):.0f}",
                    f"{np.max(used):.0f}",
                    "yes" if pairs[0][0]["warnings"] else "",
                )
            )
    if not found:
        return ""
    return f"""## The shipped settings, and each moved alone

`actuators/reference.toml`: bounds of the paper, temperature 0.05 mm² s, cooling 0.87, tolerance 1e-13 mm² s, reannealing after 60, 400 evaluations. The records are the sensible design's whose lowest point lies inside
these bounds.

{table(("setting", "searches", f"reached within {RUNS_GOAL} runs, %", "runs until there, median", "most", "runs used, mean", "most", "warned of"), found, 7)}
{_advice(rows)}"""


def _advice(rows: Sequence[Row]) -> str:
    """Whether the shipped settings follow from the table."""
    pairs = [pair for pair in _searches(_of(rows, "one")) if pair[0]["moved"] == "shipped"]
    inside = [pair for pair in pairs if not pair[0]["at_bound"]]
    if not inside:
        return ""
    share = _share(inside, lambda _, one: _within(one))
    most = max(one["evaluations"] for _, one in inside)
    budget = pairs[0][0]["evaluation_budget"]
    follows = share >= 99.0 and most < budget
    faster = [
        name
        for name in (f"cooling = {value:g}" for value in MOVED["cooling"])
        if _sure(rows, name) and _used(rows, name) < _used(rows, "shipped")
    ]
    fast = (
        f"{faster[0]} arrives as surely on these records, after {_used(rows, faster[0]):.0f} model runs instead of {_used(rows, 'shipped'):.0f}"
        if faster
        else "none faster arrives as surely"
    )
    return f"""What the defaults should be: every search arrives, none uses up its evaluations, and the same settings serve two values and the four that are searched where grease and winding are (`day_values`), of
whose model runs each value gets half as many. The shipped ones {"are such" if follows else "are **not** such"}: {share:.1f} % arrive, the longest search took {most} of {budget:g} evaluations. They are not the fastest for two: {fast}.
"""


def _of_moved(rows: Sequence[Row], moved: str) -> list[tuple[Row, Row]]:
    return [pair for pair in _searches(_of(rows, "one")) if pair[0]["moved"] == moved and not pair[0]["at_bound"]]


def _sure(rows: Sequence[Row], moved: str) -> bool:
    pairs = _of_moved(rows, moved)
    return bool(pairs) and all(_within(one) for _, one in pairs)


def _used(rows: Sequence[Row], moved: str) -> float:
    """Model runs of a search, mean."""
    return float(np.mean([one["evaluations"] for _, one in _of_moved(rows, moved)]))


def _factors(rows: Sequence[Row]) -> str:
    parts = [
        "## By factor\n",
        "Share of the searches that reach the lowest point within 600 runs, %, by quarters of each range from its low end; the lowest point inside the bounds.\n",
    ]
    found = []
    for design in ("sensible", "any"):
        pairs = [pair for pair in _searches(_of(rows, design)) if not pair[0]["at_bound"]]
        if not pairs:
            continue
        for name, factor in FACTORS.items():
            ends = factor.sensible if design == "sensible" else factor.all
            if ends[0] == ends[1]:
                continue
            cells = []
            for quarter in range(_QUARTERS):
                low, high = (factor.at(edge / _QUARTERS, ends) for edge in (quarter, quarter + 1))
                some = [pair for pair in pairs if low <= _value(pair[0], name) <= high]
                cells.append(_percent(_share(some, lambda _, one: _within(one))))
            found.append((design, factor.title, *cells))
    parts.append(table(("design", "setting", "first quarter", "second", "third", "fourth"), found, 4))
    found = []
    for design in ("sensible", "any"):
        pairs = [pair for pair in _searches(_of(rows, design)) if not pair[0]["at_bound"]]
        for name, values in (("effect", EFFECTS), ("fault", FAULTS)):
            for value in values:
                some = [pair for pair in pairs if pair[0][name] == value]
                if some:
                    found.append(
                        (
                            design,
                            name,
                            value,
                            str(len(some)),
                            _percent(_share(some, lambda _, one: _within(one))),
                            _runs(some, 0.5),
                            _runs(some, 0.99),
                        )
                    )
    parts.append(table(("design", "record's", "is", "searches", "within 600 runs, %", "runs, median", "99 %"), found, 4))
    return "\n".join(parts)


def _value(row: Row, name: str) -> float:
    return 1.0 - float(row["cooling"]) if name == "hotter" else float(row[name])


def _failures(rows: Sequence[Row]) -> str:
    failed = [(row, one) for row, one in _searches(_of(rows, "sensible")) if not _within(one)]
    if not failed:
        return ""
    found = []
    for row, one in failed[:_LISTED]:
        off = ", ".join(f"{value:+.2f}" for value in one["off_percent"])
        found.append(
            (
                f"{row['effect']}, {row['fault']}",
                "on a bound" if row["at_bound"] else "inside",
                f"{row['cooling']:.3f}",
                f"{row['initial_temperature_mm2s']:.1e}",
                off,
                f"{one['above']:.1e}",
                str(one["evaluations"]),
                one["verdict"],
            )
        )
    more = f"The first {_LISTED} of {len(failed)}.\n" if len(failed) > _LISTED else ""
    headings = ("record", "lowest point", "cooling", "temperature", "CSJ, BLK off, %", "cost above it, mm² s", "runs", "verdict")
    return f"## Sensible searches that failed\n\n{_why(failed)}\n{table(headings, found, 5)}{more}"


def _why(failed: Sequence[tuple[Row, Row]]) -> str:
    walls = sum(row["at_bound"] for row, _ in failed)
    return f"""The lowest point of {walls} of {len(failed)} lies on a bound, where the search moves a draw outside the box to where its quadratic rises least inside. The others ended
before they were down; what they answered stands beside.
"""
